//! Point split-hints put into very badly shaped patches: the next step that the paper's last section announces.
//!
//! A long rectangle offers `point_split` nothing but diagonals, a needle offers `triangle_split` only slimmer needles.
//! Points in the middle of the long edges offer the short cross-cut, and the parts become well shaped step by step.

use super::Mesh;
use super::patch::BoundaryPoint;
use crate::geometry::polygon;
use crate::id::{EdgeId, PatchId, VertexId};

/// A patch less compact than this is very badly shaped: a rectangle of more than 4 : 1, a triangle of more than 3 : 1.
const BADLY_SHAPED: f64 = 0.5;
/// An edge longer than this share of the longest gets a point.
const LONG: f64 = 0.6;

impl Mesh {
    /// Splits a leaf edge in its middle.
    pub(super) fn split_at_middle(&mut self, leaf: EdgeId) -> VertexId {
        let [first, last] = self.edges.ends(leaf).map(|vertex| self.vertex_m(vertex));
        self.split_edge(leaf, first.midpoint(last))
    }

    /// Puts point hints into the long edges of a very badly shaped patch that has none there yet, if that makes no more than
    /// `room` triangles.
    pub(super) fn add_point_hints(&mut self, patch: PatchId, room: usize) {
        if self.compactness(patch) >= BADLY_SHAPED {
            return;
        }
        let corners = self.polygon_m(patch);
        let longest_m =
            (0..corners.len()).map(|i| corners[i].distance(corners[(i + 1) % corners.len()])).fold(0.0, f64::max);
        // Cross-cuts much narrower than the patch is long are worth a point; a patch of even sides is only sharp.
        let width_m = 2.0 * polygon::area_m2(&corners) / polygon::perimeter_m(&corners);
        if longest_m <= 2.0 * width_m.max(self.finest_of(patch)) {
            return;
        }
        let is_long = |point: &BoundaryPoint| {
            let [first, last] = self.edges.ends(point.leaf.edge).map(|vertex| self.vertex_m(vertex));
            first.distance(last) > LONG * longest_m
        };
        let long: Vec<EdgeId> =
            self.boundary(patch).iter().filter(|point| is_long(point)).map(|p| p.leaf.edge).collect();
        if long.iter().map(|&edge| self.edges.beside(edge)).sum::<usize>() <= room {
            long.into_iter().for_each(|edge| {
                self.split_at_middle(edge);
            });
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::sample::{self, first, rectangle};
    use glam::DVec2;

    #[test]
    fn a_long_rectangle_gets_a_point_in_each_long_side_and_is_cut_across() {
        let mut mesh = sample::mesh(&[rectangle((0.0, 0.0), (20.0, 1.0))]);
        mesh.add_point_hints(first(), usize::MAX);
        assert_eq!(mesh.point_hints(first()).len(), 2);
        assert!(mesh.split(first()));
        let parts = mesh.patch(first()).subpatches.unwrap();
        assert!(
            parts.iter().all(|&part| (mesh.patch(part).area_m2 - 10.0).abs() < 1e-5 && mesh.polygon_m(part).len() == 4)
        );
    }

    #[test]
    fn a_needle_gets_points_in_its_long_sides_only() {
        let mut mesh = sample::mesh(&[vec![DVec2::ZERO, DVec2::new(10.0, -0.5), DVec2::new(10.0, 0.5)]]);
        mesh.add_point_hints(first(), usize::MAX);
        assert_eq!(mesh.point_hints(first()).len(), 2);
    }

    #[test]
    fn a_square_and_an_equilateral_triangle_are_left_alone() {
        for corners in [rectangle((0.0, 0.0), (1.0, 1.0)), vec![DVec2::ZERO, DVec2::X, DVec2::new(0.5, 0.866)]] {
            let mut mesh = sample::mesh(&[corners]);
            mesh.add_point_hints(first(), usize::MAX);
            assert!(mesh.point_hints(first()).is_empty());
        }
    }
}
