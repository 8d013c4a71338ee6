//! `push_pull`: makes the light that was gathered at different levels of the hierarchy one.
//!
//! Push: a leaf's irradiance is what it and all its ancestors gathered, since irradiance is a density; each ancestor's is a
//! linear function, taken at the leaf's centroid, so that no light is lost. Pull: a node's radiosity is the mean of its
//! parts' by area.
//!
//! ```text
//!        E1            leaf p: E = E1(p) + E2(p) + E3(p)
//!       /  \
//!     E2    .          B_p = M + rho E
//!    /  \
//!  E3(p) .             B_parent = (A_p B_p + A_q B_q) / (A_p + A_q)
//! ```
//!
//! Subpatches have larger numbers than their patch, so that a pass down is one over rising numbers, and a pass up one over
//! falling numbers.

use glam::DVec2;

use super::{LinearIrradiance, RadiosityMoments};
use crate::id::{PatchId, Table};
use crate::mesh::Mesh;
use crate::prepare::Prepared;
use crate::scene::{Rgb, Scene};

/// What each patch emits and reflects.
#[derive(Clone, Debug, PartialEq)]
pub struct Surfaces {
    /// Emitted exitance `M`, in W/m2.
    pub exitance: Table<PatchId, Rgb>,
    /// Reflectance, 0 to 1.
    pub reflectance: Table<PatchId, Rgb>,
}

impl Surfaces {
    /// Takes each patch's material from its face.
    pub fn new(scene: &Scene, prepared: &Prepared, mesh: &Mesh) -> Self {
        let material = |patch: &crate::mesh::Patch| &scene.materials[prepared.faces[patch.face].material];
        Self {
            exitance: mesh.patches().map(|(_, patch)| material(patch).exitance()).collect(),
            reflectance: mesh.patches().map(|(_, patch)| material(patch).reflectance).collect(),
        }
    }
}

/// Irradiance, as area mean, and radiosity of every node, from what each gathered.
pub fn push_pull(
    mesh: &Mesh,
    surfaces: &Surfaces,
    gathered: Table<PatchId, LinearIrradiance>,
) -> (Table<PatchId, Rgb>, Table<PatchId, RadiosityMoments>) {
    let offset_m = |part: PatchId, whole: PatchId| -> DVec2 {
        let frame = mesh.frame(mesh.patch(part).face);
        frame.to_2d(mesh.patch(part).centroid_m) - frame.to_2d(mesh.patch(whole).centroid_m)
    };
    let mut pushed = gathered;
    for (id, patch) in mesh.patches() {
        if let Some(parent) = patch.parent {
            let (above, offset_m) = (pushed[parent], offset_m(id, parent));
            let node = &mut pushed[id];
            node.mean += above.mean + offset_m.x * above.gradient[0] + offset_m.y * above.gradient[1];
            node.gradient[0] += above.gradient[0];
            node.gradient[1] += above.gradient[1];
        }
    }
    // A linear function may fall below zero at the dark end of a patch.
    let mut irradiance: Table<PatchId, Rgb> = pushed.iter().map(|node| node.mean.max(Rgb::ZERO)).collect();
    let mut radiosity: Table<PatchId, RadiosityMoments> =
        Table::from(vec![RadiosityMoments::default(); mesh.patch_count()]);
    for index in (0..mesh.patch_count()).rev() {
        let id = PatchId::from(index);
        let Some(parts) = mesh.patch(id).subpatches else {
            radiosity[id].mean = surfaces.exitance[id] + surfaces.reflectance[id] * irradiance[id];
            continue;
        };
        let shares = shares(parts.map(|part| mesh.patch(part).area_m2));
        let (mut mean_irradiance, mut node) = (Rgb::ZERO, RadiosityMoments::default());
        for (part, share) in parts.into_iter().zip(shares) {
            mean_irradiance += share * irradiance[part];
            node.mean += share * radiosity[part].mean;
        }
        for (part, share) in parts.into_iter().zip(shares) {
            let (below, offset_m) = (radiosity[part], offset_m(part, id));
            node.first[0] += share * (below.first[0] + offset_m.x * (below.mean - node.mean));
            node.first[1] += share * (below.first[1] + offset_m.y * (below.mean - node.mean));
        }
        (irradiance[id], radiosity[id]) = (mean_irradiance, node);
    }
    (irradiance, radiosity)
}

/// Shares of two areas in their sum.
fn shares(areas_m2: [f64; 2]) -> [f64; 2] {
    let [first_m2, second_m2] = areas_m2.map(|area_m2| area_m2.max(0.0));
    let first = if first_m2 + second_m2 > 0.0 { first_m2 / (first_m2 + second_m2) } else { 0.5 };
    [first, 1.0 - first]
}
