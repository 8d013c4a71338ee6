//! A room or a floor, and things that stand on it, lean, touch, overlap or nearly touch. +Y is up, the floor is at height 0.

use std::collections::BTreeSet;
use std::f64::consts::FRAC_PI_2;

use glam::{DQuat, DVec3};
use umbrage::scene::Material;

use super::numbers::Numbers;
use super::shapes::{self, Thing};

/// Half the width of the room, in metres.
const HALF_WIDTH_M: f64 = 3.0;
/// Height of the room, in metres.
pub(super) const HEIGHT_M: f64 = 3.0;
/// Things are at most so large from their middle on, in metres.
const LARGEST_M: f64 = 1.0;
/// Gaps narrower than this are welded, in metres: 4 millionths of the largest scene, of which the baker welds 3.
const HAIR_M: f64 = 3e-5;
/// Places are multiples of this where things shall touch, in metres.
const GRID_M: f64 = 0.5;

/// Middle of the room and half its size, in metres.
pub(super) fn space_m() -> (DVec3, DVec3) {
    let half = DVec3::new(HALF_WIDTH_M, 0.5 * HEIGHT_M, HALF_WIDTH_M);
    (half.y * DVec3::Y, half)
}

/// The room and what is in it: at least one thing.
pub(super) fn things(numbers: &mut Numbers, most: usize, traits: &mut BTreeSet<&'static str>) -> Vec<Thing> {
    let mut things = frame(numbers, traits);
    let count = numbers.count(most).max(things.len() + usize::from(things.is_empty()));
    while things.len() < count {
        let thing = match numbers.below(20) {
            // What lies in the plane of the floor, or before a side of a thing that is there.
            0 => overlap(numbers, traits),
            1..4 if !things.is_empty() => before(numbers, &things, traits),
            _ => standing(numbers, traits),
        };
        things.push(thing);
    }
    things
}

fn paint(numbers: &mut Numbers, thing: Thing, double_sided: f64, traits: &mut BTreeSet<&'static str>) -> Thing {
    let double_sided = numbers.chance(double_sided);
    if double_sided {
        traits.insert("double-sided");
    }
    let material = Material { double_sided, ..Material::diffuse(thing.name, numbers.colour(0.9)) };
    thing.of(material)
}

/// A closed room, one without some of its sides, a floor, or nothing.
fn frame(numbers: &mut Numbers, traits: &mut BTreeSet<&'static str>) -> Vec<Thing> {
    let (middle, half) = space_m();
    let mut room = shapes::block(half).turned_inside_out().moved(DQuat::IDENTITY, middle).named("room");
    let thing = match numbers.below(8) {
        0..3 => {
            traits.insert("closed room");
            room
        }
        3..5 => {
            traits.insert("open room");
            for _ in 0..1 + numbers.below(3) {
                // The floor, which is the third, stays.
                let side = [0, 1, 3, 4, 5].map(|side: usize| side.min(room.polygons.len() - 1))[numbers.below(5)];
                room.polygons.remove(side);
            }
            room
        }
        5..7 => {
            traits.insert("floor");
            shapes::rectangle(HALF_WIDTH_M, HALF_WIDTH_M).named("floor")
        }
        _ => return Vec::new(),
    };
    vec![paint(numbers, thing, 0.3, traits)]
}

