//! One exact bounce: what links miss, found by gathering at a few points of every leaf with exact visibility.
//!
//! Links are linear over their receivers, which may be large, and rays tell what stands between their ends. What the leaves
//! reflect errs by that, in one direction over whole regions. So the solution `B` of the links' equation `B = rho (D + F B)`
//! is put into the exact one, and what each leaf then receives more, `d = D + G B - (D + F B)`, is handed back to be solved
//! with: `B = rho (D + d + F B)`. What is left is the error that links make about the correction alone (defect correction:
//! Stetter, *The defect correction principle and discretization methods*, 1978). What a point sees of which patch is found once,
//! and kept as the terms of a sum; so later bounces cost next to nothing.

use glam::DVec2;
use rayon::prelude::*;
use smallvec::SmallVec;

use super::field::{Places, distinct};
use super::irradiance::{Irradiance, Terms};
use crate::id::{PatchId, Table};
use crate::mesh::Mesh;
use crate::prepare::Prepared;
use crate::progress::{Cancelled, Progress, Stage};
use crate::scene::Rgb;
use crate::solve::{Solution, Surfaces};
use crate::transport::Linear;
use crate::visibility::{AtPoints, Memory, Notes, ReceiverPoint, Visibility};

/// Points between two reports of progress.
const POINTS_A_REPORT: usize = 16;
/// Bounces go on until one changes the light by less than this share of it.
const UNBOUNCED: f64 = 1e-5;
/// What is seen of which patch is looked at as closely as that patch reflects; and anew where the light changes by more than
/// this share of it.
const LIKE: f64 = 0.2;
/// But no more often than that.
const MOST_GATHERINGS: usize = 3;
/// Bounces that may follow one gathering: each leaves a small part of the change that the one before
/// made.
const MOST_BOUNCES: usize = 30;

/// Solves for what leaves exactly receive of what they reflect. `solve` solves for what links bring them, and what these miss
/// is added to [`Surfaces::missed`] by each bounce. Where `notes` are given, the terms of the last gathering are in them.
///
/// # Errors
/// [`Cancelled`] where the progress callback asks to stop.
pub fn bounce(
    prepared: &Prepared,
    visibility: &Visibility,
    mesh: &Mesh,
    surfaces: &mut Surfaces,
    solve: impl Fn(&Surfaces) -> Result<Solution, Cancelled>,
    notes: Option<&Notes<Terms>>,
    progress: Progress<'_>,
) -> Result<Solution, Cancelled> {
    let mut solution = solve(surfaces)?;
    let places = Places::new(prepared);
    for _ in 0..MOST_GATHERINGS {
        let looked_at = solution.clone();
        let memory = notes.map_or(Memory::None, |notes| {
            notes.clear();
            Memory::Noting(notes)
        });
        let light = Irradiance::new(prepared, visibility, mesh, &looked_at.reflected, looked_at.mean_irradiance(mesh))
            .with_memory(memory);
        let bounced_light = BouncedLight::gather(mesh, &places, &light, progress)?;
        solution = bounced_light.settled(mesh, &light, surfaces, &solve, solution)?;
        let change = solution.relative_change(mesh, &looked_at);
        tracing::debug!(change, "gathered");
        if change < LIKE {
            break;
        }
    }
    Ok(solution)
}

/// The same for a scene whose light changed, from the terms that were noted at the last gathering before. Points that are not known
/// are gathered at.
///
/// # Errors
/// [`Cancelled`] where the progress callback asks to stop.
pub fn bounce_again(
    prepared: &Prepared,
    visibility: &Visibility,
    mesh: &Mesh,
    surfaces: &mut Surfaces,
    solve: impl Fn(&Surfaces) -> Result<Solution, Cancelled>,
    known: &AtPoints<Terms>,
    progress: Progress<'_>,
) -> Result<Solution, Cancelled> {
    let solution = solve(surfaces)?;
    let looked_at = solution.clone();
    let light = Irradiance::new(prepared, visibility, mesh, &looked_at.reflected, looked_at.mean_irradiance(mesh))
        .with_memory(Memory::Known(known));
    let bounced_light = BouncedLight::gather(mesh, &Places::new(prepared), &light, progress)?;
    bounced_light.settled(mesh, &light, surfaces, &solve, solution)
}

