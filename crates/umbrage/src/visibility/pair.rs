//! Faces that are nearer to each other than points are exact: which of two is before the other.
//!
//! ```text
//!              ....---- B          Of the points of A next to the line in which it meets B, rounding would decide one by one which
//!      ....----                    side of B they are on: along 2 cm where the angle is 1e-5 and the scene 3 m large. Contacts
//!     --------------------- A      cut faces where they cross; so A as a whole is on one side, and each of its points is there, too.
//! ```
//!
//! Asked for points of a face that are nearer to the plane of another face than the coplanar tolerance, and by beams for those within
//! the weld distance, which take what is so near to the receiver for a contact.
//!
//! Holds: the answer is the same for all points of a face; a face that has both sides of the other's plane has none, and then the
//! point's own place counts.

use glam::DVec3;

use super::{ReceiverPoint, Visibility};
use crate::geometry::Plane;
use crate::id::FaceId;

/// Faces with normals whose cosine is less than this, either way, do not cover each other: they meet in an edge, like floor and wall.
const ALONG: f64 = 0.7;

/// Where a face lies, as seen from a face that is very near.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Placed {
    /// Not before it: it hides nothing from it.
    Behind,
    /// Before it; it is seen from its front.
    BeforeWithFront,
    /// Before it; it is seen from its back.
    BeforeWithBack,
    /// The one reaches through the plane of the other.
    Across,
}

/// The least and greatest height of corners over a plane, in metres.
fn heights_m(plane: &Plane, corners_m: &[DVec3]) -> [f64; 2] {
    let heights = corners_m.iter().map(|&corner| plane.signed_distance_m(corner));
    heights.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], height| [low.min(height), high.max(height)])
}

impl Visibility {
    /// Where `face` lies as seen from `receiver`.
    fn placed(&self, face: FaceId, receiver: FaceId) -> Placed {
        let near_m = self.tolerance().coplanar_m();
        let [_, over_receiver_m] = heights_m(self.near_plane(receiver), self.boundary_m(face));
        if over_receiver_m <= near_m {
            return Placed::Behind;
        }
        let [low_m, high_m] = heights_m(self.near_plane(face), self.boundary_m(receiver));
        match (low_m < -near_m, high_m > near_m) {
            (true, true) => Placed::Across,
            _ if low_m + high_m > 0.0 => Placed::BeforeWithFront,
            _ => Placed::BeforeWithBack,
        }
    }

    /// Which side of a face a point of another face is on, if it is so near to the face's plane that it counts as its own face lies:
    /// `None` where it does not.
    pub(super) fn placed_at(&self, face: FaceId, receiver: FaceId, point_m: DVec3) -> Option<Placed> {
        let is_near = self.near_plane(face).signed_distance_m(point_m).abs() <= self.tolerance().coplanar_m();
        (is_near && face != receiver).then(|| self.placed(face, receiver)).filter(|&placed| placed != Placed::Across)
    }

    /// Whether the foot of a point in the plane of a face lies in the face, or beyond its border by rounding: points of the mesh on an
    /// edge are rounded.
    pub(super) fn is_over(&self, face: FaceId, point_m: DVec3) -> bool {
        let (normal, slack_m) = (self.near_plane(face).normal, self.tolerance().coplanar_m());
        let boundary_m = self.boundary_m(face);
        let next = boundary_m.iter().cycle().skip(1);
        boundary_m.iter().zip(next).all(|(&a, &b)| {
            let side = b - a;
            normal.dot(side.cross(point_m - a)) >= -slack_m * side.length()
        })
    }

    /// Whether a face lies on a receiver point: within the weld distance before it, and over it.
    pub(super) fn covers(&self, face: FaceId, receiver: &ReceiverPoint) -> bool {
        let Some(own) = receiver.face else { return false };
        let (plane, point_m) = (self.near_plane(face), receiver.position_m);
        plane.signed_distance_m(point_m).abs() <= self.tolerance().weld_m()
            && plane.normal.dot(self.near_plane(own).normal).abs() > ALONG
            && self.is_over(face, point_m)
            && matches!(self.placed(face, own), Placed::BeforeWithFront | Placed::BeforeWithBack)
    }
}

