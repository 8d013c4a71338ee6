//! Iterations to a stated residual: `R <- rho (D + F R)` from `R = rho D`, each one a bounce of light (Jacobi), where `R` is
//! the reflected radiosity and `D` the direct irradiance.
//!
//! The residual is the area mean of what a bounce changes, relative to the area mean of radiosity, in the worst channel.
//! What is still missing is at most the residual times `rho / (1 - rho)`. Sums run over leaves in the order of their
//! numbers: the same bits come out whatever the number of threads.

use super::gather::{RadiosityMoments, gather};
use super::push_pull::push_pull;
use super::surfaces::Surfaces;
use crate::id::{FaceId, PatchId, Table};
use crate::mesh::Mesh;
use crate::progress::{self, Cancelled, Progress, Stage};
use crate::scene::Rgb;
use crate::transport::{Linear, Links};

/// When iterations stop.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SolveSettings {
    /// At this relative residual.
    pub max_residual: f64,
    /// After so many iterations, whatever the residual.
    pub max_iterations: usize,
}

impl Default for SolveSettings {
    fn default() -> Self {
        Self { max_residual: 1e-5, max_iterations: 200 }
    }
}

/// Light of every node of the hierarchy.
#[derive(Clone, Debug, PartialEq)]
pub struct Solution {
    /// What each patch reflects, `B - M`, in W/m2: its area mean and the best linear fit.
    pub reflected: Table<PatchId, Linear<Rgb>>,
    /// Irradiance `E` of each patch, in W/m2: its area mean, and of leaves the best linear fit.
    pub irradiance: Table<PatchId, Linear<Rgb>>,
    /// Relative residual that was reached.
    pub residual: f64,
    /// Iterations that it took.
    pub iterations: usize,
}

/// A broken promise of [`Solution`]: always a defect of this library.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum SolutionError {
    /// A value is negative, NaN or infinite.
    #[error("{patch:?} reflects {reflected} of irradiance {irradiance}")]
    BadLight {
        /// The patch.
        patch: PatchId,
        /// The radiosity that it reflects.
        reflected: Rgb,
        /// Its irradiance.
        irradiance: Rgb,
    },
}

impl Solution {
    /// Area mean of how much irradiance differs from that of `before`, over its area mean, in the worst channel.
    pub fn relative_change(&self, mesh: &Mesh, before: &Solution) -> f64 {
        let irradiance = |leaf: PatchId| [before, self].map(|solution| solution.irradiance[leaf].mean);
        relative_change(mesh, irradiance, |leaf| self.irradiance[leaf].mean)
    }

    /// Mean irradiance of the faces that show it, in W/m2; of all where none does.
    ///
    /// Emitters are drawn in their own colour: two that face each other may receive a thousand times what all else does.
    pub fn mean_irradiance(&self, mesh: &Mesh, shows_it: impl Fn(FaceId) -> bool) -> Rgb {
        let mean = |counts: &dyn Fn(FaceId) -> bool| {
            let (mut power, mut area_m2) = (Rgb::ZERO, 0.0);
            for leaf in mesh.leaves().filter(|&leaf| counts(mesh.patch(leaf).face)) {
                power += mesh.patch(leaf).area_m2 * self.irradiance[leaf].mean;
                area_m2 += mesh.patch(leaf).area_m2;
            }
            (area_m2 > 0.0).then(|| power / area_m2)
        };
        mean(&shows_it).or_else(|| mean(&|_| true)).unwrap_or_default()
    }

    /// Checks that light is finite and not negative.
    ///
    /// # Errors
    /// The first bad value.
    pub fn validate(&self) -> Result<(), SolutionError> {
        for (patch, (reflected, irradiance)) in self.reflected.keys().zip(self.reflected.iter().zip(&self.irradiance)) {
            let good = |light: Rgb| light.is_finite() && light.min_element() >= 0.0;
            let (reflected, irradiance) = (reflected.mean, irradiance.mean);
            if !good(reflected) || !good(irradiance) {
                return Err(SolutionError::BadLight { patch, reflected, irradiance });
            }
        }
        Ok(())
    }
}

/// Steps that progress is told in.
const STEPS: f64 = 1000.0;

