//! The sides of faces, joined to regions around edges.
//!
//! ```text
//!            one             Around an edge, the faces that end on it stand like the pages of a book. The side of a face
//!     region  | region       that looks to the next page, and the side of that one that looks back, bound one region.
//!        A    |   B          A face that no other meets has one region on both of its sides: one can go around it.
//!   other ----+---- third
//!        region C
//! ```
//!
//! Pages whose angles rounding cannot tell apart are joined all with all: that may make one region of two, and then less
//! is hidden than could be; never more.

use std::f64::consts::TAU;

use glam::DVec3;
use smallvec::SmallVec;

use crate::geometry::DisjointSets;
use crate::id::{EdgeId, FaceId, Table};
use crate::prepare::{DirectedEdge, Prepared};

/// Pages nearer in angle than this, in radians, may stand in either order: vertices are rounded by a ten-millionth of the
/// extent, and normals of small faces by a thousand times as much.
const SAME_ANGLE_RAD: f64 = 1e-4;

/// A region of space, by the least of its sides.
pub(super) type Region = usize;

/// The front and back of each face, and the outside of everything, in disjoint sets.
#[derive(Clone, Debug)]
pub(super) struct Sides {
    /// The two sides of each face, front and back by turns; at last the outside. The least of a set stands for it.
    sets: DisjointSets,
    count: usize,
    /// The face at the back of each, where a surface is double-sided.
    opposites: Table<FaceId, Option<FaceId>>,
}

/// A face at an edge.
#[derive(Clone, Copy, Debug)]
struct Page {
    angle_rad: f64,
    face: FaceId,
    /// Whether its front looks to where angles ascend.
    front_ascends: bool,
}

impl Page {
    /// The side that looks to where angles ascend, or the other.
    fn side(&self, ascends: bool) -> usize {
        if self.front_ascends == ascends { front(self.face) } else { back(self.face) }
    }
}

impl Sides {
    /// The sides that hang together around edges.
    pub(super) fn around_edges(prepared: &Prepared) -> Self {
        let count = 2 * prepared.faces.len() + 1;
        let opposites = prepared.faces.keys().map(|face| opposite(prepared, face)).collect();
        let mut sides = Self { sets: DisjointSets::new(count), count, opposites };
        for face in prepared.faces.keys() {
            if let Some(opposite) = sides.opposites[face] {
                sides.join(front(face), back(opposite));
            }
        }
        for edge in prepared.edges.keys() {
            sides.join_around(&pages(prepared, edge, &sides.opposites));
        }
        sides
    }

    /// Joins neighbours in angle; `pages` ascend.
    fn join_around(&mut self, pages: &[Page]) {
        for (page, next) in pages.iter().zip(pages.iter().cycle().skip(1)) {
            self.join(page.side(true), next.side(false));
            let between_rad = (next.angle_rad - page.angle_rad).rem_euclid(TAU);
            if pages.len() > 1 && between_rad.min(TAU - between_rad) < SAME_ANGLE_RAD {
                [page, next].into_iter().for_each(|one| self.join(one.side(true), one.side(false)));
                self.join(page.side(true), next.side(true));
            }
        }
    }

    /// The number of regions is less than this.
    pub(super) fn count(&self) -> usize {
        self.count
    }

    /// The region that a face looks into.
    pub(super) fn region_before(&mut self, face: FaceId) -> Region {
        self.region(front(face))
    }

    /// The region behind a face.
    pub(super) fn region_behind(&mut self, face: FaceId) -> Region {
        self.region(back(face))
    }

    /// The region that a side bounds.
    pub(super) fn region(&mut self, side: usize) -> Region {
        self.sets.first_of(side)
    }

    /// The region that has no end.
    pub(super) fn outside(&mut self) -> Region {
        self.region(self.count - 1)
    }

    /// Whether a face has another at its back.
    pub(super) fn has_opposite(&self, face: FaceId) -> bool {
        self.opposites[face].is_some()
    }

    /// Makes one region of two.
    pub(super) fn join(&mut self, one: usize, other: usize) {
        self.sets.join(one, other);
    }
}

/// The number of the front of a face.
pub(super) fn front(face: FaceId) -> usize {
    2 * face.index()
}

/// The number of the back of a face.
pub(super) fn back(face: FaceId) -> usize {
    2 * face.index() + 1
}

/// The face at the back of a face: the other side of one sheet.
fn opposite(prepared: &Prepared, face: FaceId) -> Option<FaceId> {
    let own = &prepared.faces[face];
    let edges_of = |face: FaceId| {
        let mut edges: SmallVec<[EdgeId; 8]> =
            prepared.faces[face].sides.iter().flatten().map(|directed| directed.edge).collect();
        edges.sort_unstable();
        edges
    };
    let edges = edges_of(face);
    let beside = &prepared.edges[*edges.first()?].faces;
    let mut facing = beside
        .iter()
        .copied()
        .filter(|&other| prepared.faces[other].plane == own.plane && prepared.faces[other].facing != own.facing);
    facing.find(|&other| edges_of(other) == edges)
}

/// The sheets at an edge, one of two faces back to back for each, in the order of their angles around it.
fn pages(prepared: &Prepared, edge: EdgeId, opposites: &Table<FaceId, Option<FaceId>>) -> SmallVec<[Page; 4]> {
    let [from, to] = prepared.edges[edge].ends.map(|vertex| prepared.vertices_m[vertex]);
    let along = (to - from).normalize_or_zero();
    let across = along.any_orthonormal_vector();
    let up = along.cross(across);
    let page = |&face: &FaceId| {
        let (normal, is_reversed) = (prepared.normal(face), passes_reversed(prepared, face, edge));
        let direction = if is_reversed { -along } else { along };
        let inward: DVec3 = normal.cross(direction);
        // Turning about the edge, a page moves to where `along x inward` points.
        let front_ascends = normal.dot(along.cross(inward)) > 0.0;
        Page { angle_rad: inward.dot(up).atan2(inward.dot(across)), face, front_ascends }
    };
    let mut pages: SmallVec<[Page; 4]> = prepared.edges[edge]
        .faces
        .iter()
        .filter(|&&face| opposites[face].is_none_or(|opposite| face < opposite))
        .map(page)
        .collect();
    pages.sort_by(|p, q| p.angle_rad.total_cmp(&q.angle_rad).then(p.face.cmp(&q.face)));
    pages
}

/// Whether a face's boundary passes an edge from its second end to its first.
fn passes_reversed(prepared: &Prepared, face: FaceId, edge: EdgeId) -> bool {
    prepared.faces[face].sides.iter().flatten().any(|&passed| passed == DirectedEdge { edge, reversed: true })
}
