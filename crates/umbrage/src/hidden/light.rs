//! The regions that hold a source of light.
//!
//! An emitter lights the region before it, a sun the outside, and a lamp whatever its rays meet. A lamp that lies on a surface
//! within rounding may light the regions on both of its sides.

use super::sides::{Region, Sides, back, front};
use super::sight::{LEAVES_EXTENTS, over_sphere};
use crate::prepare::Prepared;
use crate::scene::Scene;
use crate::visibility::Visibility;

/// Rays from each lamp.
const RAYS_OF_LAMP: usize = 32;

/// Whether light is in each region, by its number.
pub(super) fn lit_regions(scene: &Scene, prepared: &Prepared, visibility: &Visibility, sides: &mut Sides) -> Vec<bool> {
    let mut is_lit = vec![false; sides.count()];
    let mut light = |region: Region| is_lit[region] = true;
    for (id, face) in prepared.faces.iter_enumerated() {
        if scene.materials[face.material].emits() {
            light(sides.region_before(id));
        }
    }
    let length_m = LEAVES_EXTENTS * prepared.tolerance.extent_m;
    for lamp in &scene.lamps {
        let Some(at_m) = lamp.position_m().map(|at_m| at_m - prepared.origin_m) else {
            light(sides.outside());
            continue;
        };
        // A lamp far outside sees the scene from there.
        let length_m = length_m + at_m.length();
        for direction in over_sphere(RAYS_OF_LAMP) {
            let region = match visibility.first_side(at_m, at_m + length_m * direction, None) {
                Some((face, true)) => sides.region(front(face)),
                Some((face, false)) => sides.region(back(face)),
                None => sides.outside(),
            };
            light(region);
        }
    }
    is_lit
}
