//! Pieces become faces: with ids that depend on the scene only, shared edges, and sides that are straight runs.
//!
//! Faces are numbered by surface, then by position; planes, skins, vertices and edges in the order in which the faces
//! use them, so that what lies together has near numbers. Nothing unused is kept.

use std::collections::HashMap;

use glam::DVec3;
use smallvec::SmallVec;

use super::arrangement::{Label, Shown, side_of};
use super::coplanar::Planes;
use super::needed::NeededEdge;
use super::weld::{Frame, Points};
use super::{DirectedEdge, Edge, Face, Facing, PrepareReport, Prepared, Rim, Side, Skin};
use crate::geometry::{Plane, PlaneFrame, polygon};
use crate::id::{EdgeId, FaceId, PlaneId, SkinId, Table, VertexId};
use crate::scene::Scene;

/// A convex piece of a plane.
#[derive(Clone, Debug)]
pub(super) struct PlacedPiece {
    /// Its plane.
    pub(super) plane: PlaneId,
    /// All vertices of its boundary, counter-clockwise in the plane's frame.
    pub(super) boundary: Vec<VertexId>,
    /// Which of these are corners, ascending.
    pub(super) corners: Vec<usize>,
    /// What it shows along and against the plane's normal.
    pub(super) label: Label,
}

/// The piece that a face is one side of, and which.
pub(super) type Origin = (usize, Facing);

/// A face before it has a number.
struct Draft {
    origin: Origin,
    shown: Shown,
    centroid: DVec3,
    facing: Facing,
    plane: PlaneId,
    boundary: Vec<VertexId>,
    corners: Vec<usize>,
}

/// What faces are made of besides the pieces.
#[derive(Clone, Copy)]
pub(super) struct Parts<'a> {
    pub(super) scene: &'a Scene,
    pub(super) frame: &'a Frame,
    pub(super) planes: &'a Planes,
    pub(super) skins: &'a Table<SkinId, Skin>,
    pub(super) points: &'a Points,
}

/// Makes the prepared scene of all pieces of all planes, with rims along edges that have some; and says which side of
/// which piece each face is.
pub(super) fn assemble(
    Parts { scene, frame, planes, skins, points }: Parts<'_>,
    pieces: &[PlacedPiece],
    edges: &[NeededEdge],
    mut report: PrepareReport,
) -> (Prepared, Table<FaceId, Origin>) {
    let mut drafts = Vec::with_capacity(pieces.len());
    for (number, piece) in pieces.iter().enumerate() {
        for facing in [Facing::Along, Facing::Against] {
            if let Some(shown) = piece.label[side_of(facing)] {
                match draft(number, piece, facing, shown, planes, points) {
                    Some(draft) => drafts.push(draft),
                    None => report.dropped_cuts += 1,
                }
            }
        }
    }
    let order = |d: &Draft| (d.shown.surface, d.centroid, d.facing);
    drafts.sort_by(|p, q| {
        let ((s, c, f), (t, d, g)) = (order(p), order(q));
        let by_position = c.x.total_cmp(&d.x).then(c.y.total_cmp(&d.y)).then(c.z.total_cmp(&d.z));
        s.cmp(&t).then(by_position).then(f.cmp(&g)).then(p.boundary.cmp(&q.boundary))
    });
    let mut numbering = Numbering::default();
    let mut faces: Table<FaceId, Face> = Table::with_capacity(drafts.len());
    let mut origins: Table<FaceId, Origin> = Table::with_capacity(drafts.len());
    for draft in drafts {
        let id = faces.next_key();
        let plane = numbering.plane(&draft, planes, points, frame.tolerance.weld_m());
        let sides = numbering.sides(&draft, points, id);
        let Shown { surface, skin } = draft.shown;
        let skin = skin.map(|skin| numbering.skin(skin, skins));
        let material = scene.surfaces[surface].material;
        faces.push(Face { plane, facing: draft.facing, surface, material, skin, sides });
        origins.push(draft.origin);
    }
    let rims = numbering.rims(edges, frame.tolerance.extent_m, |face| {
        let (piece, facing) = origins[face];
        (pieces[piece].plane, facing)
    });
    let prepared = Prepared {
        origin_m: frame.origin_m,
        tolerance: frame.tolerance,
        planes: numbering.planes,
        skins: numbering.skins,
        vertices_m: numbering.vertices_m,
        edges: numbering.edges,
        faces,
        rims,
        report,
    };
    (prepared, origins)
}

/// A facing of a piece; `None` where rounding left it no area.
fn draft(
    number: usize,
    piece: &PlacedPiece,
    facing: Facing,
    shown: Shown,
    planes: &Planes,
    points: &Points,
) -> Option<Draft> {
    let (mut boundary, mut corners) = (piece.boundary.clone(), piece.corners.clone());
    let mut normal = planes.frames[piece.plane].plane.normal;
    if facing == Facing::Against {
        boundary.reverse();
        corners.reverse();
        corners.iter_mut().for_each(|i| *i = boundary.len() - 1 - *i);
        normal = -normal;
    }
    // The boundary starts at a corner, so that no side goes around its end.
    let first = *corners.first()?;
    boundary.rotate_left(first);
    corners.iter_mut().for_each(|i| *i -= first);
    let polygon_m: Vec<DVec3> = corners.iter().map(|&i| points[boundary[i]]).collect();
    let has_area = polygon::doubled_area_vector(&polygon_m).dot(normal) > 0.0;
    let centroid = polygon::centroid(&polygon_m);
    let origin = (number, facing);
    has_area.then_some(Draft { origin, shown, centroid, facing, plane: piece.plane, boundary, corners })
}

