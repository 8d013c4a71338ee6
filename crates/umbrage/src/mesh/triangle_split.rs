//! `triangle_split` (paper, sections 5 and 6, Fig. 4): splits a triangle from the middle of its longest edge.
//!
//! Before: a leaf with three boundary points. After: two triangles and one new vertex, which is the point split-hint of
//! the neighbours along the split edge.

use super::Mesh;
use super::patch::{BoundaryPoint, Cut};
use crate::id::PatchId;

impl Mesh {
    /// Splits a triangle without split-hints from the middle of its longest edge. False where that edge is no longer
    /// than the weld distance allows.
    pub(super) fn triangle_split(&mut self, patch: PatchId) -> bool {
        let boundary = self.boundary(patch);
        let length_m =
            |point: &BoundaryPoint| self.vertex_m(point.vertex).distance(self.vertex_m(self.edges.end(point.leaf)));
        let longest = (0..boundary.len())
            .reduce(|best, next| if length_m(&boundary[next]) > length_m(&boundary[best]) { next } else { best });
        let Some(base) = longest.filter(|&i| length_m(&boundary[i]) >= 2.0 * self.least_edge_m) else { return false };
        let opposite = boundary[(base + 2) % boundary.len()].vertex;
        let middle = self.split_at_middle(boundary[base].leaf.edge);
        let boundary = self.boundary(patch);
        let [Some(from), Some(to)] = [middle, opposite].map(|v| boundary.iter().find(|point| point.vertex == v)) else {
            unreachable!("the middle and the opposite corner are boundary points of {patch:?}")
        };
        self.split_between(patch, from, to, Cut::Triangle);
        true
    }
}
