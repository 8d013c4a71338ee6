//! Contacts: lines on which a surface ends on another that goes on beneath it. There the value jumps (degree 0).
//!
//! `prepare` has cut both surfaces along the contact, so the line is an edge: two coplanar faces that look the same way
//! lie on its two sides, and a third face stands on it in front of them.

use super::{DSegment, Degree, Event};
use crate::id::{EdgeId, FaceId};
use crate::prepare::Prepared;

/// Whether a contact runs along `edge`: faces of one plane and facing on both sides, and a face in front of them.
pub fn is_contact(prepared: &Prepared, edge: EdgeId, face: FaceId) -> bool {
    let (own, plane) = (&prepared.faces[face], prepared.oriented_plane(face));
    let faces = &prepared.edges[edge].faces;
    let goes_on = faces.iter().any(|&other| {
        let other_face = &prepared.faces[other];
        other != face && other_face.plane == own.plane && other_face.facing == own.facing
    });
    // Cut along the contact, the other lies wholly before or behind: its farthest corner tells which, however small the angle is.
    let is_before = |other: FaceId| {
        let heights = prepared.corners(other).map(|v| plane.signed_distance_m(prepared.vertices_m[v]));
        let farthest_m = heights.max_by(|one, other| one.abs().total_cmp(&other.abs()));
        farthest_m.is_some_and(|height_m| height_m > prepared.tolerance.coplanar_m())
    };
    goes_on && faces.iter().any(|&other| prepared.faces[other].plane != own.plane && is_before(other))
}

/// The contacts of all faces that show light, as d-segments of degree 0.
pub(super) fn contacts(prepared: &Prepared, receives: impl Fn(FaceId) -> bool) -> Vec<DSegment> {
    let mut segments = Vec::new();
    for (edge, ends) in prepared.edges.iter_enumerated() {
        for &face in &ends.faces {
            if receives(face) && is_contact(prepared, edge, face) {
                let ends_m = ends.ends.map(|vertex| prepared.vertices_m[vertex]);
                segments.push(DSegment {
                    face,
                    ends_m,
                    degree: Degree::D0,
                    strength: 0.0,
                    event: Event::Contact { edge },
                });
            }
        }
    }
    segments
}
