//! The command `umbrage-view`, which `umbrage view` calls.

use std::path::PathBuf;
use std::process::ExitCode;

use anyhow::ensure;
use clap::Parser;
use umbrage_cli::camera::{CameraArgs, SizeArgs};
use umbrage_cli::look::LookArgs;
use umbrage_cli::method::MethodArgs;
use umbrage_cli::output;
use umbrage_cli::scene_file::SceneArgs;
use umbrage_formats::write_atomically;
use umbrage_view::{Gpu, Job, LineArgs, ViewOptions, open, screenshot};

const HELP: &str = "\
Examples:
  umbrage-view baked.glb                      a baked file
  umbrage-view room.glb --tolerance 0.02      a scene: it is baked first, and again whenever it changes
  umbrage-view room.glb --segments --patches 3
  umbrage-view baked.glb --screenshot view.png --width 800 --height 600 --eye 3,1.6,4 --target 0,1,0

In the window: drag to turn, wheel to come nearer, W A S D to walk; the panel tells more. WGPU_BACKEND=vulkan or gl \
chooses the graphics driver.";

/// Show a baked GLB, or a scene while it is baked, in a window
#[derive(Debug, Parser)]
#[command(name = "umbrage-view", version, after_help = HELP)]
struct ViewArgs {
    /// A baked file (.glb), or a scene: glTF 2.0 (.glb or .gltf), OBJ, MGF, PLY or STL
    file: PathBuf,
    /// Write a picture of the view (.png) instead of opening a window
    #[arg(long, value_name = "OUT.png")]
    screenshot: Option<PathBuf>,
    #[command(flatten)]
    size: SizeArgs,
    #[command(flatten)]
    camera: CameraArgs,
    #[command(flatten)]
    look: LookArgs,
    #[command(flatten)]
    lines: LineArgs,
    #[command(flatten)]
    reading: SceneArgs,
    #[command(flatten)]
    method: MethodArgs,
}

fn main() -> ExitCode {
    match run(ViewArgs::parse()) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            output::error_chain(&error);
            ExitCode::FAILURE
        }
    }
}

fn run(args: ViewArgs) -> anyhow::Result<()> {
    let ViewArgs { file, screenshot: to, size, camera, look, lines, reading, method } = args;
    let job = Job { path: file, reading, settings: method.settings(0)?, tolerance_by_size: !method.has_tolerance() };
    let options = ViewOptions { job, size, camera, look, lines };
    let Some(to) = to else { return open(options) };
    let is_png = to.extension().is_some_and(|ending| ending.eq_ignore_ascii_case("png"));
    ensure!(is_png, "{}: the picture's name must end in .png", to.display());
    let picture = screenshot(&options, Gpu::headless()?)?;
    Ok(write_atomically(&to, &picture.png()?)?)
}
