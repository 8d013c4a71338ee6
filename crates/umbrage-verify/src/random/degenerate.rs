//! Tiny degenerate scenes: a few polygons that overlap in one plane, cross a hair apart, are there twice, reversed, slivers or needles, or meet
//! inside an edge; emitters that cross them, and bulbs and spots on corners, edges and faces.
//!
//! ```text
//! polygon on a grid -> others made from it (copy, shift by a hair, turn about an edge, sliver beside) -> lights on what is there
//! ```
//!
//! Holds: polygons are plane; there is a light; nothing is promised of anything else.

use std::collections::BTreeSet;

use glam::{DQuat, DVec3};
use umbrage::scene::{Lamp, LampKind, Material, Rgb};

use super::numbers::Numbers;
use super::shapes::{self, Thing};

/// Polygons beside emitters, at least and at most.
const POLYGONS: [usize; 2] = [5, 14];
/// Corners lie on a grid of so many steps of a quarter of a metre each way.
const GRID: usize = 8;
const STEP_M: f64 = 0.25;
/// A hair, in metres: from what welds to what can be seen.
const HAIRS_M: [f64; 6] = [0.0, 3e-13, 1e-9, 1e-6, 1e-5, 1e-3];

/// Polygons and lamps of a scene.
pub(super) fn things(numbers: &mut Numbers, traits: &mut BTreeSet<&'static str>) -> (Vec<Thing>, Vec<Lamp>) {
    let mut things = vec![plain(numbers, traits)];
    let count = POLYGONS[0] + numbers.below(POLYGONS[1] - POLYGONS[0] + 1);
    while things.len() < count {
        let thing = if numbers.chance(0.3) { plain(numbers, traits) } else { made_from(numbers, &things, traits) };
        things.push(thing);
    }
    let emitters = numbers.below(3);
    for _ in 0..emitters {
        let emitter = emitter(numbers, &things, traits);
        things.push(emitter);
    }
    let count = numbers.below(3).max(usize::from(emitters == 0));
    let lamps = (0..count).map(|number| lamp(numbers, number, &things, traits)).collect();
    (things, lamps)
}

fn hair_m(numbers: &mut Numbers) -> f64 {
    HAIRS_M[numbers.below(HAIRS_M.len())]
}

fn on_grid(numbers: &mut Numbers) -> DVec3 {
    DVec3::from([(); 3].map(|()| STEP_M * numbers.below(GRID) as f64))
}

fn grey(numbers: &mut Numbers, thing: Thing) -> Thing {
    let double_sided = numbers.chance(0.3);
    thing.of(Material { double_sided, ..Material::diffuse("grey", Rgb::splat(0.5)) })
}

/// A polygon of these corners.
fn polygon(name: &'static str, corners_m: Vec<DVec3>) -> Thing {
    let all = (0..corners_m.len() as u32).collect();
    Thing { positions_m: corners_m, polygons: vec![all], ..shapes::rectangle(1.0, 1.0).named(name) }
}

/// A triangle or a parallelogram on the grid, or a needle.
fn plain(numbers: &mut Numbers, traits: &mut BTreeSet<&'static str>) -> Thing {
    if numbers.chance(0.15) {
        traits.insert("needle");
        let width_m = hair_m(numbers).max(1e-7);
        let needle = shapes::needle(numbers.between(0.1, 2.0), width_m);
        let (turn, at) = (numbers.turn(false), on_grid(numbers));
        return grey(numbers, needle.moved(turn, at));
    }
    let mut corners_m = [(); 3].map(|()| on_grid(numbers)).to_vec();
    if numbers.chance(0.5) {
        corners_m.push(corners_m[0] + corners_m[2] - corners_m[1]);
    }
    if numbers.chance(0.3) {
        // Flat on the ground, as others are: planes are shared.
        corners_m.iter_mut().for_each(|p| p.y = 0.0);
        traits.insert("one plane");
    }
    let thing = polygon("sheet", corners_m);
    grey(numbers, thing)
}

fn normal_of(corners_m: &[DVec3]) -> DVec3 {
    corners_m.windows(2).map(|p| (p[0] - corners_m[0]).cross(p[1] - corners_m[0])).sum::<DVec3>().normalize_or_zero()
}

