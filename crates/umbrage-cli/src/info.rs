//! `umbrage info`: what is in a scene, before it is baked.

use std::fmt::Write;
use std::path::PathBuf;

use clap::{Args, ValueEnum};
use glam::DVec3;
use umbrage::id::{MaterialId, SurfaceId};
use umbrage::prepare::{self, Prepared};
use umbrage::progress::Progress;
use umbrage::scene::{Scene, SceneError};

use umbrage_formats::shortened;

use crate::light;
use crate::output::{Output, answer, warning};
use crate::progress::Bar;
use crate::scene_file::{SceneArgs, Unit};
use crate::summary::{self, count, grouped, rgb, rounded};

/// Tell what is in a scene: polygons, area, materials, what gives light and how much, gaps and defects
#[derive(Debug, Args)]
pub(crate) struct InfoArgs {
    /// The scene: glTF 2.0 (.glb or .gltf), OBJ, MGF, PLY or STL
    scene: PathBuf,
    #[command(flatten)]
    reading: SceneArgs,
}

pub(crate) fn run(args: &InfoArgs, output: Output) -> anyhow::Result<()> {
    let scene = args.reading.read(&args.scene, 1.0)?;
    let valid = scene.validate();
    if let Err(error) = &valid {
        warning(&format!("{}: cannot be baked: {error}", args.scene.display()));
    }
    let mut text = describe(&scene, args.reading.unit());
    // A scene without light has faces, all the same.
    if matches!(valid, Ok(()) | Err(SceneError::Lightless { .. })) {
        let bar = Bar::new(output);
        let callback = |update| bar.update(update);
        let prepared = prepare::prepare(&scene, Progress::new(&callback));
        bar.clear();
        match prepared {
            Ok(prepared) => {
                if let Some(guessed) = summary::guessed(&prepared.report) {
                    warning(&format!("{}: {guessed}", args.scene.display()));
                }
                text += &describe_faces(&prepared);
            }
            Err(error) => warning(&format!("{}: cannot be baked: {error}", args.scene.display())),
        }
    }
    answer(&text)
}

/// The least and the greatest corner of all polygons, in metres.
fn bounds_m(scene: &Scene) -> Option<[DVec3; 2]> {
    let ids = (0..scene.surfaces.len()).map(SurfaceId::from);
    let polygons = ids.flat_map(|id| (0..scene.surfaces[id].polygons.len()).map(move |n| (id, n)));
    let used = polygons.flat_map(|(id, n)| {
        let surface = &scene.surfaces[id];
        surface.polygons[n].iter().filter_map(|&i| surface.positions_m.get(i as usize).copied())
    });
    used.fold(None, |bounds: Option<[DVec3; 2]>, p| {
        let [low, high] = bounds.unwrap_or([p, p]);
        Some([low.min(p), high.max(p)])
    })
}

/// A unit that the file may be in, if that of its coordinates is unlikely: rooms and buildings are not a hundred metres
/// high and more, nor some millimetres.
fn likely_unit(unit: Unit, [low, high]: [DVec3; 2]) -> Option<(Unit, f64)> {
    let (height, width) = ((high - low).y / unit.metres(), (high - low).max_element() / unit.metres());
    let likely = match (height, width) {
        _ if unit != Unit::M => return None,
        (1000.0.., _) | (_, 20_000.0..) => Unit::Mm,
        (100.0.., _) | (_, 2000.0..) => Unit::Cm,
        _ => return None,
    };
    Some((likely, height))
}

/// Materials that are listed: the others are counted.
const LISTED_MATERIALS: usize = 1000;

/// One line of a description.
fn line(text: &mut String, name: &str, value: &str) {
    // Writing to a string cannot fail.
    let _ = writeln!(text, "{name:<10}  {value}");
}

/// What there is to say of a scene once its faces are known.
fn describe_faces(prepared: &Prepared) -> String {
    let mut text = String::new();
    line(&mut text, "faces", &grouped(prepared.faces.len()));
    let shells = prepare::shells(prepared);
    let open = match shells.open_edges {
        0 => String::new(),
        n => format!(", with {}", count(n, "open edge")),
    };
    line(&mut text, "shells", &format!("{} closed, {} open{open}", grouped(shells.closed), grouped(shells.open)));
    let defects = summary::mended(&prepared.report);
    line(&mut text, "defects", &if defects.is_empty() { "none".into() } else { defects.join(", ") });
    text
}

