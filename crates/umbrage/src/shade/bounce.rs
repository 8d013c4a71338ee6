//! One exact bounce: what links miss, found by gathering at a few points of every leaf with exact visibility.
//!
//! Links are linear over their receivers, which may be large, and rays tell what stands between their ends. What the leaves
//! reflect errs by that, in one direction over whole regions. So the solution `B` of the links' equation `B = rho (D + F B)`
//! is put into the exact one, and what each leaf then receives more, `d = D + G B - (D + F B)`, is handed back to be solved
//! with: `B = rho (D + d + F B)`. What is left is the error that links make about the correction alone (defect correction:
//! Stetter, *The defect correction principle and discretization methods*, 1978).

use glam::DVec3;
use rayon::prelude::*;

use super::Irradiance;
use crate::id::PatchId;
use crate::mesh::Mesh;
use crate::prepare::Prepared;
use crate::progress::{Cancelled, Progress, Stage};
use crate::scene::Rgb;
use crate::solve::{Solution, Surfaces};
use crate::transport::Linear;
use crate::visibility::ReceiverPoint;

/// How far from its corners towards its middle a triangle is looked at: the mean of these points is exact to degree 2.
const INWARD_IN_TRIANGLE: f64 = 0.5;
/// And other patches: exact to degree 3 in a rectangle, where these are Gauss's points.
const INWARD: f64 = 0.422_649_730_810_374_2;
/// Leaves between two reports of progress.
const LEAVES_A_REPORT: usize = 256;

/// Adds to [`Surfaces::missed`] the irradiance that links miss of every leaf, by one bounce of `solution`, whose light
/// `irradiance` evaluates.
///
/// # Errors
/// [`Cancelled`] where the progress callback asks to stop.
pub fn add_missed_by_links(
    prepared: &Prepared,
    mesh: &Mesh,
    surfaces: &mut Surfaces,
    irradiance: &Irradiance<'_>,
    solution: &Solution,
    progress: Progress<'_>,
) -> Result<(), Cancelled> {
    let leaves: Vec<PatchId> = mesh.leaves().collect();
    let missed = leaves
        .par_iter()
        .enumerate()
        .map(|(number, &leaf)| {
            if number.is_multiple_of(LEAVES_A_REPORT) {
                progress.report(Stage::Solve, number, leaves.len())?;
            }
            Ok(surfaces.direct[leaf] + gathered(prepared, mesh, irradiance, leaf) - solution.irradiance[leaf])
        })
        .collect::<Result<Vec<Linear<Rgb>>, Cancelled>>()?;
    for (leaf, missed) in leaves.into_iter().zip(missed) {
        surfaces.missed[leaf] = surfaces.missed[leaf] + missed;
    }
    Ok(())
}

/// The linear fit to the reflected irradiance of a leaf.
fn gathered(prepared: &Prepared, mesh: &Mesh, irradiance: &Irradiance<'_>, leaf: PatchId) -> Linear<Rgb> {
    let patch = mesh.patch(leaf);
    let (frame, corners_m) = (mesh.frame(patch.face), mesh.polygon_m(leaf));
    let inward = if corners_m.len() == 3 { INWARD_IN_TRIANGLE } else { INWARD };
    let points_m: Vec<DVec3> = corners_m.iter().map(|corner| corner.lerp(patch.centroid_m, inward)).collect();
    let weight = 1.0 / points_m.len() as f64;
    let middle_m: DVec3 = points_m.iter().map(|&point_m| weight * point_m).sum();
    let around_middle = Linear::fit(points_m.iter().map(|&point_m| {
        let receiver = ReceiverPoint::on_face(prepared, patch.face, point_m);
        (frame.to_2d(point_m) - frame.to_2d(middle_m), weight, irradiance.indirect(&receiver))
    }));
    Linear { mean: around_middle.at(frame.to_2d(patch.centroid_m) - frame.to_2d(middle_m)), ..around_middle }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::id::Table;
    use crate::mesh::MeshSettings;
    use crate::scene::Material;
    use crate::solve::{SolveSettings, solve};
    use crate::transport::{DirectLight, FormFactorOracle, link_all};
    use crate::visibility::{Visibility, fixture};
    use std::f64::consts::PI;

    #[test]
    fn a_furnished_furnace_is_even_once_what_links_miss_is_known() {
        // Everything emits 1 and reflects a half: irradiance is 2 everywhere.
        let glow = Material { reflectance: Rgb::splat(0.5), ..Material::emitting("glow", Rgb::ONE / PI) };
        let mut room = fixture::inward_box(DVec3::ZERO, DVec3::new(2.0, 1.5, 1.0));
        room.extend(fixture::outward_box(DVec3::new(0.5, 0.5, 0.25), DVec3::new(1.0, 1.0, 0.75)));
        let polygons: Vec<_> = room.into_iter().map(|polygon| (polygon, 0)).collect();
        let (prepared, scene) = (fixture::prepared_of_materials(&polygons), fixture::scene(vec![glow]));
        let index = Visibility::new(&prepared);
        let mut mesh = Mesh::new(&prepared, &Table::new(), MeshSettings::default());
        let coplanar_m = prepared.tolerance.coplanar_m();
        let oracle = FormFactorOracle { max_form_factor: 0.1, min_area_m2: 0.02, coplanar_m };
        let links = link_all(&prepared, &index, &mut mesh, &oracle, Progress::silent()).unwrap();
        let direct = DirectLight::new(&scene, &prepared, &index);
        let mut surfaces = Surfaces::new(&scene, &prepared, &mesh, &direct);
        let settings = SolveSettings { max_residual: 1e-7, max_iterations: 99 };
        let solved = |surfaces: &Surfaces| solve(&mesh, surfaces, &links, settings, Progress::silent()).unwrap();
        let error = |solution: &Solution| {
            let squared = |leaf| mesh.patch(leaf).area_m2 * (solution.irradiance[leaf].mean.x - 2.0).powi(2);
            let area_m2: f64 = mesh.leaves().map(|leaf| mesh.patch(leaf).area_m2).sum();
            (mesh.leaves().map(squared).sum::<f64>() / area_m2).sqrt() / 2.0
        };
        let mut solution = solved(&surfaces);
        let mut errors = vec![error(&solution)];
        for _ in 0..2 {
            let light = Irradiance::new(&prepared, &index, &mesh, &direct, &solution);
            add_missed_by_links(&prepared, &mesh, &mut surfaces, &light, &solution, Progress::silent()).unwrap();
            solution = solved(&surfaces);
            errors.push(error(&solution));
        }
        // What stays, however often light bounces, is what a few rays err about weak patches behind the box.
        assert!(errors[1] < 0.2 * errors[0] && errors[2] < 0.01, "{errors:?}");
    }
}
