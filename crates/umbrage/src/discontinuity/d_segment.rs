//! d-segments: where on a face the radiosity function, or one of its derivatives, jumps (paper, section 3.2).

use glam::DVec3;

use crate::id::{EdgeId, EmitterId, FaceId, LampId, VertexId};

/// Which derivative of the radiosity function jumps across a d-segment.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Degree {
    /// The value: a contact of two surfaces, or the shadow of a lamp without extent.
    D0,
    /// The slope: an occluder edge coplanar with a source edge, or the source's own plane.
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
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
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
    /// An occluder edge before a lamp without extent.
    LampEdge {
        /// The lamp.
        lamp: LampId,
        /// Edge of the occluder.
        occluder: EdgeId,
    },
}

/// A segment of discontinuity on a face.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DSegment {
    /// The receiver.
    pub face: FaceId,
    /// Its ends, in the plane of the face, in metres.
    pub ends_m: [DVec3; 2],
    /// Its degree.
    pub degree: Degree,
    /// How much jumps across it: W/m2 (degree 0), W/m3 (1), W/m4 (2); an estimate that orders hints of one degree.
    pub strength: f64,
    /// What made it.
    pub event: Event,
}

impl DSegment {
    /// Its length, in metres.
    pub fn length_m(&self) -> f64 {
        self.ends_m[0].distance(self.ends_m[1])
    }
}
