//! What is shown: triangles that follow the shadow boundaries, and the light of their vertices.

mod baked_mesh;

pub use baked_mesh::{BakedMesh, BakedMeshError, BakedPart};
