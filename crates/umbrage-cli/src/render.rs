//! `umbrage render`: a picture of a baked GLB, or of two beside each other.

use std::path::{Path, PathBuf};

use anyhow::{Context, bail};
use clap::{Args, ValueEnum};
use glam::DVec3;
use umbrage::bake;
use umbrage::progress::Progress;
use umbrage_formats::{BakedFile, ReadOptions, write_atomically};
use umbrage_picture::{
    Camera, Line, LineColor, LineSet, Look, MAX_SIZE_PX, Picture, PictureMesh, RenderSettings, Scale, Tone, beside,
    color, difference, nice_ceiling, wireframe,
};

use crate::method::{number, positive};
use crate::output::Output;
use crate::progress::Bar;
use crate::scene_file::SceneArgs;
use crate::shown::{Colors, Shown, default_camera};
use crate::{interrupt, summary};

const HELP: &str = "\
Examples:
  umbrage render baked.glb -o baked.png
  umbrage render baked.glb -o mesh.png --wireframe
  umbrage render baked.glb -o shadows.png --segments room.glb
  umbrage render baked.glb -o corner.png --eye 3,1.6,4 --target 0,1,0 --fov 60
  umbrage render baked.glb -o lux.png --false-color lx --scale-end 500
  umbrage render --side-by-side coarse.glb fine.glb --difference -o compared.png

Without --eye the first camera of the file is used; without one, the camera stands outside, where most of the light can \
be seen. Surfaces are seen from their front only.

A .png shows what a screen can show. A .exr holds the light itself, linear and not cut off; it needs a program built \
with `--features exr`.";

/// Colours of d-segments by degree.
const DEGREE_COLORS: [[u8; 3]; 3] = [[226, 30, 30], [255, 140, 0], [40, 110, 255]];
const DEGREE_WIDTH_PX: f64 = 1.6;
const WIRE_WIDTH_PX: f64 = 0.8;
const WIRE_OPACITY: f32 = 0.45;

/// Draw a baked GLB as a picture
#[derive(Debug, Args)]
#[command(after_help = HELP)]
pub(crate) struct RenderArgs {
    /// The baked file (.glb); with --side-by-side two of them
    #[arg(required = true, num_args = 1..=2, value_name = "BAKED")]
    baked: Vec<PathBuf>,
    /// The picture to write (.png or .exr); replaced if it exists
    #[arg(short, long, value_name = "OUT.png")]
    output: PathBuf,
    /// Width in pixels, of each picture where there are several
    #[arg(long, value_name = "PX", value_parser = size, default_value_t = 1024)]
    width: usize,
    /// Height in pixels
    #[arg(long, value_name = "PX", value_parser = size, default_value_t = 1024)]
    height: usize,
    #[command(flatten)]
    camera: CameraArgs,
    #[command(flatten)]
    look: LookArgs,
    /// Show two files beside each other, with the camera and the exposure of the first
    #[arg(long)]
    side_by_side: bool,
    /// Show besides how much more irradiance the second has (red) or less (blue), and tell the figures
    #[arg(long, requires = "side_by_side")]
    difference: bool,
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

/// Where the picture is taken from.
#[derive(Debug, Args)]
#[command(next_help_heading = "Camera")]
struct CameraArgs {
    /// Where the camera stands, in metres: x,y,z
    #[arg(long, value_name = "X,Y,Z", value_parser = point, allow_hyphen_values = true, requires = "target")]
    eye: Option<DVec3>,
    /// The point that it looks at, in metres: x,y,z
    #[arg(long, value_name = "X,Y,Z", value_parser = point, allow_hyphen_values = true, requires = "eye")]
    target: Option<DVec3>,
    /// What is up in the picture: x,y,z [default: 0,1,0]
    #[arg(long, value_name = "X,Y,Z", value_parser = point, allow_hyphen_values = true, requires = "eye")]
    up: Option<DVec3>,
    /// Field of view from the lower to the upper edge, in degrees [default: the camera's, or 40]
    #[arg(long, value_name = "DEG", value_parser = angle)]
    fov: Option<f64>,
    /// The camera of the file that has this name [default: its first one]
    #[arg(long, value_name = "NAME", conflicts_with = "eye")]
    camera: Option<String>,
}

/// What becomes of the light.
#[derive(Debug, Args)]
#[command(next_help_heading = "Light")]
struct LookArgs {
    /// Make the picture this many times brighter
    #[arg(long, value_name = "K", value_parser = positive, default_value_t = 1.0)]
    exposure: f64,
    /// What becomes of light that is too bright for a screen
    #[arg(long, value_name = "TONE", default_value = "off")]
    tone: ToneArg,
    /// Draw the light alone, as if all surfaces were white
    #[arg(long)]
    light_only: bool,
    /// Draw the irradiance in false colours, with a legend, in this unit [default without UNIT: w]
    #[arg(long, value_name = "UNIT", num_args = 0..=1, default_missing_value = "w",
        conflicts_with_all = ["light_only", "exposure", "tone"])]
    false_color: Option<Unit>,
    /// Where the scale of --false-color ends, in its unit [default: a round number above nearly all of the scene]
    #[arg(long, value_name = "E", value_parser = positive, requires = "false_color")]
    scale_end: Option<f64>,
}

