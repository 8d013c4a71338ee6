//! Faces that meet a plane: what the tracing of a wedge (section 3.2 of the paper, its Fig. 2) has to look at.
//!
//! The caller narrows the plane to its wedge by a box test, for instance by the half-spaces that bound the wedge.
//!
//! Holds: every face that crosses or touches the plane within the wedge is found; some that only come near it may be
//! too, since boxes are tested and not faces. Ids ascend.

use std::ops::ControlFlow;

use glam::DVec3;

use super::Visibility;
use crate::geometry::Plane;
use crate::id::FaceId;

impl Visibility {
    /// Faces whose box straddles `plane`, within the coplanar tolerance, and passes `keep(min_m, max_m)`; ids ascend. A
    /// box that contains a passing box must pass `keep` too.
    pub fn faces_meeting_plane(&self, plane: &Plane, keep: impl Fn(DVec3, DVec3) -> bool) -> Vec<FaceId> {
        let slack_m = self.tolerance().coplanar_m();
        let meets = |min_m: DVec3, max_m: DVec3| {
            let reach_m = plane.normal.abs().dot(0.5 * (max_m - min_m));
            plane.signed_distance_m(0.5 * (min_m + max_m)).abs() <= reach_m + slack_m && keep(min_m, max_m)
        };
        let mut faces = Vec::new();
        self.walk(meets, |face| {
            faces.push(face);
            ControlFlow::Continue(())
        });
        faces.sort_unstable();
        faces
    }
}

#[cfg(test)]
mod tests {
    use super::super::fixture;
    use super::*;

    #[test]
    fn a_plane_meets_what_it_cuts_and_what_it_touches() {
        let at = |x: f64| [DVec3::ZERO, DVec3::X, DVec3::X + DVec3::Y, DVec3::Y].map(|p| p + x * DVec3::X).to_vec();
        let index = Visibility::new(&fixture::prepared(&[at(0.0), at(1.0), at(2.0), at(3.0)]));
        let meeting = |x: f64| {
            let plane = Plane::through(DVec3::X * x, DVec3::X);
            index.faces_meeting_plane(&plane, |_, _| true).into_iter().map(FaceId::index).collect::<Vec<_>>()
        };
        assert_eq!(meeting(1.5), [1]);
        assert_eq!(meeting(2.0), [1, 2]);
        assert!(meeting(5.0).is_empty());
    }

    #[test]
    fn the_callers_bound_narrows_the_plane() {
        let at = |y: f64| [DVec3::ZERO, DVec3::X, DVec3::X + DVec3::Y, DVec3::Y].map(|p| p + y * DVec3::Y).to_vec();
        let index = Visibility::new(&fixture::prepared(&[at(0.0), at(2.0), at(4.0)]));
        let plane = Plane::through(DVec3::X * 0.5, DVec3::X);
        let upper = index.faces_meeting_plane(&plane, |_, max_m| max_m.y > 1.5);
        assert_eq!(upper, [1, 2].map(FaceId::from));
    }
}
