//! `umbrage inspect`: what the stages of a bake made, as JSON or as drawings.

use std::path::PathBuf;

use anyhow::{Context, bail};
use clap::{Args, ValueEnum};
use umbrage::bake;
use umbrage::progress::Progress;
use umbrage::scene::Scene;
use umbrage_formats::{ReadOptions, write_atomically};
use umbrage_inspect::{d_segments, mesh, patches};

use crate::bake::refuse_baked;
use crate::method::MethodArgs;
use crate::output::{Output, answer};
use crate::progress::Bar;
use crate::replace::{self, Made};
use crate::scene_file::SceneArgs;
use crate::{interrupt, summary};

const HELP: &str = "\
Examples:
  umbrage inspect room.glb --stage d-segments -o shadows.svg    where shadows begin and end, and how hard
  umbrage inspect room.glb --stage d-segments -o shadows.json   the same, with what makes each line
  umbrage inspect room.glb --stage patches -o patches.svg       how surfaces were cut, and by what
  umbrage inspect room.glb --stage mesh > mesh.json             triangles, and the light at their corners

The JSON has a record per line, for diff; docs/inspect.md tells what is in it.";

/// Tell or draw what a stage of a bake made: edges of shadows, patches, triangles
#[derive(Debug, Args)]
#[command(after_help = HELP)]
pub(crate) struct InspectArgs {
    /// The scene: glTF 2.0 (.glb or .gltf), OBJ, MGF, PLY or STL
    scene: PathBuf,
    /// What to show
    #[arg(long, value_enum)]
    stage: InspectedStage,
    /// The file to write, JSON or a drawing by its name (.json, .svg); replaced if it exists [default: JSON to standard
    /// output]
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,
    #[command(flatten)]
    reading: SceneArgs,
    #[command(flatten)]
    method: MethodArgs,
}

/// A stage whose result can be shown.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum InspectedStage {
    /// Segments across which light, its slope or its curvature jumps, and what makes them
    DSegments,
    /// The hierarchy of patches, and what made each cut
    Patches,
    /// The triangles of the baked mesh, and the light at their corners
    Mesh,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Form {
    Json,
    Svg,
}

pub(crate) fn run(args: &InspectArgs, output: Output) -> anyhow::Result<()> {
    let form = form_of(args)?;
    if let Some(path) = &args.output {
        replace::check(path, Made::Inspection, output.force)?;
    }
    interrupt::listen()?;
    let scene = args.reading.read(&args.scene, ReadOptions::default().max_reflectance)?;
    refuse_baked(&args.scene, &scene)?;
    let text =
        inspect(&scene, args, form, output).with_context(|| format!("cannot inspect {}", args.scene.display()))?;
    match &args.output {
        None => answer(&text),
        Some(path) => {
            write_atomically(path, text.as_bytes())?;
            output.say(&format!("Wrote {} ({})", path.display(), summary::bytes(text.len() as u64)))
        }
    }
}

fn form_of(args: &InspectArgs) -> anyhow::Result<Form> {
    let Some(path) = &args.output else { return Ok(Form::Json) };
    match path.extension().map(|extension| extension.to_ascii_lowercase()) {
        Some(extension) if extension == "json" => Ok(Form::Json),
        Some(extension) if extension == "svg" => Ok(Form::Svg),
        _ => bail!("{}: cannot tell what to write: give a name that ends in .json or .svg", path.display()),
    }
}

fn inspect(scene: &Scene, args: &InspectArgs, form: Form, output: Output) -> anyhow::Result<String> {
    let bar = Bar::new(output);
    let callback = |update| bar.update(update);
    let progress = Progress::new(&callback);
    let settings = args.method.settings(scene.polygon_count())?;
    let text = match args.stage {
        InspectedStage::DSegments => bake::trace(scene, settings.prepare, 0.0, progress).map(|traced| match form {
            Form::Json => d_segments::json(scene, &traced),
            Form::Svg => d_segments::svg(scene, &traced),
        }),
        InspectedStage::Patches => bake::subdivided(scene, &settings, progress).map(|meshed| match form {
            Form::Json => patches::json(scene, &meshed),
            Form::Svg => patches::svg(scene, &meshed),
        }),
        InspectedStage::Mesh => bake::bake(scene, &settings, progress).map(|bake| match form {
            Form::Json => mesh::json(scene, &bake.mesh),
            Form::Svg => mesh::svg(scene, &bake.mesh),
        }),
    };
    bar.clear();
    Ok(text?)
}
