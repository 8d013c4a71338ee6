//! Which polygons lie in one plane, said once as an id.
//!
//! Polygons come by falling area: one whose corners all lie within the coplanar tolerance of a known plane joins it
//! (the nearest, where there are several), else its own plane becomes a new one. A known plane never moves, so that no
//! chain of nearly coplanar polygons drifts away from it.
//!
//! Known planes lie in cells by their normal, in each cell by their offset. How far to look follows from how far a
//! polygon of this width can be tilted within the tolerance.

use std::collections::{BTreeMap, HashMap};

use glam::{DVec3, I64Vec3};

use super::Facing;
use super::soup::Polygon;
use super::weld::Points;
use crate::geometry::{Plane, PlaneFrame, Tolerance, polygon};
use crate::id::{PlaneId, Table};

/// None is taken for coplanar that is tilted more than this (radians), which keeps the search small. Only polygons hardly
/// wider than the tolerance could be.
const MOST_TILT: f64 = 0.1;
/// Size of a cell of normals.
const CELL: f64 = 0.03;

/// The planes of a scene.
#[derive(Debug)]
pub(super) struct Planes {
    /// The planes, each with a frame near the largest of its polygons.
    pub(super) frames: Table<PlaneId, PlaneFrame>,
    /// The plane of each polygon, and which way it looks.
    pub(super) of_polygon: Vec<(PlaneId, Facing)>,
}

/// Planes by normal and offset.
#[derive(Default)]
struct Known {
    /// In each cell the planes by the sort key of their offset, and by number.
    cells: HashMap<I64Vec3, BTreeMap<(u64, PlaneId), Plane>>,
}

/// A number whose order as an integer is the order of finite `x`.
fn sort_key(x: f64) -> u64 {
    let bits = x.to_bits();
    if x.is_sign_negative() { !bits } else { bits | (1 << 63) }
}

impl Known {
    fn cell(normal: DVec3) -> I64Vec3 {
        (normal / CELL).floor().as_i64vec3()
    }

    fn insert(&mut self, plane: &Plane, id: PlaneId) {
        let cell = self.cells.entry(Self::cell(plane.normal)).or_default();
        cell.insert((sort_key(plane.offset_m), id), *plane);
    }

    /// Planes whose normal and offset differ from those of `plane` by no more than this, and of which `is_near` holds.
    fn near(&self, plane: &Plane, tilt: f64, slack_m: f64, is_near: impl Fn(&Plane) -> bool) -> Vec<PlaneId> {
        let (low, high) = (Self::cell(plane.normal - tilt), Self::cell(plane.normal + tilt));
        let range = (sort_key(plane.offset_m - slack_m), PlaneId::from(0))
            ..=(sort_key(plane.offset_m + slack_m), PlaneId::from(u32::MAX as usize - 1));
        let mut found = Vec::new();
        for x in low.x..=high.x {
            for y in low.y..=high.y {
                for z in low.z..=high.z {
                    let Some(cell) = self.cells.get(&I64Vec3::new(x, y, z)) else { continue };
                    let planes = cell.range(range.clone());
                    found.extend(
                        planes.filter(|p| is_near(p.1) && p.1.normal.distance(plane.normal) <= tilt).map(|p| p.0.1),
                    );
                }
            }
        }
        found
    }
}

/// Gives every polygon its plane.
pub(super) fn planes(soup: &[Polygon], points: &Points, tolerance: &Tolerance) -> Planes {
    let mut by_area: Vec<usize> = (0..soup.len()).collect();
    by_area.sort_by(|&i, &j| soup[j].area_m2.total_cmp(&soup[i].area_m2).then(i.cmp(&j)));
    let mut frames: Table<PlaneId, PlaneFrame> = Table::new();
    let mut known = Known::default();
    let mut of_polygon = vec![(PlaneId::from(0), Facing::Along); soup.len()];
    for i in by_area {
        let corners = soup[i].corners_m(points);
        let Some(own) = Plane::of_polygon(&corners) else { continue };
        let id = nearest(&own, &corners, soup[i].area_m2, &frames, &known, tolerance).unwrap_or_else(|| {
            let id = frames.push_and_get_key(PlaneFrame::new(own, polygon::centroid(&corners)));
            known.insert(&own, id);
            id
        });
        let along = frames[id].plane.normal.dot(own.normal) > 0.0;
        of_polygon[i] = (id, if along { Facing::Along } else { Facing::Against });
    }
    Planes { frames, of_polygon }
}