#[derive(Clone, Copy, Debug, ValueEnum)]
enum ToneArg {
    /// It is cut off, as in every glTF viewer
    Off,
    /// It goes through the curve of a film: softer in the bright, more contrast in the dark
    Filmic,
}

/// Units of irradiance.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum Unit {
    /// W/m2, as in the file
    W,
    /// lx, at 683 lm per W: for scenes whose light is in watts
    Lx,
    /// lx, as in the file: for scenes whose light is photometric already, as in MGF
    Photometric,
}

impl Unit {
    fn name(self) -> &'static str {
        if self == Self::W { "W/m2" } else { "lx" }
    }

    /// How many of it are 1 in the file.
    fn per_file_unit(self) -> f64 {
        if self == Self::Lx { color::LUMENS_PER_WATT } else { 1.0 }
    }
}

/// The kinds of files that a picture can become.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Kind {
    Png,
    Exr,
}

pub(crate) fn run(args: &RenderArgs, output: Output) -> anyhow::Result<()> {
    let kind = kind(args)?;
    let files = args.baked.iter().map(|path| Shown::read(path)).collect::<anyhow::Result<Vec<_>>>()?;
    let first = files.first().context("no file was given")?;
    let k = first.file.exposure_k;
    let cannot = || format!("cannot draw {}", args.baked[0].display());

    let camera = camera(args, first).with_context(cannot)?;
    let segments = args.segments.as_deref().map(|scene| segments(scene, &args.reading, output)).transpose()?;
    let look = Drawing::new(args, kind, &first.file);
    let mut pictures = Vec::new();
    for file in &files {
        let meshes = file.meshes(look.colors, k);
        let mut lines = Vec::new();
        if args.wireframe {
            lines.push(wires(&meshes, &camera));
        }
        lines.extend(segments.iter().flatten().cloned());
        let mut picture = umbrage_picture::render(&meshes, &lines, &camera, &look.settings).with_context(cannot)?;
        if let Some(scale) = &look.scale {
            scale.draw(&mut picture);
        }
        pictures.push(picture);
    }
    let mut told = String::new();
    if args.difference {
        let (picture, figures) = compare(args, &files, &camera).with_context(cannot)?;
        pictures.push(picture);
        told = figures;
    }
    let bytes = encode(&beside(&pictures), kind)?;
    write_atomically(&args.output, &bytes)?;
    output.say(&format!("{told}Wrote {} ({})", args.output.display(), summary::bytes(bytes.len() as u64)))
}

/// The kind of file that is asked for, if it can be made of what else is asked for.
fn kind(args: &RenderArgs) -> anyhow::Result<Kind> {
    match (args.baked.len(), args.side_by_side) {
        (1, true) => bail!("--side-by-side needs two baked files"),
        (2.., false) => bail!("there are two baked files: say --side-by-side to see both"),
        _ => {}
    }
    let ending = args.output.extension().map(|ending| ending.to_string_lossy().to_ascii_lowercase());
    match ending.as_deref() {
        Some("png") => Ok(Kind::Png),
        Some("exr") if !cfg!(feature = "exr") => bail!(
            "{}: this program was built without OpenEXR: install it with `cargo install --path crates/umbrage-cli \
             --features exr`, or write a .png",
            args.output.display()
        ),
        Some("exr")
            if args.look.false_color.is_some() || args.difference || matches!(args.look.tone, ToneArg::Filmic) =>
        {
            bail!("an EXR holds the light itself: leave out --false-color, --difference and --tone, or write a .png")
        }
        Some("exr") => Ok(Kind::Exr),
        _ => bail!("{}: the picture's name must end in .png or .exr", args.output.display()),
    }
}

/// What is drawn of a file, and how.
struct Drawing {
    colors: Colors,
    settings: RenderSettings,
    scale: Option<Scale>,
}

