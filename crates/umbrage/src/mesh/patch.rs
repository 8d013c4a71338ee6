//! Patches: faces and the parts that they are split into; a tree with the face as root.
//!
//! Holds:
//! - a patch is convex; its boundary is a list of *sides*, straight runs of directed edges, counter-clockwise seen from
//!   the front;
//! - the *boundary points* are the ends of the leaves of those edges; one that the patch did not make is a point
//!   split-hint;
//! - the two subpatches of a split patch cover it exactly, and share the splitting edge.

use glam::DVec3;
use smallvec::SmallVec;

use super::EdgeHint;
use crate::id::{DSegmentId, FaceId, PatchId, VertexId};
use crate::prepare::{DirectedEdge, Side};

/// What split a patch.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Cut {
    /// `edge_split` along this d-segment.
    EdgeHint(DSegmentId),
    /// `point_split` between two boundary points.
    Points,
    /// `triangle_split` from the middle of the longest edge.
    Triangle,
}

/// A node of the patch tree.
#[derive(Clone, Debug)]
pub struct Patch {
    /// The face that it is part of.
    pub face: FaceId,
    /// The patch that it was split from.
    pub parent: Option<PatchId>,
    /// The two parts, once split.
    pub subpatches: Option<[PatchId; 2]>,
    /// What split it.
    pub cut: Option<Cut>,
    /// Area, in square metres.
    pub area_m2: f64,
    /// Centroid, in metres.
    pub centroid_m: DVec3,
    /// Boundary, as it was when the patch was made.
    pub(super) sides: SmallVec<[Side; 4]>,
    /// Edge split-hints inside, highest priority first.
    pub(super) edge_hints: Vec<EdgeHint>,
}

impl Patch {
    /// Edge split-hints that are still inside, highest priority first.
    pub fn edge_hints(&self) -> &[EdgeHint] {
        &self.edge_hints
    }
}

/// A boundary point of a patch.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct BoundaryPoint {
    /// The vertex.
    pub vertex: VertexId,
    /// The leaf edge from it to the next boundary point.
    pub leaf: DirectedEdge,
    /// The side that the leaf edge lies on.
    pub side: usize,
    /// Whether it is the first point of its side: it then also lies on the side before.
    pub corner: bool,
}

/// The one or two sides of `side_count` that a boundary point lies on.
pub(super) fn sides_of(point: &BoundaryPoint, side_count: usize) -> [usize; 2] {
    let before = if point.corner { (point.side + side_count - 1) % side_count } else { point.side };
    [before, point.side]
}

/// Whether two boundary points lie on one straight side: no chord may join them.
pub(super) fn on_one_side(first: &BoundaryPoint, second: &BoundaryPoint, side_count: usize) -> bool {
    let (of_first, of_second) = (sides_of(first, side_count), sides_of(second, side_count));
    of_first.iter().any(|side| of_second.contains(side))
}
