//! `edge_split` (paper, section 6): splits a patch along its edge split-hint of highest priority.
//!
//! The hint is prolonged to a chord where it ends inside the patch. An end of the chord that falls next to a boundary
//! point snaps to it, as far as the shadow may be moved without being seen; one of degree 0 moves only by rounding.
//! Otherwise the boundary edge is split there, which is the point split-hint of the neighbours along it.
//!
//! How far that is goes with the size of the patch. So a hint that snapped stays, for what is left of it in the subpatches,
//! and one that runs along the boundary nearer than that waits until patches are small enough: what is lost here would be
//! bisected without end.
//!
//! Before: the patch is a leaf with an edge hint. After: it is split, with at most two new vertices; or all hints wait.

use glam::{DVec2, DVec3};

use super::patch::{BoundaryPoint, Cut, on_one_side};
use super::split::Attempt;
use super::{EdgeHint, Mesh};
use crate::discontinuity::Degree;
use crate::geometry::clip;
use crate::geometry::convex::Line;
use crate::id::PatchId;

/// How far a d-segment of degree 1 may be moved, as a share of the square root of the patch's area.
const D1_SNAP: f64 = 0.01;
/// The same for degree 2, where only the curvature jumps.
const D2_SNAP: f64 = 0.02;

/// A hint shorter than this share of the square root of the patch's area waits until the patch is smaller: the chord
/// that it is prolonged to would follow the shadow nowhere else. A round shadow is many such hints, and a large patch
/// would lose a sliver to each.
const LEAST_OF_PATCH: f64 = 0.04;

/// Of more hints that must be cut than this, the next is one that halves their number; where none does, they wait until the patch is
/// smaller. One after another they would each be prolonged through the whole patch, and all others be clipped each time, in a time
/// that grows with the square of their number, and so would the depth of the tree.
const MANY: usize = 24;
/// So many of them are tried, evenly over the list.
const TRIED: usize = 16;
/// A hint that leaves more than this share of them on one side halves nothing.
const MOST_OF_ONE_SIDE: f64 = 0.75;

/// Where the end of a chord meets the boundary.
#[derive(Clone, Copy, Debug)]
enum End {
    /// At this boundary point.
    Point(BoundaryPoint),
    /// Inside the leaf edge after this boundary point.
    Inside(BoundaryPoint, DVec3),
}

/// A hint, prolonged to the boundary.
#[derive(Clone, Copy, Debug)]
struct Chord {
    ends: [End; 2],
    /// Whether an end snapped to a boundary point farther from it than rounding.
    is_moved: bool,
}

impl End {
    /// For the test whether two ends lie on one side: a point inside an edge is a point of that edge's side alone.
    fn place(&self) -> BoundaryPoint {
        match *self {
            Self::Point(point) => point,
            Self::Inside(before, _) => BoundaryPoint { corner: false, ..before },
        }
    }

    /// How many triangles more its vertex makes.
    fn cost(&self, mesh: &Mesh) -> usize {
        if let Self::Inside(before, _) = self { mesh.edges.beside(before.leaf.edge) } else { 0 }
    }
}

impl Mesh {
    /// How far a d-segment may be moved in this patch, in metres.
    pub(super) fn along_m(&self, patch: PatchId, degree: Degree) -> f64 {
        let size_m = self.patches[patch].area_m2.max(0.0).sqrt();
        match degree {
            Degree::D0 => self.finest_of(patch),
            Degree::D1 => self.finest_of(patch).max(D1_SNAP * size_m),
            Degree::D2 => self.finest_of(patch).max(D2_SNAP * size_m),
        }
    }

