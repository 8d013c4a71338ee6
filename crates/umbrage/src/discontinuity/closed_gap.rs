//! Contacts across a gap that counts as closed: a box that floats a tenth of a millimetre over the floor stands on it.
//!
//! What lies so near over a face covers it ([`crate::visibility`]), and nothing divides the face there: the border of the one,
//! dropped onto the other, is a contact, where the value jumps (degree 0).
//!
//! ```text
//!         |    box     |
//!         +------------+
//!    _____:____________:_____ floor      : contacts
//! ```

use std::ops::ControlFlow;

use glam::DVec3;

use super::{DSegment, Degree, Event};
use crate::geometry::convex;
use crate::id::{EdgeId, FaceId};
use crate::prepare::Prepared;
use crate::visibility::Visibility;

/// The contacts of all faces that show light with faces that lie closely over them, as d-segments of degree 0.
pub(super) fn contacts(
    prepared: &Prepared,
    visibility: &Visibility,
    receives: impl Fn(FaceId) -> bool,
) -> Vec<DSegment> {
    let closed_m = prepared.tolerance.closed_m();
    let mut segments = Vec::new();
    for over in prepared.faces.keys() {
        let edges: Vec<EdgeId> = prepared.faces[over].sides.iter().flatten().map(|side| side.edge).collect();
        let [middle_m, half_m] = visibility.box_m(over);
        let (low_m, high_m) = (middle_m - half_m - closed_m, middle_m + half_m + closed_m);
        let mut covered = Vec::new();
        visibility.walk(
            |min_m, max_m| min_m.cmple(high_m).all() && max_m.cmpge(low_m).all(),
            |face| {
                let is_covered = receives(face)
                    && prepared.faces[face].plane != prepared.faces[over].plane
                    && visibility.lie_along([face, over])
                    && visibility.placed(over, face).is_before();
                covered.extend(is_covered.then_some(face));
                ControlFlow::Continue(())
            },
        );
        for face in covered {
            let apart = edges.iter().filter(|&&edge| {
                !prepared.edges[edge].faces.contains(&face) && !goes_on(prepared, visibility, [over, face], edge)
            });
            segments.extend(apart.filter_map(|&edge| dropped(prepared, edge, face)));
        }
    }
    segments
}

/// Whether a segment on the second of two faces is the shadow of the first across a closed gap.
pub(super) fn is_across(
    prepared: &Prepared,
    visibility: &Visibility,
    [over, face]: [FaceId; 2],
    ends_m: [DVec3; 2],
) -> bool {
    let plane = prepared.oriented_plane(over);
    let closed_m = prepared.tolerance.closed_m();
    prepared.faces[face].plane != prepared.faces[over].plane
        && ends_m.iter().all(|&end| plane.signed_distance_m(end).abs() <= closed_m)
        && visibility.lie_along([face, over])
        && visibility.placed(over, face).is_before()
}

/// Whether the plane of the first of two faces goes on beyond an edge of it, and covers the second there, too: where two
/// planes are nearly one, some parts of the first may lie in the second.
fn goes_on(prepared: &Prepared, visibility: &Visibility, [over, face]: [FaceId; 2], edge: EdgeId) -> bool {
    let own = &prepared.faces[over];
    let is_next = |&other: &FaceId| {
        let next = &prepared.faces[other];
        let goes_on = other != over && next.plane == own.plane && next.facing == own.facing;
        goes_on && visibility.placed(other, face).is_before()
    };
    prepared.edges[edge].faces.iter().any(is_next)
}

/// The part of an edge that is within a closed gap over a face, dropped onto it.
fn dropped(prepared: &Prepared, edge: EdgeId, face: FaceId) -> Option<DSegment> {
    let (closed_m, frame) = (prepared.tolerance.closed_m(), prepared.face_frame(face));
    let ends_m = prepared.edges[edge].ends.map(|end| prepared.vertices_m[end]);
    let heights_m = ends_m.map(|end| frame.plane.signed_distance_m(end));
    let flat = ends_m.map(|end| frame.to_2d(end));
    let corners: Vec<_> = prepared.polygon_m(face).into_iter().map(|corner| frame.to_2d(corner)).collect();
    let mut part = [0.0, 1.0];
    // Linear along the edge, and not below zero in the part.
    let mut keep = |[from, to]: [f64; 2]| {
        let crossing: f64 = from / (from - to);
        match (from < 0.0, to < 0.0) {
            (true, true) => part = [1.0, 0.0],
            (true, false) => part[0] = crossing.max(part[0]),
            (false, true) => part[1] = crossing.min(part[1]),
            (false, false) => {}
        }
    };
    keep(heights_m.map(|height_m| closed_m - height_m));
    keep(heights_m.map(|height_m| height_m + prepared.tolerance.coplanar_m()));
    convex::sides(&corners).for_each(|(from, to)| keep(flat.map(|end| (to - from).perp_dot(end - from))));
    let at = |share: f64| -> DVec3 { frame.to_3d(flat[0].lerp(flat[1], share)) };
    let segment =
        DSegment { face, ends_m: part.map(at), degree: Degree::D0, strength: 0.0, event: Event::Contact { edge } };
    (part[0] < part[1] && segment.length_m() > prepared.tolerance.weld_m()).then_some(segment)
}
