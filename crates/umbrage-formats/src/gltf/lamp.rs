//! `KHR_lights_punctual`: point, spot and directional lamps.
//!
//! The extension gives candela and lux, and the emission of materials in cd/m2. Umbrage computes with watts on both sides;
//! so lamps and materials are taken as they stand, in one unit, unless the options say that lamps alone are photometric
//! ([`LampUnits`]).

use std::f64::consts::PI;

use glam::{DAffine3, DVec3};
use umbrage::scene::{Lamp, LampKind, Rgb};

use super::document::Document;
use super::item::Item;
use crate::{FormatError, LampUnits};

/// Luminous efficacy at 555 nm, in lm/W: what exporters turn watts into lumens with, whatever the spectrum.
const LUMENS_PER_WATT: f64 = 683.0;

const EXTENSION: &str = "KHR_lights_punctual";

/// The lamp of a node, if it has one, in the world. Spots whose cones are not as the extension wants them are counted in `odd_cones`.
pub(super) fn of_node(
    document: &Document,
    node: &Item<'_>,
    world: &DAffine3,
    units: LampUnits,
    odd_cones: &mut usize,
) -> Result<Option<Lamp>, FormatError> {
    let Some(holder) = node.extension(EXTENSION)? else { return Ok(None) };
    let index = holder.required_whole("light")?;
    let all = match document.root()?.extension(EXTENSION)? {
        Some(root) => root.children("lights", "light")?.collect::<Result<Vec<_>, _>>()?,
        None => Vec::new(),
    };
    let light = all.get(index).ok_or_else(|| FormatError::DanglingReference {
        file: document.file.clone(),
        place: format!("{}, light", node.place),
        index,
        count: all.len(),
    })?;
    let name = light.name().or(node.name()).map_or_else(|| format!("light {index}"), str::to_owned);
    Ok(Some(Lamp { name, kind: kind(light, world, units, odd_cones)? }))
}

fn kind(light: &Item<'_>, world: &DAffine3, units: LampUnits, odd_cones: &mut usize) -> Result<LampKind, FormatError> {
    let color = light.numbers::<3>("color")?.map_or(Rgb::ONE, Rgb::from);
    let strength = light.number("intensity")?.unwrap_or(1.0);
    let per_unit = match units {
        LampUnits::Same => 1.0,
        LampUnits::Lumens => 1.0 / LUMENS_PER_WATT,
    };
    let brightness = per_unit * strength * color;
    if !(brightness.is_finite() && brightness.min_element() >= 0.0) {
        return Err(light.bad("intensity", format!("times color is {brightness}, and should not be negative")));
    }
    let range_m = light.number("range")?;
    if let Some(range) = range_m.filter(|&range| range <= 0.0) {
        return Err(light.bad("range", format!("is {range}, and should be above 0")));
    }
    let position_m = world.translation;
    // A lamp looks along -z of its node.
    let direction = || {
        let ahead = world.transform_vector3(DVec3::NEG_Z).try_normalize();
        ahead.ok_or_else(|| light.bad("type", "needs a direction, and its node is scaled to nothing"))
    };
    match light.text("type")? {
        Some("point") => Ok(LampKind::Point { position_m, intensity: brightness, range_m }),
        Some("directional") => Ok(LampKind::Directional { direction: direction()?, irradiance: brightness }),
        Some("spot") => {
            let cones = light.child("spot")?;
            let angle =
                |key, default| Ok(cones.as_ref().map(|c| c.number(key)).transpose()?.flatten().unwrap_or(default));
            let (inner_rad, outer_rad): (f64, f64) =
                (angle("innerConeAngle", 0.0)?, angle("outerConeAngle", 0.25 * PI)?);
            if !(outer_rad > 0.0 && inner_rad.is_finite() && outer_rad.is_finite()) {
                let what = format!("has cones of {inner_rad} and {outer_rad} rad: the outer one should be above 0");
                return Err(light.bad("spot", what));
            }
            let is_as_specified = inner_rad >= 0.0 && inner_rad < outer_rad && outer_rad <= 0.5 * PI + ANGLE_SLACK_RAD;
            *odd_cones += usize::from(!is_as_specified);
            let outer_rad = outer_rad.min(0.5 * PI);
            let inner_rad = inner_rad.clamp(0.0, outer_rad);
            Ok(LampKind::Spot {
                position_m,
                direction: direction()?,
                intensity: brightness,
                range_m,
                inner_rad,
                outer_rad,
            })
        }
        Some(other) => Err(light.bad("type", format!("is {other:?}, and should be point, spot or directional"))),
        None => Err(light.bad("type", "is missing")),
    }
}

/// A right angle may have been rounded to `f32`, in radians.
const ANGLE_SLACK_RAD: f64 = 1e-6;