/// Numbers that are given on first use.
#[derive(Default)]
struct Numbering {
    planes: Table<PlaneId, PlaneFrame>,
    skins: Table<SkinId, Skin>,
    vertices_m: Table<VertexId, DVec3>,
    edges: Table<EdgeId, Edge>,
    plane_of: HashMap<PlaneId, PlaneId>,
    /// Planes of bent pieces, by the vertices of their boundaries, ascending: both sides of a piece lie in one plane.
    plane_of_bent: HashMap<Vec<VertexId>, PlaneId>,
    skin_of: HashMap<SkinId, SkinId>,
    vertex_of: HashMap<VertexId, VertexId>,
    edge_of: HashMap<[VertexId; 2], EdgeId>,
}

impl Numbering {
    /// The plane of a face: its polygons' or, where cuts have bent it away from that by more than the weld distance,
    /// one of its own.
    fn plane(&mut self, draft: &Draft, planes: &Planes, points: &Points, weld_m: f64) -> PlaneId {
        let known = planes.frames[draft.plane];
        let is_off = |&v: &VertexId| known.plane.signed_distance_m(points[v]).abs() > weld_m;
        if draft.boundary.iter().any(is_off) {
            let corners: Vec<DVec3> = draft.corners.iter().map(|&i| points[draft.boundary[i]]).collect();
            if let Some(own) = Plane::of_polygon(&corners) {
                let oriented = if draft.facing == Facing::Along { own } else { own.flipped() };
                let mut vertices = draft.boundary.clone();
                vertices.sort_unstable();
                let planes = &mut self.planes;
                let new = || planes.push_and_get_key(PlaneFrame::new(oriented, draft.centroid));
                return *self.plane_of_bent.entry(vertices).or_insert_with(new);
            }
        }
        *self.plane_of.entry(draft.plane).or_insert_with(|| self.planes.push_and_get_key(known))
    }

    fn skin(&mut self, known: SkinId, skins: &Table<SkinId, Skin>) -> SkinId {
        *self.skin_of.entry(known).or_insert_with(|| self.skins.push_and_get_key(skins[known].clone()))
    }

    fn vertex(&mut self, known: VertexId, points: &Points) -> VertexId {
        *self.vertex_of.entry(known).or_insert_with(|| self.vertices_m.push_and_get_key(points[known]))
    }

    /// The sides of a face, which its edges list from now on.
    fn sides(&mut self, draft: &Draft, points: &Points, face: FaceId) -> Vec<Side> {
        let n = draft.boundary.len();
        let mut sides = Vec::with_capacity(draft.corners.len());
        for (i, &from) in draft.corners.iter().enumerate() {
            let to = draft.corners.get(i + 1).copied().unwrap_or(n);
            let mut side: Side = SmallVec::new();
            for at in from..to {
                let start = self.vertex(draft.boundary[at], points);
                let end = self.vertex(draft.boundary[(at + 1) % n], points);
                side.push(self.edge(start, end, face));
            }
            sides.push(side);
        }
        sides
    }

    /// The rims along edges; `side_of_face` tells the plane, by its number before, and the facing of a face.
    fn rims(
        &self,
        edges: &[NeededEdge],
        extent_m: f64,
        side_of_face: impl Fn(FaceId) -> (PlaneId, Facing),
    ) -> Vec<Rim> {
        let mut rims = Vec::new();
        for edge in edges {
            let [a, b] = edge.ends.map(|end| self.vertex_of.get(&end));
            let (Some(&a), Some(&b)) = (a, b) else { continue };
            let Some(&id) = self.edge_of.get(&[a.min(b), a.max(b)]) else { continue };
            for used in &edge.uses {
                for facing in [Facing::Along, Facing::Against] {
                    let Some(width) = used.rims[side_of(facing)] else { continue };
                    let here = |face: &&FaceId| side_of_face(**face) == (used.plane, facing);
                    let width_m = width.width_m(extent_m);
                    rims.extend(self.edges[id].faces.iter().find(here).map(|&face| Rim { edge: id, face, width_m }));
                }
            }
        }
        rims.sort_by_key(|rim| (rim.edge, rim.face));
        rims
    }

    fn edge(&mut self, start: VertexId, end: VertexId, face: FaceId) -> DirectedEdge {
        let ends = [start.min(end), start.max(end)];
        let edge = *self
            .edge_of
            .entry(ends)
            .or_insert_with(|| self.edges.push_and_get_key(Edge { ends, faces: SmallVec::new() }));
        let faces = &mut self.edges[edge].faces;
        if faces.last() != Some(&face) {
            faces.push(face);
        }
        DirectedEdge { edge, reversed: start > end }
    }
}
