//! A tree over the boxes of small things, and the box around a point that is asked for.
//!
//! The box of the question is grown by the tolerance, not those of the things: thousands of grown boxes in one place would make the
//! tree deeper than the stack that `obvhs` keeps for walks through it.

use glam::DVec3;
use obvhs::aabb::Aabb;
use obvhs::bvh2::Bvh2;
use obvhs::bvh2::builder::build_bvh2;
use obvhs::{Boundable, BvhBuildParams};

/// Builds a tree. Without reinsertion, which makes it deeper.
pub(crate) fn tree<T: Boundable>(boxes: &[T]) -> Bvh2 {
    let settings = BvhBuildParams { reinsertion_batch_ratio: 0.0, ..BvhBuildParams::medium_build() };
    build_bvh2(boxes, settings, &mut Default::default())
}

/// The box of all that is at most so far from a point along each axis.
pub(crate) fn around(point_m: DVec3, distance_m: f64) -> Aabb {
    Aabb::new((point_m - distance_m).as_vec3a(), (point_m + distance_m).as_vec3a())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tiny_boxes_close_to_one_another_are_all_found() {
        let boxes: Vec<Aabb> = (0..20_000)
            .map(|i| {
                let corner = [i % 20, i / 20 % 20, i / 400].map(|k| f64::from(k) * 1e-6);
                around(DVec3::from(corner), 5e-7)
            })
            .collect();
        let tree = tree(&boxes);
        let mut found = 0;
        tree.aabb_traverse(around(DVec3::ZERO, 1e-3), |tree, index| {
            found += tree.nodes[index as usize].prim_count;
            true
        });
        assert_eq!(found, 20_000);
    }
}
