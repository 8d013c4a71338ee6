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
//! How: the faces that the index finds in the beam are projected into the source's plane ([`super::view`]), where their
//! shadows become convex parts that do not overlap ([`super::shadow`]). Whatever is additive, a factor or an area, is
//! that of the source less those of the shadows. The same point of space has the same shadow whatever face it belongs
//! to, so faces that share an edge leave no hairline between them.
//!
//! Holds after: all polygons are convex, counter-clockwise seen from the source's front, in the frame of its plane and
//! not below the receiver's horizon; what is wholly dark has no outline, exactly.
//!
//! Faces in the plane of receiver or source never occlude; occluder corners nearer to the receiver's plane than the
//! weld tolerance count as below it, so that nothing shines through beneath what stands on it.

use std::ops::ControlFlow;

use glam::{DVec2, DVec3};
use smallvec::SmallVec;

use super::shadow::{self, Rounding, Shadows};
use super::view::{PlaneView, Window};
use super::{ReceiverPoint, Visibility};
use crate::geometry::convex::{self, Convex};
use crate::geometry::{Plane, PlaneFrame, polygon};
use crate::id::{FaceId, PlaneId};
use crate::prepare::Prepared;

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

/// A convex polygon that sends light, in the frame of its plane.
#[derive(Clone, Debug, PartialEq)]
pub struct FlatSource {
    /// The frame, with the front towards which it sends.
    pub frame: PlaneFrame,
    /// Its corners, counter-clockwise seen from the front, in metres.
    pub corners_m: Convex,
    /// The plane that it lies in: the plane's faces do not shade it.
    pub plane: PlaneId,
}

impl FlatSource {
    /// The whole of `face`, in its own frame.
    pub fn of_face(prepared: &Prepared, face: FaceId) -> Self {
        Self::new(&SourcePolygon::of_face(prepared, face), prepared.face_frame(face))
    }

    /// A polygon in a frame of its plane.
    pub fn new(polygon: &SourcePolygon, frame: PlaneFrame) -> Self {
        let corners_m = polygon.corners_m.iter().map(|&corner_m| frame.to_2d(corner_m)).collect();
        Self { frame, corners_m, plane: polygon.plane }
    }
}

/// What a receiver point sees of a source: its part above the horizon, less shadows.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Seen {
    /// The part above the horizon; empty where nothing is seen.
    pub outline: Convex,
    /// Whether that is all of the source.
    pub whole: bool,
    /// What is in shadow: convex parts that do not overlap.
    pub shadows: Shadows,
}

impl Seen {
    /// Whether nothing is seen: behind the source, below the horizon, or wholly in shadow.
    pub fn is_nothing(&self) -> bool {
        self.outline.is_empty()
    }

    /// Of what is seen, a measure that adds up over parts of a polygon.
    pub fn measure<T: std::ops::Sub<Output = T>>(&self, of: impl Fn(&[DVec2]) -> T) -> T {
        self.shadows.iter().fold(of(&self.outline), |left, shadow| left - of(shadow))
    }
}

/// The pyramid from a receiver point over the part of a source above its horizon.
#[derive(Debug)]
pub struct Beam<'a> {
    receiver: &'a ReceiverPoint,
    window: Window<'a>,
    /// What the faces around a point of a smooth surface are seen through.
    near: Option<Window<'a>>,
    /// Whether that is all of the source.
    whole: bool,
    area_m2: f64,
    /// The planes of receiver and source.
    passing: [PlaneId; 2],
}

/// Faces that may stand between a point and a source.
pub type Between = SmallVec<[FaceId; 32]>;

/// Corners nearer to a line than this share of the extent of the source lie on it: far above rounding, and far below
/// what is seen.
const SLACK_OF_SOURCE: f64 = 4e-9;

/// Past no more faces than this their shadows are found sooner than a ray tells which of them takes all.
const FEW: usize = 4;

impl Visibility {
    /// The view of a source's plane from a point, where the plane's front can be seen at all.
    pub fn view(&self, receiver: &ReceiverPoint, source: &FlatSource) -> Option<PlaneView> {
        if receiver.plane == source.plane { None } else { PlaneView::new(receiver, &source.frame) }
    }

    /// What `receiver` sees of `source`, the view of whose plane is given, past some faces, or past all where none are given.
    pub fn seen(
        &self,
        receiver: &ReceiverPoint,
        view: PlaneView,
        source: &FlatSource,
        among: Option<&[FaceId]>,
    ) -> Seen {
        let Some(beam) = self.beam(receiver, view, source) else { return Seen::default() };
        if among.is_none_or(|among| among.len() > FEW) && self.one_takes_all(&beam, source, among) {
            return Seen::default();
        }
        let mut thrown = Thrown::default();
        if self.throw_near(&beam, &mut thrown).is_continue() {
            self.walk_beam(&beam, among, |face| self.throw(&beam, &beam.window, face, &mut thrown));
        }
        beam.less(thrown)
    }

