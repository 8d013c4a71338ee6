//! `random`: many random scenes baked and judged, each in a process of its own.
//!
//! What fails is told by its seed, and can be reduced to the few polygons and lamps that make it fail, and written as a file.

use std::collections::BTreeMap;
use std::path::PathBuf;
use std::process::{Command, Stdio};

use clap::Args;
use rayon::prelude::*;
use umbrage_verify::random::reduce;

use crate::measure::this_program;
use crate::parts::Parts;
use crate::random_one::{Answer, NOT_ENDED, RandomSettings, Told};
use crate::table::{Table, grouped, percent, seconds};
use crate::{random_file, say, tell};

/// Seeds of a kind of fault that the table lists.
const LISTED: usize = 12;
/// Bakes for the reduction of one scene, at most.
const REDUCING_BAKES: usize = 150;

/// Bake many random scenes and judge each by paths of light
#[derive(Debug, Args)]
pub(crate) struct RandomArgs {
    /// How many scenes
    #[arg(long, default_value_t = 1000)]
    scenes: u64,
    /// The first one's seed: the others' follow it
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// Processes at a time [default: as many as there are processors]
    #[arg(long)]
    jobs: Option<usize>,
    #[command(flatten)]
    settings: RandomSettings,
    /// Reduce so many scenes of each kind of fault to the parts that make them fail
    #[arg(long, default_value_t = 0)]
    reduce: usize,
    /// Write scenes that fail, reduced if so asked, into this folder: an OBJ, and a TOML with lamps and materials
    #[arg(long, value_name = "FOLDER")]
    write: Option<PathBuf>,
}

/// A scene that fails.
struct Failure {
    seed: u64,
    told: Told,
}

pub(crate) fn run(args: &RandomArgs) -> anyhow::Result<()> {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(args.jobs.unwrap_or(0)).build()?;
    let seeds: Vec<u64> = (args.seed..args.seed + args.scenes).collect();
    let answers: Vec<Answer> = pool.install(|| {
        let judged = |&seed: &u64| {
            let answer = in_a_process(&args.settings, seed, None)?;
            answer.faults.iter().for_each(|(kind, what)| tell(&format!("{seed}: {kind}: {what}")));
            anyhow::Ok(answer)
        };
        seeds.par_iter().map(judged).collect::<anyhow::Result<_>>()
    })?;
    let mut failures: BTreeMap<&str, Vec<Failure>> = BTreeMap::new();
    for (&seed, answer) in seeds.iter().zip(&answers) {
        for told in &answer.faults {
            failures.entry(&told.0).or_default().push(Failure { seed, told: told.clone() });
        }
    }
    say(&by_kind(&failures, answers.len()).text())?;
    say(&summary(&answers))?;
    say(&by_trait(args, &seeds, &answers).text())?;
    for failure in failures.values().flat_map(|failures| failures.iter().take(args.reduce.max(1))) {
        let parts = (args.reduce > 0).then(|| pool.install(|| reduced(&args.settings, failure)));
        if let Some((parts, what)) = &parts {
            let Failure { seed, told: (kind, _) } = failure;
            say(&format!("{kind}, seed {seed}: {} parts are enough (--parts {parts}): {what}", parts.len()))?;
        }
        if let Some(folder) = &args.write {
            let path = folder.join(format!("{}-{}.obj", failure.told.0.replace(' ', "-"), failure.seed));
            let random = args.settings.scene(failure.seed);
            let scene = random.scene(|part| parts.as_ref().is_none_or(|(parts, _)| parts.has(part)));
            say(&format!("wrote {}", random_file::write(&scene, &path)?))?;
        }
    }
    Ok(())
}

