//! What the balance of light needs to know of each patch: its material, its direct light, and its shape.

use glam::DMat2;

use crate::geometry::polygon;
use crate::id::{PatchId, Table};
use crate::mesh::Mesh;
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
        let (exitance, reflectance, missed, second_moment_m2) = Default::default();
        let mut surfaces = Self { exitance, reflectance, direct: Table::new(), missed, second_moment_m2 };
        surfaces.extend(scene, prepared, mesh, direct);
        surfaces
    }

    /// Takes each patch's material from its face alone: where direct light is known by other means.
    pub fn of_materials(scene: &Scene, prepared: &Prepared, mesh: &Mesh) -> Self {
        let material = |patch: PatchId| &scene.materials[prepared.faces[mesh.patch(patch).face].material];
        let patches = || mesh.patches().map(|(patch, _)| patch);
        let nothing = || patches().map(|_| Linear::default()).collect();
        Self {
            exitance: patches().map(|patch| material(patch).exitance()).collect(),
            reflectance: patches().map(|patch| material(patch).reflectance).collect(),
            direct: nothing(),
            missed: nothing(),
            second_moment_m2: patches().map(|patch| polygon::second_moment_m2(&mesh.polygon_2d_m(patch))).collect(),
        }
    }

    /// Does the same for patches that came since; of those that were split, what links miss stays with them, and is handed down.
    pub fn extend(&mut self, scene: &Scene, prepared: &Prepared, mesh: &Mesh, direct: &DirectLight<'_>) {
        let known = self.exitance.len();
        let fresh = (known..mesh.patch_count()).map(PatchId::from);
        for id in fresh.clone() {
            let material = &scene.materials[prepared.faces[mesh.patch(id).face].material];
            self.exitance.push(material.exitance());
            self.reflectance.push(material.reflectance);
            self.missed.push(Linear::default());
            self.second_moment_m2.push(polygon::second_moment_m2(&mesh.polygon_2d_m(id)));
        }
        for id in (0..known).map(PatchId::from) {
            if mesh.patch(id).subpatches.is_some() {
                self.direct[id] = Linear::default();
            }
        }
        let fresh: Vec<PatchId> = fresh.collect();
        self.direct.extend(direct.over_leaves_of(mesh, &fresh));
    }
}
