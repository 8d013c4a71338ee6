//! d-segments: where on a face the radiosity function, or one of its derivatives, jumps (paper, section 3.2).

use serde::{Deserialize, Serialize};
use std::cmp::Ordering;

use glam::DVec3;

use super::LampCurve;
use crate::id::{EdgeId, EmitterId, FaceId, LampId, PlaneId, VertexId};
use crate::prepare::Prepared;

/// Which derivative of the radiosity function jumps across a d-segment.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
pub enum Degree {
    /// The value: a contact of two surfaces, or the shadow of a lamp without extent.
    D0,
    /// The slope: an occluder edge coplanar with a source edge, the source's own plane, an occluder's plane.
    D1,
    /// The curvature: every other edge-vertex and vertex-edge event.
    D2,
}

impl Degree {
    /// 0, 1 or 2.
    pub fn number(self) -> usize {
        match self {
            Self::D0 => 0,
            Self::D1 => 1,
            Self::D2 => 2,
        }
    }
}

/// What made a d-segment. Merging goes by it, and errors are explained by it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
pub enum Event {
    /// A surface ends on this edge of the face.
    Contact {
        /// The edge of contact.
        edge: EdgeId,
    },
    /// The plane of an emitter meets the face.
    SourcePlane {
        /// The emitter.
        emitter: EmitterId,
    },
    /// The plane of an occluder's faces cuts an emitter: where the plane meets the receiver, the occluder is seen
    /// edge-on, and another of its edges becomes the silhouette.
    OccluderPlane {
        /// The emitter.
        emitter: EmitterId,
        /// The plane of the occluder's faces.
        occluder: PlaneId,
    },
    /// A source edge and an occluder edge in one plane: the coincident EV and VE events of both.
    EdgeEdge {
        /// The emitter.
        emitter: EmitterId,
        /// Edge of the source.
        source: EdgeId,
        /// Edge of the occluder.
        occluder: EdgeId,
    },
    /// VE: the strip behind an occluder edge, as seen from a vertex of the source.
    VertexEdge {
        /// The emitter.
        emitter: EmitterId,
        /// Vertex of the source.
        source: VertexId,
        /// Edge of the occluder.
        occluder: EdgeId,
    },
    /// EV: the double pencil from an edge of the source through an occluder vertex.
    EdgeVertex {
        /// The emitter.
        emitter: EmitterId,
        /// Edge of the source.
        source: EdgeId,
        /// Vertex of the occluder.
        occluder: VertexId,
    },
    /// EEE: an edge of the source and two edges of occluders, no two in one plane.
    ThreeEdges {
        /// The emitter.
        emitter: EmitterId,
        /// Edge of the source.
        source: EdgeId,
        /// Edges of the occluders, first the one that is nearer to the source.
        occluders: [EdgeId; 2],
    },
    /// An occluder edge before a lamp without extent.
    LampEdge {
        /// The lamp.
        lamp: LampId,
        /// Edge of the occluder.
        occluder: EdgeId,
    },
    /// The light of a lamp without extent begins or ends here by itself.
    LampCurve {
        /// The lamp.
        lamp: LampId,
        /// Why.
        curve: LampCurve,
    },
}

impl Event {
    /// The emitter whose light it changes; contacts are of all light, and lamps are no emitters.
    pub(super) fn emitter(&self) -> Option<EmitterId> {
        match *self {
            Self::SourcePlane { emitter }
            | Self::OccluderPlane { emitter, .. }
            | Self::EdgeEdge { emitter, .. }
            | Self::VertexEdge { emitter, .. }
            | Self::EdgeVertex { emitter, .. }
            | Self::ThreeEdges { emitter, .. } => Some(emitter),
            Self::Contact { .. } | Self::LampEdge { .. } | Self::LampCurve { .. } => None,
        }
    }

