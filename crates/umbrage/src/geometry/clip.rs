//! Clipping of convex polygons and segments by half-planes and planes (Sutherland and Hodgman, 1974).
//!
//! The point where a side meets the clipping plane is computed from its ends in an order that does not depend on the
//! direction of travel: two polygons that share a side are cut at the very same bits.

use glam::{DVec2, DVec3};
use smallvec::SmallVec;

use super::Plane;

/// A corner that can be cut: a point of two or three dimensions.
pub trait Corner: Copy {
    /// The point that is the share `t` of the way on.
    fn lerp_towards(self, other: Self, t: f64) -> Self;
    /// An order of all points.
    fn precedes(self, other: Self) -> bool;
}

impl Corner for DVec3 {
    fn lerp_towards(self, other: Self, t: f64) -> Self {
        self + (other - self) * t
    }
    fn precedes(self, other: Self) -> bool {
        self.to_array() <= other.to_array()
    }
}

impl Corner for DVec2 {
    fn lerp_towards(self, other: Self, t: f64) -> Self {
        self + (other - self) * t
    }
    fn precedes(self, other: Self) -> bool {
        self.to_array() <= other.to_array()
    }
}

/// The point between `p` and `q` where a linear function with the values `at_p` and `at_q` of opposite sign is zero.
fn crossing<P: Corner>(p: P, at_p: f64, q: P, at_q: f64) -> P {
    if p.precedes(q) { p.lerp_towards(q, at_p / (at_p - at_q)) } else { q.lerp_towards(p, at_q / (at_q - at_p)) }
}

fn clip_by<P: Corner>(corners: &[P], height: impl Fn(P) -> f64) -> SmallVec<[P; 8]> {
    let mut kept = SmallVec::new();
    let Some(&last) = corners.last() else { return kept };
    let (mut previous, mut previous_height) = (last, height(last));
    for &corner in corners {
        let corner_height = height(corner);
        if (previous_height > 0.0 && corner_height < 0.0) || (previous_height < 0.0 && corner_height > 0.0) {
            kept.push(crossing(previous, previous_height, corner, corner_height));
        }
        if corner_height >= 0.0 {
            kept.push(corner);
        }
        (previous, previous_height) = (corner, corner_height);
    }
    if kept.len() < 3 {
        kept.clear();
    }
    kept
}

/// The part of a convex polygon in front of `plane`; corners nearer to the plane than `snap_m` count as in it.
pub fn in_front_of(corners: &[DVec3], plane: &Plane, snap_m: f64) -> Vec<DVec3> {
    clip_by(corners, |p| {
        let height_m = plane.signed_distance_m(p);
        if height_m.abs() <= snap_m { 0.0 } else { height_m }
    })
    .into_vec()
}

/// The part of a convex polygon where a linear function is not negative: for clipping in homogeneous coordinates.
pub fn where_not_negative<P: Corner>(corners: &[P], linear: impl Fn(P) -> f64) -> SmallVec<[P; 8]> {
    clip_by(corners, linear)
}

/// The part of a convex polygon to the left of the line from `from` to `to`.
pub fn left_of(corners: &[DVec2], from: DVec2, to: DVec2) -> Vec<DVec2> {
    let along = to - from;
    clip_by(corners, |p| along.perp_dot(p - from)).into_vec()
}

/// The common part of two convex counter-clockwise polygons.
pub fn intersection(first: &[DVec2], second: &[DVec2]) -> Vec<DVec2> {
    let mut part = first.to_vec();
    for i in 0..second.len() {
        part = left_of(&part, second[i], second[(i + 1) % second.len()]);
    }
    part
}

/// The interval `[t0, t1]` of the line `from + t (to - from)` inside a convex counter-clockwise polygon, within
/// `[t_min, t_max]`; `None` where they do not meet.
pub fn line_in_convex(
    from: DVec2,
    to: DVec2,
    corners: &[DVec2],
    (mut t_min, mut t_max): (f64, f64),
) -> Option<(f64, f64)> {
    let direction = to - from;
    for i in 0..corners.len() {
        let (p, q) = (corners[i], corners[(i + 1) % corners.len()]);
        let side = q - p;
        let (height, slope) = (side.perp_dot(from - p), side.perp_dot(direction));
        if slope > 0.0 {
            t_min = t_min.max(-height / slope);
        } else if slope < 0.0 {
            t_max = t_max.min(-height / slope);
        } else if height < 0.0 {
            return None;
        }
    }
    (t_min < t_max).then_some((t_min, t_max))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::convex::fixture::regular;
    use crate::geometry::polygon;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn a_line_divides_a_polygon_without_loss(p in regular(), a in -1.0..1.0, b in -1.0..1.0, angle in 0.0..6.3) {
            let from = DVec2::new(a, b);
            let to = from + DVec2::from_angle(angle);
            let parts = polygon::signed_area_2d_m2(&left_of(&p, from, to)) + polygon::signed_area_2d_m2(&left_of(&p, to, from));
            prop_assert!((parts - polygon::signed_area_2d_m2(&p)).abs() < 1e-12);
        }

        #[test]
        fn intersection_is_symmetric(p in regular(), q in regular()) {
            let (pq, qp) = (intersection(&p, &q), intersection(&q, &p));
            prop_assert!((polygon::signed_area_2d_m2(&pq) - polygon::signed_area_2d_m2(&qp)).abs() < 1e-12);
        }

        #[test]
        fn shared_sides_are_cut_at_the_same_bits(a in -1.0..1.0, b in -1.0..1.0, c in -1.0..1.0, h in -0.5..0.5) {
            let (p, q) = (DVec3::new(a, b, -1.0), DVec3::new(b, c, 1.0));
            let plane = Plane::through(DVec3::Z * h, DVec3::Z);
            let one = in_front_of(&[p, q, DVec3::X * 5.0], &plane, 0.0);
            let other = in_front_of(&[q, p, DVec3::X * -5.0], &plane, 0.0);
            prop_assert!(one.iter().any(|x| other.contains(x) && *x != q));
        }
    }

    #[test]
    fn a_line_through_a_square() {
        let square = [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)].map(DVec2::from);
        let whole = (f64::NEG_INFINITY, f64::INFINITY);
        assert_eq!(line_in_convex(DVec2::new(-1.0, 0.5), DVec2::new(0.0, 0.5), &square, whole), Some((1.0, 2.0)));
        assert_eq!(line_in_convex(DVec2::new(-1.0, 1.5), DVec2::new(0.0, 1.5), &square, whole), None);
        assert_eq!(
            line_in_convex(DVec2::new(-1.0, 0.5), DVec2::new(0.0, 0.5), &square, (0.0, 1.25)),
            Some((1.0, 1.25))
        );
    }
}
