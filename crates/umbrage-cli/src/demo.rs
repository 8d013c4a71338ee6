//! `umbrage demo`: the built-in Cornell box, baked and drawn.

use std::path::PathBuf;
use std::sync::Arc;
use std::time::Instant;

use anyhow::Context;
use clap::Args;
use umbrage::bake::BakeSettings;
use umbrage::scene::cornell::cornell_box;
use umbrage_formats::write_atomically;
use umbrage_picture::{Camera, RenderSettings};

use crate::bake::{bake_scene, warn_of, write};
use crate::light::Fluxes;
use crate::output::Output;
use crate::replace::{self, Made};
use crate::shown::{Colors, Shown, default_camera};
use crate::{interrupt, summary};

/// Bake the built-in Cornell box: leaves cornell.glb and cornell.png, and needs no file
#[derive(Debug, Args)]
pub(crate) struct DemoArgs {
    /// The folder to write into; made if it does not exist
    #[arg(long, value_name = "FOLDER", default_value = ".")]
    out_dir: PathBuf,
}

pub(crate) fn run(args: &DemoArgs, output: Output) -> anyhow::Result<()> {
    interrupt::listen()?;
    let begin = Instant::now();
    std::fs::create_dir_all(&args.out_dir)
        .with_context(|| format!("cannot make the folder {}: choose another --out-dir", args.out_dir.display()))?;
    let [glb, png] = ["cornell.glb", "cornell.png"].map(|name| args.out_dir.join(name));

    replace::check(&glb, Made::Glb, output.force)?;
    replace::check(&png, Made::Picture, output.force)?;
    let scene = Arc::new(cornell_box());
    let step = bake_scene(&scene, &BakeSettings::default(), output).context("cannot bake the Cornell box")?;
    let written = write(&scene, &step, None, &glb)?;
    let shown = Shown::read(&glb)?;
    let meshes = shown.meshes(Colors::Seen, shown.file.exposure_k);
    let settings = RenderSettings::default();
    let camera = default_camera(&meshes, settings.width, settings.height, Camera::DEFAULT_FOV_DEG)?;
    let picture = umbrage_picture::render(&meshes, &[], &camera, &settings)?.png()?;
    write_atomically(&png, &picture)?;

    let umbrage = std::env::args().next().unwrap_or_else(|| "umbrage".into());
    let warnings = warn_of(&step.bake.report, &glb).len();
    let fluxes = Fluxes::new(&scene);
    let summary = summary::summary(&step.bake.report, &fluxes, &written, begin.elapsed(), None, warnings);
    let glb_name = glb.display();
    output.say(&format!(
        "{summary}\
         Wrote {glb_name} ({}), for any glTF viewer\n\
         Wrote {} ({})\n\
         \n\
         Next:\n  \
           {umbrage} render {glb_name} -o mesh.png --wireframe   see the triangles follow the shadows\n  \
           {umbrage} page {glb_name} -o cornell.html      walk around in it, in a browser\n  \
           {umbrage} bake SCENE.glb -o baked.glb   bake a scene of your own",
        summary::bytes(written.bytes),
        png.display(),
        summary::bytes(picture.len() as u64),
    ))
}
