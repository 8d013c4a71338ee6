//! Edge-vertex and vertex-edge events of an emitter (paper, section 3.2, Fig. 2; Heckbert 1992).
//!
//! - **VE**: a vertex of the source and an edge of an occluder: the strip behind the edge, as seen from the vertex.
//! - **EV**: an edge of the source and a vertex of an occluder: the double pencil through the vertex.
//!
//! Both are degree 2, unless the source edge and the occluder edge lie in one plane: then the wedges of the two edges
//! coincide, and are one event of degree 1 ([`Event::EdgeEdge`]). Only silhouettes seen from the source feature count,
//! and only in front of the emitter's plane.

use glam::DVec3;

use super::silhouette::{OccluderEdge, OccluderEdges};
use super::strength::Sight;
use super::trace::{self, Received};
use super::wedge::Wedge;
use super::{DSegment, Degree, Emitter, Event};
use crate::geometry::Plane;
use crate::id::{EdgeId, EmitterId, FaceId, VertexId};
use crate::prepare::Prepared;
use crate::visibility::Visibility;

/// What the tracing of events reads.
#[derive(Clone, Copy)]
pub(super) struct Surroundings<'a> {
    pub(super) prepared: &'a Prepared,
    pub(super) visibility: &'a Visibility,
    pub(super) occluders: &'a OccluderEdges,
    /// Whether a face shows received light: emitters are drawn in their own colour.
    pub(super) receives: &'a (dyn Fn(FaceId) -> bool + Sync),
}

