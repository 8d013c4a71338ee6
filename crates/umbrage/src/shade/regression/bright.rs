//! Leaves that small bright places begin with: a spot of light behind a hole lies between the first samples of a large leaf.
//!
//! Texels are many, and where next events bring the light of bright texels, that of each is known well enough to see such a place.
//! Leaves in which bright texels are a small part are split until they are an eighth of it: each then has samples of its own.

use crate::id::{FaceId, PatchId, Table};
use crate::mesh::Mesh;
use crate::shade::reflected_places::OF_FACE;
use crate::texels::{Texel, TexelRadiosity};
use crate::transport::{BrightPlace, PlacesOfLeaves};

/// Bright texels that are this share of a leaf cannot be missed by its samples.
const SHARE_OF_LEAF: f64 = 0.125;
/// Rounds of splits.
const MAX_ROUNDS: usize = 24;

/// The texels that are bright by reflection, and by more than `least` in W/m2.
pub(crate) fn bright_places(light: &TexelRadiosity, least: f64) -> Vec<BrightPlace> {
    let of = |number: usize| f64::from(light.indirect[number].element_sum()) / 3.0;
    let mut sums: Table<FaceId, (f64, f64)> = vec![(0.0, 0.0); light.reflectance.len()].into();
    for (number, texel) in light.grid.texels().iter().enumerate() {
        let (light_w, area_m2) = &mut sums[texel.face];
        (*light_w, *area_m2) = (*light_w + texel.area_m2 * of(number), *area_m2 + texel.area_m2);
    }
    let place = |(number, texel): (usize, &Texel)| {
        let (light_w, area_m2) = sums[texel.face];
        let is_bright = of(number) > (OF_FACE * light_w / area_m2).max(least);
        is_bright.then(|| BrightPlace {
            face: texel.face,
            point_m: texel.point_m,
            area_m2: texel.area_m2,
            irradiance: light.indirect[number].as_dvec3(),
            lamp: None,
        })
    };
    light.grid.texels().iter().enumerate().filter_map(place).collect()
}

/// Splits leaves of more than `least_m2` around bright places.
pub(super) fn split_around(mesh: &mut Mesh, places: &[BrightPlace], least_m2: f64) {
    let mut bright = PlacesOfLeaves::new(mesh, places);
    for _ in 0..MAX_ROUNDS {
        let is_missed = |&leaf: &PatchId| {
            let area_m2 = mesh.patch(leaf).area_m2;
            let bright_m2: f64 = bright.of(leaf).iter().map(|place| place.area_m2).sum();
            area_m2 > least_m2 && bright_m2 > 0.0 && bright_m2 < SHARE_OF_LEAF * area_m2
        };
        let missed: Vec<PatchId> = mesh.leaves().filter(is_missed).collect();
        if missed.into_iter().filter(|&leaf| mesh.split(leaf)).count() == 0 {
            break;
        }
        bright.hand_down(mesh);
    }
    tracing::debug!(texels = places.len(), leaves = mesh.leaves().count(), "split around bright texels");
}