/// Solves for the radiosity of every patch.
///
/// # Errors
/// [`Cancelled`] where `progress` asks to stop.
pub fn solve(
    mesh: &Mesh,
    surfaces: &Surfaces,
    links: &Links,
    settings: SolveSettings,
    progress: Progress<'_>,
) -> Result<Solution, Cancelled> {
    let nothing = Table::from(vec![Linear::default(); mesh.patch_count()]);
    let (mut irradiance, mut reflected) = push_pull(mesh, surfaces, nothing);
    let (mut residual, mut iterations) = (1.0, 0);
    while residual > settings.max_residual && iterations < settings.max_iterations {
        let share = progress::share_of_way(residual, settings.max_residual);
        progress.report(Stage::Solve, (STEPS * share) as usize, STEPS as usize)?;
        let bounced = push_pull(mesh, surfaces, gather(links, &reflected));
        let changing = |leaf: PatchId| [&reflected, &bounced.1].map(|moments| moments[leaf].mean);
        residual = relative_change(mesh, changing, |leaf| surfaces.exitance[leaf] + bounced.1[leaf].mean);
        (irradiance, reflected) = bounced;
        iterations += 1;
    }
    tracing::debug!(iterations, residual, "solved");
    let reflected = reflected.iter_enumerated().map(|(id, node)| linear(surfaces, id, node)).collect();
    Ok(Solution { reflected, irradiance, residual, iterations })
}

/// The linear function with given moments.
pub(super) fn linear(surfaces: &Surfaces, patch: PatchId, moments: &RadiosityMoments) -> Linear<Rgb> {
    let inverse = surfaces.second_moment_m2[patch].inverse();
    if !inverse.is_finite() {
        return Linear { mean: moments.mean, gradient: [Rgb::ZERO; 2] };
    }
    let row = |i: usize| inverse.col(0)[i] * moments.first[0] + inverse.col(1)[i] * moments.first[1];
    Linear { mean: moments.mean, gradient: [row(0), row(1)] }
}

/// Area mean of what changes, `[before, after]`, over the area mean of light, in the worst channel.
fn relative_change(mesh: &Mesh, changing: impl Fn(PatchId) -> [Rgb; 2], light: impl Fn(PatchId) -> Rgb) -> f64 {
    let (mut change, mut whole) = (Rgb::ZERO, Rgb::ZERO);
    for leaf in mesh.leaves() {
        let area_m2 = mesh.patch(leaf).area_m2;
        let [before, after] = changing(leaf);
        change += area_m2 * (after - before).abs();
        whole += area_m2 * light(leaf);
    }
    worst_share(change, whole)
}

