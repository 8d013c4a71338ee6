//! Patches, their edges and split-hints: the hierarchy that is cut but never gets a T-vertex (paper, sections 3 to 5).

mod bad_shape;
mod chain;
mod count;
mod edge_split;
mod edge_tree;
#[expect(clippy::module_inception, reason = "the module's main type is named like the module")]
mod mesh;
mod outline;
mod patch;
mod point_split;
#[cfg(test)]
mod sample;
mod score;
mod split;
mod split_hint;
mod triangle_split;

pub use edge_tree::EdgeTrees;
pub use mesh::{Mesh, MeshError, MeshSettings};
pub use patch::{BoundaryPoint, Cut, Patch};
pub use score::{ParseScoreError, SplitScore};
pub use split::Attempt;
pub use split_hint::EdgeHint;
