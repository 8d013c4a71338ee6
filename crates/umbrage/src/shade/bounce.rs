//! One exact bounce: gathers once more at the middle of every leaf, with exact visibility.
//!
//! Links are linear over their receivers, which may be large, and rays tell what stands between their ends. What the leaves
//! reflect errs by that, in one direction over whole regions. A bounce through [`Irradiance`] leaves of these errors only
//! what a further reflection makes of them.

use rayon::prelude::*;

use super::Irradiance;
use crate::id::PatchId;
use crate::mesh::Mesh;
use crate::prepare::Prepared;
use crate::progress::{Cancelled, Progress, Stage};
use crate::scene::Rgb;
use crate::solve::{Solution, Surfaces};
use crate::visibility::ReceiverPoint;

/// Leaves between two reports of progress.
const LEAVES_A_REPORT: usize = 256;

/// The solution with what its leaves reflect after one more bounce. Gradients are kept.
///
/// # Errors
/// [`Cancelled`] where the progress callback asks to stop.
pub fn bounce(
    prepared: &Prepared,
    mesh: &Mesh,
    surfaces: &Surfaces,
    irradiance: &Irradiance<'_>,
    mut solution: Solution,
    progress: Progress<'_>,
) -> Result<Solution, Cancelled> {
    let leaves: Vec<PatchId> = mesh.leaves().collect();
    let gathered = leaves
        .par_iter()
        .enumerate()
        .map(|(number, &leaf)| {
            if number.is_multiple_of(LEAVES_A_REPORT) {
                progress.report(Stage::Solve, number, leaves.len())?;
            }
            let patch = mesh.patch(leaf);
            let receiver = ReceiverPoint::on_face(prepared, patch.face, patch.centroid_m);
            Ok(surfaces.direct[leaf].mean + irradiance.indirect(&receiver, patch.face))
        })
        .collect::<Result<Vec<Rgb>, Cancelled>>()?;
    for (&leaf, light) in leaves.iter().zip(gathered) {
        solution.irradiance[leaf] = light;
        solution.reflected[leaf].mean = surfaces.reflectance[leaf] * light;
    }
    for index in (0..mesh.patch_count()).rev() {
        let patch = PatchId::from(index);
        if let Some(parts) = mesh.patch(patch).subpatches {
            let areas_m2 = parts.map(|part| mesh.patch(part).area_m2.max(0.0));
            let share = if areas_m2[0] + areas_m2[1] > 0.0 { areas_m2[0] / (areas_m2[0] + areas_m2[1]) } else { 0.5 };
            let mean = |of: &dyn Fn(PatchId) -> Rgb| share * of(parts[0]) + (1.0 - share) * of(parts[1]);
            solution.irradiance[patch] = mean(&|part| solution.irradiance[part]);
            solution.reflected[patch].mean = mean(&|part| solution.reflected[part].mean);
        }
    }
    Ok(solution)
}
