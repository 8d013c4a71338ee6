//! `umbrage render`: a picture of a baked GLB, or of two beside each other.

use std::path::{Path, PathBuf};

use anyhow::{Context, bail};
use clap::Args;
use umbrage::bake;
use umbrage::progress::Progress;
use umbrage_formats::{BakedFile, ReadOptions, write_atomically};
use umbrage_picture::{
    Camera, Line, LineColor, LineSet, Look, Picture, PictureMesh, RenderSettings, SEGMENT_WIDTH_PX, Scale, Tone,
    WIRE_OPACITY, WIRE_WIDTH_PX, beside, color, difference, nice_ceiling, wireframe,
};

use crate::camera::{CameraArgs, SizeArgs};
use crate::look::{LookArgs, Unit};
use crate::output::Output;
use crate::progress::Bar;
use crate::replace::{self, Made};
use crate::scene_file::SceneArgs;
use crate::shown::{Colors, Shown};
use crate::{interrupt, summary};

const HELP: &str = "\
Examples:
  umbrage render baked.glb -o baked.png
  umbrage render baked.glb -o mesh.png --wireframe
  umbrage render baked.glb -o shadows.png --segments room.glb
  umbrage render baked.glb -o corner.png --eye 3,1.6,4 --target 0,1,0 --fov 60
  umbrage render baked.glb -o lux.png --false-color lx --scale-end 500
  umbrage render --side-by-side coarse.glb fine.glb --difference -o compared.png

Without --eye the first camera of the file is used; without one, the camera stands inside where the scene is an interior, \
else outside, above, where most of the light can be seen. --exposure is that of `umbrage bake`, whose summary tells the one it chose; --brighter is relative to that. Surfaces are seen from their front only.

A .png shows what a screen can show. A .exr holds the light itself, linear and not cut off; it needs a program built \
with `--features exr`.";

/// Draw a baked GLB as a picture
#[derive(Debug, Args)]
#[command(after_help = HELP)]
pub(crate) struct RenderArgs {
    /// The baked file (.glb); with --side-by-side two of them
    #[arg(required = true, num_args = 1..=2, value_name = "BAKED")]
    baked: Vec<PathBuf>,
    /// The picture to write (.png or .exr); a picture of that name is replaced
    #[arg(short, long, value_name = "OUT.png")]
    output: PathBuf,
    #[command(flatten)]
    size: SizeArgs,
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
    /// Draw the d-segments (shadow edges) of this scene, which is the one that was baked: contacts and hard edges red,
    /// D1 orange, D2 blue
    #[arg(long, value_name = "SCENE")]
    segments: Option<PathBuf>,
    #[command(flatten)]
    reading: SceneArgs,
}

/// The kinds of files that a picture can become.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Kind {
    Png,
    Exr,
}

pub(crate) fn run(args: &RenderArgs, output: Output) -> anyhow::Result<()> {
    let kind = kind(args)?;
    replace::check(&args.output, Made::Picture, output.force)?;
    let files = args.baked.iter().map(|path| Shown::read(path)).collect::<anyhow::Result<Vec<_>>>()?;
    let first = files.first().context("no file was given")?;
    let k = first.file.exposure_k;
    let cannot = || format!("cannot draw {}", args.baked[0].display());

    let camera = args.camera.choose(first, args.size).with_context(cannot)?;
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
        Some("exr") if args.look.false_color.is_some() || args.difference || args.look.tone() == Tone::Filmic => {
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
        let SizeArgs { width, height } = args.size;
        let settings = RenderSettings { width, height, ..RenderSettings::default() };
        let colors = args.look.colors();
        if let Some(unit) = args.look.false_color.map(|unit| unit.in_file(first)) {
            let end = args.look.scale_end.unwrap_or_else(|| unit.scale_end(first));
            let look = Look::FalseColor { end: (end / unit.per_file_unit()) as f32 };
            return Self { colors, settings: RenderSettings { look, ..settings }, scale: Some(unit.scale(end)) };
        }
        let exposure = args.look.brighter(first) as f32;
        let look = match kind {
            Kind::Png => Look::Display { exposure, tone: args.look.tone() },
            Kind::Exr => Look::Raw { exposure },
        };
        Self { colors, settings: RenderSettings { look, ..settings }, scale: None }
    }
}

/// How the irradiance of two files differs: a picture of it, and the figures.
fn compare(args: &RenderArgs, files: &[Shown], camera: &Camera) -> anyhow::Result<(Picture, String)> {
    // What shows no surface is no number, and stays out of the figures.
    let settings = RenderSettings {
        width: args.size.width,
        height: args.size.height,
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
    let unit = args.look.false_color.unwrap_or(Unit::W).in_file(&files[0].file);
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
        color: LineColor::Plain(color::linear_from_srgb8(color::DEGREES[degree])),
        opacity: 1.0,
        width_px: SEGMENT_WIDTH_PX,
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
