//! The polygons of a scene in its frame: welded, without degenerate ones and duplicates, and all of them plane.
//!
//! A polygon whose texture coordinates or normals are no affine function of the position becomes triangles, too.
//!
//! Holds after: consecutive corners of a polygon differ; a polygon is wider than the weld distance; its corners lie
//! within the coplanar tolerance of its Newell plane; no two polygons have the same loop of corners.

use std::collections::{HashMap, HashSet};
use std::ops::Range;

use glam::DVec3;

use super::PrepareReport;
use super::skin;
use super::triangulation;
use super::weld::{Frame, Points};
use crate::geometry::{Plane, PlaneFrame, Tolerance, polygon};
use crate::id::{SurfaceId, VertexId};
use crate::scene::Scene;

/// A plane polygon between welded corners.
#[derive(Clone, Debug)]
pub(super) struct Polygon {
    /// The surface that it came from.
    pub(super) surface: SurfaceId,
    /// Which of the surface's polygons it is, or is a triangle of.
    pub(super) number: usize,
    /// Its corners, counter-clockwise seen from its front.
    pub(super) corners: Vec<VertexId>,
    /// Which of its surface's corners each of them is.
    pub(super) sources: Vec<u32>,
    /// Its area.
    pub(super) area_m2: f64,
    /// Whether it also has a face at its back.
    pub(super) double_sided: bool,
    /// Whether it emits: of two in one place it is the one that is shown.
    pub(super) emits: bool,
}

impl Polygon {
    /// Positions of the corners.
    pub(super) fn corners_m(&self, points: &Points) -> Vec<DVec3> {
        self.corners.iter().map(|&v| points[v]).collect()
    }

    /// The ends of each side, in order.
    pub(super) fn sides(&self) -> impl Iterator<Item = [VertexId; 2]> + '_ {
        (0..self.corners.len()).map(|i| [self.corners[i], self.corners[(i + 1) % self.corners.len()]])
    }
}

/// The polygons of a scene.
pub(super) fn polygons(scene: &Scene, frame: &Frame, points: &mut Points, report: &mut PrepareReport) -> Vec<Polygon> {
    let mut soup: Vec<Polygon> = Vec::new();
    // By its corners, the places of each polygon in the soup; and the places of those that are there again, emitting.
    let mut known: HashMap<Vec<VertexId>, Range<usize>> = HashMap::new();
    let mut replaced: HashSet<usize> = HashSet::new();
    for (surface, s) in scene.surfaces.iter_enumerated() {
        let (double_sided, emits) = (scene.materials[s.material].double_sided, scene.materials[s.material].emits());
        for number in 0..s.polygons.len() {
            report.polygons += 1;
            let before = points.len();
            let place = |&i: &u32| (points.weld(s.positions_m[i as usize] - frame.origin_m), i);
            let corners: Vec<(VertexId, u32)> = s.polygons[number].iter().map(place).collect();
            report.welded_corners += corners.len() - (points.len() - before);
            let (corners, sources): (Vec<VertexId>, Vec<u32>) = without_spikes(corners).into_iter().unzip();
            let area_m2 = area_m2(&corners, points);
            let polygon = Polygon { surface, number, area_m2, corners, sources, double_sided, emits };
            let Some(plane) = plane_of(&polygon, points, &frame.tolerance) else {
                report.degenerate_polygons += 1;
                continue;
            };
            let key = from_least(&polygon.corners);
            if let Some(first) = known.get(&key) {
                report.duplicate_polygons += 1;
                if !emits || soup[first.clone()].iter().all(|first| first.emits) {
                    continue;
                }
                replaced.extend(first.clone());
            }
            let start = soup.len();
            let height_m = |&v: &VertexId| plane.signed_distance_m(points[v]).abs();
            let is_plane = polygon.corners.iter().map(height_m).all(|h| h <= frame.tolerance.coplanar_m());
            if is_plane && skin::is_affine(&polygon, s, points) {
                soup.push(polygon);
            } else {
                report.nonplanar_polygons += usize::from(!is_plane);
                let triangles = triangles(&polygon, &plane, points);
                soup.extend(triangles.filter(|t| plane_of(t, points, &frame.tolerance).is_some()));
            }
            known.insert(key, start..soup.len());
        }
    }
    if replaced.is_empty() {
        return soup;
    }
    soup.into_iter().enumerate().filter(|(place, _)| !replaced.contains(place)).map(|(_, polygon)| polygon).collect()
}

