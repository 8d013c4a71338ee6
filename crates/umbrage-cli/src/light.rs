//! What gives light in a scene, and how much: surfaces and lamps apart, since files may have them in different units.

use glam::DVec3;
use umbrage::geometry::polygon;
use umbrage::id::{MaterialId, Table};
use umbrage::scene::{Lamp, LampKind, Rgb, Scene};

use crate::summary::{rgb, rounded};

/// What light is measured in.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Units {
    /// Of light that is given.
    pub(crate) flux: &'static str,
    /// Of light that falls on a surface.
    pub(crate) irradiance: &'static str,
    /// Of what a surface emits.
    pub(crate) radiance: &'static str,
}

impl Units {
    /// Those of a scene or a file.
    pub(crate) fn of(photometric: bool) -> Self {
        if photometric {
            Self { flux: "lm", irradiance: "lx", radiance: "cd/m2" }
        } else {
            Self { flux: "W", irradiance: "W/m2", radiance: "W/(m2 sr)" }
        }
    }
}

/// Area of the polygons of each material that can be measured, in square metres; a double-sided one counts once.
pub(crate) fn areas_m2(scene: &Scene) -> Table<MaterialId, f64> {
    let mut areas_m2: Table<MaterialId, f64> = scene.materials.iter().map(|_| 0.0).collect();
    for (id, surface) in scene.surfaces.iter_enumerated() {
        let sound = |&n: &usize| surface.polygons[n].iter().all(|&i| (i as usize) < surface.positions_m.len());
        let area = |n| polygon::area_m2(&scene.corners_m(id, n).collect::<Vec<DVec3>>());
        areas_m2[surface.material] += (0..surface.polygons.len()).filter(sound).map(area).sum::<f64>();
    }
    areas_m2
}

/// Flux that an area of a material gives, in watts.
pub(crate) fn flux_w(scene: &Scene, material: MaterialId, area_m2: f64) -> Rgb {
    let sides = if scene.materials[material].double_sided { 2.0 } else { 1.0 };
    sides * area_m2 * scene.materials[material].exitance()
}

/// What a scene's light gives, in watts.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Fluxes {
    /// All surfaces that emit.
    pub(crate) surfaces_w: Rgb,
    /// All lamps but distant ones, which have no flux of their own.
    pub(crate) lamps_w: Rgb,
    lamps: usize,
    /// Irradiance of each distant lamp on what faces it.
    suns: Vec<Rgb>,
    photometric: bool,
}

impl Fluxes {
    pub(crate) fn new(scene: &Scene) -> Self {
        let areas_m2 = areas_m2(scene);
        let sun = |lamp: &Lamp| match lamp.kind {
            LampKind::Directional { irradiance, .. } => Some(irradiance),
            LampKind::Point { .. } | LampKind::Spot { .. } => None,
        };
        let suns: Vec<Rgb> = scene.lamps.iter().filter_map(sun).collect();
        Self {
            surfaces_w: areas_m2.iter_enumerated().map(|(id, &area_m2)| flux_w(scene, id, area_m2)).sum(),
            lamps_w: scene.lamps.iter().filter_map(Lamp::flux_w).sum(),
            lamps: scene.lamps.len() - suns.len(),
            suns,
            photometric: scene.photometric,
        }
    }

    /// Whether there is any light.
    pub(crate) fn is_any(&self) -> bool {
        self.surfaces_w != Rgb::ZERO || self.lamps_w != Rgb::ZERO || !self.suns.is_empty()
    }

    /// What they are in.
    pub(crate) fn units(&self) -> Units {
        Units::of(self.photometric)
    }

    /// One line. Where lamps give hundreds of times what surfaces do, their units differ.
    pub(crate) fn describe(&self) -> String {
        let Units { flux, irradiance, .. } = self.units();
        let mut parts = Vec::new();
        if self.surfaces_w != Rgb::ZERO || (self.lamps == 0 && self.suns.is_empty()) {
            let noun = if self.lamps + self.suns.len() > 0 { "surfaces " } else { "" };
            parts.push(format!("{noun}{} {flux}", rgb(self.surfaces_w)));
        }
        if self.lamps > 0 {
            parts.push(format!("lamps {} {flux}", rgb(self.lamps_w)));
        }
        match self.suns[..] {
            [] => {}
            [sun] => parts.push(format!("a distant lamp {} {irradiance} on what faces it", rgb(sun))),
            _ => parts.push(format!(
                "{} distant lamps {} {irradiance} on what faces them all",
                self.suns.len(),
                rgb(self.suns.iter().sum())
            )),
        }
        parts.join(", ")
    }
}

/// A lamp with its kind and its flux.
pub(crate) fn describe_lamp(lamp: &Lamp, units: Units) -> String {
    let degrees = |angle_rad: f64| rounded(angle_rad.to_degrees());
    let kind = match lamp.kind {
        LampKind::Point { .. } => "point".to_owned(),
        LampKind::Spot { inner_rad, outer_rad, .. } => {
            format!("spot of {} to {} degrees from its axis", degrees(inner_rad), degrees(outer_rad))
        }
        LampKind::Directional { irradiance, .. } => {
            format!("distant, {} {} on what faces it", rgb(irradiance), units.irradiance)
        }
    };
    let flux = lamp.flux_w().map_or(String::new(), |flux| format!(": {}", rgb(flux)));
    format!("{:?}, {kind}{flux}", umbrage_formats::shortened(&lamp.name))
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
        assert_eq!(Fluxes::new(&scene).describe(), "surfaces 0.7885 0.5998 0.2896 W, lamps 683 683 683 W");
        assert_eq!(describe_lamp(&scene.lamps.raw[0], Units::of(false)), "\"bulb\", point: 683 683 683");
        // Suns are in the account, in the unit of the scene.
        scene.photometric = true;
        scene.materials[MaterialId::from(3)].radiance = Rgb::ZERO;
        let sun = |e: f64| LampKind::Directional { direction: DVec3::NEG_Y, irradiance: Rgb::splat(e) };
        scene.lamps = [sun(3.0), sun(2.0)].map(|kind| Lamp { name: "sun".into(), kind }).into_iter().collect();
        assert_eq!(Fluxes::new(&scene).describe(), "2 distant lamps 5 5 5 lx on what faces them all");
    }
}
