//! What is wrong with a bake, by kinds that a run over many random scenes can count.
//!
//! Few points and paths find a suspect, and many by other random numbers must confirm it, so that chance is no fault.

use std::fmt;
use std::ops::ControlFlow;

use umbrage::scene::{Rgb, Scene};

use crate::conformity::t_vertices;
use crate::report::{Estimate, Report};
use crate::verify::{BakedTriangle, Settings, VerifyError, verify};

/// A bake may err this many times what was asked.
const ERROR_OF_ASKED: f64 = 3.0;
/// An error counts by what it exceeds its own standard errors by, this many of them; a suspect need not be sure.
const SURE: f64 = 2.0;
/// The account of energy may be off by this share, without a warning.
const ACCOUNT: f64 = 0.05;
/// A point that is dark and is shown brighter than this share of the mean light is a leak ...
const LEAK_OF_MEAN: f64 = 0.05;
/// ... where at least this share of the points is.
const LEAKS_OF_POINTS: f64 = 0.01;
/// More triangles of a polygon than this, in the mean over the scene, are too many ...
const TRIANGLES_OF_POLYGON: usize = 1000;
/// ... where there are more than this in all: one large floor under a near bulb takes thousands.
const FEW_TRIANGLES: usize = 20_000;

/// Light fainter than this share of the brightest source is none: it is that of sources seen from their edge, by rounding.
const NOTHING_OF_BRIGHTEST: f64 = 1e-9;

/// How many points and paths find a suspect.
const FIRST: [usize; 2] = [150, 128];
/// How many confirm it, by other random numbers.
const SECOND: [usize; 2] = [600, 2048];

/// A kind of fault.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum FaultKind {
    /// Vertices inside edges.
    TVertices,
    /// Energy made or lost.
    Energy,
    /// Light that is not what paths tell.
    Error,
    /// Light where there must be none.
    Leak,
    /// Places without a triangle.
    Uncovered,
    /// Far more triangles than the scene has polygons.
    Triangles,
}

impl fmt::Display for FaultKind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::TVertices => "T-vertices",
            Self::Energy => "energy",
            Self::Error => "error",
            Self::Leak => "leak",
            Self::Uncovered => "uncovered",
            Self::Triangles => "triangles",
        })
    }
}

/// A fault of a bake.
#[derive(Clone, Debug, PartialEq)]
pub struct Fault {
    /// Its kind.
    pub kind: FaultKind,
    /// How bad it is, and where.
    pub what: String,
}

/// What is judged.
#[derive(Clone, Copy, Debug)]
pub struct Judged<'a> {
    /// What was baked.
    pub scene: &'a Scene,
    /// What came of it.
    pub triangles: &'a [BakedTriangle],
    /// Error asked for, as a share of the mean light.
    pub tolerance: f64,
    /// Surplus of the account of energy, as a share of what is emitted.
    pub surplus: f64,
    /// Whether light is compared with paths: not where sides are nearer to each other than the baker welds.
    pub light: bool,
    /// Whether the bake warned that its light is doubtful: the account may then be off.
    pub warned: bool,
}

/// A judgement.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Judgement {
    /// Faults, in the order of their kinds.
    pub faults: Vec<Fault>,
    /// Error by paths, as a share of the mean light; of the last check.
    pub error: Estimate,
}

/// Judges a bake.
///
/// # Errors
/// A [`VerifyError`] where the scene is refused. Nothing to compare is no error: then all is black.
pub fn judge(judged: &Judged<'_>) -> Result<Judgement, VerifyError> {
    let mut faults = Vec::new();
    let mut add = |kind, what: String| faults.push(Fault { kind, what });
    let cracks = t_vertices(judged.triangles);
    if let Some(first) = cracks.first() {
        add(FaultKind::TVertices, format!("{}, one at {} on {:?}", cracks.len(), first.vertex_m, first.edge_m));
    }
    if judged.surplus.abs() > ACCOUNT && !judged.warned {
        add(FaultKind::Energy, format!("{:+.2} %", 100.0 * judged.surplus));
    }
    let (triangles, polygons) = (judged.triangles.len(), judged.scene.polygon_count());
    if triangles > FEW_TRIANGLES.max(TRIANGLES_OF_POLYGON * polygons) {
        add(FaultKind::Triangles, format!("{triangles} of {polygons} polygons"));
    }
    let check = |[points, paths]: [usize; 2], seed: u64| {
        let settings = Settings { points, paths, seed, ..Settings::default() };
        match verify(judged.scene, judged.triangles, &settings, &|_, _| ControlFlow::Continue(())) {
            Ok(report) => {
                Ok((report.mean_irradiance > NOTHING_OF_BRIGHTEST * brightest(judged.scene)).then_some(report))
            }
            Err(VerifyError::NothingToCompare) => Ok(None),
            Err(error) => Err(error),
        }
    };
    let shown = shown_mean(judged.triangles);
    let faults_of = |report: &Report, points, sure| {
        // What a lamp throws on the spot that it touches is much of the mean light, and no point lies there.
        let unit = (shown / report.mean_irradiance).max(1.0);
        light_faults(&in_units(report, unit), judged.tolerance, points, sure)
    };
    let mut report = if judged.light { check(FIRST, 1)? } else { None };
    if report.as_ref().is_some_and(|report| !faults_of(report, FIRST[0], 0.0).is_empty()) {
        report = check(SECOND, 2)?;
        faults.extend(report.iter().flat_map(|report| faults_of(report, SECOND[0], SURE)));
    }
    faults.sort_by_key(|fault| fault.kind);
    Ok(Judgement { faults, error: report.map(|report| report.error).unwrap_or_default() })
}

