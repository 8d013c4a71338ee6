//! Half-edges of a triangulation's pieces, and the taking away of diagonals between them: the greedy part of `convex`.
//!
//! Holds throughout: the half-edges of a piece form one closed loop; a piece is convex but for vertices that lie
//! straight within the tolerance.

use std::cmp::Ordering;
use std::collections::BinaryHeap;

use glam::{DVec2, DVec3};

use super::sides;
use super::triangulation::Triangulation;
use crate::geometry::polygon;

/// No piece that is merged has more corners. Work on a patch grows with the square of its boundary points, and most
/// chords of a rounder one leave a sliver; the polygons that people draw by hand have fewer.
const MAX_CORNERS: usize = 16;

/// Which diagonal goes first.
#[derive(Clone, Copy, Debug)]
pub(super) enum Order {
    /// The one whose union is better shaped than its worse part by most.
    MostGain,
    /// The longest.
    Longest,
}

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
pub(super) struct Pieces<'a> {
    flat: &'a [DVec2],
    points: &'a [DVec3],
    straight_m: f64,
    /// First vertex.
    pub(super) start: Vec<u32>,
    next: Vec<usize>,
    previous: Vec<usize>,
    /// The other half of a diagonal; none for a needed edge.
    twin: Vec<Option<usize>>,
    /// Whether its diagonal was taken away.
    pub(super) gone: Vec<bool>,
    /// The piece of each half-edge: a triangle's number, by union-find.
    parent: Vec<usize>,
    area_m2: Vec<f64>,
    perimeter_m: Vec<f64>,
    version: Vec<u32>,
}

impl<'a> Pieces<'a> {
    /// A piece for each triangle; diagonals may go between those that `may_merge`.
    pub(super) fn new(
        flat: &'a [DVec2],
        points: &'a [DVec3],
        triangulation: &Triangulation,
        straight_m: f64,
        may_merge: impl Fn(usize) -> bool,
    ) -> Self {
        let triangles = &triangulation.triangles;
        let n = triangles.len();
        let twin_of = |half: usize| {
            let (t, i) = (half / 3, half % 3);
            let neighbour = triangles[t].neighbours[i]
                .filter(|&n| triangles[t].edges[i].is_none() && may_merge(t) && may_merge(n as usize))?;
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

    /// The piece of a half-edge.
    pub(super) fn piece_of(&mut self, half: usize) -> usize {
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
    pub(super) fn round(&self, half: usize) -> Vec<usize> {
        let mut round = vec![half];
        let mut at = self.next[half];
        while at != half {
            round.push(at);
            at = self.next[at];
        }
        round
    }

    /// The corners of a boundary, where it is convex.
    pub(super) fn corners(&self, boundary: &[u32]) -> Option<Vec<usize>> {
        let flat: Vec<DVec2> = boundary.iter().map(|&v| self.flat[v as usize]).collect();
        let points: Vec<DVec3> = boundary.iter().map(|&v| self.points[v as usize]).collect();
        sides::convex_corners(&flat, &points, self.straight_m)
    }

    fn candidate(&mut self, half: usize, order: Order) -> Option<Candidate> {
        let twin = self.twin[half]?;
        let half = half.min(twin);
        let (p, q) = (self.piece_of(half), self.piece_of(self.twin[half]?));
        let length_m = self.length_m(half);
        let rank = match order {
            Order::MostGain => {
                let perimeter_m = self.perimeter_m[p] + self.perimeter_m[q] - 2.0 * length_m;
                let union = polygon::compactness(self.area_m2[p] + self.area_m2[q], perimeter_m);
                union - self.compactness(p).min(self.compactness(q))
            }
            Order::Longest => length_m,
        };
        Some(Candidate { rank, half, versions: [self.version[p], self.version[q]] })
    }

    /// How well shaped a piece is.
    pub(super) fn compactness(&self, piece: usize) -> f64 {
        polygon::compactness(self.area_m2[piece], self.perimeter_m[piece])
    }

    /// Takes diagonals away, in an order, as long as pieces stay convex.
    pub(super) fn merge(&mut self, order: Order) {
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
            // Where it is not convex now, or has too many corners, it always will: pieces only grow.
            if p != q
                && self.turns_left(self.previous[half], self.next[twin])
                && self.turns_left(self.previous[twin], self.next[half])
                && self.may_be_one(half, twin)
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

    /// Whether the union across a diagonal is convex, with corners that are not too many.
    fn may_be_one(&self, half: usize, twin: usize) -> bool {
        let without_last = |from: usize| self.round(from).into_iter().skip(1).map(|h| self.start[h]);
        let boundary: Vec<u32> = without_last(half).chain(without_last(twin)).collect();
        self.corners(&boundary).is_some_and(|corners| corners.len() <= MAX_CORNERS)
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
