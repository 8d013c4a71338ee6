//! `umbrage bake`: a scene in, a baked GLB out.

use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::{Duration, Instant};

use anyhow::Context;
use bytesize::ByteSize;
use clap::Args;
use umbrage::bake::{self, BakeSettings, Report};
use umbrage::progress::Progress;
use umbrage::scene::Scene;
use umbrage_formats::{Written, choose_nodes, write_baked_glb};

use crate::interrupt::{Interrupted, Kept};
use crate::light::Fluxes;
use crate::limits::{Limits, memory_limit, time_limit, watch_reading};
use crate::method::{MethodArgs, facts, positive, share};
use crate::output::Output;
use crate::replace::{self, Made};
use crate::report::{Asked, Reported, ReportedWarning};
use crate::reuse::Reuse;
use crate::scene_file::SceneArgs;
use crate::steps::{Step, Wishes, bake_in_steps, bake_in_steps_by};
use crate::{interrupt, report, summary};

const HELP: &str = "\
Examples:
  umbrage bake room.glb -o baked.glb
  umbrage bake room.glb -o fine.glb --tolerance 0.003
  umbrage bake room.glb -o small.glb --max-triangles 5000
  umbrage bake room.glb -o best.glb --time-limit 60
  umbrage bake room.glb -o best.glb --memory-limit 2GiB
  umbrage bake room.glb -o early.glb --progressive
  umbrage bake room.glb -o baked.glb --reuse room.umbrage
  umbrage bake room.glb -o brighter.glb --exposure 2.5
  umbrage bake room.glb -o baked.glb --report baked.json
  umbrage bake room.glb -o room-only.glb --skip car
  umbrage bake house.obj -o house.glb --unit mm --emit lamp=12,11,9

A scene needs at least one material that gives light (glTF: emissiveFactor, in Blender: Emission; OBJ: Ke; MGF: ed). \
Where the file has none, --emit gives it, or a TOML beside the scene (for room.glb: room.umbrage.toml):

  double_sided = false        # all materials but those below that say otherwise

  [materials.lamp]
  emission = [12, 11, 9]      # radiance in W/(m2 sr); one number is for red, green and blue
  reflectance = 0.5           # share of light, 0 to 1
  double_sided = true

  [[lamps]]                   # a sun: where its light goes to, and W/m2 on what faces it
  direction = [-1, -3, -2]
  irradiance = [3, 2.9, 2.7]

  [[lamps]]                   # a bulb: where it is, in metres with Y up, and W/sr
  name = \"over the table\"     # optional, for messages
  position = [0, 2.2, 0]
  intensity = 8

  [[lamps]]                   # a spot: a bulb with a direction
  position = [0, 2.2, 0]
  direction = [0, -1, 0]
  intensity = [8, 7, 6]
  inner_degrees = 20          # from the axis; inside of it the intensity is full [default: 0]
  outer_degrees = 30          # outside of it it is dark, 90 at most [default: 45]

  [nodes.sky]                 # all that hangs below a node, or shows a mesh, of this name
  casts_shadow = false        # light passes through it, it lights nothing; materials have this key too
  emission = 2                # as of a material, for what hangs below this node alone

lamp_unit = \"file\" above the tables says that positions of [[lamps]] are in the unit that --unit names, and not in metres.

--max-triangles N is never passed: with few triangles refinement goes where the error is greatest, and along the strongest \
edges of shadows first. Of hard shadows the weakest and shortest edges stay uncut where there is no room for them, which a \
warning says. Where the shapes alone need more triangles, the bake is refused, and the error says how many they need.

Refinement ends by itself: no split makes an edge shorter than 0.00001 of the scene or 0.0001 of its face, and what is \
narrower than that is not split.

--time-limit, --memory-limit and --progressive bake in steps, the first of them at 16 times the tolerance, with limits at 0.16 at least, each finer \
than the one before; faces and the edges of shadows are found once. What steps took says how fine the next can be. Every \
step is a whole bake, the same that its tolerance alone gives, and the file names that tolerance. With limits a sketch comes \
before them, without edges of shadows, whose refinement is cut short once a quarter of the time is used up. Of every other step \
refinement ends once three quarters are used up; that is kept where it errs less than the step before. Where a limit is \
reached before the tolerance asked for, the best step is written; a warning says at \
which tolerance it is and how much it errs, and the exit code is 0. Only where a limit is reached in the sketch, nothing is \
written. Ctrl-C ends a bake at once: with --progressive the best result by then \
stays, without it nothing is written.

--memory-limit is of the most that the process holds, reading the scene included: of `peak memory` in the summary. A \
step is given up when all but an eighth and 8 MiB of SIZE is held; these are for what a step takes until it has ended.

