//! `point_split` (paper, sections 5 and 6): splits a patch by the best chord between two of its boundary points.
//!
//! Boundary points are the patch's own corners and the point split-hints alike (Fig. 3). Before: a leaf with more than
//! three boundary points. After: it is split, and there is no new vertex and no new hint.

use super::Mesh;
use super::outline::Outline;
use super::patch::{BoundaryPoint, Cut};
use super::split::TRIANGLE;
use crate::id::PatchId;

impl Mesh {
    /// Splits a leaf by the chord with the best score. False where no chord leaves two parts with area.
    pub(super) fn point_split(&mut self, patch: PatchId) -> bool {
        let boundary = self.boundary(patch);
        let outline = Outline::of(self, patch, &boundary);
        let Some((i, j)) = outline.best_chord(self.settings.score) else { return false };
        self.split_between(patch, &boundary[i], &boundary[j], Cut::Points);
        true
    }

    /// The possible splitting edges of a patch (paper, Fig. 3): pairs of boundary points.
    pub fn splitting_edges(&self, patch: PatchId) -> Vec<[BoundaryPoint; 2]> {
        let boundary = self.boundary(patch);
        let outline = Outline::of(self, patch, &boundary);
        outline.chords().map(|(i, j, _)| [boundary[i], boundary[j]]).collect()
    }

    /// The triangles that `point_split` would make of a patch, by the numbers of their boundary points in `boundary`.
    pub fn triangles_of(&self, patch: PatchId, boundary: &[BoundaryPoint]) -> Vec<[usize; 3]> {
        let mut triangles = Vec::with_capacity(boundary.len().saturating_sub(2));
        let mut open = vec![Outline::of(self, patch, boundary)];
        while let Some(outline) = open.pop() {
            if let [a, b, c] = outline.points[..] {
                triangles.push([a.number, b.number, c.number]);
            } else if let Some((i, j)) = outline.best_chord(self.settings.score) {
                open.extend(outline.parts(i, j));
            }
        }
        triangles
    }

    /// Splits every leaf that has more than three boundary points, until all are triangles without a point hint: the
    /// last step of `generate_mesh`.
    ///
    /// What is thinner than rounding is split, too, though a part have no area or be turned over: its neighbours cut its
    /// edges, and a gap would be left.
    pub fn triangulate(&mut self) {
        let mut open: Vec<PatchId> = self.leaves().collect();
        while let Some(patch) = open.pop() {
            if self.boundary(patch).len() > TRIANGLE {
                if !self.point_split(patch) {
                    self.hairline_split(patch);
                }
                open.extend(self.patch(patch).subpatches.into_iter().flatten());
            }
        }
    }

    /// Splits a leaf that is thinner than rounding.
    fn hairline_split(&mut self, patch: PatchId) {
        let boundary = self.boundary(patch);
        let Some((i, j)) = Outline::of(self, patch, &boundary).most_even_chord() else {
            unreachable!("{patch:?} has three sides and more than three points, of which two do not lie on one side")
        };
        self.split_between(patch, &boundary[i], &boundary[j], Cut::Points);
    }
}

#[cfg(test)]
mod tests {
    use super::super::patch::on_one_side;
    use super::super::sample::{self, first, rectangle};
    use super::super::{MeshSettings, SplitScore};
    use super::*;
    use crate::discontinuity::Degree;
    use glam::DVec2;
    use proptest::prelude::*;

    #[test]
    fn fig_3_chords_join_corners_and_hints_that_lie_on_different_sides() {
        let mut mesh = sample::mesh(&[rectangle((0.0, 0.0), (1.0, 1.0))]);
        let lower = mesh.boundary(first())[0].leaf.edge;
        let hint = mesh.split_at_middle(lower);
        let edges = mesh.splitting_edges(first());
        // Two diagonals, and the hint with the two corners of the opposite side; never along a side.
        assert_eq!(edges.len(), 4);
        assert_eq!(edges.iter().filter(|ends| ends.iter().any(|end| end.vertex == hint)).count(), 2);
    }

