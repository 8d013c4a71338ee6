//! Planes, plane frames, convex polygons, clipping and exact predicates. Lengths are metres, in `f64`.

pub mod clip;
pub mod convex;
pub(crate) mod disjoint_sets;
pub mod plane;
pub mod polygon;
pub mod predicate;
pub mod tolerance;

pub(crate) use disjoint_sets::DisjointSets;
pub use plane::{Plane, PlaneFrame};
pub use tolerance::Tolerance;