/// The greatest share of the three colours; a colour without light has none.
fn worst_share(part: Rgb, whole: Rgb) -> f64 {
    (0..3).filter(|&channel| whole[channel] > 0.0).map(|channel| part[channel] / whole[channel]).fold(0.0, f64::max)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::MeshSettings;
    use crate::prepare::Prepared;
    use crate::scene::{Material, Scene};
    use crate::transport::{DirectLight, FormFactorOracle, link_all};
    use crate::visibility::{Visibility, fixture};
    use glam::DVec3;

    fn solved(scene: &Scene, prepared: &Prepared, f_max: f64, settings: SolveSettings) -> (Mesh, Surfaces, Solution) {
        let mut mesh = Mesh::new(prepared, &Table::new(), MeshSettings::default());
        let coplanar_m = prepared.tolerance.coplanar_m();
        let oracle = FormFactorOracle { max_form_factor: f_max, min_area_m2: 0.002, coplanar_m };
        let index = Visibility::new(prepared);
        let links = link_all(prepared, &index, &mut mesh, &oracle, Progress::silent()).unwrap();
        let surfaces = Surfaces::new(scene, prepared, &mesh, &DirectLight::new(scene, prepared, &index));
        let solution = solve(&mesh, &surfaces, &links, settings, Progress::silent()).unwrap();
        solution.validate().unwrap();
        (mesh, surfaces, solution)
    }

    fn mean_over_leaves(mesh: &Mesh, value: impl Fn(PatchId) -> f64) -> f64 {
        let area = |leaf: PatchId| mesh.patch(leaf).area_m2;
        mesh.leaves().map(|leaf| area(leaf) * value(leaf)).sum::<f64>() / mesh.leaves().map(area).sum::<f64>()
    }

    fn glowing(reflectance: f64) -> Material {
        let radiance = Rgb::ONE / std::f64::consts::PI;
        Material { reflectance: Rgb::splat(reflectance), ..Material::emitting("glow", radiance) }
    }

    #[test]
    fn a_furnace_has_radiosity_two_everywhere() {
        let prepared = fixture::prepared(&fixture::inward_box(DVec3::ZERO, DVec3::ONE));
        let scene = fixture::scene(vec![glowing(0.5)]);
        let (mesh, surfaces, solution) =
            solved(&scene, &prepared, 0.02, SolveSettings { max_residual: 1e-7, max_iterations: 99 });
        let radiosity = |leaf: PatchId| surfaces.exitance[leaf].x + solution.reflected[leaf].mean.x;
        let mean = mean_over_leaves(&mesh, radiosity);
        assert!((mean - 2.0).abs() < 1e-3, "area mean {mean}");
        let rms = mean_over_leaves(&mesh, |leaf| (radiosity(leaf) - 2.0).powi(2)).sqrt() / 2.0;
        assert!(rms < 0.02, "rms {rms}");
    }

    #[test]
    fn a_furnace_with_all_links_on_one_level_is_exact() {
        // Every wall is linked to every other as a whole: rows sum to 1 without being made to.
        let prepared = fixture::prepared(&fixture::inward_box(DVec3::ZERO, DVec3::ONE));
        let scene = fixture::scene(vec![glowing(0.5)]);
        let (mesh, surfaces, solution) =
            solved(&scene, &prepared, 1.0, SolveSettings { max_residual: 1e-9, max_iterations: 99 });
        assert_eq!(mesh.patch_count(), 6);
        for leaf in mesh.leaves() {
            let radiosity = surfaces.exitance[leaf].x + solution.reflected[leaf].mean.x;
            assert!((radiosity / 2.0 - 1.0).abs() < 1e-6, "{radiosity}");
        }
    }

    #[test]
    fn what_is_emitted_is_absorbed() {
        let walls = fixture::inward_box(DVec3::ZERO, DVec3::new(1.0, 1.0, 2.0));
        let polygons: Vec<_> = walls.into_iter().enumerate().map(|(i, wall)| (wall, usize::from(i == 1))).collect();
        let prepared = fixture::prepared_of_materials(&polygons);
        let grey = Material::diffuse("grey", Rgb::new(0.7, 0.5, 0.2));
        let scene = fixture::scene(vec![grey, Material::emitting("lamp", Rgb::ONE)]);
        let (mesh, surfaces, solution) =
            solved(&scene, &prepared, 0.02, SolveSettings { max_residual: 1e-7, max_iterations: 99 });
        for channel in 0..3 {
            let emitted = mean_over_leaves(&mesh, |leaf| surfaces.exitance[leaf][channel]);
            let absorbed = mean_over_leaves(&mesh, |leaf| {
                (1.0 - surfaces.reflectance[leaf][channel]) * solution.irradiance[leaf].mean[channel]
            });
            assert!((absorbed / emitted - 1.0).abs() < 5e-3, "{absorbed} of {emitted} in channel {channel}");
        }
    }

    #[test]
    fn the_residual_is_reached_and_told() {
        let prepared = fixture::prepared(&fixture::inward_box(DVec3::ZERO, DVec3::ONE));
        let scene = fixture::scene(vec![glowing(0.5)]);
        let (_, _, solution) = solved(&scene, &prepared, 1.0, SolveSettings::default());
        assert!(solution.residual <= 1e-4 && solution.iterations > 5);
        let (_, _, early) = solved(&scene, &prepared, 1.0, SolveSettings { max_iterations: 3, ..Default::default() });
        assert!(early.residual > 1e-4 && early.iterations == 3);
    }

    #[test]
    fn the_number_of_threads_does_not_matter() {
        let prepared = fixture::prepared(&fixture::inward_box(DVec3::ZERO, DVec3::new(1.0, 2.0, 3.0)));
        let scene = fixture::scene(vec![glowing(0.8)]);
        let of_threads = |threads: usize| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            pool.install(|| solved(&scene, &prepared, 0.1, SolveSettings::default()).2)
        };
        assert_eq!(of_threads(1), of_threads(2));
    }
}
