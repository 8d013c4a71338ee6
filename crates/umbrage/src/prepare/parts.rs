//! The convex parts of the union of faces, by its outline alone.
//!
//! The outline, every edge with one of the faces beside it, is triangulated and merged as the cells of a plane are ([`super::convex`]). What
//! divides the faces inside plays no part, so that tiles make one rectangle.

use glam::{DVec2, DVec3};

use super::arrangement::{self, Label, Shown};
use super::convex;
use super::face::Prepared;
use super::triangulation::Triangulation;
use crate::id::{FaceId, SurfaceId, VertexId};

/// Corners of convex parts of the union of faces, counter-clockwise seen from their front, in metres; `faces` ascend, lie in one plane, and
/// look the same way. `None` where rounding leaves an edge of the outline out.
pub(crate) fn convex_parts(prepared: &Prepared, faces: &[FaceId]) -> Option<Vec<Vec<DVec3>>> {
    let is_ours = |face: &&FaceId| faces.binary_search(face).is_ok();
    let outline: Vec<[VertexId; 2]> = faces
        .iter()
        .flat_map(|&face| prepared.faces[face].sides.iter().flatten())
        .filter(|side| prepared.edges[side.edge].faces.iter().filter(is_ours).count() == 1)
        .map(|&side| [prepared.start(side), prepared.end(side)])
        .collect();
    let frame = prepared.face_frame(*faces.first()?);
    let (vertices, numbered) = arrangement::number(outline.iter().copied());
    let points: Vec<DVec3> = vertices.iter().map(|&vertex| prepared.vertices_m[vertex]).collect();
    let flat: Vec<DVec2> = points.iter().map(|&point| frame.to_2d(point)).collect();
    let triangulation = Triangulation::new(&flat, &numbered);
    if triangulation.missing_edges > 0 {
        return None;
    }
    let inside: Label = [Some(Shown { surface: SurfaceId::from(0), skin: None }), None];
    // Faces run counter-clockwise: the inside is to the left of each edge as it runs.
    let beside: Vec<[Label; 2]> =
        numbered.iter().map(|[from, to]| if from < to { [inside, [None; 2]] } else { [[None; 2], inside] }).collect();
    let pieces = convex::pieces(&frame, &points, &triangulation, &beside, &prepared.tolerance);
    let corners = |piece: &convex::Piece| {
        piece.corners.iter().map(|&corner| points[piece.boundary[corner] as usize]).collect::<Vec<_>>()
    };
    Some(pieces.iter().map(corners).collect())
}
