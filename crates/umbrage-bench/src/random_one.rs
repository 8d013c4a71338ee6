//! One random scene in a process of its own, which a limit on processor time ends whatever happens.

use std::io;
use std::ops::ControlFlow;
use std::process;

use clap::Args;
use serde::{Deserialize, Serialize};
use umbrage::bake::{BakeError, BakeSettings, bake};
use umbrage::progress::Progress;
use umbrage::shade::ShadeSettings;
use umbrage_bench::usage;
use umbrage_verify::judge::{FaultKind, Judged, judge};
use umbrage_verify::random::{RandomScene, Size};

use crate::measure;
use crate::parts::Parts;

/// Exit code of a bake that the limit ended.
pub(crate) const NOT_ENDED: i32 = 4;
/// Processor time for judging, in seconds, beside that for the bake.
pub(crate) const JUDGING_S: f64 = 120.0;

/// More triangles for each polygon than this are too many in degenerate scenes.
const TRIANGLES_OF_POLYGON: usize = 1000;

/// What the processes of a run have in common.
#[derive(Clone, Debug, Args)]
pub(crate) struct RandomSettings {
    /// Things in a scene, at most
    #[arg(long, default_value_t = 40)]
    pub(crate) things: usize,
    /// Lamps in a scene, at most
    #[arg(long, default_value_t = 40)]
    pub(crate) lamps: usize,
    /// Error asked for, as a share of the mean light
    #[arg(long, value_parser = crate::positive, default_value_t = 0.01)]
    pub(crate) tolerance: f64,
    /// Processor seconds that a bake may take
    #[arg(long, value_parser = crate::positive, default_value_t = 20.0)]
    pub(crate) limit: f64,
    /// Tiny degenerate scenes instead: light is not compared with paths, and there may be no more than a thousand triangles for each polygon
    #[arg(long)]
    pub(crate) degenerate: bool,
}

impl RandomSettings {
    /// The scene of a seed.
    pub(crate) fn scene(&self, seed: u64) -> RandomScene {
        if self.degenerate {
            return RandomScene::degenerate(seed);
        }
        RandomScene::new(seed, Size { things: self.things, lamps: self.lamps })
    }
}

/// Bake and judge one random scene and print what came of it as JSON
#[derive(Debug, Args)]
pub(crate) struct RandomOneArgs {
    #[arg(long)]
    seed: u64,
    /// Numbers of the polygons and lamps to take
    #[arg(long)]
    parts: Option<Parts>,
    #[command(flatten)]
    settings: RandomSettings,
}

/// A kind of fault, and what is wrong.
pub(crate) type Told = (String, String);

/// What the process prints.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub(crate) struct Answer {
    pub(crate) polygons: usize,
    pub(crate) triangles: usize,
    /// Processor time of the bake.
    pub(crate) cpu_seconds: f64,
    pub(crate) error: f64,
    pub(crate) faults: Vec<Told>,
}

pub(crate) fn run(args: &RandomOneArgs) -> anyhow::Result<()> {
    let limit_s = args.settings.limit;
    end_after(limit_s + JUDGING_S);
    let random = args.settings.scene(args.seed);
    let scene = random.scene(|part| args.parts.as_ref().is_none_or(|parts| parts.has(part)));
    let default = BakeSettings::default();
    let shade = ShadeSettings { tolerance: args.settings.tolerance, ..default.shade };
    let in_time = |_| match usage::cpu_seconds() {
        Some(seconds) if seconds > limit_s => ControlFlow::Break(()),
        _ => ControlFlow::Continue(()),
    };
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build()?;
    let mut answer = Answer { polygons: scene.polygon_count(), ..Answer::default() };
    match pool.install(|| bake(&scene, &BakeSettings { shade, ..default }, Progress::new(&in_time))) {
        Err(BakeError::Cancelled(_)) => process::exit(NOT_ENDED),
        Err(error) => answer.faults.push(("refused".into(), error.to_string())),
        Ok(baked) => {
            answer.cpu_seconds = usage::cpu_seconds().unwrap_or_default();
            answer.triangles = baked.report.triangles;
            let triangles = measure::triangles(&baked.mesh);
            let judged = Judged {
                scene: &scene,
                triangles: &triangles,
                tolerance: args.settings.tolerance,
                surplus: baked.report.energy.error(),
                light: random.is_distinct() && !args.settings.degenerate,
                warned: !baked.report.warnings.is_empty(),
            };
            if let Err(broken) = baked.mesh.validate() {
                answer.faults.push(("broken mesh".into(), broken.to_string()));
            }
            let most = TRIANGLES_OF_POLYGON * answer.polygons;
            if args.settings.degenerate && answer.triangles > most {
                answer.faults.push(("triangles".into(), format!("{} of {}", answer.triangles, answer.polygons)));
            }
            let judgement = pool.install(|| judge(&judged))?;
            answer.faults.extend(baked.report.warnings.iter().map(|warning| ("warning".into(), warning.to_string())));
            answer.error = judgement.error.value;
            // Too many triangles are told above.
            let is_told = |kind: FaultKind| args.settings.degenerate && kind == FaultKind::Triangles;
            let others = judgement.faults.into_iter().filter(|fault| !is_told(fault.kind));
            answer.faults.extend(others.map(|fault| (fault.kind.to_string(), fault.what)));
        }
    }
    Ok(serde_json::to_writer(io::stdout().lock(), &answer)?)
}

/// Lets the system end this process after so many seconds of processor time, wherever it then is.
#[cfg(unix)]
fn end_after(seconds: f64) {
    use nix::sys::resource::{Resource, setrlimit};
    let seconds = seconds.ceil() as u64;
    // Where the system refuses, the bake's own limit is left.
    let _ = setrlimit(Resource::RLIMIT_CPU, seconds, seconds + 1);
}

#[cfg(not(unix))]
fn end_after(_: f64) {}
