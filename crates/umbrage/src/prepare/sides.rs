//! Straight runs: which vertices of a line or of a loop are corners, and which only lie on a straight line.
//!
//! By the method of Douglas and Peucker (1973): the vertex farthest from the line between two corners is a corner if it
//! is farther than the tolerance. All vertices that are passed over lie within the tolerance of the final line, so a
//! long, slightly bent chain cannot drift.

use glam::{DVec2, DVec3};

use crate::geometry::Tolerance;

/// A vertex this near to a line (as a share of the weld distance) lies straight on it. Vertices nearer than the weld
/// distance to an edge have cut it, so straightening an edge by half of that passes over none.
const STRAIGHT_OF_WELD: f64 = 0.5;

/// A vertex nearer than this to a line lies straight on it.
pub(super) fn straight_m(tolerance: &Tolerance) -> f64 {
    STRAIGHT_OF_WELD * tolerance.weld_m()
}

/// Distance of `p` from the segment between `a` and `b`.
pub(super) fn distance_to_segment_m(p: DVec3, a: DVec3, b: DVec3) -> f64 {
    let along = b - a;
    let t = ((p - a).dot(along) / along.length_squared()).clamp(0.0, 1.0);
    if t.is_finite() { p.distance(a + t * along) } else { p.distance(a) }
}

/// The corners of an open chain, its ends included, ascending.
pub(super) fn corners_of_chain(chain: &[DVec3], tolerance_m: f64) -> Vec<usize> {
    let mut corners = vec![0];
    let mut open = vec![(0, chain.len() - 1)];
    while let Some((from, to)) = open.pop() {
        let height_m = |i: usize| distance_to_segment_m(chain[i], chain[from], chain[to]);
        let farthest = (from + 1..to).max_by(|&i, &j| height_m(i).total_cmp(&height_m(j)).then(j.cmp(&i)));
        match farthest {
            Some(middle) if height_m(middle) > tolerance_m => open.extend([(middle, to), (from, middle)]),
            _ => corners.push(to),
        }
    }
    corners
}

/// The corners of a closed loop, ascending; fewer than three where it is straight altogether.
pub(super) fn corners_of_loop(points: &[DVec3], tolerance_m: f64) -> Vec<usize> {
    let farthest_from = |from: DVec3| {
        let distance_m = |&i: &usize| points[i].distance_squared(from);
        (0..points.len()).max_by(|i, j| distance_m(i).total_cmp(&distance_m(j)).then(j.cmp(i))).unwrap_or(0)
    };
    // The farthest vertex from any point is a corner of the convex hull.
    let start = farthest_from(points[0]);
    let turn = farthest_from(points[start]);
    let turned: Vec<DVec3> = (0..=points.len()).map(|i| points[(start + i) % points.len()]).collect();
    let half = (turn + points.len() - start) % points.len();
    if half == 0 {
        return vec![start];
    }
    let mut corners = corners_of_chain(&turned[..=half], tolerance_m);
    corners.pop();
    corners.extend(corners_of_chain(&turned[half..], tolerance_m).into_iter().map(|i| i + half));
    corners.pop();
    corners.iter_mut().for_each(|i| *i = (*i + start) % points.len());
    corners.sort_unstable();
    corners
}

/// The corners of a convex loop in a plane, with all other vertices straight between them; `None` where the loop is
/// not convex.
pub(super) fn convex_corners(flat: &[DVec2], points: &[DVec3], tolerance_m: f64) -> Option<Vec<usize>> {
    let corners = corners_of_loop(points, tolerance_m);
    is_convex(flat, &corners).then_some(corners)
}

/// Whether some vertices of a counter-clockwise simple loop form a convex polygon with area.
pub(super) fn is_convex(flat: &[DVec2], corners: &[usize]) -> bool {
    let n = corners.len();
    n >= 3
        && (0..n).all(|i| {
            let [a, b, c] = [0, 1, 2].map(|k| flat[corners[(i + k) % n]]);
            (b - a).perp_dot(c - b) > 0.0
        })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_long_chain_does_not_drift() {
        // An arc so flat that each vertex is within the tolerance of its neighbours' line.
        let arc: Vec<DVec3> =
            (0..=1000).map(|i| f64::from(i) * 1e-3).map(|x| DVec3::new(x, x * x * 0.1, 0.0)).collect();
        let tolerance_m = 1e-4;
        let corners = corners_of_chain(&arc, tolerance_m);
        assert!(corners.len() > 5 && corners.len() < 100, "{}", corners.len());
        for pair in corners.windows(2) {
            for &p in &arc[pair[0]..=pair[1]] {
                assert!(distance_to_segment_m(p, arc[pair[0]], arc[pair[1]]) <= tolerance_m);
            }
        }
    }

    #[test]
    fn a_square_with_vertices_on_its_sides_has_four_corners() {
        let square: Vec<DVec3> = [(0, 0), (1, 0), (2, 0), (3, 0), (3, 2), (3, 3), (0, 3), (0, 1)]
            .map(|(x, y)| DVec3::new(f64::from(x), f64::from(y), 0.0))
            .to_vec();
        for turn in 0..8 {
            let mut turned = square.clone();
            turned.rotate_left(turn);
            let corners = corners_of_loop(&turned, 1e-9);
            let found: Vec<DVec3> = corners.iter().map(|&i| turned[i]).collect();
            assert_eq!(found.len(), 4, "{found:?}");
            assert!(found.iter().all(|p| p.x % 3.0 == 0.0 && p.y % 3.0 == 0.0));
        }
    }

    #[test]
    fn a_straight_loop_has_two_corners() {
        let line = [0.0, 1.0, 2.0, 1.5].map(|x| DVec3::X * x);
        assert!(corners_of_loop(&line, 1e-9).len() < 3);
    }
}
