//! A receiver point as a source's plane sees it, and the shadows that occluders throw from it onto that plane.
//!
//! In the frame of the plane the point `P` has a foot and a height `h`. A point `Q` of an occluder, at the height
//! `h_Q`, throws its shadow at `(x, y) / w` with `(x, y) = foot(Q) - foot(P) h_Q / h` and `w = 1 - h_Q / h`: 1 in the
//! plane, 0 at the height of the point, more than 1 behind the plane. This is linear, so polygons are clipped before
//! the division, by `w <= 1` and by the sides of what is asked about.
//!
//! Holds: a point of space throws the same shadow in every face that has it as a corner, and an edge the same clipped
//! ends.

use glam::{DVec2, DVec3, Vec3A};
use smallvec::SmallVec;

use super::ReceiverPoint;
use super::half_spaces::HalfSpaces;
use super::shadow::Rounding;
use crate::geometry::convex::{self, Convex};
use crate::geometry::{Plane, PlaneFrame, Tolerance, clip, polygon};

/// Occluders nearer to the receiver point than this share of its height over the source are cut off: there the
/// projection loses all digits.
const NEAREST_W: f64 = 1e-9;
/// Corners of an occluder count as in the source's plane within the weld tolerance, but within no more than this share
/// of the receiver point's own height over it.
const IN_SOURCE_OF_HEIGHT: f64 = 0.125;

/// A box that reaches over a side of the beam by no more than this share of the beam's length only touches it.
const TOUCHING: f64 = 1e-12;

/// A receiver point in the frame of a source's plane, in front of it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PlaneView {
    /// The foot of the perpendicular from the point, in metres.
    pub foot_m: DVec2,
    /// Its distance from the plane, in metres.
    pub height_m: f64,
    /// The receiver's unit normal, along the axes and the normal of the frame.
    pub normal: DVec3,
}

impl PlaneView {
    /// The view of a plane from a point; `None` where the point is not in front of the plane.
    pub fn new(receiver: &ReceiverPoint, frame: &PlaneFrame) -> Option<Self> {
        Self::from(receiver.position_m, receiver.normal, frame)
    }

    /// The view from a point with this unit normal.
    pub(super) fn from(from_m: DVec3, n: DVec3, frame: &PlaneFrame) -> Option<Self> {
        let height_m = frame.plane.signed_distance_m(from_m);
        (height_m > 0.0).then(|| Self {
            foot_m: frame.to_2d(from_m),
            height_m,
            normal: DVec3::new(n.dot(frame.u), n.dot(frame.v), n.dot(frame.plane.normal)),
        })
    }

    /// From the receiver point to a point of the plane, in metres.
    pub fn towards_m(&self, point_m: DVec2) -> DVec3 {
        (point_m - self.foot_m).extend(-self.height_m)
    }

    /// Height of a point of the plane over the receiver's own plane, in metres.
    pub fn over_horizon_m(&self, point_m: DVec2) -> f64 {
        self.normal.dot(self.towards_m(point_m))
    }

    /// The part of a polygon above the receiver's horizon; `None` where that is all of it.
    pub fn above_horizon(&self, corners: &[DVec2]) -> Option<Convex> {
        let below = corners.iter().any(|&corner| self.over_horizon_m(corner) < 0.0);
        below.then(|| clip::where_not_negative(corners, |p| self.over_horizon_m(p)))
    }
}

/// What is asked about: a convex part of the source's plane, and what counts as nothing there.
#[derive(Debug)]
pub(super) struct Window<'a> {
    /// The receiver point, in metres.
    from_m: DVec3,
    frame: &'a PlaneFrame,
    view: PlaneView,
    horizon: Plane,
    /// Within this distance from the receiver's plane a corner counts as below it.
    on_receiver_m: f64,
    /// Within this distance from the source's plane a corner counts as in it.
    on_source_m: f64,
    /// And a face before it where a corner is farther than this.
    in_source_m: f64,
    pub(super) outline: Convex,
    pub(super) rounding: Rounding,
    beam_sides: BeamSides,
    /// All sides of what an occluder must meet.
    rounded: HalfSpaces,
}

/// Normals of the beam's sides, inward, through the receiver point; and the least height over them that counts.
type BeamSides = SmallVec<[(DVec3, f64); 8]>;

