//! `suite`: whole bakes of scenes, each in a process of its own, with one thread and with two.

use std::path::PathBuf;

use anyhow::bail;
use clap::Args;
use jiff::{Timestamp, Unit};
use umbrage::shade::ShadeSettings;

use crate::machine::{Machine, version};
use crate::measure::{self, Task};
use crate::record::{Measured, Run, Timed, Unfinished};
use crate::scenes::{self, SMALL, Wanted, field_polygons};
use crate::table::{Table, grouped, percent, seconds};
use crate::{positive, say, tell};

/// Numbers of threads.
const THREADS: [usize; 2] = [1, 2];
/// A bake is measured so often at most, and the fastest counts: what else runs only ever makes it slower.
const MOST_BAKES: usize = 3;
/// Nor is it measured again when that took so long, in seconds.
const LONG_S: f64 = 10.0;

const HELP: &str = "\
Scenes: cornell, touching, occluder, room, home, field-N (boxes of N faces in all, under three lamps), fields (those of 100, 1,000, \
10,000 and 100,000), or the path of a scene; SCENE@T is baked at tolerance T. Each bake is a process of its own. Errors are by path \
tracing, as `umbrage verify` does it. A bake that takes longer than the limit is recorded as one that did not end.";

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
    /// Seconds that a bake may take
    #[arg(long, value_name = "S", value_parser = positive, default_value_t = 600.0)]
    limit: f64,
    /// Where what was measured goes [default: bench-runs/DATE.json in the project]
    #[arg(short, long, value_name = "RUN.json")]
    output: Option<PathBuf>,
}

pub(crate) fn run(args: &SuiteArgs) -> anyhow::Result<()> {
    let date = Timestamp::now().round(Unit::Second)?.to_string();
    let mut run = Run {
        version: version(),
        machine: Machine::here(),
        tolerance: args.tolerance,
        scenes: Vec::new(),
        unfinished: Vec::new(),
        date,
    };
    let in_project = || scenes::in_project("bench-runs").join(format!("{}.json", run.date.replace(':', "")));
    let path = args.output.clone().unwrap_or_else(in_project);
    for wanted in args.scenes.iter().flat_map(|word| Wanted::of(word)) {
        tell(&format!("{} ...", wanted.told));
        let (measured, unfinished) = measured(&wanted, args);
        unfinished.iter().for_each(|bake| tell(&describe_unfinished(bake)));
        run.scenes.extend(measured);
        run.unfinished.extend(unfinished);
        // A large scene may take hours: what was measured before it is kept whatever comes.
        run.write(&path)?;
    }
    say(&format!("{}\nWrote {}", describe(&run), path.display()))?;
    if !run.unfinished.is_empty() {
        bail!("not all was measured");
    }
    match run.scenes.iter().find(|scene| !scene.same_bytes) {
        Some(scene) => bail!("{}: not the same bytes every time", scene.scene),
        None => Ok(()),
    }
}

/// Bakes a scene with each number of threads, the most first, and verifies it once; and which of these bakes left
/// nothing.
fn measured(wanted: &Wanted, args: &SuiteArgs) -> (Option<Measured>, Vec<Unfinished>) {
    let (mut bakes, mut digests, mut verified, mut unfinished) = (Vec::new(), Vec::new(), None, Vec::new());
    for threads in THREADS.into_iter().rev() {
        let task = |verify: bool| Task {
            scene: &wanted.name,
            tolerance: wanted.tolerance.unwrap_or(args.tolerance),
            threads,
            limit_s: args.limit,
            verify,
        };
        let mut best: Option<Timed> = None;
        let mut spent_s = 0.0;
        for _ in 0..MOST_BAKES {
            match measure::in_a_process(task(verified.is_none())) {
                Ok(answer) => {
                    verified = verified.or(answer.verified);
                    digests.push(answer.timed.digest.clone());
                    spent_s += answer.timed.seconds;
                    if best.as_ref().is_none_or(|best| answer.timed.seconds < best.seconds) {
                        best = Some(answer.timed);
                    }
                }
                Err(error) => {
                    let (scene, why) = (wanted.told.clone(), format!("{error:#}"));
                    unfinished.push(Unfinished { scene, threads, why });
                    break;
                }
            }
            if spent_s > LONG_S {
                break;
            }
        }
        match best {
            Some(best) => bakes.insert(0, best),
            // With fewer threads it would take longer still.
            None => break,
        }
    }
    digests.dedup();
    let measured = verified.map(|verified| Measured {
        scene: wanted.told.clone(),
        same_bytes: digests.len() == 1,
        verified,
        bakes,
    });
    (measured, unfinished)
}

