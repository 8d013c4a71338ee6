//! `point_split` (paper, sections 5 and 6): splits a patch by the best chord between two of its boundary points.
//!
//! Boundary points are the patch's own corners and the point split-hints alike (Fig. 3). Before: a leaf with more than
//! three boundary points. After: it is split, and there is no new vertex and no new hint.

use glam::DVec2;

use super::Mesh;
use super::patch::{BoundaryPoint, Cut, sides_of};
use super::score::{Chord, SplitScore};
use super::split::TRIANGLE;
use crate::id::PatchId;

/// A part with less than this share of the patch's area is no part: rounding made it.
const LEAST_SHARE: f64 = 1e-9;

/// A boundary point of an outline: its number in the patch's boundary, its place, and the sides that it lies on.
#[derive(Clone, Copy, Debug)]
struct OutlinePoint {
    number: usize,
    at_m: DVec2,
    sides: [usize; 2],
}

/// Boundary points of a patch, or of a part of one, in the frame of its face.
struct Outline {
    points: Vec<OutlinePoint>,
    /// `moments[i]`: sum over `k < i` of the cross product of points `k` and `k + 1`.
    moments: Vec<f64>,
    /// Numbers of sides from here on are free.
    next_side: usize,
}

impl Outline {
    fn of(mesh: &Mesh, patch: PatchId, boundary: &[BoundaryPoint]) -> Self {
        let frame = mesh.frame(mesh.patch(patch).face);
        let centre = frame.to_2d(mesh.patch(patch).centroid_m);
        let side_count = mesh.patch(patch).sides.len();
        let point = |(number, p): (usize, &BoundaryPoint)| OutlinePoint {
            number,
            at_m: frame.to_2d(mesh.vertex_m(p.vertex)) - centre,
            sides: sides_of(p, side_count),
        };
        Self::new(boundary.iter().enumerate().map(point).collect(), side_count)
    }

    fn new(points: Vec<OutlinePoint>, next_side: usize) -> Self {
        let mut moments = vec![0.0];
        for (i, point) in points.iter().enumerate() {
            moments.push(moments[i] + point.at_m.perp_dot(points[(i + 1) % points.len()].at_m));
        }
        Self { points, moments, next_side }
    }

    /// The chord from point `i` to point `j > i`; `None` where both lie on one straight side.
    fn chord(&self, i: usize, j: usize) -> Option<Chord> {
        let (from, to) = (&self.points[i], &self.points[j]);
        if from.sides.iter().any(|side| to.sides.contains(side)) {
            return None;
        }
        let (p, q) = (from.at_m, to.at_m);
        let whole_m2 = 0.5 * self.moments[self.points.len()];
        let part_m2 = 0.5 * (self.moments[j] - self.moments[i] + q.perp_dot(p));
        let length_m = p.distance(q);
        Some(Chord {
            areas_m2: [part_m2, whole_m2 - part_m2],
            length_m,
            least_sine: self.least_sine_at(i, q - p).min(self.least_sine_at(j, p - q)),
        })
    }

    /// The chord with the best score, by the numbers of its ends here; one that leaves a neighbour of its ends on the wrong
    /// side, as rounding of a long side makes them, only where there is no other. The first of equals wins, so that the
    /// choice depends on nothing but the outline.
    fn best_chord(&self, score: SplitScore) -> Option<(usize, usize)> {
        let scored = self.chords().map(|(i, j, chord)| ((chord.least_sine < 0.0, score.of(&chord)), i, j));
        scored.reduce(|best, next| if next.0 < best.0 { next } else { best }).map(|(_, i, j)| (i, j))
    }

    /// The chord whose lesser part is the largest, though it have no area or be turned over.
    fn most_even_chord(&self) -> Option<(usize, usize)> {
        let lesser = self.pairs().map(|(i, j, chord)| (chord.areas_m2[0].min(chord.areas_m2[1]), i, j));
        lesser.reduce(|best, next| if next.0 > best.0 { next } else { best }).map(|(_, i, j)| (i, j))
    }

    /// The two parts beside a chord.
    fn parts(&self, i: usize, j: usize) -> [Self; 2] {
        let chord = self.next_side;
        let part = |from: usize, to: usize| {
            let n = self.points.len();
            let count = (to + n - from) % n + 1;
            let mut points: Vec<OutlinePoint> = (0..count).map(|k| self.points[(from + k) % n]).collect();
            // The ends lie on the chord now, and on the one side of their own that is left of the part.
            let after = self.side_after(from);
            let before = self.side_after((to + n - 1) % n);
            points[0].sides = [chord, after];
            points[count - 1].sides = [before, chord];
            Self::new(points, chord + 1)
        };
        [part(i, j), part(j, i)]
    }

    /// The side from a point to the next: the one that both lie on.
    fn side_after(&self, i: usize) -> usize {
        let next = self.points[(i + 1) % self.points.len()].sides;
        let own = self.points[i].sides;
        if next.contains(&own[1]) { own[1] } else { own[0] }
    }

    /// Sine of the lesser angle that a chord in `direction` makes with the boundary at point `i`; angles beyond a right
    /// angle count as right. Negative where the chord leaves the patch there.
    fn least_sine_at(&self, i: usize, direction: DVec2) -> f64 {
        let n = self.points.len();
        let chord = direction.normalize_or_zero();
        [((i + 1) % n, 1.0), ((i + n - 1) % n, -1.0)]
            .into_iter()
            .map(|(neighbour, turn)| {
                let along = (self.points[neighbour].at_m - self.points[i].at_m).normalize_or_zero();
                if along.dot(chord) <= 0.0 { 1.0 } else { turn * along.perp_dot(chord) }
            })
            .fold(1.0, f64::min)
    }

    /// Every chord between two points, with their numbers.
    fn pairs(&self) -> impl Iterator<Item = (usize, usize, Chord)> + '_ {
        let n = self.points.len();
        (0..n)
            .flat_map(move |i| (i + 1..n).map(move |j| (i, j)))
            .filter_map(|(i, j)| self.chord(i, j).map(|chord| (i, j, chord)))
    }

    /// Every chord that may split the patch.
    fn chords(&self) -> impl Iterator<Item = (usize, usize, Chord)> + '_ {
        let least_m2 = LEAST_SHARE * 0.5 * self.moments[self.points.len()];
        self.pairs().filter(move |(_, _, chord)| chord.areas_m2.iter().all(|&area| area > least_m2))
    }
}

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
    use super::super::MeshSettings;
    use super::super::sample::{self, first, rectangle};
    use super::*;
    use crate::discontinuity::Degree;
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
