//! `umbrage bake`: a scene in, a baked GLB out.

use std::path::{Path, PathBuf};
use std::time::Instant;

use anyhow::Context;
use clap::Args;
use umbrage::bake::{self, Bake, BakeSettings};
use umbrage::progress::Progress;
use umbrage::scene::Scene;
use umbrage_formats::{Written, choose_nodes, write_baked_glb};

use crate::light::Fluxes;
use crate::method::{MethodArgs, facts, positive, share};
use crate::output::Output;
use crate::progress::Bar;
use crate::scene_file::SceneArgs;
use crate::{interrupt, summary};

const HELP: &str = "\
Examples:
  umbrage bake room.glb -o baked.glb
  umbrage bake room.glb -o fine.glb --tolerance 0.003
  umbrage bake room.glb -o small.glb --max-triangles 5000
  umbrage bake room.glb -o brighter.glb --exposure 2.5
  umbrage bake room.glb -o room-only.glb --skip car
  umbrage bake house.obj -o house.glb --unit mm --emit lamp=12,11,9

A scene needs at least one material that gives light (glTF: emissiveFactor, in Blender: Emission; OBJ: Ke; MGF: ed). Where \
the file has none, --emit gives it, or a TOML beside the scene (for room.glb: room.umbrage.toml):

  [materials.lamp]
  emission = [12, 11, 9]      # radiance in W/(m2 sr); one number is for red, green and blue
  reflectance = 0.5           # share of light, 0 to 1
  double_sided = true

  [[lamps]]                   # a sun: where its light goes to, and W/m2 on what faces it
  direction = [-1, -3, -2]
  irradiance = [3, 2.9, 2.7]

  [[lamps]]                   # a bulb: where it is, in metres with Y up, and W/sr; with a direction it is a spot
  position = [0, 2.2, 0]
  intensity = 8

Units are metres and W/m2; a surface is lit on its front, unless its material is double-sided.";

/// Bake a scene: write a GLB whose triangles follow the shadows and whose vertices carry the light
#[derive(Debug, Args)]
#[command(after_help = HELP)]
pub(crate) struct BakeArgs {
    /// The scene: glTF 2.0 (.glb or .gltf), OBJ, MGF, PLY or STL
    scene: PathBuf,
    /// The baked file to write (.glb); replaced if it exists
    #[arg(short, long, value_name = "OUT.glb")]
    output: PathBuf,
    /// Colours are K times E/pi, the light of a white surface in W/(m2 sr), cut off at white: a greater K is brighter
    /// [default: so that little of the scene is cut off]
    #[arg(long, value_name = "K", value_parser = positive)]
    exposure: Option<f64>,
    /// Take no surface to reflect more than this share of the light: a white closed room has no solution
    #[arg(long, value_name = "R", value_parser = share, default_value_t = 0.9)]
    max_reflectance: f64,
    /// Bake only this node, by its name or its mesh's, with all below it; may be repeated. All others block, reflect and give light,
    /// but are not in the baked file: their nodes are there, empty
    #[arg(long, value_name = "NODE")]
    only: Vec<String>,
    /// Do not bake this node, nor what is below it; may be repeated
    #[arg(long, value_name = "NODE")]
    skip: Vec<String>,
    #[command(flatten)]
    reading: SceneArgs,
    #[command(flatten)]
    method: MethodArgs,
}

pub(crate) fn run(args: &BakeArgs, output: Output) -> anyhow::Result<()> {
    interrupt::listen()?;
    check_folder(&args.output)?;
    let begin = Instant::now();
    let mut scene = args.reading.read(&args.scene, args.max_reflectance)?;
    choose_nodes(&mut scene, &args.only, &args.skip)?;
    let settings = args.method.settings();
    let bake =
        bake_scene(&scene, &settings, output).with_context(|| format!("cannot bake {}", args.scene.display()))?;
    let written = write(&scene, &bake, &settings, args.exposure, &args.output)?;
    let summary = summary::summary(&bake.report, &Fluxes::new(&scene), &written, begin.elapsed());
    output.say(&format!("{summary}Wrote {} ({})", args.output.display(), summary::bytes(written.bytes)))
}

/// Fails where a file has no folder to be in: better now than after a long bake.
fn check_folder(output: &Path) -> anyhow::Result<()> {
    let folder = output.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
    anyhow::ensure!(
        folder.is_dir(),
        "{}: cannot be written: there is no folder {}",
        output.display(),
        folder.display()
    );
    Ok(())
}

/// Bakes with progress on the terminal; Ctrl-C cancels.
pub(crate) fn bake_scene(scene: &Scene, settings: &BakeSettings, output: Output) -> anyhow::Result<Bake> {
    interrupt::check()?;
    let bar = Bar::new(output);
    let callback = |update| bar.update(update);
    let bake = bake::bake(scene, settings, Progress::new(&callback));
    bar.clear();
    Ok(bake?)
}

/// Writes a bake as GLB, and with it how it was made.
pub(crate) fn write(
    scene: &Scene,
    bake: &Bake,
    settings: &BakeSettings,
    exposure: Option<f64>,
    path: &Path,
) -> anyhow::Result<Written> {
    interrupt::check()?;
    let facts = facts(settings, &bake.report, exposure);
    Ok(write_baked_glb(scene, &bake.mesh, &facts, path)?)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_folder_that_is_not_there_is_told_before_the_bake() {
        assert!(check_folder(Path::new("out.glb")).is_ok());
        let message = check_folder(Path::new("no/such/folder/out.glb")).unwrap_err().to_string();
        assert!(message.contains("no/such/folder/out.glb") && message.contains("there is no folder"), "{message}");
    }
}
