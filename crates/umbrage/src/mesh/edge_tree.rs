//! Edge trees: one edge is shared by all patches along it, and remembers how it was split.
//!
//! An edge is a leaf, or a split point with two child edges that keep its direction. A patch refers to the edges of the
//! time when it was made; what has been split since, by whichever neighbour, is found by descending to the leaves.
//! That is all there is to *point split-hints* (paper, section 3.1): nothing is stored, and nothing can be lost.

use crate::id::{EdgeId, Table, VertexId};
use crate::prepare::{DirectedEdge, Side};

/// An edge: a leaf, or a split into two.
#[derive(Clone, Copy, Debug, PartialEq)]
struct EdgeNode {
    ends: [VertexId; 2],
    /// From the first end to the split point, and on to the second end.
    halves: Option<[EdgeId; 2]>,
    /// The edge at the root of the tree.
    root: EdgeId,
    /// How many leaf patches lie along it whose triangles are counted ([`super::count`]).
    beside: u32,
}

/// All edge trees of a mesh.
#[derive(Clone, Debug, Default)]
pub struct EdgeTrees {
    edges: Table<EdgeId, EdgeNode>,
}

impl EdgeTrees {
    /// A new tree that is one leaf, along which nothing is counted yet.
    pub(super) fn push(&mut self, ends: [VertexId; 2]) -> EdgeId {
        let root = self.edges.next_key();
        self.edges.push_and_get_key(EdgeNode { ends, halves: None, root, beside: 0 })
    }

    /// How many leaf patches lie along an edge whose triangles are counted.
    pub(super) fn beside(&self, edge: EdgeId) -> usize {
        self.edges[edge].beside as usize
    }

    /// Counts so many more of them along an edge that is not split.
    pub(super) fn add_beside(&mut self, edge: EdgeId, count: u32) {
        self.edges[edge].beside += count;
    }

    /// Sets how many of them lie along each root, and so along all edges of its tree.
    pub(super) fn set_beside(&mut self, of_root: &Table<EdgeId, u32>) {
        self.edges.iter_mut().for_each(|edge| edge.beside = of_root[edge.root]);
    }

    /// Number of edges, split ones included.
    pub fn len(&self) -> usize {
        self.edges.len()
    }

    /// Whether there is no edge.
    pub fn is_empty(&self) -> bool {
        self.edges.is_empty()
    }

    /// Ends of an edge, in its own direction.
    pub fn ends(&self, edge: EdgeId) -> [VertexId; 2] {
        self.edges[edge].ends
    }

    /// The two halves of a split edge.
    pub fn halves(&self, edge: EdgeId) -> Option<[EdgeId; 2]> {
        self.edges[edge].halves
    }

    /// The edge at the root of an edge's tree: one of the prepared faces, or a chord.
    pub fn root(&self, edge: EdgeId) -> EdgeId {
        self.edges[edge].root
    }

    /// First vertex of a directed edge.
    pub fn start(&self, edge: DirectedEdge) -> VertexId {
        self.edges[edge.edge].ends[usize::from(edge.reversed)]
    }

    /// Last vertex of a directed edge.
    pub fn end(&self, edge: DirectedEdge) -> VertexId {
        self.start(edge.opposite())
    }

    /// The halves of a split directed edge, in the order of travel.
    pub fn directed_halves(&self, edge: DirectedEdge) -> Option<[DirectedEdge; 2]> {
        let [first, second] = self.edges[edge.edge].halves?;
        let directed = |half| DirectedEdge { edge: half, reversed: edge.reversed };
        Some(if edge.reversed { [directed(second), directed(first)] } else { [directed(first), directed(second)] })
    }

    /// Splits a leaf at `point`.
    pub(super) fn split(&mut self, leaf: EdgeId, point: VertexId) {
        assert!(self.edges[leaf].halves.is_none(), "{leaf:?} is already split");
        let EdgeNode { ends: [first, last], root, beside, .. } = self.edges[leaf];
        let halves = [[first, point], [point, last]]
            .map(|ends| self.edges.push_and_get_key(EdgeNode { ends, halves: None, root, beside }));
        self.edges[leaf].halves = Some(halves);
    }

