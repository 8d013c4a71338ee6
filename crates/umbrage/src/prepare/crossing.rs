//! Where two edges cross: in the frame of a plane that they share, by exact predicates, or else in space.

use glam::DVec3;

use super::coplanar::Planes;
use crate::geometry::Tolerance;
use crate::geometry::predicate::orient_2d;
use crate::id::PlaneId;

/// Edges without a common plane cross where they are nearer than this share of the weld distance: the cut moves each
/// by half of it.
const CROSSING_OF_WELD: f64 = 0.5;

/// An edge in space.
pub(super) struct Span<'a> {
    /// Its ends.
    pub(super) ends: [DVec3; 2],
    /// The planes that it is an edge of.
    pub(super) planes: &'a [PlaneId],
}

/// Where two edges without a common end cross.
pub(super) fn crossing(first: &Span<'_>, second: &Span<'_>, planes: &Planes, tolerance: &Tolerance) -> Option<DVec3> {
    let ([a, b], [c, d]) = (first.ends, second.ends);
    let (s, t) = if let Some(&shared) = first.planes.iter().find(|p| second.planes.contains(p)) {
        let [p, q, u, v] = [a, b, c, d].map(|x| planes.frames[shared].to_2d(x));
        let at = [orient_2d(u, v, p), orient_2d(u, v, q), orient_2d(p, q, u), orient_2d(p, q, v)];
        if at[0] * at[1] >= 0.0 || at[2] * at[3] >= 0.0 {
            return None;
        }
        (at[0] / (at[0] - at[1]), at[2] / (at[2] - at[3]))
    } else {
        let (e, f, r) = (b - a, d - c, a - c);
        let (ee, ef, ff) = (e.dot(e), e.dot(f), f.dot(f));
        let determinant = ee * ff - ef * ef;
        let s = (ef * f.dot(r) - ff * e.dot(r)) / determinant;
        let t = (ee * f.dot(r) - ef * e.dot(r)) / determinant;
        let apart_m = (a + s * e).distance(c + t * f);
        let crosses = s > 0.0 && s < 1.0 && t > 0.0 && t < 1.0 && apart_m <= CROSSING_OF_WELD * tolerance.weld_m();
        if !crosses {
            return None;
        }
        (s, t)
    };
    Some(0.5 * (a.lerp(b, s) + c.lerp(d, t)))
}

#[cfg(test)]
mod tests {
    use super::super::testing::{Small, TOLERANCE};
    use super::*;

    /// Where the first sides of two triangles cross.
    fn met(one: [[f64; 3]; 3], other: [[f64; 3]; 3]) -> Option<DVec3> {
        let small = Small::new(&[&one, &other]);
        let plane = [0, 1].map(|i| [small.planes.of_polygon[i].0]);
        let span = |corners: [[f64; 3]; 3], i: usize| Span {
            ends: [corners[0], corners[1]].map(DVec3::from),
            planes: &plane[i],
        };
        crossing(&span(one, 0), &span(other, 1), &small.planes, &TOLERANCE)
    }

    const LEVEL: [[f64; 3]; 3] = [[0.0, 0.0, 0.0], [4.0, 0.0, 0.0], [2.0, 3.0, 0.0]];

    #[test]
    fn edges_of_two_planes_cross_in_space() {
        let at = |y: f64| met(LEVEL, [[2.0, y, -1.0], [2.0, y, 1.0], [2.0, -3.0, 0.0]]);
        assert_eq!(at(0.0), Some(DVec3::X * 2.0));
        assert_eq!(at(TOLERANCE.weld_m()), None);
        assert_eq!(met(LEVEL, [[5.0, 0.0, -1.0], [5.0, 0.0, 1.0], [5.0, -3.0, 0.0]]), None);
    }

    #[test]
    fn edges_of_one_plane_cross_in_it() {
        assert_eq!(met(LEVEL, [[1.0, -1.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]]), Some(DVec3::X));
        assert_eq!(met(LEVEL, [[1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]]), None);
    }
}
