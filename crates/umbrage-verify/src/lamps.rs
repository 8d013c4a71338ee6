//! Lamps without extent, as paths meet them: off the surfaces that they lie on, and from their own side where they nearly touch one.
//!
//! A lamp within rounding of a surface is before it, as the baker promises: rays would pass it on both sides of a sheet, or on none. One
//! at the height `h` over a surface lights a spot of about the size of `h` with half of its flux. No ray from elsewhere finds that spot
//! by chance, so light that a lamp throws on what is nearer to it than a share of the scene is sampled from the lamp: a direction, the
//! place that it meets, and its connection with the vertex of the path. So is all light of narrow spots. (Paths from both ends: Lafortune and Willems, *Bi-directional path
//! tracing*, 1993.) Every path of light is counted once, by where its first place from the lamp is.

use std::f64::consts::{PI, TAU};

use fastrand::Rng;
use glam::DVec3;
use umbrage::scene::{Lamp, LampKind, Scene};

use crate::tracer::Tracer;

/// Places nearer to a lamp than this share of the extent are found from the lamp: beyond, light is even enough to be found by chance. With
/// a tenth of it, a bulb 10 um under a ceiling takes a hundred times as many paths.
const NEAR_OF_EXTENT: f64 = 0.02;
/// All that spots of less than this are aimed at is found from them: a thirtieth of a hemisphere.
const NARROW_RAD: f64 = 0.25;
/// How far before a surface a lamp stands that lies on it, in lengths within which things touch.
const BEFORE_OF_TOUCHING: f64 = 2.0;
/// A lamp farther than this from a sheet of two sides is on one of them, in the same lengths; nearer, it is before the front.
const ON_A_SIDE_OF_TOUCHING: f64 = 0.1;
/// Normals with a cosine below this look opposite ways.
const OPPOSITE: f64 = -0.999;

/// A lamp.
pub(crate) struct PlacedLamp {
    pub(crate) lamp: Lamp,
    /// What is nearer to it than this is found from it, in metres; 0 where nothing is.
    pub(crate) near_m: f64,
}

/// Returns the lamps of a scene.
pub(crate) fn lamps(scene: &Scene, tracer: &Tracer) -> Vec<PlacedLamp> {
    let placed = |lamp: &Lamp| {
        let mut lamp = lamp.clone();
        let (LampKind::Point { position_m, .. } | LampKind::Spot { position_m, .. }) = &mut lamp.kind else {
            return PlacedLamp { lamp, near_m: 0.0 };
        };
        *position_m = before_surfaces(scene, tracer, *position_m);
        let near_m = NEAR_OF_EXTENT * tracer.extent_m;
        let is_near = tracer.triangles.iter().any(|triangle| triangle.distance_m(*position_m) < near_m);
        let near_m = if is_narrow(&lamp) {
            f64::INFINITY
        } else if is_near {
            near_m
        } else {
            0.0
        };
        PlacedLamp { lamp, near_m }
    };
    scene.lamps.iter().map(placed).collect()
}

/// Whether a lamp is a spot whose circles of light are too small to be found by chance.
fn is_narrow(lamp: &Lamp) -> bool {
    matches!(lamp.kind, LampKind::Spot { outer_rad, .. } if outer_rad < NARROW_RAD)
}

/// Moves a point before all sides that it lies on.
fn before_surfaces(scene: &Scene, tracer: &Tracer, point_m: DVec3) -> DVec3 {
    let touching_m = tracer.touching_m;
    let (mut moved_m, mut pushed) = (point_m, Vec::<DVec3>::new());
    for triangle in tracer.triangles.iter().filter(|triangle| triangle.distance_m(point_m) < touching_m) {
        let height_m = triangle.normal.dot(point_m - triangle.corner_m);
        let is_behind =
            scene.materials[triangle.material].double_sided && height_m < -ON_A_SIDE_OF_TOUCHING * touching_m;
        let normal = if is_behind { -triangle.normal } else { triangle.normal };
        if pushed.iter().all(|other| other.dot(normal) > OPPOSITE) {
            let height_m = normal.dot(moved_m - triangle.corner_m);
            moved_m += (BEFORE_OF_TOUCHING * touching_m - height_m).max(0.0) * normal;
            pushed.push(normal);
        }
    }
    moved_m
}

/// Returns a direction in which a lamp may shine, evenly over these, and the solid angle of them all; `None` for a distant one.
pub(crate) fn direction(lamp: &Lamp, rng: &mut Rng) -> Option<(DVec3, f64)> {
    let (axis, least_cosine) = match lamp.kind {
        LampKind::Point { .. } => (DVec3::Z, -1.0),
        LampKind::Spot { direction, outer_rad, .. } => (direction, outer_rad.cos()),
        LampKind::Directional { .. } => return None,
    };
    let cosine = 1.0 - rng.f64() * (1.0 - least_cosine);
    let (sine, (turn_sine, turn_cosine)) = ((1.0 - cosine * cosine).max(0.0).sqrt(), (TAU * rng.f64()).sin_cos());
    let (u, v) = axis.any_orthonormal_pair();
    let towards = cosine * axis + sine * (turn_cosine * u + turn_sine * v);
    Some((towards, 2.0 * PI * (1.0 - least_cosine)))
}
