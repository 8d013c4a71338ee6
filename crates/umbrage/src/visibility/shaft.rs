//! The shaft between two polygons: whether any face can stand between any of their points (Haines and Wallace, *Shaft
//! culling for efficient ray-traced radiosity*, 1991).
//!
//! The shaft is the convex hull of both polygons, in front of both planes. Its side planes pass through an edge of one
//! polygon and a corner of the other and have both on one side; a face that lies wholly beyond one of them, or behind
//! one of the two polygons' planes, blocks nothing.
//!
//! Holds after: where the answer is no, every point of the one sees every point of the other that is in front of it,
//! but for what intrudes by less than the coplanar tolerance. A yes may be too careful.

use std::ops::ControlFlow;

use glam::DVec3;

use super::{SourcePolygon, Visibility};
use crate::geometry::Plane;
use crate::id::FaceId;

impl Visibility {
    /// Whether a face may stand between a point of `receiver` and a point of `source`.
    pub fn may_be_blocked(&self, receiver: &SourcePolygon, source: &SourcePolygon) -> bool {
        let mut blocked = false;
        self.walk_shaft(receiver, source, |_| {
            blocked = true;
            ControlFlow::Break(())
        });
        blocked
    }

    /// The faces that may stand between a point of `receiver` and a point of `source`.
    pub fn faces_between(&self, receiver: &SourcePolygon, source: &SourcePolygon) -> Vec<FaceId> {
        let mut faces = Vec::new();
        self.walk_shaft(receiver, source, |face| {
            faces.push(face);
            ControlFlow::Continue(())
        });
        faces
    }

    fn walk_shaft(
        &self,
        receiver: &SourcePolygon,
        source: &SourcePolygon,
        mut visit: impl FnMut(FaceId) -> ControlFlow<()>,
    ) {
        let slack_m = self.tolerance().coplanar_m();
        let mut inward = vec![receiver.oriented_plane, source.oriented_plane];
        add_side_planes(&mut inward, &receiver.corners_m, &source.corners_m, slack_m);
        add_side_planes(&mut inward, &source.corners_m, &receiver.corners_m, slack_m);
        let both = || receiver.corners_m.iter().chain(&source.corners_m).copied();
        let (lo_m, hi_m) = (both().fold(DVec3::INFINITY, DVec3::min), both().fold(DVec3::NEG_INFINITY, DVec3::max));
        let meets = |min_m: DVec3, max_m: DVec3| {
            let (middle, half) = (0.5 * (min_m + max_m), 0.5 * (max_m - min_m));
            min_m.cmple(hi_m).all()
                && max_m.cmpge(lo_m).all()
                && inward.iter().all(|plane| plane.signed_distance_m(middle) + plane.normal.abs().dot(half) > slack_m)
        };
        self.walk(meets, |face| {
            let plane = self.plane(face);
            let apart = plane == receiver.plane
                || plane == source.plane
                || inward
                    .iter()
                    .any(|side| self.boundary_m(face).iter().all(|&corner| side.signed_distance_m(corner) <= slack_m));
            if apart { ControlFlow::Continue(()) } else { visit(face) }
        });
    }
}

/// Adds the planes through an edge of `edges` and a corner of `corners` that have both polygons on their inner side.
fn add_side_planes(inward: &mut Vec<Plane>, edges: &[DVec3], corners: &[DVec3], slack_m: f64) {
    for i in 0..edges.len() {
        let (from, to) = (edges[i], edges[(i + 1) % edges.len()]);
        for &corner in corners {
            let Some(normal) = (to - from).cross(corner - from).try_normalize() else { continue };
            let heights = || edges.iter().chain(corners).map(|&p| normal.dot(p - from));
            if heights().all(|height| height >= -slack_m) {
                inward.push(Plane::through(from, normal));
            } else if heights().all(|height| height <= slack_m) {
                inward.push(Plane::through(from, -normal));
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::fixture::{self, square};
    use super::super::{FlatSource, ReceiverPoint};
    use super::*;
    use proptest::prelude::*;

    fn may_be_blocked(occluder: Vec<DVec3>) -> bool {
        let prepared =
            fixture::prepared(&[square(DVec3::ZERO, 1.0, true), square(DVec3::Z * 2.0, 0.5, false), occluder]);
        let [receiver, source] = [0, 1].map(|face| SourcePolygon::of_face(&prepared, FaceId::from(face)));
        Visibility::new(&prepared).may_be_blocked(&receiver, &source)
    }

    #[test]
    fn only_what_reaches_into_the_shaft_blocks() {
        assert!(may_be_blocked(square(DVec3::Z, 0.01, true)));
        assert!(may_be_blocked(square(DVec3::new(0.8, 0.0, 1.0), 0.1, true)));
        assert!(!may_be_blocked(square(DVec3::new(0.9, 0.0, 1.0), 0.1, true)));
        assert!(!may_be_blocked(square(DVec3::new(0.0, 0.0, -0.1), 0.1, true)));
        assert!(!may_be_blocked(square(DVec3::new(0.0, 0.0, 2.1), 0.1, true)));
    }

    proptest! {
        #[test]
        fn an_empty_shaft_hides_nothing(
            corners in prop::collection::vec((-2.0..2.0, -2.0..2.0, -0.5..2.5), 3),
            x in -1.0..1.0, y in -1.0..1.0,
        ) {
            let occluder: Vec<DVec3> = corners.iter().map(|&c| fixture::f32_point(DVec3::from(c))).collect();
            prop_assume!((occluder[1] - occluder[0]).cross(occluder[2] - occluder[0]).length() > 1e-3);
            let prepared =
                fixture::prepared(&[square(DVec3::ZERO, 1.0, true), square(DVec3::Z * 2.0, 0.5, false), occluder]);
            let index = Visibility::new(&prepared);
            let [receiver, source] = [0, 1].map(|face| SourcePolygon::of_face(&prepared, FaceId::from(face)));
            if !index.may_be_blocked(&receiver, &source) {
                let point = ReceiverPoint::on_face(&prepared, FaceId::from(0), DVec3::new(x, y, 0.0));
                let seen = index.seen(&point, &FlatSource::of_face(&prepared, FaceId::from(1)));
                prop_assert!(seen.whole && seen.shadows.is_empty() && !seen.is_nothing());
            }
        }
    }
}
