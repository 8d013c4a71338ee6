//! A field that is quadratic over the triangles of the leaves of a mesh: indirect light, which is smooth, is gathered at few
//! points and interpolated at the many that direct light needs.
//!
//! Leaves do not see the points that their neighbours have on a common side: there the field jumps by what both err.

use super::parabola::{Parabola, value_at};
use super::refine::Refined;
use crate::id::{FaceId, PatchId, Table};
use crate::mesh::Mesh;
use crate::scene::Rgb;
use crate::visibility::ReceiverPoint;

/// A field that is quadratic over the triangles of the leaves of a mesh of its own.
#[derive(Clone, Debug)]
pub(super) struct Interpolated<'a> {
    mesh: &'a Mesh,
    parabolas: Table<PatchId, Vec<Parabola>>,
}

impl<'a> Interpolated<'a> {
    /// The field that was refined on `mesh`.
    pub(super) fn new(mesh: &'a Mesh, refined: &Refined) -> Self {
        let mut parabolas: Table<PatchId, Vec<Parabola>> = vec![Vec::new(); mesh.patch_count()].into();
        for leaf in mesh.leaves() {
            parabolas[leaf] = refined.parabolas(mesh, leaf);
        }
        Self { mesh, parabolas }
    }

    /// The value at a point of a face.
    pub(super) fn at(&self, point: &ReceiverPoint, face: FaceId) -> Rgb {
        let at_m = self.mesh.frame(face).to_2d(point.position_m);
        let leaf = self.mesh.leaf_at(face, point.position_m);
        // A parabola may fall below zero beside a dark corner.
        value_at(&self.parabolas[leaf], at_m).map_or(Rgb::ZERO, |value| value.max(Rgb::ZERO))
    }
}
