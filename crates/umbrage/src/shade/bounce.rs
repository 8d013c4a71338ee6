//! One exact bounce: what links miss, found by gathering at a few points of every leaf with exact visibility.
//!
//! Links are linear over their receivers, which may be large, and rays tell what stands between their ends. What the leaves
//! reflect errs by that, in one direction over whole regions. So the solution `B` of the links' equation `B = rho (D + F B)`
//! is put into the exact one, and what each leaf then receives more, `d = D + G B - (D + F B)`, is handed back to be solved
//! with: `B = rho (D + d + F B)`. What is left is the error that links make about the correction alone (defect correction:
//! Stetter, *The defect correction principle and discretization methods*, 1978). Gathering is linear, so a later bounce
//! gathers the change alone, in which nearly every source is weak.

use glam::DVec2;
use rayon::prelude::*;

use super::field::{Field, Places, Values};
use super::irradiance::{Indirect, Irradiance};
use crate::id::{PatchId, Table};
use crate::mesh::Mesh;
use crate::prepare::Prepared;
use crate::progress::{Cancelled, Progress, Stage};
use crate::scene::Rgb;
use crate::solve::{Solution, Surfaces};
use crate::transport::Linear;
use crate::visibility::Visibility;

/// Leaves between two reports of progress.
const LEAVES_A_REPORT: usize = 256;
/// Bounces go on until the next would change the light by less than this share of it, if changes go on falling as they do.
const UNBOUNCED: f64 = 1e-5;

/// Solves for what leaves exactly receive of what they reflect. `solve` solves for what links bring them, and what these miss
/// is added to [`Surfaces::missed`] by each bounce.
///
/// # Errors
/// [`Cancelled`] where the progress callback asks to stop.
pub fn bounce(
    prepared: &Prepared,
    visibility: &Visibility,
    mesh: &Mesh,
    surfaces: &mut Surfaces,
    solve: impl Fn(&Surfaces) -> Result<Solution, Cancelled>,
    progress: Progress<'_>,
) -> Result<Solution, Cancelled> {
    let mut solution = solve(surfaces)?;
    let mean = solution.mean_irradiance(mesh);
    let places = Places::new(prepared);
    let mut gathered: Table<PatchId, Linear<Rgb>> = vec![Linear::default(); mesh.patch_count()].into();
    let mut not_gathered = solution.reflected.clone();
    let (mut before, mut change) = (1.0, 1.0);
    while change * change > UNBOUNCED * before {
        let light = Irradiance::new(prepared, visibility, mesh, &not_gathered, mean);
        let light = if change < 1.0 { light.of_change() } else { light };
        add_gathered(mesh, &places, &mut gathered, &light, progress)?;
        for leaf in mesh.leaves() {
            let exactly = surfaces.direct[leaf] + gathered[leaf];
            surfaces.missed[leaf] = surfaces.missed[leaf] + exactly - solution.irradiance[leaf];
        }
        let bounced = solve(surfaces)?;
        (before, change) = (change, bounced.relative_change(mesh, &solution).min(0.5 * change));
        not_gathered =
            bounced.reflected.iter().zip(&solution.reflected).map(|(&after, &before)| after - before).collect();
        solution = bounced;
    }
    Ok(solution)
}

/// Adds to `gathered` what each leaf receives of the light that `reflected` evaluates: of a change of light its own change, so
/// that a second bounce, which changes little, is found by few rays.
///
/// # Errors
/// [`Cancelled`] where the progress callback asks to stop.
fn add_gathered(
    mesh: &Mesh,
    places: &Places<'_>,
    gathered: &mut Table<PatchId, Linear<Rgb>>,
    reflected: &Irradiance<'_>,
    progress: Progress<'_>,
) -> Result<(), Cancelled> {
    let light = Indirect(reflected);
    let leaves: Vec<PatchId> = mesh.leaves().collect();
    let corners =
        leaves.iter().flat_map(|&leaf| mesh.corners(leaf).map(move |corner| places.vertex(mesh, leaf, corner)));
    let mut at_corners = Values::default();
    at_corners.evaluate(mesh, &light, corners.collect(), Stage::Solve, progress)?;
    let of_leaves: Vec<Linear<Rgb>> = leaves
        .par_iter()
        .enumerate()
        .map(|(number, &leaf)| {
            if number.is_multiple_of(LEAVES_A_REPORT) {
                progress.report(Stage::Solve, number, leaves.len())?;
            }
            let centroid_m = mesh.patch(leaf).centroid_m;
            let in_middle = light.at(mesh, &places.inside(mesh, leaf, centroid_m), leaf);
            let frame = mesh.frame(mesh.patch(leaf).face);
            let corners: Vec<(DVec2, Rgb)> = mesh
                .corners(leaf)
                .filter_map(|corner| {
                    let offset_m = frame.to_2d(mesh.vertex_m(corner)) - frame.to_2d(centroid_m);
                    Some((offset_m, at_corners.get(&places.vertex(mesh, leaf, corner).key)?))
                })
                .collect();
            Ok(over_leaf(in_middle, &corners))
        })
        .collect::<Result<_, Cancelled>>()?;
    for (leaf, more) in leaves.into_iter().zip(of_leaves) {
        gathered[leaf] = gathered[leaf] + more;
    }
    Ok(())
}