/// Mean irradiance that triangles show, over the colours, in W/m2.
fn shown_mean(triangles: &[BakedTriangle]) -> f64 {
    let (mut flux_w, mut area_m2) = (0.0, 0.0);
    for BakedTriangle { corners_m: [a, b, c], irradiance } in triangles {
        let doubled_m2 = (b - a).cross(c - a).length();
        flux_w += doubled_m2 * irradiance.iter().map(|light| light.element_sum()).sum::<f64>() / 9.0;
        area_m2 += doubled_m2;
    }
    if area_m2 > 0.0 { flux_w / area_m2 } else { 0.0 }
}

/// A report whose mean light is so many times as much, and errors as many times less a share of it.
fn in_units(report: &Report, unit: f64) -> Report {
    let Estimate { value, standard_error } = report.error;
    let error = Estimate { value: value / unit, standard_error: standard_error / unit };
    Report { error, mean_irradiance: unit * report.mean_irradiance, ..report.clone() }
}

/// The exitance of the brightest surface, or the brightness of the brightest lamp.
fn brightest(scene: &Scene) -> f64 {
    let surfaces = scene.materials.iter().map(|material| material.exitance());
    surfaces.chain(scene.lamps.iter().map(|lamp| lamp.brightness())).map(Rgb::max_element).fold(0.0, f64::max)
}

/// What is wrong by a check.
fn light_faults(report: &Report, tolerance: f64, points: usize, sure: f64) -> Vec<Fault> {
    let mut faults = Vec::new();
    let mut add = |kind, what: String| faults.push(Fault { kind, what });
    let Estimate { value, standard_error } = report.error;
    if value - sure * standard_error > ERROR_OF_ASKED * tolerance {
        let percent = [100.0 * value, 100.0 * standard_error];
        let worst = report.worst.first().map(|p| format!(", worst at {}: {} for {}", p.position_m, p.baked, p.traced));
        add(FaultKind::Error, format!("{:.2} +- {:.2} %{}", percent[0], percent[1], worst.unwrap_or_default()));
    }
    let bright = |light: Rgb| light.max_element() > LEAK_OF_MEAN * report.mean_irradiance;
    let leaks: Vec<_> = report.leaks.iter().filter(|leak| bright(leak.baked)).collect();
    if let Some(worst) = leaks.first().filter(|_| leaks.len() as f64 > LEAKS_OF_POINTS * points as f64) {
        let mean = report.mean_irradiance;
        add(
            FaultKind::Leak,
            format!("{} points, one at {}: {} W/m2, mean {mean}", leaks.len(), worst.position_m, worst.baked),
        );
    }
    if report.uncovered as f64 > LEAKS_OF_POINTS * points as f64 {
        add(FaultKind::Uncovered, format!("{} of {} points", report.uncovered, points));
    }
    faults
}

#[cfg(test)]
mod tests {
    use umbrage::scene::cornell::cornell_box;

    use super::*;
    use crate::sides;

    fn kinds(triangles: &[BakedTriangle], surplus: f64) -> Vec<FaultKind> {
        let judged = Judged { scene: &cornell_box(), triangles, tolerance: 0.01, surplus, light: true, warned: false };
        judge(&judged).unwrap().faults.iter().map(|fault| fault.kind).collect()
    }

    #[test]
    fn each_kind_of_fault_is_found() {
        let flat = vec![Vec::new(); cornell_box().polygon_count()];
        let triangles: Vec<BakedTriangle> = sides::triangles(&cornell_box(), &flat)
            .iter()
            .map(|triangle| BakedTriangle { corners_m: triangle.corners_m(), irradiance: [Rgb::ONE; 3] })
            .collect();
        // Even light is not that of the box, and lights its floor beneath the blocks.
        let wrong = [FaultKind::Error, FaultKind::Leak];
        assert_eq!(kinds(&triangles, 0.01), wrong);
        assert_eq!(kinds(&triangles, -0.06), [&[FaultKind::Energy], &wrong[..]].concat());
        assert!(kinds(&triangles[2..], 0.0).contains(&FaultKind::Uncovered), "the floor is not there");
        assert_eq!(kinds(&triangles.repeat(600), 0.0), [&wrong[..], &[FaultKind::Triangles]].concat());
        // A triangle whose side ends in the middle of another's.
        let [p, q, r] = triangles[0].corners_m;
        let half = BakedTriangle { corners_m: [0.5 * (p + q), q, p + q - r], ..triangles[0] };
        let cut = [&triangles[..1], &[half]].concat();
        assert!(kinds(&cut, 0.0).contains(&FaultKind::TVertices));
    }
}
