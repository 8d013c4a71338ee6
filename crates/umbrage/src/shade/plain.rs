//! Plain faces: those over which what the bounces found of indirect light is enough to show it.
//!
//! For the bounces light was gathered in the middle of every leaf, and at the corners of those where it mattered. A face that is one
//! leaf, and over which indirect light is so even, or which is so small, that interpolation between these points errs little of the
//! whole, needs no more: in a scene of many small faces that is most of them. The light over it is linear over the fan of triangles
//! around its middle; a corner where nothing was gathered has the mean of such faces around it that lie in one plane.
//!
//! After: what plain faces err is within a share of the tolerance, and on none of them is it much of its own light; points of their
//! corners that other faces share are known to these.

use std::collections::BTreeMap;

use rayon::prelude::*;

use super::field::{Field, MeshPoint, Places, Request, Values};
use super::irradiance::{Irradiance, Terms};
use super::refine::{LEAST_OF_ALL, OWN_TOLERANCES, least_within};
use crate::id::{FaceId, PatchId, Table, VertexId};
use crate::mesh::Mesh;
use crate::progress::{Cancelled, Progress, Stage};
use crate::scene::Rgb;
use crate::visibility::{AtPoints, ReceiverPoint};

/// The share of the squared error of indirect light that plain faces may take.
const SHARE: f64 = 0.5;
/// Between the middle and the corners a parabola departs from straight lines by about this share of how far its middle does.
const OF_MIDDLE: f64 = 0.5;
/// What five points do not tell of a field between them, as a share of how much they differ.
const OF_SPREAD: f64 = 0.1;

/// What bounces gathered, as a field; elsewhere light is gathered.
struct Bounced<'a> {
    light: &'a Irradiance<'a>,
    bounced: &'a AtPoints<Terms>,
}

impl Field for Bounced<'_> {
    fn at(&self, _: &Mesh, point: &ReceiverPoint, _: PatchId) -> Rgb {
        self.bounced.get(point).map_or_else(|| self.light.indirect(point), |terms| self.light.sum_of(terms))
    }
}

/// A face, as the points tell its light.
#[derive(Clone, Debug)]
pub(super) struct PlainFace {
    /// Its corners and their light, in W/m2.
    pub(super) corners: Vec<(VertexId, Rgb)>,
    /// That of its middle.
    pub(super) in_middle: Rgb,
}

impl PlainFace {
    fn mean(&self) -> Rgb {
        self.corners.iter().map(|corner| corner.1).sum::<Rgb>() / self.corners.len() as f64
    }

    /// About the mean square of what interpolation errs, over the three colours.
    fn error_squared(&self) -> f64 {
        let from_middle = OF_MIDDLE * (self.in_middle - self.mean());
        let least = self.corners.iter().fold(self.in_middle, |least, corner| least.min(corner.1));
        let most = self.corners.iter().fold(self.in_middle, |most, corner| most.max(corner.1));
        let spread = OF_SPREAD * (most - least);
        (from_middle * from_middle).max(spread * spread).element_sum() / 3.0
    }
}