/// The linear function over a convex polygon whose mean is that of the field with a value in the centroid and values at the
/// corners, which are given by their offsets from the centroid: exact to degree 2 over triangles and to degree 3 over
/// parallelograms, where it is Simpson's rule.
fn over_leaf(in_middle: Rgb, corners: &[(DVec2, Rgb)]) -> Linear<Rgb> {
    let count = corners.len();
    let doubled_m2: Vec<f64> = (0..count).map(|i| corners[i].0.perp_dot(corners[(i + 1) % count].0)).collect();
    let whole_m2: f64 = doubled_m2.iter().sum();
    if whole_m2 <= 0.0 {
        return Linear { mean: in_middle, ..Linear::default() };
    }
    let weight = |i: usize| 0.5 * (doubled_m2[i] + doubled_m2[(i + count - 1) % count]) / whole_m2;
    let linear = Linear::fit(corners.iter().enumerate().map(|(i, &(offset_m, value))| (offset_m, weight(i), value)));
    // What is left of the field beside its slope is zero in the middle, and grows with the square of the distance.
    let beside = |&(offset_m, value): &(DVec2, Rgb)| value - in_middle - (linear.at(offset_m) - linear.mean);
    let at_corners: Rgb = corners.iter().enumerate().map(|(i, corner)| weight(i) * beside(corner)).sum();
    let square_m2 = |i: usize| {
        let (p, q) = (corners[i].0, corners[(i + 1) % count].0);
        doubled_m2[i] / whole_m2 * (p.dot(p) + p.dot(q) + q.dot(q)) / 6.0
    };
    let over_area_m2: f64 = (0..count).map(square_m2).sum();
    let over_corners_m2: f64 = (0..count).map(|i| weight(i) * corners[i].0.length_squared()).sum();
    Linear { mean: in_middle + over_area_m2 / over_corners_m2 * at_corners, ..linear }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::MeshSettings;
    use crate::scene::Material;
    use crate::solve::{SolveSettings, solve};
    use crate::transport::{DirectLight, FormFactorOracle, link_all};
    use crate::visibility::fixture;
    use glam::DVec3;
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
        let error = |solution: &Solution| {
            let squared = |leaf| mesh.patch(leaf).area_m2 * (solution.irradiance[leaf].mean.x - 2.0).powi(2);
            let area_m2: f64 = mesh.leaves().map(|leaf| mesh.patch(leaf).area_m2).sum();
            (mesh.leaves().map(squared).sum::<f64>() / area_m2).sqrt() / 2.0
        };
        let solved = |surfaces: &Surfaces| solve(&mesh, surfaces, &links, settings, Progress::silent());
        let linked = solved(&surfaces).unwrap();
        let bounced = bounce(&prepared, &index, &mesh, &mut surfaces, solved, Progress::silent()).unwrap();
        let errors = [&linked, &bounced].map(error);
        // What stays, however often light bounces, is what a few rays err about weak patches behind the box.
        assert!(errors[1] < 0.2 * errors[0] && errors[1] < 0.01, "{errors:?}");
    }

    #[test]
    fn the_mean_over_a_leaf_is_exact_to_its_degree() {
        let field = |p: DVec2| Rgb::splat(3.0 + p.x - 2.0 * p.y + p.x * p.x - 3.0 * p.x * p.y + 0.5 * p.y * p.y);
        let corners =
            |points: &[(f64, f64)]| points.iter().map(|&p| (DVec2::from(p), field(p.into()))).collect::<Vec<_>>();
        // Integrals of the squares by hand: a parallelogram with the half sides (2, 1) and (0, 1), and a triangle.
        let parallelogram = over_leaf(Rgb::splat(3.0), &corners(&[(-2.0, -2.0), (2.0, 0.0), (2.0, 2.0), (-2.0, 0.0)]));
        assert!((parallelogram.mean.x - (3.0 + 4.0 / 3.0 - 3.0 * 2.0 / 3.0 + 0.5 * 2.0 / 3.0)).abs() < 1e-12);
        let triangle = over_leaf(Rgb::splat(3.0), &corners(&[(-1.0, -1.0), (2.0, -1.0), (-1.0, 2.0)]));
        assert!((triangle.mean.x - (3.0 + 0.5 + 3.0 * 0.25 + 0.5 * 0.5)).abs() < 1e-12);
        assert!(over_leaf(Rgb::ONE, &corners(&[(0.0, 0.0), (0.0, 0.0), (0.0, 0.0)])).mean == Rgb::ONE);
    }
}
