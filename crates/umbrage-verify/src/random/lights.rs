//! Lights of a random scene: lamps without extent, and sheets and boxes that emit.

use std::collections::BTreeSet;
use std::f64::consts::PI;

use glam::{DQuat, DVec3};
use umbrage::scene::{Lamp, LampKind, Material, Rgb};

use super::numbers::Numbers;
use super::room::{self, space_m};
use super::shapes::{self, Thing};

/// So many lamps are many.
const MANY: usize = 12;

/// The same lamp, so many times brighter, if it has a place.
pub(super) fn brighter(mut lamp: Lamp, times: f64) -> Lamp {
    match &mut lamp.kind {
        LampKind::Point { intensity, .. } | LampKind::Spot { intensity, .. } => *intensity *= times,
        LampKind::Directional { .. } => {}
    }
    lamp
}

/// Lamps of all kinds; those with extent are added to the things. There is always a light.
pub(super) fn lamps(
    numbers: &mut Numbers,
    most: usize,
    things: &mut Vec<Thing>,
    traits: &mut BTreeSet<&'static str>,
) -> Vec<Lamp> {
    if numbers.chance(0.5) {
        for _ in 0..numbers.count(4) {
            let light = area_light(numbers, traits);
            things.push(light);
        }
        if numbers.chance(0.5) {
            return Vec::new();
        }
    }
    let count = numbers.count(most);
    if count > MANY {
        traits.insert("many lamps");
    }
    (0..count).map(|number| lamp(numbers, number, count, things, traits)).collect()
}

/// A light colour of about this brightness, without a dark channel.
fn light(numbers: &mut Numbers, low: f64, high: f64) -> Rgb {
    let bright = numbers.log_between(low, high);
    if numbers.chance(0.6) {
        Rgb::splat(bright)
    } else {
        bright * Rgb::new(1.0, numbers.between(0.3, 1.0), numbers.between(0.3, 1.0))
    }
}

/// A sheet, a disc or a box that emits.
fn area_light(numbers: &mut Numbers, traits: &mut BTreeSet<&'static str>) -> Thing {
    let size_m = numbers.log_between(0.01, 1.0);
    let half = DVec3::new(size_m, 0.2 * size_m, size_m * numbers.between(0.2, 1.0));
    let (thing, area_m2, double_sided) = match numbers.below(4) {
        0 => (shapes::block(half), 8.0 * (half.x * half.y + half.y * half.z + half.z * half.x), false),
        1 => (shapes::disc(3 + numbers.below(6), [size_m; 2]), PI * size_m * size_m, numbers.chance(0.4)),
        _ => (shapes::rectangle(half.x, half.z), 4.0 * half.x * half.z, numbers.chance(0.4)),
    };
    traits.insert(if double_sided { "double-sided light" } else { "area light" });
    let radiance = light(numbers, 3.0, 60.0) / (PI * area_m2);
    let reflectance = if numbers.chance(0.5) { Rgb::ZERO } else { numbers.colour(0.9) };
    let material = Material { radiance, reflectance, double_sided, ..Material::diffuse("light", Rgb::ZERO) };
    // Most lights look down.
    let down = DQuat::from_rotation_x(PI);
    let turn = if numbers.chance(0.6) { numbers.turn(true) * down } else { numbers.turn(false) };
    let (middle, half) = space_m();
    let mut at = middle + 0.9 * numbers.point(half);
    if numbers.chance(0.3) {
        // In, or just under, the ceiling.
        at.y = room::HEIGHT_M - numbers.gap_m();
    }
    thing.named("light").of(material).moved(turn, at)
}

fn lamp(
    numbers: &mut Numbers,
    number: usize,
    count: usize,
    things: &[Thing],
    traits: &mut BTreeSet<&'static str>,
) -> Lamp {
    let position_m = position_m(numbers, things, traits);
    let direction =
        if numbers.chance(0.6) { (numbers.direction() - 2.0 * DVec3::Y).normalize() } else { numbers.direction() };
    let intensity = light(numbers, 1.0, 20.0) / count as f64;
    let range_m = numbers.chance(0.2).then(|| {
        traits.insert("range");
        numbers.log_between(0.1, 20.0)
    });
    let kind = match numbers.below(10) {
        0..5 => LampKind::Point { position_m, intensity, range_m },
        5..8 => {
            let outer_rad = numbers.log_between(1.0, 90.0).to_radians();
            traits.insert(if outer_rad < 0.2 { "narrow spot" } else { "spot" });
            let hard = numbers.chance(0.25);
            if hard {
                traits.insert("hard spot");
            }
            let inner_rad = if hard { outer_rad } else { numbers.between(0.0, 0.99) * outer_rad };
            LampKind::Spot { position_m, direction, intensity, range_m, inner_rad, outer_rad }
        }
        _ => {
            traits.insert("sun");
            LampKind::Directional { direction, irradiance: light(numbers, 0.3, 10.0) / count as f64 }
        }
    };
    Lamp { name: format!("lamp {number}"), kind }
}

/// A place in the room, near or on a surface or its border, or in the middle of a thing.
fn position_m(numbers: &mut Numbers, things: &[Thing], traits: &mut BTreeSet<&'static str>) -> DVec3 {
    let (middle, half) = space_m();
    let choice = numbers.below(20);
    if choice < 14 || things.is_empty() {
        return middle + 0.98 * numbers.point(half);
    }
    let thing = &things[numbers.below(things.len())];
    if choice < 16 {
        traits.insert("lamp in a thing");
        return thing.middle_m();
    }
    let corners = thing.corners_m(numbers.below(thing.polygons.len()));
    let normal = (corners[1] - corners[0]).cross(corners[2] - corners[0]).normalize_or_zero();
    let (s, t) = match numbers.below(4) {
        // A corner, an edge, or within.
        0 => (0.0, 0.0),
        1 => (numbers.between(0.0, 1.0), 0.0),
        _ => (numbers.between(0.05, 0.45), numbers.between(0.05, 0.45)),
    };
    let on = corners[0] + s * (corners[1] - corners[0]) + t * (corners[2] - corners[0]);
    let away_m = match numbers.below(4) {
        0 => 0.0,
        1 => 3e-13,
        _ => numbers.log_between(1e-6, 0.1),
    };
    traits.insert(if away_m < 1e-9 { "lamp on a surface" } else { "lamp near a surface" });
    on + away_m * normal
}