/// Corners without repeated ones and without there-and-back spikes.
fn without_spikes(mut corners: Vec<(VertexId, u32)>) -> Vec<(VertexId, u32)> {
    loop {
        let before = corners.len();
        // Turned by half, the place where the loop closes is looked at as well.
        for _ in 0..2 {
            let mut kept: Vec<(VertexId, u32)> = Vec::with_capacity(corners.len());
            for corner in corners {
                if kept.len() >= 2 && kept[kept.len() - 2].0 == corner.0 {
                    kept.pop();
                } else if kept.last().is_none_or(|last| last.0 != corner.0) {
                    kept.push(corner);
                }
            }
            let half = kept.len() / 2;
            kept.rotate_left(half);
            corners = kept;
        }
        if corners.len() == before {
            return corners;
        }
    }
}

fn area_m2(corners: &[VertexId], points: &Points) -> f64 {
    polygon::area_m2(&corners.iter().map(|&v| points[v]).collect::<Vec<_>>())
}

/// The plane of a polygon; `None` where it is nowhere wider than the weld distance.
fn plane_of(p: &Polygon, points: &Points, tolerance: &Tolerance) -> Option<Plane> {
    let corners = p.corners_m(points);
    let first = *corners.first()?;
    let (low, high) = corners.iter().fold((first, first), |(low, high), &c| (low.min(c), high.max(c)));
    let width_m = 2.0 * p.area_m2 / low.distance(high);
    if width_m >= tolerance.weld_m() { Plane::of_polygon(&corners) } else { None }
}

/// A loop turned so that it starts at its least corner: equal loops become equal lists.
fn from_least(corners: &[VertexId]) -> Vec<VertexId> {
    let start = (0..corners.len()).min_by_key(|&i| corners[i]).unwrap_or(0);
    corners[start..].iter().chain(&corners[..start]).copied().collect()
}

/// The triangles of a polygon that is not plane, by Delaunay's rule in its mean plane.
fn triangles<'a>(p: &'a Polygon, plane: &Plane, points: &'a Points) -> impl Iterator<Item = Polygon> + 'a {
    let frame = PlaneFrame::new(*plane, points[p.corners[0]]);
    triangulation::fill(&p.corners, |v| frame.to_2d(points[v])).into_iter().map(|t| {
        let corners = t.to_vec();
        let source = |v: &VertexId| p.corners.iter().position(|corner| corner == v).map_or(0, |i| p.sources[i]);
        let sources = corners.iter().map(source).collect();
        Polygon { area_m2: area_m2(&corners, points), corners, sources, ..*p }
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn spikes_and_repeats_are_taken_off() {
        let clean = |corners: &[usize]| {
            let kept = without_spikes(corners.iter().map(|&i| (VertexId::from(i), 0)).collect());
            let kept: Vec<VertexId> = kept.into_iter().map(|corner| corner.0).collect();
            from_least(&kept).into_iter().map(VertexId::index).collect::<Vec<_>>()
        };
        assert_eq!(clean(&[0, 0, 1, 2, 2, 3, 0]), [0, 1, 2, 3]);
        assert_eq!(clean(&[0, 1, 5, 1, 2, 3]), [0, 1, 2, 3]);
        assert_eq!(clean(&[5, 1, 2, 3, 0, 1]), [0, 1, 2, 3]);
        assert_eq!(clean(&[0, 1, 2, 3, 7, 8, 7, 3]), [0, 1, 2, 3]);
        assert!(clean(&[0, 1, 2, 1]).len() < 3);
        assert!(clean(&[4, 4, 4]).len() < 3);
    }
}
