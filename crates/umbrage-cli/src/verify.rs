//! `umbrage verify`: a baked file against light by path tracing.

use std::fmt::Write;
use std::path::PathBuf;
use std::time::Instant;

use anyhow::Context;
use clap::Args;
use glam::DVec3;
use umbrage::prepare::orient;
use umbrage_formats::{BakedFile, read_baked};
use umbrage_verify::{BakedTriangle, CheckedPoint, Estimate, Report, Settings};

use crate::interrupt;
use crate::light::Units;
use crate::method::{positive, share};
use crate::output::{Output, answer, warning};
use crate::progress::Bar;
use crate::scene_file::SceneArgs;
use crate::summary::{self, count, grouped, rgb, rounded};

const HELP: &str = "\
Examples:
  umbrage verify room.glb baked.glb
  umbrage verify room.glb baked.glb --points 4000 --paths 32768    less noise, for longer
  umbrage verify room.glb baked.glb --max-error 0.02               exit code 3 if the error is above 2 %

Paths of light are followed from random points of the surfaces that receive light and do not emit; what the bake shows there \
is compared. The check shares no geometry with the bake. Its own noise is told, and taken off the error. Errors are shares of \
the mean irradiance. Options that say how the scene is read must be those of the bake.";

/// So many standard errors over a value lies a bound that holds in 98 of 100 checks.
const SURE: f64 = 2.0;

/// Check a baked file against path tracing: error, bias, worst places, light that leaks
#[derive(Debug, Args)]
#[command(after_help = HELP)]
pub(crate) struct VerifyArgs {
    /// The scene that was baked: glTF 2.0 (.glb or .gltf), OBJ, MGF, PLY or STL
    scene: PathBuf,
    /// The baked file (.glb)
    baked: PathBuf,
    /// How many points are compared
    #[arg(long, value_name = "N", default_value_t = Settings::default().points)]
    points: usize,
    /// How many paths are followed from each point, rounded up to eight times a square
    #[arg(long, value_name = "N", default_value_t = Settings::default().paths)]
    paths: usize,
    /// Where the random numbers begin: another seed checks other points
    #[arg(long, value_name = "N", default_value_t = Settings::default().seed)]
    seed: u64,
    /// Fail, with exit code 3, if the error is above this share of the mean irradiance, or if light leaks
    #[arg(long, value_name = "E", value_parser = positive)]
    max_error: Option<f64>,
    /// What --max-reflectance of the bake was
    #[arg(long, value_name = "R", value_parser = share, default_value_t = 0.9)]
    max_reflectance: f64,
    /// The bake was made with --flat-shading: normals of the file count for nothing
    #[arg(long)]
    flat_shading: bool,
    #[command(flatten)]
    reading: SceneArgs,
}

/// The error is above the bound that was given.
#[derive(Debug, thiserror::Error)]
#[error("the bake is not as good as asked: {0}")]
pub(crate) struct NotGoodEnough(String);

pub(crate) fn run(args: &VerifyArgs, output: Output) -> anyhow::Result<()> {
    interrupt::listen()?;
    let cannot = || format!("cannot verify {}", args.baked.display());
    let mut scene = args.reading.read(&args.scene, args.max_reflectance)?;
    // Which side of a polygon is lit is the scene's own business, and paths take it as the bake did.
    scene.validate().with_context(cannot)?;
    let turned = orient(&mut scene).with_context(cannot)?;
    if turned > 0 {
        warning(&format!("{}: {}", args.scene.display(), summary::turned(turned)));
    }
    let baked = read_baked(&args.baked)?;
    let begin = Instant::now();
    let bar = Bar::new(output);
    let settings = Settings { points: args.points, paths: args.paths, seed: args.seed, smooth: !args.flat_shading };
    let report =
        umbrage_verify::verify(&scene, &triangles(&baked), &settings, &|done, total| bar.step("verify", done, total));
    bar.clear();
    let report = report.with_context(cannot)?;
    answer(&describe(&report, &baked, begin.elapsed().as_secs_f64()))?;
    match args.max_error {
        Some(bound) if report.error.value > bound => {
            let text =
                format!("its error is {}, and should be at most {}", percent(report.error.value), percent(bound));
            Err(NotGoodEnough(text).into())
        }
        Some(_) if !report.leaks.is_empty() => {
            Err(NotGoodEnough(count(report.leaks.len(), "point leaks|points leak")).into())
        }
        _ => Ok(()),
    }
}