    /// Whether the face that stops a ray to the middle of a beam takes all of it: one ray for a source behind a wall, in place of the
    /// shadows of all faces on the way.
    fn one_takes_all(&self, beam: &Beam<'_>, source: &FlatSource, among: Option<&[FaceId]>) -> bool {
        if beam.receiver.near.is_some() {
            return false;
        }
        let outline = &beam.window.outline;
        let to_m = source.frame.to_3d(outline.iter().sum::<DVec2>() / outline.len() as f64);
        let stopper = self.stopper(beam.receiver, to_m, Some(source.plane), among);
        stopper.is_some_and(|face| self.throw(beam, &beam.window, face, &mut Thrown::default()).is_break())
    }

    /// The beam from a point over what of a source is above its horizon; `None` where that is nothing.
    pub fn beam<'a>(&self, receiver: &'a ReceiverPoint, view: PlaneView, source: &'a FlatSource) -> Option<Beam<'a>> {
        let above = view.above_horizon(&source.corners_m);
        let whole = above.is_none() && !self.is_in_closed_gap(receiver, &view);
        let mut outline = above.unwrap_or_else(|| source.corners_m.clone());
        if self.is_in_closed_gap(receiver, &view) {
            outline = self.across_gap(receiver, &source.frame, outline);
        }
        let [low_m, high_m] = convex::bounds_m(&outline);
        let slack_m = SLACK_OF_SOURCE * (high_m - low_m).max_element();
        let rounding = Rounding { slack_m, thin_m2: slack_m * convex::perimeter_m(&outline) };
        let area_m2 = polygon::signed_area_2d_m2(&outline);
        if outline.is_empty() || area_m2 <= rounding.thin_m2 {
            return None;
        }
        let normal = receiver.normal;
        let near = receiver.near.and_then(|near| {
            let view = PlaneView::from(near.from_m, normal, &source.frame)?;
            Some(Window::new([near.from_m, normal], &source.frame, view, outline.clone(), self.tolerance(), rounding))
        });
        let at = [receiver.position_m, normal];
        let window = Window::new(at, &source.frame, view, outline, self.tolerance(), rounding);
        Some(Beam { receiver, window, near, whole, area_m2, passing: [receiver.plane, source.plane] })
    }

    /// The faces whose boxes meet a beam; `among` some, or all where none are given. Those around a point of a smooth surface are not
    /// told: they are looked at in any case.
    pub fn between(&self, beam: &Beam<'_>, among: Option<&[FaceId]>) -> Between {
        let mut between = Between::new();
        self.walk_beam(beam, among, |face| {
            between.push(face);
            ControlFlow::Continue(())
        });
        between
    }

    /// What is seen in a beam past the faces that are [`Self::between`].
    pub fn seen_past(&self, beam: Beam<'_>, between: &[FaceId]) -> Seen {
        let mut thrown = Thrown::default();
        // Stops where nothing is left to be seen.
        let _ = self.throw_near(&beam, &mut thrown).is_continue()
            && between.iter().try_for_each(|&face| self.throw(&beam, &beam.window, face, &mut thrown)).is_continue();
        beam.less(thrown)
    }

    /// Visits the faces whose boxes meet a beam and that may stand in it.
    fn walk_beam(&self, beam: &Beam<'_>, among: Option<&[FaceId]>, mut visit: impl FnMut(FaceId) -> ControlFlow<()>) {
        self.walk_among(
            among,
            |aabb| beam.window.rounded_box_may_occlude(aabb.min, aabb.max),
            |min_m, max_m| beam.window.box_may_occlude(min_m, max_m),
            |face| {
                let passes = beam.passing.contains(&self.plane(face)) || self.is_near(beam.receiver, face);
                if passes { ControlFlow::Continue(()) } else { visit(face) }
            },
        );
    }

    /// Adds the shadows of what lies on a point, and of the faces around one of a smooth surface; breaks where one takes the whole.
    fn throw_near(&self, beam: &Beam<'_>, thrown: &mut Thrown) -> ControlFlow<()> {
        let [_, source] = beam.passing;
        let covering = beam.receiver.face.map_or(&[][..], |own| self.covering(own));
        for &face in covering.iter().filter(|&&face| self.plane(face) != source) {
            self.throw(beam, &beam.window, face, thrown)?;
        }
        let Some(window) = &beam.near else { return ControlFlow::Continue(()) };
        let may_occlude = |face: FaceId| {
            let [min_m, max_m] = self.bounds_m(face);
            self.plane(face) != source && window.box_may_occlude(min_m, max_m)
        };
        let mut near = self.near(beam.receiver).iter().copied().filter(|&face| may_occlude(face));
        near.try_for_each(|face| self.throw(beam, window, face, thrown))
    }

