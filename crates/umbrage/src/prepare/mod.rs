//! From the user's polygons to faces: convex, plane, one-sided, with shared vertices and shared edges.

mod face;

pub use face::{DirectedEdge, Edge, Face, Facing, PrepareReport, Prepared, PreparedError, Side};