/// The plain faces of a mesh that is not split yet, and what is known at the corners of all faces that are one leaf of the mesh that
/// light bounced on. `tolerance` is that of indirect light and `of_all` that of the whole, both in W/m2.
///
/// # Errors
/// [`Cancelled`] where the progress callback asks to stop.
pub(super) fn plain_faces(
    mesh: &Mesh,
    places: &Places<'_>,
    light: &Irradiance<'_>,
    bounced: &AtPoints<Terms>,
    [tolerance, of_all]: [f64; 2],
    progress: Progress<'_>,
) -> Result<(Table<FaceId, Option<PlainFace>>, Values), Cancelled> {
    let mut values = Values::default();
    let leaves: Vec<PatchId> = mesh.leaves().collect();
    let mut faces: Table<FaceId, Option<PlainFace>> = vec![None; leaves.len()].into();
    if !tolerance.is_finite() {
        return Ok((faces, values));
    }
    let whole: Vec<PatchId> =
        leaves.iter().copied().filter(|&leaf| light.mesh.patch(leaf).subpatches.is_none()).collect();
    let corners = |&leaf: &PatchId| mesh.corners(leaf).map(move |vertex| places.vertex(mesh, leaf, vertex));
    let known = |request: &Request| bounced.get(&request.point).is_some();
    let requests = whole.iter().flat_map(corners).filter(known).collect();
    values.evaluate(mesh, &Bounced { light, bounced }, requests, Stage::Shade, progress)?;
    let in_middle = |&leaf: &PatchId| {
        let terms = bounced.get(&places.inside(mesh, leaf, mesh.patch(leaf).centroid_m))?;
        Some((leaf, light.sum_of(terms)))
    };
    let middles: Vec<(PatchId, Rgb)> = whole.par_iter().filter_map(in_middle).collect();
    let mut around: BTreeMap<MeshPoint, (Rgb, f64)> = BTreeMap::new();
    for &(leaf, value) in &middles {
        for request in corners(&leaf).filter(|request| values.get(&request.key).is_none()) {
            let (sum, count) = around.entry(request.key).or_default();
            (*sum, *count) = (*sum + value, *count + 1.0);
        }
    }
    let face = |&(leaf, in_middle): &(PatchId, Rgb)| {
        let (mut corners, mut is_constant) = (Vec::new(), true);
        for vertex in mesh.corners(leaf) {
            let key = places.vertex_key(mesh, leaf, vertex);
            let known = values.get(&key);
            is_constant &= known.is_none();
            let mean = || around.get(&key).map(|(sum, count)| *sum / *count);
            corners.push((vertex, known.or_else(mean).unwrap_or(in_middle)));
        }
        (leaf, is_constant, PlainFace { corners, in_middle })
    };
    let looked_at: Vec<(PatchId, bool, PlainFace)> = middles.par_iter().map(face).collect();
    let area_m2 = |leaf: PatchId| mesh.patch(leaf).area_m2;
    let all_m2: f64 = leaves.iter().map(|&leaf| area_m2(leaf)).sum();
    let mut errors: Vec<(PatchId, f64)> = Vec::new();
    for (leaf, is_constant, face) in looked_at {
        let squared = face.error_squared();
        let own = face.mean().element_sum() / 3.0;
        let most = OWN_TOLERANCES * of_all / light.mean * own + of_all;
        // What was left at one value is little: the bounces saw to that.
        if !is_constant {
            if squared > most * most && area_m2(leaf) >= LEAST_OF_ALL * all_m2 {
                continue;
            }
            errors.push((leaf, area_m2(leaf) * squared));
        }
        faces[mesh.patch(leaf).face] = Some(face);
    }
    let count = least_within(&mut errors, SHARE * tolerance * tolerance * all_m2);
    for (leaf, _) in &errors[count..] {
        faces[mesh.patch(*leaf).face] = None;
    }
    Ok((faces, values))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::MeshSettings;
    use crate::scene::Material;
    use crate::shade::interpolated::Interpolated;
    use crate::shade::refine::Refined;
    use crate::shade::{Bouncing, Room, bounce};
    use crate::solve::{SolveSettings, Surfaces};
    use crate::transport::{DirectLight, FormFactorOracle, link_all};
    use crate::visibility::{Visibility, fixture};
    use glam::DVec3;

    /// How many faces of a room with many cubes in it are plain, how many there are, and what these err, over what they may; where
    /// light bounced with one tolerance and is shown with another.
    fn plain_in_a_room_of_cubes([bounced_to, tolerance]: [f64; 2]) -> (usize, usize, f64) {
        let mut polygons: Vec<_> =
            fixture::inward_box(DVec3::ZERO, DVec3::new(3.0, 3.0, 2.0)).into_iter().map(|wall| (wall, 0)).collect();
        for i in 0..25 {
            let low = DVec3::new(0.3 + 0.5 * f64::from(i % 5), 0.3 + 0.5 * f64::from(i / 5), 0.2 + 0.05 * f64::from(i));
            polygons.extend(fixture::outward_box(low, low + 0.1).into_iter().map(|side| (side, 1)));
        }
        polygons.push((fixture::square(DVec3::new(1.5, 1.5, 1.9), 0.3, false), 2));
        let prepared = fixture::prepared_of_materials(&polygons);
        let grey = |reflectance: f64| Material::diffuse("grey", Rgb::splat(reflectance));
        let scene = fixture::scene(vec![grey(0.7), grey(0.4), Material::emitting("lamp", Rgb::ONE)]);
        let index = Visibility::new(&prepared);
        let gathering = Mesh::new(&prepared, &Table::new(), MeshSettings::default());
        let mut mesh = gathering.clone();
        let coplanar_m = prepared.tolerance.coplanar_m();
        let oracle = FormFactorOracle { max_form_factor: 0.1, min_area_m2: 0.05, coplanar_m };
        let links = link_all(&prepared, &index, &mut mesh, &oracle, Progress::silent()).unwrap();
        let direct = DirectLight::new(&scene, &prepared, &index);
        let mut surfaces = Surfaces::new(&scene, &prepared, &mesh, &direct);
        let room = Room { scene: &scene, prepared: &prepared, visibility: &index, direct: &direct, links: &links };
        let solve = SolveSettings { max_residual: 1e-6, max_iterations: 99 };
        let bouncing = Bouncing { solve, tolerance: bounced_to, coarser: 1.0 };
        let (solution, bounced) = bounce(room, bouncing, &mut mesh, &mut surfaces, None, Progress::silent()).unwrap();
        let mean = solution.mean_irradiance(&mesh, |_| true);
        let light = Irradiance::new(&prepared, &index, &mesh, &solution.reflected, mean);
        let places = Places::new(&prepared);
        let tolerances = [0.3, 1.0].map(|share| share * tolerance * light.mean);
        let (plain, _) = plain_faces(&gathering, &places, &light, &bounced, tolerances, Progress::silent()).unwrap();
        let refined = Refined { values: Values::default(), elements: Vec::new(), shifts: Vec::new(), error: 0.0 };
        let field = Interpolated::new(&gathering, &refined, &plain);
        let (mut squared, mut all_m2, mut count) = (0.0, 0.0, 0);
        for (face, plain) in plain.iter_enumerated() {
            let root = gathering.root(face);
            all_m2 += gathering.patch(root).area_m2;
            if plain.is_none() {
                continue;
            }
            count += 1;
            let corners = gathering.polygon_m(root);
            for i in 0..16_u32 {
                let [s, t] = [0.618034, 0.754878].map(|step| (f64::from(i) * step).fract());
                let at_m = corners[0] + s * (corners[1] - corners[0]) + t * (corners[3] - corners[0]);
                let point = ReceiverPoint::on_face(&prepared, face, at_m);
                let error = field.at(&point, face) - light.indirect(&point);
                squared += gathering.patch(root).area_m2 / 16.0 * (error * error).element_sum() / 3.0;
            }
        }
        (count, plain.len(), (squared / all_m2).sqrt() / tolerances[0])
    }

    #[test]
    fn small_faces_are_plain_and_err_little() {
        for tolerance in [0.1, 0.02] {
            let (count, all, error) = plain_in_a_room_of_cubes([tolerance; 2]);
            assert!(count > all / 2, "{count} of {all} at {tolerance}");
            assert!(error < 1.0, "{error} at {tolerance}");
        }
        let (count, all, _) = plain_in_a_room_of_cubes([0.02, 1e-7]);
        assert!(2 * count < all, "{count} of {all}");
    }
}
