//! From triangles and lines in the world to triangles and lines on the grid of samples.
//!
//! Idea: clip in view space, project, snap to a grid of 1/256 sample, and from there on count in integers, so that two
//! triangles with a common edge agree exactly on which side of it a sample lies ([`crate::fill`]).
//!
//! - Clipping is against the near plane and a guard band of [`GUARD`] frames: what only leaves the frame is not cut.
//!   A cut of an edge is computed from the edge's ends in one fixed order, so both its triangles get the same point.
//! - What is linear on the screen is interpolated: 1/z, colour/z and uv/z.
//!
//! Holds: snapped coordinates lie within `GUARD` frames, so products of two differences fit an `i64` easily.

use glam::{DVec2, DVec3};

use crate::camera::Lens;
use crate::color::LinearRgb;

/// Steps of the snapping grid per sample.
pub(crate) const SNAP: i64 = 256;
/// The half width, in half frames, beyond which triangles are cut.
const GUARD: f64 = 2.0;

/// A vertex in view space.
#[derive(Clone, Copy, Debug, PartialEq)]
struct ViewVertex {
    view_m: DVec3,
    color: LinearRgb,
    uv: [f32; 2],
}

/// A corner on the grid.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Corner {
    /// Steps to the right from the picture's left edge.
    pub(crate) x: i64,
    /// Steps down from its upper edge.
    pub(crate) y: i64,
    /// 1/z, per metre.
    pub(crate) inverse_depth: f64,
    /// Colour times 1/z.
    pub(crate) color_over_depth: [f64; 3],
    /// Place in the texture times 1/z.
    pub(crate) uv_over_depth: [f64; 2],
}

/// A triangle on the grid: it runs counter-clockwise, as one sees the screen, where it shows its front.
pub(crate) type ScreenTriangle = [Corner; 3];

/// A straight line on the screen.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct ScreenLine {
    /// Its ends, in samples.
    pub(crate) ends: [DVec2; 2],
    /// 1/z of its ends, per metre.
    pub(crate) inverse_depth: [f64; 2],
}

/// The part of space that is drawn.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Frustum {
    lens: Lens,
    near_m: f64,
    /// Greatest abs(x) / z and abs(y) / z.
    slope: DVec2,
}

impl Frustum {
    /// What `lens` sees beyond `near_m`.
    pub(crate) fn new(lens: Lens, near_m: f64) -> Self {
        Self { lens, near_m, slope: GUARD * lens.centre / lens.focal }
    }

    /// How far a point of view space is inside the five planes, each positive inside.
    fn depths(&self, p: DVec3) -> [f64; 5] {
        let (x, y) = (self.slope.x * p.z, self.slope.y * p.z);
        [p.z - self.near_m, x + p.x, x - p.x, y + p.y, y - p.y]
    }

    /// The parts of a triangle that can be seen, on the grid.
    pub(crate) fn triangle(
        &self,
        corners_m: [DVec3; 3],
        colors: [LinearRgb; 3],
        uvs: [[f32; 2]; 3],
    ) -> Vec<ScreenTriangle> {
        let vertex = |i: usize| ViewVertex { view_m: self.lens.view_m(corners_m[i]), color: colors[i], uv: uvs[i] };
        let mut polygon = vec![vertex(0), vertex(1), vertex(2)];
        let depths = [0, 1, 2].map(|i| self.depths(polygon[i].view_m));
        for plane in 0..5 {
            if depths.iter().all(|d| d[plane] < 0.0) {
                return Vec::new();
            }
            if depths.iter().any(|d| d[plane] < 0.0) {
                polygon = self.clip(&polygon, plane);
            }
        }
        let corners: Vec<Corner> = polygon.iter().map(|v| self.corner(v)).collect();
        (2..corners.len()).map(|i| [corners[0], corners[i - 1], corners[i]]).collect()
    }

    /// Cuts a convex polygon at a plane (Sutherland and Hodgman).
    fn clip(&self, polygon: &[ViewVertex], plane: usize) -> Vec<ViewVertex> {
        let mut inside = Vec::with_capacity(polygon.len() + 1);
        for (i, &a) in polygon.iter().enumerate() {
            let b = polygon[(i + 1) % polygon.len()];
            let (da, db) = (self.depths(a.view_m)[plane], self.depths(b.view_m)[plane]);
            if da >= 0.0 {
                inside.push(a);
            }
            if (da >= 0.0) != (db >= 0.0) {
                inside.push(if ordered(a.view_m, b.view_m) { cut(a, b, da, db) } else { cut(b, a, db, da) });
            }
        }
        inside
    }

