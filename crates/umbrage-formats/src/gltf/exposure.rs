//! From light to displayed colour: the exposure `k`, and what `COLOR_0` and the base colour show.
//!
//! A viewer shows base colour x `COLOR_0`, both clipped to 1. A surface that only reflects keeps its reflectance `rho` as
//! base colour, and `COLOR_0 = k E / pi`, so that the product is `k` times its radiance. A surface that emits `L` shows
//! `k (L + rho E / pi)`, which `rho` times a colour below 1 cannot reach; so its base colour becomes the brightest of
//! those values on its material, clipped, and `COLOR_0` the ratio to it. For a plain lamp (`rho = 0`) this is
//! `COLOR_0 = 1` and base colour `k L` clipped; for a lamp that also reflects, the product is still exact up to clipping.
//!
//! With an image on it, a surface that reflects shows base colour times image times light, and one that emits by an image shows
//! that image, times `k` and cut off at white, and nothing of what it reflects.
//!
//! `k` is one over the value of `E / pi`, brightest channel, that 99.5 % of the area of the reflecting surfaces that are lit stays
//! below, to three digits: spots close to a lamp may clip, and do not darken the rest. Surfaces with less than a hundredth of the mean light
//! do not count: however large the dark outside of a house is, it says nothing of how bright its rooms are.

use std::f64::consts::PI;

use glam::DVec3;
use umbrage::id::{MaterialId, Table};
use umbrage::scene::{Material, Rgb, Scene};
use umbrage::shade::{BakedMesh, BakedPart};

/// Share of the lit area, in percent, that is shown unclipped.
pub(super) const PERCENTILE: f64 = 99.5;

/// What has less than this share of the mean light is not lit.
const LIT_SHARE: f64 = 0.01;

/// The exposure for a mesh: see the head of this file. 1 if all is dark.
pub(super) fn choose(scene: &Scene, baked: &BakedMesh) -> f64 {
    let reflected = |_: &Material, e: Rgb| e / PI;
    let shown = |m: &Material, e: Rgb| m.shown_radiance() + m.reflectance * e / PI;
    let reflecting = values(scene, baked, false, reflected);
    let bright = percentile(reflecting).or_else(|| percentile(values(scene, baked, true, shown)));
    bright.map_or(1.0, |bright| three_digits(1.0 / bright.max(f64::MIN_POSITIVE)))
}

/// The greatest number of three digits that is not above one: what is told can be given back, and clips no more.
fn three_digits(k: f64) -> f64 {
    let unit = 10.0_f64.powf(k.log10().floor() - 2.0);
    // Digits are written and read again, so that they are those of the number that is told.
    format!("{:.2e}", unit * (k / unit).floor()).parse().unwrap_or(k)
}

/// A value and an area at each triangle's corner, over the parts that emit or those that do not.
fn values(scene: &Scene, baked: &BakedMesh, emitting: bool, value: impl Fn(&Material, Rgb) -> Rgb) -> Vec<(f64, f64)> {
    let mut values = Vec::new();
    for part in &baked.parts {
        let material = material_of(scene, part);
        if material.shines() != emitting {
            continue;
        }
        for triangle in &part.triangles {
            let [a, b, c] = triangle.map(|v| DVec3::from(part.positions_m[v as usize].map(f64::from)));
            let third = (b - a).cross(c - a).length() / 6.0;
            values.extend(triangle.map(|v| (value(material, irradiance(part, v as usize)).max_element(), third)));
        }
    }
    values
}

/// The value that [`PERCENTILE`] of the area stays below; the greatest if that is 0; `None` if all are 0.
fn percentile(mut values: Vec<(f64, f64)>) -> Option<f64> {
    values.sort_by(|x, y| x.0.total_cmp(&y.0));
    let mean = values.iter().map(|(value, area)| value * area).sum::<f64>()
        / values.iter().map(|(_, area)| area).sum::<f64>().max(f64::MIN_POSITIVE);
    values.retain(|(value, _)| *value >= LIT_SHARE * mean);
    let total: f64 = values.iter().map(|(_, area)| area).sum();
    let mut below = 0.0;
    let found = values.iter().find(|(_, area)| {
        below += area;
        below >= total * (PERCENTILE / 100.0)
    });
    let candidates = [found, values.last()];
    candidates.into_iter().flatten().map(|(value, _)| *value).find(|value| *value > 0.0)
}

