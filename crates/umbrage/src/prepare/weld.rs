//! The frame in which everything is measured, and the points in it that count as one.
//!
//! The frame's origin is the centre of the scene's bounding box, so that a scene far from the world's origin keeps its
//! full precision. A point is rounded to `f32` once, when it enters, and becomes the nearest known point nearer than
//! the weld distance, or a new one. Points never move: a chain of near points does not draw together, and which points
//! are one depends on the order of the input only.
//!
//! Holds: any two points are at least the weld distance apart; every point is an `f32` point.
//!
//! Points lie in a hash grid whose cells are twice the weld distance wide: a ball of that radius touches at most eight
//! cells, all of which are looked up, so that no border splits a pair.

use std::collections::HashMap;

use glam::{DVec3, I64Vec3};
use smallvec::SmallVec;

use super::PrepareError;
use crate::geometry::Tolerance;
use crate::id::{SurfaceId, Table, VertexId};
use crate::scene::Scene;

/// Below this extent (in metres) the rounding to `f32` near the origin is no longer a share of the extent.
const LEAST_EXTENT_M: f64 = 1e-15;
/// Above this extent (in metres) products of three lengths leave the range of `f32`, which later readers use.
const MOST_EXTENT_M: f64 = 1e12;

/// The frame of a scene.
#[derive(Clone, Copy, Debug)]
pub(super) struct Frame {
    /// Centre of the bounding box, an `f32` point.
    pub(super) origin_m: DVec3,
    /// Tolerances from the extent.
    pub(super) tolerance: Tolerance,
}

impl Frame {
    /// The frame of a valid scene.
    pub(super) fn of_scene(scene: &Scene) -> Result<Self, PrepareError> {
        let (mut low, mut high) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
        let mut farthest = (SurfaceId::from(0), 0);
        for (surface, s) in scene.surfaces.iter_enumerated() {
            for number in 0..s.polygons.len() {
                for p in scene.corners_m(surface, number) {
                    if !(p.cmpge(low).all() && p.cmple(high).all()) {
                        farthest = (surface, number);
                    }
                    (low, high) = (low.min(p), high.max(p));
                }
            }
        }
        let extent_m = (high - low).max_element();
        let origin_m = (low + 0.5 * (high - low)).as_vec3().as_dvec3();
        if extent_m > MOST_EXTENT_M || (extent_m > 0.0 && extent_m < LEAST_EXTENT_M) || !origin_m.is_finite() {
            return Err(PrepareError::Extent {
                place: scene.place(farthest.0, farthest.1),
                extent_m,
                least_m: LEAST_EXTENT_M,
                most_m: MOST_EXTENT_M,
            });
        }
        Ok(Self { origin_m, tolerance: Tolerance::new(extent_m) })
    }
}

/// Points at least the weld distance apart.
#[derive(Debug)]
pub(super) struct Points {
    positions_m: Table<VertexId, DVec3>,
    cells: HashMap<I64Vec3, SmallVec<[VertexId; 1]>>,
    weld_m: f64,
}

impl Points {
    /// No point yet.
    pub(super) fn new(weld_m: f64) -> Self {
        Self { positions_m: Table::new(), cells: HashMap::new(), weld_m }
    }

    /// The point that `p`, relative to the frame's origin, becomes.
    pub(super) fn weld(&mut self, p: DVec3) -> VertexId {
        let p = p.as_vec3().as_dvec3();
        if let Some(known) = self.nearest(p) {
            return known;
        }
        let new = self.positions_m.push_and_get_key(p);
        self.cells.entry(self.cell(p)).or_default().push(new);
        new
    }

    /// The nearest point nearer than the weld distance; of two at the same distance the older.
    fn nearest(&self, p: DVec3) -> Option<VertexId> {
        let low = self.cell(p - self.weld_m);
        let high = self.cell(p + self.weld_m);
        let mut best: Option<(f64, VertexId)> = None;
        for x in low.x..=high.x {
            for y in low.y..=high.y {
                for z in low.z..=high.z {
                    for &candidate in self.cells.get(&I64Vec3::new(x, y, z)).into_iter().flatten() {
                        let found = (self.positions_m[candidate].distance(p), candidate);
                        if found.0 < self.weld_m && best.is_none_or(|b| found < b) {
                            best = Some(found);
                        }
                    }
                }
            }
        }
        best.map(|(_, id)| id)
    }

    fn cell(&self, p: DVec3) -> I64Vec3 {
        (p / (2.0 * self.weld_m)).floor().as_i64vec3()
    }

    /// How many points there are.
    pub(super) fn len(&self) -> usize {
        self.positions_m.len()
    }
}

impl std::ops::Index<VertexId> for Points {
    type Output = DVec3;

    fn index(&self, id: VertexId) -> &DVec3 {
        &self.positions_m[id]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn a_cell_border_splits_no_pair() {
        let mut points = Points::new(1e-3);
        for i in -5..5 {
            let border = f64::from(i) * 2e-3;
            let below = points.weld(DVec3::new(border - 1e-4, 7.0, border - 1e-4));
            assert_eq!(points.weld(DVec3::new(border + 1e-4, 7.0, border + 1e-4)), below);
        }
        assert_eq!(points.len(), 10);
    }

    #[test]
    fn a_chain_of_near_points_does_not_draw_together() {
        let mut points = Points::new(1.0);
        let ids: Vec<_> = (0..10).map(|i| points.weld(DVec3::X * 0.6 * f64::from(i))).collect();
        assert_eq!(points.len(), 5);
        assert_ne!(ids[0], ids[9]);
    }

    proptest! {
        #[test]
        fn points_are_apart(ps in prop::collection::vec((0.0..4.0, 0.0..4.0, 0.0..1.0).prop_map(DVec3::from), 1..60)) {
            let mut points = Points::new(1.0);
            let ids: Vec<_> = ps.iter().map(|&p| points.weld(p)).collect();
            for (i, &a) in ids.iter().enumerate() {
                prop_assert!(points[a].distance(ps[i]) < 1.0 + 1e-6);
                for &b in &ids[..i] {
                    prop_assert!(a == b || points[a].distance(points[b]) >= 1.0);
                }
            }
        }
    }
}
