//! What the balance of light needs to know of each patch: its material, its direct light, and its shape.

use glam::DMat2;

use crate::geometry::polygon;
use crate::id::{PatchId, Table};
use crate::mesh::{Mesh, Patch};
use crate::prepare::Prepared;
use crate::scene::{Rgb, Scene};
use crate::transport::{DirectLight, Linear};

/// What each patch emits, reflects, and receives straight from the emitters.
#[derive(Clone, Debug, PartialEq)]
pub struct Surfaces {
    /// Emitted exitance `M`, in W/m2.
    pub exitance: Table<PatchId, Rgb>,
    /// Reflectance, 0 to 1.
    pub reflectance: Table<PatchId, Rgb>,
    /// Direct irradiance of the leaves, in W/m2; zero for patches that are split.
    pub direct: Table<PatchId, Linear<Rgb>>,
    /// Reflected irradiance that links miss, or bring too much of, in W/m2: zero until an exact bounce tells it of the
    /// leaves.
    pub missed: Table<PatchId, Linear<Rgb>>,
    /// Area mean of the outer product of the offset from the centroid with itself, in the frame of the face, in square
    /// metres.
    pub second_moment_m2: Table<PatchId, DMat2>,
}

impl Surfaces {
    /// Takes each patch's material from its face, and evaluates the direct light of the leaves.
    pub fn new(scene: &Scene, prepared: &Prepared, mesh: &Mesh, direct: &DirectLight<'_>) -> Self {
        let material = |patch: &Patch| &scene.materials[prepared.faces[patch.face].material];
        let second_moment = |id: PatchId| polygon::second_moment_m2(&mesh.polygon_2d_m(id));
        Self {
            exitance: mesh.patches().map(|(_, patch)| material(patch).exitance()).collect(),
            reflectance: mesh.patches().map(|(_, patch)| material(patch).reflectance).collect(),
            direct: direct.over_leaves(mesh),
            missed: Table::from(vec![Linear::default(); mesh.patch_count()]),
            second_moment_m2: mesh.patches().map(|(id, _)| second_moment(id)).collect(),
        }
    }
}
