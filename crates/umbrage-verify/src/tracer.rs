//! Rays through a scene: the nearest side, and whether anything is between two points.
//!
//! The tree of boxes is `obvhs`'s, in `f32`, with boxes that are grown by more than `f32` rounds; triangles are met in
//! `f64`.
//!
//! Holds: where several sides lie in one place, the one that faces the ray is met, and of those the smallest polygon's,
//! as the baker promises.

use glam::{DVec3, Vec3A};
use obvhs::aabb::Aabb;
use obvhs::bvh2::Bvh2;
use obvhs::bvh2::builder::build_bvh2;
use obvhs::ray::{Ray, RayHit};
use obvhs::{Boundable, BvhBuildParams};

use umbrage::scene::Scene;

use crate::path::{Near, Place};
use crate::sides::{self, Triangle};
use crate::smooth::SmoothSurfaces;

/// Sides nearer to one another than this share of the extent are in one place, and a ray starts so far from its side:
/// 16 roundings of an `f32` coordinate.
const TOUCHING_OF_EXTENT: f64 = 1e-6;
/// What is around a place on a smooth surface is seen from so much higher, as a share of the extent.
const HAIR_OF_EXTENT: f64 = 2e-6;
/// Boxes are grown by this share of the extent, for the rounding of rays and boxes to `f32`.
const GROWN_OF_EXTENT: f64 = 1e-5;
/// A ray that passes a triangle by this share of its sides meets it: so that none slips between neighbours.
const EDGE_SLACK: f64 = 1e-9;

/// A triangle and how much its box is grown.
struct Boxed<'a>(&'a Triangle, f64);

impl Boundable for Boxed<'_> {
    fn aabb(&self) -> Aabb {
        let corners = self.0.corners_m();
        let (low, high) = (corners[0].min(corners[1]).min(corners[2]), corners[0].max(corners[1]).max(corners[2]));
        Aabb::new((low - self.1).as_vec3a(), (high + self.1).as_vec3a())
    }
}

/// What a ray meets.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Hit {
    pub(crate) distance_m: f64,
    /// Number of the triangle.
    pub(crate) triangle: usize,
    /// Whether the ray comes from its front.
    pub(crate) front: bool,
}

/// The sides of a scene, for rays.
pub(crate) struct Tracer {
    pub(crate) triangles: Vec<Triangle>,
    /// For each smooth polygon, the triangles of itself and those around it, ascending.
    around: Vec<Vec<u32>>,
    pub(crate) touching_m: f64,
    pub(crate) extent_m: f64,
    tree: Bvh2,
}

impl Tracer {
    pub(crate) fn new(scene: &Scene, smooth: &SmoothSurfaces, extent_m: f64) -> Self {
        let triangles = sides::triangles(scene, &smooth.normals);
        let mut of_polygon: Vec<Vec<u32>> = vec![Vec::new(); scene.polygon_count()];
        triangles.iter().enumerate().for_each(|(number, t)| of_polygon[t.polygon].push(number as u32));
        let triangles_of =
            |polygons: &Vec<u32>| polygons.iter().flat_map(|&p| &of_polygon[p as usize]).copied().collect();
        let around = smooth.around.iter().map(triangles_of).collect();
        let boxes: Vec<Boxed<'_>> = triangles.iter().map(|t| Boxed(t, GROWN_OF_EXTENT * extent_m)).collect();
        let tree = if boxes.is_empty() {
            Bvh2::default()
        } else {
            build_bvh2(&boxes, BvhBuildParams::medium_build(), &mut Default::default())
        };
        Self { triangles, around, touching_m: TOUCHING_OF_EXTENT * extent_m, extent_m, tree }
    }

    /// The point of a triangle, on its front or back, as what receives light there.
    pub(crate) fn place(&self, number: usize, position_m: DVec3, on_front: bool) -> Place {
        let triangle = &self.triangles[number];
        let side = if on_front { 1.0 } else { -1.0 };
        let flat = Place { position_m, front: side * triangle.normal, normal: side * triangle.normal, near: None };
        let Some(corners) = &triangle.smooth else { return flat };
        let (normal, over_m) = corners.normal_and_over_m(position_m, side);
        let from_m = over_m + HAIR_OF_EXTENT * self.extent_m * normal;
        Place { normal, near: Some(Near { polygon: triangle.polygon, from_m }), ..flat }
    }

    /// The triangles that a place sees from its near view, ascending, and that view.
    fn near(&self, place: &Place) -> (&[u32], DVec3) {
        place.near.map_or((&[], place.position_m), |near| (&self.around[near.polygon], near.from_m))
    }

