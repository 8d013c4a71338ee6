//! Point to polygon: the exact visible part of a polygonal source, seen from a receiver point.
//!
//! From a point, the visible part of a source is the source minus all occluders, projected onto it. The beam is the
//! pyramid from the point over the source:
//!
//! ```text
//!        source, clipped to the receiver's horizon
//!      ____________
//!      \   |##|   /     ##  shadow of an occluder, as seen from the point
//!       \  |  |  /
//!        \ ====  /      ==  occluder: a face whose box meets the beam
//!         \    /
//!          \  /
//!   ________\/_________ receiver
//! ```
//!
//! How: the faces that the index finds in the beam are projected ([`super::project`]) to an integer grid in the source's
//! plane, where their union is taken from the source exactly ([`super::shadow`]). The same point of space has the same
//! grid point whatever face it belongs to, so faces that share an edge leave no hairline between them.
//!
//! Holds after: contours run counter-clockwise seen from the source's front, holes clockwise, all in the source's plane
//! and not below the receiver's horizon; what is wholly dark is [`VisiblePart::Nothing`], exactly.
//!
//! Faces in the plane of receiver or source never occlude; occluder corners nearer to the receiver's plane than the weld
//! tolerance count as below it, so that nothing shines through beneath what stands on it.

use std::ops::ControlFlow;

use glam::DVec3;

use super::Visibility;
use super::project::SourceView;
use super::shadow::{self, Cover};
use crate::geometry::{Plane, clip};
use crate::id::{FaceId, PlaneId};
use crate::prepare::Prepared;

/// A point that receives light.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ReceiverPoint {
    /// Where it is, in its plane, in metres.
    pub position_m: DVec3,
    /// Unit normal of the side that is lit.
    pub normal: DVec3,
    /// The plane that it lies in: the plane's faces do not shade it.
    pub plane: PlaneId,
}

impl ReceiverPoint {
    /// The point of `face` at the foot of `near_m`.
    pub fn on_face(prepared: &Prepared, face: FaceId, near_m: DVec3) -> Self {
        let plane = prepared.oriented_plane(face);
        Self { position_m: plane.project(near_m), normal: plane.normal, plane: prepared.faces[face].plane }
    }
}

/// A convex polygon that sends light, a face or a part of one.
#[derive(Clone, Debug, PartialEq)]
pub struct SourcePolygon {
    /// Its corners, counter-clockwise seen from the front, in metres.
    pub corners_m: Vec<DVec3>,
    /// Its plane, the front towards which it sends.
    pub oriented_plane: Plane,
    /// The plane that it lies in: the plane's faces do not shade it.
    pub plane: PlaneId,
}

impl SourcePolygon {
    /// The polygon `corners_m` of `face`.
    pub fn on_face(prepared: &Prepared, face: FaceId, corners_m: Vec<DVec3>) -> Self {
        Self { corners_m, oriented_plane: prepared.oriented_plane(face), plane: prepared.faces[face].plane }
    }

    /// The whole of `face`.
    pub fn of_face(prepared: &Prepared, face: FaceId) -> Self {
        Self::on_face(prepared, face, prepared.polygon_m(face))
    }

    /// Distance of the farthest corner from `middle_m`.
    pub fn reach_m(&self, middle_m: DVec3) -> f64 {
        self.corners_m.iter().map(|corner_m| corner_m.distance(middle_m)).fold(0.0, f64::max)
    }

    /// One of `count` points inside, half way from the middle to corners that are spread around.
    pub fn inner_point_m(&self, middle_m: DVec3, number: usize, count: usize) -> DVec3 {
        middle_m.midpoint(self.corners_m[number * self.corners_m.len() / count])
    }
}

/// Closed oriented contours in space: outer ones counter-clockwise, holes clockwise.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Contours {
    corners_m: Vec<DVec3>,
    ends: Vec<u32>,
}

impl Contours {
    /// Adds a contour.
    pub fn push(&mut self, corners_m: impl IntoIterator<Item = DVec3>) {
        self.corners_m.extend(corners_m);
        self.ends.push(self.corners_m.len() as u32);
    }

    /// The contours, each a list of corners in metres.
    pub fn iter(&self) -> impl Iterator<Item = &[DVec3]> {
        let starts = std::iter::once(0).chain(self.ends.iter().copied());
        starts.zip(&self.ends).map(|(start, &end)| &self.corners_m[start as usize..end as usize])
    }
}