impl<'a> Window<'a> {
    /// As seen from a point with a unit normal.
    pub(super) fn new(
        [from_m, normal]: [DVec3; 2],
        frame: &'a PlaneFrame,
        view: PlaneView,
        outline: Convex,
        tolerance: Tolerance,
        rounding: Rounding,
    ) -> Self {
        let weld_m = tolerance.weld_m();
        let to_side = |(p, q): (DVec2, DVec2)| {
            let [from, to] = [p, q].map(|corner| frame.to_3d(corner) - from_m);
            let side = to.cross(from);
            (side, TOUCHING * side.length() * from.length().max(to.length()))
        };
        let on_source_m = weld_m.min(IN_SOURCE_OF_HEIGHT * view.height_m);
        let beam_sides: BeamSides = convex::long_sides(&outline, rounding.slack_m).map(to_side).collect();
        let towards = frame.plane.normal;
        let in_source_m = tolerance.coplanar_m().min(on_source_m);
        let ends = [
            (normal, weld_m),
            (towards, in_source_m - view.height_m),
            // What is as high over the source as the point is behind it.
            (-towards, 0.0),
        ];
        let half_spaces = ends.into_iter().chain(beam_sides.iter().copied());
        Self {
            from_m,
            frame,
            view,
            horizon: Plane::through(from_m, normal),
            on_receiver_m: weld_m,
            on_source_m,
            in_source_m,
            rounded: HalfSpaces::around(from_m, half_spaces, tolerance.extent_m),
            beam_sides,
            outline,
            rounding,
        }
    }

    /// The same as [`Self::box_may_occlude`], for a box that is rounded outward: it may pass more.
    pub(super) fn rounded_box_may_occlude(&self, min_m: Vec3A, max_m: Vec3A) -> bool {
        self.rounded.may_meet(min_m, max_m)
    }

    /// Whether a face in this box may take something of the window: false only where it cannot.
    pub(super) fn box_may_occlude(&self, min_m: DVec3, max_m: DVec3) -> bool {
        let (middle, half) = (0.5 * (min_m + max_m), 0.5 * (max_m - min_m));
        let over_receiver = self.horizon.signed_distance_m(middle) + self.horizon.normal.abs().dot(half);
        if over_receiver <= self.on_receiver_m {
            return false;
        }
        let plane = &self.frame.plane;
        let (over_source, reach) = (plane.signed_distance_m(middle), plane.normal.abs().dot(half));
        if over_source + reach <= self.in_source_m || over_source - reach >= self.view.height_m {
            return false;
        }
        let from_point = middle - self.from_m;
        self.beam_sides.iter().all(|(side, least)| side.dot(from_point) + side.abs().dot(half) > *least)
    }

    /// Whether all of it is within a distance of a plane, in metres.
    pub(super) fn is_within(&self, plane: &Plane, distance_m: f64) -> bool {
        self.outline.iter().all(|&corner| plane.signed_distance_m(self.frame.to_3d(corner)).abs() <= distance_m)
    }

    /// The part of the window in the shadow of a face and its area, in square metres; `None` where that is nothing.
    pub(super) fn shadow(&self, boundary_m: &[DVec3]) -> Option<(Convex, f64)> {
        let mut above_receiver = false;
        let mut before_source = false;
        let homogeneous: SmallVec<[DVec3; 8]> = boundary_m
            .iter()
            .map(|&corner| {
                let height = self.horizon.signed_distance_m(corner);
                let below = if height.abs() <= self.on_receiver_m { height + self.on_receiver_m } else { 0.0 };
                above_receiver |= height > self.on_receiver_m;
                let q = self.homogeneous(corner - below * self.horizon.normal);
                before_source |= self.frame.plane.signed_distance_m(corner) > self.in_source_m;
                q
            })
            .collect();
        if !above_receiver || !before_source {
            return None;
        }
        let inward = |(p, q): (DVec2, DVec2)| {
            let left = (q - p).perp();
            left.extend(-left.dot(p))
        };
        // What only touches a side has no shadow beyond rounding.
        let narrow = |(p, q): (DVec2, DVec2)| inward((p, q)) - self.rounding.slack_m * p.distance(q) * DVec3::Z;
        let no_side_has_it = |side: DVec3| homogeneous.iter().all(|q| side.dot(*q) <= 0.0);
        let sides = || convex::long_sides(&self.outline, self.rounding.slack_m);
        if sides().map(narrow).any(no_side_has_it) {
            return None;
        }
        let ends = [(DVec3::NEG_Z, 1.0), (DVec3::Z, -NEAREST_W)];
        let mut clipped = homogeneous;
        for (inward, offset) in ends.into_iter().chain(sides().map(|side| (inward(side), 0.0))) {
            let height = |q: DVec3| inward.dot(q) + offset;
            if clipped.iter().any(|&q| height(q) < 0.0) {
                clipped = clip::where_not_negative(&clipped, height);
            }
        }
        let mut shadow: Convex = clipped.iter().map(|q| q.truncate() / q.z).collect();
        let area_m2 = polygon::signed_area_2d_m2(&shadow);
        if area_m2 < 0.0 {
            shadow.reverse();
        }
        (area_m2.abs() > self.rounding.thin_m2).then_some((shadow, area_m2.abs()))
    }

    fn homogeneous(&self, point: DVec3) -> DVec3 {
        let height = self.frame.plane.signed_distance_m(point);
        let share = if height.abs() <= self.on_source_m { 0.0 } else { height / self.view.height_m };
        (self.frame.to_2d(point) - share * self.view.foot_m).extend(1.0 - share)
    }
}