    /// A mesh of one hairline with its leftmost corner at the origin, whose first side was bent there by a neighbour.
    fn bent(corners: &[[f64; 2]], at: DVec2) -> Mesh {
        let mut mesh = sample::mesh(&[corners.iter().copied().map(DVec2::from).collect()]);
        let boundary = mesh.boundary(first());
        let x_m = |point: &&BoundaryPoint| mesh.vertex_m(point.vertex).x;
        let origin = *boundary.iter().min_by(|p, q| x_m(p).total_cmp(&x_m(q))).unwrap();
        mesh.split_edge(origin.leaf.edge, mesh.vertex_m(origin.vertex) + at.extend(0.0));
        mesh
    }

    /// Areas of its triangles, the least first.
    fn triangles_m2(mesh: &mut Mesh) -> Vec<f64> {
        mesh.triangulate();
        assert_eq!(mesh.validate(), Ok(()));
        assert!(mesh.leaves().all(|leaf| mesh.boundary(leaf).len() == TRIANGLE));
        let mut areas_m2: Vec<f64> = mesh.leaves().map(|leaf| mesh.patch(leaf).area_m2).collect();
        areas_m2.sort_by(f64::total_cmp);
        areas_m2
    }

    #[test]
    fn a_needle_narrower_than_its_side_is_bent_is_cut_into_triangles() {
        let mut mesh = bent(&[[0.0, 0.0], [1.0, 0.0], [1.0, 4e-6]], DVec2::new(0.1, 1e-6));
        assert!(!mesh.point_split(first()), "there is one chord, and it turns a part over");
        let areas_m2 = triangles_m2(&mut mesh);
        assert!(areas_m2.len() == 2 && areas_m2[0] < 0.0, "{areas_m2:?}");
    }

    #[test]
    fn a_chord_that_a_neighbour_of_its_end_lies_beyond_is_taken_last() {
        // The best score has the chord from the origin to the third corner, and the bend lies beyond that.
        let mut mesh = bent(&[[0.0, 0.0], [1.0, 0.0], [0.94, 6e-6], [0.45, 8e-6]], DVec2::new(0.08, 1e-6));
        let areas_m2 = triangles_m2(&mut mesh);
        assert!(areas_m2.len() == 3 && areas_m2[0] > 0.0, "{areas_m2:?}");
    }

    #[test]
    fn a_triangle_offers_no_chord() {
        let mesh = sample::mesh(&[vec![DVec2::ZERO, DVec2::X, DVec2::Y]]);
        assert!(mesh.splitting_edges(first()).is_empty());
    }

    /// Which chord splits a 10 x 1 rectangle with points in the middle of its long sides.
    fn cut_of_long_rectangle(score: SplitScore) -> f64 {
        let mut mesh = sample::mesh(&[rectangle((0.0, 0.0), (10.0, 1.0))]);
        mesh.settings = MeshSettings { score, ..mesh.settings };
        for i in [0, 2] {
            let leaf = mesh.boundary(first()).iter().filter(|point| point.corner).nth(i).map(|point| point.leaf.edge);
            mesh.split_at_middle(leaf.unwrap());
        }
        assert!(mesh.point_split(first()));
        let [part, _] = mesh.patch(first()).subpatches.unwrap();
        mesh.compactness(part)
    }

    #[test]
    fn the_default_score_takes_the_cross_cut_where_equation_1_ties() {
        assert!(cut_of_long_rectangle(SplitScore::WellShaped) > 0.4);
        assert!(cut_of_long_rectangle(SplitScore::Eq1) < 0.3, "Eq. (1) takes the first of the ties, a diagonal");
    }

