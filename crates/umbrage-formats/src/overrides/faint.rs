//! Emission that is too faint to light anything: it is shown, and not cast.
//!
//! Files have emissive maps with a trace of light in them, on thousands of polygons that would each become a light source. What emits less
//! than a thousandth of the brightest emitter, or than a hundredth of what a white surface shows in the light of the brightest lamp, and all of which
//! together gives less than a hundredth of the flux, keeps its colour and lights nothing.

use std::collections::BTreeSet;

use glam::DVec3;
use umbrage::geometry::polygon::area_m2;
use umbrage::id::{MaterialId, Table};
use umbrage::scene::{Lamp, LampKind, Rgb, Scene};

use crate::Warning;

/// Of the radiance of the brightest emitter.
const SHARE_OF_EMITTER: f64 = 1e-3;
/// Of the radiance of a white surface in the light of the brightest lamp.
const SHARE_OF_LIT: f64 = 1e-2;
/// Of the flux, all that is faint together.
const SHARE_OF_FLUX: f64 = 1e-2;
/// A surface that a bulb lights is taken to be so far away, as a share of the scene's extent.
const LIT_AT: f64 = 0.25;

/// Takes faint emission out of the light, but that of materials which are `named`: somebody has asked for it.
pub(super) fn show_only(scene: &mut Scene, named: &BTreeSet<&str>) -> Option<Warning> {
    let brightness = |colour: Rgb| colour.max_element();
    let mut areas_m2: Table<MaterialId, f64> = scene.materials.iter().map(|_| 0.0).collect();
    for (id, surface) in scene.surfaces.iter_enumerated() {
        if scene.materials[surface.material].emits() {
            let area = |polygon| area_m2(&scene.corners_m(id, polygon).collect::<Vec<DVec3>>());
            areas_m2[surface.material] += (0..surface.polygons.len()).map(area).sum::<f64>();
        }
    }
    let emitters =
        || scene.materials.iter().zip(&areas_m2).filter(|(material, area_m2)| material.emits() && **area_m2 > 0.0);
    let corners = || scene.surfaces.iter().flat_map(|surface| &surface.positions_m);
    let (low, high) = corners().fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(l, h), &p| (l.min(p), h.max(p)));
    let extent_m = (high - low).length();
    let lit = |lamp: &Lamp| match lamp.kind {
        LampKind::Directional { irradiance, .. } => brightness(irradiance),
        LampKind::Point { intensity, .. } | LampKind::Spot { intensity, .. } => {
            brightness(intensity) / (LIT_AT * extent_m).powi(2)
        }
    };
    let lamp_flux = |lamp: &Lamp| lamp.flux_w().map_or(lit(lamp) * (0.5 * extent_m).powi(2), brightness);
    let brightest = emitters().map(|(material, _)| brightness(material.radiance)).fold(0.0, f64::max);
    let lit = scene.lamps.iter().map(lit).fold(0.0, f64::max) / std::f64::consts::PI;
    let limit = (SHARE_OF_EMITTER * brightest).max(SHARE_OF_LIT * lit);
    let is_faint = |radiance: Rgb, name: &str| brightness(radiance) <= limit && !named.contains(name);
    let (mut faint_w, mut all_w) = (0.0, scene.lamps.iter().map(lamp_flux).sum::<f64>());
    for (material, area_m2) in emitters() {
        let flux_w = area_m2 * brightness(material.exitance());
        all_w += flux_w;
        faint_w += if is_faint(material.radiance, &material.name) { flux_w } else { 0.0 };
    }
    if !(faint_w > 0.0 && faint_w <= SHARE_OF_FLUX * all_w) {
        return None;
    }
    let mut materials = 0;
    for (material, area_m2) in scene.materials.iter_mut().zip(&areas_m2) {
        if material.emits() && *area_m2 > 0.0 && is_faint(material.radiance, &material.name) {
            material.look.glow = std::mem::take(&mut material.radiance);
            materials += 1;
        }
    }
    Some(Warning::FaintNotCast { materials, share_of_flux: faint_w / all_w })
}

#[cfg(test)]
mod tests {
    use umbrage::scene::cornell::cornell_box;

    use super::*;

    #[test]
    fn a_trace_of_emission_is_shown_and_not_cast() {
        let mut scene = cornell_box();
        let (white, light) = (MaterialId::from(0), MaterialId::from(3));
        let trace = 1e-5 * scene.materials[light].radiance;
        scene.materials[white].radiance = trace;
        let mut asked = scene.clone();
        assert_eq!(show_only(&mut asked, &BTreeSet::from(["white"])), None);
        assert!(matches!(show_only(&mut scene, &BTreeSet::new()), Some(Warning::FaintNotCast { materials: 1, .. })));
        let white = &scene.materials[white];
        assert!(!white.emits() && white.look.glow == trace && white.shown_radiance() == trace);
        assert!(scene.materials[light].emits());
    }

    #[test]
    fn what_is_faint_beside_a_lamp_but_gives_most_of_the_light_is_cast() {
        let mut scene = cornell_box();
        scene.materials[MaterialId::from(3)].radiance = Rgb::splat(1e-9);
        assert_eq!(show_only(&mut scene, &BTreeSet::new()), None);
        assert!(scene.materials[MaterialId::from(3)].emits());
    }
}
