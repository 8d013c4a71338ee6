//! What stands between a receiver point and another point: the faces around a point of a smooth surface as seen from its near view, all
//! others as seen from the point ([`super::receiver`]).

use glam::DVec3;

use super::{ReceiverPoint, Visibility};
use crate::id::{FaceId, PlaneId};

impl Visibility {
    /// The faces that a receiver point sees from its near view, ascending.
    pub(super) fn near(&self, receiver: &ReceiverPoint) -> &[FaceId] {
        receiver.near.map_or(&[], |near| self.around().of(near.face))
    }

    /// Whether a receiver point sees a face from its near view.
    pub(super) fn is_near(&self, receiver: &ReceiverPoint, face: FaceId) -> bool {
        receiver.near.is_some() && self.near(receiver).binary_search(&face).is_ok()
    }

    /// A face that stands between a receiver point and another point, of some faces, or of all where none are given. Faces in the
    /// plane of the `source` that the other point belongs to do not.
    pub(crate) fn stopper(
        &self,
        receiver: &ReceiverPoint,
        to_m: DVec3,
        source: Option<PlaneId>,
        among: Option<&[FaceId]>,
    ) -> Option<FaceId> {
        let stops = |face: &&FaceId| self.stops(**face, receiver, to_m, source);
        if let Some(&near) = self.near(receiver).iter().find(stops) {
            return Some(near);
        }
        if let Some(cover) = self.cover(receiver, to_m, source) {
            return Some(cover);
        }
        let passing = [receiver.plane, source.unwrap_or(receiver.plane)];
        let from = (receiver.position_m, receiver.face);
        self.blocker_but(among, from, to_m, passing, |face| self.is_near(receiver, face))
    }

    /// Whether a face stands between a receiver point and another point.
    pub(crate) fn stops(&self, face: FaceId, receiver: &ReceiverPoint, to_m: DVec3, source: Option<PlaneId>) -> bool {
        let plane = self.plane(face);
        if source == Some(plane) {
            return false;
        }
        match receiver.near {
            Some(near) if self.is_near(receiver, face) => self.is_crossed(face, (near.from_m, None), to_m),
            _ => plane != receiver.plane && self.is_crossed(face, (receiver.position_m, receiver.face), to_m),
        }
    }
}
