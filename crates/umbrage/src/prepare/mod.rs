//! From the user's polygons to faces: convex, plane, one-sided, with shared vertices and shared edges.
//!
//! The steps, each in a file of its own:
//! 1. `weld`: a frame around the scene's centre; corners become shared points.
//! 2. `soup`: polygons without degenerate ones and duplicates, all of them plane.
//! 3. `orient`: polygons of closed shells look the way that most of their shell does.
//! 4. `coplanar`: every polygon gets its plane; what lies in one plane has one id.
//! 5. `skin`: texture coordinates and smooth normals, as functions of the position.
//! 6. `contact`: the segments along which polygons of different planes meet.
//! 7. `node`: all edges of all planes are cut until they meet in end points only.
//! 8. `arrangement`: the cells of each plane, and what each shows to either side.
//! 9. `needed`: only edges where something changes stay; so triangles become polygons again.
//! 10. `convex`: cells fall into few, well-shaped convex pieces.
//! 11. `twins`: of pieces of different planes with the same corners one is shown.
//! 12. `diagonal`: borders between pieces are cut where other planes' vertices touch them.
//! 13. `assemble`: pieces become faces, in an order that depends on the scene only.
//!
//! `draft` holds the result of steps 1 to 11; faces that turn out to be hidden are left out of it, and steps 9 to 13 are done again.
//! Beside them, `curved` tells of a point of a face how the smooth surface lies that the face stands for.

mod arrangement;
mod assemble;
mod contact;
mod convex;
mod coplanar;
mod crossing;
mod curved;
mod diagonal;
mod draft;
mod entangled;
mod error;
mod face;
mod merge;
mod near;
mod needed;
mod node;
mod orient;
mod parts;
mod pieces;
mod rim;
mod shell;
mod sides;
mod skin;
mod soup;
mod stages;
#[cfg(test)]
mod testing;
mod triangulation;
mod twins;
mod weld;

pub use draft::{Draft, FaceOrigins};
pub use error::PrepareError;
pub use face::{DirectedEdge, Edge, Face, Facing, PrepareReport, Prepared, PreparedError, Rim, Side};
pub use orient::orient;
pub(crate) use parts::convex_parts;
pub use shell::{Shells, shells};
pub use skin::Skin;
pub(crate) use skin::is_one_surface_at;
pub use stages::{PrepareSettings, draft, prepare, prepare_with};