impl Drawing {
    fn new(args: &RenderArgs, kind: Kind, first: &BakedFile) -> Self {
        let settings = RenderSettings { width: args.width, height: args.height, ..RenderSettings::default() };
        if let Some(unit) = args.look.false_color {
            let per_file_unit = unit.per_file_unit();
            let within = || first.irradiance_quantile(color::SHARE_WITHIN_SCALE, color::LUMINANCE_WEIGHTS);
            let end = args.look.scale_end.unwrap_or_else(|| nice_ceiling(per_file_unit * within()));
            let look = Look::FalseColor { end: (end / per_file_unit) as f32 };
            let scale = Scale { begin: 0.0, end, unit: unit.name(), stops: &color::SEQUENTIAL };
            let settings = RenderSettings { look, ..settings };
            return Self { colors: Colors::Irradiance, settings, scale: Some(scale) };
        }
        let colors = if args.look.light_only { Colors::Light } else { Colors::Seen };
        let tone = match args.look.tone {
            ToneArg::Off => Tone::Off,
            ToneArg::Filmic => Tone::Filmic,
        };
        let look = match kind {
            Kind::Png => Look::Display { exposure: args.look.exposure as f32, tone },
            Kind::Exr => Look::Raw { exposure: args.look.exposure as f32 },
        };
        Self { colors, settings: RenderSettings { look, ..settings }, scale: None }
    }
}

/// The camera that was asked for, of the file, or outside of it.
fn camera(args: &RenderArgs, file: &Shown) -> anyhow::Result<Camera> {
    let asked = &args.camera;
    let camera = match (asked.eye, asked.target) {
        (Some(eye), Some(target)) => {
            let camera = Camera::looking(eye, target, Camera::DEFAULT_FOV_DEG);
            Some(Camera { up: asked.up.unwrap_or(camera.up), ..camera })
        }
        _ => file.camera(asked.camera.as_deref())?,
    };
    match camera {
        Some(camera) => Ok(Camera { fov_y_deg: asked.fov.unwrap_or(camera.fov_y_deg), ..camera }),
        None => {
            let meshes = file.meshes(Colors::Seen, file.file.exposure_k);
            default_camera(&meshes, args.width, args.height, asked.fov.unwrap_or(Camera::DEFAULT_FOV_DEG))
        }
    }
}

/// How the irradiance of two files differs: a picture of it, and the figures.
fn compare(args: &RenderArgs, files: &[Shown], camera: &Camera) -> anyhow::Result<(Picture, String)> {
    // What shows no surface is no number, and stays out of the figures.
    let settings = RenderSettings {
        width: args.width,
        height: args.height,
        look: Look::Raw { exposure: 1.0 },
        background: [f32::NAN; 3],
    };
    let mut irradiance = Vec::new();
    for file in files {
        let meshes = file.meshes(Colors::Irradiance, file.file.exposure_k);
        irradiance.push(umbrage_picture::render(&meshes, &[], camera, &settings)?);
    }
    let [first, second] = irradiance.as_slice() else { bail!("two files are compared, not {}", files.len()) };
    let difference = difference(first, second).context("the pictures differ in size")?;
    let unit = args.look.false_color.unwrap_or(Unit::W);
    let end = nice_ceiling(unit.per_file_unit() * difference.largest());
    let mut picture = difference.picture(end / unit.per_file_unit());
    Scale { begin: -end, end, unit: unit.name(), stops: &color::DIVERGING }.draw(&mut picture);
    let (rms, mean) = (difference.rms(), difference.mean_of_first());
    let share = if mean > 0.0 { format!(", {:.2} % of the first's mean", 100.0 * rms / mean) } else { String::new() };
    let figures = format!(
        "Irradiance, second less first, over the pixels: root mean square {:.4} {}{share}\n",
        unit.per_file_unit() * rms,
        unit.name(),
    );
    Ok((picture, figures))
}

fn encode(picture: &Picture, kind: Kind) -> anyhow::Result<Vec<u8>> {
    match kind {
        #[cfg(feature = "exr")]
        Kind::Exr => Ok(picture.exr()?),
        _ => Ok(picture.png()?),
    }
}

/// The edges of the triangles.
fn wires(meshes: &[PictureMesh], camera: &Camera) -> LineSet {
    LineSet {
        color: LineColor::Contrast,
        opacity: WIRE_OPACITY,
        width_px: WIRE_WIDTH_PX,
        lines: wireframe(meshes, camera.eye_m),
    }
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
