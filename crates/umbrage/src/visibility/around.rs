//! The faces around the facets of smooth surfaces.
//!
//! A point of a smooth surface sees its own facet and those around it from a place of its own ([`super::receiver`]). Around a facet are
//! the faces beyond its edges, and those that smooth edges lead to around its corners; of sheets both sides. What only touches a facet
//! somewhere inside is not. Where a facet is cut, by what touches it, the faces around all its pieces are around each.

use smallvec::SmallVec;

use crate::geometry::polygon;
use crate::id::{EdgeId, FaceId, SkinId, Table, VertexId};
use crate::prepare::{Prepared, is_one_surface_at};

/// Around a vertex no more facets than this are looked for (there may be more at the tip of a cone).
const MOST_AT_VERTEX: usize = 32;
/// A facet that is cut into more pieces than this is large: each of them has what is around itself.
const MOST_PIECES: usize = 32;

/// For the facets of smooth surfaces, themselves and the faces around them.
#[derive(Clone, Debug, Default)]
pub(super) struct Around {
    lists: Vec<Box<[FaceId]>>,
    /// Which list is that of a face; empty where no face is smooth.
    of_face: Table<FaceId, Option<u32>>,
}

impl Around {
    pub(super) fn new(prepared: &Prepared) -> Self {
        let mut pieces: Vec<(SkinId, FaceId)> = Vec::new();
        for (face, skin) in prepared.faces.iter_enumerated().filter_map(|(face, f)| Some((face, f.skin?))) {
            if prepared.is_smooth(face) {
                pieces.push((skin, face));
            }
        }
        let mut around = Self::default();
        if pieces.is_empty() {
            return around;
        }
        around.of_face = vec![None; prepared.faces.len()].into();
        pieces.sort_unstable();
        for facet in pieces.chunk_by(|one, other| one.0 == other.0) {
            let size = if facet.len() <= MOST_PIECES { facet.len() } else { 1 };
            for together in facet.chunks(size) {
                let mut near: Vec<FaceId> = Vec::new();
                for &(_, face) in together {
                    add_around(prepared, face, &mut near);
                    around.of_face[face] = Some(around.lists.len() as u32);
                }
                near.sort_unstable();
                near.dedup();
                around.lists.push(near.into());
            }
        }
        around
    }

    /// A facet and the faces around it, ascending; none for a flat face.
    pub(super) fn of(&self, face: FaceId) -> &[FaceId] {
        let list = self.of_face.get(face).copied().flatten();
        list.map_or(&[], |list| &self.lists[list as usize])
    }
}

/// Adds a face and what is around it, by a walk around each of its corners over edges where the surface goes on.
fn add_around(prepared: &Prepared, face: FaceId, near: &mut Vec<FaceId>) {
    near.push(face);
    for vertex in prepared.boundary(face) {
        let mut met: SmallVec<[FaceId; 16]> = SmallVec::new();
        met.push(face);
        let mut next = 0;
        while next < met.len() && met.len() <= MOST_AT_VERTEX {
            let here = met[next];
            next += 1;
            for edge in edges_at(prepared, here, vertex) {
                let beyond = beyond(prepared, edge, here);
                let goes_on = |other: FaceId| goes_on(prepared, vertex, [here, other]);
                for &other in beyond.iter().filter(|&&other| other != here) {
                    // Of a sheet whose front goes on, the back too.
                    let same_plane = |&twin: &FaceId| prepared.faces[twin].plane == prepared.faces[other].plane;
                    if is_behind(prepared, other, here) || beyond.iter().any(|twin| same_plane(twin) && goes_on(*twin))
                    {
                        near.push(other);
                    }
                    if !met.contains(&other) && goes_on(other) {
                        met.push(other);
                    }
                }
            }
        }
    }
}

/// The edges of a face that end at a vertex.
fn edges_at(prepared: &Prepared, face: FaceId, vertex: VertexId) -> impl Iterator<Item = EdgeId> + '_ {
    let edges = prepared.faces[face].sides.iter().flatten().map(|side| side.edge);
    edges.filter(move |&edge| prepared.edges[edge].ends.contains(&vertex))
}

/// The faces beyond an edge of a face; where its plane goes on beyond it, those of its plane alone.
fn beyond(prepared: &Prepared, edge: EdgeId, face: FaceId) -> SmallVec<[FaceId; 4]> {
    let (own, faces) = (&prepared.faces[face], &prepared.edges[edge].faces);
    let is_coplanar = |other: &FaceId| prepared.faces[*other].plane == own.plane;
    let goes_on = |other: &FaceId| *other != face && is_coplanar(other) && prepared.faces[*other].facing == own.facing;
    if faces.iter().any(goes_on) {
        faces.iter().copied().filter(|other| is_coplanar(other)).collect()
    } else {
        faces.clone()
    }
}

/// Whether a face that shares an edge with another does not stand in front of it.
fn is_behind(prepared: &Prepared, face: FaceId, of: FaceId) -> bool {
    let middle_m = polygon::centroid(&prepared.polygon_m(face));
    prepared.oriented_plane(of).signed_distance_m(middle_m) <= prepared.tolerance.weld_m()
}

/// Whether two faces are one smooth surface at a vertex.
fn goes_on(prepared: &Prepared, vertex: VertexId, faces: [FaceId; 2]) -> bool {
    let at_m = prepared.vertices_m[vertex];
    faces.iter().all(|&face| prepared.is_smooth(face))
        && is_one_surface_at(
            faces.map(|face| prepared.normal(face)),
            faces.map(|face| prepared.smooth_normal(face, at_m)),
        )
}
