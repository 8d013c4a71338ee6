//! What is shown: triangles that follow the shadow boundaries, and the light of their vertices.

mod assemble;
mod baked_mesh;
mod corner_group;

pub use assemble::assemble;
pub use baked_mesh::{BakedMesh, BakedMeshError, BakedPart};
