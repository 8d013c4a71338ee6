//! Smooth surfaces, by their definition: which polygons stand for one, with what normals, and what is around each of them.
//!
//! - A normal of a corner is of use if it is not zero and not turned away from its polygon by more than 84 degrees; it is turned to the
//!   front that most of its polygon's normals look to. Where it is of no use the polygon's own normal stands.
//! - An edge is smooth if two polygons pass along it in opposite directions, in two planes that bend by no more than 61 degrees, and
//!   if their normals, all of use, differ by no more than half of the bend at both ends.
//! - A polygon with a smooth edge is part of a smooth surface. A point of it receives by the interpolated normal. Itself, and
//!   the polygons that have a corner in common with it, unless they stand in front of it and its surface does not go on in them, it sees
//!   from a point above: it is moved along its normal, as far as the tangent
//!   planes at the corners lie over it, by the weights of the corners (Hanika, *Hacking the shadow terminator*, Ray Tracing Gems II,
//!   2021), and a hair further. All else it sees from where it is.

use std::collections::BTreeMap;

use glam::DVec3;
use umbrage::scene::{Scene, Surface};

/// The least cosine between a normal and its polygon's.
const LEAST_FACING_COSINE: f64 = 0.1;
/// The least cosine between two polygons beside a smooth edge.
const LEAST_SMOOTH_COSINE: f64 = 0.485;
/// Normals at a smooth edge differ by no more than this share of the bend.
const SMOOTH_OF_BEND: f64 = 0.5;
/// Corners that agree to this share of the extent are one.
const SAME_OF_EXTENT: f64 = 1e-6;
/// Where more polygons than this meet at a corner, only those beside its edges are around one of them.
const MOST_AT_CORNER: usize = 32;

/// A polygon, as far as smoothness goes.
struct Polygon {
    /// Names of its corners: equal where they are at one place.
    corners: Vec<u32>,
    front: DVec3,
    at_m: DVec3,
    /// Towards the front; `None` where there is none of use.
    normals: Vec<Option<DVec3>>,
}

/// What smooth surfaces there are.
#[derive(Debug, Default)]
pub(crate) struct SmoothSurfaces {
    /// Normals of the corners of each polygon, by surface and polygon in order; none for flat ones.
    pub(crate) normals: Vec<Vec<DVec3>>,
    /// For each smooth polygon, itself and those around it, ascending.
    pub(crate) around: Vec<Vec<u32>>,
}

/// A side of a polygon: the names of its ends, ascending; whether it runs from the second to the first; polygon and side.
type Side = ([u32; 2], bool, usize, usize);

impl SmoothSurfaces {
    /// Those of a scene of this extent, in metres.
    pub(crate) fn new(scene: &Scene, extent_m: f64) -> Self {
        let polygons = polygons(scene, SAME_OF_EXTENT * extent_m);
        let mut sides: Vec<Side> = Vec::new();
        for (number, polygon) in polygons.iter().enumerate() {
            for (i, &corner) in polygon.corners.iter().enumerate() {
                let next = polygon.corners[(i + 1) % polygon.corners.len()];
                sides.push(([corner.min(next), corner.max(next)], next < corner, number, i));
            }
        }
        sides.sort_unstable();
        let mut is_smooth = vec![false; polygons.len()];
        let mut beside: Vec<Vec<u32>> = vec![Vec::new(); polygons.len()];
        for run in sides.chunk_by(|one, other| one.0 == other.0) {
            for &(_, reversed, one, i) in run {
                for &(_, other_reversed, other, j) in run.iter().filter(|side| side.2 != one) {
                    beside[one].push(other as u32);
                    let [p, q] = [&polygons[one], &polygons[other]];
                    let next = |polygon: &Polygon, i: usize| (i + 1) % polygon.corners.len();
                    is_smooth[one] |= reversed != other_reversed
                        && is_bent(p, q, SAME_OF_EXTENT * extent_m)
                        && is_smooth_at([p, q], [i, next(q, j)])
                        && is_smooth_at([p, q], [next(p, i), j]);
                }
            }
        }
        let mut at_corner: BTreeMap<u32, Vec<u32>> = BTreeMap::new();
        for (number, polygon) in polygons.iter().enumerate() {
            polygon.corners.iter().for_each(|&corner| at_corner.entry(corner).or_default().push(number as u32));
        }
        let mut smooth = Self::default();
        for (number, polygon) in polygons.iter().enumerate() {
            let is_smooth = is_smooth[number];
            let normal = |normal: &Option<DVec3>| normal.unwrap_or(polygon.front);
            smooth.normals.push(if is_smooth { polygon.normals.iter().map(normal).collect() } else { Vec::new() });
            let mut around = Vec::new();
            if is_smooth {
                around = std::mem::take(&mut beside[number]);
                around.push(number as u32);
                let few =
                    polygon.corners.iter().map(|corner| &at_corner[corner]).filter(|at| at.len() <= MOST_AT_CORNER);
                around.extend(few.flatten());
                around.sort_unstable();
                around.dedup();
                let same_m = SAME_OF_EXTENT * extent_m;
                let goes_on = |other: &Polygon| (0..other.corners.len()).any(|j| is_one_surface_at(polygon, other, j));
                let is_around: Vec<bool> = around
                    .iter()
                    .map(|&other| &polygons[other as usize])
                    .map(|other| (other.at_m - polygon.at_m).dot(polygon.front) <= same_m || goes_on(other))
                    .collect();
                let mut is_around = is_around.into_iter();
                around.retain(|_| is_around.next().unwrap_or(true));
            }
            smooth.around.push(around);
        }
        smooth
    }
}

