//! Faces, their edges and vertices: what `prepare` makes and every later stage reads.
//!
//! Holds:
//! - a vertex's coordinates are exactly representable in `f32`, relative to `origin_m`;
//! - a face is convex and lies in its plane within the coplanar tolerance; its corners run counter-clockwise seen from
//!   its front;
//! - a face's boundary is a list of *sides*, each a straight run of one or more directed edges; the last vertex of a
//!   side is the first of the next;
//! - edges meet in end points only: no vertex lies inside an edge, no two edges overlap;
//! - an edge lists every face on whose boundary it lies, in ascending order; it may have any number of them.

use glam::DVec3;
use serde::{Deserialize, Serialize};
use smallvec::SmallVec;

use super::Skin;
use super::rim::TAPER;
use crate::geometry::{Plane, PlaneFrame, Tolerance};
use crate::id::{EdgeId, FaceId, MaterialId, PlaneId, SkinId, SurfaceId, Table, VertexId};
use crate::scene::Scene;

/// An edge and the direction in which a boundary passes along it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
pub struct DirectedEdge {
    /// The edge.
    pub edge: EdgeId,
    /// Whether it is passed from its second end to its first.
    pub reversed: bool,
}

impl DirectedEdge {
    /// The same edge the other way.
    pub fn opposite(self) -> Self {
        Self { reversed: !self.reversed, ..self }
    }
}

/// A straight run of directed edges.
pub type Side = SmallVec<[DirectedEdge; 1]>;

/// An undirected edge between two vertices.
#[derive(Clone, Debug, PartialEq)]
pub struct Edge {
    /// Its ends, the smaller id first.
    pub ends: [VertexId; 2],
    /// The faces on whose boundary it lies, ascending.
    pub faces: SmallVec<[FaceId; 4]>,
}

/// Which way a face looks along the normal of its plane.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
pub enum Facing {
    /// The front is where the plane's normal points.
    Along,
    /// The front is where the plane's normal comes from.
    Against,
}

/// A convex, plane, one-sided polygon of one material: the root of a patch tree.
#[derive(Clone, Debug, PartialEq)]
pub struct Face {
    /// The plane that it lies in.
    pub plane: PlaneId,
    /// Which way it looks.
    pub facing: Facing,
    /// The surface that it came from.
    pub surface: SurfaceId,
    /// Its material.
    pub material: MaterialId,
    /// What is laid over it.
    pub skin: Option<SkinId>,
    /// Its boundary, counter-clockwise seen from the front.
    pub sides: Vec<Side>,
}

/// A narrow strip beyond an edge of a face, in its plane: area that is hidden, as the floor under a wall, and that continues
/// what the face shows, so that rounding on the way to the screen opens no crack and shows no dark.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rim {
    /// The edge.
    pub edge: EdgeId,
    /// The face that ends there.
    pub face: FaceId,
    /// How far the strip reaches beyond the edge, in metres.
    pub width_m: f64,
}

impl Rim {
    /// By how much the far side of the strip is shorter at each end, in metres.
    pub fn taper_m(&self) -> f64 {
        TAPER * self.width_m
    }
}

/// What `prepare` mended, counted.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct PrepareReport {
    /// Polygons of the input.
    pub polygons: usize,
    /// Corners of the input that became one with another.
    pub welded_corners: usize,
    /// Polygons without area that were left out.
    pub degenerate_polygons: usize,
    /// Polygons with the same corners as an earlier one, that were left out.
    pub duplicate_polygons: usize,
    /// Polygons that were not plane and were cut into triangles.
    pub nonplanar_polygons: usize,
    /// Corners of smooth polygons whose normals are turned away from the polygon, whose own normal counts there instead.
    pub unusable_normals: usize,
    /// Polygons of closed shells that looked another way than most of their shell, and were turned over: a guess.
    pub turned_polygons: usize,
    /// Vertices of the input that lay inside another polygon's edge (T-vertices), and cut it.
    pub t_vertices: usize,
    /// Edges on which a surface ends on another that goes on.
    pub contact_edges: usize,
    /// Regions where coplanar polygons that look the same way overlapped, and the smaller won.
    pub overlaps: usize,
    /// Cuts that rounding left no room for, and that were left out.
    pub dropped_cuts: usize,
    /// Share of the area of all sides that is hidden, 0 to 1: sides that no light reaches and nobody can see, and that have no faces.
    pub hidden_share: f64,
}