/// The triangles of a baked file, in the world.
fn triangles(baked: &BakedFile) -> Vec<BakedTriangle> {
    let parts = baked.parts.iter().flat_map(|part| {
        let triangle = |&corners| BakedTriangle::new(baked.origin_m, corners, &part.positions_m, &part.irradiance);
        part.triangles.iter().map(triangle)
    });
    parts.collect()
}

fn percent(share: f64) -> String {
    format!("{:.3} %", 100.0 * share)
}

fn describe(report: &Report, baked: &BakedFile, seconds: f64) -> String {
    let unit = Units::of(baked.photometric).irradiance;
    let mut text = String::new();
    let mut line = |name: &str, value: String| {
        // Writing to a string cannot fail.
        let _ = writeln!(text, "{name:<12}  {value}");
    };
    let (error, bias) = (report.error, report.bias);
    line("error", measured(error));
    line("bias", format!("{:+.3} % +- {} of it", 100.0 * bias.value, percent(bias.standard_error)));
    line("noise", format!("{} of this check, rms, taken off the error", percent(report.noise)));
    let own = baked.extras.get("error").and_then(serde_json::Value::as_f64);
    let own =
        own.map(|own| format!("{} of the bake's own mean, by interpolation between vertices alone", percent(own)));
    line("estimate", own.unwrap_or_else(|| "none".into()));
    line("mean", format!("{} {unit} at these points, by paths", rounded(report.mean_irradiance)));
    let dark = count(report.dark, "dark one|dark ones");
    line("points", format!("{}, {dark}; {} buried and left out", grouped(report.compared), grouped(report.buried)));
    if report.uncovered > 0 {
        line("uncovered", format!("{} where the bake has no triangle", count(report.uncovered, "point")));
    }
    line("triangles", grouped(baked.triangle_count()));
    let (paths, rays) = (report.paths as f64 / seconds / 1e6, report.rays as f64 / seconds / 1e6);
    line("speed", format!("{paths:.2} million paths/s, {rays:.2} million rays/s, {seconds:.1} s"));
    line("leaks", if report.leaks.is_empty() { "none".into() } else { grouped(report.leaks.len()) });
    const LISTED: usize = 8;
    report.leaks.iter().take(LISTED).for_each(|leak| line("", place(leak, unit)));
    line("worst", String::new());
    report.worst.iter().for_each(|point| line("", place(point, unit)));
    text
}

/// An error with its standard error; where noise hides it, with a bound.
fn measured(error: Estimate) -> String {
    let told = format!(
        "{} +- {} of the mean irradiance at these points, rms",
        percent(error.value),
        percent(error.standard_error)
    );
    if error.value >= error.standard_error {
        return told;
    }
    let bound = percent(error.value + SURE * error.standard_error);
    format!("{told}: below about {bound}, noise hides how much; more --paths measure it")
}

/// A point, with what the bake shows there and what paths tell, in `unit`.
fn place(point: &CheckedPoint, unit: &str) -> String {
    let vector = |v: DVec3| v.to_array().map(|x| rounded(if x.abs() < 5e-5 { 0.0 } else { x })).join(",");
    format!(
        "at {} on {}: {} {unit} baked, {} +- {} traced",
        vector(point.position_m),
        vector(point.normal),
        rgb(point.baked),
        rgb(point.traced),
        rgb(point.traced_error)
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_error_that_noise_hides_is_told_as_a_bound() {
        let told = |value: f64, standard_error: f64| measured(Estimate { value, standard_error });
        assert_eq!(told(0.005, 0.001), "0.500 % +- 0.100 % of the mean irradiance at these points, rms");
        assert!(told(0.0, 0.0).ends_with("rms"), "what is exact hides nothing");
        let hidden = told(0.0, 0.56);
        assert!(hidden.starts_with("0.000 % +- 56.000 %") && hidden.contains("below about 112.000 %"), "{hidden}");
    }
}
