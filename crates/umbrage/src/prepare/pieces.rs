//! The convex pieces of all planes: each plane's needed edges, triangulated and merged ([`super::convex`]).

use glam::{DVec2, DVec3};
use rayon::prelude::*;
use smallvec::SmallVec;

use super::PrepareReport;
use super::arrangement;
use super::assemble::PlacedPiece;
use super::convex;
use super::coplanar::Planes;
use super::needed::{NeededEdge, Use};
use super::triangulation::Triangulation;
use super::weld::Points;
use crate::geometry::Tolerance;
use crate::id::{PlaneId, VertexId};
use crate::progress::Cancelled;

/// Partitions the cells of every plane.
pub(super) fn convex_pieces(
    edges: &[NeededEdge],
    planes: &Planes,
    points: &Points,
    tolerance: &Tolerance,
    report: &mut PrepareReport,
    pulse: impl Fn() -> Result<(), Cancelled> + Sync,
) -> Result<Vec<PlacedPiece>, Cancelled> {
    let mut uses: Vec<(PlaneId, [VertexId; 2], Use)> = Vec::new();
    for edge in edges {
        let ascending = edge.starting_at(edge.ends[0].min(edge.ends[1]));
        uses.extend(ascending.uses.iter().map(|&u| (u.plane, ascending.ends, u)));
    }
    uses.par_sort_by_key(|u| (u.0, u.1));
    let runs: Vec<_> = uses.chunk_by(|a, b| a.0 == b.0).collect();
    let partition = |run: &&[(PlaneId, [VertexId; 2], Use)]| {
        pulse()?;
        let plane = run[0].0;
        let (vertices, numbered) = arrangement::number(run.iter().map(|u| u.1));
        let flat: Vec<DVec2> = vertices.iter().map(|&v| planes.frames[plane].to_2d(points[v])).collect();
        let positions: Vec<DVec3> = vertices.iter().map(|&v| points[v]).collect();
        let beside: SmallVec<[_; 8]> = run.iter().map(|u| u.2.beside).collect();
        let triangulation = Triangulation::new(&flat, &numbered);
        let pieces = convex::pieces(&planes.frames[plane], &positions, &triangulation, &beside, tolerance);
        let place = |piece: convex::Piece| PlacedPiece {
            plane,
            boundary: piece.boundary.iter().map(|&i| vertices[i as usize]).collect(),
            corners: piece.corners,
            label: piece.label,
        };
        Ok((pieces.into_iter().map(place).collect::<Vec<_>>(), triangulation.missing_edges))
    };
    let found: Vec<(Vec<PlacedPiece>, usize)> = runs.par_iter().map(partition).collect::<Result<_, _>>()?;
    report.dropped_cuts += found.iter().map(|f| f.1).sum::<usize>();
    Ok(found.into_iter().flat_map(|f| f.0).collect())
}