/// Bakes and judges a scene in a process of its own: what that dies of is a fault, too.
fn in_a_process(settings: &RandomSettings, seed: u64, parts: Option<&Parts>) -> anyhow::Result<Answer> {
    let RandomSettings { things, lamps, tolerance, limit, degenerate } = settings;
    let mut command = Command::new(this_program()?);
    command.arg("random-one").arg(format!("--seed={seed}")).args(parts.map(|parts| format!("--parts={parts}")));
    command.arg(format!("--things={things}")).arg(format!("--lamps={lamps}"));
    command.args(degenerate.then_some("--degenerate"));
    command.arg(format!("--tolerance={tolerance}")).arg(format!("--limit={limit}"));
    let output = command.stdin(Stdio::null()).output()?;
    let heard = String::from_utf8_lossy(&output.stderr);
    let failed = |kind: &str, what: String| Answer { faults: vec![(kind.into(), what)], ..Answer::default() };
    Ok(match output.status.code() {
        Some(0) => serde_json::from_slice(&output.stdout)?,
        Some(NOT_ENDED) => failed("time", format!("did not end in {limit} s of processor time")),
        // The place, and what was said there.
        _ if heard.contains("panicked at") => {
            let from = heard.find("panicked at").unwrap_or_default();
            failed("panic", heard[from..].lines().take(2).collect::<Vec<_>>().join(" "))
        }
        _ => failed("killed", format!("{}: {}", output.status, heard.lines().next().unwrap_or_default())),
    })
}

/// The parts of a scene that are enough for a kind of fault, and what then is wrong.
fn reduced(settings: &RandomSettings, failure: &Failure) -> (Parts, String) {
    let mut last = failure.told.1.clone();
    let fails = |parts: &[usize]| {
        let parts = Parts::new(parts.to_vec());
        let answer = in_a_process(settings, failure.seed, Some(&parts)).unwrap_or_default();
        let told = answer.faults.into_iter().find(|told| told.0 == failure.told.0);
        told.map(|(_, what)| last = what).is_some()
    };
    let groups = settings.scene(failure.seed).groups();
    (Parts::new(reduce(&groups, fails, REDUCING_BAKES)), last)
}

fn by_kind(failures: &BTreeMap<&str, Vec<Failure>>, scenes: usize) -> Table {
    let mut table = Table::new(&["fault", "scenes", "of", "share", "seeds"]);
    for (kind, failures) in failures {
        let mut seeds: Vec<String> = failures.iter().take(LISTED).map(|failure| failure.seed.to_string()).collect();
        seeds.extend((failures.len() > LISTED).then(|| "...".into()));
        let share = percent(failures.len() as f64 / scenes.max(1) as f64, 2);
        table.row(vec![(*kind).into(), grouped(failures.len()), grouped(scenes), share, seeds.join(" ")]);
    }
    table
}

/// What a scene took, in the middle and at the most.
fn summary(answers: &[Answer]) -> String {
    let baked: Vec<&Answer> = answers.iter().filter(|answer| answer.triangles > 0).collect();
    let good = answers.iter().filter(|answer| answer.faults.is_empty()).count();
    let sorted = |of: &dyn Fn(&Answer) -> f64| {
        let mut values: Vec<f64> = baked.iter().map(|answer| of(answer)).collect();
        values.sort_by(f64::total_cmp);
        [values.len() / 2, values.len() * 9 / 10, values.len().saturating_sub(1)]
            .map(|place| values.get(place).copied().unwrap_or_default())
    };
    let [half, most, worst] = sorted(&|answer| answer.cpu_seconds).map(seconds);
    let triangles = sorted(&|answer| answer.triangles as f64 / answer.polygons.max(1) as f64);
    let error = sorted(&|answer| answer.error).map(|error| percent(error, 2));
    format!(
        "\nbaked {} of {}, without a fault {good}; median, 90th percentile and most: processor time {half}, {most}, {worst} s; \
         triangles of a polygon {:.0}, {:.0}, {:.0}; error {}, {}, {}\n\n",
        baked.len(),
        answers.len(),
        triangles[0],
        triangles[1],
        triangles[2],
        error[0],
        error[1],
        error[2],
    )
}

/// How often scenes with a trait fail.
fn by_trait(args: &RandomArgs, seeds: &[u64], answers: &[Answer]) -> Table {
    let mut counts: BTreeMap<&str, [usize; 2]> = BTreeMap::new();
    for (&seed, answer) in seeds.iter().zip(answers) {
        for name in args.settings.scene(seed).traits {
            let [scenes, failed] = counts.entry(name).or_default();
            *scenes += 1;
            *failed += usize::from(!answer.faults.is_empty());
        }
    }
    let mut table = Table::new(&["trait", "scenes", "with a fault", "share"]);
    for (name, [scenes, failed]) in counts {
        table.row(vec![name.into(), grouped(scenes), grouped(failed), percent(failed as f64 / scenes as f64, 1)]);
    }
    table
}
