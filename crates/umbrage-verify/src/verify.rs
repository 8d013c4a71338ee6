//! The check: points, paths, and the bake beside them.

use std::ops::ControlFlow;
use std::sync::atomic::{AtomicUsize, Ordering};

use fastrand::Rng;
use glam::DVec3;
use rayon::prelude::*;
use umbrage::scene::{Rgb, Scene, SceneError};

use crate::baked::{Baked, Shown};
use crate::emitters::Emitters;
use crate::path::{BATCHES, Gathered, Paths};
use crate::report::{CheckedPoint, Report};
use crate::smooth::SmoothSurfaces;
use crate::tracer::Tracer;
use crate::{lamps, points, sides};

/// A point with less than this share of the mean light, next to where the bake ends, is enclosed by what stands on it.
const ENCLOSED_OF_MEAN: f64 = 1e-3;

/// A triangle of a bake, with its light.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BakedTriangle {
    /// Its corners in the world, counter-clockwise seen from its front, in metres.
    pub corners_m: [DVec3; 3],
    /// Irradiance at the corners, in W/m2.
    pub irradiance: [Rgb; 3],
}

impl BakedTriangle {
    /// The triangle of the corners with these numbers, whose positions are relative to `origin_m`.
    pub fn new(origin_m: DVec3, corners: [u32; 3], positions_m: &[[f32; 3]], irradiance: &[[f32; 3]]) -> Self {
        let vectors = |of: &[[f32; 3]]| corners.map(|i| DVec3::from(of[i as usize].map(f64::from)));
        Self { corners_m: vectors(positions_m).map(|p| origin_m + p), irradiance: vectors(irradiance) }
    }
}

/// How much is checked.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Settings {
    /// Points on the surfaces.
    pub points: usize,
    /// Paths from each point, rounded up to eight times a square number.
    pub paths: usize,
    /// Where the random numbers begin: another seed checks other points by other paths.
    pub seed: u64,
    /// Whether surfaces whose normals say so are smooth.
    pub smooth: bool,
}

impl Default for Settings {
    fn default() -> Self {
        Self { points: 1000, paths: 8192, seed: 1, smooth: true }
    }
}

/// Why nothing was checked.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum VerifyError {
    /// The scene cannot be used as it is.
    #[error(transparent)]
    Scene(#[from] SceneError),
    /// No surface that receives light can be compared.
    #[error(
        "no point of the scene can be compared: is the file baked from this scene, in the same unit and with the same axes?"
    )]
    NothingToCompare,
    /// The callback asked to stop.
    #[error("cancelled")]
    Cancelled,
}

/// Compares a bake with light by path tracing; `progress` is told how many of how many points are done.
///
/// # Errors
/// A [`VerifyError`] where the scene is refused, nothing can be compared, or the callback breaks.
pub fn verify(
    scene: &Scene,
    baked: &[BakedTriangle],
    settings: &Settings,
    progress: &(dyn Fn(usize, usize) -> ControlFlow<()> + Sync),
) -> Result<Report, VerifyError> {
    scene.validate()?;
    let extent_m = sides::extent_m(scene);
    let smooth = if settings.smooth { SmoothSurfaces::new(scene, extent_m) } else { SmoothSurfaces::default() };
    let tracer = Tracer::new(scene, &smooth, extent_m);
    let baked = Baked::new(baked, tracer.extent_m);
    let emitters = Emitters::new(scene, &tracer);
    let lamps = lamps::lamps(scene, &tracer);
    let paths = Paths { scene, tracer: &tracer, emitters: &emitters, lamps: &lamps };
    let mut rng = Rng::with_seed(settings.seed);
    let places = points::points(scene, &tracer, settings.points, &mut rng);
    let seeds: Vec<u64> = places.iter().map(|_| rng.u64(..)).collect();
    let side = (settings.paths as f64 / BATCHES as f64).sqrt().ceil().max(1.0) as usize;

    let done = AtomicUsize::new(0);
    let gathered: Vec<(Option<Shown>, Gathered)> = places
        .par_iter()
        .zip(&seeds)
        .map(|(place, &seed)| {
            if progress(done.fetch_add(1, Ordering::Relaxed), places.len()).is_break() {
                return Err(VerifyError::Cancelled);
            }
            Ok((baked.irradiance(place), paths.gather(place, side, seed)))
        })
        .collect::<Result<_, _>>()?;

    let light =
        |gathered: &Gathered| gathered.batches.iter().copied().sum::<Rgb>().element_sum() / (3 * BATCHES) as f64;
    let mean = gathered.iter().map(|(_, gathered)| light(gathered)).sum::<f64>() / gathered.len().max(1) as f64;
    let (mut compared, mut buried, mut uncovered, mut rays) = (Vec::new(), Vec::new(), 0, 0);
    for (place, (shown, gathered)) in places.iter().zip(&gathered) {
        rays += gathered.rays;
        let is_dark = gathered.batches.iter().all(|&batch| batch == Rgb::ZERO);
        let point = |shown| CheckedPoint::new(place.position_m, place.front, shown, &gathered.batches);
        // Of what is dark the light of a sheet close by tells nothing.
        match shown.filter(|shown| shown.is_own || !is_dark).map(|shown| shown.irradiance) {
            // What no light reaches may be left out of a bake.
            None if is_dark => buried.push(point(Rgb::ZERO)),
            None => uncovered += 1,
            // And what is shown beside it may go on for a bit into it. A path in thousands finds a way out through the rounding of edges, and
            // out of a smooth surface that it sees from above.
            Some(shown)
                if light(gathered) < ENCLOSED_OF_MEAN * mean && shown != Rgb::ZERO && baked.ends_near(place) =>
            {
                buried.push(point(Rgb::ZERO));
            }
            Some(shown) if is_dark && !gathered.sees_a_side => buried.push(point(shown)),
            Some(shown) => compared.push(point(shown)),
        }
    }
    if compared.is_empty() {
        return Err(VerifyError::NothingToCompare);
    }
    let paths = (places.len() * BATCHES * side * side) as u64;
    Ok(Report::new(&compared, &buried, uncovered, paths, rays))
}
