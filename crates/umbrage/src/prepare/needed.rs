//! Which edges are still needed when all planes are known, and which vertices on them.
//!
//! An edge is needed where a plane shows something else on its two sides, or where faces of two planes meet: a wall's
//! foot cuts the floor that goes on beneath it. What else divided a plane, like the triangles that it came in, is
//! merged.
//!
//! A vertex where just two needed edges meet, in all planes together and with the same on their sides, is dropped where
//! it lies straight between its neighbours.
//!
//! Holds after: every plane that shows a face beside an edge lists it; needed edges meet in end points only.

use std::collections::{BTreeMap, HashSet};

use glam::DVec3;
use smallvec::SmallVec;

use super::arrangement::Label;
use super::rim::RimWidth;
use super::sides;
use super::weld::Points;
use crate::geometry::Tolerance;
use crate::id::{PlaneId, VertexId};

/// What one plane shows beside an edge.
#[derive(Clone, Copy, Debug)]
pub(super) struct Use {
    /// The plane.
    pub(super) plane: PlaneId,
    /// What it shows to the left and to the right of the edge, from its first end to its second.
    pub(super) beside: [Label; 2],
    /// For each facing, how wide a rim is that continues what it shows into area that is hidden, if that begins here.
    pub(super) rims: [Option<RimWidth>; 2],
}

impl Use {
    /// What a plane shows beside an edge where nothing is hidden.
    pub(super) fn new(plane: PlaneId, beside: [Label; 2]) -> Self {
        Self { plane, beside, rims: [None; 2] }
    }

    /// Whether an edge with this use goes on in one with the other.
    fn continues(&self, other: &Self) -> bool {
        let has_rims = |rims: [Option<RimWidth>; 2]| rims.map(|rim| rim.is_some());
        self.plane == other.plane && self.beside == other.beside && has_rims(self.rims) == has_rims(other.rims)
    }
}

/// An edge that some face needs.
#[derive(Clone, Debug)]
pub(super) struct NeededEdge {
    /// Its ends; the order says what is left.
    pub(super) ends: [VertexId; 2],
    /// The planes with a face beside it, ascending.
    pub(super) uses: SmallVec<[Use; 2]>,
}

impl NeededEdge {
    /// Whether some face is bounded by it, given all planes that show something beside it.
    pub(super) fn is_needed(&self) -> bool {
        self.uses.len() > 1 || self.uses.iter().any(|u| u.beside[0] != u.beside[1])
    }

    /// Whether one plane's face ends on it and another's goes on.
    pub(super) fn is_contact(&self) -> bool {
        self.uses.len() > 1
            && self.uses.iter().any(|u| (0..2).any(|f| u.beside[0][f].is_some() && u.beside[1][f].is_some()))
    }

    fn reversed(&self) -> Self {
        let turned = |u: &Use| Use { beside: [u.beside[1], u.beside[0]], ..*u };
        Self { ends: [self.ends[1], self.ends[0]], uses: self.uses.iter().map(turned).collect() }
    }

    /// The same edge, starting at one of its ends.
    pub(super) fn starting_at(&self, start: VertexId) -> Self {
        if self.ends[0] == start { self.clone() } else { self.reversed() }
    }
}

/// Drops the vertices that lie straight between two edges.
pub(super) fn straighten(edges: &[NeededEdge], points: &Points, tolerance: &Tolerance) -> Vec<NeededEdge> {
    let mut at: BTreeMap<VertexId, SmallVec<[usize; 4]>> = BTreeMap::new();
    for (number, edge) in edges.iter().enumerate() {
        edge.ends.iter().for_each(|&v| at.entry(v).or_default().push(number));
    }
    let chains = Chains { edges, at, done: vec![false; edges.len()] }.all();
    let mut known: HashSet<[VertexId; 2]> = edges.iter().map(|e| sorted(e.ends)).collect();
    let mut straight = Vec::with_capacity(chains.len());
    for (chain, is_loop) in chains {
        let merged = merge(&chain, is_loop, points, tolerance);
        chain.iter().for_each(|e| {
            known.remove(&sorted(e.ends));
        });
        // Never onto another edge: two sides of a sliver stay two.
        let kept = if merged.iter().any(|e| known.contains(&sorted(e.ends))) { chain } else { merged };
        known.extend(kept.iter().map(|e| sorted(e.ends)));
        straight.extend(kept);
    }
    straight.sort_by_key(|e| sorted(e.ends));
    straight
}

fn sorted([a, b]: [VertexId; 2]) -> [VertexId; 2] {
    [a.min(b), a.max(b)]
}

/// The same chain between its corners.
fn merge(chain: &[NeededEdge], is_loop: bool, points: &Points, tolerance: &Tolerance) -> Vec<NeededEdge> {
    let Some(last) = chain.last() else { return Vec::new() };
    let mut vertices: Vec<VertexId> = chain.iter().map(|e| e.ends[0]).collect();
    vertices.push(last.ends[1]);
    let positions: Vec<DVec3> = vertices.iter().map(|&v| points[v]).collect();
    let straight_m = sides::straight_m(tolerance);
    let corners = if is_loop {
        let mut corners = sides::corners_of_loop(&positions[..chain.len()], straight_m);
        corners.push(corners[0]);
        corners
    } else {
        sides::corners_of_chain(&positions, straight_m)
    };
    if vertices[0] == last.ends[1] && corners.len() < 4 {
        return chain.to_vec();
    }
    let join = |w: &[usize]| {
        let mut uses = chain[w[0] % chain.len()].uses.clone();
        // The narrowest rim fits along all of them.
        let last = if w[1] > w[0] { w[1] } else { w[1] + chain.len() };
        for part in w[0] + 1..last {
            for (one, other) in uses.iter_mut().zip(&chain[part % chain.len()].uses) {
                one.rims = [0, 1].map(|facing| one.rims[facing].max(other.rims[facing]));
            }
        }
        NeededEdge { ends: [vertices[w[0]], vertices[w[1]]], uses }
    };
    corners.windows(2).map(join).collect()
}