/// A polygon that lies to one that is there as none should.
fn made_from(numbers: &mut Numbers, things: &[Thing], traits: &mut BTreeSet<&'static str>) -> Thing {
    let mut corners_m = things[numbers.below(things.len())].corners_m(0);
    let normal = normal_of(&corners_m);
    let middle_m = corners_m.iter().sum::<DVec3>() / corners_m.len() as f64;
    let hair_m = hair_m(numbers) * if numbers.chance(0.5) { 1.0 } else { -1.0 };
    let (a, b) = (corners_m[0], corners_m[1]);
    let kind = match numbers.below(6) {
        0 => {
            corners_m.iter_mut().for_each(|p| *p += hair_m * normal);
            "twice, a hair apart"
        }
        1 => {
            // About its own plane: it crosses it in a line a hair off.
            let axis = (b - a).normalize_or(DVec3::X);
            let turn = DQuat::from_axis_angle(axis, numbers.log_between(1e-6, 1.0));
            corners_m.iter_mut().for_each(|p| *p = middle_m + turn * (*p - middle_m) + hair_m * normal);
            "crossing at a small angle"
        }
        2 => {
            let size = numbers.between(0.2, 1.5);
            let shift = (b - a) * numbers.between(-0.7, 0.7);
            corners_m.iter_mut().for_each(|p| *p = middle_m + size * (*p - middle_m) + shift);
            "overlap in one plane"
        }
        3 => {
            let along = numbers.between(0.1, 0.9);
            let out = (b - a).cross(normal).normalize_or(DVec3::Y);
            corners_m = vec![b, a, a.lerp(b, along) + (hair_m.abs() + 1e-6) * out];
            "sliver on an edge"
        }
        4 => {
            // From the middle of an edge: a T-vertex of the input.
            let [from, to] = [numbers.between(0.1, 0.5), numbers.between(0.5, 0.9)];
            let up = numbers.direction();
            corners_m = vec![a.lerp(b, from) + hair_m * normal, a.lerp(b, to), a.lerp(b, 0.5) + up];
            "inside an edge"
        }
        _ => {
            let other_m = things[numbers.below(things.len())].corners_m(0);
            corners_m = vec![a, other_m[0], other_m[1] + hair_m * normal, b];
            corners_m.truncate(3);
            "between corners"
        }
    };
    traits.insert(kind);
    if numbers.chance(0.4) {
        traits.insert("reversed");
        corners_m.reverse();
    }
    grey(numbers, polygon("copy", corners_m))
}

/// A place on a polygon: a corner, a point of an edge or of the inside, with the polygon's normal.
fn place(numbers: &mut Numbers, things: &[Thing], traits: &mut BTreeSet<&'static str>) -> (DVec3, DVec3) {
    let corners_m = things[numbers.below(things.len())].corners_m(0);
    let normal = normal_of(&corners_m).try_normalize().unwrap_or(DVec3::Y);
    let (s, t, kind) = match numbers.below(3) {
        0 => (0.0, 0.0, "light on a corner"),
        1 => (numbers.between(0.0, 1.0), 0.0, "light on an edge"),
        _ => (numbers.between(0.1, 0.4), numbers.between(0.1, 0.4), "light on a face"),
    };
    traits.insert(kind);
    (corners_m[0] + s * (corners_m[1] - corners_m[0]) + t * (corners_m[2] - corners_m[0]), normal)
}

/// A small sheet that emits, around a place of what is there, in its plane or across it.
fn emitter(numbers: &mut Numbers, things: &[Thing], traits: &mut BTreeSet<&'static str>) -> Thing {
    let (at_m, normal) = place(numbers, things, traits);
    let size_m = numbers.log_between(0.003, 0.5);
    let turn = numbers.turn(false);
    let at_m =
        if numbers.chance(0.3) { at_m + numbers.between(0.0, 0.5) * normal } else { at_m + hair_m(numbers) * normal };
    let radiance = Rgb::splat(1.0 / (size_m * size_m));
    let double_sided = numbers.chance(0.3);
    let material = Material { radiance, double_sided, ..Material::diffuse("light", Rgb::ZERO) };
    traits.insert("emitter across a face");
    shapes::rectangle(size_m, size_m).named("light").of(material).moved(turn, at_m)
}

fn lamp(numbers: &mut Numbers, number: usize, things: &[Thing], traits: &mut BTreeSet<&'static str>) -> Lamp {
    let (at_m, normal) = place(numbers, things, traits);
    let off_m = if numbers.chance(0.3) { numbers.between(0.05, 1.0) } else { hair_m(numbers) };
    let (position_m, intensity) = (at_m + off_m * normal, Rgb::ONE);
    let kind = match numbers.below(5) {
        0..3 => LampKind::Point { position_m, intensity, range_m: None },
        3 => {
            let outer_rad = numbers.log_between(1.0, 90.0).to_radians();
            let inner_rad = numbers.between(0.0, 0.95) * outer_rad;
            let direction = if numbers.chance(0.5) { -normal } else { numbers.direction() };
            LampKind::Spot { position_m, direction, intensity, range_m: None, inner_rad, outer_rad }
        }
        _ => LampKind::Directional { direction: numbers.direction(), irradiance: intensity },
    };
    Lamp { name: format!("lamp {number}"), kind }
}