    /// Splits a leaf along the first of its edge hints that this patch is small enough for, if that makes no more than `room`
    /// triangles. It stays whole where there is none: hints that are short for the patch, or run along its boundary nearer
    /// than it may be cut, wait for its subpatches; those that must be cut only where they are many.
    pub(super) fn edge_split(&mut self, patch: PatchId, room: usize) -> Attempt {
        let hints = &self.patches[patch].edge_hints;
        let needed: Vec<usize> = (0..hints.len()).filter(|&number| hints[number].needed).collect();
        if needed.len() <= MANY {
            return self.edge_split_from(patch, room, 0);
        }
        self.halving_hint(patch, &needed).map_or(Attempt::Whole, |number| self.edge_split_from(patch, room, number))
    }

    /// Of many hints that must be cut the one that leaves the fewest of them on either side, by its number, if it halves them at all.
    fn halving_hint(&self, patch: PatchId, needed: &[usize]) -> Option<usize> {
        let hints = &self.patches[patch].edge_hints;
        let finest_m = self.finest_of(patch);
        let greater_side = |number: usize| {
            let line = Line::through(hints[number].ends_m[0], hints[number].ends_m[1]);
            let heights_m = needed.iter().map(|&other| hints[other].ends_m.map(|end| line.height_m(end)));
            let on_sides = heights_m.fold([0, 0], |[left, right], [p, q]| {
                [left + usize::from(p.max(q) > finest_m), right + usize::from(p.min(q) < -finest_m)]
            });
            on_sides[0].max(on_sides[1])
        };
        let tried = (0..TRIED).map(|i| needed[i * needed.len() / TRIED]).map(|number| (greater_side(number), number));
        let most = (MOST_OF_ONE_SIDE * needed.len() as f64) as usize;
        tried.min().filter(|&(greater, _)| greater <= most).map(|(_, number)| number)
    }

    /// The same, from a hint on, however many there are.
    pub(super) fn edge_split_from(&mut self, patch: PatchId, room: usize, from: usize) -> Attempt {
        let (corners, sides) = (self.polygon_2d_m(patch), self.patches[patch].sides.len());
        let least_m = LEAST_OF_PATCH * self.patches[patch].area_m2.max(0.0).sqrt();
        let mut number = from;
        while let Some(&hint) = self.patches[patch].edge_hints.get(number) {
            let is_d0 = hint.degree == Degree::D0;
            let is_along = || !is_d0 && hint.runs_along(&corners, self.along_m(patch, hint.degree));
            let waits = !hint.needed && (hint.length_m() < least_m || is_along());
            let chord = if waits { None } else { self.chord_of(patch, &hint) };
            match chord.filter(|chord| !on_one_side(&chord.ends[0].place(), &chord.ends[1].place(), sides)) {
                Some(chord) if chord.ends.iter().map(|end| end.cost(self)).sum::<usize>() > room => {
                    return Attempt::NoRoom;
                }
                Some(chord) => {
                    // What snapped elsewhere has not been cut yet.
                    if is_d0 || !chord.is_moved {
                        self.patches[patch].edge_hints.remove(number);
                    }
                    self.cut_along(patch, &chord, &hint);
                    return Attempt::Split;
                }
                // By rounding alone: the boundary is where it would cut.
                None if is_d0 && !waits => drop(self.patches[patch].edge_hints.remove(number)),
                None => number += 1,
            }
        }
        Attempt::Whole
    }

    fn cut_along(&mut self, patch: PatchId, chord: &Chord, hint: &EdgeHint) {
        let vertices = chord.ends.map(|end| match end {
            End::Point(point) => point.vertex,
            End::Inside(before, at) => self.split_edge(before.leaf.edge, at),
        });
        let boundary = self.boundary(patch);
        let [Some(from), Some(to)] = vertices.map(|vertex| boundary.iter().find(|point| point.vertex == vertex)) else {
            unreachable!("the ends of a chord are boundary points of {patch:?}")
        };
        self.split_between(patch, from, to, Cut::EdgeHint(hint.d_segment));
        if hint.degree == Degree::D0 {
            self.mark_jump(patch);
        }
    }

