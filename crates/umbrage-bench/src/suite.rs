//! `suite`: whole bakes of scenes, each in a process of its own, with one thread and with two.

use std::path::PathBuf;

use anyhow::{Context, bail};
use clap::Args;
use jiff::{Timestamp, Unit};
use umbrage::shade::ShadeSettings;

use crate::machine::{Machine, version};
use crate::measure::{self, Answer};
use crate::record::{Measured, Run, Timed};
use crate::scenes::{self, SMALL};
use crate::table::{Table, grouped, percent, seconds};
use crate::{positive, say, tell};

/// Numbers of threads.
const THREADS: [usize; 2] = [1, 2];
/// A bake is measured so often at most, and the fastest counts: what else runs only ever makes it slower.
const MOST_BAKES: usize = 3;
/// Nor is it measured again when that took so long, in seconds.
const LONG_S: f64 = 10.0;

const HELP: &str = "\
Scenes: cornell, touching, occluder, room, field-N (boxes of N faces in all, under three lamps; field-100000 takes long), or the \
path of a scene. Each bake is a process of its own. Errors are by path tracing, as `umbrage verify` does it.";

/// Bake scenes and store what it took
#[derive(Debug, Args)]
#[command(after_help = HELP)]
pub(crate) struct SuiteArgs {
    /// Names or paths, with commas between them
    #[arg(long, value_delimiter = ',', value_name = "SCENES", default_values = SMALL)]
    scenes: Vec<String>,
    /// The error that is asked for, as a share of the mean light
    #[arg(long, value_name = "T", value_parser = positive, default_value_t = ShadeSettings::default().tolerance)]
    tolerance: f64,
    /// Where what was measured goes [default: bench-runs/DATE.json in the project]
    #[arg(short, long, value_name = "RUN.json")]
    output: Option<PathBuf>,
}

pub(crate) fn run(args: &SuiteArgs) -> anyhow::Result<()> {
    let date = Timestamp::now().round(Unit::Second)?.to_string();
    let mut run =
        Run { version: version(), machine: Machine::here(), tolerance: args.tolerance, scenes: Vec::new(), date };
    let in_project = || scenes::in_project("bench-runs").join(format!("{}.json", run.date.replace(':', "")));
    let path = args.output.clone().unwrap_or_else(in_project);
    let mut failed = Vec::new();
    for name in &args.scenes {
        tell(&format!("{name} ..."));
        match measured(name, args.tolerance) {
            Ok(measured) => run.scenes.push(measured),
            Err(error) => {
                tell(&format!("{name} failed: {error:#}"));
                failed.push(name.as_str());
            }
        }
        // A large scene may take hours: what was measured before it is kept whatever comes.
        run.write(&path)?;
    }
    say(&format!("{}\nWrote {}", describe(&run), path.display()))?;
    if !failed.is_empty() {
        bail!("not measured: {}", failed.join(", "));
    }
    match run.scenes.iter().find(|scene| !scene.same_bytes) {
        Some(scene) => bail!("{}: not the same bytes every time", scene.scene),
        None => Ok(()),
    }
}

/// Bakes a scene with each number of threads, and verifies it once.
fn measured(name: &str, tolerance: f64) -> anyhow::Result<Measured> {
    let (mut bakes, mut digests, mut verified) = (Vec::new(), Vec::new(), None);
    for (round, threads) in THREADS.into_iter().enumerate() {
        let mut best: Option<Timed> = None;
        let mut spent_s = 0.0;
        for again in 0..MOST_BAKES {
            if again > 0 && spent_s > LONG_S {
                break;
            }
            // The check is done with the most threads.
            let check = again == 0 && round + 1 == THREADS.len();
            let Answer { timed, verified: found } = measure::in_a_process(name, tolerance, threads, check)?;
            verified = verified.or(found);
            spent_s += timed.seconds;
            digests.push(timed.digest.clone());
            if best.as_ref().is_none_or(|best| timed.seconds < best.seconds) {
                best = Some(timed);
            }
        }
        bakes.extend(best);
    }
    let verified = verified.context("nothing was verified")?;
    digests.dedup();
    Ok(Measured { scene: name.into(), same_bytes: digests.len() == 1, verified, bakes })
}