/// What a receiver point sees of a source.
#[derive(Clone, Debug, PartialEq)]
pub enum VisiblePart {
    /// Nothing: behind it, below the horizon, or wholly in shadow.
    Nothing,
    /// All that is above the horizon: no occluder takes anything.
    Whole(Vec<DVec3>),
    /// A part.
    Part(Contours),
}

impl Visibility {
    /// The part of `source` that `receiver` sees.
    pub fn visible_part(&self, receiver: &ReceiverPoint, source: &SourcePolygon) -> VisiblePart {
        // Never `None` where any number of shadows will do.
        self.visible_part_past(receiver, source, usize::MAX).unwrap_or(VisiblePart::Nothing)
    }

    /// The part of `source` that `receiver` sees, unless more than `most_shadows` occluders take something of it: then its
    /// parts are quicker to look at one by one.
    pub fn visible_part_past(
        &self,
        receiver: &ReceiverPoint,
        source: &SourcePolygon,
        most_shadows: usize,
    ) -> Option<VisiblePart> {
        let position_m = receiver.position_m;
        if receiver.plane == source.plane || source.oriented_plane.signed_distance_m(position_m) <= 0.0 {
            return Some(VisiblePart::Nothing);
        }
        let horizon = Plane::through(position_m, receiver.normal);
        let above = clip::in_front_of(&source.corners_m, &horizon, 0.0);
        let Some(view) = SourceView::new(position_m, horizon, source.oriented_plane, &above, self.tolerance().weld_m())
        else {
            return Some(VisiblePart::Nothing);
        };
        let mut shadows = Vec::new();
        let mut dark = false;
        self.walk(
            |min_m, max_m| view.box_may_occlude(min_m, max_m),
            |face| {
                let plane = self.plane(face);
                if plane == receiver.plane || plane == source.plane {
                    return ControlFlow::Continue(());
                }
                if let Some(outline) = view.project(self.boundary_m(face)) {
                    match shadow::cover(&outline, view.source()) {
                        Cover::All => {
                            dark = true;
                            return ControlFlow::Break(());
                        }
                        Cover::None => {}
                        Cover::Some => shadows.push(outline),
                    }
                }
                if shadows.len() > most_shadows { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
            },
        );
        if dark {
            return Some(VisiblePart::Nothing);
        }
        if shadows.len() > most_shadows {
            return None;
        }
        if shadows.is_empty() {
            return Some(VisiblePart::Whole(above));
        }
        let mut lit = Contours::default();
        for contour in shadow::source_minus_shadows(view.source(), &shadows) {
            lit.push(contour.into_iter().map(|p| view.to_3d(p)));
        }
        Some(if lit.ends.is_empty() { VisiblePart::Nothing } else { VisiblePart::Part(lit) })
    }
}

#[cfg(test)]
mod tests {
    use super::super::fixture::{self, square};
    use super::*;
    use crate::geometry::polygon;
    use glam::DQuat;
    use proptest::prelude::*;

    /// A scene whose last face is the source.
    struct Stage {
        prepared: Prepared,
        index: Visibility,
        source: SourcePolygon,
    }

    fn stage(polygons: &[Vec<DVec3>]) -> Stage {
        let prepared = fixture::prepared(polygons);
        let index = Visibility::new(&prepared);
        let last = FaceId::from(prepared.faces.len() - 1);
        let source = SourcePolygon::of_face(&prepared, last);
        Stage { prepared, index, source }
    }

    impl Stage {
        fn seen_from(&self, face: usize, near: DVec3) -> VisiblePart {
            let receiver = ReceiverPoint::on_face(&self.prepared, FaceId::from(face), near);
            self.index.visible_part(&receiver, &self.source)
        }

        fn share_from_face(&self, face: usize, near: DVec3) -> f64 {
            area_m2(&self.seen_from(face, near), self.source.oriented_plane.normal)
                / polygon::area_m2(&self.source.corners_m)
        }
    }

    fn area_m2(part: &VisiblePart, normal: DVec3) -> f64 {
        let signed = |corners: &[DVec3]| 0.5 * polygon::doubled_area_vector(corners).dot(normal);
        match part {
            VisiblePart::Nothing => 0.0,
            VisiblePart::Whole(corners) => signed(corners),
            VisiblePart::Part(contours) => contours.iter().map(signed).sum(),
        }
    }