    fn corner(&self, vertex: &ViewVertex) -> Corner {
        let p = (self.lens.project(vertex.view_m) * SNAP as f64).round();
        let inverse_depth = 1.0 / vertex.view_m.z;
        let color_over_depth = vertex.color.map(|c| f64::from(c) * inverse_depth);
        let uv_over_depth = vertex.uv.map(|x| f64::from(x) * inverse_depth);
        Corner { x: p.x as i64, y: p.y as i64, inverse_depth, color_over_depth, uv_over_depth }
    }

    /// The part of a line that can be seen.
    pub(crate) fn line(&self, ends_m: [DVec3; 2]) -> Option<ScreenLine> {
        let mut ends = ends_m.map(|p| self.lens.view_m(p));
        for plane in 0..5 {
            let [d0, d1] = ends.map(|p| self.depths(p)[plane]);
            match (d0 >= 0.0, d1 >= 0.0) {
                (true, true) => {}
                (false, false) => return None,
                (true, false) => ends[1] = ends[0].lerp(ends[1], d0 / (d0 - d1)),
                (false, true) => ends[0] = ends[1].lerp(ends[0], d1 / (d1 - d0)),
            }
        }
        Some(ScreenLine { ends: ends.map(|p| self.lens.project(p)), inverse_depth: ends.map(|p| 1.0 / p.z) })
    }
}

/// An order of points that does not depend on the triangle that asks.
fn ordered(a: DVec3, b: DVec3) -> bool {
    a.x.total_cmp(&b.x).then(a.y.total_cmp(&b.y)).then(a.z.total_cmp(&b.z)).is_le()
}

/// Where the edge from `a` to `b` crosses the plane that is `da` and `db` away from them.
fn cut(a: ViewVertex, b: ViewVertex, da: f64, db: f64) -> ViewVertex {
    let t = da / (da - db);
    let color = std::array::from_fn(|i| a.color[i] + t as f32 * (b.color[i] - a.color[i]));
    let uv = std::array::from_fn(|i| a.uv[i] + t as f32 * (b.uv[i] - a.uv[i]));
    ViewVertex { view_m: a.view_m.lerp(b.view_m, t), color, uv }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::camera::Camera;

    const NO_UVS: [[f32; 2]; 3] = [[0.0; 2]; 3];

    fn frustum() -> Frustum {
        let camera = Camera::looking(DVec3::ZERO, DVec3::NEG_Z, 90.0);
        Frustum::new(camera.lens(100.0, 100.0).unwrap(), 0.5)
    }

    #[test]
    fn a_triangle_that_leaves_the_frame_a_little_is_not_cut() {
        let corners = [DVec3::new(-1.5, 0.0, -1.0), DVec3::new(1.5, 0.0, -1.0), DVec3::new(0.0, 1.0, -1.0)];
        assert_eq!(frustum().triangle(corners, [[1.0; 3]; 3], NO_UVS).len(), 1);
    }

    #[test]
    fn a_floor_under_the_eye_is_cut_at_the_near_plane_on_both_sides_of_an_edge_alike() {
        let (a, b) = (DVec3::new(0.3, -1.0, 5.0), DVec3::new(-0.1, -1.0, -9.0));
        let colors = [[0.0; 3], [0.5; 3], [1.0; 3]];
        let left = frustum().triangle([a, b, DVec3::new(-7.0, -1.0, -4.0)], colors, NO_UVS);
        let right = frustum().triangle([b, a, DVec3::new(7.0, -1.0, -4.0)], colors, NO_UVS);
        let points = |parts: &[ScreenTriangle]| {
            let mut all: Vec<(i64, i64)> = parts.iter().flatten().map(|c| (c.x, c.y)).collect();
            all.sort_unstable();
            all.dedup();
            all
        };
        let (left, right) = (points(&left), points(&right));
        let common = left.iter().filter(|p| right.contains(p)).count();
        assert_eq!(common, 2, "{left:?} {right:?}");
    }

    #[test]
    fn what_lies_behind_is_dropped() {
        let corners = [DVec3::new(-1.0, 0.0, 1.0), DVec3::new(1.0, 0.0, 1.0), DVec3::new(0.0, 1.0, 2.0)];
        assert!(frustum().triangle(corners, [[1.0; 3]; 3], NO_UVS).is_empty());
        assert!(frustum().line([corners[0], corners[1]]).is_none());
        let line = frustum().line([DVec3::new(0.0, 0.0, 3.0), DVec3::new(0.0, 0.0, -4.0)]).unwrap();
        assert_eq!(line.inverse_depth, [2.0, 0.25]);
    }
}