    /// The two places where the prolonged hint meets the boundary of the patch.
    fn chord_of(&self, patch: PatchId, hint: &EdgeHint) -> Option<Chord> {
        let [from, to] = hint.ends_m;
        let line = (f64::NEG_INFINITY, f64::INFINITY);
        let (t0, t1) = clip::line_in_convex(from, to, &self.polygon_2d_m(patch), line)?;
        let snap_m = self.along_m(patch, hint.degree);
        let boundary = self.boundary(patch);
        let frame = self.frame(self.patches[patch].face);
        let corners_m: Vec<DVec2> = boundary.iter().map(|p| frame.to_2d(self.vertex_m(p.vertex))).collect();
        let finest_m = self.finest_of(patch);
        let ends = [t0, t1].map(|t| self.end_at(from.lerp(to, t), &boundary, &corners_m, [snap_m, finest_m]));
        let moved_m = |(end, t): (&End, f64)| match end {
            End::Point(point) => frame.to_2d(self.vertex_m(point.vertex)).distance(from.lerp(to, t)),
            End::Inside(..) => 0.0,
        };
        let is_moved = ends.iter().zip([t0, t1]).map(moved_m).any(|moved_m| moved_m > finest_m);
        Some(Chord { ends, is_moved })
    }

    /// The boundary point next to `at`, or else the place inside the leaf edge that `at` lies on.
    fn end_at(&self, at: DVec2, boundary: &[BoundaryPoint], corners_m: &[DVec2], [snap_m, finest_m]: [f64; 2]) -> End {
        let n = boundary.len();
        let nearest = |distance: &dyn Fn(usize) -> f64| {
            (0..n).map(|i| (distance(i), i)).min_by(|p, q| p.0.total_cmp(&q.0)).unwrap_or((f64::INFINITY, 0))
        };
        let (distance_m, i) = nearest(&|i| corners_m[i].distance(at));
        if distance_m <= snap_m {
            return End::Point(boundary[i]);
        }
        let foot = |i: usize| {
            let (p, q) = (corners_m[i], corners_m[(i + 1) % n]);
            let t = ((at - p).dot(q - p) / (q - p).length_squared()).clamp(0.0, 1.0);
            (t, p.lerp(q, t).distance(at))
        };
        let (_, i) = nearest(&|i| foot(i).1);
        let ends = [boundary[i].vertex, boundary[(i + 1) % n].vertex].map(|vertex| self.vertex_m(vertex));
        let point = ends[0].lerp(ends[1], foot(i).0);
        if point.distance(ends[0]) < finest_m {
            End::Point(boundary[i])
        } else if point.distance(ends[1]) < finest_m {
            End::Point(boundary[(i + 1) % n])
        } else {
            End::Inside(boundary[i], point)
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::sample::{self, first, rectangle};
    use super::*;
    use proptest::prelude::*;

    fn square_with(segments: &[(DVec2, DVec2, Degree)]) -> Mesh {
        let segments: Vec<_> = segments.iter().map(|&(from, to, degree)| (0, from, to, degree)).collect();
        sample::mesh_with(&[rectangle((0.0, 0.0), (1.0, 1.0))], &segments)
    }

    #[test]
    fn the_hint_of_highest_priority_is_used_first() {
        let mut mesh = square_with(&[
            (DVec2::new(0.0, 0.3), DVec2::new(1.0, 0.3), Degree::D2),
            (DVec2::new(0.4, 0.0), DVec2::new(0.4, 1.0), Degree::D1),
        ]);
        assert_eq!(mesh.edge_split(first(), usize::MAX), Attempt::Split);
        let Some(subpatches) = mesh.patch(first()).subpatches else { panic!("not split") };
        let mut areas = subpatches.map(|part| mesh.patch(part).area_m2);
        areas.sort_by(f64::total_cmp);
        assert!((areas[0] - 0.4).abs() < 1e-6, "{areas:?}");
        assert!(
            subpatches.iter().all(|&part| mesh.patch(part).edge_hints().len() == 1),
            "the other is clipped into both"
        );
    }

    #[test]
    fn a_hint_that_is_short_for_its_patch_waits_but_not_for_degree_0() {
        let ends = (DVec2::new(0.5, 0.31), DVec2::new(0.53, 0.29));
        let mut mesh = square_with(&[(ends.0, ends.1, Degree::D1)]);
        assert_eq!(mesh.edge_split(first(), usize::MAX), Attempt::Whole);
        assert!(mesh.split(first()));
        assert_eq!(mesh.patch(first()).cut, Some(Cut::Points));
        // The patches around it shrink until it is long enough, and then it is used.
        let mut open: Vec<PatchId> = mesh.leaves().collect();
        while let Some(patch) = open.pop() {
            if !mesh.patch(patch).edge_hints().is_empty() && mesh.split(patch) {
                open.extend(mesh.patch(patch).subpatches.into_iter().flatten());
            }
        }
        assert!(mesh.patches().any(|(_, patch)| matches!(patch.cut, Some(Cut::EdgeHint(_)))));
        let mut needed = square_with(&[(ends.0, ends.1, Degree::D0)]);
        assert_eq!(needed.edge_split(first(), usize::MAX), Attempt::Split);
    }

    /// A disc's shadow: the tangents of a circle of `n` sides, in a square.
    fn square_under_a_disc(n: u32) -> Mesh {
        let corner =
            |i: u32| DVec2::splat(0.5) + 0.3 * DVec2::from_angle(std::f64::consts::TAU * f64::from(i) / f64::from(n));
        let sides: Vec<_> = (0..n).map(|i| (corner(i), corner(i + 1), Degree::D2)).collect();
        square_with(&sides)
    }

    #[test]
    fn a_round_shadow_is_closed_in_upon_by_halves_and_not_by_slivers() {
        let mut mesh = square_under_a_disc(192);
        // Always the largest patch: tangents alone would leave it nearly as large as it was.
        for _ in 0..31 {
            let area_m2 = |leaf: &PatchId| mesh.patch(*leaf).area_m2;
            let Some(largest) = mesh.leaves().max_by(|p, q| area_m2(p).total_cmp(&area_m2(q))) else { break };
            assert!(mesh.split(largest));
        }
        let largest_m2 = mesh.leaves().map(|leaf| mesh.patch(leaf).area_m2).fold(0.0, f64::max);
        assert!(largest_m2 < 0.1, "{largest_m2}");
    }

    #[test]
    fn a_hint_that_ends_inside_is_prolonged_to_a_chord() {
        let mut mesh = square_with(&[(DVec2::new(0.2, 0.5), DVec2::new(0.6, 0.5), Degree::D1)]);
        assert_eq!(mesh.edge_split(first(), usize::MAX), Attempt::Split);
        let new: Vec<DVec3> = (4..6).map(|i| mesh.vertex_m(i.into())).collect();
        assert!(new.iter().all(|v| v.y == 0.5 && (v.x == 0.0 || v.x == 1.0)), "{new:?}");
    }

    #[test]
    fn a_hint_near_the_boundary_waits_until_patches_are_small_enough() {
        // Half a snap from the border.
        let y = 0.5 * D1_SNAP;
        let mut mesh = square_with(&[(DVec2::new(0.0, y), DVec2::new(1.0, y), Degree::D1)]);
        assert!(mesh.edge_split(first(), usize::MAX) == Attempt::Whole && mesh.patch(first()).edge_hints().len() == 1);
        for _ in 0..200 {
            let lies_there = |&leaf: &PatchId| !mesh.patch(leaf).edge_hints().is_empty();
            let Some(leaf) = mesh.leaves().find(lies_there) else { break };
            assert!(mesh.split(leaf));
        }
        assert!(mesh.leaves().all(|leaf| mesh.patch(leaf).edge_hints().is_empty()), "all of it is cut");
        let is_on_it = |v: usize| (mesh.vertex_m(v.into()).y - y).abs() < 1e-6;
        assert!((0..mesh.vertex_count()).filter(|&v| is_on_it(v)).count() >= 4);
    }

    #[test]
    fn an_end_next_to_a_corner_snaps_but_not_for_degree_0() {
        let ends = (DVec2::new(0.01, 0.0), DVec2::new(1.0, 0.995));
        let mut soft = square_with(&[(ends.0, ends.1, Degree::D2)]);
        assert_eq!(soft.edge_split(first(), usize::MAX), Attempt::Split);
        assert_eq!(soft.vertex_count(), 4, "both ends snap to the corners");
        let mut hard = square_with(&[(ends.0, ends.1, Degree::D0)]);
        assert_eq!(hard.edge_split(first(), usize::MAX), Attempt::Split);
        assert_eq!(hard.vertex_count(), 6);
    }

    #[test]
    fn a_round_shadow_of_many_edges_is_cut_in_a_shallow_tree() {
        let corner = |i: usize| 0.5 + 0.3 * DVec2::from_angle(std::f64::consts::TAU * i as f64 / 400.0);
        let hints: Vec<_> = (0..400).map(|i| (corner(i), corner(i + 1), Degree::D0)).collect();
        let mut mesh = square_with(&hints);
        mesh.remove_d0_hints();
        assert!(mesh.leaves().all(|leaf| !mesh.has_d0_hint(leaf)), "all are cut");
        let depth = |leaf: PatchId| std::iter::successors(Some(leaf), |&patch| mesh.patch(patch).parent).count();
        let deepest = mesh.leaves().map(depth).max().unwrap();
        assert!(deepest < 60, "{deepest} levels");
        // Cut one after another, each edge would be prolonged through the square.
        let length_m = |leaf: PatchId| mesh.edges().ends(mesh.boundary(leaf)[0].leaf.edge).map(|v| mesh.vertex_m(v));
        assert!(mesh.leaves().count() < 4000 && mesh.leaves().all(|leaf| length_m(leaf)[0] != length_m(leaf)[1]));
    }

    #[test]
    fn a_shadow_edge_nearly_in_line_with_one_that_was_cut_is_cut_too() {
        let mut mesh = square_with(&[]);
        let rise_m = 0.6 * mesh.finest_of(first());
        assert!(rise_m > 2.0 * mesh.least_edge_m, "else they are one line");
        let (start, bend, end) = (DVec2::new(0.2, 0.5), DVec2::new(0.6, 0.5), DVec2::new(0.7, 0.5 + rise_m));
        mesh = square_with(&[(start, bend, Degree::D0), (bend, end, Degree::D0)]);
        mesh.remove_d0_hints();
        let cuts = mesh.patches().filter(|(_, patch)| matches!(patch.cut, Some(Cut::EdgeHint(_)))).count();
        assert_eq!(cuts, 2);
    }

    proptest! {
        #[test]
        fn at_most_two_vertices_are_new_and_the_hint_is_used_up_but_for_its_snap(
            corners in sample::convex(3), from in (-0.9..0.9, -0.9..0.9), to in (-0.9..0.9, -0.9..0.9), degree in 0usize..3
        ) {
            let degree = [Degree::D0, Degree::D1, Degree::D2][degree];
            let mut mesh = sample::mesh_with(&[corners], &[(0, from.into(), to.into(), degree)]);
            prop_assume!(!mesh.patch(first()).edge_hints().is_empty());
            let (before, snap_m) = (mesh.vertex_count(), mesh.along_m(first(), degree));
            let split = mesh.edge_split(first(), usize::MAX) == Attempt::Split;
            prop_assert!(mesh.vertex_count() <= before + 2);
            prop_assert_eq!(split, mesh.patch(first()).subpatches.is_some());
            for leaf in mesh.leaves() {
                let corners = mesh.polygon_2d_m(leaf);
                let mut hints = mesh.patch(leaf).edge_hints().iter();
                prop_assert!(hints.all(|hint| degree != Degree::D0 && (!split || hint.runs_along(&corners, snap_m))));
            }
        }
    }
}
