//! A scene as an OBJ, its materials beside it, and what OBJ cannot say (lamps, both sides) in the TOML that `umbrage bake` takes up.

use std::fmt::Write;
use std::fs;
use std::path::Path;

use glam::DVec3;
use umbrage::scene::{Lamp, LampKind, Scene};

/// Writes `PATH.obj`, `.mtl` and `.umbrage.toml`; returns the first one's name.
pub(crate) fn write(scene: &Scene, path: &Path) -> anyhow::Result<String> {
    if let Some(folder) = path.parent() {
        fs::create_dir_all(folder)?;
    }
    let mtl = path.with_extension("mtl");
    let name = mtl.file_name().map(|name| name.to_string_lossy().into_owned()).unwrap_or_default();
    fs::write(path, obj(scene, &name)?)?;
    fs::write(mtl, materials(scene)?)?;
    fs::write(path.with_extension("umbrage.toml"), toml(scene)?)?;
    Ok(path.display().to_string())
}

fn obj(scene: &Scene, mtl: &str) -> anyhow::Result<String> {
    let mut text = format!("mtllib {mtl}\n");
    let (mut corners, mut normals) = (1, 1);
    for surface in &scene.surfaces {
        for p in &surface.positions_m {
            writeln!(text, "v {} {} {}", p.x, p.y, p.z)?;
        }
        for n in &surface.normals {
            writeln!(text, "vn {} {} {}", n.x, n.y, n.z)?;
        }
        writeln!(text, "usemtl {}", material_name(scene, surface.material.into()))?;
        for polygon in &surface.polygons {
            text += "f";
            for &i in polygon {
                let i = i as usize;
                write!(text, " {}", corners + i)?;
                if !surface.normals.is_empty() {
                    write!(text, "//{}", normals + i)?;
                }
            }
            text += "\n";
        }
        corners += surface.positions_m.len();
        normals += surface.normals.len();
    }
    Ok(text)
}

/// The name of a material, without blanks.
fn material_name(scene: &Scene, number: usize) -> String {
    scene.materials.raw[number].name.replace(' ', "-")
}

fn materials(scene: &Scene) -> anyhow::Result<String> {
    let mut text = String::new();
    for (number, material) in scene.materials.iter().enumerate() {
        let (kd, ke) = (material.reflectance, material.radiance);
        writeln!(text, "newmtl {}\nKd {} {} {}", material_name(scene, number), kd.x, kd.y, kd.z)?;
        writeln!(text, "Ke {} {} {}\n", ke.x, ke.y, ke.z)?;
    }
    Ok(text)
}

fn toml(scene: &Scene) -> anyhow::Result<String> {
    let mut text = String::new();
    for (number, _) in scene.materials.iter().enumerate().filter(|(_, material)| material.double_sided) {
        writeln!(text, "[materials.\"{}\"]\ndouble_sided = true\n", material_name(scene, number))?;
    }
    for lamp in &scene.lamps {
        text += &lamp_text(lamp)?;
    }
    Ok(text)
}

fn lamp_text(lamp: &Lamp) -> anyhow::Result<String> {
    let vector = |v: DVec3| format!("[{:?}, {:?}, {:?}]", v.x, v.y, v.z);
    let mut text = format!("[[lamps]]\nname = \"{}\"\n", lamp.name);
    match lamp.kind {
        LampKind::Point { position_m, intensity, range_m } | LampKind::Spot { position_m, intensity, range_m, .. } => {
            writeln!(text, "position = {}\nintensity = {}", vector(position_m), vector(intensity))?;
            if let Some(range_m) = range_m {
                writeln!(text, "# its light ends at {range_m} m, which this file cannot say")?;
            }
        }
        LampKind::Directional { direction, irradiance } => {
            writeln!(text, "direction = {}\nirradiance = {}", vector(direction), vector(irradiance))?;
        }
    }
    if let LampKind::Spot { direction, inner_rad, outer_rad, .. } = lamp.kind {
        let [inner, outer] = [inner_rad, outer_rad].map(f64::to_degrees);
        writeln!(text, "direction = {}\ninner_degrees = {inner:?}\nouter_degrees = {outer:?}", vector(direction))?;
    }
    text += "\n";
    Ok(text)
}

#[cfg(test)]
mod tests {
    use umbrage_formats::{Overrides, ReadOptions, read_scene_with};
    use umbrage_verify::random::{RandomScene, Size};

    use super::*;

    #[test]
    fn a_scene_comes_back_from_its_files() {
        let folder = std::env::temp_dir().join(format!("umbrage-random-{}", std::process::id()));
        for seed in 0..20 {
            let scene = RandomScene::new(seed, Size { things: 6, lamps: 4 }).scene(|_| true);
            let path = folder.join(format!("{seed}.obj"));
            write(&scene, &path).unwrap();
            let (mut read, _) = read_scene_with(&path, &ReadOptions::default()).unwrap();
            Overrides::read(Overrides::path_beside(&path)).unwrap().apply(&mut read, 0.9).unwrap();
            assert_eq!(read.polygon_count(), scene.polygon_count(), "seed {seed}");
            assert_eq!(read.lamps.len(), scene.lamps.len());
            let double = |scene: &Scene| {
                let of = |s: &umbrage::scene::Surface| scene.materials[s.material].double_sided;
                scene.surfaces.iter().filter(|s| of(s)).map(|s| s.polygons.len()).sum::<usize>()
            };
            assert_eq!(double(&read), double(&scene), "seed {seed}");
            let smooth = |scene: &Scene| scene.surfaces.iter().any(|s| !s.normals.is_empty());
            assert!(smooth(&read) || !smooth(&scene), "seed {seed}");
        }
        fs::remove_dir_all(folder).unwrap();
    }
}