/// The known plane that all corners lie in, the nearest of several.
fn nearest(
    own: &Plane,
    corners: &[DVec3],
    area_m2: f64,
    frames: &Table<PlaneId, PlaneFrame>,
    known: &Known,
    tolerance: &Tolerance,
) -> Option<PlaneId> {
    // Both planes pass within the tolerance of all corners, so they differ by at most four tolerances over the width.
    let width_m = area_m2 / polygon::perimeter_m(corners);
    let tilt = (4.0 * tolerance.coplanar_m() / width_m).min(MOST_TILT);
    let reach_m = corners.iter().map(|c| c.length()).fold(0.0, f64::max);
    let slack_m = tilt * reach_m + 2.0 * tolerance.coplanar_m();
    let passes = |plane: &Plane| corners.iter().all(|&c| plane.signed_distance_m(c).abs() <= tolerance.coplanar_m());
    let distance_m = |id: PlaneId| {
        let plane = &frames[id].plane;
        corners.iter().map(|&c| plane.signed_distance_m(c).abs()).fold(0.0, f64::max)
    };
    [*own, own.flipped()]
        .iter()
        .flat_map(|way| known.near(way, tilt, slack_m, passes))
        .map(|id| (distance_m(id), id))
        .min_by(|p, q| p.0.total_cmp(&q.0).then(p.1.cmp(&q.1)))
        .map(|(_, id)| id)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::id::{SurfaceId, VertexId};

    const TOLERANCE: Tolerance = Tolerance { extent_m: 1.0 };

    /// The plane of each square of side `size_m` at a height, tilted and turned over as asked.
    fn planes_of(squares: &[(f64, f64, f64, bool)]) -> Vec<(PlaneId, Facing)> {
        let mut points = Points::new(1e-9);
        let soup: Vec<Polygon> = squares
            .iter()
            .map(|&(size_m, height_m, slope, over)| {
                let mut corners: Vec<VertexId> = [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)]
                    .map(|(x, y)| points.weld(DVec3::new(x * size_m, y * size_m, height_m + x * size_m * slope)))
                    .to_vec();
                if over {
                    corners.reverse();
                }
                let surface = SurfaceId::from(0);
                Polygon {
                    surface,
                    number: 0,
                    corners,
                    sources: Vec::new(),
                    area_m2: size_m * size_m,
                    double_sided: false,
                    emits: false,
                }
            })
            .collect();
        planes(&soup, &points, &TOLERANCE).of_polygon
    }

    #[test]
    fn both_facings_share_a_plane() {
        let found = planes_of(&[(0.5, 0.25, 0.0, false), (0.3, 0.25, 0.0, true), (0.4, 0.26, 0.0, false)]);
        assert_eq!(found[0].0, found[1].0);
        assert_ne!(found[0].0, found[2].0);
        assert_ne!(found[0].1, found[1].1);
    }

    #[test]
    fn coplanar_is_a_distance_and_never_an_angle() {
        // The same slope is a bend for a large polygon, and rounding for a small one.
        let large = planes_of(&[(0.5, 0.0, 0.0, false), (0.4, 0.0, 5e-6, false)]);
        assert_ne!(large[0].0, large[1].0);
        let small = planes_of(&[(0.5, 0.0, 0.0, false), (0.1, 0.0, 5e-6, false)]);
        assert_eq!(small[0].0, small[1].0);
    }

    #[test]
    fn a_stack_of_near_planes_does_not_drift() {
        let stack: Vec<_> = (0..20).map(|i| (0.5 - 0.01 * f64::from(i), 0.6e-6 * f64::from(i), 0.0, false)).collect();
        let found = planes_of(&stack);
        for (i, p) in found.iter().enumerate() {
            for (j, q) in found.iter().enumerate() {
                let apart_m = 0.6e-6 * (i as f64 - j as f64).abs();
                assert!(p.0 != q.0 || apart_m < 2.1e-6, "{i} {j}");
            }
        }
    }
}
