//! Curves on which the light of a lamp without extent begins or ends by itself, with no occluder.
//!
//! | curve | where | degree |
//! |---|---|---|
//! | terminator | the interpolated normal of a smooth surface is perpendicular to the light: the cosine is cut off at zero | 1 |
//! | inner cone | the light of a spot begins to fall | 1 |
//! | outer cone | it ends, with no slope; where the cones are one, the value jumps | 2, or 0 |
//! | range | the light of a lamp that has one ends | 1 |
//!
//! On a face each is (nearly) a conic, known as the zeros of a function that is positive where the lamp shines
//! ([`super::implicit_curve`] follows them). Chords stand for it, each a d-segment of its own. A piece from which
//! the lamp is not seen is left out.

use glam::{DVec2, DVec3};
use serde::{Deserialize, Serialize};

use super::features::Surroundings;
use super::implicit_curve::chords;
use super::{DSegment, Degree, Event};
use crate::geometry::PlaneFrame;
use crate::id::{FaceId, LampId};
use crate::scene::{Lamp, LampKind, Rgb};
use crate::visibility::ReceiverPoint;

/// Chords leave a curve of degree 1 or 2 by at most this share of their length: 40 of them are a circle, and leave it by 0.3 % of its
/// radius.
const LEAVES_SOFT: f64 = 0.02;
/// The same where the value jumps: 160 are a circle, and cut off 0.03 % of its area.
const LEAVES_HARD: f64 = 0.005;
/// Cones whose cosines differ by less are one: the soft edge would be 1e-4 rad wide at 45 degrees.
const ONE_CONE: f64 = 1e-4;
/// From a chord, light is looked at so far to both sides, as a share of its length: beyond what the chord leaves the curve by.
const BESIDE: f64 = 0.05;
/// Where along a chord it is looked at whether the lamp is seen.
const LOOKED_AT: [f64; 3] = [0.1, 0.5, 0.9];
/// What is farther away than this many extents is outside of the scene.
const FAR_OF_EXTENT: f64 = 2.0;

/// Why the light of a lamp begins or ends.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
pub enum LampCurve {
    /// A smooth surface turns away from it.
    Terminator,
    /// A spot is at its full brightness inside.
    InnerCone,
    /// A spot does not shine outside.
    OuterCone,
    /// The lamp does not reach farther.
    Range,
}

impl LampCurve {
    const ALL: [Self; 4] = [Self::Terminator, Self::InnerCone, Self::OuterCone, Self::Range];
}

