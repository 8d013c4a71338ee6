//! Small bright places that reflected light makes: light of a spot's circle on a wall through a hole, light of a sunlit sill on the reveal
//! beside it. On a large face they fall between the points at which light is gathered; seen from the bright patch they cannot be missed.
//!
//! Rays leave all patches in proportion to their reflected power. Where one ends, the patch that it comes from, with those around it that
//! are about as bright, would bring so much if nothing else stood between. Only where that is several times the mean of the face there is
//! the light gathered exactly: in rooms that are lit as usual hardly anywhere.
//!
//! After: each place stands for the area over which its light makes one ray.

use rayon::prelude::*;

use super::irradiance::Irradiance;
use crate::geometry::polygon;
use crate::id::{FaceId, PatchId, Table};
use crate::mesh::Mesh;
use crate::solve::{Solution, Surfaces};
use crate::texels::{Sequence, key_of};
use crate::transport::{BrightPlace, cosine_direction};
use crate::visibility::{FirstMet, ReceiverPoint};

/// Rays of all patches. A hole of 20 cm in a wall, 4 m from a spot's circle, lets one in a thousand pass.
const RAYS: usize = 1 << 14;
/// A patch and those around it are one source, as long as their mean radiosity is this share of its own.
const AS_BRIGHT: f64 = 0.5;
/// A place is looked at from so many times the mean of its face on: a less bright one is a large part of the face, whose points find it.
pub(super) const OF_FACE: f64 = 4.0;
/// So many candidates are looked at, at most; of more, every second, third and so on.
const MOST_LOOKED_AT: usize = 256;
/// A ray of so many extents of the scene leaves it.
const LEAVES_EXTENTS: f64 = 2.0;
/// Use of random numbers.
const OF_PLACES: u64 = 7;

/// Finds the places where patches that reflect much, as in `solution`, bring several times the mean of the face that they light, and more
/// than `least`, in W/m2.
pub fn reflected_places(
    light: &Irradiance<'_>,
    solution: &Solution,
    surfaces: &Surfaces,
    least: f64,
) -> Vec<BrightPlace> {
    let (mesh, prepared) = (light.mesh, light.prepared());
    let leaves: Vec<PatchId> = mesh.leaves().collect();
    let mut sum_w = 0.0;
    let ends_w: Vec<f64> = leaves
        .iter()
        .map(|&leaf| {
            sum_w += mesh.patch(leaf).area_m2 * solution.reflected[leaf].mean.element_sum().max(0.0);
            sum_w
        })
        .collect();
    if sum_w <= 0.0 || !least.is_finite() {
        return Vec::new();
    }
    let of_faces = means_of_faces(mesh, prepared.faces.len(), solution, surfaces);
    let ray_w = sum_w / RAYS as f64;
    let sequence = Sequence::new(key_of(0, OF_PLACES));
    let far_m = LEAVES_EXTENTS * prepared.tolerance.extent_m;
    let met = |number: usize| {
        let leaf = *leaves.get(ends_w.partition_point(|&end_w| end_w <= ray_w * (number as f64 + 0.5)))?;
        let face = mesh.patch(leaf).face;
        let [s, t, u, v] = sequence.at(number).map(f64::from);
        let from_m = polygon::point_of(&mesh.polygon_m(leaf), s, t);
        let to_m = from_m + far_m * cosine_direction(prepared.normal(face), u, v);
        match light.visibility.first_met(from_m, to_m, Some(prepared.faces[face].plane)) {
            FirstMet::Front(face, point_m) => Some((leaf, ReceiverPoint::on_face(prepared, face, point_m))),
            FirstMet::Nothing | FirstMet::Back(_) => None,
        }
    };
    let is_candidate = |leaf: PatchId, receiver: &ReceiverPoint| {
        let enough = receiver.face.map_or(0.0, |face| OF_FACE * of_faces[face]).max(least);
        unoccluded(mesh, solution, leaf, receiver) > enough
    };
    let candidate = |number: usize| met(number).filter(|(leaf, receiver)| is_candidate(*leaf, receiver));
    let candidates: Vec<(PatchId, ReceiverPoint)> = (0..RAYS).into_par_iter().filter_map(candidate).collect();
    let step = candidates.len().div_ceil(MOST_LOOKED_AT).max(1);
    let place = |&(_, receiver): &(PatchId, ReceiverPoint)| {
        let irradiance = light.indirect(&receiver);
        let area_m2 = step as f64 * ray_w / irradiance.element_sum();
        let place = BrightPlace { face: receiver.face?, point_m: receiver.position_m, area_m2, irradiance, lamp: None };
        (irradiance.element_sum() / 3.0 > least).then_some(place)
    };
    let looked_at: Vec<&(PatchId, ReceiverPoint)> = candidates.iter().step_by(step).collect();
    let places: Vec<BrightPlace> = looked_at.into_par_iter().filter_map(place).collect();
    tracing::debug!(candidates = candidates.len(), places = places.len(), "places that reflected light makes bright");
    places
}

/// Mean irradiance by reflection of each face, over the colours, in W/m2.
fn means_of_faces(mesh: &Mesh, faces: usize, solution: &Solution, surfaces: &Surfaces) -> Table<FaceId, f64> {
    let mut sums: Table<FaceId, (f64, f64)> = vec![(0.0, 0.0); faces].into();
    for leaf in mesh.leaves() {
        let patch = mesh.patch(leaf);
        let (light_w, area_m2) = &mut sums[patch.face];
        *light_w += patch.area_m2 * (solution.irradiance[leaf].mean - surfaces.direct[leaf].mean).element_sum() / 3.0;
        *area_m2 += patch.area_m2;
    }
    sums.iter().map(|&(light_w, area_m2)| if area_m2 > 0.0 { (light_w / area_m2).max(0.0) } else { 0.0 }).collect()
}

/// Irradiance that a leaf and those around it that are as bright would bring to a point if nothing else stood between, over the colours, in
/// W/m2: about that of a disc of their area.
fn unoccluded(mesh: &Mesh, solution: &Solution, leaf: PatchId, receiver: &ReceiverPoint) -> f64 {
    let sent = |patch: PatchId| solution.reflected[patch].mean.element_sum() / 3.0;
    let enough = AS_BRIGHT * sent(leaf);
    let mut source = leaf;
    while let Some(parent) = mesh.patch(source).parent.filter(|&parent| sent(parent) >= enough) {
        source = parent;
    }
    let patch = mesh.patch(source);
    let towards_m = patch.centroid_m - receiver.position_m;
    let squared_m2 = towards_m.length_squared();
    let received_m = receiver.normal.dot(towards_m).max(0.0);
    let sent_m = -mesh.frame(patch.face).plane.normal.dot(towards_m).min(0.0);
    if squared_m2 <= 0.0 {
        return 0.0;
    }
    let cosines = received_m * sent_m / squared_m2;
    sent(source) * patch.area_m2 * cosines / (std::f64::consts::PI * squared_m2 + patch.area_m2)
}
