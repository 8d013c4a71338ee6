//! Iterations to a stated residual: `B <- M + rho F B` from `B = M`, each one a bounce of light (Jacobi).
//!
//! The residual is the area mean of what a bounce changes, relative to the area mean of radiosity, in the worst channel.
//! What is still missing is at most the residual times `rho / (1 - rho)`. Sums run over leaves in the order of their
//! numbers: the same bits come out whatever the number of threads.

use super::gather::gather;
use super::push_pull::{Surfaces, push_pull};
use crate::id::{PatchId, Table};
use crate::mesh::Mesh;
use crate::progress::{Cancelled, Progress, Stage};
use crate::scene::Rgb;
use crate::transport::Links;

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
        Self { max_residual: 1e-4, max_iterations: 200 }
    }
}

/// Light of every node of the hierarchy.
#[derive(Clone, Debug, PartialEq)]
pub struct Solution {
    /// Radiosity `B` of each patch, in W/m2: its area mean.
    pub radiosity: Table<PatchId, Rgb>,
    /// Irradiance `E` of each patch, in W/m2: its area mean.
    pub irradiance: Table<PatchId, Rgb>,
    /// Relative residual that was reached.
    pub residual: f64,
    /// Iterations that it took.
    pub iterations: usize,
}

/// A broken promise of [`Solution`]: always a defect of this library.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum SolutionError {
    /// A value is negative, NaN or infinite.
    #[error("{patch:?} has radiosity {radiosity} and irradiance {irradiance}")]
    BadLight {
        /// The patch.
        patch: PatchId,
        /// Its radiosity.
        radiosity: Rgb,
        /// Its irradiance.
        irradiance: Rgb,
    },
}

impl Solution {
    /// Checks that light is finite and not negative.
    ///
    /// # Errors
    /// The first bad value.
    pub fn validate(&self) -> Result<(), SolutionError> {
        for (patch, (&radiosity, &irradiance)) in self.radiosity.keys().zip(self.radiosity.iter().zip(&self.irradiance))
        {
            let good = |light: Rgb| light.is_finite() && light.min_element() >= 0.0;
            if !good(radiosity) || !good(irradiance) {
                return Err(SolutionError::BadLight { patch, radiosity, irradiance });
            }
        }
        Ok(())
    }
}

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
    let nothing = Table::from(vec![Rgb::ZERO; mesh.patch_count()]);
    let (irradiance, radiosity) = push_pull(mesh, surfaces, nothing);
    let mut solution = Solution { radiosity, irradiance, residual: 1.0, iterations: 0 };
    while solution.residual > settings.max_residual && solution.iterations < settings.max_iterations {
        progress.report(Stage::Solve, solution.iterations, 0)?;
        let (irradiance, radiosity) = push_pull(mesh, surfaces, gather(links, &solution.radiosity));
        solution.residual = relative_change(mesh, &solution.radiosity, &radiosity);
        (solution.irradiance, solution.radiosity) = (irradiance, radiosity);
        solution.iterations += 1;
    }
    tracing::debug!(iterations = solution.iterations, residual = solution.residual, "solved");
    Ok(solution)
}

/// Area mean of the change of radiosity over the area mean of radiosity, in the worst channel.
fn relative_change(mesh: &Mesh, before: &Table<PatchId, Rgb>, after: &Table<PatchId, Rgb>) -> f64 {
    let (mut change, mut light) = (Rgb::ZERO, Rgb::ZERO);
    for leaf in mesh.leaves() {
        let area_m2 = mesh.patch(leaf).area_m2;
        change += area_m2 * (after[leaf] - before[leaf]).abs();
        light += area_m2 * after[leaf];
    }
    (0..3).filter(|&channel| light[channel] > 0.0).map(|channel| change[channel] / light[channel]).fold(0.0, f64::max)
}
