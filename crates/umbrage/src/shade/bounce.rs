//! One exact bounce: what links miss, found by gathering at the middle of every leaf with exact visibility.
//!
//! Links are linear over their receivers, which may be large, and rays tell what stands between their ends. What the leaves
//! reflect errs by that, in one direction over whole regions. So the solution `B` of the links' equation `B = rho (D + F B)`
//! is put into the exact one, and what each leaf then receives more, `d = D + G B - (D + F B)`, is handed back to be solved
//! with: `B = rho (D + d + F B)`. What is left is the error that links make about the correction alone (defect correction:
//! Stetter, *The defect correction principle and discretization methods*, 1978).

use rayon::prelude::*;

use super::Irradiance;
use crate::id::{PatchId, Table};
use crate::mesh::Mesh;
use crate::prepare::Prepared;
use crate::progress::{Cancelled, Progress, Stage};
use crate::scene::Rgb;
use crate::solve::{Solution, Surfaces};
use crate::visibility::ReceiverPoint;

/// Patches between two reports of progress.
const LEAVES_A_REPORT: usize = 256;

/// The irradiance that links miss of every leaf, by one bounce of `solution`, whose light `irradiance` evaluates: what
/// [`Surfaces::missed`] wants; zero for patches that are split.
///
/// # Errors
/// [`Cancelled`] where the progress callback asks to stop.
pub fn missed_by_links(
    prepared: &Prepared,
    mesh: &Mesh,
    surfaces: &Surfaces,
    irradiance: &Irradiance<'_>,
    solution: &Solution,
    progress: Progress<'_>,
) -> Result<Table<PatchId, Rgb>, Cancelled> {
    let of = |number: usize| {
        let patch = mesh.patch(PatchId::from(number));
        if patch.subpatches.is_some() {
            return Ok(Rgb::ZERO);
        }
        if number.is_multiple_of(LEAVES_A_REPORT) {
            progress.report(Stage::Solve, number, mesh.patch_count())?;
        }
        let receiver = ReceiverPoint::on_face(prepared, patch.face, patch.centroid_m);
        let leaf = PatchId::from(number);
        Ok(surfaces.direct[leaf].mean + irradiance.indirect(&receiver) - solution.irradiance[leaf])
    };
    (0..mesh.patch_count()).into_par_iter().map(of).collect::<Result<Vec<Rgb>, Cancelled>>().map(Table::from)
}
