//! The plane of an occluder's face that cuts an emitter: where the plane meets the receiver, the face is seen edge-on.
//!
//! On one side of the plane the far edge of the face is the silhouette, on the other side the near one. Both lie upon
//! the same line of the emitter when the eye passes the plane, but move at different speeds: the slope of irradiance
//! jumps (degree 1). A thin plate hides nothing when it is seen edge-on, and something to both sides.

use glam::DVec3;
use smallvec::SmallVec;

use super::features::Surroundings;
use super::in_plane::InPlane;
use super::{DSegment, Emitter, Event, merge};
use crate::geometry::{Plane, polygon};
use crate::id::{EdgeId, EmitterId, FaceId, PlaneId};
use crate::prepare::DirectedEdge;

/// A line on an emitter, or on a face in a plane.
pub(super) type Chord = [DVec3; 2];

impl Surroundings<'_> {
    /// The chords in which a plane cuts an emitter: where it cuts a face from side to side, and edges along which the
    /// emitter's faces are cut already, since the occluder pierces it.
    pub(super) fn chords(&self, emitter: &Emitter, plane: &Plane) -> SmallVec<[Chord; 1]> {
        let mut chords = SmallVec::new();
        if let Some(part_m) = &emitter.part_m {
            let heights_m: SmallVec<[f64; 8]> = part_m.iter().map(|&p| plane.signed_distance_m(p)).collect();
            chords.extend(self.chord_across(part_m, &heights_m));
            return chords;
        }
        for &face in &emitter.faces {
            let corners = self.visibility.boundary_m(face);
            let heights_m: SmallVec<[f64; 8]> = corners.iter().map(|&p| plane.signed_distance_m(p)).collect();
            let slack_m = self.coplanar_m();
            if heights_m.iter().all(|&h| h > slack_m) || heights_m.iter().all(|&h| h < -slack_m) {
                continue;
            }
            if heights_m.iter().any(|&h| h > slack_m) && heights_m.iter().any(|&h| h < -slack_m) {
                chords.extend(self.chord_across(corners, &heights_m));
                continue;
            }
            let is_cut = |edge: EdgeId| {
                let mut others = self.prepared.edges[edge].faces.iter().filter(|&&other| other != face);
                // One of the two faces has it, the one with the smaller id.
                others.clone().all(|&other| other > face || !emitter.faces.contains(&other))
                    && others.any(|other| emitter.faces.contains(other))
            };
            for edge in self.prepared.faces[face].sides.iter().flatten().map(|side| side.edge) {
                let ends = self.ends(edge);
                if ends.iter().all(|&end| plane.signed_distance_m(end).abs() <= slack_m) && is_cut(edge) {
                    chords.push(ends);
                }
            }
        }
        chords
    }

    /// The chord of a face whose corners have these heights over a plane.
    fn chord_across(&self, corners: &[DVec3], heights_m: &[f64]) -> Option<Chord> {
        let n = corners.len();
        let crossings = (0..n).filter_map(|i| {
            let (from, to) = (heights_m[i], heights_m[(i + 1) % n]);
            ((from > 0.0) != (to > 0.0)).then(|| corners[i].lerp(corners[(i + 1) % n], from / (from - to)))
        });
        let ends: SmallVec<[DVec3; 2]> = crossings.collect();
        Chord::try_from(ends.as_slice()).ok().filter(|ends| ends[0].distance(ends[1]) > self.weld_m())
    }

    /// The event of an emitter and the faces in a plane.
    pub(super) fn occluder_plane(&self, id: EmitterId, occluder: PlaneId) -> Vec<DSegment> {
        let emitter = &self.features.emitters[id];
        let plane = self.prepared.planes[occluder].plane;
        let chords = self.chords(emitter, &plane);
        if chords.is_empty() {
            return Vec::new();
        }
        let event = Event::OccluderPlane { emitter: id, occluder };
        let mut segments = Vec::new();
        for (edge, side) in self.sides_in(occluder) {
            let Some(through) = self.part_in_front(emitter, self.ends(edge)) else { continue };
            let inward = self.across_in(&plane, edge) * f64::from(side);
            let beside = |other: FaceId| self.prepared.edges[edge].faces.contains(&other);
            // Rays leave the face here that come over it: from sources on its side of the edge.
            let is_over = |chord: &&Chord| chord.iter().any(|&p| inward.dot(p - through[0]) > 0.0);
            for &source in chords.iter().filter(is_over) {
                segments.extend(self.in_plane(&InPlane { plane, source, occluder: through, beside: &beside }, event));
            }
        }
        merge::merge(segments, self.weld_m())
    }

    /// The edges of the faces in a plane, and on which side of the edge a face lies: the sense of [`Self::across_in`], or the
    /// other. Once each, though a sheet has two faces.
    fn sides_in(&self, plane: PlaneId) -> Vec<(EdgeId, i8)> {
        let frame = self.prepared.planes[plane].plane;
        let mut sides: Vec<(EdgeId, i8)> = Vec::new();
        for face in self.features.faces_in(plane) {
            let inside = polygon::centroid(&self.prepared.polygon_m(face));
            sides.extend(self.prepared.faces[face].sides.iter().flatten().map(|&DirectedEdge { edge, .. }| {
                let over = self.across_in(&frame, edge).dot(inside - self.ends(edge)[0]);
                (edge, if over > 0.0 { 1 } else { -1 })
            }));
        }
        sides.sort_unstable();
        sides.dedup();
        sides
    }

    /// The direction across an edge in a plane.
    fn across_in(&self, plane: &Plane, edge: EdgeId) -> DVec3 {
        let [from, to] = self.ends(edge);
        plane.normal.cross(to - from)
    }
}