--reuse FILE is for trying lamps and colours: the first bake writes FILE, every later one takes it up, whatever \
changed of emission, reflectance and lamps since. FILE stays as it is until surfaces or options change; it may be \
deleted at any time. It keeps what one tolerance finds, and so does not go with a bake in steps.

--report FILE.json has all that the summary says, and each warning, for programs: docs/report.md explains its keys.

Units are metres and W/m2; a surface is lit on its front, unless its material is double-sided.";

/// Bake a scene: write a GLB whose triangles follow the shadows and whose vertices carry the light
#[derive(Debug, Args)]
#[command(after_help = HELP)]
pub(crate) struct BakeArgs {
    /// The scene: glTF 2.0 (.glb or .gltf), OBJ, MGF, PLY or STL
    scene: PathBuf,
    /// The baked file to write (.glb); a baked file of that name is replaced, another one with --force alone
    #[arg(short, long, value_name = "OUT.glb")]
    output: PathBuf,
    /// Colours are K times E/pi, the light of a white surface in W/(m2 sr), cut off at white: a greater K is brighter
    /// [default: so that little of the scene is cut off]
    #[arg(long, value_name = "K", value_parser = positive, allow_negative_numbers = true)]
    exposure: Option<f64>,
    /// Take no surface to reflect more than this share of the light: a white closed room has no solution
    #[arg(long, value_name = "R", value_parser = share, default_value_t = 0.9)]
    max_reflectance: f64,
    /// Bake only this node, by its name or its mesh's, with all below it; may be repeated. All others block, reflect
    /// and give light, but are not in the baked file: their nodes are there, empty
    #[arg(long, value_name = "NODE")]
    only: Vec<String>,
    /// Do not bake this node, nor what is below it; may be repeated
    #[arg(long, value_name = "NODE")]
    skip: Vec<String>,
    /// Write the best result that there is time for: end within S seconds, reading and writing included
    #[arg(long, value_name = "S", value_parser = time_limit)]
    time_limit: Option<Duration>,
    /// Write the best result that there is memory for: give up what takes more than SIZE, such as 500MB or 2GiB
    #[arg(long, value_name = "SIZE", value_parser = memory_limit)]
    memory_limit: Option<ByteSize>,
    /// Write a coarse result early, and replace it by better ones until the tolerance is reached; takes about a third
    /// longer
    #[arg(long)]
    progressive: bool,
    /// Take up what FILE has of a bake of the same surfaces: after lamps or colours changed it takes a fraction of the
    /// time. Where there is no such file, or surfaces or options are others, bake as if there were none, and write it
    #[arg(long, value_name = "FILE", conflicts_with_all = ["time_limit", "memory_limit", "progressive"])]
    reuse: Option<PathBuf>,
    /// Fail, with exit code 3, where a warning says that a figure of the result cannot be true or that the light of a lamp is lost; the file is
    /// written all the same
    #[arg(long)]
    strict: bool,
    /// Write what the summary says as JSON, with settings, times and warnings; replaced if it is a report
    #[arg(long, value_name = "FILE.json")]
    report: Option<PathBuf>,
    #[command(flatten)]
    reading: SceneArgs,
    #[command(flatten)]
    method: MethodArgs,
}

