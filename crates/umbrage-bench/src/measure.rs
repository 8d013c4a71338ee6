//! One bake in a process of its own: what it took, and what it errs.
//!
//! Time and memory are taken when the bytes of the baked file are there, before anything is verified.

use std::hash::{DefaultHasher, Hasher};
use std::io;
use std::ops::ControlFlow;
use std::path::PathBuf;
use std::process::{self, Command, Stdio};
use std::time::Instant;

use anyhow::{Context, bail};
use clap::Args;
use serde::{Deserialize, Serialize};
use umbrage::bake::{BakeError, BakeSettings, bake};
use umbrage::progress::Progress;
use umbrage::scene::Scene;
use umbrage::shade::{BakedMesh, ShadeSettings};
use umbrage_formats::{BakeFacts, baked_glb_bytes};
use umbrage_verify::{BakedTriangle, Settings, verify};

use crate::positive;
use crate::record::{Timed, Verified};
use crate::scenes;
use crate::usage;

/// Exit code of a bake that the limit ended.
const NOT_ENDED: i32 = 4;
/// Points that are verified, and paths from each: the error is then known to about a tenth of a percent of the mean
/// light.
const CHECK: Settings = Settings { points: 1000, paths: 2048, seed: 1, smooth: true };

/// Bake one scene and print what it took as JSON
#[derive(Debug, Args)]
pub(crate) struct OneArgs {
    /// Name or path
    scene: String,
    #[arg(long, value_parser = positive)]
    tolerance: f64,
    #[arg(long)]
    threads: usize,
    /// Seconds for reading, baking and making the bytes of the file
    #[arg(long, value_parser = positive)]
    limit: f64,
    /// Follow paths, too
    #[arg(long)]
    verify: bool,
}

/// A bake that is wanted.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Task<'a> {
    /// Name or path.
    pub(crate) scene: &'a str,
    pub(crate) tolerance: f64,
    pub(crate) threads: usize,
    /// Seconds that it may take.
    pub(crate) limit_s: f64,
    /// Follow paths, too.
    pub(crate) verify: bool,
}

/// What the process prints.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(crate) struct Answer {
    pub(crate) timed: Timed,
    pub(crate) verified: Option<Verified>,
}

/// Starts this program anew to bake a scene.
///
/// # Errors
/// Says why it left nothing; the process itself has told more on standard error.
pub(crate) fn in_a_process(task: Task<'_>) -> anyhow::Result<Answer> {
    let Task { scene, tolerance, threads, limit_s, verify } = task;
    let mut command = Command::new(this_program()?);
    command.arg("one").args([format!("--tolerance={tolerance}"), format!("--threads={threads}")]);
    command.arg(format!("--limit={limit_s}")).args(verify.then_some("--verify")).args(["--", scene]);
    let output = command.stdin(Stdio::null()).stderr(Stdio::inherit()).output()?;
    match output.status.code() {
        Some(0) => serde_json::from_slice(&output.stdout).context("its answer is not understood"),
        Some(NOT_ENDED) => bail!("did not end in {limit_s} s"),
        _ => bail!("failed: {}", output.status),
    }
}

/// The file of this program; on Linux the very file that runs, though a new build may have taken its place.
pub(crate) fn this_program() -> anyhow::Result<PathBuf> {
    if cfg!(target_os = "linux") {
        Ok("/proc/self/exe".into())
    } else {
        std::env::current_exe().context("the program does not know its own place")
    }
}

pub(crate) fn run(args: &OneArgs) -> anyhow::Result<()> {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(args.threads).build()?;
    match pool.install(|| measured(args)) {
        Err(error) if matches!(error.downcast_ref(), Some(BakeError::Cancelled(_))) => process::exit(NOT_ENDED),
        answer => Ok(serde_json::to_writer(io::stdout().lock(), &answer?)?),
    }
}

fn measured(args: &OneArgs) -> anyhow::Result<Answer> {
    let begin = Instant::now();
    let scene = scenes::scene(&args.scene)?;
    let default = BakeSettings::default();
    let settings = BakeSettings { shade: ShadeSettings { tolerance: args.tolerance, ..default.shade }, ..default };
    let in_time = |_| match begin.elapsed().as_secs_f64() {
        seconds if seconds > args.limit => ControlFlow::Break(()),
        _ => ControlFlow::Continue(()),
    };
    let baked = bake(&scene, &settings, Progress::new(&in_time))?;
    let bytes = baked_glb_bytes(&scene, &baked.mesh, &BakeFacts::default())?;
    let report = baked.report;
    let timed = Timed {
        threads: args.threads,
        polygons: scene.polygon_count(),
        faces: report.faces,
        d_segments: report.d_segments,
        patches: report.patches,
        leaves: Some(report.leaves),
        linking_seconds: Some(report.linking_s),
        links: report.links,
        triangles: report.triangles,
        estimate: report.error,
        seconds: begin.elapsed().as_secs_f64(),
        stage_seconds: report.seconds.iter().map(|(stage, seconds)| (stage.to_string(), *seconds)).collect(),
        cpu_seconds: usage::cpu_seconds(),
        peak_bytes: usage::peak_bytes(),
        digest: digest(&bytes),
    };
    let verified = args.verify.then(|| verified(&scene, &baked.mesh)).transpose()?;
    Ok(Answer { timed, verified })
}

fn digest(bytes: &[u8]) -> String {
    let mut hasher = DefaultHasher::new();
    hasher.write(bytes);
    format!("{:016x}", hasher.finish())
}

fn verified(scene: &Scene, mesh: &BakedMesh) -> anyhow::Result<Verified> {
    let report = verify(scene, &triangles(mesh), &CHECK, &|_, _| ControlFlow::Continue(()))?;
    Ok(Verified {
        error: [report.error.value, report.error.standard_error],
        bias: [report.bias.value, report.bias.standard_error],
        noise: report.noise,
        points: report.compared,
        leaks: report.leaks.len(),
    })
}

/// The triangles of a baked mesh in the world.
pub(crate) fn triangles(mesh: &BakedMesh) -> Vec<BakedTriangle> {
    let of_part = mesh.parts.iter().flat_map(|part| {
        let triangle = |&corners| BakedTriangle::new(mesh.origin_m, corners, &part.positions_m, &part.irradiance);
        part.triangles.iter().map(triangle)
    });
    of_part.collect()
}
