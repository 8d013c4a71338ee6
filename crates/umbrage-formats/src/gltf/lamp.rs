//! `KHR_lights_punctual`: point, spot and directional lamps.
//!
//! The extension gives candela and lux, and the emission of materials in cd/m2. Umbrage computes with watts on both sides;
//! so lamps and materials are taken as they stand, in one unit, unless the options say that lamps alone are photometric
//! ([`LampUnits`]).
//!
//! What no lamp can have is mended as viewers do, and counted with the first case: cones that are equal have an edge between
//! them that is soft over a hundredth of the cone, an inner cone is at most the outer one, which is at most a right angle; a range that is not above 0 is none; a brightness below 0 is
//! 0. The scale of a node does not affect its lamp, so a direction is that of the node's rotations alone where a scale of 0 has taken it.

use std::f64::consts::PI;

use glam::DVec3;
use umbrage::scene::{Lamp, LampKind, Rgb};

use super::document::Document;
use super::item::Item;
use super::node::Placed;
use super::tally::Tally;
use crate::{FormatError, LampUnits};

/// Luminous efficacy at 555 nm, in lm/W: what exporters turn watts into lumens with, whatever the spectrum.
const LUMENS_PER_WATT: f64 = 683.0;

const EXTENSION: &str = "KHR_lights_punctual";

/// The lamp of a node, if it has one, in the world; none where it has no direction.
pub(super) fn of_node(
    document: &Document,
    placed: &Placed<'_>,
    units: LampUnits,
    tally: &mut Tally,
) -> Result<Option<Lamp>, FormatError> {
    let node = &placed.item;
    let Some(holder) = node.extension(EXTENSION)? else { return Ok(None) };
    let index = holder.required_whole("light")?;
    let root = document.root()?.extension(EXTENSION)?;
    let all = root.as_ref().map(|root| root.list("lights")).transpose()?.unwrap_or_default();
    let light = all.get(index).ok_or_else(|| FormatError::DanglingReference {
        file: document.file.clone(),
        place: format!("{}, light", node.place),
        index,
        count: all.len(),
    })?;
    let light = Item::named(&document.file, format!("{}, light {index}", node.place), light)?;
    let name = light.name().or(node.name()).map_or_else(|| format!("light {index}"), str::to_owned);
    let mut mended = |what: String| tally.lamp_mended(&name, what);
    let kind = kind(&light, placed, units, &mut mended)?;
    Ok(kind.map(|kind| Lamp { name, kind }))
}

fn kind(
    light: &Item<'_>,
    placed: &Placed<'_>,
    units: LampUnits,
    mended: &mut impl FnMut(String),
) -> Result<Option<LampKind>, FormatError> {
    let color = light.numbers::<3>("color")?.map_or(Rgb::ONE, Rgb::from);
    let strength = light.number("intensity")?.unwrap_or(1.0);
    let per_unit = match units {
        LampUnits::Same => 1.0,
        LampUnits::Lumens => 1.0 / LUMENS_PER_WATT,
    };
    let mut brightness = per_unit * strength * color;
    if brightness.min_element() < 0.0 {
        mended(format!("its brightness is {brightness}: what is below 0 is 0"));
        brightness = brightness.max(Rgb::ZERO);
    }
    if !brightness.is_finite() {
        return Err(light.bad("intensity", format!("times color is {brightness}, which is too large")));
    }
    let mut range_m = light.number("range")?;
    if let Some(range) = range_m.filter(|&range| range <= 0.0) {
        mended(format!("its range is {range}: without end"));
        range_m = None;
    }
    let position_m = placed.world.translation;
    let mut direction = || {
        let ahead = direction(placed);
        if ahead.is_none() {
            mended("its node is scaled to nothing: it has no direction, and is left out".to_owned());
        }
        ahead
    };
    Ok(match light.text("type")? {
        Some("point") => Some(LampKind::Point { position_m, intensity: brightness, range_m }),
        Some("directional") => direction().map(|direction| LampKind::Directional { direction, irradiance: brightness }),
        Some("spot") => {
            let Some(direction) = direction() else { return Ok(None) };
            let (inner_rad, outer_rad) = cones(light.child("spot")?.as_ref(), mended)?;
            Some(LampKind::Spot { position_m, direction, intensity: brightness, range_m, inner_rad, outer_rad })
        }
        Some(other) => return Err(light.bad("type", format!("is {other:?}, and should be point, spot or directional"))),
        None => return Err(light.bad("type", "is missing")),
    })
}

/// Where a lamp looks: along -z of its node.
fn direction(placed: &Placed<'_>) -> Option<DVec3> {
    let ahead = placed.world.transform_vector3(DVec3::NEG_Z).try_normalize();
    ahead.or_else(|| placed.turned.and_then(|turned| (turned * DVec3::NEG_Z).try_normalize()))
}

/// Half angles of a spot's cones, in radians, with 0 <= inner <= outer <= pi / 2.
fn cones(spot: Option<&Item<'_>>, mended: &mut impl FnMut(String)) -> Result<(f64, f64), FormatError> {
    let angle = |key, default| Ok(spot.map(|cones| cones.number(key)).transpose()?.flatten().unwrap_or(default));
    let (inner, outer): (f64, f64) = (angle("innerConeAngle", 0.0)?, angle("outerConeAngle", 0.25 * PI)?);
    let outer_rad = outer.clamp(LEAST_CONE_RAD, 0.5 * PI);
    let inner_rad = inner.clamp(0.0, outer_rad);
    let is_near = |asked: f64, taken: f64| (asked - taken).abs() <= ANGLE_SLACK_RAD;
    if !is_near(outer, outer_rad) || inner < 0.0 || inner > outer + ANGLE_SLACK_RAD {
        mended(format!("its cones of {inner} and {outer} rad are taken as {inner_rad:.4} and {outer_rad:.4}"));
    }
    Ok((inner_rad, outer_rad))
}

/// Cones may have been rounded to `f32`, in radians.
const ANGLE_SLACK_RAD: f64 = 2e-6;

/// The narrowest cone, in radians: a spot of 1 mm at a distance of 10 m.
const LEAST_CONE_RAD: f64 = 1e-4;
