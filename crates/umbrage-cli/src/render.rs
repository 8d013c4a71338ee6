//! `umbrage render`: a picture of a baked GLB.

use std::path::{Path, PathBuf};

use anyhow::{Context, anyhow};
use clap::Args;
use glam::DVec3;
use umbrage::bake;
use umbrage::progress::Progress;
use umbrage_formats::{BakedFilePart, ReadOptions, read_baked, write_atomically};
use umbrage_picture::{Camera, Line, LineColor, LineSet, MAX_SIZE_PX, PictureMesh, RenderSettings, color, wireframe};

use crate::method::{number, positive};
use crate::output::Output;
use crate::progress::Bar;
use crate::scene_file::SceneArgs;
use crate::{interrupt, summary};

const HELP: &str = "\
Examples:
  umbrage render baked.glb -o baked.png
  umbrage render baked.glb -o mesh.png --wireframe
  umbrage render baked.glb -o shadows.png --segments room.glb
  umbrage render baked.glb -o corner.png --eye 3,1.6,4 --target 0,1,0 --fov 60

Without --eye the camera stands outside, where most of the light can be seen. Surfaces are seen from their front only.";

/// Colours of d-segments by degree.
const DEGREE_COLORS: [[u8; 3]; 3] = [[226, 30, 30], [255, 140, 0], [40, 110, 255]];
const DEGREE_WIDTH_PX: f64 = 1.6;
const WIRE_WIDTH_PX: f64 = 0.8;
const WIRE_OPACITY: f32 = 0.45;

/// Draw a baked GLB as a PNG picture
#[derive(Debug, Args)]
#[command(after_help = HELP)]
pub(crate) struct RenderArgs {
    /// The baked file (.glb)
    baked: PathBuf,
    /// The picture to write (.png); replaced if it exists
    #[arg(short, long, value_name = "OUT.png")]
    output: PathBuf,
    /// Where the camera stands, in metres: x,y,z
    #[arg(long, value_name = "X,Y,Z", value_parser = point, allow_hyphen_values = true, requires = "target")]
    eye: Option<DVec3>,
    /// The point that it looks at, in metres: x,y,z
    #[arg(long, value_name = "X,Y,Z", value_parser = point, allow_hyphen_values = true, requires = "eye")]
    target: Option<DVec3>,
    /// What is up in the picture: x,y,z [default: 0,1,0]
    #[arg(long, value_name = "X,Y,Z", value_parser = point, allow_hyphen_values = true, requires = "eye")]
    up: Option<DVec3>,
    /// Field of view from the lower to the upper edge, in degrees
    #[arg(long, value_name = "DEG", value_parser = angle, default_value_t = Camera::DEFAULT_FOV_DEG)]
    fov: f64,
    /// Width in pixels
    #[arg(long, value_name = "PX", value_parser = size, default_value_t = 1024)]
    width: usize,
    /// Height in pixels
    #[arg(long, value_name = "PX", value_parser = size, default_value_t = 1024)]
    height: usize,
    /// Make the picture this many times brighter
    #[arg(long, value_name = "K", value_parser = positive, default_value_t = 1.0)]
    exposure: f64,
    /// Draw the light alone, as if all surfaces were white
    #[arg(long)]
    light_only: bool,
    /// Draw the edges of the triangles
    #[arg(long)]
    wireframe: bool,
    /// Draw the d-segments (shadow edges) of this scene, which is the one that was baked: contacts and hard edges red, D1
    /// orange, D2 blue
    #[arg(long, value_name = "SCENE")]
    segments: Option<PathBuf>,
    #[command(flatten)]
    reading: SceneArgs,
}

pub(crate) fn run(args: &RenderArgs, output: Output) -> anyhow::Result<()> {
    let meshes = read_meshes(&args.baked, if args.light_only { Colors::Light } else { Colors::Seen })?;
    let settings = RenderSettings {
        width: args.width,
        height: args.height,
        exposure: args.exposure as f32,
        ..RenderSettings::default()
    };
    let camera = match (args.eye, args.target) {
        (Some(eye), Some(target)) => {
            let camera = Camera::looking(eye, target, args.fov);
            Camera { up: args.up.unwrap_or(camera.up), ..camera }
        }
        _ => default_camera(&meshes, &settings, args.fov)
            .with_context(|| format!("cannot draw {}", args.baked.display()))?,
    };
    let mut lines = Vec::new();
    if args.wireframe {
        let edges = wireframe(&meshes, camera.eye_m);
        lines.push(LineSet {
            color: LineColor::Contrast,
            opacity: WIRE_OPACITY,
            width_px: WIRE_WIDTH_PX,
            lines: edges,
        });
    }
    if let Some(scene) = &args.segments {
        lines.extend(segments(scene, &args.reading, output)?);
    }
    let picture = umbrage_picture::render(&meshes, &lines, &camera, &settings)
        .with_context(|| format!("cannot draw {}", args.baked.display()))?
        .png()?;
    write_atomically(&args.output, &picture)?;
    output.say(&format!("Wrote {} ({})", args.output.display(), summary::bytes(picture.len() as u64)))
}