    /// Adds the shadow of a face as seen through a window; breaks where it takes the whole.
    fn throw(&self, beam: &Beam<'_>, window: &Window<'_>, face: FaceId, thrown: &mut Thrown) -> ControlFlow<()> {
        let is_in_gap = || window.is_within(self.near_plane(face), self.tolerance().closed_m());
        match self.covers(face, beam.receiver) {
            Some(false) => return ControlFlow::Continue(()),
            Some(true) if !is_in_gap() => thrown.most_m2 = f64::INFINITY,
            _ => {
                if let Some((shadow, shadow_m2)) = window.shadow(self.boundary_m(face)) {
                    thrown.most_m2 = shadow_m2.max(thrown.most_m2);
                    thrown.shadows.push(shadow);
                }
            }
        }
        if beam.is_taken_by(thrown) { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    }
}

/// Shadows that are thrown onto a source, and the area of the largest, in square metres.
#[derive(Default)]
struct Thrown {
    shadows: Shadows,
    most_m2: f64,
}

impl Beam<'_> {
    /// Whether one shadow takes all of the source.
    fn is_taken_by(&self, thrown: &Thrown) -> bool {
        thrown.most_m2 >= self.area_m2 - self.window.rounding.thin_m2
    }

    /// What shadows leave.
    fn less(self, thrown: Thrown) -> Seen {
        if self.is_taken_by(&thrown) {
            return Seen::default();
        }
        let Beam { window, whole, area_m2, .. } = self;
        let shadows = shadow::without_overlap(&window.outline, thrown.shadows, window.rounding);
        let dark_m2: f64 = shadows.iter().map(|shadow| polygon::signed_area_2d_m2(shadow)).sum();
        if area_m2 - dark_m2 <= THIN_LIT * window.rounding.thin_m2 {
            return Seen::default();
        }
        Seen { outline: window.outline, whole, shadows }
    }
}

/// A region is lit from so many times the area on that is rounding: each shadow beside it may be as much too small.
const THIN_LIT: f64 = 4.0;

#[cfg(test)]
mod tests {
    use super::super::fixture::{self, square};
    use super::*;
    use glam::DQuat;
    use proptest::prelude::*;

    /// A scene whose last face is the source.
    struct Stage {
        prepared: Prepared,
        index: Visibility,
        source: FlatSource,
    }

    fn stage(polygons: &[Vec<DVec3>]) -> Stage {
        let prepared = fixture::prepared(polygons);
        let index = Visibility::new(&prepared);
        let last = FaceId::from(prepared.faces.len() - 1);
        let source = FlatSource::of_face(&prepared, last);
        Stage { prepared, index, source }
    }

    impl Stage {
        fn seen_from(&self, face: usize, near: DVec3) -> Seen {
            let receiver = ReceiverPoint::on_face(&self.prepared, FaceId::from(face), near);
            let view = self.index.view(&receiver, &self.source);
            view.map(|view| self.index.seen(&receiver, view, &self.source, None)).unwrap_or_default()
        }

        fn share_from_face(&self, face: usize, near: DVec3) -> f64 {
            let area_m2 = |corners: &[DVec2]| polygon::signed_area_2d_m2(corners);
            self.seen_from(face, near).measure(area_m2) / area_m2(&self.source.corners_m)
        }

        /// Whether all of the source is seen and nothing shades it.
        fn is_all_seen(&self, face: usize, near: DVec3) -> bool {
            let seen = self.seen_from(face, near);
            seen.whole && seen.shadows.is_empty() && seen.outline == self.source.corners_m
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
        assert!(stage.is_all_seen(0, DVec3::X));
    }

    #[test]
    fn behind_the_source_and_in_its_plane_nothing_is_seen() {
        let stage = stage(&[floor(), square(DVec3::new(2.0, 0.0, 3.0), 1.0, true), square(DVec3::Z * 3.0, 0.5, true)]);
        assert!(stage.seen_from(0, DVec3::X).is_nothing());
        assert!(stage.seen_from(1, DVec3::new(2.0, 0.0, 3.0)).is_nothing());
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
        assert!(stage.seen_from(0, DVec3::ZERO).is_nothing());
    }

    #[test]
    fn faces_in_the_sources_plane_do_not_shade() {
        let stage = stage(&[floor(), square(DVec3::new(0.25, 0.0, 3.0), 0.5, false), lamp()]);
        assert!(stage.is_all_seen(0, DVec3::X));
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
            prop_assert!(stage.seen_from(0, turn * DVec3::new(x, y, 0.0)).is_nothing());
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
            prop_assert!(stage.seen_from(0, DVec3::new(x, y, 0.0)).is_nothing());
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
            prop_assert!(stage.seen_from(0, turn * DVec3::new(x, y, 0.0)).is_nothing());
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
