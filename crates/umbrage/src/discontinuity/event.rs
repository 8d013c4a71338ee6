//! Edge-vertex and vertex-edge events of degree 2 (paper, section 3.2, Fig. 2; Heckbert 1992).
//!
//! - **VE**: a corner of a source and an edge of an occluder: the strip behind the edge, as seen from the corner.
//! - **EV**: an edge of a source and a vertex of an occluder: the double pencil through the vertex.
//!
//! A wedge casts where its vertex has steps (`corner`) that do not cancel. The image of the vertex changes along the wedge
//! only where a ray lies in the plane of a face at the vertex, so the wedge falls into intervals of direction that are open or
//! not. Where an edge of the source and one of the occluder lie in one plane, the event is one of degree 1 (`edge_edge`),
//! and none of these.

use glam::DVec3;
use smallvec::SmallVec;

use super::corner::{self, FaceCorner, Step};
use super::features::Surroundings;
use super::silhouette::OccluderEdge;
use super::source::{SourceEdge, SourceVertex};
use super::trace::{self, Received};
use super::wedge::Wedge;
use super::{DSegment, Degree, Event};
use crate::id::VertexId;
use crate::scene::Rgb;

/// Intervals of direction in a wedge.
type Intervals = SmallVec<[[f64; 2]; 2]>;

impl Surroundings<'_> {
    /// The VE event of a source corner and an occluder edge.
    pub(super) fn vertex_edge(&self, source: &SourceVertex, edge: &OccluderEdge) -> Vec<DSegment> {
        let apex = source.at_m;
        let Some(wedge) = Wedge::new(apex, edge.ends_m, self.weld_m()) else { return Vec::new() };
        if edge.hidden_sides(&wedge.plane, self.coplanar_m()) == [true, true] {
            return Vec::new();
        }
        let in_one_plane =
            |&number: &usize| self.common_plane(self.features.sources.edges[number].ends_m, edge.ends_m).is_some();
        if source.edges.iter().any(in_one_plane) {
            return Vec::new();
        }
        let corners = self.features.corners.at(source.vertex);
        let open = open_intervals(corners, &wedge, |s| {
            let to_eye = (wedge.point(s, 1.0) - apex).normalize();
            let steps = corner::steps(corners, to_eye, corner::emitted(Rgb::ZERO));
            corner::slope_jump(&steps, to_eye, wedge.plane.normal) != Rgb::ZERO
        });
        if open.is_empty() {
            return Vec::new();
        }
        if self.is_walled_off(&wedge, [apex; 2], edge.ends_m, |face| edge.is_beside(face)) {
            return Vec::new();
        }
        let pieces = wedge.pieces(self.visibility, 0.0, |face| edge.is_beside(face));
        let hiding = trace::part_at(&pieces, 1.0, true);
        let beyond = trace::part_at(&pieces, 1.0, false);
        let received = self.received(&wedge, &hiding, &beyond);
        let event = Event::VertexEdge { emitter: source.emitter, source: source.vertex, occluder: edge.edge };
        self.open_segments(&wedge, &received, &open, event)
    }

    /// The EV event of a source edge and an occluder vertex.
    pub(super) fn edge_vertex(&self, source: &SourceEdge, vertex: VertexId) -> Vec<DSegment> {
        let apex = self.position(vertex);
        if source.step(apex, self.coplanar_m(), Rgb::ZERO) == Rgb::ZERO {
            return Vec::new();
        }
        let Some(towards) = Wedge::new(apex, source.ends_m, self.weld_m()) else { return Vec::new() };
        let corners = self.features.corners.at(vertex);
        let in_one_plane = |step: &Step| self.common_plane(source.ends_m, [apex, apex + step.edge]).is_some();
        let open = open_intervals(corners, &towards, |s| {
            let to_eye = (apex - towards.point(s, 1.0)).normalize();
            let steps = corner::steps(corners, to_eye, corner::open);
            !steps.iter().any(in_one_plane) && corner::slope_jump(&steps, to_eye, towards.plane.normal) != Rgb::ZERO
        });
        if open.is_empty() {
            return Vec::new();
        }
        if self.is_walled_off(&towards, source.ends_m, [apex; 2], |_| false) {
            return Vec::new();
        }
        let away = towards.opposite();
        let hiding = trace::part_at(&towards.pieces(self.visibility, 1.0, |_| false), 1.0, true);
        let beyond = away.pieces(self.visibility, 0.0, |_| false);
        let received = self.received(&away, &hiding, &beyond);
        let event = Event::EdgeVertex { emitter: source.emitter, source: source.edge, occluder: vertex };
        self.open_segments(&away, &received, &open, event)
    }

    fn open_segments(&self, wedge: &Wedge, received: &[Received], open: &Intervals, event: Event) -> Vec<DSegment> {
        received
            .iter()
            .flat_map(|part| open.iter().filter_map(|&interval| part.clipped(interval)))
            .filter_map(|part| self.segment(wedge, &part, event, Degree::D2))
            .collect()
    }
}

/// The directions of a wedge in which the image of its apex, where these faces meet, is open.
fn open_intervals(corners: &[FaceCorner], wedge: &Wedge, is_open: impl Fn(f64) -> bool) -> Intervals {
    let mut ends: SmallVec<[f64; 8]> = SmallVec::from_slice(&[0.0, 1.0]);
    for corner in corners {
        let [from, to] = wedge.rays.map(|ray: DVec3| corner.normal.dot(ray));
        if from * to < 0.0 {
            ends.push(from / (from - to));
        }
    }
    ends.sort_by(f64::total_cmp);
    let mut open = Intervals::new();
    for pair in ends.windows(2).filter(|pair| pair[0] < pair[1] && is_open(0.5 * (pair[0] + pair[1]))) {
        match open.last_mut().filter(|last| last[1] == pair[0]) {
            Some(last) => last[1] = pair[1],
            None => open.push([pair[0], pair[1]]),
        }
    }
    open
}
