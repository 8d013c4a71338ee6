//! Where two edges cross: in the frame of a plane that they share, by exact predicates, or else in space.

use glam::DVec3;

use super::coplanar::Planes;
use super::node::Segment;
use super::weld::Points;
use crate::geometry::Tolerance;
use crate::geometry::predicate::orient_2d;

/// Edges without a common plane cross where they are nearer than this share of the weld distance: the cut moves each
/// by half of it.
const CROSSING_OF_WELD: f64 = 0.5;

/// Where two edges without a common end cross.
pub(super) fn crossing(
    first: &Segment,
    second: &Segment,
    planes: &Planes,
    points: &Points,
    tolerance: &Tolerance,
) -> Option<DVec3> {
    if first.ends.iter().any(|v| second.ends.contains(v)) {
        return None;
    }
    let ([a, b], [c, d]) = (first.ends.map(|v| points[v]), second.ends.map(|v| points[v]));
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