/// What the colours of a picture are.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Colors {
    /// Base colour times light, as any viewer shows it.
    Seen,
    /// The light alone.
    Light,
}

/// The parts of a baked file as they are drawn.
pub(crate) fn read_meshes(path: &Path, colors: Colors) -> anyhow::Result<Vec<PictureMesh>> {
    let file = read_baked(path)?;
    Ok(file.parts.iter().map(|part| picture_mesh(part, file.origin_m, colors)).collect())
}

fn picture_mesh(part: &BakedFilePart, origin_m: DVec3, colors: Colors) -> PictureMesh {
    let base = if colors == Colors::Seen { part.base_color } else { [1.0; 4] };
    PictureMesh {
        positions_m: part.positions_m.iter().map(|p| (origin_m + DVec3::from(p.map(f64::from))).to_array()).collect(),
        colors: part.color.iter().map(|light| std::array::from_fn(|i| base[i] * light[i])).collect(),
        triangles: part.triangles.clone(),
    }
}

/// The camera where none is asked for.
pub(crate) fn default_camera(
    meshes: &[PictureMesh],
    settings: &RenderSettings,
    fov_deg: f64,
) -> anyhow::Result<Camera> {
    umbrage_picture::default_camera(meshes, settings.width, settings.height, fov_deg)?
        .ok_or_else(|| anyhow!("there are no triangles: bake a scene that has surfaces"))
}

/// The d-segments of a scene by degree, the strongest last, so that they are drawn over the others.
fn segments(path: &Path, reading: &SceneArgs, output: Output) -> anyhow::Result<Vec<LineSet>> {
    interrupt::listen()?;
    let scene = reading.read(path, ReadOptions::default().max_reflectance)?;
    let bar = Bar::new(output);
    let callback = |update| bar.update(update);
    let segments = bake::d_segments(&scene, Progress::new(&callback));
    bar.clear();
    let segments = segments.with_context(|| format!("cannot find the shadow edges of {}", path.display()))?;
    let of_degree = |degree: usize| LineSet {
        color: LineColor::Plain(color::linear_from_srgb8(DEGREE_COLORS[degree])),
        opacity: 1.0,
        width_px: DEGREE_WIDTH_PX,
        lines: segments
            .iter()
            .filter(|segment| usize::from(segment.degree) == degree)
            .map(|segment| Line {
                ends_m: segment.ends_m.map(|p| p.to_array()),
                normal: Some(segment.normal.to_array()),
            })
            .collect(),
    };
    Ok([2, 1, 0].map(of_degree).into())
}

/// Three numbers with commas between.
fn point(text: &str) -> Result<DVec3, String> {
    let numbers = text.split(',').map(number).collect::<Result<Vec<_>, _>>();
    match numbers.as_deref() {
        Ok(&[x, y, z]) => Ok(DVec3::new(x, y, z)),
        _ => Err("must be three numbers with commas between, as in 1,0.5,-2".into()),
    }
}

fn angle(text: &str) -> Result<f64, String> {
    number(text).and_then(
        |x| {
            if (0.1..=179.0).contains(&x) { Ok(x) } else { Err("must be between 0.1 and 179".into()) }
        },
    )
}

fn size(text: &str) -> Result<usize, String> {
    match text.parse() {
        Ok(n) if (1..=MAX_SIZE_PX).contains(&n) => Ok(n),
        _ => Err(format!("must be a whole number between 1 and {MAX_SIZE_PX}")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_point_is_three_numbers() {
        assert_eq!(point("1, 0.5,-2"), Ok(DVec3::new(1.0, 0.5, -2.0)));
        assert!(point("1,2").is_err() && point("1,2,x").is_err() && point("1,2,inf").is_err());
    }

    #[test]
    fn sizes_and_angles_are_bounded() {
        assert!(size("0").is_err() && size("99999").is_err() && size("640") == Ok(640));
        assert!(angle("0").is_err() && angle("180").is_err() && angle("40") == Ok(40.0));
    }
}
