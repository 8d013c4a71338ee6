//! Edge split-hints: d-segments clipped to the patch that they lie in (paper, sections 3.2 and 3.3).
//!
//! Priority: D0 before D1 before D2, those that must be cut before others, and then by strength times length in the patch. Point split-hints come
//! last and are not stored at all: they are boundary points that a neighbour made (see `edge_tree`).

use std::cmp::Ordering;

use glam::DVec2;

use crate::discontinuity::Degree;
use crate::geometry::clip;
use crate::id::DSegmentId;

/// A d-segment clipped to a patch: where to split it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EdgeHint {
    /// The d-segment that it is part of.
    pub d_segment: DSegmentId,
    /// Degree of the d-segment.
    pub degree: Degree,
    /// Strength of the d-segment.
    pub strength: f64,
    /// Whether the mesh must be cut along it, wherever light asks for splits or not.
    pub needed: bool,
    /// Ends in the frame of the face, in metres.
    pub ends_m: [DVec2; 2],
}

impl EdgeHint {
    /// Length in the patch, in metres.
    pub fn length_m(&self) -> f64 {
        self.ends_m[0].distance(self.ends_m[1])
    }

    /// Order of priority: the hint to be used first is less.
    pub fn by_priority(&self, other: &Self) -> Ordering {
        let weight = |hint: &Self| hint.strength * hint.length_m();
        self.degree
            .cmp(&other.degree)
            .then(other.needed.cmp(&self.needed))
            .then_with(|| weight(other).total_cmp(&weight(self)))
            .then_with(|| self.d_segment.cmp(&other.d_segment))
    }

    /// The part inside the convex polygon `corners`; `None` where that is shorter than `least_m`, or runs along the
    /// boundary, nowhere farther from it than `along_m`: then the boundary has satisfied it.
    pub(super) fn clipped(&self, corners: &[DVec2], least_m: f64, along_m: f64) -> Option<Self> {
        let [from, to] = self.ends_m;
        let (t0, t1) = clip::line_in_convex(from, to, corners, (0.0, 1.0))?;
        let part = Self { ends_m: [from.lerp(to, t0), from.lerp(to, t1)], ..*self };
        (part.length_m() > least_m && !part.runs_along(corners, along_m)).then_some(part)
    }

    /// Whether it runs along a side of a polygon, nowhere farther from it than `along_m`.
    pub(super) fn runs_along(&self, corners: &[DVec2], along_m: f64) -> bool {
        (0..corners.len()).any(|i| {
            let (p, q) = (corners[i], corners[(i + 1) % corners.len()]);
            let direction = (q - p).normalize_or_zero();
            self.ends_m.iter().all(|&end| direction.perp_dot(end - p).abs() <= along_m)
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn hint(degree: Degree, strength: f64, to: f64) -> EdgeHint {
        let ends_m = [DVec2::new(0.1, 0.5), DVec2::new(to, 0.5)];
        EdgeHint { d_segment: DSegmentId::from(0), degree, strength, needed: degree == Degree::D0, ends_m }
    }

    fn square() -> [DVec2; 4] {
        [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)].map(DVec2::from)
    }

    #[test]
    fn degree_comes_before_strength_and_strength_times_length_decides_within() {
        let mut hints = [
            hint(Degree::D2, 9.0, 0.9),
            hint(Degree::D1, 1.0, 0.5),
            hint(Degree::D1, 1.0, 0.9),
            hint(Degree::D0, 0.1, 0.2),
        ];
        hints.sort_by(EdgeHint::by_priority);
        assert_eq!(hints.map(|h| h.degree), [Degree::D0, Degree::D1, Degree::D1, Degree::D2]);
        assert_eq!(hints[1].ends_m[1].x, 0.9);
    }

    #[test]
    fn a_hint_is_clipped_to_its_patch() {
        let part = hint(Degree::D1, 1.0, 2.0).clipped(&square(), 1e-6, 1e-6).unwrap();
        assert!((part.length_m() - 0.9).abs() < 1e-15);
    }

    #[test]
    fn a_hint_along_the_boundary_is_satisfied() {
        let along = EdgeHint { ends_m: [DVec2::new(0.2, 1e-7), DVec2::new(0.8, 1e-7)], ..hint(Degree::D1, 1.0, 1.0) };
        assert!(along.clipped(&square(), 1e-6, 1e-6).is_none());
        assert!(along.clipped(&square(), 1e-8, 1e-8).is_some_and(|along| along.runs_along(&square(), 1e-6)));
    }
}
