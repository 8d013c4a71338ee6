//! Polygonal emitters: touching coplanar faces of one radiance, and the outline of their union; or a convex part of
//! such faces.
//!
//! Events come from the outline of the whole emitter, never from the inner edges of its convex pieces. A part of faces
//! has an outline of its own: its corners and edges are numbered after those of the faces, and no face lies along them.
//! It lies a hair in front of its faces, which are plane but for the rounding of their vertices: so none of them hides
//! it.

use glam::DVec3;

use crate::geometry::{Plane, polygon};
use crate::id::{EdgeId, EmitterId, FaceId, Table, VertexId};
use crate::prepare::{DirectedEdge, Edge, Prepared};
use crate::scene::Rgb;

/// How far a part lies in front of its faces, in coplanar tolerances: their vertices are within one of the plane.
const IN_FRONT_OF_FACES: f64 = 2.0;

/// A polygonal light.
#[derive(Clone, Debug, PartialEq)]
pub struct Emitter {
    /// Its faces, ascending; those that it lies on if it is a part of them.
    pub faces: Vec<FaceId>,
    /// If it is a convex part of its faces: its corners, counter-clockwise seen from the front, in metres.
    pub part_m: Option<Vec<DVec3>>,
    /// Its plane, front towards where it shines.
    pub plane: Plane,
    /// Emitted radiance, in W/(m2 sr).
    pub radiance: Rgb,
    /// Area, in square metres.
    pub area_m2: f64,
    /// Centroid, in metres.
    pub centroid_m: DVec3,
    /// Edges of its outline, ascending.
    pub outline: Vec<EdgeId>,
    /// Vertices where the outline turns, ascending.
    pub corners: Vec<VertexId>,
}

impl Emitter {
    /// Mean of the radiance over the three colours, in W/(m2 sr).
    pub fn mean_radiance(&self) -> f64 {
        self.radiance.element_sum() / 3.0
    }

    /// A convex part of touching faces of one plane; `corners_m` are counter-clockwise seen from the front. Adds its
    /// corners and its outline to the vertices and edges.
    pub(super) fn of_part(prepared: &mut Prepared, faces: Vec<FaceId>, corners_m: &[DVec3], radiance: Rgb) -> Self {
        let plane = prepared.oriented_plane(faces[0]);
        let in_front_m = IN_FRONT_OF_FACES * prepared.tolerance.coplanar_m();
        let part_m: Vec<DVec3> = corners_m.iter().map(|&p| plane.project(p) + in_front_m * plane.normal).collect();
        let corners: Vec<VertexId> = part_m.iter().map(|&p| prepared.vertices_m.push_and_get_key(p)).collect();
        let outline = (0..corners.len()).map(|i| {
            let (from, to) = (corners[i], corners[(i + 1) % corners.len()]);
            prepared.edges.push_and_get_key(Edge { ends: [from.min(to), from.max(to)], faces: Default::default() })
        });
        Self {
            outline: outline.collect(),
            faces,
            plane,
            radiance,
            area_m2: polygon::area_m2(&part_m),
            centroid_m: polygon::centroid(&part_m),
            corners,
            part_m: Some(part_m),
        }
    }
}

/// Groups of touching faces that lie in one plane, look the same way and are alike, in the order of their first faces;
/// each ascends.
pub(crate) fn groups(prepared: &Prepared, alike: impl Fn(FaceId, FaceId) -> bool) -> Vec<Vec<FaceId>> {
    let mut groups = Vec::new();
    let mut taken: Table<FaceId, bool> = prepared.faces.iter().map(|_| false).collect();
    for first in prepared.faces.keys() {
        if taken[first] {
            continue;
        }
        let joins = |face: FaceId| {
            let (one, other) = (&prepared.faces[face], &prepared.faces[first]);
            one.plane == other.plane && one.facing == other.facing && alike(face, first)
        };
        let mut faces = vec![first];
        taken[first] = true;
        let mut next = 0;
        while let Some(&face) = faces.get(next) {
            for edge in prepared.faces[face].sides.iter().flatten() {
                for &neighbour in &prepared.edges[edge.edge].faces {
                    if !taken[neighbour] && joins(neighbour) {
                        taken[neighbour] = true;
                        faces.push(neighbour);
                    }
                }
            }
            next += 1;
        }
        faces.sort_unstable();
        groups.push(faces);
    }
    groups
}

/// The emitters among faces that have these radiances, in the order of their first faces.
pub(super) fn emitters(prepared: &Prepared, radiance: &Table<FaceId, Rgb>) -> Table<EmitterId, Emitter> {
    groups(prepared, |one, other| radiance[one] == radiance[other])
        .into_iter()
        .filter(|faces| radiance[faces[0]].max_element() > 0.0)
        .map(|faces| {
            let radiance = radiance[faces[0]];
            emitter_of(prepared, faces, radiance)
        })
        .collect()
}

fn emitter_of(prepared: &Prepared, faces: Vec<FaceId>, radiance: Rgb) -> Emitter {
    let mut outline: Vec<DirectedEdge> = faces
        .iter()
        .flat_map(|&face| prepared.faces[face].sides.iter().flatten().copied())
        .filter(|edge| {
            prepared.edges[edge.edge].faces.iter().filter(|face| faces.binary_search(face).is_ok()).count() == 1
        })
        .collect();
    outline.sort_unstable();
    let polygons: Vec<Vec<DVec3>> = faces.iter().map(|&face| prepared.polygon_m(face)).collect();
    let area_m2: f64 = polygons.iter().map(|corners| polygon::area_m2(corners)).sum();
    let moment: DVec3 = polygons.iter().map(|corners| polygon::area_m2(corners) * polygon::centroid(corners)).sum();
    Emitter {
        plane: prepared.oriented_plane(faces[0]),
        corners: corners_of(prepared, &outline),
        outline: outline.into_iter().map(|edge| edge.edge).collect(),
        faces,
        part_m: None,
        radiance,
        area_m2,
        centroid_m: moment / area_m2,
    }
}

/// The vertices at which an outline does not go straight on.
fn corners_of(prepared: &Prepared, outline: &[DirectedEdge]) -> Vec<VertexId> {
    let mut ends: Vec<(VertexId, DVec3)> = outline
        .iter()
        .flat_map(|&edge| {
            let (start, end) = (prepared.start(edge), prepared.end(edge));
            let along = (prepared.vertices_m[end] - prepared.vertices_m[start]).normalize_or_zero();
            [(start, along), (end, along)]
        })
        .collect();
    ends.sort_by_key(|end| end.0);
    ends.chunk_by(|p, q| p.0 == q.0)
        .filter(|directions| {
            // A sine below this is rounding of f32 vertices on an edge of a hundredth of the extent.
            const STRAIGHT_SINE: f64 = 1e-5;
            !(directions.len() == 2 && directions[0].1.cross(directions[1].1).length() < STRAIGHT_SINE)
        })
        .map(|directions| directions[0].0)
        .collect()
}
