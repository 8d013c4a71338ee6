//! Partition of a plane's cells into convex, well-shaped pieces (Hertel and Mehlhorn, 1983).
//!
//! A constrained Delaunay triangulation fills the cells; then diagonals are taken away as long as what they separated is
//! convex together. Hertel and Mehlhorn take any order and have at most four times the fewest pieces; here several
//! orders are tried, by how well shaped (`4 pi A / P^2`) a union is and by how much better than its parts, and each cell
//! keeps the one with the fewest pieces, then with the best shaped worst piece. Needed edges are never taken away. Both
//! facings of a cell share its pieces, so that diagonals never cross.
//!
//! Holds after: pieces are convex but for vertices that lie straight within the tolerance; they cover the cells.

use std::cmp::Ordering;
use std::collections::BinaryHeap;

use glam::{DVec2, DVec3};

use super::arrangement::Label;
use super::sides;
use super::triangulation::{Cells, Triangulation};
use crate::geometry::polygon;

/// A convex piece of a cell.
#[derive(Clone, Debug)]
pub(super) struct Piece {
    /// Numbers of all its boundary vertices, counter-clockwise in the frame.
    pub(super) boundary: Vec<u32>,
    /// Which of these are corners, ascending; the others lie straight between them.
    pub(super) corners: Vec<usize>,
    /// What its cell shows.
    pub(super) label: Label,
}

/// Which diagonal goes first.
#[derive(Clone, Copy, Debug)]
enum Order {
    /// The one whose union is best shaped.
    BestUnion,
    /// The one whose union is better shaped than its worse part by most.
    MostGain,
    /// The longest.
    Longest,
}

/// A partition is better shaped only by more than this: less is rounding.
const LEAST_GAIN: f64 = 1e-6;
/// All orders that are tried; of equal results the first counts.
const ORDERS: [Order; 3] = [Order::MostGain, Order::BestUnion, Order::Longest];

/// A diagonal that may go; the highest rank goes first.
#[derive(PartialEq)]
struct Candidate {
    rank: f64,
    half: usize,
    versions: [u32; 2],
}

impl Eq for Candidate {}

impl Ord for Candidate {
    fn cmp(&self, other: &Self) -> Ordering {
        self.rank.total_cmp(&other.rank).then(other.half.cmp(&self.half))
    }
}

impl PartialOrd for Candidate {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

/// Half-edges of the pieces: half-edge `3 t + i` starts as side `i` of triangle `t`.
struct Pieces<'a> {
    flat: &'a [DVec2],
    points: &'a [DVec3],
    straight_m: f64,
    start: Vec<u32>,
    next: Vec<usize>,
    previous: Vec<usize>,
    /// The other half of a diagonal; none for a needed edge.
    twin: Vec<Option<usize>>,
    gone: Vec<bool>,
    /// The piece of each half-edge: a triangle's number, by union-find.
    parent: Vec<usize>,
    area_m2: Vec<f64>,
    perimeter_m: Vec<f64>,
    version: Vec<u32>,
}

/// The convex pieces of all cells that show something. `beside` says what each edge has to its left and its right.
pub(super) fn pieces(
    flat: &[DVec2],
    points: &[DVec3],
    triangulation: &Triangulation,
    beside: &[[Label; 2]],
    straight_m: f64,
) -> Vec<Piece> {
    let cells = triangulation.cells();
    let labels = labels(triangulation, &cells, beside);
    let mut best: Vec<Option<Partition>> = vec![None; cells.count];
    for order in ORDERS {
        let mut pieces =
            Pieces::new(flat, points, triangulation, straight_m, |t| labels[cells.cell_of[t] as usize] != [None; 2]);
        pieces.merge(order);
        for (cell, found) in pieces.by_cell(&cells, &labels).into_iter().enumerate() {
            if best[cell].as_ref().is_none_or(|known| found.is_better_than(known)) {
                best[cell] = Some(found);
            }
        }
    }
    best.into_iter().flatten().flat_map(|partition| partition.pieces).collect()
}

