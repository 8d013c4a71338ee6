//! Shadow edges of lamps: the light of a point or of a distant lamp jumps where an occluder's edge passes before it
//! (degree 0).
//!
//! A lamp and an edge of an occluder span a plane, in which the edge's shadow is traced like a wedge of an event: from
//! a point the rays of a wedge, from a distant lamp a strip of parallel ones.

use glam::DVec3;

use super::features::Surroundings;
use super::silhouette::OccluderEdge;
use super::trace::{self, Received};
use super::wedge::{Piece, Wedge, chord, clip_directions};
use super::{DSegment, Degree, Event, closed_gap};
use crate::geometry::Plane;
use crate::id::{FaceId, LampId};

/// A strip of parallel rays past an edge. Direction `s` is the place along the edge, 0 to 1; nearness falls from 1 on
/// the edge to 0 at `reach_m`, linearly, so that straight pieces are straight in both.
struct Strip {
    from: DVec3,
    along: DVec3,
    direction: DVec3,
    reach_m: f64,
    plane: Plane,
}

/// A ray of so many extents leaves the scene from anywhere in it.
const REACH_OF_EXTENT: f64 = 2.0;

impl Strip {
    /// The strip of an edge; `None` where the rays run along it.
    fn new([from, to]: [DVec3; 2], direction: DVec3, extent_m: f64, least_m: f64) -> Option<Self> {
        let along = to - from;
        let across = along.cross(direction);
        let plane = Plane::through(from, across.try_normalize()?);
        let wide = across.length() > least_m;
        wide.then_some(Self { from, along, direction, reach_m: REACH_OF_EXTENT * extent_m, plane })
    }

    fn point(&self, s: f64, nearness: f64) -> DVec3 {
        self.from + s * self.along + (1.0 - nearness) * self.reach_m * self.direction
    }

    /// Direction and nearness of a point of the plane.
    fn coordinates(&self, point: DVec3) -> (f64, f64) {
        let d = point - self.from;
        let square = self.along - self.along.dot(self.direction) * self.direction;
        let s = d.dot(square) / square.length_squared();
        (s, 1.0 - (d - s * self.along).dot(self.direction) / self.reach_m)
    }
}

impl Surroundings<'_> {
    /// The shadow of an occluder's edge by a lamp.
    pub(super) fn lamp_edge(&self, id: LampId, edge: &OccluderEdge) -> Vec<DSegment> {
        let (lamp, extent_m) = (&self.features.lamps[id], self.prepared.tolerance.extent_m);
        let beside = |face: FaceId| edge.is_beside(face);
        let towards = |at_m: DVec3| lamp.arriving(at_m).map(|arriving| arriving.towards);
        // Any point of the plane of lamp and edge tells what the edge hides.
        let middle = edge.ends_m[0].midpoint(edge.ends_m[1]);
        let eye = match lamp.position_m() {
            Some(position_m) => position_m,
            None => middle + extent_m * towards(middle).unwrap_or(DVec3::ZERO),
        };
        let Some(plane) = Plane::of_polygon(&[eye, edge.ends_m[0], edge.ends_m[1]]) else { return Vec::new() };
        if edge.hidden_sides(&plane, self.coplanar_m()) == [true, true] {
            return Vec::new();
        }
        let lit = |face: FaceId| match lamp.position_m() {
            Some(position_m) => self.lit(face, position_m),
            None => {
                let plane = self.prepared.oriented_plane(face);
                let at_m = plane.project(middle);
                self.lit(face, at_m + extent_m * towards(at_m).unwrap_or(DVec3::ZERO))
            }
        };
        let trace = |pieces: &[Piece]| -> Vec<Received> {
            let hiding = trace::part_at(pieces, 1.0, true);
            trace::received(&hiding, &trace::part_at(pieces, 1.0, false), lit, |face| self.visibility.plane(face))
        };
        let ends: Vec<(FaceId, [DVec3; 2])> = match lamp.position_m() {
            Some(apex) => {
                let Some(wedge) = Wedge::new(apex, edge.ends_m, self.weld_m()) else { return Vec::new() };
                let received = trace(&wedge.pieces(self.visibility, 0.0, beside));
                let on = |part: &Received| [0, 1].map(|i| wedge.point(part.s[i], part.nearness[i]));
                received.iter().map(|part| (part.face, on(part))).collect()
            }
            None => {
                let Some(direction) = towards(middle).map(|towards| -towards) else { return Vec::new() };
                let strip = Strip::new(edge.ends_m, direction, extent_m, self.weld_m());
                let Some(strip) = strip else { return Vec::new() };
                let received = trace(&self.pieces_in(&strip, beside));
                let on = |part: &Received| [0, 1].map(|i| strip.point(part.s[i], part.nearness[i]));
                received.iter().map(|part| (part.face, on(part))).collect()
            }
        };
        let event = Event::LampEdge { lamp: id, occluder: edge.edge };
        let segment = |(face, ends_m): (FaceId, [DVec3; 2])| {
            // Beyond its range, and out of its cone, a lamp has no shadows.
            lamp.arriving(ends_m[0].midpoint(ends_m[1]))?;
            // Across a closed gap the contact stands for it.
            if edge.faces().any(|over| closed_gap::is_across(self.prepared, self.visibility, [over, face], ends_m)) {
                return None;
            }
            self.segment_between(face, ends_m, event, Degree::D0)
        };
        ends.into_iter().filter_map(segment).collect()
    }

    /// The pieces of all faces in a strip, but for those beside its edge.
    fn pieces_in(&self, strip: &Strip, but: impl Fn(FaceId) -> bool) -> Vec<Piece> {
        let faces = self.visibility.faces_meeting_plane(&strip.plane, |_, _| true);
        let piece = |face: FaceId| {
            let (crossing, ends) = chord(self.visibility, face, &strip.plane)?;
            let coordinates = ends.into_iter().map(|end| strip.coordinates(end));
            let first = coordinates.clone().min_by(|p, q| p.0.total_cmp(&q.0))?;
            let last = coordinates.max_by(|p, q| p.0.total_cmp(&q.0))?;
            let (s, nearness) = clip_directions([first, last])?;
            Some(Piece { face, crossing, s, nearness })
        };
        faces.into_iter().filter(|&face| !but(face)).filter_map(piece).collect()
    }
}
