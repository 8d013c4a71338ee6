//! `umbrage page`: a baked GLB as a web page in one file.

use std::path::PathBuf;

use anyhow::Context;
use clap::Args;
use umbrage_formats::write_atomically;
use umbrage_page::PageOptions;
use umbrage_picture::Camera;

use crate::output::Output;
use crate::replace::{self, Made};
use crate::shown::{Colors, Shown, default_camera};
use crate::summary;

const HELP: &str = "\
Examples:
  umbrage page baked.glb -o room.html
  umbrage page baked.glb -o room.html --title \"The room at noon\"

The page opens from a disk in any current browser, without network: drag to turn, wheel or pinch to come nearer, W A S D \
to walk. It starts with the first camera of the file; without one, inside where the scene is an interior, else outside. The address of the page keeps \
the view: #eye=x,y,z&target=x,y,z&fov=40&exposure=2&tone=filmic&show=irradiance&wire=1";

/// Pixels of a window, to choose the first view by.
const FIRST_VIEW_PX: [usize; 2] = [800, 600];

/// Write a baked GLB as a web page in one file, to walk around in
#[derive(Debug, Args)]
#[command(after_help = HELP)]
pub(crate) struct PageArgs {
    /// The baked file (.glb)
    baked: PathBuf,
    /// The page to write (.html); a page of that name is replaced, another file with --force alone
    #[arg(short, long, value_name = "OUT.html")]
    output: PathBuf,
    /// Its title [default: the scene's name, or the file's]
    #[arg(long, value_name = "TEXT")]
    title: Option<String>,
}

pub(crate) fn run(args: &PageArgs, output: Output) -> anyhow::Result<()> {
    replace::check(&args.output, Made::Page, output.force)?;
    // Textures are decoded so that a page is not written with one that a browser would refuse.
    let shown = Shown::read(&args.baked)?;
    let meshes = shown.meshes(Colors::Seen, shown.file.exposure_k);
    let [width, height] = FIRST_VIEW_PX;
    let camera = default_camera(&meshes, width, height, Camera::DEFAULT_FOV_DEG)
        .with_context(|| format!("cannot show {}", args.baked.display()))?;
    let file_stem = || args.baked.file_stem().map(|stem| stem.to_string_lossy().into_owned()).unwrap_or_default();
    let scene_name = || Some(shown.file.name.clone()).filter(|name| !name.is_empty());
    let title = args.title.clone().or_else(scene_name).unwrap_or_else(file_stem);
    let page = umbrage_page::page(&shown.file, &PageOptions { title, camera });
    write_atomically(&args.output, page.as_bytes())?;
    output.say(&format!("Wrote {} ({})", args.output.display(), summary::bytes(page.len() as u64)))
}
