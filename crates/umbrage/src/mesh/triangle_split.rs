//! `triangle_split` (paper, sections 5 and 6, Fig. 4): splits a triangle from the middle of its longest edge.
//!
//! Before: a leaf with three boundary points. After: two triangles and one new vertex, which is the point split-hint of
//! the neighbours along the split edge.

use super::Mesh;
use super::patch::{BoundaryPoint, Cut};
use super::split::Attempt;
use crate::id::PatchId;

impl Mesh {
    /// Splits a triangle without split-hints from the middle of its longest edge, if that makes no more than `room`
    /// triangles. It stays whole where that edge is no longer than the weld distance allows.
    pub(super) fn triangle_split(&mut self, patch: PatchId, room: usize) -> Attempt {
        let boundary = self.boundary(patch);
        let length_m =
            |point: &BoundaryPoint| self.vertex_m(point.vertex).distance(self.vertex_m(self.edges.end(point.leaf)));
        let longest = (0..boundary.len())
            .reduce(|best, next| if length_m(&boundary[next]) > length_m(&boundary[best]) { next } else { best });
        let Some(base) = longest.filter(|&i| length_m(&boundary[i]) >= 2.0 * self.finest_of(patch)) else {
            return Attempt::Whole;
        };
        if self.edges.beside(boundary[base].leaf.edge) > room {
            return Attempt::NoRoom;
        }
        let opposite = boundary[(base + 2) % boundary.len()].vertex;
        let middle = self.split_at_middle(boundary[base].leaf.edge);
        let boundary = self.boundary(patch);
        let [Some(from), Some(to)] = [middle, opposite].map(|v| boundary.iter().find(|point| point.vertex == v)) else {
            unreachable!("the middle and the opposite corner are boundary points of {patch:?}")
        };
        self.split_between(patch, from, to, Cut::Triangle);
        Attempt::Split
    }
}

#[cfg(test)]
mod tests {
    use super::super::sample::{self, first};
    use super::*;
    use glam::DVec2;
    use proptest::prelude::*;

    #[test]
    fn fig_4_the_longest_edge_is_split_and_the_neighbour_gets_a_hint() {
        let long = [DVec2::new(0.0, 0.0), DVec2::new(4.0, 0.0)];
        let mut mesh = sample::mesh(&[
            vec![long[0], long[1], DVec2::new(1.0, 2.0)],
            vec![long[1], long[0], DVec2::new(2.0, -3.0)],
        ]);
        assert_eq!(mesh.triangle_split(first(), usize::MAX), Attempt::Split);
        let hints = mesh.point_hints(PatchId::from(1));
        assert_eq!(hints.iter().map(|&v| mesh.vertex_m(v).truncate()).collect::<Vec<_>>(), [DVec2::new(2.0, 0.0)]);
        let parts = mesh.patch(first()).subpatches.unwrap();
        assert!(parts.iter().all(|&part| mesh.boundary(part).len() == 3));
    }

    proptest! {
        #[test]
        fn one_vertex_and_one_hint_are_new(corners in sample::convex(3)) {
            let corners = corners[..3].to_vec();
            let area = crate::geometry::polygon::signed_area_2d_m2(&corners);
            prop_assume!(area > 0.01);
            let mut mesh = sample::mesh(&[corners]);
            prop_assert_eq!(mesh.triangle_split(first(), usize::MAX), Attempt::Split);
            prop_assert_eq!(mesh.vertex_count(), 4);
            prop_assert_eq!(mesh.point_hints(first()).len(), 1);
            let parts = mesh.patch(first()).subpatches.unwrap().map(|part| mesh.patch(part).area_m2);
            prop_assert!((parts[0] - parts[1]).abs() < 1e-6, "the halves are equal");
        }
    }
}
