//! What is shown: triangles that follow the shadow boundaries, and the light of their vertices.

mod assemble;
mod baked_mesh;
mod corner_group;
mod irradiance;

pub use assemble::assemble;
pub use baked_mesh::{BakedMesh, BakedMeshError, BakedPart};
pub use irradiance::Irradiance;