pub(crate) fn run(args: &BakeArgs, output: Output) -> anyhow::Result<()> {
    interrupt::listen()?;
    check_folder(&args.output)?;
    check_is_not_the_scene(&args.scene, &args.output)?;
    check_is_glb(&args.output)?;
    replace::check(&args.output, Made::Glb, output.force)?;
    if let Some(reuse) = &args.reuse {
        check_folder(reuse)?;
        anyhow::ensure!(
            *reuse != args.output,
            "{}: cannot be both the baked file and what --reuse takes up",
            reuse.display()
        );
    }
    if let Some(report) = &args.report {
        let materials = args.reading.materials_path(&args.scene);
        let others = [&args.scene, &args.output, &materials].into_iter().chain(&args.reuse);
        report::check(report, &others.map(PathBuf::as_path).collect::<Vec<_>>())?;
        replace::check(report, Made::Report, output.force)?;
    }
    let begin = Instant::now();
    let watch = args.memory_limit.map(|limit| watch_reading(limit.as_u64())).transpose()?;
    let (mut scene, read) = args.reading.read_and_warn(&args.scene, args.max_reflectance)?;
    let mut warnings: Vec<ReportedWarning> = read.iter().map(ReportedWarning::of_scene).collect();
    choose_nodes(&mut scene, &args.only, &args.skip)?;
    refuse_baked(&args.scene, &scene)?;
    let scene = Arc::new(scene);
    drop(watch);
    let limits = Arc::new(Limits::new(begin, args.time_limit, args.memory_limit)?);
    let wishes = Wishes { early: args.progressive, limits: Arc::clone(&limits) };
    let write = |step: &Step| write(&scene, step, args.exposure, &args.output);
    let asked = args.method.settings(scene.polygon_count())?;
    let mut best = None;
    let reuse = args.reuse.clone().map(Reuse::new);
    let bake = {
        let reuse = reuse.clone();
        move |scene: &Scene, settings: &BakeSettings, progress: Progress<'_>| match &reuse {
            Some(reuse) => reuse.bake(scene, settings, progress),
            None => bake::bake(scene, settings, progress),
        }
    };
    let ended = bake_in_steps_by(bake, &scene, &asked, &wishes, output, |step| {
        let written = args.progressive.then(|| write(&step)).transpose()?;
        if args.progressive && !step.is_asked {
            let seconds = summary::seconds(begin.elapsed().as_secs_f64());
            output.say(&format!("Wrote {} after {seconds}: {}", args.output.display(), quality(&step)))?;
        }
        best = Some((step, written));
        Ok(())
    });
    let (limit, step, written) = match (ended, best) {
        (Ok(limit), Some((step, written))) => (limit, step, written),
        (Err(error), Some((step, Some(_)))) if error.is::<Interrupted>() => {
            return Err(Kept(format!("{} has {}", args.output.display(), quality(&step))).into());
        }
        (Err(error), _) => return Err(error).with_context(|| format!("cannot bake {}", args.scene.display())),
        (Ok(_), None) => anyhow::bail!("{}: nothing was baked", args.scene.display()),
    };
    let written = written.map_or_else(|| write(&step), Ok)?;
    let why_coarser = limit.map(|limit| limits.why_coarser(limit, asked.shade.tolerance));
    if let (Some(why), Some(limit)) = (&why_coarser, limit) {
        let text = format!("{why}: it has {}. {} gets nearer to it", quality(&step), limit.way_out());
        warnings.push(ReportedWarning::of_limits(text).told(&args.output));
    }
    if let Some(guessed) = summary::guessed(&step.bake.report.prepare) {
        warnings.push(ReportedWarning::of_scene(&guessed).told(&args.scene));
    }
    let fluxes = Fluxes::new(&scene);
    let before_result = warnings.len();
    warnings.extend(warn_of(&step.bake.report, &args.output));
    let defects = summary::lamp_defects(&step.bake.report, fluxes.units());
    for defect in defects.iter().take(NAMED_LAMPS) {
        warnings.push(ReportedWarning::of_lamp(defect).told(&args.scene));
    }
    if let Some(more) = defects.len().checked_sub(NAMED_LAMPS).filter(|more| *more > 0) {
        let text = format!("{} likewise: --report names them", summary::count(more, "more lamp"));
        ReportedWarning::of_lamp(&text).told(&args.scene);
        warnings.extend(defects.iter().skip(NAMED_LAMPS).map(|defect| ReportedWarning::of_lamp(defect)));
    }
    let as_large = || {
        let is_coarser = asked.shade.tolerance > BakeSettings::default().shade.tolerance;
        (is_coarser && !args.method.has_tolerance())
            .then(|| "for so many polygons; --tolerance asks for less".to_owned())
    };
    let doubtful = warnings.len() - before_result;
    let coarser = why_coarser.or_else(as_large).map(|why| format!("{}: {why}", step.settings.shade.tolerance));
    if step.bake.report.uncut > 0 {
        let edges = summary::count(step.bake.report.uncut, "edge of hard shadows was|edges of hard shadows were");
        let text = format!(
            "{edges} not cut, or in part: --max-triangles leaves no room. They are the weakest and shortest; light leaks there"
        );
        warnings.push(ReportedWarning::of_limits(text).told(&args.output));
    }
    let elapsed = begin.elapsed();
    let summary = summary::summary(&step.bake.report, &fluxes, &written, elapsed, coarser, warnings.len());
    output.say(&format!("{summary}Wrote {} ({})", args.output.display(), summary::bytes(written.bytes)))?;
    if let Some(path) = &args.report {
        let asked =
            Asked { tolerance: asked.shade.tolerance, exposure: args.exposure, max_reflectance: args.max_reflectance };
        let reported = Reported {
            input: &args.scene,
            output: &args.output,
            scene: &scene,
            report: &step.bake.report,
            settings: &step.settings,
            asked: &asked,
            written: &written,
            elapsed,
            warnings: &warnings,
        };
        let bytes = report::write(path, &reported)?;
        output.say(&format!("Wrote {} ({})", path.display(), summary::bytes(bytes)))?;
    }
    reuse.map_or(Ok(()), |reuse| reuse.finish(output))?;
    if args.strict && doubtful > 0 { Err(NotTrue(doubtful).into()) } else { Ok(()) }
}

