//! The outline of a patch, or of a part of one: its boundary points in the plane of the face, and the chords between them.
//!
//! A part is told without splitting anything, so that refinement can look at the triangles that a patch would be cut into.
//! A patch is convex but for rounding: a long side may be bent, and no part may be wider than that. So a chord may have
//! points beyond it, and parts may be turned over.

use glam::DVec2;

use super::Mesh;
use super::patch::{BoundaryPoint, sides_of};
use super::score::{Chord, SplitScore};
use crate::id::PatchId;

/// A part with less than this share of the patch's area is no part: rounding made it.
const LEAST_SHARE: f64 = 1e-9;

/// An outline of more points than this offers those chords alone that about halve its area: no other wins, and of all pairs there are
/// too many.
const MANY_POINTS: usize = 64;
/// So many points to either side of the one across which the area is halved.
const BESIDE_HALF: usize = 8;

/// A boundary point of an outline: its number in the patch's boundary, its place, and the sides that it lies on.
#[derive(Clone, Copy, Debug)]
pub(super) struct OutlinePoint {
    pub(super) number: usize,
    at_m: DVec2,
    sides: [usize; 2],
}

/// Boundary points of a patch, or of a part of one, in the frame of its face.
pub(super) struct Outline {
    pub(super) points: Vec<OutlinePoint>,
    /// `moments[i]`: sum over `k < i` of the cross product of points `k` and `k + 1`.
    moments: Vec<f64>,
    /// Numbers of sides from here on are free.
    next_side: usize,
}

impl Outline {
    pub(super) fn of(mesh: &Mesh, patch: PatchId, boundary: &[BoundaryPoint]) -> Self {
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

    /// The chord from point `i` to point `j > i`, its angles not yet measured; `None` where both lie on one straight side.
    fn chord(&self, i: usize, j: usize) -> Option<Chord> {
        let (from, to) = (&self.points[i], &self.points[j]);
        if from.sides.iter().any(|side| to.sides.contains(side)) {
            return None;
        }
        let (p, q) = (from.at_m, to.at_m);
        let whole_m2 = 0.5 * self.moments[self.points.len()];
        let part_m2 = 0.5 * (self.moments[j] - self.moments[i] + q.perp_dot(p));
        let length_m = p.distance(q);
        Some(Chord { areas_m2: [part_m2, whole_m2 - part_m2], length_m, least_sine: 1.0 })
    }

    /// A chord from point `i` to point `j` with its angles.
    fn with_angles(&self, i: usize, j: usize, chord: Chord) -> Chord {
        let along = self.points[j].at_m - self.points[i].at_m;
        Chord { least_sine: self.least_sine_at(i, along).min(self.least_sine_at(j, -along)), ..chord }
    }

    /// The chord with the best score, by the numbers of its ends here; one that leaves a neighbour of its ends on the wrong
    /// side, as rounding of a long side makes them, only where there is no other. The first of equals wins, so that the
    /// choice depends on nothing but the outline.
    pub(super) fn best_chord(&self, score: SplitScore) -> Option<(usize, usize)> {
        if self.points.len() > MANY_POINTS {
            let best = self.best_of(self.halving_pairs(), score);
            // One that leaves the patch at an end is for want of others.
            let stays_inside =
                |(i, j)| self.chord(i, j).is_some_and(|chord| self.with_angles(i, j, chord).least_sine >= 0.0);
            if best.is_some_and(stays_inside) {
                return best;
            }
        }
        self.best_of(self.pairs(), score)
    }

    fn best_of(&self, pairs: impl Iterator<Item = (usize, usize, Chord)>, score: SplitScore) -> Option<(usize, usize)> {
        let mut best: Option<((bool, f64), usize, usize)> = None;
        for (i, j, chord) in self.with_area(pairs) {
            // Angles are dear, and a neighbour may have left thousands of points: most chords are worse at any angle.
            let upright = (false, score.of(&Chord { least_sine: 1.0, ..chord }));
            if best.is_some_and(|(least, ..)| upright >= least) {
                continue;
            }
            let chord = self.with_angles(i, j, chord);
            let scored = (chord.least_sine < 0.0, score.of(&chord));
            if best.is_none_or(|(least, ..)| scored < least) {
                best = Some((scored, i, j));
            }
        }
        best.map(|(_, i, j)| (i, j))
    }

    /// The chord whose lesser part is the largest, though it have no area or be turned over.
    pub(super) fn most_even_chord(&self) -> Option<(usize, usize)> {
        let lesser = self.pairs().map(|(i, j, chord)| (chord.areas_m2[0].min(chord.areas_m2[1]), i, j));
        lesser.reduce(|best, next| if next.0 > best.0 { next } else { best }).map(|(_, i, j)| (i, j))
    }

    /// The two parts beside a chord.
    pub(super) fn parts(&self, i: usize, j: usize) -> [Self; 2] {
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

    /// Every chord between two points, with their numbers, without angles. Points of one side are passed over together: a neighbour may
    /// have left hundreds on it.
    fn pairs(&self) -> impl Iterator<Item = (usize, usize, Chord)> + '_ {
        let n = self.points.len();
        self.beyond_sides()
            .into_iter()
            .enumerate()
            .flat_map(move |(i, beyond)| (beyond..n).map(move |j| (i, j)))
            .filter_map(|(i, j)| self.chord(i, j).map(|chord| (i, j, chord)))
    }

    /// For each point, the first after it that does not lie on the side between it and the next.
    fn beyond_sides(&self) -> Vec<usize> {
        let n = self.points.len();
        let mut beyond = Vec::with_capacity(n);
        let (mut side, mut end) = (usize::MAX, 0);
        for i in 0..n {
            let after = self.side_after(i);
            if after != side || end <= i {
                side = after;
                end = i + 1;
                while end < n && self.points[end].sides.contains(&side) {
                    end += 1;
                }
            }
            beyond.push(end);
        }
        beyond
    }

    /// The chords from each point to those about across, where the area is halved.
    fn halving_pairs(&self) -> impl Iterator<Item = (usize, usize, Chord)> + '_ {
        let n = self.points.len();
        let half_m2 = 0.25 * self.moments[n];
        let part_m2 = move |i: usize, j: usize| {
            0.5 * (self.moments[j] - self.moments[i] + self.points[j].at_m.perp_dot(self.points[i].at_m))
        };
        let across = move |i: usize| {
            // The part before a chord grows with its end, but for rounding.
            let (mut low, mut high) = (i + 1, n);
            while low < high {
                let middle = low.midpoint(high);
                if part_m2(i, middle) < half_m2 { low = middle + 1 } else { high = middle }
            }
            low
        };
        let beside = move |i: usize| {
            let at = across(i);
            (at.saturating_sub(BESIDE_HALF).max(i + 1)..n.min(at + BESIDE_HALF)).map(move |j| (i, j))
        };
        (0..n).flat_map(beside).filter_map(|(i, j)| self.chord(i, j).map(|chord| (i, j, chord)))
    }

