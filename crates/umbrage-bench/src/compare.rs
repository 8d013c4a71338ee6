//! `compare`: two stored runs, scene by scene, as ratios.

use std::path::PathBuf;

use anyhow::ensure;
use clap::Args;

use crate::record::{Measured, Run, Timed};
use crate::say;
use crate::table::{Table, percent};

const HELP: &str = "Every ratio is the second run over the first: 0.50 is half the time, memory or triangles.";

/// Compare two stored runs of the suite
#[derive(Debug, Args)]
#[command(after_help = HELP)]
pub(crate) struct CompareArgs {
    /// The run that is compared with
    #[arg(value_name = "A.json")]
    before: PathBuf,
    /// The run that is compared
    #[arg(value_name = "B.json")]
    after: PathBuf,
}

pub(crate) fn run(args: &CompareArgs) -> anyhow::Result<()> {
    let (before, after) = (Run::read(&args.before)?, Run::read(&args.after)?);
    ensure!(!pairs(&before, &after).is_empty(), "the runs have no scene in common");
    say(&describe(&before, &after))
}

/// The scenes that are in both runs.
fn pairs<'a>(before: &'a Run, after: &'a Run) -> Vec<[&'a Measured; 2]> {
    let with = |after: &'a Measured| {
        before.scenes.iter().find(|before| before.scene == after.scene).map(|before| [before, after])
    };
    after.scenes.iter().filter_map(with).collect()
}

fn describe(before: &Run, after: &Run) -> String {
    let mut text = String::new();
    for (name, run) in [("A", before), ("B", after)] {
        let (machine, tolerance) = (&run.machine, run.tolerance);
        text += &format!(
            "{name}: {}, version {}, {} cores of {}, tolerance {tolerance}\n",
            run.date, run.version, machine.cores, machine.cpu
        );
    }
    if before.machine != after.machine {
        text += "The machines differ: ratios of time say little.\n";
    }
    if before.tolerance != after.tolerance {
        text += "The tolerances differ: the bakes were not asked for the same.\n";
    }
    for (name, run) in [("A", before), ("B", after)] {
        for bake in &run.unfinished {
            text += &format!("{name}: {} with {} threads {}\n", bake.scene, bake.threads, bake.why);
        }
    }
    let pairs = pairs(before, after);
    format!("{text}\n{}\n{}", ratios(&pairs).text(), stages(&pairs).text())
}

fn ratio(before: f64, after: f64) -> String {
    format!("{:.2}", after / before)
}

/// The ratio of a figure that both bakes may have.
fn ratio_of([before, after]: [&Measured; 2], of: impl Fn(&Measured) -> Option<f64>) -> String {
    of(before).zip(of(after)).map_or(String::new(), |(before, after)| ratio(before, after))
}

/// B / A of whole bakes, and the errors of both.
fn ratios(pairs: &[[&Measured; 2]]) -> Table {
    let mut table = Table::new(&[
        "B / A",
        "1 thread",
        "2 threads",
        "CPU",
        "memory",
        "links",
        "triangles",
        "error A",
        "error B",
        "+-",
    ]);
    for &pair in pairs {
        let of_last = |of: &dyn Fn(&Timed) -> Option<f64>| ratio_of(pair, |scene| of(scene.last()));
        let seconds = |threads| ratio_of(pair, |scene| scene.with_threads(threads).map(|bake| bake.seconds));
        let [before, after] = pair.map(|scene| &scene.verified);
        table.row(vec![
            pair[1].scene.clone(),
            seconds(1),
            seconds(2),
            of_last(&|bake| bake.cpu_seconds),
            of_last(&|bake| bake.peak_bytes.map(|bytes| bytes as f64)),
            of_last(&|bake| Some(bake.links as f64)),
            of_last(&|bake| Some(bake.triangles as f64)),
            percent(before.error[0], 2),
            percent(after.error[0], 2),
            percent(before.error[1].hypot(after.error[1]), 2),
        ]);
    }
    table
}

/// B / A of the seconds of each stage, with the most threads.
fn stages(pairs: &[[&Measured; 2]]) -> Table {
    let names: Vec<&str> = pairs
        .iter()
        .take(1)
        .flat_map(|[_, after]| &after.last().stage_seconds)
        .map(|(name, _)| name.as_str())
        .collect();
    let mut table = Table::new(&[&["B / A"], &names[..]].concat());
    for &pair in pairs {
        let of = |name: &str| {
            ratio_of(pair, |scene| scene.last().stage_seconds.iter().find(|(stage, _)| stage == name).map(|(_, s)| *s))
        };
        table.row([pair[1].scene.clone()].into_iter().chain(names.iter().map(|name| of(name))).collect());
    }
    table
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::record::tests::{measured, run};

    #[test]
    fn half_the_time_is_a_ratio_of_a_half() {
        let before = run(vec![measured("gone", 20, 1.0), measured("a", 20, 3.0)]);
        let after = run(vec![measured("a", 20, 1.5), measured("new", 20, 1.0)]);
        let text = describe(&before, &after);
        assert!(text.contains("| a     |     0.50 |      0.50 | 0.50 |   1.00 |"), "{text}");
        assert!(text.contains("| a     |    0.50 |  0.50 |"), "{text}");
        assert!(!text.contains("gone") && !text.contains("new") && !text.contains("differ"), "{text}");
    }

    #[test]
    fn what_makes_runs_incomparable_is_said() {
        let (before, mut after) = (run(vec![measured("a", 20, 3.0)]), run(vec![measured("a", 20, 3.0)]));
        after.tolerance *= 2.0;
        after.machine.cores += 1;
        assert_eq!(describe(&before, &after).matches("differ").count(), 2);
    }
}
