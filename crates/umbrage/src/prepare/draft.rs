//! The pieces of all planes, before they become faces.
//!
//! Which faces are hidden is known when all of them can be asked what they see of each other. Then their pieces lose
//! what they show on that side, edges that divide nothing any more go, and the planes are divided anew: so what is
//! hidden leaves no cut behind in what is visible, but for rims ([`super::rim`]) along the edges between the two.

use std::collections::HashMap;

use glam::DVec2;

use super::arrangement::{Label, side_of};
use super::assemble::{self, Origin, Parts, PlacedPiece};
use super::coplanar::Planes;
use super::diagonal;
use super::needed::{self, NeededEdge, Use};
use super::pieces::convex_pieces;
use super::rim::RimWidth;
use super::soup::Polygon;
use super::twins;
use super::weld::{Frame, Points};
use super::{Facing, PrepareReport, Prepared, Skin};
use crate::id::{FaceId, PlaneId, SkinId, SurfaceId, Table, VertexId};
use crate::progress::Cancelled;
use crate::scene::Scene;

/// The planes of a scene, divided into convex pieces.
#[derive(Debug)]
pub struct Draft {
    pub(super) frame: Frame,
    pub(super) planes: Planes,
    pub(super) skins: Table<SkinId, Skin>,
    pub(super) points: Points,
    pub(super) edges: Vec<NeededEdge>,
    pub(super) pieces: Vec<PlacedPiece>,
    pub(super) fronts: Fronts,
    pub(super) report: PrepareReport,
}

/// Where faces come from.
#[derive(Clone, Debug)]
pub struct FaceOrigins {
    of_face: Table<FaceId, Origin>,
    /// Whether a face is the back of a double-sided surface: most of the polygons that it came from look the other way.
    pub is_reverse: Table<FaceId, bool>,
}

/// Each surface in each plane.
#[derive(Debug)]
pub(super) struct Fronts(HashMap<(PlaneId, SurfaceId), Front>);

/// A surface in a plane.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Front {
    /// How much of it looks along the plane's normal and against it, in square metres.
    ways_m2: [f64; 2],
    /// Whether it emits.
    pub(super) emits: bool,
}

impl Front {
    /// How large it is, both ways.
    pub(super) fn area_m2(&self) -> f64 {
        self.ways_m2.iter().sum()
    }
}

impl Fronts {
    pub(super) fn new(soup: &[Polygon], planes: &Planes) -> Self {
        let mut fronts: HashMap<(PlaneId, SurfaceId), Front> = HashMap::new();
        for (polygon, &(plane, facing)) in soup.iter().zip(&planes.of_polygon) {
            let front = fronts.entry((plane, polygon.surface)).or_default();
            front.ways_m2[side_of(facing)] += polygon.area_m2;
            front.emits = polygon.emits;
        }
        Self(fronts)
    }

    /// A surface in a plane; nothing where it has no polygon there.
    pub(super) fn of(&self, plane: PlaneId, surface: SurfaceId) -> Front {
        self.0.get(&(plane, surface)).copied().unwrap_or_default()
    }

    fn is_reverse(&self, plane: PlaneId, surface: SurfaceId, facing: Facing) -> bool {
        let here = side_of(facing);
        let Front { ways_m2, .. } = self.of(plane, surface);
        ways_m2[here] < ways_m2[1 - here]
    }
}

impl Draft {
    /// Makes faces of all sides that the pieces show.
    pub fn faces(&self, scene: &Scene) -> (Prepared, FaceOrigins) {
        let Self { frame, planes, skins, points, edges, .. } = self;
        let mut pieces = self.pieces.clone();
        diagonal::cut(&mut pieces, edges, points, &frame.tolerance);
        let contact_edges = edges.iter().filter(|edge| edge.is_contact()).count();
        let report = PrepareReport { contact_edges, ..self.report.clone() };
        let (prepared, of_face) =
            assemble::assemble(Parts { scene, frame, planes, skins, points }, &pieces, edges, report);
        let is_reverse = prepared.faces.iter_enumerated().map(|(id, face)| {
            let (piece, facing) = of_face[id];
            self.fronts.is_reverse(pieces[piece].plane, face.surface, facing)
        });
        let is_reverse = is_reverse.collect();
        (prepared, FaceOrigins { of_face, is_reverse })
    }