fn describe(scene: &Scene, unit: Unit) -> String {
    let mut text = String::new();
    let mut line = |name: &str, value: String| line(&mut text, name, &value);
    let materials: Vec<(MaterialId, f64)> =
        light::areas_m2(scene).iter_enumerated().map(|(id, &area_m2)| (id, area_m2)).collect();
    let units = light::Units::of(scene.photometric);
    line("scene", scene.name.clone());
    line("nodes", grouped(scene.nodes.len()));
    line("surfaces", grouped(scene.surfaces.len()));
    line("polygons", grouped(scene.polygon_count()));
    line("area", format!("{} m2", rounded(materials.iter().map(|(_, area)| area).sum())));
    if let Some(bounds) = bounds_m(scene) {
        let [low, high] = bounds;
        let [low, high, size] = [low, high, high - low].map(|p| p.to_array().map(rounded));
        line("bounds", format!("{} to {} m", low.join(","), high.join(",")));
        line("size", format!("{} m", size.join(" x ")));
        if let Some((likely, height)) = likely_unit(unit, bounds) {
            let name = likely.to_possible_value().map_or(String::new(), |value| value.get_name().to_owned());
            line("unit", format!("{} m high? It is perhaps in {name}: give --unit {name}", rounded(height)));
        }
    }
    line("materials", grouped(materials.len()));
    for &(id, area) in materials.iter().take(LISTED_MATERIALS) {
        let material = &scene.materials[id];
        let sides = if material.double_sided { ", double-sided" } else { "" };
        let light = if material.emits() {
            format!(", gives light: radiance {} {}", rgb(material.radiance), units.radiance)
        } else {
            String::new()
        };
        line(
            "",
            format!(
                "{:?}: {} m2, reflects {}{sides}{light}",
                shortened(&material.name),
                rounded(area),
                rgb(material.reflectance)
            ),
        );
    }
    if let Some(more) = materials.len().checked_sub(LISTED_MATERIALS).filter(|more| *more > 0) {
        line("", format!("and {} more", grouped(more)));
    }
    let lights: Vec<(MaterialId, f64)> =
        materials.into_iter().filter(|&(id, area)| scene.materials[id].emits() && area > 0.0).collect();
    line(
        "emitters",
        if lights.is_empty() { "none".into() } else { format!("flux of each in {} (red, green, blue)", units.flux) },
    );
    for (id, area) in lights {
        line("", format!("{:?}: {}", shortened(&scene.materials[id].name), rgb(light::flux_w(scene, id, area))));
    }
    if !scene.lamps.is_empty() {
        line("lamps", format!("flux of each in {} (red, green, blue)", units.flux));
        scene.lamps.iter().for_each(|lamp| line("", light::describe_lamp(lamp, units)));
    }
    let fluxes = light::Fluxes::new(scene);
    if fluxes.is_any() {
        line("", format!("total: {}", fluxes.describe()));
    }
    text
}

#[cfg(test)]
mod tests {
    use umbrage::scene::cornell::cornell_box;

    use super::*;

    #[test]
    fn the_cornell_box_is_described() {
        let text = describe(&cornell_box(), Unit::M);
        // 0.13 x 0.105 m of light; pi x 18.387 x 0.01365 = 0.7885 W of red.
        for expected in ["polygons    20", "total: 0.7885 0.5998 0.2896 W", "0.01365 m2", "0.556 x 0.5488 x 0.5592 m"] {
            assert!(text.contains(expected), "{expected} is not in\n{text}");
        }
    }

    #[test]
    fn a_room_in_millimetres_is_recognised() {
        let mut scene = cornell_box();
        scene.surfaces.iter_mut().flat_map(|s| &mut s.positions_m).for_each(|p| *p *= 5000.0);
        assert!(describe(&scene, Unit::M).contains("2744 m high? It is perhaps in mm: give --unit mm"));
        assert!(!describe(&scene, Unit::Ft).contains("perhaps"));
        assert!(!describe(&cornell_box(), Unit::M).contains("perhaps"));
    }

    #[test]
    fn faces_shells_and_defects_are_described() {
        let prepared = prepare::prepare(&cornell_box(), Progress::silent()).unwrap();
        let text = describe_faces(&prepared);
        assert!(text.contains("shells      0 closed, 1 open, with 4 open edges") && text.contains("defects"), "{text}");
    }

    #[test]
    fn a_broken_scene_is_described_too() {
        let mut scene = cornell_box();
        scene.surfaces[SurfaceId::from(0)].polygons[0][0] = 4_000_000;
        assert!(describe(&scene, Unit::M).contains("polygons    20"));
        assert!(describe(&Scene::default(), Unit::M).contains("emitters    none"));
    }
}
