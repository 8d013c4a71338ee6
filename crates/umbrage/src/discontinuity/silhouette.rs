//! Edges that can hide something: silhouette edges of all faces, closed shells and open sheets alike.
//!
//! Seen from a point, every face along an edge hides what lies on one side of the plane through the point and the edge.
//! Where the faces hide both sides, nothing changes across the edge; where they hide one, it is a silhouette. The rule
//! needs no orientation and holds for any number of faces.

use glam::DVec3;

use crate::geometry::Plane;
use crate::id::{EdgeId, FaceId, Table, VertexId};
use crate::prepare::Prepared;

/// An edge that is not inside a flat surface.
#[derive(Clone, Debug)]
pub(super) struct OccluderEdge {
    pub(super) edge: EdgeId,
    pub(super) ends_m: [DVec3; 2],
    /// The faces along it, and a point inside each.
    pub(super) faces: Vec<(FaceId, DVec3)>,
}

/// The edges that can be silhouettes, and those at each vertex.
#[derive(Clone, Debug)]
pub(super) struct OccluderEdges {
    pub(super) edges: Vec<OccluderEdge>,
    /// Numbers of the edges at each vertex, ascending.
    pub(super) at_vertex: Table<VertexId, Vec<usize>>,
    slack_m: f64,
}

impl OccluderEdges {
    pub(super) fn new(prepared: &Prepared) -> Self {
        let mut edges: Vec<OccluderEdge> = Vec::new();
        let mut at_vertex: Table<VertexId, Vec<usize>> = prepared.vertices_m.iter().map(|_| Vec::new()).collect();
        let inside: Table<FaceId, DVec3> =
            prepared.faces.keys().map(|face| crate::geometry::polygon::centroid(&prepared.polygon_m(face))).collect();
        for (id, edge) in prepared.edges.iter_enumerated() {
            let ends_m = edge.ends.map(|vertex| prepared.vertices_m[vertex]);
            if edge.faces.is_empty() || is_flat(prepared, &inside, &edge.faces, ends_m) {
                continue;
            }
            edge.ends.iter().for_each(|&vertex| at_vertex[vertex].push(edges.len()));
            let faces = edge.faces.iter().map(|&face| (face, inside[face])).collect();
            edges.push(OccluderEdge { edge: id, ends_m, faces });
        }
        Self { edges, at_vertex, slack_m: prepared.tolerance.coplanar_m() }
    }

    /// Whether `edge` is a silhouette seen from `eye`: its faces hide at most one of the sides of the plane of both.
    pub(super) fn is_silhouette(&self, edge: &OccluderEdge, eye: DVec3) -> bool {
        let [p, q] = edge.ends_m;
        let Some(plane) = Plane::of_polygon(&[eye, p, q]) else { return false };
        let heights_m = edge.faces.iter().map(|&(_, inside)| plane.signed_distance_m(inside));
        let (mut above, mut below) = (false, false);
        for height_m in heights_m {
            above |= height_m > self.slack_m;
            below |= height_m < -self.slack_m;
        }
        !(above && below)
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