/// The prepared scene.
#[derive(Clone, Debug)]
pub struct Prepared {
    /// What is added to a vertex to place it in the world, in metres.
    pub origin_m: DVec3,
    /// Tolerances of this scene.
    pub tolerance: Tolerance,
    /// The planes, each with the frame in which its faces are measured.
    pub planes: Table<PlaneId, PlaneFrame>,
    /// What is laid over the faces.
    pub skins: Table<SkinId, Skin>,
    /// Vertices, relative to `origin_m`, in metres.
    pub vertices_m: Table<VertexId, DVec3>,
    /// Edges.
    pub edges: Table<EdgeId, Edge>,
    /// Faces.
    pub faces: Table<FaceId, Face>,
    /// Rims beyond edges of faces, by edge and face; none where no area is hidden.
    pub rims: Vec<Rim>,
    /// What was mended.
    pub report: PrepareReport,
}

/// A broken promise of [`Prepared`]: always a defect of this library.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum PreparedError {
    /// A vertex is not representable in `f32`.
    #[error("{0:?} is not an f32 point")]
    NotF32(VertexId),
    /// A face's boundary is not a closed loop of edges that list the face.
    #[error("{0:?} has a boundary that is not a loop of its own edges")]
    OpenBoundary(FaceId),
    /// A vertex of a face is not in its plane.
    #[error("{face:?} has {vertex:?} at {distance_m} m from its plane")]
    OffPlane {
        /// The face.
        face: FaceId,
        /// Its vertex.
        vertex: VertexId,
        /// Distance of the vertex from the plane.
        distance_m: f64,
    },
    /// A face is not convex, or has no area.
    #[error("{0:?} is not a convex polygon with area")]
    NotConvex(FaceId),
    /// A side is not straight.
    #[error("{face:?} has side {side}, which is not straight")]
    BentSide {
        /// The face.
        face: FaceId,
        /// Number of its side.
        side: usize,
    },
}

impl Prepared {
    /// First vertex of a directed edge.
    pub fn start(&self, edge: DirectedEdge) -> VertexId {
        self.edges[edge.edge].ends[usize::from(edge.reversed)]
    }

    /// Last vertex of a directed edge.
    pub fn end(&self, edge: DirectedEdge) -> VertexId {
        self.start(edge.opposite())
    }