    /// Leaves faces out.
    ///
    /// # Errors
    /// [`Cancelled`] where `pulse` asks to stop.
    pub fn without(
        mut self,
        hidden: &Table<FaceId, bool>,
        origins: &FaceOrigins,
        pulse: impl Fn() -> Result<(), Cancelled> + Sync,
    ) -> Result<Self, Cancelled> {
        let mut is_hidden = vec![[false; 2]; self.pieces.len()];
        for (&(piece, facing), _) in origins.of_face.iter().zip(hidden).filter(|(_, hidden)| **hidden) {
            is_hidden[piece][side_of(facing)] = true;
        }
        let uncovered = Uncovered::new(&self, &is_hidden);
        let edges: Vec<NeededEdge> = self.edges.iter().filter_map(|edge| uncovered.edge(edge)).collect();
        self.edges = needed::straighten(&edges, &self.points, &self.frame.tolerance);
        // Cuts that rounding left no room for were counted before.
        let mut counted = PrepareReport::default();
        self.pieces =
            convex_pieces(&self.edges, &self.planes, &self.points, &self.frame.tolerance, &mut counted, pulse)?;
        twins::take_away(&mut self.pieces, &self.planes, &self.fronts);
        Ok(self)
    }
}

/// What edges are like where some sides of pieces are hidden.
struct Uncovered<'a> {
    draft: &'a Draft,
    is_hidden: &'a [[bool; 2]],
    /// The piece to the left of each edge of its boundary, in its plane.
    left_of: HashMap<(PlaneId, [VertexId; 2]), usize>,
}

impl<'a> Uncovered<'a> {
    fn new(draft: &'a Draft, is_hidden: &'a [[bool; 2]]) -> Self {
        let mut left_of = HashMap::new();
        for (number, piece) in draft.pieces.iter().enumerate() {
            let next = piece.boundary.iter().cycle().skip(1);
            left_of.extend(piece.boundary.iter().zip(next).map(|(&a, &b)| ((piece.plane, [a, b]), number)));
        }
        Self { draft, is_hidden, left_of }
    }

    /// The edge, if it is still needed.
    fn edge(&self, edge: &NeededEdge) -> Option<NeededEdge> {
        let uses = edge.uses.iter().map(|used| self.used(used, edge.ends));
        let uses = uses.filter(|used| used.beside != [[None; 2]; 2]).collect();
        Some(NeededEdge { ends: edge.ends, uses }).filter(NeededEdge::is_needed)
    }

    fn used(&self, used: &Use, [from, to]: [VertexId; 2]) -> Use {
        let directions = [[from, to], [to, from]];
        let pieces = directions.map(|ends| self.left_of.get(&(used.plane, ends)).copied());
        let hides = |side: usize, facing: usize| pieces[side].is_some_and(|piece| self.is_hidden[piece][facing]);
        let label =
            |side: usize| -> Label { [0, 1].map(|facing| used.beside[side][facing].filter(|_| !hides(side, facing))) };
        let beside = [label(0), label(1)];
        let rims = [0, 1].map(|facing| {
            let side = (0..2).find(|&side| hides(side, facing) && beside[1 - side][facing].is_some())?;
            self.rim(directions[side], pieces[side]?)
        });
        Use { beside, rims, ..*used }
    }

    /// The rim inside a hidden piece along one of its edges.
    fn rim(&self, ends: [VertexId; 2], piece: usize) -> Option<RimWidth> {
        let (piece, points) = (&self.draft.pieces[piece], &self.draft.points);
        let flat = |v: VertexId| self.draft.planes.frames[piece.plane].to_2d(points[v]);
        let corners: Vec<DVec2> = piece.corners.iter().map(|&i| flat(piece.boundary[i])).collect();
        RimWidth::along(ends.map(flat), &corners, self.draft.frame.tolerance.extent_m)
    }
}