    /// The nearest side along a unit direction.
    pub(crate) fn nearest(&self, from: &Place, direction: DVec3) -> Option<Hit> {
        let mut best: Option<Hit> = None;
        let (near, near_m) = self.near(from);
        for &number in near {
            let triangle = &self.triangles[number as usize];
            if let Some(distance_m) = meets(triangle, near_m, direction).filter(|&t| t > 0.0) {
                let hit = Hit { distance_m, triangle: number as usize, front: triangle.normal.dot(direction) < 0.0 };
                if best.is_none_or(|best| self.is_before(&hit, &best)) {
                    best = Some(hit);
                }
            }
        }
        let from_m = from.position_m;
        let ray = Ray::new_inf(as_f32(from_m), as_f32(direction));
        self.tree.ray_traverse(ray, &mut RayHit::none(), |_, place| {
            let number = self.tree.primitive_indices[place] as usize;
            if near.binary_search(&(number as u32)).is_ok() {
                return f32::INFINITY;
            }
            let triangle = &self.triangles[number];
            let Some(distance_m) = meets(triangle, from_m, direction).filter(|&t| t > self.touching_m) else {
                return f32::INFINITY;
            };
            let hit = Hit { distance_m, triangle: number, front: triangle.normal.dot(direction) < 0.0 };
            if best.is_none_or(|best| self.is_before(&hit, &best)) {
                best = Some(hit);
            }
            // What lies in the same place must still be looked at.
            (distance_m + 2.0 * self.touching_m) as f32
        });
        best
    }

    /// Whether a ray meets `hit` rather than `other`.
    fn is_before(&self, hit: &Hit, other: &Hit) -> bool {
        let away_m = hit.distance_m - other.distance_m;
        if away_m.abs() > self.touching_m {
            return away_m < 0.0;
        }
        let rank = |hit: &Hit| (!hit.front, self.triangles[hit.triangle].polygon_area_m2);
        let (mine, others) = (rank(hit), rank(other));
        // By number where all is equal: the order of the tree is no reason.
        mine.partial_cmp(&others).is_some_and(|order| order.then(hit.triangle.cmp(&other.triangle)).is_lt())
    }

    /// Whether anything is between a place and a point, but for what touches either.
    pub(crate) fn blocked(&self, from: &Place, to_m: DVec3) -> bool {
        let (near, near_m) = self.near(from);
        let near_far_m = near_m.distance(to_m) - self.touching_m;
        let towards = (to_m - near_m).normalize_or_zero();
        let stops = |&number: &u32| {
            meets(&self.triangles[number as usize], near_m, towards).is_some_and(|t| t > 0.0 && t < near_far_m)
        };
        if near.iter().any(stops) {
            return true;
        }
        let from_m = from.position_m;
        let distance_m = from_m.distance(to_m);
        let direction = (to_m - from_m) / distance_m;
        let far_m = distance_m - self.touching_m;
        let ray = Ray::new(as_f32(from_m), as_f32(direction), 0.0, far_m as f32);
        !self.tree.ray_traverse_miss(ray, |_, place| {
            let number = self.tree.primitive_indices[place];
            if near.binary_search(&number).is_ok() {
                return f32::INFINITY;
            }
            let triangle = &self.triangles[number as usize];
            let met = meets(triangle, from_m, direction).is_some_and(|t| t > self.touching_m && t < far_m);
            if met { 0.0 } else { f32::INFINITY }
        })
    }
}

fn as_f32(p: DVec3) -> Vec3A {
    p.as_vec3a()
}

/// The distance at which a ray meets a triangle (Möller and Trumbore, *Fast, minimum storage ray-triangle
/// intersection*, 1997).
fn meets(triangle: &Triangle, from_m: DVec3, direction: DVec3) -> Option<f64> {
    let [first, second] = triangle.edges_m;
    let across = direction.cross(second);
    let determinant = first.dot(across);
    if determinant == 0.0 {
        return None;
    }
    let inverse = 1.0 / determinant;
    let away = from_m - triangle.corner_m;
    let s = inverse * away.dot(across);
    if !(-EDGE_SLACK..=1.0 + EDGE_SLACK).contains(&s) {
        return None;
    }
    let q = away.cross(first);
    let t = inverse * direction.dot(q);
    (t >= -EDGE_SLACK && s + t <= 1.0 + EDGE_SLACK).then(|| inverse * second.dot(q))
}

#[cfg(test)]
mod tests {
    use super::*;
    use umbrage::scene::cornell::cornell_box;

    #[test]
    fn a_closed_box_holds_every_ray() {
        let tracer = Tracer::new(&cornell_box(), &SmoothSurfaces::default(), 0.5);
        let at = |position_m: DVec3| Place { position_m, normal: DVec3::X, front: DVec3::X, near: None };
        let mut rng = fastrand::Rng::with_seed(7);
        let mut point = || DVec3::new(rng.f64(), rng.f64(), rng.f64()) - 0.5;
        let middle = DVec3::new(0.278, 0.45, 0.15);
        let mut open = 0;
        for _ in 0..10_000 {
            let direction = point().normalize();
            match tracer.nearest(&at(middle), direction) {
                Some(hit) => {
                    assert!(hit.front, "{hit:?} along {direction}");
                    let place = middle + hit.distance_m * direction;
                    assert!(!tracer.blocked(&at(middle), place) && !tracer.blocked(&at(place), middle));
                    assert!(tracer.blocked(&at(middle), place + 0.01 * direction));
                }
                // The front of the box is open, towards -z.
                None => {
                    open += 1;
                    assert!(direction.z < 0.0, "{direction}");
                }
            }
        }
        assert!((2_000..5_000).contains(&open), "{open}");
    }
}
