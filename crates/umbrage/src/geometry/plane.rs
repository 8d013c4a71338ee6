//! Oriented planes and the two-dimensional frames in them.

use glam::{DVec2, DVec3};
use serde::{Deserialize, Serialize};

use super::polygon;

/// The points `p` with `normal . p = offset_m`.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Plane {
    /// Unit normal, towards the front.
    pub normal: DVec3,
    /// Signed distance of the plane from the origin along the normal, in metres.
    pub offset_m: f64,
}

impl Plane {
    /// The plane through `point` with the unit normal `normal`.
    pub fn through(point: DVec3, normal: DVec3) -> Self {
        Self { normal, offset_m: normal.dot(point) }
    }

    /// The plane of a polygon by Newell's normal through its mean corner; `None` where it has no area.
    pub fn of_polygon(corners: &[DVec3]) -> Option<Self> {
        let normal = polygon::doubled_area_vector(corners).try_normalize()?;
        let mean = corners.iter().sum::<DVec3>() / corners.len() as f64;
        Some(Self::through(mean, normal))
    }

    /// Distance of `point` from the plane, positive in front, in metres.
    pub fn signed_distance_m(&self, point: DVec3) -> f64 {
        self.normal.dot(point) - self.offset_m
    }

    /// The same plane looking the other way.
    pub fn flipped(&self) -> Self {
        Self { normal: -self.normal, offset_m: -self.offset_m }
    }

    /// The foot of the perpendicular from `point`.
    pub fn project(&self, point: DVec3) -> DVec3 {
        point - self.signed_distance_m(point) * self.normal
    }
}

/// A right-handed frame in a plane: `u x v` is the plane's normal. Coordinates are metres.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct PlaneFrame {
    /// The plane that the frame lies in.
    pub plane: Plane,
    /// Origin of the frame, in the plane.
    pub origin: DVec3,
    /// First axis, a unit vector.
    pub u: DVec3,
    /// Second axis, a unit vector.
    pub v: DVec3,
}

impl PlaneFrame {
    /// A frame in `plane` with its origin at the foot of `near`, so that coordinates stay small.
    pub fn new(plane: Plane, near: DVec3) -> Self {
        let (u, v) = plane.normal.any_orthonormal_pair();
        Self { plane, origin: plane.project(near), u, v }
    }

    /// Coordinates of the foot of `point` in the frame.
    pub fn to_2d(&self, point: DVec3) -> DVec2 {
        let d = point - self.origin;
        DVec2::new(d.dot(self.u), d.dot(self.v))
    }

    /// The point of the plane with these coordinates.
    pub fn to_3d(&self, point: DVec2) -> DVec3 {
        self.origin + self.u * point.x + self.v * point.y
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn vector() -> impl Strategy<Value = DVec3> {
        (-1.0..1.0, -1.0..1.0, -1.0..1.0).prop_map(DVec3::from)
    }

    proptest! {
        #[test]
        fn a_frame_is_right_handed_and_round_trips(n in vector(), near in vector(), p in vector()) {
            prop_assume!(n.length() > 0.1);
            let plane = Plane::through(near, n.normalize());
            let frame = PlaneFrame::new(plane, near);
            prop_assert!((frame.u.cross(frame.v) - plane.normal).length() < 1e-14);
            let foot = plane.project(p);
            prop_assert!(plane.signed_distance_m(foot).abs() < 1e-14);
            prop_assert!((frame.to_3d(frame.to_2d(p)) - foot).length() < 1e-14);
        }
    }

    #[test]
    fn a_counter_clockwise_square_looks_at_its_viewer() {
        let square = [DVec3::ZERO, DVec3::X, DVec3::X + DVec3::Y, DVec3::Y];
        let plane = Plane::of_polygon(&square).unwrap();
        assert_eq!(plane.normal, DVec3::Z);
        assert!(Plane::of_polygon(&[DVec3::ZERO, DVec3::X, DVec3::X * 2.0]).is_none());
    }
}
