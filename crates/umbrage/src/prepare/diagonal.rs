//! Diagonals are cut where another plane's vertex touches them.
//!
//! A vertex that touches a face in its inside, as the tip of a cone does, cuts nothing; but a diagonal of the partition
//! may happen to pass through it. The diagonal then becomes a side of two edges for the pieces on both sides of it.
//!
//! Holds after: no vertex lies inside an edge, diagonals included.

use std::collections::HashSet;

use rayon::prelude::*;
use rstar::RTree;

use super::assemble::PlacedPiece;
use super::near::{PlacedPoint, points_within};
use super::needed::NeededEdge;
use super::sides;
use super::weld::Points;
use crate::geometry::Tolerance;
use crate::id::{PlaneId, VertexId};

/// Cuts the diagonals of all pieces at the ends of needed edges that are not in their plane.
pub(super) fn cut(pieces: &mut [PlacedPiece], edges: &[NeededEdge], points: &Points, tolerance: &Tolerance) {
    let reach_m = sides::straight_m(tolerance);
    let needed: HashSet<[VertexId; 2]> = edges.iter().map(|e| e.ends).collect();
    let own: HashSet<(PlaneId, VertexId)> =
        edges.iter().flat_map(|e| e.uses.iter().flat_map(|u| e.ends.map(|v| (u.plane, v)))).collect();
    let mut vertices: Vec<VertexId> = edges.iter().flat_map(|e| e.ends).collect();
    vertices.sort_unstable();
    vertices.dedup();
    let tree: RTree<PlacedPoint> =
        RTree::bulk_load(vertices.iter().map(|&v| PlacedPoint::new(points[v].to_array(), v)).collect());
    pieces.par_iter_mut().for_each(|piece| {
        let n = piece.boundary.len();
        let mut stops: Vec<(usize, Vec<VertexId>)> = Vec::new();
        for i in 0..n {
            let ends = [piece.boundary[i], piece.boundary[(i + 1) % n]];
            if needed.contains(&ends) || needed.contains(&[ends[1], ends[0]]) {
                continue;
            }
            let mut found = points_within(&tree, ends.map(|v| points[v]), reach_m);
            found.retain(|&v| !own.contains(&(piece.plane, v)));
            if !found.is_empty() {
                stops.push((i, found));
            }
        }
        // From the last to the first, so that earlier places stay valid.
        for (i, found) in stops.into_iter().rev() {
            piece.corners.iter_mut().filter(|corner| **corner > i).for_each(|corner| *corner += found.len());
            piece.boundary.splice(i + 1..i + 1, found);
        }
    });
}