    fn floor() -> Vec<DVec3> {
        square(DVec3::ZERO, 4.0, true)
    }

    fn lamp() -> Vec<DVec3> {
        square(DVec3::Z * 3.0, 0.5, false)
    }

    #[test]
    fn nothing_between_leaves_the_whole() {
        let stage = stage(&[floor(), lamp()]);
        assert_eq!(stage.seen_from(0, DVec3::X), VisiblePart::Whole(lamp()));
    }

    #[test]
    fn behind_the_source_and_in_its_plane_nothing_is_seen() {
        let stage = stage(&[floor(), square(DVec3::new(2.0, 0.0, 3.0), 1.0, true), square(DVec3::Z * 3.0, 0.5, true)]);
        assert_eq!(stage.seen_from(0, DVec3::X), VisiblePart::Nothing);
        assert_eq!(stage.seen_from(1, DVec3::new(2.0, 0.0, 3.0)), VisiblePart::Nothing);
    }

    #[test]
    fn a_plate_takes_what_it_covers() {
        let stage = stage(&[floor(), square(DVec3::Z * 1.5, 0.125, true), lamp()]);
        assert!((stage.share_from_face(0, DVec3::ZERO) - (1.0 - 0.25)).abs() < 1e-8);
        assert!((stage.share_from_face(0, DVec3::X * 0.5) - (1.0 - 0.125)).abs() < 1e-8);
        assert_eq!(stage.share_from_face(0, DVec3::X * 1.5), 1.0);
    }

    #[test]
    fn a_plate_with_the_sources_outline_makes_it_exactly_dark() {
        let stage = stage(&[floor(), square(DVec3::Z * 1.5, 0.25, true), lamp()]);
        assert_eq!(stage.seen_from(0, DVec3::ZERO), VisiblePart::Nothing);
    }

    #[test]
    fn faces_in_the_sources_plane_do_not_shade() {
        let stage = stage(&[floor(), square(DVec3::new(0.25, 0.0, 3.0), 0.5, false), lamp()]);
        assert_eq!(stage.seen_from(0, DVec3::X), VisiblePart::Whole(lamp()));
    }

    #[test]
    fn a_wall_below_the_horizon_is_cut_off() {
        let wall = vec![
            DVec3::new(2.0, -1.0, -1.0),
            DVec3::new(2.0, -1.0, 1.0),
            DVec3::new(2.0, 1.0, 1.0),
            DVec3::new(2.0, 1.0, -1.0),
        ];
        let stage = stage(&[floor(), wall]);
        assert_eq!(stage.share_from_face(0, DVec3::ZERO), 0.5);
    }

    /// A standing box without bottom, with its walls cut in two, on a floor, under a lamp.
    fn standing_box(turn: DQuat, lift: f64) -> Stage {
        let mut polygons = vec![floor()];
        let faces = fixture::outward_box(DVec3::new(-0.5, -0.3, lift), DVec3::new(0.7, 0.6, 0.8));
        polygons.push(faces[1].clone());
        for wall in &faces[2..] {
            polygons.push(vec![wall[0], wall[1], wall[2]]);
            polygons.push(vec![wall[0], wall[2], wall[3]]);
        }
        polygons.push(lamp());
        for p in polygons.iter_mut().flatten() {
            *p = fixture::f32_point(turn * *p);
        }
        stage(&polygons)
    }

    fn rotation() -> impl Strategy<Value = DQuat> {
        (-1.0..1.0, -1.0..1.0, -1.0..1.0, 0.1..1.0).prop_map(|(x, y, z, w)| DQuat::from_xyzw(x, y, z, w).normalize())
    }

