//! `push_pull`: makes the light that was gathered at different levels of the hierarchy one.
//!
//! Push: a leaf's irradiance is what it and all its ancestors gathered, since irradiance is a density. Pull: a node's
//! radiosity is the mean of its parts' by area.
//!
//! ```text
//!        E1            leaf p: E = E1 + E2 + E3
//!       /  \
//!     E2    .          B_p = M + rho E
//!    /  \
//!  E3(p) .             B_parent = (A_p B_p + A_q B_q) / (A_p + A_q)
//! ```
//!
//! Subpatches have larger numbers than their patch, so that a pass down is one over rising numbers, and a pass up one over
//! falling numbers.

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

/// Irradiance and radiosity of every node, from what each gathered: both in W/m2.
pub fn push_pull(
    mesh: &Mesh,
    surfaces: &Surfaces,
    gathered: Table<PatchId, Rgb>,
) -> (Table<PatchId, Rgb>, Table<PatchId, Rgb>) {
    let mut irradiance = gathered;
    for (id, patch) in mesh.patches() {
        if let Some(parent) = patch.parent {
            let above = irradiance[parent];
            irradiance[id] += above;
        }
    }
    let mut radiosity: Table<PatchId, Rgb> = Table::from(vec![Rgb::ZERO; mesh.patch_count()]);
    for index in (0..mesh.patch_count()).rev() {
        let id = PatchId::from(index);
        match mesh.patch(id).subpatches {
            None => radiosity[id] = surfaces.exitance[id] + surfaces.reflectance[id] * irradiance[id],
            Some(parts) => {
                let [first_m2, second_m2] = parts.map(|part| mesh.patch(part).area_m2.max(0.0));
                let share = if first_m2 + second_m2 > 0.0 { first_m2 / (first_m2 + second_m2) } else { 0.5 };
                let mean = |table: &Table<PatchId, Rgb>| table[parts[1]].lerp(table[parts[0]], share);
                (irradiance[id], radiosity[id]) = (mean(&irradiance), mean(&radiosity));
            }
        }
    }
    (irradiance, radiosity)
}
