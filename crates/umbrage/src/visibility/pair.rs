//! Faces that lie very near to each other: which of two is before the other, and what it covers.
//!
//! ```text
//!              ....---- B          Of the points of A next to the line in which it meets B, rounding would decide one by one which
//!      ....----                    side of B they are on: along 2 cm where the angle is 1e-5 and the scene 3 m large. Contacts
//!     --------------------- A      cut faces where they cross; so A as a whole is on one side, and each of its points is there, too.
//!
//!      =========== B               A narrow gap is closed: what is over the foot of a point, nearer than the gap that counts as
//!     --------------------- A      closed, covers it. No ray leaves sideways, and the border of what is covered is a contact.
//! ```
//!
//! Holds: the answer is the same for all points of a face; a face that has both sides of the other's plane has none, and then the
//! point's own place counts. What is in the gap, a lamp or the face itself, is seen from there as ever.

use std::ops::ControlFlow;

use glam::{DVec2, DVec3};
use smallvec::SmallVec;

use super::{PlaneView, ReceiverPoint, Visibility};
use crate::geometry::convex::{self, Convex};
use crate::geometry::{Plane, PlaneFrame, clip, polygon};
use crate::id::{FaceId, PlaneId};

/// The cosine of the angle between faces that may cover each other: 5.7 degrees. From the foot of a wedge of that angle a point sees
/// a quarter of a percent of what is outside.
const ALONG: f64 = 0.995;

/// Where a face lies, as seen from a face that is very near.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Placed {
    /// Not before it: it hides nothing from it.
    Behind,
    /// Before it; it is seen from its front.
    BeforeWithFront,
    /// Before it; it is seen from its back.
    BeforeWithBack,
    /// The one reaches through the plane of the other.
    Across,
}

impl Placed {
    /// Whether it is before the other, with either side.
    pub(crate) fn is_before(self) -> bool {
        matches!(self, Self::BeforeWithFront | Self::BeforeWithBack)
    }
}

/// The least and greatest height of corners over a plane, in metres.
fn heights_m(plane: &Plane, corners_m: &[DVec3]) -> [f64; 2] {
    range(corners_m.iter().map(|&corner| plane.signed_distance_m(corner)))
}

/// The least and the greatest of some values; where there is none, the first is greater.
fn range(values: impl Iterator<Item = f64>) -> [f64; 2] {
    values.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], value| [low.min(value), high.max(value)])
}

impl Visibility {
    /// Where `face` lies as seen from `receiver`.
    pub(crate) fn placed(&self, face: FaceId, receiver: FaceId) -> Placed {
        let near_m = self.tolerance().coplanar_m();
        let over_receiver_m @ [_, highest_m] = heights_m(self.near_plane(receiver), self.boundary_m(face));
        if highest_m <= near_m {
            return Placed::Behind;
        }
        if self.lie_along([face, receiver]) {
            return self.placed_along(face, receiver, over_receiver_m);
        }
        let [low_m, high_m] = heights_m(self.near_plane(face), self.boundary_m(receiver));
        match (low_m < -near_m, high_m > near_m) {
            (true, true) => Placed::Across,
            _ if low_m + high_m > 0.0 => Placed::BeforeWithFront,
            _ => Placed::BeforeWithBack,
        }
    }

    /// The same of faces that lie along each other, given the least and greatest height of the corners of the one over the other's
    /// plane, in metres. Where planes cross beside the part that the two have in common does not matter; a face that is over the other by no
    /// more than the tolerance of planes does not cover it.
    fn placed_along(&self, face: FaceId, receiver: FaceId, over_receiver_m: [f64; 2]) -> Placed {
        let near_m = self.tolerance().coplanar_m();
        let (plane, own) = (self.near_plane(face), self.near_plane(receiver));
        let along = plane.normal.dot(own.normal);
        let [low_m, high_m] = match over_receiver_m[0] < -near_m {
            true => range(self.common(face, receiver).iter().map(|&corner| -plane.signed_distance_m(corner) / along)),
            false => over_receiver_m,
        };
        match (low_m < -near_m, high_m > near_m) {
            (_, false) => Placed::Behind,
            (true, true) => Placed::Across,
            (false, true) if along < 0.0 => Placed::BeforeWithFront,
            (false, true) => Placed::BeforeWithBack,
        }
    }

