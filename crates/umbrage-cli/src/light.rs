//! What gives light in a scene, and how much: surfaces and lamps apart, since files may have them in different units.

use glam::DVec3;
use umbrage::geometry::polygon;
use umbrage::id::MaterialId;
use umbrage::scene::{Lamp, LampKind, Rgb, Scene};

use crate::summary::{rgb, rounded};

/// Area of the polygons of a material that can be measured, in square metres; a double-sided one counts once.
pub(crate) fn area_m2(scene: &Scene, material: MaterialId) -> f64 {
    let areas = scene.surfaces.iter_enumerated().filter(|(_, s)| s.material == material).map(|(id, surface)| {
        let sound = |&n: &usize| surface.polygons[n].iter().all(|&i| (i as usize) < surface.positions_m.len());
        let area = |n| polygon::area_m2(&scene.corners_m(id, n).collect::<Vec<DVec3>>());
        (0..surface.polygons.len()).filter(sound).map(area).sum::<f64>()
    });
    areas.sum()
}

/// Flux that an area of a material gives, in watts.
pub(crate) fn flux_w(scene: &Scene, material: MaterialId, area_m2: f64) -> Rgb {
    let sides = if scene.materials[material].double_sided { 2.0 } else { 1.0 };
    sides * area_m2 * scene.materials[material].exitance()
}

/// What a scene's light gives, in watts.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Fluxes {
    /// All surfaces that emit.
    pub(crate) surfaces_w: Rgb,
    /// All lamps but distant ones, which have no flux of their own.
    pub(crate) lamps_w: Rgb,
    lamps: usize,
}

impl Fluxes {
    pub(crate) fn new(scene: &Scene) -> Self {
        let materials = (0..scene.materials.len()).map(MaterialId::from);
        Self {
            surfaces_w: materials.map(|id| flux_w(scene, id, area_m2(scene, id))).sum(),
            lamps_w: scene.lamps.iter().filter_map(Lamp::flux_w).sum(),
            lamps: scene.lamps.len(),
        }
    }

    /// One line. Where lamps give hundreds of times what surfaces do, their units differ.
    pub(crate) fn describe(&self) -> String {
        if self.lamps == 0 {
            rgb(self.surfaces_w)
        } else {
            format!("surfaces {}, lamps {}", rgb(self.surfaces_w), rgb(self.lamps_w))
        }
    }
}

/// A lamp with its kind and its flux.
pub(crate) fn describe_lamp(lamp: &Lamp) -> String {
    let degrees = |angle_rad: f64| rounded(angle_rad.to_degrees());
    let kind = match lamp.kind {
        LampKind::Point { .. } => "point".to_owned(),
        LampKind::Spot { inner_rad, outer_rad, .. } => {
            format!("spot of {} to {} degrees from its axis", degrees(inner_rad), degrees(outer_rad))
        }
        LampKind::Directional { irradiance, .. } => format!("distant, {} W/m2 on what faces it", rgb(irradiance)),
    };
    let flux = lamp.flux_w().map_or(String::new(), |flux| format!(": {}", rgb(flux)));
    format!("{:?}, {kind}{flux}", lamp.name)
}

#[cfg(test)]
mod tests {
    use umbrage::scene::cornell::cornell_box;

    use super::*;

    #[test]
    fn a_double_sided_light_gives_twice_the_flux() {
        let mut scene = cornell_box();
        let light = MaterialId::from(3);
        let one = flux_w(&scene, light, 1.0);
        scene.materials[light].double_sided = true;
        assert_eq!(flux_w(&scene, light, 1.0), 2.0 * one);
    }

    #[test]
    fn fluxes_of_lamps_and_surfaces_stand_side_by_side() {
        let mut scene = cornell_box();
        let kind = LampKind::Point {
            position_m: DVec3::ZERO,
            intensity: Rgb::splat(683.0 / (4.0 * std::f64::consts::PI)),
            range_m: None,
        };
        scene.lamps.push(Lamp { name: "bulb".into(), kind });
        assert_eq!(Fluxes::new(&scene).describe(), "surfaces 0.7885 0.5998 0.2896, lamps 683 683 683");
        assert_eq!(describe_lamp(&scene.lamps.raw[0]), "\"bulb\", point: 683 683 683");
    }
}
