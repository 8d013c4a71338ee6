//! Where the visible factor of a source has a kink on a receiver.
//!
//! An edge of the source and an edge of an occluder in one plane make a discontinuity of degree 1 where that plane meets the
//! receiver: the visible factor bends there, and rules for smooth functions are slow to converge across it. All other
//! events are of degree 2, bend only the slope, and are left to bisection.
//!
//! Lines are hints: one where the factor does not bend, or one that is missing, costs time and nothing else.

use glam::{DVec2, DVec3};

use crate::geometry::{Plane, PlaneFrame};
use crate::visibility::{SourcePolygon, Visibility};

/// A line on the receiver, in its frame: `normal . p = offset_m`, and how many events lie on it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Kink {
    pub(super) normal: DVec2,
    pub(super) offset_m: f64,
    pub(super) events: u32,
}

/// Planes of edges that meet the receiver at an angle whose sine is below this do not cut it in a line worth a cut.
const LEAST_SINE: f64 = 1e-6;

/// The kinks on the receiver of what it sees of `source`, each once.
pub(super) fn kinks(
    visibility: &Visibility,
    receiver: &SourcePolygon,
    source: &SourcePolygon,
    frame: &PlaneFrame,
) -> Vec<Kink> {
    let slack_m = visibility.tolerance().weld_m();
    let mut kinks = Vec::new();
    for face in visibility.faces_between(receiver, source) {
        let boundary = visibility.boundary_m(face);
        for (p, q) in sides(boundary) {
            for (from, to) in sides(&source.corners_m) {
                let plane = common_plane([from, to], [p, q], slack_m);
                kinks.extend(plane.and_then(|plane| line(&plane, frame)));
            }
        }
    }
    unite(kinks, slack_m)
}

fn sides(corners: &[DVec3]) -> impl Iterator<Item = (DVec3, DVec3)> + '_ {
    (0..corners.len()).map(|i| (corners[i], corners[(i + 1) % corners.len()])).filter(|(p, q)| p != q)
}

/// The plane of two edges that have one, and only one.
fn common_plane([from, to]: [DVec3; 2], occluder: [DVec3; 2], slack_m: f64) -> Option<Plane> {
    let across = |p: DVec3| (to - from).cross(p - from) / (to - from).length();
    let far = if across(occluder[0]).length() > across(occluder[1]).length() { occluder[0] } else { occluder[1] };
    if across(far).length() <= slack_m {
        return None;
    }
    let plane = Plane::through(from, across(far).normalize());
    occluder.iter().all(|&p| plane.signed_distance_m(p).abs() <= slack_m).then_some(plane)
}

/// Where a plane meets the plane of a frame.
fn line(plane: &Plane, frame: &PlaneFrame) -> Option<Kink> {
    let flat = DVec2::new(plane.normal.dot(frame.u), plane.normal.dot(frame.v));
    let sine = flat.length();
    if sine < LEAST_SINE {
        return None;
    }
    let normal = flat / sine;
    let offset_m = -plane.signed_distance_m(frame.origin) / sine;
    // One direction for both orientations of a line.
    let backward = normal.x < -LEAST_SINE || (normal.x < LEAST_SINE && normal.y < 0.0);
    let sign = if backward { -1.0 } else { 1.0 };
    Some(Kink { normal: sign * normal, offset_m: sign * offset_m, events: 1 })
}

/// Lines that are the same within `slack_m` become one.
fn unite(mut kinks: Vec<Kink>, slack_m: f64) -> Vec<Kink> {
    kinks.sort_by(|a, b| a.offset_m.total_cmp(&b.offset_m).then(a.normal.x.total_cmp(&b.normal.x)));
    let mut united: Vec<Kink> = Vec::new();
    for kink in kinks {
        let near = united.iter_mut().rev().take_while(|other| kink.offset_m - other.offset_m <= slack_m);
        let mut same = near.filter(|other| other.normal.distance(kink.normal) <= LEAST_SINE);
        match same.next() {
            Some(other) => other.events += kink.events,
            None => united.push(kink),
        }
    }
    united
}
