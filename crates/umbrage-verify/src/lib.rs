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
//! Holds: the report depends on the seed and never on threads or time.

mod baked;
mod emitters;
mod path;
mod points;
mod report;
mod sides;
mod smooth;
mod stratified;
mod tracer;
mod verify;

pub use report::{CheckedPoint, Estimate, Report};
pub use verify::{BakedTriangle, Settings, VerifyError, verify};