/// The pieces of one cell.
#[derive(Clone, Debug, Default)]
struct Partition {
    pieces: Vec<Piece>,
    /// Compactness of the worst shaped piece.
    worst: f64,
}

impl Partition {
    fn is_better_than(&self, other: &Self) -> bool {
        let (n, m) = (self.pieces.len(), other.pieces.len());
        n < m || (n == m && self.worst > other.worst + LEAST_GAIN)
    }
}

/// What each cell shows: what some edge of it has on that side.
fn labels(triangulation: &Triangulation, cells: &Cells, beside: &[[Label; 2]]) -> Vec<Label> {
    let mut label_of: Vec<Option<Label>> = vec![None; cells.count];
    for (t, triangle) in triangulation.triangles.iter().enumerate() {
        for i in 0..3 {
            if let Some(edge) = triangle.edges[i] {
                let [from, to] = triangle.side(i);
                label_of[cells.cell_of[t] as usize].get_or_insert(beside[edge as usize][usize::from(from > to)]);
            }
        }
    }
    label_of.into_iter().map(Option::unwrap_or_default).collect()
}

impl<'a> Pieces<'a> {
    fn new(
        flat: &'a [DVec2],
        points: &'a [DVec3],
        triangulation: &Triangulation,
        straight_m: f64,
        shows: impl Fn(usize) -> bool,
    ) -> Self {
        let triangles = &triangulation.triangles;
        let n = triangles.len();
        let twin_of = |half: usize| {
            let (t, i) = (half / 3, half % 3);
            let neighbour = triangles[t].neighbours[i].filter(|_| triangles[t].edges[i].is_none() && shows(t))?;
            let [a, b] = triangles[t].side(i);
            (0..3).find(|&j| triangles[neighbour as usize].side(j) == [b, a]).map(|j| 3 * neighbour as usize + j)
        };
        let corners = |t: usize| triangles[t].corners.map(|c| flat[c as usize]);
        let perimeter_m = |[a, b, c]: [DVec2; 3]| a.distance(b) + b.distance(c) + c.distance(a);
        Self {
            flat,
            points,
            straight_m,
            start: triangles.iter().flat_map(|t| t.corners).collect(),
            next: (0..3 * n).map(|h| if h % 3 == 2 { h - 2 } else { h + 1 }).collect(),
            previous: (0..3 * n).map(|h| if h % 3 == 0 { h + 2 } else { h - 1 }).collect(),
            twin: (0..3 * n).map(twin_of).collect(),
            gone: vec![false; 3 * n],
            parent: (0..n).collect(),
            area_m2: (0..n).map(|t| polygon::signed_area_2d_m2(&corners(t))).collect(),
            perimeter_m: (0..n).map(|t| perimeter_m(corners(t))).collect(),
            version: vec![0; n],
        }
    }

    fn piece_of(&mut self, half: usize) -> usize {
        let mut i = half / 3;
        while self.parent[i] != i {
            self.parent[i] = self.parent[self.parent[i]];
            i = self.parent[i];
        }
        i
    }

    fn length_m(&self, half: usize) -> f64 {
        self.flat[self.start[half] as usize].distance(self.flat[self.start[self.next[half]] as usize])
    }

    /// All half-edges of a piece, in order.
    fn round(&self, half: usize) -> Vec<usize> {
        let mut round = vec![half];
        let mut at = self.next[half];
        while at != half {
            round.push(at);
            at = self.next[at];
        }
        round
    }

    fn corners(&self, boundary: &[u32]) -> Option<Vec<usize>> {
        let flat: Vec<DVec2> = boundary.iter().map(|&v| self.flat[v as usize]).collect();
        let points: Vec<DVec3> = boundary.iter().map(|&v| self.points[v as usize]).collect();
        sides::convex_corners(&flat, &points, self.straight_m)
    }

