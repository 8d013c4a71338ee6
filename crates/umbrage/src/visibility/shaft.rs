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
use crate::id::{FaceId, PlaneId};

impl Visibility {
    /// Whether a face may stand between a point of `receiver` and a point of `source`.
    pub fn may_be_blocked(&self, receiver: &SourcePolygon, source: &SourcePolygon) -> bool {
        let mut blocked = false;
        self.walk_shaft(&Shaft::new(receiver, source, self.tolerance().coplanar_m()), None, |_| {
            blocked = true;
            ControlFlow::Break(())
        });
        blocked
    }

    /// The faces that may stand between a point of `receiver` and a point of `source`.
    pub fn faces_between(&self, receiver: &SourcePolygon, source: &SourcePolygon) -> Vec<FaceId> {
        self.faces_in(&Shaft::new(receiver, source, self.tolerance().coplanar_m()), None)
    }

    /// The faces, of some or of all, that the beam from any point of `receiver` to `source` may meet: those that only touch the shaft
    /// are among them.
    pub fn faces_around(
        &self,
        receiver: &SourcePolygon,
        source: &SourcePolygon,
        among: Option<&[FaceId]>,
    ) -> Vec<FaceId> {
        let coplanar_m = self.tolerance().coplanar_m();
        self.faces_in(&Shaft { least_m: -coplanar_m, ..Shaft::new(receiver, source, coplanar_m) }, among)
    }

    fn faces_in(&self, shaft: &Shaft, among: Option<&[FaceId]>) -> Vec<FaceId> {
        let mut faces = Vec::new();
        self.walk_shaft(shaft, among, |face| {
            faces.push(face);
            ControlFlow::Continue(())
        });
        faces
    }

    fn walk_shaft(&self, shaft: &Shaft, among: Option<&[FaceId]>, mut visit: impl FnMut(FaceId) -> ControlFlow<()>) {
        let meets = |min_m: DVec3, max_m: DVec3| shaft.meets(min_m, max_m);
        self.walk_among(
            among,
            |aabb| meets(aabb.min.as_dvec3(), aabb.max.as_dvec3()),
            meets,
            |face| {
                let apart = shaft.planes.contains(&self.plane(face)) || shaft.is_apart(self.boundary_m(face));
                if apart { ControlFlow::Continue(()) } else { visit(face) }
            },
        );
    }
}

/// The shaft between two polygons.
struct Shaft {
    /// Its sides, inward.
    inward: Vec<Plane>,
    /// The box around both polygons, in metres.
    low_m: DVec3,
    high_m: DVec3,
    /// What does not rise over a side by more than this is beyond it, in metres.
    least_m: f64,
    /// The planes of the polygons: their faces block nothing.
    planes: [PlaneId; 2],
}

impl Shaft {
    /// The shaft without what intrudes by no more than a slack, in metres.
    fn new(receiver: &SourcePolygon, source: &SourcePolygon, slack_m: f64) -> Self {
        let mut inward = vec![receiver.oriented_plane, source.oriented_plane];
        add_side_planes(&mut inward, &receiver.corners_m, &source.corners_m, slack_m);
        add_side_planes(&mut inward, &source.corners_m, &receiver.corners_m, slack_m);
        let both = || receiver.corners_m.iter().chain(&source.corners_m).copied();
        let [low_m, high_m] = [both().fold(DVec3::INFINITY, DVec3::min), both().fold(DVec3::NEG_INFINITY, DVec3::max)];
        Self { inward, low_m, high_m, least_m: slack_m, planes: [receiver.plane, source.plane] }
    }

    fn meets(&self, min_m: DVec3, max_m: DVec3) -> bool {
        let (middle, half) = (0.5 * (min_m + max_m), 0.5 * (max_m - min_m));
        let around_m = (-self.least_m).max(0.0);
        min_m.cmple(self.high_m + around_m).all()
            && max_m.cmpge(self.low_m - around_m).all()
            && self
                .inward
                .iter()
                .all(|side| side.signed_distance_m(middle) + side.normal.abs().dot(half) > self.least_m)
    }

    /// Whether a polygon is wholly beyond a side.
    fn is_apart(&self, corners_m: &[DVec3]) -> bool {
        let beyond = |side: &Plane| corners_m.iter().all(|&corner| side.signed_distance_m(corner) <= self.least_m);
        self.inward.iter().any(beyond)
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
    use crate::geometry::polygon;
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
                let lamp = FlatSource::of_face(&prepared, FaceId::from(1));
                let view = index.view(&point, &lamp);
                let seen = view.map(|view| index.seen(&point, view, &lamp, None)).unwrap_or_default();
                prop_assert!(seen.whole && seen.shadows.is_empty() && !seen.is_nothing());
            }
        }

        #[test]
        fn what_is_not_around_a_shaft_throws_no_shadow_in_it(
            corners in prop::collection::vec((-2.0..2.0, -2.0..2.0, -0.5..2.5), 3..30),
            x in -1.0..1.0, y in -1.0..1.0, half in 0.05..1.0,
        ) {
            let floor = square(DVec3::ZERO, 1.0, true);
            let mut polygons = vec![floor, square(DVec3::Z * 2.0, 0.5, false)];
            let triangles = corners.chunks_exact(3);
            polygons.extend(triangles.map(|of| of.iter().map(|&c| fixture::f32_point(DVec3::from(c))).collect()));
            prop_assume!(polygons[2..].iter().all(|of: &Vec<DVec3>| (of[1] - of[0]).cross(of[2] - of[0]).length() > 1e-3));
            let prepared = fixture::prepared(&polygons);
            let (index, floor, lamp) = (Visibility::new(&prepared), FaceId::from(0), FaceId::from(1));
            // A part of the floor, and a smaller one inside it.
            let part = |half: f64| {
                let corners_m = square(DVec3::new(0.5 * x, 0.5 * y, 0.0), half, true);
                SourcePolygon::on_face(&prepared, floor, corners_m.iter().map(|p| *p - prepared.origin_m).collect())
            };
            let source = SourcePolygon::of_face(&prepared, lamp);
            let around = index.faces_around(&part(half), &source, None);
            let closer = index.faces_around(&part(0.4 * half), &source, Some(&around));
            prop_assert!(closer.len() <= around.len());
            let flat = FlatSource::of_face(&prepared, lamp);
            for [s, t] in [[0.0, 0.0], [0.99, 0.99], [-0.99, 0.6], [0.3, -0.99]] {
                for (half, among) in [(half, &around), (0.4 * half, &closer)] {
                    let at_m = DVec3::new(0.5 * x + s * half, 0.5 * y + t * half, 0.0) - prepared.origin_m;
                    let point = ReceiverPoint::on_face(&prepared, floor, at_m);
                    let Some(view) = index.view(&point, &flat) else { continue };
                    let area = |among| index.seen(&point, view, &flat, among).measure(polygon::signed_area_2d_m2);
                    let [past_some, past_all] = [area(Some(among.as_slice())), area(None)];
                    prop_assert!((past_some - past_all).abs() < 1e-12, "{past_some} is not {past_all}");
                }
            }
        }
    }
}
