//! `convergence`: error against triangles and against time, with and without discontinuities.
//!
//! With discontinuities a scene is baked at a row of tolerances. Without, it is given as many triangles as each of
//! these bakes made, by a tolerance that it cannot reach, and the same Fmax: all that differs is where triangles are.

use std::path::PathBuf;
use std::time::Instant;

use anyhow::Context;
use clap::Args;
use umbrage::bake::{BakeSettings, bake};
use umbrage::prepare::PrepareSettings;
use umbrage::progress::Progress;
use umbrage::scene::Scene;
use umbrage::shade::ShadeSettings;

use crate::reference::{NAMES, Reference};
use crate::table::{Table, grouped, percent, seconds};
use crate::{measure, page, plot, say, scenes, tell, usage};

/// What is asked for: error as a share of the mean light.
const TOLERANCES: [f64; 6] = [0.16, 0.08, 0.04, 0.02, 0.01, 0.005];
/// Without discontinuities a tolerance below by this share is asked for, so that the number of triangles is what ends
/// it.
const OUT_OF_REACH: f64 = 0.1;

const HELP: &str = "\
Error is the relative root mean square error of the irradiance at the reference points of testdata/reference, whose own noise is \
in it and is drawn as a line. Time is that of the processor, all threads together.";

/// Draw error against triangles and time, with and without discontinuities
#[derive(Debug, Args)]
#[command(after_help = HELP)]
pub(crate) struct ConvergenceArgs {
    /// Scenes that have reference points, with commas between them
    #[arg(long, value_delimiter = ',', value_name = "SCENES", default_values = NAMES)]
    scenes: Vec<String>,
    /// The drawing; a page of the same name beside it, if there is one, gets the figures between its marks anew
    /// [default: docs/convergence.svg in the project]
    #[arg(short, long, value_name = "PLOT.svg")]
    output: Option<PathBuf>,
}

/// A bake, as a point of a curve.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Sample {
    pub(crate) triangles: usize,
    /// Processor time.
    pub(crate) seconds: f64,
    /// Relative root mean square error.
    pub(crate) error: f64,
}

/// What was measured of a scene.
#[derive(Clone, Debug)]
pub(crate) struct Curves {
    pub(crate) scene: String,
    /// Standard error of the reference, as a share of the mean.
    pub(crate) noise: f64,
    /// With discontinuities and without, for each tolerance.
    pub(crate) samples: Vec<[Sample; 2]>,
}

pub(crate) fn run(args: &ConvergenceArgs) -> anyhow::Result<()> {
    let begin = Instant::now();
    let curves = args.scenes.iter().map(|scene| curves(scene)).collect::<anyhow::Result<Vec<_>>>()?;
    let output = args.output.clone().unwrap_or_else(|| scenes::in_project("docs/convergence.svg"));
    plot::write(&curves, &output)?;
    let table = table(&curves).text();
    say(&format!("{table}\nWrote {} in {:.0} s", output.display(), begin.elapsed().as_secs_f64()))?;
    let page = output.with_extension("md");
    if page.exists() {
        page::put_figures(&page, &table)?;
        say(&format!("Wrote {}", page.display()))?;
    }
    Ok(())
}

fn curves(name: &str) -> anyhow::Result<Curves> {
    let (reference, scene) = (Reference::read(name)?, scenes::scene(name)?);
    let mut samples = Vec::new();
    for tolerance in TOLERANCES {
        tell(&format!("{name} at {tolerance} ..."));
        let default = BakeSettings::default();
        let with = BakeSettings { shade: ShadeSettings { tolerance, ..default.shade }, ..default };
        let found = sample(&scene, &reference, &with)?;
        let without = BakeSettings {
            max_form_factor: Some(with.fmax()),
            prepare: PrepareSettings { cut_contacts: false, ..with.prepare },
            discontinuities: false,
            shade: ShadeSettings { tolerance: OUT_OF_REACH * tolerance, max_triangles: found.triangles },
            ..with
        };
        samples.push([found, sample(&scene, &reference, &without)?]);
    }
    Ok(Curves { scene: name.into(), noise: reference.noise, samples })
}

fn sample(scene: &Scene, reference: &Reference, settings: &BakeSettings) -> anyhow::Result<Sample> {
    const NEEDED: &str = "this system does not tell processor time";
    let before = usage::cpu_seconds().context(NEEDED)?;
    let baked = bake(scene, settings, Progress::silent())?;
    let seconds = usage::cpu_seconds().context(NEEDED)? - before;
    let error = reference.error(&measure::triangles(&baked.mesh))?;
    Ok(Sample { triangles: baked.report.triangles, seconds, error })
}

fn table(curves: &[Curves]) -> Table {
    let mut table = Table::new(&[
        "scene",
        "tolerance",
        "triangles",
        "error",
        "CPU s",
        "triangles without",
        "error without",
        "CPU s without",
        "error ratio",
    ]);
    for Curves { scene, samples, .. } in curves {
        for (tolerance, [with, without]) in TOLERANCES.iter().zip(samples) {
            let of = |sample: &Sample| [grouped(sample.triangles), percent(sample.error, 2), seconds(sample.seconds)];
            let ratio = format!("{:.2}", without.error / with.error);
            let ends = ([scene.clone(), tolerance.to_string()], [ratio]);
            table.row(ends.0.into_iter().chain(of(with)).chain(of(without)).chain(ends.1).collect());
        }
    }
    table
}