    fn candidate(&mut self, half: usize, order: Order) -> Option<Candidate> {
        let twin = self.twin[half]?;
        let half = half.min(twin);
        let (p, q) = (self.piece_of(half), self.piece_of(self.twin[half]?));
        let length_m = self.length_m(half);
        let perimeter_m = self.perimeter_m[p] + self.perimeter_m[q] - 2.0 * length_m;
        let union = polygon::compactness(self.area_m2[p] + self.area_m2[q], perimeter_m);
        let rank = match order {
            Order::BestUnion => union,
            Order::MostGain => union - self.compactness(p).min(self.compactness(q)),
            Order::Longest => length_m,
        };
        Some(Candidate { rank, half, versions: [self.version[p], self.version[q]] })
    }

    fn compactness(&self, piece: usize) -> f64 {
        polygon::compactness(self.area_m2[piece], self.perimeter_m[piece])
    }

    fn by_cell(&mut self, cells: &Cells, labels: &[Label]) -> Vec<Partition> {
        let mut partitions: Vec<Partition> = vec![Partition { pieces: Vec::new(), worst: 1.0 }; cells.count];
        let mut done = vec![false; self.start.len()];
        for half in 0..self.start.len() {
            let cell = cells.cell_of[half / 3] as usize;
            if done[half] || self.gone[half] || labels[cell] == [None; 2] {
                continue;
            }
            let round = self.round(half);
            round.iter().for_each(|&h| done[h] = true);
            let boundary: Vec<u32> = round.iter().map(|&h| self.start[h]).collect();
            let corners = self.corners(&boundary).unwrap_or_else(|| (0..boundary.len()).collect());
            let piece = self.piece_of(half);
            partitions[cell].worst = partitions[cell].worst.min(self.compactness(piece));
            partitions[cell].pieces.push(Piece { boundary, corners, label: labels[cell] });
        }
        partitions
    }

    fn merge(&mut self, order: Order) {
        let mut open = BinaryHeap::new();
        for half in 0..self.start.len() {
            if self.twin[half].is_some_and(|twin| half < twin) {
                open.extend(self.candidate(half, order));
            }
        }
        while let Some(Candidate { half, versions, .. }) = open.pop() {
            let Some(twin) = self.twin[half] else { continue };
            let (p, q) = (self.piece_of(half), self.piece_of(twin));
            if self.gone[half] || versions != [self.version[p], self.version[q]] {
                continue;
            }
            // Where it is not convex now, it never will be: pieces only grow.
            if p != q
                && self.turns_left(self.previous[half], self.next[twin])
                && self.turns_left(self.previous[twin], self.next[half])
                && self.is_union_convex(half, twin)
            {
                let grown = self.unite(half, twin, [p, q]);
                for at in self.round(grown) {
                    open.extend(self.candidate(at, order));
                }
            }
        }
    }

    /// Whether a boundary that arrives by one half-edge and goes on by another turns left, or is straight.
    fn turns_left(&self, arriving: usize, leaving: usize) -> bool {
        let [a, b, c] = [arriving, leaving, self.next[leaving]].map(|h| self.flat[self.start[h] as usize]);
        let turn = (b - a).perp_dot(c - b);
        turn > 0.0 || (-turn <= self.straight_m * a.distance(c) && (b - a).dot(c - b) > 0.0)
    }

    fn is_union_convex(&self, half: usize, twin: usize) -> bool {
        let without_last = |from: usize| self.round(from).into_iter().skip(1).map(|h| self.start[h]);
        let boundary: Vec<u32> = without_last(half).chain(without_last(twin)).collect();
        self.corners(&boundary).is_some()
    }

    /// Takes a diagonal away; returns a half-edge of the union.
    fn unite(&mut self, half: usize, twin: usize, [p, q]: [usize; 2]) -> usize {
        let (into, from) = (p.min(q), p.max(q));
        self.perimeter_m[into] += self.perimeter_m[from] - 2.0 * self.length_m(half);
        self.area_m2[into] += self.area_m2[from];
        self.version[into] += self.version[from] + 1;
        self.parent[from] = into;
        for (one, other) in [(half, twin), (twin, half)] {
            let (before, after) = (self.previous[one], self.next[other]);
            self.next[before] = after;
            self.previous[after] = before;
        }
        self.gone[half] = true;
        self.gone[twin] = true;
        self.next[twin]
    }
}
