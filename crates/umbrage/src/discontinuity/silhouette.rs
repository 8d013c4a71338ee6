//! Edges that can hide something: silhouette edges of all faces, closed shells and open sheets alike.
//!
//! Seen from a point, every face along an edge hides what lies on one side of the plane through the point and the edge.
//! Where the faces hide both sides, nothing changes across the edge; where they hide one, it is a silhouette. The rule
//! needs no orientation and holds for any number of faces.

use glam::DVec3;
use smallvec::SmallVec;

use crate::geometry::{Plane, polygon};
use crate::id::{EdgeId, FaceId, Table, VertexId};
use crate::prepare::Prepared;

/// An edge that is not inside a flat surface.
#[derive(Clone, Debug)]
pub(super) struct OccluderEdge {
    pub(super) edge: EdgeId,
    pub(super) ends_m: [DVec3; 2],
    /// The faces along it, and a point inside each.
    faces: SmallVec<[(FaceId, DVec3); 2]>,
}

impl OccluderEdge {
    /// Whether a face lies along the edge.
    pub(super) fn is_beside(&self, face: FaceId) -> bool {
        self.faces.iter().any(|&(own, _)| own == face)
    }

    /// The faces along the edge.
    pub(super) fn faces(&self) -> impl Iterator<Item = FaceId> + '_ {
        self.faces.iter().map(|&(face, _)| face)
    }

    /// Which sides of a plane through the edge its faces hide: in front, behind.
    pub(super) fn hidden_sides(&self, plane: &Plane, slack_m: f64) -> [bool; 2] {
        let heights_m = || self.faces.iter().map(|&(_, inside)| plane.signed_distance_m(inside));
        [heights_m().any(|height_m| height_m > slack_m), heights_m().any(|height_m| height_m < -slack_m)]
    }
}

/// The edges that can be silhouettes, and the vertices that they end at.
#[derive(Clone, Debug)]
pub(super) struct OccluderEdges {
    pub(super) edges: Vec<OccluderEdge>,
    /// Number of each edge.
    number: Table<EdgeId, Option<u32>>,
    /// The ends of all edges, ascending.
    pub(super) vertices: Vec<VertexId>,
}

impl OccluderEdges {
    pub(super) fn new(prepared: &Prepared) -> Self {
        let inside: Table<FaceId, DVec3> =
            prepared.faces.keys().map(|face| polygon::centroid(&prepared.polygon_m(face))).collect();
        let mut edges: Vec<OccluderEdge> = Vec::new();
        let mut vertices = Vec::new();
        let mut number = Table::with_capacity(prepared.edges.len());
        for (id, edge) in prepared.edges.iter_enumerated() {
            let ends_m = edge.ends.map(|vertex| prepared.vertices_m[vertex]);
            if edge.faces.is_empty() || is_flat(prepared, &inside, &edge.faces, ends_m) {
                number.push(None);
                continue;
            }
            number.push(Some(edges.len() as u32));
            vertices.extend(edge.ends);
            let faces = edge.faces.iter().map(|&face| (face, inside[face])).collect();
            edges.push(OccluderEdge { edge: id, ends_m, faces });
        }
        vertices.sort_unstable();
        vertices.dedup();
        Self { edges, number, vertices }
    }

    /// The occluder edge of an edge, if it can hide something.
    pub(super) fn of(&self, edge: EdgeId) -> Option<&OccluderEdge> {
        self.number[edge].map(|number| &self.edges[number as usize])
    }
}

/// Whether a plane surface goes on across the edge: then the edge hides nothing from anywhere.
fn is_flat(prepared: &Prepared, inside: &Table<FaceId, DVec3>, faces: &[FaceId], [p, q]: [DVec3; 2]) -> bool {
    let along = (q - p).normalize_or_zero();
    let across = |face: FaceId| {
        let d = inside[face] - p;
        d - d.dot(along) * along
    };
    faces.iter().enumerate().any(|(i, &one)| {
        faces[i + 1..].iter().any(|&other| {
            prepared.faces[one].plane == prepared.faces[other].plane && across(one).dot(across(other)) < 0.0
        })
    })
}
