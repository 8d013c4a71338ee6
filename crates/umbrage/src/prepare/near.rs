//! A search of an R-tree for what lies near a segment: a long slanted one does not look through its whole box.

use glam::DVec3;
use rstar::primitives::GeomWithData;
use rstar::{AABB, RTree, SelectionFunction};

use super::sides::distance_to_segment_m;
use crate::id::VertexId;

/// A point in a tree.
pub(super) type PlacedPoint = GeomWithData<[f64; 3], VertexId>;

/// The points of a tree nearer than `reach_m` to the segment between two points, its ends included; in order along it.
pub(super) fn points_within(tree: &RTree<PlacedPoint>, [from, to]: [DVec3; 2], reach_m: f64) -> Vec<VertexId> {
    let mut found: Vec<(f64, VertexId)> = tree
        .locate_with_selection_function(NearSegment::new([from, to], reach_m))
        .map(|point| (DVec3::from(*point.geom()), point.data))
        .filter(|&(p, _)| distance_to_segment_m(p, from, to) < reach_m)
        .map(|(p, v)| ((p - from).dot(to - from), v))
        .collect();
    found.sort_by(|p, q| p.0.total_cmp(&q.0).then(p.1.cmp(&q.1)));
    found.into_iter().map(|(_, v)| v).collect()
}

/// Selects boxes that touch a segment thickened by a reach.
pub(super) struct NearSegment {
    from: DVec3,
    to: DVec3,
    reach_m: f64,
}

impl NearSegment {
    /// A search along the segment between two points.
    pub(super) fn new([from, to]: [DVec3; 2], reach_m: f64) -> Self {
        Self { from, to, reach_m }
    }

    /// Whether the segment passes through a box widened by the reach (Kay and Kajiya's slabs).
    fn passes(&self, range: &AABB<[f64; 3]>) -> bool {
        let (mut t_min, mut t_max) = (0.0_f64, 1.0_f64);
        for axis in 0..3 {
            let (from, to) = (self.from[axis], self.to[axis]);
            let (low, high) = (range.lower()[axis] - self.reach_m, range.upper()[axis] + self.reach_m);
            if from == to {
                if from < low || from > high {
                    return false;
                }
            } else {
                let (enter, leave) = ((low - from) / (to - from), (high - from) / (to - from));
                t_min = t_min.max(enter.min(leave));
                t_max = t_max.min(enter.max(leave));
            }
        }
        t_min <= t_max
    }
}

impl<T: rstar::RTreeObject<Envelope = AABB<[f64; 3]>>> SelectionFunction<T> for NearSegment {
    fn should_unpack_parent(&self, envelope: &AABB<[f64; 3]>) -> bool {
        self.passes(envelope)
    }

    fn should_unpack_leaf(&self, leaf: &T) -> bool {
        self.passes(&leaf.envelope())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_diagonal_finds_what_is_near_it_only() {
        let points: Vec<[f64; 3]> =
            (0..1000).map(|i| [f64::from(i % 10), f64::from(i / 10 % 10), f64::from(i / 100)]).collect();
        let tree = RTree::bulk_load(points);
        let near = NearSegment::new([DVec3::ZERO, DVec3::splat(9.0)], 0.1);
        let mut found: Vec<_> = tree.locate_with_selection_function(near).copied().collect();
        found.sort_by(|a, b| a[0].total_cmp(&b[0]));
        assert_eq!(found, (0..10).map(|i| [f64::from(i); 3]).collect::<Vec<_>>());
    }
}