    /// Appends the leaves of a directed edge, in the order of travel.
    pub fn leaves(&self, edge: DirectedEdge, leaves: &mut Vec<DirectedEdge>) {
        match self.directed_halves(edge) {
            None => leaves.push(edge),
            Some(halves) => halves.into_iter().for_each(|half| self.leaves(half, leaves)),
        }
    }

    /// Number of leaves of an edge.
    pub fn leaf_count(&self, edge: EdgeId) -> usize {
        self.edges[edge].halves.map_or(1, |halves| halves.into_iter().map(|half| self.leaf_count(half)).sum())
    }

    /// Cuts a side at `point`, a boundary point on it, into the runs before and after, each of as few edges as
    /// possible. At an end of the side one of them is empty.
    pub(super) fn cut_side(&self, side: &[DirectedEdge], point: VertexId) -> (Side, Side) {
        let (mut before, mut after) = (Side::new(), Side::new());
        let mut passed = side.first().is_some_and(|&e| self.start(e) == point);
        for &edge in side {
            if passed {
                after.push(edge);
            } else {
                passed = self.cut_edge(edge, point, &mut before, &mut after);
            }
        }
        assert!(passed, "{point:?} is not on the side {side:?}");
        (before, after)
    }

    /// Puts the part of `edge` before `point` into `before`, the rest into `after`; tells whether `point` was met.
    fn cut_edge(&self, edge: DirectedEdge, point: VertexId, before: &mut Side, after: &mut Side) -> bool {
        if self.end(edge) == point {
            before.push(edge);
            return true;
        }
        let Some([first, second]) = self.directed_halves(edge) else {
            before.push(edge);
            return false;
        };
        let kept = before.len();
        if self.cut_edge(first, point, before, after) {
            after.push(second);
            return true;
        }
        before.truncate(kept);
        before.push(first);
        let kept = before.len();
        if self.cut_edge(second, point, before, after) {
            return true;
        }
        before.truncate(kept - 1);
        before.push(edge);
        false
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn v(i: usize) -> VertexId {
        VertexId::from(i)
    }

    fn directed(edge: EdgeId, reversed: bool) -> DirectedEdge {
        DirectedEdge { edge, reversed }
    }

    /// Edge 0 - 4 with split points 2, then 1 and 3.
    fn quartered() -> (EdgeTrees, EdgeId) {
        let mut trees = EdgeTrees::default();
        let root = trees.push([v(0), v(4)]);
        trees.split(root, v(2));
        let [left, right] = trees.halves(root).unwrap();
        trees.split(left, v(1));
        trees.split(right, v(3));
        (trees, root)
    }

    fn points(trees: &EdgeTrees, run: &[DirectedEdge]) -> Vec<VertexId> {
        let mut leaves = Vec::new();
        run.iter().for_each(|&e| trees.leaves(e, &mut leaves));
        leaves.iter().map(|&e| trees.start(e)).chain(leaves.last().map(|&e| trees.end(e))).collect()
    }

    #[test]
    fn leaves_are_met_in_the_order_of_travel() {
        let (trees, root) = quartered();
        assert_eq!(points(&trees, &[directed(root, false)]), [0, 1, 2, 3, 4].map(v));
        assert_eq!(points(&trees, &[directed(root, true)]), [4, 3, 2, 1, 0].map(v));
    }

    #[test]
    fn a_side_is_cut_at_every_point_of_its_tree_into_few_edges() {
        let (trees, root) = quartered();
        for reversed in [false, true] {
            let side = [directed(root, reversed)];
            let all = points(&trees, &side);
            for (at, &point) in all.iter().enumerate() {
                let (before, after) = trees.cut_side(&side, point);
                assert_eq!(points(&trees, &before), if at == 0 { vec![] } else { all[..=at].to_vec() });
                assert_eq!(points(&trees, &after), if at == 4 { vec![] } else { all[at..].to_vec() });
                assert!(before.len() <= 2 && after.len() <= 2, "{before:?} {after:?}");
            }
        }
    }
}
