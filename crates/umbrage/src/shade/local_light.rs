//! The light around a place: what an error there is to be compared with.
//!
//! An error is a share of the mean light where one sees plenty of light at once. In a dim room behind a slit, all that there is to see may
//! be less than the tolerance: there an error is a share of the light in that room. What is in one room with a place is what it sees:
//! rays from the patch of the solved hierarchy meet other patches, and the light that half of them are below is that of the room. So
//! the shadow beneath a table in a lit room is no dim room, and one from which a ray in ten passes a door into a lit one is. What is
//! open to the outside is seen from there together with all else.

use std::sync::OnceLock;

use glam::DVec3;

use super::refine::OWN_TOLERANCES;
use crate::id::{FaceId, PatchId, Table};
use crate::mesh::Mesh;
use crate::prepare::Prepared;
use crate::scene::{Rgb, Scene};
use crate::transport::{Linear, cosine_direction};
use crate::visibility::{ReceiverPoint, Visibility};

/// What is fainter than this share of the mean is dark: nobody looks for errors there. At an exposure that shows the mean as white, it
/// is less than one code of 255.
const DARK_OF_MEAN: f64 = 1e-3;
/// Rays that look around from a patch. Twice as many tell of the same rooms.
const RAYS: usize = 15;
/// A ray of so many extents of the scene leaves it.
const LEAVES_EXTENTS: f64 = 2.0;
/// What is nearer than this share of the scene's extent is the other side of a gap: nobody stands in it. With 0, a furnished room takes
/// 15 % more triangles at 0.05, behind its furniture; with 0.02 none, as with 0.05.
const NARROW_OF_EXTENT: f64 = 0.03;
/// The golden ratio less 1: its multiples are even.
const GOLDEN: f64 = 0.618_033_988_749_894_9;

/// The light around each patch of the solved hierarchy.
#[derive(Debug)]
pub struct LocalLight<'a> {
    scene: &'a Scene,
    prepared: &'a Prepared,
    visibility: &'a Visibility,
    mesh: &'a Mesh,
    irradiance: &'a Table<PatchId, Linear<Rgb>>,
    /// What is as bright as this is not dim, in W/m2.
    plenty: f64,
    /// Of the leaves that were asked for: few places are dim.
    known: Table<PatchId, OnceLock<f64>>,
}

impl<'a> LocalLight<'a> {
    /// Prepares to look around from the patches that carried transport, whose irradiance is `irradiance` and its mean `mean`.
    pub fn new(
        scene: &'a Scene,
        (prepared, visibility): (&'a Prepared, &'a Visibility),
        mesh: &'a Mesh,
        irradiance: &'a Table<PatchId, Linear<Rgb>>,
        mean: f64,
    ) -> Self {
        let known = mesh.patches().map(|_| OnceLock::new()).collect();
        Self { scene, prepared, visibility, mesh, irradiance, plenty: mean / OWN_TOLERANCES, known }
    }

    /// Returns the irradiance around a point of a face, over the three colours, in W/m2.
    pub fn at(&self, face: FaceId, point_m: DVec3) -> f64 {
        let leaf = self.mesh.leaf_at(face, point_m);
        *self.known[leaf].get_or_init(|| {
            let own = self.of(leaf);
            if own < self.plenty { own.max(self.seen_from(leaf)) } else { own }
        })
    }

    fn of(&self, leaf: PatchId) -> f64 {
        self.irradiance[leaf].mean.element_sum() / 3.0
    }

    /// The median of what rays from a patch meet.
    fn seen_from(&self, leaf: PatchId) -> f64 {
        let patch = self.mesh.patch(leaf);
        let from = ReceiverPoint::on_flat_face(self.prepared, patch.face, patch.centroid_m);
        let far_m = LEAVES_EXTENTS * self.prepared.tolerance.extent_m;
        let gap_m = NARROW_OF_EXTENT * self.prepared.tolerance.extent_m;
        let light = |ray: usize| {
            let (u, v) = ((ray as f64 + 0.5) / RAYS as f64, (GOLDEN * ray as f64).fract());
            let to_m = from.position_m + far_m * cosine_direction(self.prepared.normal(patch.face), u, v);
            match self.visibility.first_front_of(&from, to_m) {
                Some((face, at_m))
                    if self.prepared.shows_light(self.scene, face) && from.position_m.distance(at_m) > gap_m =>
                {
                    self.of(self.mesh.leaf_at(face, at_m))
                }
                // Lamps are bright, and what is open, or too narrow to be looked into, is not dim.
                _ => f64::INFINITY,
            }
        };
        let mut seen: Vec<f64> = (0..RAYS).map(light).collect();
        seen.sort_by(f64::total_cmp);
        seen[RAYS / 2]
    }
}

/// Returns the error that counts for nothing where the light around is `local`, in W/m2: `tolerance` of the mean light, or so much more
/// of what is less than that as an element may err of its own light.
pub fn negligible(tolerance: f64, mean: f64, local: f64) -> f64 {
    tolerance * mean.min(OWN_TOLERANCES * local.max(DARK_OF_MEAN * mean))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_error_is_compared_with_the_mean_or_with_what_is_dimmer() {
        let of = |local: f64| negligible(0.01, 2.0, local);
        assert_eq!([of(f64::INFINITY), of(2.0), of(0.2)], [0.02; 3]);
        assert!((of(0.02) - 0.002).abs() < 1e-15, "a tenth of the light there");
        assert_eq!(of(0.0), of(1e-3 * 2.0), "what is dark");
    }
}
