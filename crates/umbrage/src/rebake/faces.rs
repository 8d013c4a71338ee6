//! Where all faces are: what is kept of a bake is of no use to any others.

use glam::DVec3;
use serde::{Deserialize, Serialize};

use crate::geometry::PlaneFrame;
use crate::id::{PlaneId, VertexId};
use crate::prepare::{DirectedEdge, Face, Facing, Prepared};

/// The prepared faces of a scene, as far as they decide on what sees what.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct Faces {
    origin_m: DVec3,
    planes: Vec<PlaneFrame>,
    vertices_m: Vec<DVec3>,
    edges: Vec<[VertexId; 2]>,
    faces: Vec<Outline>,
}

/// A face.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
struct Outline {
    plane: PlaneId,
    facing: Facing,
    sides: Vec<Vec<DirectedEdge>>,
}

impl Faces {
    pub(super) fn of(prepared: &Prepared) -> Self {
        let outline = |face: &Face| Outline {
            plane: face.plane,
            facing: face.facing,
            sides: face.sides.iter().map(|side| side.to_vec()).collect(),
        };
        Self {
            origin_m: prepared.origin_m,
            planes: prepared.planes.raw.clone(),
            vertices_m: prepared.vertices_m.raw.clone(),
            edges: prepared.edges.iter().map(|edge| edge.ends).collect(),
            faces: prepared.faces.iter().map(outline).collect(),
        }
    }
}
