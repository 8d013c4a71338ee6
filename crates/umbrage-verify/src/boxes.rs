//! A tree over boxes of which thousands may lie in one place, as those of tiny triangles do that are grown by a tolerance.

use obvhs::bvh2::Bvh2;
use obvhs::bvh2::builder::build_bvh2;
use obvhs::{Boundable, BvhBuildParams};

/// Builds a tree without reinsertion: over boxes in one place that makes `obvhs`'s tree deeper than the stack that it keeps for
/// walks through it.
pub(crate) fn tree<T: Boundable>(boxes: &[T]) -> Bvh2 {
    let settings = BvhBuildParams { reinsertion_batch_ratio: 0.0, ..BvhBuildParams::medium_build() };
    build_bvh2(boxes, settings, &mut Default::default())
}

#[cfg(test)]
mod tests {
    use obvhs::aabb::Aabb;

    use super::*;

    #[test]
    fn boxes_in_one_place_are_all_found() {
        let boxes: Vec<Aabb> = (0..20_000)
            .map(|i| {
                let corner = [i % 20, i / 20 % 20, i / 400].map(|k| 1e-9 * k as f32);
                Aabb::new(corner.into(), corner.map(|x| 1.0 + x).into())
            })
            .collect();
        let tree = tree(&boxes);
        let mut found = 0;
        tree.point_traverse([0.5; 3].into(), |tree, index| {
            found += tree.nodes[index as usize].prim_count;
            true
        });
        assert_eq!(found, 20_000);
    }
}
