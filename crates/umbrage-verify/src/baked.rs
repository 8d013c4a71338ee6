//! What a bake shows at a point: the light of the triangle there, between its corners.

use std::f64::consts::TAU;

use glam::{DVec2, DVec3};
use obvhs::Boundable;
use obvhs::aabb::Aabb;
use obvhs::bvh2::Bvh2;
use umbrage::scene::Rgb;

use crate::boxes::{around, tree};
use crate::path::Place;
use crate::verify::BakedTriangle;

/// A triangle further from a point than this share of the extent is not its own.
const ON_PLANE_OF_EXTENT: f64 = 1e-4;
/// Of triangles that are, those nearer than this share are before all others: corners are welded by 3 millionths at most. Sheets
/// that lie closer to one another than `ON_PLANE_OF_EXTENT` are told apart by that.
const OWN_OF_EXTENT: f64 = 4e-6;
/// Nor is one that looks another way: the least cosine.
const SAME_WAY: f64 = 0.999;
/// A point may lie outside of its triangle by this share of it: corners are rounded.
const OUTSIDE: f64 = 1e-3;
/// A bake shows a strip no wider than this share of the extent of area that is hidden, beside what can be seen: half as much
/// again as the rims that umbrage makes.
const RIM_OF_EXTENT: f64 = 1.5e-3;
/// In so many directions is looked for an end of what is shown.
const AROUND: usize = 16;

struct Boxed<'a>(&'a BakedTriangle);

impl Boundable for Boxed<'_> {
    fn aabb(&self) -> Aabb {
        let [p, q, r] = self.0.corners_m;
        Aabb::new(p.min(q).min(r).as_vec3a(), p.max(q).max(r).as_vec3a())
    }
}

/// What a bake shows at a point.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Shown {
    pub(crate) irradiance: Rgb,
    /// Whether that is surely of the point's own surface, and not of one close behind or before it.
    pub(crate) is_own: bool,
}

/// The triangles of a bake, by place.
pub(crate) struct Baked<'a> {
    triangles: &'a [BakedTriangle],
    tree: Bvh2,
    on_plane_m: f64,
    own_m: f64,
    rim_m: f64,
}

impl<'a> Baked<'a> {
    pub(crate) fn new(triangles: &'a [BakedTriangle], extent_m: f64) -> Self {
        let on_plane_m = ON_PLANE_OF_EXTENT * extent_m;
        let boxes: Vec<Boxed<'_>> = triangles.iter().map(Boxed).collect();
        let tree = if boxes.is_empty() { Bvh2::default() } else { tree(&boxes) };
        Self { triangles, tree, on_plane_m, own_m: OWN_OF_EXTENT * extent_m, rim_m: RIM_OF_EXTENT * extent_m }
    }

    /// The irradiance that the bake shows at a point; `None` where it has no triangle there that looks the same way.
    pub(crate) fn irradiance(&self, place: &Place) -> Option<Shown> {
        // The triangle in whose plane it is, and among these that the point lies deepest in, by its least barycentric coordinate.
        let mut best: Option<((bool, f64), usize, Rgb)> = None;
        self.tree.aabb_traverse(around(place.position_m, self.on_plane_m), |tree, index| {
            let node = &tree.nodes[index as usize];
            let range = node.first_index as usize..(node.first_index + node.prim_count) as usize;
            for &number in &tree.primitive_indices[range] {
                let number = number as usize;
                if let Some((depth, light)) = self.within(&self.triangles[number], place) {
                    let better = best.is_none_or(|(most, other, _)| depth > most || (depth == most && number < other));
                    if better {
                        best = Some((depth, number, light));
                    }
                }
            }
            true
        });
        best.map(|((is_own, _), _, irradiance)| Shown { irradiance, is_own })
    }

    /// Whether the bake shows nothing at some place beside a point, no farther away than a rim is wide: what is shown goes on
    /// so far beneath what stands on it.
    pub(crate) fn ends_near(&self, place: &Place) -> bool {
        let (u, v) = place.front.any_orthonormal_pair();
        (0..AROUND).any(|number| {
            let direction = DVec2::from_angle(TAU * number as f64 / AROUND as f64);
            let beside = self.rim_m * (direction.x * u + direction.y * v);
            self.irradiance(&Place { position_m: place.position_m + beside, ..*place }).is_none()
        })
    }

    /// Whether a point that lies in a triangle is in its plane, its least barycentric coordinate, and the light there.
    fn within(&self, triangle: &BakedTriangle, place: &Place) -> Option<((bool, f64), Rgb)> {
        let corners = triangle.corners_m;
        let across = (corners[1] - corners[0]).cross(corners[2] - corners[0]);
        let doubled = across.length();
        let normal = across / doubled;
        let away = place.position_m - corners[0];
        if !(normal.dot(place.front) > SAME_WAY && away.dot(normal).abs() <= self.on_plane_m) {
            return None;
        }
        let weight = |p: DVec3, q: DVec3| (p - place.position_m).cross(q - place.position_m).dot(normal) / doubled;
        let weights = [weight(corners[1], corners[2]), weight(corners[2], corners[0]), weight(corners[0], corners[1])];
        let least = weights.iter().copied().fold(f64::INFINITY, f64::min);
        let light = weights.iter().zip(triangle.irradiance).map(|(w, e)| w.max(0.0) * e).sum::<Rgb>();
        let sum: f64 = weights.iter().map(|w| w.max(0.0)).sum();
        let is_own = away.dot(normal).abs() <= self.own_m;
        (least >= -OUTSIDE).then(|| ((is_own, least), light / sum))
    }
}