/// The base colour that each material is shown with.
pub(super) fn base_colours(scene: &Scene, baked: &BakedMesh, k: f64) -> Table<MaterialId, Rgb> {
    let mut brightest: Table<MaterialId, Rgb> = scene.materials.iter().map(|_| Rgb::ZERO).collect();
    for part in &baked.parts {
        let most = &mut brightest[scene.surfaces[part.surface].material];
        *most = (0..part.irradiance.len()).fold(*most, |most, v| most.max(irradiance(part, v)));
    }
    let pairs = scene.materials.iter().zip(&brightest);
    pairs
        .map(|(material, &most)| {
            let base = match (material.shines(), &material.look.texture) {
                (true, Some(texture)) => k * texture.factor,
                (true, None) => emitted_and_reflected(material, most, k),
                (false, Some(texture)) => texture.factor,
                (false, None) => material.reflectance,
            };
            base.min(Rgb::ONE)
        })
        .collect()
}

/// `COLOR_0` of a vertex before clipping.
pub(super) fn colour(material: &Material, base: Rgb, irradiance: Rgb, k: f64) -> Rgb {
    if !material.shines() {
        return irradiance * (k / PI);
    }
    if material.look.texture.is_some() {
        return Rgb::ONE;
    }
    let wanted = emitted_and_reflected(material, irradiance, k);
    // A channel that neither emits nor reflects is black by its base colour.
    Rgb::select(base.cmpgt(Rgb::ZERO), wanted / base, Rgb::ONE)
}

fn emitted_and_reflected(material: &Material, irradiance: Rgb, k: f64) -> Rgb {
    k * (material.shown_radiance() + material.reflectance * irradiance / PI)
}

/// The mean of `COLOR_0` over all that only reflects, at most white.
pub(super) fn mean_colour(scene: &Scene, baked: &BakedMesh, k: f64) -> Rgb {
    let mean = |channel: usize| {
        let all = values(scene, baked, false, |_, e| Rgb::splat((k * e[channel] / PI).min(1.0)));
        let area: f64 = all.iter().map(|(_, area)| area).sum();
        let sum: f64 = all.iter().map(|(value, area)| value * area).sum();
        if area > 0.0 { sum / area } else { 1.0 }
    };
    Rgb::new(mean(0), mean(1), mean(2))
}

/// The irradiance at a vertex, in W/m2.
pub(super) fn irradiance(part: &BakedPart, vertex: usize) -> Rgb {
    Rgb::from(part.irradiance[vertex].map(f64::from))
}

/// The material of a part.
pub(super) fn material_of<'a>(scene: &'a Scene, part: &BakedPart) -> &'a Material {
    &scene.materials[scene.surfaces[part.surface].material]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_percentile_weighs_by_area() {
        assert_eq!(percentile(vec![(3.0, 1.0), (1.0, 199.0)]), Some(1.0));
        assert_eq!(percentile(vec![(3.0, 2.0), (1.0, 198.0)]), Some(3.0));
        assert_eq!(percentile(vec![(0.0, 999.0), (2.0, 1.0)]), Some(2.0));
        assert_eq!(percentile(vec![(0.0, 1.0)]), None);
        assert_eq!(percentile(vec![]), None);
    }

    #[test]
    fn a_plain_lamp_shows_its_clipped_colour() {
        let lamp = Material::emitting("lamp", Rgb::new(4.0, 0.25, 0.0));
        let base = emitted_and_reflected(&lamp, Rgb::splat(9.0), 0.5).min(Rgb::ONE);
        assert_eq!(base, Rgb::new(1.0, 0.125, 0.0));
        assert!(colour(&lamp, base, Rgb::splat(2.0), 0.5).min(Rgb::ONE) == Rgb::ONE);
    }

    #[test]
    fn a_lamp_that_reflects_shows_both() {
        let lamp = Material { reflectance: Rgb::splat(0.5), ..Material::emitting("lamp", Rgb::new(0.2, 0.1, 0.0)) };
        let (k, most) = (1.0, Rgb::splat(PI));
        let base = emitted_and_reflected(&lamp, most, k).min(Rgb::ONE);
        for e in [Rgb::ZERO, Rgb::new(1.0, 2.0, 3.0), most] {
            let shown = base * colour(&lamp, base, e, k);
            assert!((shown - (lamp.radiance + 0.5 * e / PI)).abs().max_element() < 1e-12, "{shown}");
        }
    }
}
