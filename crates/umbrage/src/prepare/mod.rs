//! From the user's polygons to faces: convex, plane, one-sided, with shared vertices and shared edges.
//!
//! The steps, each in a file of its own:
//! 1. `weld`: a frame around the scene's centre; corners become shared points.
//! 2. `soup`: polygons without degenerate ones and duplicates, all of them plane.
//! 3. `coplanar`: every polygon gets its plane; what lies in one plane has one id.
//! 4. `contact`: the segments along which polygons of different planes meet.
//! 5. `node`: all edges of all planes are cut until they meet in end points only.
//! 6. `arrangement`: the cells of each plane, and the surface that each shows to either side.
//! 7. `needed`: only edges where something changes stay; so triangles become polygons again.
//! 8. `convex`: cells fall into few, well-shaped convex pieces.
//! 9. `diagonal`: borders between pieces are cut where other planes' vertices touch them.
//! 10. `assemble`: pieces become faces, in an order that depends on the scene only.

mod arrangement;
mod assemble;
mod contact;
mod convex;
mod coplanar;
mod crossing;
mod diagonal;
mod error;
mod face;
mod merge;
mod near;
mod needed;
mod node;
mod shell;
mod sides;
mod soup;
mod stages;
#[cfg(test)]
mod testing;
mod triangulation;
mod weld;

pub use error::PrepareError;
pub use face::{DirectedEdge, Edge, Face, Facing, PrepareReport, Prepared, PreparedError, Side};
pub use shell::{Shells, shells};
pub use stages::{PrepareSettings, prepare, prepare_with};