impl Surroundings<'_> {
    /// The curves of a lamp on a face.
    pub(super) fn lamp_curves(&self, id: LampId, face: FaceId) -> Vec<DSegment> {
        if !self.features.receives[face] {
            return Vec::new();
        }
        LampCurve::ALL.into_iter().flat_map(|curve| self.lamp_curve(id, face, curve)).collect()
    }

    fn lamp_curve(&self, id: LampId, face: FaceId, curve: LampCurve) -> Vec<DSegment> {
        let lamp = &self.features.lamps[id];
        let Some(degree) = self.degree_of(lamp, face, curve) else { return Vec::new() };
        let frame = self.prepared.face_frame(face);
        let corners: Vec<DVec2> = self.visibility.boundary_m(face).iter().map(|&corner| frame.to_2d(corner)).collect();
        let side = |at: DVec2| self.side(lamp, face, curve, frame.to_3d(at));
        let within = middle_of(lamp, &frame).filter(|_| curve != LampCurve::Terminator);
        let leaves = if degree == Degree::D0 { LEAVES_HARD } else { LEAVES_SOFT };
        let event = Event::LampCurve { lamp: id, curve };
        let segment = |ends: [DVec2; 2]| {
            let across = BESIDE * (ends[1] - ends[0]).perp();
            let is_seen = |share: f64| {
                let at = ends[0].lerp(ends[1], share);
                [at - across, at + across].into_iter().any(|at| self.is_lit(lamp, face, frame.to_3d(at)))
            };
            if !LOOKED_AT.into_iter().any(is_seen) {
                return None;
            }
            self.segment_between(face, ends.map(|end| frame.to_3d(end)), event, degree)
        };
        chords(&corners, within, side, leaves).into_iter().filter_map(segment).collect()
    }

    /// The degree of a curve; `None` where a lamp has none of its kind on a face.
    fn degree_of(&self, lamp: &Lamp, face: FaceId, curve: LampCurve) -> Option<Degree> {
        let is_flat = !self.prepared.is_smooth(face);
        let is_before =
            |position_m| self.prepared.oriented_plane(face).signed_distance_m(position_m) > self.coplanar_m();
        match (curve, lamp.kind) {
            (LampCurve::Terminator, _) => (!is_flat).then_some(Degree::D1),
            (_, LampKind::Point { position_m, .. } | LampKind::Spot { position_m, .. })
                if is_flat && !is_before(position_m) =>
            {
                None
            }
            (LampCurve::InnerCone | LampCurve::OuterCone, LampKind::Spot { inner_rad, outer_rad, .. }) => {
                let is_hard = inner_rad.cos() - outer_rad.cos() < ONE_CONE;
                match curve {
                    LampCurve::InnerCone => (!is_hard && inner_rad > 0.0).then_some(Degree::D1),
                    _ => Some(if is_hard { Degree::D0 } else { Degree::D2 }),
                }
            }
            (LampCurve::Range, LampKind::Point { range_m, .. } | LampKind::Spot { range_m, .. }) => {
                range_m.map(|_| Degree::D1)
            }
            _ => None,
        }
    }

    /// Positive on the side of a curve on which a lamp shines.
    fn side(&self, lamp: &Lamp, face: FaceId, curve: LampCurve, at_m: DVec3) -> f64 {
        let between_m = lamp.position_m().map(|position_m| position_m - at_m);
        match (curve, lamp.kind) {
            (LampCurve::Terminator, kind) => {
                let normal = self.prepared.smooth_normal(face, at_m);
                match (kind, between_m) {
                    (LampKind::Directional { direction, .. }, _) => -normal.dot(direction),
                    (_, between_m) => normal.dot(between_m.unwrap_or(DVec3::ZERO)),
                }
            }
            (LampCurve::Range, LampKind::Point { range_m, .. } | LampKind::Spot { range_m, .. }) => {
                range_m.unwrap_or(f64::INFINITY) - between_m.map_or(0.0, DVec3::length)
            }
            (_, LampKind::Spot { direction, inner_rad, outer_rad, .. }) => {
                let angle_rad = if curve == LampCurve::InnerCone { inner_rad } else { outer_rad };
                let between_m = between_m.unwrap_or(DVec3::ZERO);
                -direction.dot(between_m) - angle_rad.cos() * between_m.length()
            }
            _ => -1.0,
        }
    }

    /// What a lamp brings to a point of a face, if nothing stands between.
    fn brought(&self, lamp: &Lamp, face: FaceId, at_m: DVec3) -> Rgb {
        let Some(arriving) = lamp.arriving(at_m) else { return Rgb::ZERO };
        self.prepared.smooth_normal(face, at_m).dot(arriving.towards).max(0.0) * arriving.irradiance
    }

    /// Whether light of a lamp arrives at a point of a face.
    fn is_lit(&self, lamp: &Lamp, face: FaceId, at_m: DVec3) -> bool {
        if self.brought(lamp, face, at_m) == Rgb::ZERO {
            return false;
        }
        let receiver = ReceiverPoint::on_face(self.prepared, face, at_m);
        let far_m = FAR_OF_EXTENT * self.prepared.tolerance.extent_m;
        let to_m = match lamp.kind {
            LampKind::Directional { direction, .. } => receiver.position_m - far_m * direction,
            LampKind::Point { position_m, .. } | LampKind::Spot { position_m, .. } => position_m,
        };
        self.visibility.stopper(&receiver, to_m, None, None).is_none()
    }

    /// How much jumps across a curve, from differences of light beside a chord of it: in W/m2, W/m3 or W/m4 by `degree`.
    pub(super) fn of_lamp_curve(&self, segment: &DSegment, at_m: DVec3, across: DVec3, lamp: LampId) -> Rgb {
        let lamp = &self.features.lamps[lamp];
        let step_m = BESIDE * segment.length_m();
        let [before, on, beyond] =
            [-1.0, 0.0, 1.0].map(|s| self.brought(lamp, segment.face, at_m + s * step_m * across));
        let kink = beyond + before - 2.0 * on;
        match segment.degree {
            Degree::D0 => beyond - before,
            Degree::D1 => kink / step_m,
            // Light grows with the square of the distance from the curve, on one side of it.
            Degree::D2 => 2.0 * kink / (step_m * step_m),
        }
    }
}

/// A point inside the curves of a lamp in a plane, where they are closed.
fn middle_of(lamp: &Lamp, frame: &PlaneFrame) -> Option<DVec2> {
    match lamp.kind {
        LampKind::Spot { position_m, direction, .. } => {
            let down_m = -frame.plane.signed_distance_m(position_m) / frame.plane.normal.dot(direction);
            (down_m.is_finite() && down_m > 0.0).then(|| frame.to_2d(position_m + down_m * direction))
        }
        LampKind::Point { position_m, .. } => Some(frame.to_2d(position_m)),
        LampKind::Directional { .. } => None,
    }
}
