//! Projection of occluders from a receiver point into the plane of a source, onto an integer grid.
//!
//! In a frame `u, v` of the source's plane with its origin at the foot of the receiver point, a point `Q` becomes the
//! homogeneous point `(x, y, w)` with `w = 1 - height(Q) / height(point)`: 1 in the source's plane, 0 at the height of
//! the receiver point, more than 1 behind the source. This is linear, so polygons are clipped before the division, by
//! `w <= 1` and by a window about the source; then `(x / w, y / w)` is the shadow.
//!
//! Holds: a point of space gives the same grid point in every face that has it as a corner, and an edge the same clipped
//! ends; borders of the window lie outside of the source. The grid is scaled by the source's box in each axis, so that a
//! long thin source is resolved across too.

use glam::{DVec2, DVec3};
use i_overlay::i_float::int::point::IntPoint;

use crate::geometry::{Plane, clip};

/// Grid steps from the middle of the source's box to its sides: 2^28 resolves 4e-9 of the source, and leaves the window
/// inside the range of exact arithmetic of the boolean engine, 2^30.
const GRID_HALF_STEPS: f64 = (1u32 << 28) as f64;
/// Half size of the window that occluders are clipped to, in half sizes of the source's box: borders must lie outside of
/// the source by far more than rounding.
const WINDOW_HALF_SIZE: f64 = 1.25;
/// Occluders nearer to the receiver point than this share of its height over the source are cut off: there the
/// projection loses all digits.
const NEAREST_W: f64 = 1e-9;
/// Corners of an occluder count as in the source's plane within the weld tolerance, but within no more than this share
/// of the receiver point's own height over it.
const IN_SOURCE_OF_HEIGHT: f64 = 0.125;

/// A polygon on the grid of a [`SourceView`].
pub(super) type GridPolygon = Vec<IntPoint<i32>>;

/// A source as it is seen from a receiver point.
#[derive(Debug)]
pub(super) struct SourceView {
    position_m: DVec3,
    horizon: Plane,
    source_plane: Plane,
    /// Distance of the receiver point from the source's plane.
    height_m: f64,
    /// Within this distance from the receiver's plane a corner counts as below it.
    on_receiver_m: f64,
    /// Within this distance from the source's plane a corner counts as in it.
    on_source_m: f64,
    u: DVec3,
    v: DVec3,
    middle_m: DVec2,
    half_size_m: DVec2,
    source: GridPolygon,
    /// Inward planes of the beam's sides, through the receiver point.
    beam_sides: Vec<DVec3>,
}

impl SourceView {
    /// The view of the convex polygon `above`, clipped to the horizon, in `source_plane`; `None` where nothing is left
    /// of it.
    pub(super) fn new(
        position_m: DVec3,
        horizon: Plane,
        source_plane: Plane,
        above: &[DVec3],
        weld_m: f64,
    ) -> Option<Self> {
        let height_m = source_plane.signed_distance_m(position_m);
        let sides = || (0..above.len()).map(|i| (above[i], above[(i + 1) % above.len()]));
        let longest = sides().map(|(p, q)| q - p).max_by(|s, t| s.length_squared().total_cmp(&t.length_squared()))?;
        let n = source_plane.normal;
        let u = (longest - longest.dot(n) * n).try_normalize()?;
        let v = n.cross(u);
        let flat = above.iter().map(|&p| DVec2::new((p - position_m).dot(u), (p - position_m).dot(v)));
        let lo = flat.clone().fold(DVec2::INFINITY, DVec2::min);
        let hi = flat.fold(DVec2::NEG_INFINITY, DVec2::max);
        let mut view = Self {
            position_m,
            horizon,
            source_plane,
            height_m,
            on_receiver_m: weld_m,
            on_source_m: weld_m.min(IN_SOURCE_OF_HEIGHT * height_m),
            u,
            v,
            middle_m: 0.5 * (lo + hi),
            half_size_m: 0.5 * (hi - lo),
            source: Vec::new(),
            beam_sides: sides().map(|(p, q)| (q - position_m).cross(p - position_m)).collect(),
        };
        if view.half_size_m.min_element() <= 0.0 {
            return None;
        }
        let source: GridPolygon =
            above.iter().map(|&p| view.to_grid(DVec2::new((p - position_m).dot(u), (p - position_m).dot(v)))).collect();
        view.source = source;
        (doubled_area(&view.source) > 0).then_some(view)
    }