    /// A short name of its kind.
    pub fn name(&self) -> &'static str {
        match self {
            Self::Contact { .. } => "contact",
            Self::SourcePlane { .. } => "source-plane",
            Self::OccluderPlane { .. } => "occluder-plane",
            Self::EdgeEdge { .. } => "edge-edge",
            Self::VertexEdge { .. } => "vertex-edge",
            Self::EdgeVertex { .. } => "edge-vertex",
            Self::ThreeEdges { .. } => "edge-edge-edge",
            Self::LampEdge { .. } => "lamp-edge",
            Self::LampCurve { curve: LampCurve::Terminator, .. } => "terminator",
            Self::LampCurve { curve: LampCurve::InnerCone, .. } => "inner-cone",
            Self::LampCurve { curve: LampCurve::OuterCone, .. } => "outer-cone",
            Self::LampCurve { curve: LampCurve::Range, .. } => "range",
        }
    }
}

/// A segment of discontinuity on a face.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct DSegment {
    /// The receiver.
    pub face: FaceId,
    /// Its ends, in the plane of the face, in metres.
    pub ends_m: [DVec3; 2],
    /// Its degree.
    pub degree: Degree,
    /// How much jumps across it at its middle: W/m2 (degree 0), W/m3 (1), W/m4 (2), the mean over the three colours.
    pub strength: f64,
    /// What made it.
    pub event: Event,
}

impl DSegment {
    /// The order of all d-segments: by face, then by what made them.
    pub(super) fn by_face_and_event(&self, other: &Self) -> Ordering {
        self.face.cmp(&other.face).then(self.event.cmp(&other.event))
    }

    /// The part of an edge that makes this segment: in a vertex-edge or edge-vertex event where the rays to its two
    /// ends pass the event's edge, in one of three edges where they leave the source's, as shares of the edge from its
    /// first end, ascending. The rest of the edge is hidden, or casts on other faces. `None` for all other events.
    pub fn visible_interval(&self, prepared: &Prepared) -> Option<[f64; 2]> {
        let (vertex, edge) = match self.event {
            Event::VertexEdge { source, occluder, .. } => (source, occluder),
            Event::EdgeVertex { source, occluder, .. } => (occluder, source),
            Event::ThreeEdges { source, occluders, .. } => {
                return Some(self.interval_of(|end| source_share(prepared, end, source, occluders)));
            }
            _ => return None,
        };
        let apex = prepared.vertices_m[vertex];
        let [from, to] = prepared.edges[edge].ends.map(|end| prepared.vertices_m[end]);
        let across = (from - apex).cross(to - from);
        Some(self.interval_of(|end| {
            // The ray from the apex meets the edge's line where both span the same area with the edge.
            let ray = end - apex;
            (from - apex).cross(ray).dot(across) / ray.cross(to - from).dot(across)
        }))
    }

    /// The shares of both ends, ascending.
    fn interval_of(&self, share: impl Fn(DVec3) -> f64) -> [f64; 2] {
        let mut at = self.ends_m.map(|end| share(end).clamp(0.0, 1.0));
        at.sort_by(f64::total_cmp);
        at
    }

    /// Its length, in metres.
    pub fn length_m(&self) -> f64 {
        self.ends_m[0].distance(self.ends_m[1])
    }
}

/// Where a ray from `eye` that passes two occluder edges meets the line of a source edge, as a share of the edge.
fn source_share(prepared: &Prepared, eye: DVec3, source: EdgeId, occluders: [EdgeId; 2]) -> f64 {
    let line = |edge: EdgeId| prepared.edges[edge].ends.map(|end| prepared.vertices_m[end] - eye);
    let [normal, other] = occluders.map(line).map(|[p, q]| p.cross(q).normalize_or_zero());
    let [from, to] = line(source);
    let turn = |normal: DVec3| normal.dot(to - from);
    let normal = if turn(normal).abs() > turn(other).abs() { normal } else { other };
    -normal.dot(from) / turn(normal)
}