    #[test]
    fn equation_1_finds_the_chord_of_least_area_difference_times_length() {
        let corners =
            vec![(0.0, 0.0), (2.0, 0.0), (3.0, 1.0), (2.0, 2.0), (0.0, 1.5)].into_iter().map(DVec2::from).collect();
        let mut mesh = sample::mesh(&[corners]);
        mesh.settings.score = SplitScore::Eq1;
        let corners = mesh.polygon_2d_m(first());
        let area = |p: &[DVec2]| crate::geometry::polygon::signed_area_2d_m2(p);
        let best = (0..5)
            .flat_map(|i| (i + 2..5).filter(move |j| j - i < 4).map(move |j| (i, j)))
            .map(|(i, j)| {
                let part = area(&corners[i..=j]);
                (2.0 * part - area(&corners)).abs() * corners[i].distance(corners[j])
            })
            .fold(f64::INFINITY, f64::min);
        assert!(mesh.point_split(first()));
        let parts = mesh.patch(first()).subpatches.unwrap().map(|part| mesh.patch(part).area_m2);
        // A lone pentagon has edges 0 to 4; the chord is the next.
        let chord = mesh.edges().ends(crate::id::EdgeId::from(5)).map(|v| mesh.vertex_m(v));
        assert!(((parts[0] - parts[1]).abs() * chord[0].distance(chord[1]) - best).abs() < 1e-6);
    }

    proptest! {
        #[test]
        fn no_vertex_and_no_hint_is_new(corners in sample::convex(4), hints in 0usize..4) {
            let mut mesh = sample::mesh_with(&[corners], &[(0, DVec2::ZERO, DVec2::X, Degree::D1)]);
            for i in 0..hints {
                let leaf = mesh.boundary(first())[2 * i].leaf.edge;
                mesh.split_at_middle(leaf);
            }
            let (vertices, edges, points) = (mesh.vertex_count(), mesh.edges().len(), mesh.boundary(first()).len());
            prop_assert!(mesh.point_split(first()));
            prop_assert_eq!(mesh.vertex_count(), vertices);
            prop_assert_eq!(mesh.edges().len(), edges + 1, "the chord alone is new");
            let parts = mesh.patch(first()).subpatches.unwrap();
            let parts_points: usize = parts.iter().map(|&part| mesh.boundary(part).len()).sum();
            prop_assert_eq!(parts_points, points + 2);
            prop_assert!(parts.iter().map(|&part| mesh.patch(part).edge_hints().len()).sum::<usize>() <= 2);
        }

        #[test]
        fn every_pair_of_points_on_different_sides_is_a_chord(corners in sample::convex(3), hints in 0usize..12) {
            let mut mesh = sample::mesh(&[corners]);
            for i in 0..hints {
                let boundary = mesh.boundary(first());
                mesh.split_at_middle(boundary[7 * i % boundary.len()].leaf.edge);
            }
            let (boundary, sides) = (mesh.boundary(first()), mesh.patch(first()).sides.len());
            let chords = (0..boundary.len())
                .flat_map(|i| (0..i).map(move |j| (j, i)))
                .filter(|&(j, i)| !on_one_side(&boundary[j], &boundary[i], sides));
            prop_assert_eq!(mesh.splitting_edges(first()).len(), chords.count());
        }

        #[test]
        fn the_triangles_foretold_are_those_that_are_made(corners in sample::convex(4), hints in 0usize..3) {
            let mut mesh = sample::mesh(&[corners]);
            for i in 0..hints {
                let leaf = mesh.boundary(first())[2 * i].leaf.edge;
                mesh.split_at_middle(leaf);
            }
            let boundary = mesh.boundary(first());
            let sorted = |mut triangle: [crate::id::VertexId; 3]| {
                triangle.sort_unstable();
                triangle
            };
            let mut foretold: Vec<_> =
                mesh.triangles_of(first(), &boundary).iter().map(|t| sorted(t.map(|i| boundary[i].vertex))).collect();
            mesh.triangulate();
            let mut made: Vec<_> = mesh
                .leaves()
                .map(|leaf| {
                    let corners = mesh.boundary(leaf);
                    sorted([corners[0].vertex, corners[1].vertex, corners[2].vertex])
                })
                .collect();
            foretold.sort_unstable();
            made.sort_unstable();
            prop_assert_eq!(foretold, made);
        }

        #[test]
        fn triangulation_adds_no_vertex(corners in sample::convex(4)) {
            let count = corners.len();
            let mut mesh = sample::mesh(&[corners]);
            mesh.triangulate();
            prop_assert_eq!(mesh.vertex_count(), count);
            prop_assert_eq!(mesh.leaves().count(), count - 2);
        }
    }
}
