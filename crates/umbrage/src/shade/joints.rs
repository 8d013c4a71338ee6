//! Joints: which facets are one smooth surface at a point of their boundary, and so receive the same light there.
//!
//! Two facets of smooth surfaces are joined along an edge that they pass in opposite directions, where they bend by little and their
//! normals agree at both ends of it. Around a vertex, those are one surface that joined edges lead to from one another. Across a
//! contact (D0) nothing is joined: its two sides never share a value. A surface is named by its least facet at the point.

use rustc_hash::FxHashMap;

use crate::discontinuity::is_contact;
use crate::geometry::DisjointSets;
use crate::id::{EdgeId, FaceId, VertexId};
use crate::prepare::{DirectedEdge, Prepared, is_one_surface_at};

/// The facets that are joined.
#[derive(Debug, Default)]
pub(super) struct Joints {
    /// The surface of a facet along an edge, where it is not the facet alone.
    at_edges: FxHashMap<(EdgeId, FaceId), FaceId>,
    /// The same at a vertex.
    at_vertices: FxHashMap<(VertexId, FaceId), FaceId>,
}

impl Joints {
    pub(super) fn new(prepared: &Prepared) -> Self {
        let mut passages: Vec<(DirectedEdge, FaceId)> = Vec::new();
        for (face, sides) in prepared.faces.iter_enumerated().filter(|&(face, _)| prepared.is_smooth(face)) {
            passages.extend(sides.sides.iter().flatten().map(|&edge| (edge, face)));
        }
        passages.sort_unstable_by_key(|&(edge, face)| (edge.edge, face));
        let mut corners: Vec<(VertexId, FaceId)> =
            passages.iter().map(|&(edge, face)| (prepared.start(edge), face)).collect();
        corners.sort_unstable();
        corners.dedup();
        let mut around = DisjointSets::new(corners.len());
        let mut joints = Self::default();
        for sharing in passages.chunk_by(|one, other| one.0.edge == other.0.edge) {
            let mut along = DisjointSets::new(sharing.len());
            for (i, &(edge, one)) in sharing.iter().enumerate() {
                for (j, &(passed, other)) in sharing.iter().enumerate().skip(i + 1) {
                    if edge.reversed == passed.reversed || !is_joined(prepared, edge.edge, [one, other]) {
                        continue;
                    }
                    along.join(i, j);
                    for end in prepared.edges[edge.edge].ends {
                        // Both are in the table: the faces pass along the edge.
                        let [one, other] = [one, other].map(|face| corners.partition_point(|c| *c < (end, face)));
                        around.join(one, other);
                    }
                }
            }
            for (i, &(edge, face)) in sharing.iter().enumerate() {
                let first = along.first_of(i);
                if first != i {
                    joints.at_edges.insert((edge.edge, face), sharing[first].1);
                }
            }
        }
        for (number, &corner) in corners.iter().enumerate() {
            let first = around.first_of(number);
            if first != number {
                joints.at_vertices.insert(corner, corners[first].1);
            }
        }
        joints
    }

    /// The surface of a facet inside an edge of its boundary.
    pub(super) fn at_edge(&self, edge: EdgeId, face: FaceId) -> FaceId {
        self.at_edges.get(&(edge, face)).copied().unwrap_or(face)
    }

    /// The surface of a facet at a vertex of its boundary.
    pub(super) fn at_vertex(&self, vertex: VertexId, face: FaceId) -> FaceId {
        self.at_vertices.get(&(vertex, face)).copied().unwrap_or(face)
    }
}

/// Whether two facets that pass along an edge in opposite directions are one surface there.
fn is_joined(prepared: &Prepared, edge: EdgeId, faces: [FaceId; 2]) -> bool {
    !faces.iter().any(|&face| is_contact(prepared, edge, face))
        && prepared.edges[edge].ends.iter().all(|&end| {
            let at_m = prepared.vertices_m[end];
            let normals = faces.map(|face| prepared.smooth_normal(face, at_m));
            is_one_surface_at(faces.map(|face| prepared.normal(face)), normals)
        })
}