    /// All boundary vertices of a face, those inside straight sides included.
    pub fn boundary(&self, face: FaceId) -> impl Iterator<Item = VertexId> + '_ {
        self.faces[face].sides.iter().flatten().map(|&e| self.start(e))
    }

    /// The corners of a face: the ends of its sides.
    pub fn corners(&self, face: FaceId) -> impl Iterator<Item = VertexId> + '_ {
        self.faces[face].sides.iter().map(|side| self.start(side[0]))
    }

    /// The polygon of a face: positions of its corners, counter-clockwise seen from its front, in metres.
    pub fn polygon_m(&self, face: FaceId) -> Vec<DVec3> {
        self.corners(face).map(|v| self.vertices_m[v]).collect()
    }

    /// The oriented plane of a face: its front is the face's.
    pub fn oriented_plane(&self, face: FaceId) -> Plane {
        let plane = self.planes[self.faces[face].plane].plane;
        match self.faces[face].facing {
            Facing::Along => plane,
            Facing::Against => plane.flipped(),
        }
    }

    /// The frame of a face's plane, oriented like the face: its corners run counter-clockwise in it.
    pub fn face_frame(&self, face: FaceId) -> PlaneFrame {
        let frame = self.planes[self.faces[face].plane];
        match self.faces[face].facing {
            Facing::Along => frame,
            Facing::Against => {
                PlaneFrame { plane: frame.plane.flipped(), origin: frame.origin, u: frame.v, v: frame.u }
            }
        }
    }

    /// The unit normal of a face, towards its front.
    pub fn normal(&self, face: FaceId) -> DVec3 {
        self.oriented_plane(face).normal
    }

    /// The unit normal of the surface that a face stands for, at a point of it: its own unless it is part of a smooth one.
    pub fn smooth_normal(&self, face: FaceId, at_m: DVec3) -> DVec3 {
        let flat = self.normal(face);
        self.faces[face].skin.map_or(flat, |skin| self.skins[skin].normal(at_m, flat))
    }

    /// Whether a face shows the light that it receives: emitters are drawn in their own colour.
    pub fn shows_light(&self, scene: &Scene, face: FaceId) -> bool {
        !scene.materials[self.faces[face].material].emits()
    }

    /// Whether a face is part of a smooth surface.
    pub fn is_smooth(&self, face: FaceId) -> bool {
        self.faces[face].skin.is_some_and(|skin| self.skins[skin].is_smooth())
    }

    /// Whether what a face shows goes on in a rim beyond an edge.
    pub fn has_rim(&self, edge: EdgeId, face: FaceId) -> bool {
        self.rims.binary_search_by_key(&(edge, face), |rim| (rim.edge, rim.face)).is_ok()
    }

    /// Checks what the head of this file promises.
    ///
    /// # Errors
    /// The first broken promise.
    pub fn validate(&self) -> Result<(), PreparedError> {
        for (id, p) in self.vertices_m.iter_enumerated() {
            if p.as_vec3().as_dvec3() != *p {
                return Err(PreparedError::NotF32(id));
            }
        }
        for (id, face) in self.faces.iter_enumerated() {
            self.validate_boundary(id, face)?;
            self.validate_shape(id, face)?;
        }
        Ok(())
    }

    fn validate_boundary(&self, id: FaceId, face: &Face) -> Result<(), PreparedError> {
        let run: Vec<DirectedEdge> = face.sides.iter().flatten().copied().collect();
        let closed = (0..run.len()).all(|i| self.end(run[i]) == self.start(run[(i + 1) % run.len()]));
        let listed = run.iter().all(|e| self.edges[e.edge].faces.contains(&id));
        if run.len() >= 3 && closed && listed && face.sides.iter().all(|s| !s.is_empty()) {
            Ok(())
        } else {
            Err(PreparedError::OpenBoundary(id))
        }
    }

    fn validate_shape(&self, id: FaceId, face: &Face) -> Result<(), PreparedError> {
        let (plane, slack_m) = (self.oriented_plane(id), self.tolerance.weld_m());
        for vertex in self.boundary(id) {
            let distance_m = plane.signed_distance_m(self.vertices_m[vertex]);
            if distance_m.abs() > slack_m {
                return Err(PreparedError::OffPlane { face: id, vertex, distance_m });
            }
        }
        let corners = self.polygon_m(id);
        let n = corners.len();
        for (i, side) in face.sides.iter().enumerate() {
            let (a, b, c) = (corners[i], corners[(i + 1) % n], corners[(i + 2) % n]);
            let turn = (b - a).cross(c - b).dot(plane.normal);
            if turn < -slack_m * (b - a).length().max((c - b).length()) {
                return Err(PreparedError::NotConvex(id));
            }
            let direction = (b - a).normalize_or_zero();
            let bent = side.iter().skip(1).any(|&e| {
                let p = self.vertices_m[self.start(e)] - a;
                (p - p.dot(direction) * direction).length() > slack_m
            });
            if bent {
                return Err(PreparedError::BentSide { face: id, side: i });
            }
        }
        let area = crate::geometry::polygon::doubled_area_vector(&corners).dot(plane.normal);
        if area > 0.0 { Ok(()) } else { Err(PreparedError::NotConvex(id)) }
    }
}
