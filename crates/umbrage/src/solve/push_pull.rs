//! `push_pull`: makes the light that was gathered at different levels of the hierarchy one.
//!
//! Push: a leaf's irradiance is its direct light and what it and all its ancestors gathered (and what links are known to
//! miss), since irradiance is a density; each ancestor's is a linear function, taken at the leaf's centroid, so that no light is lost. Pull: a node's
//! radiosity is the mean of its parts' by area.
//!
//! ```text
//!        E1            leaf p: E = D(p) + E1(p) + E2(p) + E3(p)
//!       /  \
//!     E2    .          reflected_p = rho E
//!    /  \
//!  E3(p) .             reflected_parent = (A_p reflected_p + A_q reflected_q) / (A_p + A_q)
//! ```
//!
//! Subpatches have larger numbers than their patch, so that a pass down is one over rising numbers, and a pass up one over
//! falling numbers.

use glam::DVec2;

use super::{RadiosityMoments, Surfaces};
use crate::id::{PatchId, Table};
use crate::mesh::Mesh;
use crate::scene::Rgb;
use crate::transport::Linear;

/// Irradiance of every node, direct and gathered, and the radiosity that it reflects. A node that is split has the mean
/// of its parts' irradiance.
pub fn push_pull(
    mesh: &Mesh,
    surfaces: &Surfaces,
    gathered: Table<PatchId, Linear<Rgb>>,
) -> (Table<PatchId, Linear<Rgb>>, Table<PatchId, RadiosityMoments>) {
    pull(mesh, surfaces, push(mesh, surfaces, gathered))
}

/// Irradiance of the leaves: their own and what their ancestors gathered. A linear function may be below zero.
pub(super) fn push(
    mesh: &Mesh,
    surfaces: &Surfaces,
    gathered: Table<PatchId, Linear<Rgb>>,
) -> Table<PatchId, Linear<Rgb>> {
    let mut irradiance = gathered;
    for (id, patch) in mesh.patches() {
        let above = patch.parent.map_or(Linear::default(), |parent| {
            let Linear { gradient, .. } = irradiance[parent];
            Linear { mean: irradiance[parent].at(offset_m(mesh, id, parent)), gradient }
        });
        let node = &mut irradiance[id];
        *node = *node + above + surfaces.direct[id] + surfaces.missed[id];
    }
    irradiance
}

/// What every node reflects of what leaves receive, and the mean of what nodes that are split receive.
pub(super) fn pull(
    mesh: &Mesh,
    surfaces: &Surfaces,
    mut irradiance: Table<PatchId, Linear<Rgb>>,
) -> (Table<PatchId, Linear<Rgb>>, Table<PatchId, RadiosityMoments>) {
    let mut reflected: Table<PatchId, RadiosityMoments> =
        Table::from(vec![RadiosityMoments::default(); mesh.patch_count()]);
    for index in (0..mesh.patch_count()).rev() {
        let id = PatchId::from(index);
        let Some(parts) = mesh.patch(id).subpatches else {
            // A linear function may fall below zero at the dark end of a patch.
            irradiance[id].mean = irradiance[id].mean.max(Rgb::ZERO);
            reflected[id] = leaf_moments(surfaces, id, &irradiance[id]);
            continue;
        };
        let shares = shares(parts.map(|part| mesh.patch(part).area_m2));
        let (mut mean_irradiance, mut node) = (Rgb::ZERO, RadiosityMoments::default());
        for (part, share) in parts.into_iter().zip(shares) {
            mean_irradiance += share * irradiance[part].mean;
            node.mean += share * reflected[part].mean;
        }
        for (part, share) in parts.into_iter().zip(shares) {
            let (below, offset_m) = (reflected[part], offset_m(mesh, part, id));
            node.first[0] += share * (below.first[0] + offset_m.x * (below.mean - node.mean));
            node.first[1] += share * (below.first[1] + offset_m.y * (below.mean - node.mean));
        }
        (irradiance[id].mean, reflected[id]) = (mean_irradiance, node);
    }
    (irradiance, reflected)
}

/// From the centroid of a whole to that of its part, in the frame of their face.
fn offset_m(mesh: &Mesh, part: PatchId, whole: PatchId) -> DVec2 {
    let frame = mesh.frame(mesh.patch(part).face);
    frame.to_2d(mesh.patch(part).centroid_m) - frame.to_2d(mesh.patch(whole).centroid_m)
}

/// What a leaf reflects of a linear irradiance.
fn leaf_moments(surfaces: &Surfaces, leaf: PatchId, irradiance: &Linear<Rgb>) -> RadiosityMoments {
    let (reflectance, moment_m2) = (surfaces.reflectance[leaf], surfaces.second_moment_m2[leaf]);
    let first = |i: usize| {
        reflectance * (moment_m2.col(i).x * irradiance.gradient[0] + moment_m2.col(i).y * irradiance.gradient[1])
    };
    RadiosityMoments { mean: reflectance * irradiance.mean, first: [first(0), first(1)] }
}

/// Shares of two areas in their sum.
fn shares(areas_m2: [f64; 2]) -> [f64; 2] {
    let [first_m2, second_m2] = areas_m2.map(|area_m2| area_m2.max(0.0));
    let first = if first_m2 + second_m2 > 0.0 { first_m2 / (first_m2 + second_m2) } else { 0.5 };
    [first, 1.0 - first]
}