    proptest! {
        #[test]
        fn under_a_standing_box_it_is_exactly_dark(
            turn in rotation(), x in -0.4999..0.6999, y in -0.2999..0.5999, lift in -2e-6..2e-6,
        ) {
            let stage = standing_box(turn, lift);
            prop_assert_eq!(stage.seen_from(0, turn * DVec3::new(x, y, 0.0)), VisiblePart::Nothing);
        }

        #[test]
        fn inside_a_closed_box_it_is_exactly_dark(
            turn in rotation(), x in -0.49..0.49, y in -0.49..0.49, tilt in rotation(),
        ) {
            let mut polygons = vec![square(DVec3::ZERO, 0.5, true)];
            polygons.extend(fixture::outward_box(DVec3::splat(-0.8), DVec3::splat(0.9)));
            for polygon in &mut polygons[1..] {
                polygon.iter_mut().for_each(|p| *p = fixture::f32_point(turn * *p));
            }
            polygons.push(lamp().iter().map(|&p| fixture::f32_point(tilt * p)).collect());
            let stage = stage(&polygons);
            prop_assert_eq!(stage.seen_from(0, DVec3::new(x, y, 0.0)), VisiblePart::Nothing);
        }

        #[test]
        fn a_partition_keeps_a_room_exactly_dark(
            turn in rotation(), x in 0.001..3.999, y in 0.001..2.999, kind in 0..3usize, thick in prop::bool::ANY,
        ) {
            // A lit room beside a dark one; floor and ceiling go through, side walls are cut at the partition.
            let depth = if thick { 0.1 } else { 0.0 };
            let lit = fixture::inward_box(DVec3::new(-4.0, 0.0, 0.0), DVec3::new(-depth, 3.0, 2.0));
            let dark = fixture::inward_box(DVec3::ZERO, DVec3::new(4.0, 3.0, 2.0));
            let ground = square(DVec3::ZERO, 5.0, true);
            let mut polygons = vec![ground];
            polygons.extend(lit[1..].iter().cloned());
            polygons.extend(dark[1..].iter().cloned());
            // The source: the lit room's ceiling, its floor's neighbour wall, or a lamp that hangs free.
            polygons.push(match kind {
                0 => lit[1].clone(),
                1 => lit[2].clone(),
                _ => square(DVec3::new(-1.0, 1.0, 1.99), 0.5, false),
            });
            for p in polygons.iter_mut().flatten() {
                *p = fixture::f32_point(turn * *p);
            }
            let stage = stage(&polygons);
            prop_assert_eq!(stage.seen_from(0, turn * DVec3::new(x, y, 0.0)), VisiblePart::Nothing);
        }

        #[test]
        fn the_visible_part_is_what_rays_see(
            middles in prop::collection::vec((-1.0..1.0, -1.0..1.0, 0.1..2.9), 1..8),
            sizes in prop::collection::vec((0.05..0.6, 0.05..0.6, 0.05..0.6), 8),
            turn in rotation(),
            x in -1.0..1.0,
        ) {
            let mut polygons = vec![floor()];
            for (&middle, &size) in middles.iter().zip(&sizes) {
                for polygon in fixture::outward_box(-0.5 * DVec3::from(size), 0.5 * DVec3::from(size)) {
                    polygons.push(polygon.iter().map(|&p| fixture::f32_point(DVec3::from(middle) + turn * p)).collect());
                }
            }
            polygons.push(lamp());
            let stage = stage(&polygons);
            let receiver = ReceiverPoint::on_face(&stage.prepared, FaceId::from(0), DVec3::X * x);
            let n = 64;
            let seen = (0..n * n).filter(|i| {
                let (s, t) = (f64::from(i % n) + 0.5, f64::from(i / n) + 0.5);
                let target = DVec3::new(s / f64::from(n) - 0.5, t / f64::from(n) - 0.5, 3.0);
                !stage.index.occluded(receiver.position_m, target, [receiver.plane, stage.source.plane])
            }).count();
            // Each of the convex shadows' outlines cuts at most 4 n cells, half of which go wrong at random.
            let error = seen as f64 / f64::from(n * n) - stage.share_from_face(0, DVec3::X * x);
            prop_assert!(error.abs() < 0.02, "{error}");
        }
    }

    #[test]
    fn values_are_continuous_across_a_d1_line() {
        // The plate's edge projects onto the lamp's edge from x = 0.25.
        let stage = stage(&[floor(), square(DVec3::new(0.5, 0.0, 1.5), 0.125, true), lamp()]);
        for critical in [0.25, 0.75, 1.25, 1.75] {
            for y in [0.0, 0.25, 0.3] {
                let at = |dx: f64| stage.share_from_face(0, DVec3::new(critical + dx, y, 0.0));
                assert!((at(1e-7) - at(0.0)).abs() < 1e-6 && (at(-1e-7) - at(0.0)).abs() < 1e-6, "{critical} {y}");
            }
        }
    }
}