/// A thing on the floor, nearly on it, or leaning in the air.
fn standing(numbers: &mut Numbers, traits: &mut BTreeSet<&'static str>) -> Thing {
    let mut size = || numbers.log_between(0.03, LARGEST_M);
    let [x, y, z] = [size(), size(), size()];
    let (thing, double_sided, upright) = match numbers.below(12) {
        0..4 => (shapes::block(DVec3::new(x, y, z)), 0.3, true),
        4..7 => {
            // A sheet on edge, or lying.
            let sheet = shapes::rectangle(x, z);
            let turn = if numbers.chance(0.7) { DQuat::from_rotation_x(FRAC_PI_2) } else { DQuat::IDENTITY };
            (sheet.moved(turn, DVec3::ZERO), 0.8, true)
        }
        7 => {
            traits.insert("smooth");
            let (around, rings) = (3 + numbers.below(8), 2 + numbers.below(5));
            (shapes::sphere(x, around, rings), 0.3, true)
        }
        8 => {
            traits.insert("smooth");
            let cylinder = shapes::cylinder(x, y, 3 + numbers.below(12));
            let inside = numbers.chance(0.2);
            (if inside { cylinder.turned_inside_out() } else { cylinder }, 0.5, true)
        }
        9 => {
            traits.insert("needle");
            (shapes::needle(x, numbers.log_between(1e-5, 0.1)), 0.6, false)
        }
        _ => {
            let corners = numbers.log_between(3.0, 201.0) as usize;
            if corners > 24 {
                traits.insert("many corners");
            }
            // A star has an even number of corners.
            let star = numbers.chance(0.3) && corners > 5;
            let corners = if star { corners - corners % 2 } else { corners };
            let inner = if star { numbers.between(0.3, 0.9) * x } else { x };
            (shapes::disc(corners, [x, inner]), 0.6, false)
        }
    };
    let leans = numbers.chance(if upright { 0.25 } else { 0.6 });
    if leans {
        traits.insert("leaning");
    }
    let thing = thing.moved(numbers.turn(!leans), DVec3::ZERO);
    let (middle, half) = space_m();
    let mut at = numbers.point(half - DVec3::splat(0.1));
    if numbers.chance(0.3) {
        at = (at / GRID_M).round() * GRID_M;
    }
    let floats = leans && numbers.chance(0.6);
    at.y = if floats { middle.y + at.y } else { gap_m(numbers, traits) - thing.low_m() };
    paint(numbers, thing.moved(DQuat::IDENTITY, at), double_sided, traits)
}

fn gap_m(numbers: &mut Numbers, traits: &mut BTreeSet<&'static str>) -> f64 {
    let gap_m = numbers.gap_m();
    if gap_m > 0.0 {
        traits.insert(if gap_m < HAIR_M { "gap of a hair" } else { "narrow gap" });
    }
    gap_m
}

/// A sheet in the plane of the floor.
fn overlap(numbers: &mut Numbers, traits: &mut BTreeSet<&'static str>) -> Thing {
    traits.insert("overlap");
    let sheet = shapes::rectangle(numbers.log_between(0.1, 2.0), numbers.log_between(0.1, 2.0));
    let (_, half) = space_m();
    let at = numbers.point(half) * DVec3::new(1.0, 0.0, 1.0);
    let sheet = sheet.moved(numbers.turn(true), at);
    let sheet = if numbers.chance(0.2) { sheet.turned_inside_out() } else { sheet };
    paint(numbers, sheet, 0.3, traits)
}

/// A copy of a polygon that is there, at a narrow gap before or behind it or in its place.
fn before(numbers: &mut Numbers, things: &[Thing], traits: &mut BTreeSet<&'static str>) -> Thing {
    let original = &things[numbers.below(things.len())];
    let corners = original.corners_m(numbers.below(original.polygons.len()));
    let normal = corners.windows(2).map(|p| (p[0] - corners[0]).cross(p[1] - corners[0])).sum::<DVec3>();
    let gap_m = gap_m(numbers, traits);
    if gap_m == 0.0 {
        traits.insert("overlap");
    }
    let middle = corners.iter().sum::<DVec3>() / corners.len() as f64;
    let size = if numbers.chance(0.5) { 1.0 } else { numbers.between(0.2, 1.0) };
    let side = if numbers.chance(0.3) { -1.0 } else { 1.0 };
    let shift = side * gap_m * normal.normalize_or_zero();
    let mut copy = original.clone().named("copy");
    copy.normals.clear();
    copy.polygons = vec![(0..corners.len() as u32).collect()];
    copy.positions_m = corners.iter().map(|p| middle + size * (p - middle) + shift).collect();
    let copy = if numbers.chance(0.3) { copy.turned_inside_out() } else { copy };
    paint(numbers, copy, 0.4, traits)
}