/// What every leaf receives of what all patches reflect, as sums of terms at its corners and in its middle: what is seen does not
/// change with the light.
struct BouncedLight {
    leaves: Vec<BouncedLeaf>,
    /// Of the corners, each once.
    at_corners: Vec<Terms>,
}

struct BouncedLeaf {
    patch: PatchId,
    /// Offsets of the corners from the centroid, in metres, and their numbers.
    corners: SmallVec<[(DVec2, u32); 4]>,
    in_middle: Terms,
}

impl BouncedLight {
    /// # Errors
    /// [`Cancelled`] where the progress callback asks to stop.
    fn gather(
        mesh: &Mesh,
        places: &Places<'_>,
        light: &Irradiance<'_>,
        progress: Progress<'_>,
    ) -> Result<Self, Cancelled> {
        let patches: Vec<PatchId> = mesh.leaves().collect();
        let requests =
            patches.iter().flat_map(|&leaf| mesh.corners(leaf).map(move |corner| places.vertex(mesh, leaf, corner)));
        let corners = distinct(requests.collect());
        let count = corners.len() + patches.len();
        let terms = |number: usize, point: &ReceiverPoint| {
            if number.is_multiple_of(POINTS_A_REPORT) {
                progress.report(Stage::Solve, number, count)?;
            }
            Ok(light.terms(point))
        };
        let at_corners = corners
            .par_iter()
            .enumerate()
            .map(|(number, corner)| terms(number, &corner.point))
            .collect::<Result<_, Cancelled>>()?;
        let leaf = |(number, &patch): (usize, &PatchId)| {
            let centroid_m = mesh.patch(patch).centroid_m;
            let frame = mesh.frame(mesh.patch(patch).face);
            let corner = |vertex| {
                let key = places.vertex(mesh, patch, vertex).key;
                let number = corners.binary_search_by_key(&key, |corner| corner.key).ok()?;
                Some((frame.to_2d(mesh.vertex_m(vertex)) - frame.to_2d(centroid_m), number as u32))
            };
            Ok(BouncedLeaf {
                patch,
                corners: mesh.corners(patch).filter_map(corner).collect(),
                in_middle: terms(corners.len() + number, &places.inside(mesh, patch, centroid_m))?,
            })
        };
        let leaves = patches.par_iter().enumerate().map(leaf).collect::<Result<_, Cancelled>>()?;
        Ok(Self { leaves, at_corners })
    }

    /// Bounces until light changes no more.
    fn settled(
        &self,
        mesh: &Mesh,
        light: &Irradiance<'_>,
        surfaces: &mut Surfaces,
        solve: &impl Fn(&Surfaces) -> Result<Solution, Cancelled>,
        mut solution: Solution,
    ) -> Result<Solution, Cancelled> {
        for _ in 0..MOST_BOUNCES {
            let gathered = self.over_leaves(light, &solution.reflected);
            for (leaf, gathered) in self.leaves.iter().zip(gathered) {
                let exactly = surfaces.direct[leaf.patch] + gathered;
                surfaces.missed[leaf.patch] = surfaces.missed[leaf.patch] + exactly - solution.irradiance[leaf.patch];
            }
            let bounced = solve(surfaces)?;
            let change = bounced.relative_change(mesh, &solution);
            solution = bounced;
            tracing::debug!(change, "bounced");
            if change < UNBOUNCED {
                break;
            }
        }
        Ok(solution)
    }

    /// Irradiance of the leaves where patches reflect `radiosity`, in W/m2.
    fn over_leaves(&self, light: &Irradiance<'_>, radiosity: &Table<PatchId, Linear<Rgb>>) -> Vec<Linear<Rgb>> {
        let crowds = light.crowds_of(radiosity);
        let sum = |terms: &Terms| terms.sum(radiosity, &crowds);
        let at_corners: Vec<Rgb> = self.at_corners.par_iter().map(sum).collect();
        let over = |leaf: &BouncedLeaf| {
            let corners: SmallVec<[(DVec2, Rgb); 4]> =
                leaf.corners.iter().map(|&(offset_m, number)| (offset_m, at_corners[number as usize])).collect();
            over_leaf(sum(&leaf.in_middle), &corners)
        };
        self.leaves.par_iter().map(over).collect()
    }
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
        let bounced = bounce(&prepared, &index, &mesh, &mut surfaces, solved, None, Progress::silent()).unwrap();
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
