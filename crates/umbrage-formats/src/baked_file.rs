//! A baked GLB, read back: what a picture, a viewer or a measurement needs of it.
//!
//! Holds, for every [`BakedFile`] that this crate returns:
//! - the vertex tables of a part have one length, and no triangle refers beyond them;
//! - all numbers are finite, `color` and `base_color` lie between 0 and 1;
//! - of a file that this crate wrote and nobody altered, positions and irradiance have the bits that were written.

use glam::DVec3;
use serde_json::{Map, Value};

/// One primitive of a baked file: the triangles of one surface.
#[derive(Clone, Debug, PartialEq)]
pub struct BakedFilePart {
    /// Name of the node that it hangs from; empty if it has none.
    pub node_name: String,
    /// Name of its mesh; empty if it has none.
    pub name: String,
    /// Name of its material; empty if it has none.
    pub material_name: String,
    /// Vertices in world space relative to the file's `origin_m`, in metres.
    pub positions_m: Vec<[f32; 3]>,
    /// Unit normal of each vertex, in world space.
    pub normals: Vec<[f32; 3]>,
    /// `COLOR_0`: linear RGB and alpha, 0 to 1; `clamp(k E / pi)` where the surface only reflects.
    pub color: Vec<[f32; 4]>,
    /// `baseColorFactor` of its material, linear RGB and alpha, 0 to 1. The colour shown is `base_color * color`.
    pub base_color: [f32; 4],
    /// `_IRRADIANCE`: irradiance on the front at each vertex, linear RGB, in W/m2.
    pub irradiance: Vec<[f32; 3]>,
    /// Triangles, counter-clockwise seen from the front.
    pub triangles: Vec<[u32; 3]>,
}

/// A baked GLB.
#[derive(Clone, Debug, PartialEq)]
pub struct BakedFile {
    /// Name of the scene; empty if it has none.
    pub name: String,
    /// What is added to a position to place it in the world, in metres.
    pub origin_m: DVec3,
    /// The primitives, in the order of the file's nodes.
    pub parts: Vec<BakedFilePart>,
    /// The exposure `k`, per W/(m2 sr): `COLOR_0 = clamp(k E / pi)`.
    pub exposure_k: f64,
    /// All that the bake left in `asset.extras.umbrage`.
    pub extras: Map<String, Value>,
}

impl BakedFile {
    /// Number of triangles of all parts.
    pub fn triangle_count(&self) -> usize {
        self.parts.iter().map(|part| part.triangles.len()).sum()
    }

    /// Number of vertices of all parts.
    pub fn vertex_count(&self) -> usize {
        self.parts.iter().map(|part| part.positions_m.len()).sum()
    }
}