    /// The ends of each side of a face.
    fn sides_m(&self, face: FaceId) -> impl Iterator<Item = (DVec3, DVec3)> + '_ {
        let boundary_m = self.boundary_m(face);
        boundary_m.iter().copied().zip(boundary_m.iter().copied().cycle().skip(1))
    }

    /// The part of another face that a face lies over.
    fn common(&self, face: FaceId, receiver: FaceId) -> SmallVec<[DVec3; 8]> {
        let normal = self.near_plane(face).normal;
        let all = self.boundary_m(receiver).iter().copied().collect();
        self.sides_m(face).fold(all, |left: SmallVec<[DVec3; 8]>, (a, b)| {
            clip::where_not_negative(&left, |p: DVec3| normal.dot((b - a).cross(p - a)))
        })
    }

    /// Whether two faces are so nearly parallel that one may cover the other.
    pub(crate) fn lie_along(&self, [one, other]: [FaceId; 2]) -> bool {
        self.near_plane(one).normal.dot(self.near_plane(other).normal).abs() > ALONG
    }

    /// Which side of a face a point of another face is on, if it is so near to the face's plane that it counts as its own face lies:
    /// `None` where it does not.
    pub(super) fn placed_at(&self, face: FaceId, receiver: FaceId, point_m: DVec3) -> Option<Placed> {
        let distance_m = self.near_plane(face).signed_distance_m(point_m).abs();
        if distance_m > self.tolerance().closed_m() || face == receiver {
            return None;
        }
        let along = self.lie_along([face, receiver]);
        if distance_m > self.tolerance().coplanar_m() && !along {
            return None;
        }
        match self.placed(face, receiver) {
            Placed::Across => None,
            // Beside what covers, it is seen from its edge.
            _ if along && !self.is_over(face, point_m) => Some(Placed::Behind),
            placed => Some(placed),
        }
    }

    /// Whether the foot of a point in the plane of a face lies in the face, or beyond its border by rounding: points of the mesh on an
    /// edge are rounded.
    pub(super) fn is_over(&self, face: FaceId, point_m: DVec3) -> bool {
        let (normal, slack_m) = (self.near_plane(face).normal, self.tolerance().coplanar_m());
        self.sides_m(face).all(|(a, b)| {
            let side = b - a;
            normal.dot(side.cross(point_m - a)) >= -slack_m * side.length()
        })
    }

    /// Whether the plane that a receiver point views lies so near over it that the gap counts as closed.
    pub(crate) fn is_in_closed_gap(&self, receiver: &ReceiverPoint, view: &PlaneView) -> bool {
        receiver.face.is_some_and(|own| !self.covering(own).is_empty())
            && view.height_m <= self.tolerance().closed_m()
            && view.normal.z.abs() > ALONG
    }

    /// What a receiver point in a closed gap sees of a convex polygon in the plane across it: the part that its own face lies over. No
    /// light passes sideways.
    pub(super) fn across_gap(&self, receiver: &ReceiverPoint, frame: &PlaneFrame, polygon: Convex) -> Convex {
        let Some(own) = receiver.face else { return polygon };
        let mut own: Convex = self.boundary_m(own).iter().map(|&corner| frame.to_2d(corner)).collect();
        if polygon::signed_area_2d_m2(&own) < 0.0 {
            own.reverse();
        }
        let beside = |left: Convex, (from, to): (DVec2, DVec2)| {
            clip::where_not_negative(&left, |p: DVec2| (to - from).perp_dot(p - from)).into_iter().collect()
        };
        convex::sides(&own).fold(polygon, beside)
    }

    /// The faces that lie along a face, before it, and somewhere nearer than a gap that is closed.
    pub(super) fn lying_over(&self, own: FaceId) -> Box<[FaceId]> {
        let closed_m = self.tolerance().closed_m();
        let [low_m, high_m] = self.bounds_m(own);
        let mut over = Vec::new();
        self.walk(
            |min_m, max_m| min_m.cmple(high_m + closed_m).all() && max_m.cmpge(low_m - closed_m).all(),
            |face| {
                let lies_over = self.plane(face) != self.plane(own)
                    && self.lie_along([face, own])
                    && heights_m(self.near_plane(own), self.boundary_m(face))[0] <= closed_m
                    && self.placed(face, own).is_before();
                over.extend(lies_over.then_some(face));
                ControlFlow::Continue(())
            },
        );
        over.sort_unstable();
        over.into()
    }

    /// A face that covers a receiver point from another point, which is not in the gap; faces in the plane `source` do not.
    pub(super) fn cover(&self, receiver: &ReceiverPoint, to_m: DVec3, source: Option<PlaneId>) -> Option<FaceId> {
        let own = receiver.face?;
        let covers = |face: &FaceId| {
            Some(self.plane(*face)) != source
                && self.covers(*face, receiver) == Some(true)
                && self.crossing(*face, (receiver.position_m, Some(own)), to_m).is_some()
        };
        self.covering(own).iter().copied().find(covers)
    }

    /// Whether a receiver point lies in a closed gap: beneath a face that covers it.
    pub(crate) fn is_covered(&self, receiver: &ReceiverPoint) -> bool {
        let covers =
            |&face: &FaceId| self.covers(face, receiver) == Some(true) && self.is_over(face, receiver.position_m);
        receiver.face.is_some_and(|own| self.covering(own).iter().any(covers))
    }

    /// Whether a face that lies along that of a receiver point, and very near, covers it; `None` where it does not lie so.
    pub(super) fn covers(&self, face: FaceId, receiver: &ReceiverPoint) -> Option<bool> {
        let own = receiver.face?;
        let distance_m = self.near_plane(face).signed_distance_m(receiver.position_m).abs();
        if distance_m > self.tolerance().closed_m() || !self.lie_along([face, own]) {
            return None;
        }
        self.placed_at(face, own, receiver.position_m).map(|placed| placed != Placed::Behind)
    }
}