/// Walks along edges from one vertex that stays to the next.
struct Chains<'a> {
    edges: &'a [NeededEdge],
    at: BTreeMap<VertexId, SmallVec<[usize; 4]>>,
    done: Vec<bool>,
}

impl Chains<'_> {
    /// All chains, and whether each is a loop without a vertex that stays.
    fn all(mut self) -> Vec<(Vec<NeededEdge>, bool)> {
        let mut chains = Vec::new();
        for number in 0..self.edges.len() {
            let starts = self.edges[number].ends.map(|v| self.passed(number, v).is_none().then_some(v));
            if let (false, Some(start)) = (self.done[number], starts[0].or(starts[1])) {
                chains.push((self.walk(number, start), false));
            }
        }
        // What is left are closed loops.
        for number in 0..self.edges.len() {
            if !self.done[number] {
                chains.push((self.walk(number, self.edges[number].ends[0]), true));
            }
        }
        chains
    }

    fn walk(&mut self, mut number: usize, mut from: VertexId) -> Vec<NeededEdge> {
        let mut chain = Vec::new();
        while !self.done[number] {
            self.done[number] = true;
            let edge = self.edges[number].starting_at(from);
            from = edge.ends[1];
            chain.push(edge);
            match self.passed(number, from) {
                Some(next) => number = next,
                None => break,
            }
        }
        chain
    }

    /// The one edge that goes on where `number` ends in `vertex`, with the same on its sides.
    fn passed(&self, number: usize, vertex: VertexId) -> Option<usize> {
        let here = &self.at[&vertex];
        let &[a, b] = here.as_slice() else { return None };
        let next = if a == number { b } else { a };
        let arriving = self.edges[number].starting_at(vertex).reversed();
        let leaving = self.edges[next].starting_at(vertex);
        let continues = arriving.uses.iter().zip(&leaving.uses).all(|(one, other)| one.continues(other));
        (continues && arriving.uses.len() == leaving.uses.len()).then_some(next)
    }
}

#[cfg(test)]
mod tests {
    use super::super::arrangement::Shown;
    use super::super::testing::TOLERANCE;
    use super::*;
    use crate::id::SurfaceId;

    fn edge(ends: [usize; 2], beside: [Label; 2]) -> NeededEdge {
        let one = Use::new(PlaneId::from(0), beside);
        NeededEdge { ends: ends.map(VertexId::from), uses: [one].into_iter().collect() }
    }

    fn points(at: &[[f64; 2]]) -> Points {
        let mut points = Points::new(TOLERANCE.weld_m());
        at.iter().for_each(|&[x, y]| {
            points.weld(DVec3::new(x, y, 0.0));
        });
        points
    }

    fn white() -> Label {
        [Some(Shown { surface: SurfaceId::from(0), skin: None }), None]
    }

    fn border() -> [Label; 2] {
        [white(), [None; 2]]
    }

    #[test]
    fn a_loop_keeps_its_corners_only() {
        // A square with two vertices on each side; the loop starts in the middle of one.
        let at: Vec<[f64; 2]> = (0..12)
            .map(|i| (i + 1) % 12)
            .map(|i| match i / 3 {
                0 => [f64::from(i), 0.0],
                1 => [3.0, f64::from(i - 3)],
                2 => [f64::from(9 - i), 3.0],
                _ => [0.0, f64::from(12 - i)],
            })
            .collect();
        let edges: Vec<_> = (0..12).map(|i| edge([i, (i + 1) % 12], border())).collect();
        assert_eq!(straighten(&edges, &points(&at), &TOLERANCE).len(), 4);
    }

    #[test]
    fn a_vertex_with_another_surface_beside_it_stays() {
        let at = points(&[[0.0, 0.0], [1.0, 0.0], [2.0, 0.0], [1.0, 1.0]]);
        let other = [[None, white()[0]], [None; 2]];
        let same = [edge([0, 1], border()), edge([2, 1], [border()[1], border()[0]])];
        assert_eq!(straighten(&same, &at, &TOLERANCE).len(), 1);
        let differs = [edge([0, 1], border()), edge([1, 2], other)];
        assert_eq!(straighten(&differs, &at, &TOLERANCE).len(), 2);
        let three = [edge([0, 1], border()), edge([1, 2], border()), edge([1, 3], border())];
        assert_eq!(straighten(&three, &at, &TOLERANCE).len(), 3);
    }

    #[test]
    fn an_edge_inside_a_surface_is_not_needed() {
        assert!(!edge([0, 1], [white(), white()]).is_needed());
        assert!(edge([0, 1], border()).is_needed());
        let mut contact = edge([0, 1], [white(), white()]);
        assert!(!contact.is_contact());
        contact.uses.push(Use::new(PlaneId::from(1), border()));
        assert!(contact.is_needed() && contact.is_contact());
    }
}