/// Whether two polygons lie in different planes: a corner of the second is off the plane of the first.
fn is_bent(p: &Polygon, q: &Polygon, same_m: f64) -> bool {
    (q.at_m - p.at_m).dot(p.front).abs() > same_m || p.front.distance(q.front) > BENT
}

/// Polygons whose normals differ by more lie in different planes.
const BENT: f64 = 1e-6;

/// Whether two polygons have the same normal, up to half of the bend, at a corner of the second that is one of the first.
fn is_one_surface_at(p: &Polygon, q: &Polygon, corner: usize) -> bool {
    let same = p.corners.iter().position(|name| *name == q.corners[corner]);
    same.is_some_and(|i| is_smooth_at([p, q], [i, corner]))
}

fn is_smooth_at(polygons: [&Polygon; 2], corners: [usize; 2]) -> bool {
    let [p, q] = polygons;
    let (Some(one), Some(other)) = (p.normals[corners[0]], q.normals[corners[1]]) else { return false };
    p.front.dot(q.front) >= LEAST_SMOOTH_COSINE && one.distance(other) <= SMOOTH_OF_BEND * p.front.distance(q.front)
}

/// All polygons of a scene, with corners at one place within `same_m` under one name.
fn polygons(scene: &Scene, same_m: f64) -> Vec<Polygon> {
    let mut names: BTreeMap<[i64; 3], u32> = BTreeMap::new();
    let mut name = |at_m: DVec3| {
        let cell = (at_m / same_m.max(f64::MIN_POSITIVE)).round().to_array().map(|x| x as i64);
        // A place next to a cell's border may have been named in the cell beside it.
        let around = (0..27).map(|k| [0, 1, 2].map(|axis| cell[axis] + (k / 3_i64.pow(axis as u32)) % 3 - 1));
        let known = around.into_iter().find_map(|cell| names.get(&cell).copied());
        known.unwrap_or_else(|| {
            let fresh = names.len() as u32;
            names.insert(cell, fresh);
            fresh
        })
    };
    let mut polygons = Vec::new();
    for (id, surface) in scene.surfaces.iter_enumerated() {
        for (number, sources) in surface.polygons.iter().enumerate() {
            let corners_m: Vec<DVec3> = scene.corners_m(id, number).collect();
            let doubled: DVec3 = corners_m.windows(2).map(|p| (p[0] - corners_m[0]).cross(p[1] - corners_m[0])).sum();
            let front = doubled.normalize_or_zero();
            polygons.push(Polygon {
                corners: corners_m.iter().map(|&at_m| name(at_m)).collect(),
                front,
                at_m: corners_m.iter().sum::<DVec3>() / corners_m.len() as f64,
                normals: normals(surface, sources, front),
            });
        }
    }
    polygons
}

/// The normals of a polygon's corners that are of use.
fn normals(surface: &Surface, sources: &[u32], front: DVec3) -> Vec<Option<DVec3>> {
    if surface.normals.is_empty() {
        return vec![None; sources.len()];
    }
    let given = || sources.iter().map(|&i| surface.normals[i as usize]);
    let sign = if given().sum::<DVec3>().dot(front) < 0.0 { -1.0 } else { 1.0 };
    let of_use = |normal: DVec3| (sign * normal).try_normalize().filter(|n| n.dot(front) >= LEAST_FACING_COSINE);
    given().map(of_use).collect()
}

/// The corners of a smooth triangle: where they are, and their normals.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Corners {
    pub(crate) at_m: [DVec3; 3],
    pub(crate) normals: [DVec3; 3],
}

impl Corners {
    /// The unit normal at a point of the triangle, and the point over it on the tangent planes of its corners; on the other side of a
    /// sheet `side` is -1.
    pub(crate) fn normal_and_over_m(&self, at_m: DVec3, side: f64) -> (DVec3, DVec3) {
        let [a, b, c] = self.at_m;
        let across = (b - a).cross(c - a);
        let weight = |p: DVec3, q: DVec3| (p - at_m).cross(q - at_m).dot(across) / across.length_squared();
        let weights = [weight(b, c), weight(c, a), weight(a, b)].map(|w| w.clamp(0.0, 1.0));
        let normals = self.normals.map(|normal| side * normal);
        let normal: DVec3 = (0..3).map(|i| weights[i] * normals[i]).sum();
        let normal = normal.normalize_or(side * across.normalize_or_zero());
        let over_m: f64 = (0..3).map(|i| weights[i] * (self.at_m[i] - at_m).dot(normals[i])).sum();
        (normal, at_m + over_m.max(0.0) * normal)
    }
}
