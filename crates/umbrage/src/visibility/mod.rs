//! What sees what: one spatial index over the prepared faces, asked by ray, by beam (point to polygon) and by wedge.
//!
//! Exactness lives here (design: discontinuities only guide where the mesh is cut): a query answers what the faces
//! themselves do, with no sampling, so that an event that was missed elsewhere costs convergence and never a wrong
//! value.

mod around;
mod beam;
mod cluster;
mod first;
#[cfg(test)]
pub(crate) mod fixture;
mod half_spaces;
mod index;
mod lamps;
mod memory;
mod near;
mod pair;
mod ray;
mod receiver;
mod screen;
mod shadow;
mod shaft;
mod slim;
mod view;
mod wedge;

pub use beam::{Beam, Between, FlatSource, Seen, SourcePolygon};
pub use cluster::Cluster;
pub use first::FirstMet;
pub use index::Visibility;
pub use lamps::lamps;
pub use memory::{AtPoints, Memory, Notes};
pub use receiver::{BesideJump, NearView, ReceiverPoint};
pub use screen::Screens;
pub use shadow::Shadows;
pub use view::PlaneView;