    /// The source on the grid.
    pub(super) fn source(&self) -> &GridPolygon {
        &self.source
    }

    /// Whether a face in this box may take something of the source: false only where it cannot.
    pub(super) fn box_may_occlude(&self, min_m: DVec3, max_m: DVec3) -> bool {
        let (middle, half) = (0.5 * (min_m + max_m), 0.5 * (max_m - min_m));
        let over_receiver = self.horizon.signed_distance_m(middle) + self.horizon.normal.abs().dot(half);
        if over_receiver <= self.on_receiver_m {
            return false;
        }
        let (over_source, reach) =
            (self.source_plane.signed_distance_m(middle), self.source_plane.normal.abs().dot(half));
        if over_source + reach <= self.on_source_m || over_source - reach >= self.height_m {
            return false;
        }
        let from_point = middle - self.position_m;
        self.beam_sides.iter().all(|side| side.dot(from_point) + side.abs().dot(half) >= 0.0)
    }

    /// The shadow of a face on the grid, counter-clockwise; `None` where it has none in the window.
    pub(super) fn project(&self, boundary_m: &[DVec3]) -> Option<GridPolygon> {
        let mut above_receiver = false;
        let mut homogeneous: Vec<DVec3> = Vec::with_capacity(boundary_m.len() + 6);
        for &corner in boundary_m {
            let height = self.horizon.signed_distance_m(corner);
            let below = if height.abs() <= self.on_receiver_m { height + self.on_receiver_m } else { 0.0 };
            above_receiver |= height > self.on_receiver_m;
            homogeneous.push(self.homogeneous(corner - below * self.horizon.normal));
        }
        if !above_receiver || homogeneous.iter().all(|q| q.z >= 1.0) {
            return None;
        }
        let (lo, hi) =
            (self.middle_m - WINDOW_HALF_SIZE * self.half_size_m, self.middle_m + WINDOW_HALF_SIZE * self.half_size_m);
        let bounds: [&dyn Fn(DVec3) -> f64; 6] = [
            &|q| 1.0 - q.z,
            &|q| q.z - NEAREST_W,
            &|q| q.x - lo.x * q.z,
            &|q| hi.x * q.z - q.x,
            &|q| q.y - lo.y * q.z,
            &|q| hi.y * q.z - q.y,
        ];
        for height in bounds {
            if homogeneous.iter().any(|&q| height(q) < 0.0) {
                homogeneous = clip::where_positive(&homogeneous, height);
            }
        }
        let mut shadow: GridPolygon =
            homogeneous.iter().map(|q| self.to_grid(DVec2::new(q.x / q.z, q.y / q.z))).collect();
        match doubled_area(&shadow) {
            0 => None,
            area => {
                if area < 0 {
                    shadow.reverse();
                }
                Some(shadow)
            }
        }
    }

    /// The point of space at a grid point, in the source's plane.
    pub(super) fn to_3d(&self, p: IntPoint<i32>) -> DVec3 {
        let steps = DVec2::new(f64::from(p.x), f64::from(p.y)) / GRID_HALF_STEPS;
        let flat = self.middle_m + steps * self.half_size_m;
        self.position_m - self.height_m * self.source_plane.normal + flat.x * self.u + flat.y * self.v
    }

    fn homogeneous(&self, point: DVec3) -> DVec3 {
        let height = self.source_plane.signed_distance_m(point);
        let w = if height.abs() <= self.on_source_m { 1.0 } else { 1.0 - height / self.height_m };
        let d = point - self.position_m;
        DVec3::new(d.dot(self.u), d.dot(self.v), w)
    }

    fn to_grid(&self, flat: DVec2) -> IntPoint<i32> {
        let steps = ((flat - self.middle_m) / self.half_size_m * GRID_HALF_STEPS).round();
        IntPoint::new(steps.x as i32, steps.y as i32)
    }
}

/// Twice the signed area of a polygon on the grid, exactly.
pub(super) fn doubled_area(polygon: &[IntPoint<i32>]) -> i128 {
    let cross = |p: IntPoint<i32>, q: IntPoint<i32>| {
        i128::from(i64::from(p.x) * i64::from(q.y)) - i128::from(i64::from(p.y) * i64::from(q.x))
    };
    (0..polygon.len()).map(|i| cross(polygon[i], polygon[(i + 1) % polygon.len()])).sum()
}