    /// Every chord that may split the patch, without angles.
    pub(super) fn chords(&self) -> impl Iterator<Item = (usize, usize, Chord)> + '_ {
        self.with_area(self.pairs())
    }

    /// Those with a part on either side.
    fn with_area<'a>(
        &'a self,
        chords: impl Iterator<Item = (usize, usize, Chord)> + 'a,
    ) -> impl Iterator<Item = (usize, usize, Chord)> + 'a {
        let least_m2 = LEAST_SHARE * 0.5 * self.moments[self.points.len()];
        chords.filter(move |(_, _, chord)| chord.areas_m2.iter().all(|&area| area > least_m2))
    }
}

#[cfg(test)]
mod tests {
    use super::super::sample::{self, first};
    use super::*;

    #[test]
    fn of_many_points_the_chord_is_nearly_the_best_of_all() {
        let corner = |i: usize| DVec2::from_angle(std::f64::consts::TAU * i as f64 / 200.0) * DVec2::new(2.0, 1.0);
        let mesh = sample::mesh(&[(0..200).map(corner).collect()]);
        let boundary = mesh.boundary(first());
        let outline = Outline::of(&mesh, first(), &boundary);
        assert!(outline.points.len() > MANY_POINTS);
        let score = |(i, j): (usize, usize)| {
            SplitScore::WellShaped.of(&outline.with_angles(i, j, outline.chord(i, j).unwrap()))
        };
        let found = outline.best_chord(SplitScore::WellShaped).unwrap();
        let best = outline.best_of(outline.pairs(), SplitScore::WellShaped).unwrap();
        assert!(score(found) < 1.02 * score(best), "{found:?} {best:?}");
        let pairs = [outline.halving_pairs().count(), outline.pairs().count()];
        assert!(8 * pairs[0] < pairs[1], "{pairs:?}");
    }
}