/// Lamps whose defects are told; the report has all of them.
const NAMED_LAMPS: usize = 8;

/// Figures of a result cannot be true, and `--strict` says that this is a failure.
#[derive(Clone, Copy, Debug, thiserror::Error)]
#[error("--strict: {0} of the warnings above are about the result, which was written all the same")]
pub(crate) struct NotTrue(usize);

/// Prints the warnings about a result that is in `file`.
pub(crate) fn warn_of(report: &Report, file: &Path) -> Vec<ReportedWarning> {
    report.warnings.iter().map(|warning| ReportedWarning::of_bake(warning).told(file)).collect()
}

/// How good a step is.
fn quality(step: &Step) -> String {
    let short = match (step.is_sketch, step.is_cut_short) {
        (true, true) => " in a sketch without edges of shadows, cut short",
        (true, false) => " in a sketch without edges of shadows",
        (false, true) => ", cut short",
        (false, false) => "",
    };
    format!(
        "the light at tolerance {}{short}, between vertices in error by {} (estimate), with {}",
        step.settings.shade.tolerance,
        summary::share_of_mean(&step.bake.report),
        summary::count(step.bake.report.triangles, "triangle")
    )
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

/// Fails where a scene is a baked file: its materials give no light, and it holds the light of before as if it were paint.
pub(crate) fn refuse_baked(path: &Path, scene: &Scene) -> anyhow::Result<()> {
    let extras =
        scene.asset_extras.as_deref().and_then(|extras| serde_json::from_str::<serde_json::Value>(extras).ok());
    let is_baked = extras.is_some_and(|extras| extras["umbrage"]["exposure"].is_number());
    anyhow::ensure!(
        !is_baked,
        "{}: is a baked file and no scene: bake the scene that it was made of; `umbrage render`, `page` and `view` show it",
        path.display()
    );
    Ok(())
}

/// Fails where a file is called what it is not: no program opens a GLB under the name of a picture.
fn check_is_glb(output: &Path) -> anyhow::Result<()> {
    let is_glb = output.extension().is_none_or(|extension| extension.eq_ignore_ascii_case("glb"));
    anyhow::ensure!(
        is_glb,
        "{}: a baked file is a GLB: call it {} (`umbrage render` makes a picture of that)",
        output.display(),
        output.with_extension("glb").display()
    );
    Ok(())
}

/// Fails where a bake would replace its own scene, which has what no baked file has: emission, and surfaces in their own mesh.
fn check_is_not_the_scene(scene: &Path, output: &Path) -> anyhow::Result<()> {
    let is_scene = match (scene.canonicalize(), output.canonicalize()) {
        (Ok(scene), Ok(output)) => scene == output,
        // What is not there yet is another file.
        _ => false,
    };
    anyhow::ensure!(!is_scene, "{}: is the scene itself: give the baked file another name", output.display());
    Ok(())
}

/// Bakes in one step, with progress on the terminal.
///
/// # Errors
/// [`Interrupted`], and whatever is wrong with the scene.
pub(crate) fn bake_scene(scene: &Arc<Scene>, settings: &BakeSettings, output: Output) -> anyhow::Result<Step> {
    let mut baked = None;
    bake_in_steps(scene, settings, &Wishes::default(), output, |step| {
        baked = Some(step);
        Ok(())
    })?;
    baked.context("nothing was baked")
}

/// Writes a bake as GLB, and with it how it was made.
pub(crate) fn write(scene: &Scene, step: &Step, exposure: Option<f64>, path: &Path) -> anyhow::Result<Written> {
    let mut facts = facts(&step.settings, &step.bake.report, exposure);
    if step.is_cut_short {
        facts.extras.insert("cut_short".into(), true.into());
    }
    Ok(write_baked_glb(scene, &step.bake.mesh, &facts, path)?)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_file_that_is_called_a_picture_is_refused() {
        assert!(check_is_glb(Path::new("a/out.glb")).is_ok() && check_is_glb(Path::new("OUT.GLB")).is_ok());
        assert!(check_is_glb(Path::new("out")).is_ok());
        let message = check_is_glb(Path::new("a/out.png")).unwrap_err().to_string();
        assert!(message.starts_with("a/out.png:") && message.contains("call it a/out.glb"), "{message}");
    }

    #[test]
    fn a_folder_that_is_not_there_is_told_before_the_bake() {
        assert!(check_folder(Path::new("out.glb")).is_ok());
        let message = check_folder(Path::new("no/such/folder/out.glb")).unwrap_err().to_string();
        assert!(message.contains("no/such/folder/out.glb") && message.contains("there is no folder"), "{message}");
    }
}