impl Surroundings<'_> {
    fn position(&self, vertex: VertexId) -> DVec3 {
        self.prepared.vertices_m[vertex]
    }

    fn ends(&self, edge: EdgeId) -> [DVec3; 2] {
        self.prepared.edges[edge].ends.map(|vertex| self.position(vertex))
    }

    fn coplanar_m(&self) -> f64 {
        self.prepared.tolerance.coplanar_m()
    }

    /// Whether the front of a face is turned to `apex`, and it shows light.
    pub(super) fn lit(&self, face: FaceId, apex: DVec3) -> bool {
        (self.receives)(face) && self.prepared.oriented_plane(face).signed_distance_m(apex) > self.coplanar_m()
    }

    /// The source edge at `corner` that lies in `plane`, if any.
    fn source_edge_in(&self, emitter: &Emitter, corner: VertexId, plane: &Plane) -> Option<EdgeId> {
        emitter.outline.iter().copied().find(|&edge| {
            self.prepared.edges[edge].ends.contains(&corner) && self.ends(edge).iter().all(|&p| self.is_in(plane, p))
        })
    }

    /// The occluder edge at `vertex` that lies in `plane`, if any.
    fn occluder_edge_in(&self, vertex: VertexId, plane: &Plane) -> Option<&OccluderEdge> {
        let edges = self.occluders.at_vertex[vertex].iter().map(|&i| &self.occluders.edges[i]);
        edges.into_iter().find(|edge| edge.ends_m.iter().all(|&p| self.is_in(plane, p)))
    }

    fn is_in(&self, plane: &Plane, point: DVec3) -> bool {
        plane.signed_distance_m(point).abs() <= self.coplanar_m()
    }

    /// The segments on the faces that receive a wedge.
    fn segments(
        &self,
        wedge: &Wedge,
        received: &[Received],
        event: Event,
        degree: Degree,
        strength: impl Fn(&Sight<'_>) -> f64,
        emitter: &Emitter,
    ) -> Vec<DSegment> {
        let least_m = self.prepared.tolerance.weld_m();
        let segment = |part: &Received| {
            let ends_m = [0, 1].map(|i| wedge.point(part.s[i], part.nearness[i]));
            let receiver = self.prepared.oriented_plane(part.face);
            let at = ends_m[0].midpoint(ends_m[1]);
            let sight = Sight { emitter, receiver: &receiver, wedge: &wedge.plane, at };
            DSegment { face: part.face, ends_m, degree, strength: strength(&sight), event }
        };
        received.iter().map(segment).filter(|segment| segment.length_m() > least_m).collect()
    }

    /// The VE event of a source corner and an occluder edge.
    pub(super) fn vertex_edge(
        &self,
        id: EmitterId,
        emitter: &Emitter,
        corner: VertexId,
        edge: &OccluderEdge,
    ) -> Vec<DSegment> {
        let apex = self.position(corner);
        let Some(ends) = self.part_in_front(emitter, edge.ends_m) else { return Vec::new() };
        let Some(wedge) = Wedge::new(apex, ends, self.prepared.tolerance.weld_m()) else { return Vec::new() };
        if !self.occluders.is_silhouette(edge, apex) {
            return Vec::new();
        }
        let beside = |face: FaceId| edge.faces.iter().any(|&(own, _)| own == face);
        let pieces = wedge.pieces(self.prepared, self.visibility, 0.0, beside);
        let hiding = trace::part_at(&pieces, 1.0, true);
        let beyond = trace::part_at(&pieces, 1.0, false);
        let received = trace::received(&hiding, &beyond, |face| self.lit(face, apex));
        let occluder = ends[0].midpoint(ends[1]);
        match self.source_edge_in(emitter, corner, &wedge.plane) {
            Some(source) => {
                let event = Event::EdgeEdge { emitter: id, source, occluder: edge.edge };
                let strength = |sight: &Sight<'_>| self.edge_edge_strength(sight, source, edge);
                self.segments(&wedge, &received, event, Degree::D1, strength, emitter)
            }
            None => {
                let event = Event::VertexEdge { emitter: id, source: corner, occluder: edge.edge };
                let strength = |sight: &Sight<'_>| sight.of_corner(apex, occluder);
                self.segments(&wedge, &received, event, Degree::D2, strength, emitter)
            }
        }
    }

    /// The EV event of a source edge and an occluder vertex.
    pub(super) fn edge_vertex(
        &self,
        id: EmitterId,
        emitter: &Emitter,
        source: EdgeId,
        vertex: VertexId,
    ) -> Vec<DSegment> {
        let apex = self.position(vertex);
        if emitter.plane.signed_distance_m(apex) <= self.coplanar_m() {
            return Vec::new();
        }
        let Some(towards) = Wedge::new(apex, self.ends(source), self.prepared.tolerance.weld_m()) else {
            return Vec::new();
        };
        let open = self.open_directions(vertex, &towards);
        if open.is_empty() {
            return Vec::new();
        }
        let away = towards.opposite();
        let hiding = trace::part_at(&towards.pieces(self.prepared, self.visibility, 1.0, |_| false), 1.0, true);
        let beyond = away.pieces(self.prepared, self.visibility, 0.0, |_| false);
        let received: Vec<Received> = trace::received(&hiding, &beyond, |face| self.lit(face, apex))
            .iter()
            .flat_map(|part| open.iter().filter_map(|interval| clip_received(part, *interval)))
            .collect();
        let middle = self.ends(source)[0].midpoint(self.ends(source)[1]);
        match self.occluder_edge_in(vertex, &towards.plane) {
            Some(edge) => {
                let event = Event::EdgeEdge { emitter: id, source, occluder: edge.edge };
                let strength = |sight: &Sight<'_>| self.edge_edge_strength(sight, source, edge);
                self.segments(&away, &received, event, Degree::D1, strength, emitter)
            }
            None => {
                let event = Event::EdgeVertex { emitter: id, source, occluder: vertex };
                let strength = |sight: &Sight<'_>| sight.of_corner(middle, apex);
                self.segments(&away, &received, event, Degree::D2, strength, emitter)
            }
        }
    }

    /// The part of an occluder edge in front of the emitter's plane.
    fn part_in_front(&self, emitter: &Emitter, ends: [DVec3; 2]) -> Option<[DVec3; 2]> {
        let heights_m = ends.map(|end| emitter.plane.signed_distance_m(end) - self.coplanar_m());
        let crossing = || ends[0].lerp(ends[1], heights_m[0] / (heights_m[0] - heights_m[1]));
        match heights_m.map(|height_m| height_m > 0.0) {
            [true, true] => Some(ends),
            [true, false] => Some([ends[0], crossing()]),
            [false, true] => Some([crossing(), ends[1]]),
            [false, false] => None,
        }
    }

    /// The directions from the source edge, seen from `vertex`, in which the vertex is on a silhouette: there rays graze
    /// it. They change only where the source edge passes through the plane of a face at the vertex.
    fn open_directions(&self, vertex: VertexId, towards: &Wedge) -> Vec<[f64; 2]> {
        let edges = &self.occluders.at_vertex[vertex];
        let mut ends = vec![0.0, 1.0];
        for &number in edges {
            for &(face, _) in &self.occluders.edges[number].faces {
                let plane = self.prepared.oriented_plane(face);
                let heights = [0.0, 1.0].map(|s| plane.signed_distance_m(towards.point(s, 1.0)));
                if heights[0] * heights[1] < 0.0 {
                    ends.push(heights[0] / (heights[0] - heights[1]));
                }
            }
        }
        ends.sort_by(f64::total_cmp);
        ends.windows(2)
            .filter(|pair| {
                let eye = towards.point(0.5 * (pair[0] + pair[1]), 1.0);
                pair[1] > pair[0]
                    && edges.iter().any(|&number| self.occluders.is_silhouette(&self.occluders.edges[number], eye))
            })
            .map(|pair| [pair[0], pair[1]])
            .collect()
    }

    fn edge_edge_strength(&self, sight: &Sight<'_>, source: EdgeId, occluder: &OccluderEdge) -> f64 {
        let ends = self.ends(source);
        let (middle, hider) = (ends[0].midpoint(ends[1]), occluder.ends_m[0].midpoint(occluder.ends_m[1]));
        let magnified =
            occluder.ends_m[0].distance(occluder.ends_m[1]) * middle.distance(sight.at) / hider.distance(sight.at);
        sight.of_edges(middle, hider, ends[0].distance(ends[1]).min(magnified))
    }
}

/// The part of a received interval inside an interval of directions.
fn clip_received(part: &Received, [from, to]: [f64; 2]) -> Option<Received> {
    let at = |s: f64| {
        let t = (s - part.s[0]) / (part.s[1] - part.s[0]);
        part.nearness[0] + t * (part.nearness[1] - part.nearness[0])
    };
    let s = [part.s[0].max(from), part.s[1].min(to)];
    (s[0] < s[1]).then(|| Received { face: part.face, s, nearness: s.map(at) })
}