fn describe_unfinished(bake: &Unfinished) -> String {
    format!("{} with {} threads {}", bake.scene, bake.threads, bake.why)
}

/// The run as tables.
fn describe(run: &Run) -> String {
    let Run { date, version, machine, tolerance, scenes, unfinished } = run;
    let mut text = format!(
        "{date}, version {version}, {} cores of {}, {}, tolerance {tolerance}\n",
        machine.cores, machine.cpu, machine.system
    );
    let growth = growth(scenes);
    let tables = [(!scenes.is_empty()).then(|| results(scenes)), (!scenes.is_empty()).then(|| times(scenes)), growth];
    tables.iter().flatten().for_each(|table| text += &format!("\n{}", table.text()));
    if !unfinished.is_empty() {
        let lines: Vec<String> = unfinished.iter().map(|bake| describe_unfinished(bake) + "\n").collect();
        text += &format!("\n{}", lines.concat());
    }
    text
}

fn results(scenes: &[Measured]) -> Table {
    let mut table = Table::new(&[
        "scene",
        "polygons",
        "faces",
        "links",
        "a leaf",
        "us each",
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
        let [polygons, faces, links, triangles] = [last.polygons, last.faces, last.links, last.triangles].map(grouped);
        let of_links = last.links as f64;
        let a_leaf = last.leaves.map_or(String::new(), |leaves| format!("{:.1}", of_links / leaves.max(1) as f64));
        let linking_s = last.linking_seconds.filter(|_| last.links > 0);
        let us_each = linking_s.map_or(String::new(), |s| format!("{:.1}", 1e6 * s / of_links));
        let counts = [polygons, faces, links, a_leaf, us_each, triangles];
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

/// The powers of the number of polygons with which time, memory and the rest grow over the fields of boxes, a row for
/// each tolerance; `None` where there are no two fields.
fn growth(scenes: &[Measured]) -> Option<Table> {
    let mut of_tolerance: Vec<(String, Vec<&Timed>)> = Vec::new();
    for scene in scenes {
        let fields = Wanted::of(&scene.scene).into_iter().filter(|wanted| field_polygons(&wanted.name).is_some());
        for field in fields {
            let row = format!("fields{}", &field.told[field.name.len()..]);
            match of_tolerance.iter_mut().find(|(name, _)| *name == row) {
                Some((_, bakes)) => bakes.push(scene.last()),
                None => of_tolerance.push((row, vec![scene.last()])),
            }
        }
    }
    let stages: Vec<&str> = of_tolerance
        .first()
        .and_then(|(_, bakes)| bakes.first())
        .map_or(Vec::new(), |bake| bake.stage_seconds.iter().map(|(name, _)| name.as_str()).collect());
    let mut table = Table::new(&[&["power of N", "time", "CPU", "memory", "links", "triangles"], &stages[..]].concat());
    let mut is_empty = true;
    for (name, bakes) in of_tolerance {
        let of = |figure: &dyn Fn(&Timed) -> Option<f64>| {
            let points = bakes.iter().filter_map(|bake| Some((bake.polygons as f64, figure(bake)?)));
            power(&points.collect::<Vec<_>>())
        };
        let stage =
            |name: &str| of(&|bake| bake.stage_seconds.iter().find(|(stage, _)| stage == name).map(|(_, s)| *s));
        let Some(time) = of(&|bake| Some(bake.seconds)) else { continue };
        let whole = [
            Some(time),
            of(&|bake| bake.cpu_seconds),
            of(&|bake| bake.peak_bytes.map(|bytes| bytes as f64)),
            of(&|bake| Some(bake.links as f64)),
            of(&|bake| Some(bake.triangles as f64)),
        ];
        let powers = whole.into_iter().chain(stages.iter().map(|name| stage(name)));
        let cells = powers.map(|power| power.map_or(String::new(), |power| format!("{power:.2}")));
        table.row([name].into_iter().chain(cells).collect());
        is_empty = false;
    }
    (!is_empty).then_some(table)
}

/// The power of `x` with which `y` grows: the slope of the straight line through logarithms that errs least in squares;
/// `None` where there are no two different `x`, or something is not above 0.
fn power(points: &[(f64, f64)]) -> Option<f64> {
    if points.iter().any(|&(x, y)| !(x > 0.0 && y > 0.0)) {
        return None;
    }
    let logarithms: Vec<(f64, f64)> = points.iter().map(|&(x, y)| (x.ln(), y.ln())).collect();
    let mean = |of: fn(&(f64, f64)) -> f64| logarithms.iter().map(of).sum::<f64>() / points.len() as f64;
    let (x, y) = (mean(|p| p.0), mean(|p| p.1));
    let spread: f64 = logarithms.iter().map(|p| (p.0 - x).powi(2)).sum();
    let together: f64 = logarithms.iter().map(|p| (p.0 - x) * (p.1 - y)).sum();
    (spread > 1e-9).then(|| together / spread)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::record::tests::{measured, run};

    #[test]
    fn growth_is_the_slope_through_all_fields_of_one_tolerance() {
        let field = |n: usize, suffix: &str| {
            let seconds = 3e-4 * (n as f64).powf(1.15);
            measured(&format!("field-{n}{suffix}"), n, seconds)
        };
        let scenes = [
            field(1000, ""),
            measured("cornell", 20, 500.0),
            field(100_000, ""),
            field(10_000, ""),
            field(100, "@0.03"),
            field(300, "@0.03"),
            field(100, "@0.1"),
        ];
        let text = growth(&scenes).unwrap().text();
        let row = |name: &str| format!("| {name:<11} | 1.15 | 1.15 |   0.00 |  0.00 |      0.00 |    1.15 |  1.15 |");
        assert!(text.contains(&row("fields")) && text.contains(&row("fields@0.03")), "{text}");
        assert!(!text.contains("fields@0.1 "), "one size does not grow: {text}");
        assert!(growth(&scenes[..2]).is_none());
    }

    #[test]
    fn the_power_of_a_power_law_with_even_scatter_is_its_own() {
        // y = x^2, but for factors that cancel.
        let points = [(1.0, 1.1), (2.0, 4.0 / 1.1), (4.0, 16.0 / 1.1), (8.0, 64.0 * 1.1)];
        assert!((power(&points).unwrap() - 2.0).abs() < 1e-12);
        assert_eq!(power(&[(2.0, 1.0), (2.0, 3.0)]), None);
        assert_eq!(power(&[(1.0, 0.0), (2.0, 3.0)]), None, "0 has no logarithm");
    }

    #[test]
    fn bakes_that_left_nothing_are_told() {
        let mut run = run(Vec::new());
        run.unfinished.push(Unfinished { scene: "field-9".into(), threads: 2, why: "did not end in 5 s".into() });
        let text = describe(&run);
        assert!(text.ends_with("\nfield-9 with 2 threads did not end in 5 s\n") && !text.contains('|'), "{text}");
    }

    #[test]
    fn tables_have_a_line_for_every_scene() {
        let text = describe(&run(vec![measured("a", 12, 1.0), measured("b", 3456, 20.0)]));
        assert!(
            text.contains("| a       |     1.00 |      0.60 |  1.67 | 0.60 | 1.0 MiB |    0.15 |  0.45 |"),
            "{text}"
        );
        assert!(
            text.contains("| b     |    3,456 | 3,456 |    20 |    2.5 |     2.0 |        30 |   1.00 % | 0.80 % | 0.01 % | -0.10 % |"),
            "{text}"
        );
    }
}
