//! A lamp of the TOML.

use toml::Value;
use umbrage::scene::{Lamp, LampKind};

use super::{bad, check, colour, unknown_key};
use crate::FormatError;

/// Half the angle of a spot that does not say, in degrees: what glTF takes.
const OUTER_DEGREES: f64 = 45.0;

/// A lamp of the TOML; `number` counts from 1.
pub(super) fn read_lamp(file: &str, number: usize, value: &Value) -> Result<Lamp, FormatError> {
    let place = format!("lamps, number {number}");
    let refuse = |what: String| bad(file, place.clone(), what);
    let Value::Table(table) = value else { return Err(refuse("is not a table".into())) };
    let known = ["name", "position", "direction", "intensity", "irradiance", "inner_degrees", "outer_degrees"];
    if let Some(key) = table.keys().find(|key| !known.contains(&key.as_str())) {
        return Err(bad(file, format!("{place}, {key}"), unknown_key(key, &known)));
    }
    let vector = |key: &str| match table.get(key) {
        None => Ok(None),
        Some(value @ Value::Array(_)) => {
            let vector = colour(value).filter(|vector| vector.is_finite());
            vector.map(Some).ok_or_else(|| refuse(format!("{key} is not three finite numbers")))
        }
        Some(_) => Err(refuse(format!("{key} is not three finite numbers"))),
    };
    let light = |key: &str| match table.get(key) {
        None => Ok(None),
        Some(value) => {
            let light =
                colour(value).ok_or_else(|| refuse(format!("{key} is neither a number nor a list of three")))?;
            check(light).map_err(|what| refuse(format!("{key} {what}")))?;
            Ok(Some(light))
        }
    };
    let degrees = |key: &str, default: f64| {
        let degrees = table.get(key).map_or(Some(default), |value| colour(value).map(|x| x.x));
        let fits = degrees.filter(|degrees| (0.0..=90.0).contains(degrees)).map(f64::to_radians);
        fits.ok_or_else(|| refuse(format!("{key} is not between 0 and 90")))
    };
    let direction = vector("direction")?
        .map(|direction| direction.try_normalize().ok_or_else(|| refuse("direction has no length".into())))
        .transpose()?;
    let kind = match (vector("position")?, direction, light("intensity")?, light("irradiance")?) {
        (Some(position_m), None, Some(intensity), None) => LampKind::Point { position_m, intensity, range_m: None },
        (Some(position_m), Some(direction), Some(intensity), None) => {
            let (inner_rad, outer_rad) = (degrees("inner_degrees", 0.0)?, degrees("outer_degrees", OUTER_DEGREES)?);
            if inner_rad > outer_rad || outer_rad == 0.0 {
                return Err(refuse("inner_degrees is more than outer_degrees, or that is 0".into()));
            }
            LampKind::Spot { position_m, direction, intensity, range_m: None, inner_rad, outer_rad }
        }
        (None, Some(direction), None, Some(irradiance)) => LampKind::Directional { direction, irradiance },
        _ => {
            let what = "should have either a position and an intensity, or a direction and an irradiance";
            return Err(refuse(what.into()));
        }
    };
    let name = match table.get("name") {
        None => format!("lamp {number}"),
        Some(Value::String(name)) => name.clone(),
        Some(_) => return Err(refuse("name is not a text".into())),
    };
    Ok(Lamp { name, kind })
}
