//! The baked mesh: triangles, and the irradiance at each of their corners.
//!
//! Holds:
//! - one part per surface of the scene, in the same order, empty where the surface is not baked;
//! - positions are `f32`, relative to `origin_m`: the same point has the same bits wherever it occurs, in all parts;
//! - a vertex is shared by triangles of one part except across creases, jumps of the irradiance (D0) and borders of the texture mapping;
//! - no corner of a triangle lies inside another triangle's edge (T-vertex), no triangle is without area.

use glam::DVec3;

use crate::id::SurfaceId;

/// The triangles of one surface.
#[derive(Clone, Debug, PartialEq)]
pub struct BakedPart {
    /// The surface that they came from.
    pub surface: SurfaceId,
    /// Vertices relative to the mesh's origin, in metres.
    pub positions_m: Vec<[f32; 3]>,
    /// Unit normal of each vertex.
    pub normals: Vec<[f32; 3]>,
    /// Texture coordinates of each vertex, (0, 0) being the upper left of the image; empty without.
    pub uvs: Vec<[f32; 2]>,
    /// Irradiance on the front at each vertex, linear RGB, in W/m2.
    pub irradiance: Vec<[f32; 3]>,
    /// Triangles, counter-clockwise seen from the front.
    pub triangles: Vec<[u32; 3]>,
}

impl BakedPart {
    /// No triangle of a surface.
    pub fn new(surface: SurfaceId) -> Self {
        Self {
            surface,
            positions_m: Vec::new(),
            normals: Vec::new(),
            uvs: Vec::new(),
            irradiance: Vec::new(),
            triangles: Vec::new(),
        }
    }
}

/// What a bake leaves: a triangle mesh with light at its vertices.
#[derive(Clone, Debug, PartialEq)]
pub struct BakedMesh {
    /// What is added to a vertex to place it in the world, in metres.
    pub origin_m: DVec3,
    /// One part per surface of the scene, in order.
    pub parts: Vec<BakedPart>,
}

/// A broken promise of [`BakedMesh`]: always a defect of this library.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum BakedMeshError {
    /// The tables of a part differ in length, or a triangle refers beyond them.
    #[error("{0:?}: tables of vertices and triangles do not fit")]
    BadTables(SurfaceId),
    /// A triangle has no area.
    #[error("{surface:?}: triangle {triangle} has no area")]
    Degenerate {
        /// The part's surface.
        surface: SurfaceId,
        /// Number of the triangle.
        triangle: usize,
    },
    /// A vertex has an irradiance that is negative, NaN or infinite.
    #[error("{surface:?}: vertex {vertex} has irradiance {irradiance:?}")]
    BadIrradiance {
        /// The part's surface.
        surface: SurfaceId,
        /// Number of the vertex.
        vertex: usize,
        /// Its irradiance.
        irradiance: [f32; 3],
    },
}

impl BakedMesh {
    /// Number of triangles of all parts.
    pub fn triangle_count(&self) -> usize {
        self.parts.iter().map(|part| part.triangles.len()).sum()
    }

    /// Number of vertices of all parts.
    pub fn vertex_count(&self) -> usize {
        self.parts.iter().map(|part| part.positions_m.len()).sum()
    }

    /// Checks what can be checked of the promises above part by part.
    ///
    /// # Errors
    /// The first broken promise.
    pub fn validate(&self) -> Result<(), BakedMeshError> {
        for part in &self.parts {
            let n = part.positions_m.len();
            let fits = part.normals.len() == n && part.irradiance.len() == n && [0, n].contains(&part.uvs.len());
            if !fits || part.triangles.iter().flatten().any(|&i| i as usize >= n) {
                return Err(BakedMeshError::BadTables(part.surface));
            }
            for (vertex, &irradiance) in part.irradiance.iter().enumerate() {
                if irradiance.iter().any(|e| !e.is_finite() || *e < 0.0) {
                    return Err(BakedMeshError::BadIrradiance { surface: part.surface, vertex, irradiance });
                }
            }
            for (triangle, corners) in part.triangles.iter().enumerate() {
                let [a, b, c] = corners.map(|i| DVec3::from(part.positions_m[i as usize].map(f64::from)));
                if (b - a).cross(c - a).length_squared() <= 0.0 {
                    return Err(BakedMeshError::Degenerate { surface: part.surface, triangle });
                }
            }
        }
        Ok(())
    }
}