/// The run as tables.
fn describe(run: &Run) -> String {
    let Run { date, version, machine, tolerance, scenes } = run;
    let mut text = format!(
        "{date}, version {version}, {} cores of {}, {}, tolerance {tolerance}\n\n{}\n{}",
        machine.cores,
        machine.cpu,
        machine.system,
        results(scenes).text(),
        times(scenes).text()
    );
    if let Some((time, memory)) = growth(scenes) {
        text +=
            &format!("\nFrom the smallest to the largest field, time grows with polygons to the power of {time:.2}");
        text += &memory.map_or(String::new(), |memory| format!(", memory {memory:.2}"));
        text += ".\n";
    }
    text
}

fn results(scenes: &[Measured]) -> Table {
    let mut table = Table::new(&[
        "scene",
        "polygons",
        "faces",
        "links",
        "triangles",
        "estimate",
        "error",
        "+-",
        "bias",
        "+-",
        "leaks",
    ]);
    for scene in scenes {
        let (last, verified) = (scene.last(), &scene.verified);
        let counts = [last.polygons, last.faces, last.links, last.triangles].map(grouped);
        let shares = [
            percent(last.estimate, 2),
            percent(verified.error[0], 2),
            percent(verified.error[1], 2),
            percent(verified.bias[0], 2),
            percent(verified.bias[1], 2),
        ];
        let leaks = [grouped(verified.leaks)];
        table.row([scene.scene.clone()].into_iter().chain(counts).chain(shares).chain(leaks).collect());
    }
    table
}

fn times(scenes: &[Measured]) -> Table {
    let stages: Vec<&str> =
        scenes.iter().take(1).flat_map(|s| &s.last().stage_seconds).map(|(name, _)| name.as_str()).collect();
    let heads = ["seconds", "1 thread", "2 threads", "1 / 2", "CPU", "memory"];
    let mut table = Table::new(&[&heads[..], &stages].concat());
    for scene in scenes {
        let last = scene.last();
        let [one, two] = THREADS.map(|threads| scene.with_threads(threads).map(|bake| bake.seconds));
        let ratio = one.zip(two).map(|(one, two)| format!("{:.2}", one / two));
        let cells =
            [one.map(seconds), two.map(seconds), ratio, last.cpu_seconds.map(seconds), last.peak_bytes.map(mebibytes)];
        let stages = last.stage_seconds.iter().map(|(_, s)| seconds(*s));
        let name = [scene.scene.clone()];
        table.row(name.into_iter().chain(cells.map(Option::unwrap_or_default)).chain(stages).collect());
    }
    table
}

fn mebibytes(bytes: u64) -> String {
    format!("{:.1} MiB", bytes as f64 / f64::from(1 << 20))
}

/// The powers of the number of polygons with which time and memory grow from the smallest to the largest field of boxes;
/// `None` where there are no two.
fn growth(scenes: &[Measured]) -> Option<(f64, Option<f64>)> {
    let fields = || scenes.iter().filter(|scene| scenes::field_polygons(&scene.scene).is_some()).map(Measured::last);
    let (small, large) = (fields().min_by_key(|bake| bake.polygons)?, fields().max_by_key(|bake| bake.polygons)?);
    let polygons = (large.polygons as f64 / small.polygons as f64).ln();
    let power = |small: f64, large: f64| (large / small).ln() / polygons;
    let memory = small.peak_bytes.zip(large.peak_bytes).map(|(small, large)| power(small as f64, large as f64));
    (polygons > 0.0).then(|| (power(small.seconds, large.seconds), memory))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::record::tests::{measured, run};

    #[test]
    fn growth_is_the_slope_between_the_smallest_and_the_largest_field() {
        let scenes = [
            measured("field-1000", 1000, 2.0),
            measured("cornell", 20, 500.0),
            measured("field-100000", 100_000, 2.0 * 100_f64.powf(1.15)),
            measured("field-10000", 10_000, 7.0),
        ];
        let (time, memory) = growth(&scenes).unwrap();
        assert!((time - 1.15).abs() < 1e-9 && memory == Some(0.0), "{time} {memory:?}");
        assert_eq!(growth(&scenes[..2]), None);
    }

    #[test]
    fn tables_have_a_line_for_every_scene() {
        let text = describe(&run(vec![measured("a", 12, 1.0), measured("b", 3456, 20.0)]));
        assert!(
            text.contains("| a       |     1.00 |      0.60 |  1.67 | 0.60 | 1.0 MiB |    0.15 |  0.45 |"),
            "{text}"
        );
        assert!(
            text.contains("| b     |    3,456 | 3,456 |    20 |        30 |   1.00 % | 0.80 % | 0.01 % | -0.10 % |"),
            "{text}"
        );
    }
}
