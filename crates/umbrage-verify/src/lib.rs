//! Checks baked light by path tracing.
//!
//! At random points on the surfaces that receive light, paths estimate the irradiance without bias, and the baked value
//! between the vertices of the triangle there is compared with it. The scene's own polygons are what rays meet: of the
//! baker this crate uses the description of a scene and nothing else, so that both cannot be wrong together.
//!
//! ```text
//! scene -> smooth (normals) -> sides (triangles) -> tracer (rays)  -> path (irradiance, with its noise) \
//!                                              -> points                                               verify -> report
//! baked triangles                              -> baked (value between vertices)                      /
//! ```
//!
//! Beside that it judges a bake as a whole ([`judge`]: T-vertices, energy, light, triangles) and makes [`random`] scenes to judge
//! by.
//!
//! Holds: the report depends on the seed and never on threads or time.

mod baked;
mod boxes;
pub mod conformity;
mod emitters;
pub mod judge;
mod lamps;
mod path;
mod points;
pub mod random;
mod report;
mod sides;
mod smooth;
mod stratified;
mod tracer;
mod verify;

pub use report::{CheckedPoint, Estimate, Report};
pub use verify::{BakedTriangle, Settings, VerifyError, verify};
