//! Whole bakes of small bright places on large faces: circles of spots, bulbs next to surfaces, light through a hole. What is
//! expected is known from the side of the lamp: its flux, and the solid angle of what it shines through.
#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

mod common;

use std::f64::consts::PI;

use common::build::{add, box_faces, quad, room_faces};
use common::{Lit, lit_triangles};
use glam::DVec3;
use proptest::prelude::*;
use umbrage::bake::{Bake, BakeSettings, GatherKind, bake};
use umbrage::progress::Progress;
use umbrage::scene::{Lamp, LampKind, Material, Rgb, Scene};
use umbrage::shade::{LampDefect, ShadeSettings};

fn baked(scene: &Scene, tolerance: f64) -> Bake {
    baked_by(GatherKind::default(), scene, tolerance)
}

fn baked_by(gather: GatherKind, scene: &Scene, tolerance: f64) -> Bake {
    let default = BakeSettings::default();
    let settings = BakeSettings { gather, shade: ShadeSettings { tolerance, ..default.shade }, ..default };
    bake(scene, &settings, Progress::silent()).unwrap()
}

/// A room of six quads that looks inward.
fn room(size_m: DVec3, reflectance: f64) -> Scene {
    let mut scene = Scene::default();
    add(&mut scene, Material::diffuse("wall", Rgb::splat(reflectance)), &room_faces(DVec3::ZERO, size_m));
    scene
}

fn bulb(position_m: DVec3) -> Lamp {
    Lamp { name: "bulb".into(), kind: LampKind::Point { position_m, intensity: Rgb::ONE, range_m: None } }
}

fn spot(position_m: DVec3, direction: DVec3, cones_rad: [f64; 2]) -> Lamp {
    let [inner_rad, outer_rad] = cones_rad;
    let (direction, range_m) = (direction.normalize(), None);
    let kind = LampKind::Spot { position_m, direction, intensity: Rgb::ONE, range_m, inner_rad, outer_rad };
    Lamp { name: "spot".into(), kind }
}

/// Flux that triangles show, of those that are admitted, in W of each colour.
fn flux_w(bake: &Bake, admits: impl Fn(&Lit) -> bool) -> f64 {
    let shown = lit_triangles(&bake.mesh).into_iter().filter(admits);
    shown.map(|t| t.area() * t.irradiance.iter().map(|e| e.x).sum::<f64>() / 3.0).sum()
}

#[test]
fn a_spot_on_a_large_floor_brings_it_all_that_it_gives() {
    for (degrees, x) in [(1.0_f64, 1.3), (5.0, -2.7), (20.0, 0.0)] {
        let mut scene = Scene::default();
        let floor = quad(DVec3::ZERO, 4.0 * DVec3::X, 4.0 * DVec3::Y);
        add(&mut scene, Material::diffuse("floor", Rgb::splat(0.5)), &[floor]);
        let outer_rad = degrees.to_radians();
        scene.lamps.push(spot(DVec3::new(x, 0.4, 3.0), DVec3::new(0.1, 0.0, -1.0), [0.5 * outer_rad, outer_rad]));
        let bake = baked(&scene, 0.05);
        let (sent_w, shown_w) = (scene.lamps.first().unwrap().flux_w().unwrap().x, flux_w(&bake, |_| true));
        assert!((shown_w / sent_w - 1.0).abs() < 0.02, "{shown_w} of {sent_w} W at {degrees} degrees");
        assert!(bake.report.energy.error().abs() < 2e-3);
        let account = &bake.report.lamps[0];
        assert!((account.sent_w.x / sent_w - 1.0).abs() < 0.01 && account.defect().is_none(), "{account:?}");
    }
}

#[test]
fn a_bulb_that_touches_a_ceiling_lights_the_floor_as_one_beside_it() {
    let size_m = DVec3::new(4.0, 3.0, 5.0);
    let mean_of_floor = |below_m: f64| {
        let mut scene = room(size_m, 0.5);
        scene.lamps.push(bulb(DVec3::new(2.1, 1.4, size_m.z - below_m)));
        let bake = baked(&scene, 0.01);
        let report = &bake.report;
        assert!(report.triangles <= 20_000, "{} triangles at {below_m} m", report.triangles);
        assert!(report.energy.error().abs() < 2e-3, "{} at {below_m} m", report.energy.error());
        assert!(report.lamps[0].defect().is_none(), "{:?}", report.lamps[0]);
        flux_w(&bake, |t| t.normal().z > 0.9) / 12.0
    };
    let truth = mean_of_floor(0.01);
    for below_m in [2e-7, 1e-6, 1e-5, 1e-4, 1e-3, 5e-3] {
        let found = mean_of_floor(below_m);
        assert!((found / truth - 1.0).abs() < 0.01, "{found} is not {truth} at {below_m} m");
    }
}

#[test]
fn bulbs_on_surfaces_in_edges_and_in_corners_send_and_bring_as_much() {
    let size_m = DVec3::new(4.0, 3.0, 5.0);
    for d in [2e-7, 1e-5, 1e-4, 1e-3, 1e-2] {
        let ceiling = size_m.z - d;
        for at_m in [DVec3::new(1.7, 1.4, ceiling), DVec3::new(1.7, d, ceiling), DVec3::new(d, d, ceiling)] {
            let mut scene = room(size_m, 0.5);
            scene.lamps.push(bulb(at_m));
            let report = baked(&scene, 0.02).report;
            let account = &report.lamps[0];
            assert!(report.triangles <= 20_000, "{} triangles at {at_m}", report.triangles);
            assert!((account.received_w.x / account.sent_w.x - 1.0).abs() < 0.05, "{account:?} at {at_m}");
            // What is reflected, too.
            assert!(report.energy.error().abs() < 0.05, "{} at {at_m}", report.energy.error());
        }
    }
}

#[test]
fn lamps_on_edges_and_in_corners_light_what_is_before_them() {
    // A bulb in the corner of a room has an eighth of its sphere; one on the edge of a box in a room, three quarters; on the face of
    // it, half.
    let mut corner = room(DVec3::splat(3.0), 0.0);
    corner.lamps.push(bulb(DVec3::ZERO));
    let mut with_box = room(DVec3::splat(3.0), 0.0);
    let case = box_faces(DVec3::splat(1.0), DVec3::new(2.0, 2.0, 1.5));
    add(&mut with_box, Material::diffuse("case", Rgb::ZERO), &case);
    let mut on_face = with_box.clone();
    with_box.lamps.push(bulb(DVec3::new(1.4, 2.0, 1.5)));
    on_face.lamps.push(spot(DVec3::new(1.4, 1.6, 1.5), DVec3::Z, [0.3, 0.6]));
    let on_walls = |t: &Lit| t.corners.iter().any(|p| p.min_element() < 1e-3 || p.max_element() > 2.999);
    let of_spot = on_face.lamps.first().unwrap().flux_w().unwrap().x;
    for (scene, expected) in [(corner, 0.5 * PI), (with_box, 3.0 * PI), (on_face, of_spot)] {
        let bake = baked(&scene, 0.02);
        let account = &bake.report.lamps[0];
        assert!(bake.report.triangles <= 20_000, "{} triangles", bake.report.triangles);
        assert!((account.received_w.x / account.sent_w.x - 1.0).abs() < 0.05, "{account:?}");
        assert!(account.escaped_w.x + account.on_backs_w.x < 0.01 * account.sent_w.x, "{account:?}");
        // In the corner, the other seven eighths of the sphere go into the walls that it touches.
        let shown = if scene.surfaces.len() == 1 {
            flux_w(&bake, |t| t.corners.iter().all(|p| p.max_element() > 2.999))
        } else {
            flux_w(&bake, on_walls)
        };
        assert!((shown / expected - 1.0).abs() < 0.03, "{shown} is not {expected}");
    }
}

#[test]
fn all_accent_spots_of_a_hall_are_lit() {
    let mut scene = room(DVec3::new(20.0, 30.0, 5.0), 0.4);
    for i in 0..12 {
        let position_m = DVec3::new(3.0 + 4.7 * f64::from(i % 4), 4.0 + 9.1 * f64::from(i / 4), 4.9);
        scene.lamps.push(spot(position_m, DVec3::new(0.3, 0.1 * f64::from(i), -1.0), [0.01, 0.06]));
    }
    let bake = baked(&scene, 0.05);
    for account in &bake.report.lamps {
        assert!(account.error().abs() < 0.05 && account.defect().is_none(), "{account:?}");
    }
}

/// A black hall with a thin wall that has a hole of 20 cm, 1 m before a lamp at (1, 1.5, 1.5). Its end on the side of the lamp reflects.
fn behind_a_hole(of_end: f64) -> Scene {
    let mut scene = Scene::default();
    let [z0, z1, y0, y1, end, x1] = <[_; 6]>::try_from(room_faces(DVec3::ZERO, DVec3::new(8.0, 3.0, 3.0))).unwrap();
    add(&mut scene, Material::diffuse("hall", Rgb::ZERO), &[z0, z1, y0, y1, x1]);
    add(&mut scene, Material::diffuse("end", Rgb::splat(of_end)), &[end]);
    let panel = |low: [f64; 2], high: [f64; 2]| {
        let at = |y: f64, z: f64| DVec3::new(2.0, y, z);
        vec![at(low[0], low[1]), at(high[0], low[1]), at(high[0], high[1]), at(low[0], high[1])]
    };
    let panels =
        [([0.0, 0.0], [3.0, 1.4]), ([0.0, 1.6], [3.0, 3.0]), ([0.0, 1.4], [1.4, 1.6]), ([1.6, 1.4], [3.0, 1.6])];
    let wall = Material { double_sided: true, ..Material::diffuse("wall", Rgb::ZERO) };
    add(&mut scene, wall, &panels.map(|(low, high)| panel(low, high)));
    scene
}

fn is_beyond_the_hole(t: &Lit) -> bool {
    t.corners.iter().all(|p| p.x > 1.999) && t.corners.iter().any(|p| p.x > 2.001)
}

#[test]
fn light_through_a_hole_arrives() {
    let (half, root) = (0.1_f64, 1.01_f64.sqrt());
    let mut of_bulb = behind_a_hole(0.0);
    of_bulb.lamps.push(bulb(DVec3::new(1.0, 1.5, 1.5)));
    let solid_angle = 4.0 * (half * half / (1.0 + 2.0 * half * half).sqrt()).atan();
    let mut of_led = behind_a_hole(0.0);
    let (side_m, exitance) = (0.01, 100.0);
    let led = quad(DVec3::new(1.0, 1.5, 1.5), 0.5 * side_m * DVec3::Y, 0.5 * side_m * DVec3::Z);
    add(&mut of_led, Material::emitting("led", Rgb::splat(exitance / PI)), &[led]);
    // Lambert's factor of a point under the middle of the hole.
    let factor = 4.0 / (2.0 * PI) * 2.0 * half / root * (half / root).atan();
    for (scene, expected) in [(of_bulb, solid_angle), (of_led, exitance * side_m * side_m * factor)] {
        let shown = flux_w(&baked(&scene, 0.02), is_beyond_the_hole);
        assert!((shown / expected - 1.0).abs() < 0.03, "{shown} is not {expected}");
    }
}

#[test]
fn light_that_a_small_circle_reflects_through_a_hole_arrives() {
    let (reflectance, from_m, half_rad) = (0.5, 1.9, 0.05_f64);
    // Radiosity of the circle is that of a spot of 1 W/sr, and its light goes through the hole at 2 m.
    for (y, z) in [(1.5, 1.5), (2.3, 1.9), (0.7, 2.4)] {
        let mut scene = behind_a_hole(reflectance);
        scene.lamps.push(spot(DVec3::new(from_m, y, z), DVec3::NEG_X, [half_rad, half_rad * (1.0 + 1e-9)]));
        let even = |i: usize, n: usize| (i as f64 + 0.5) / n as f64;
        let radius_m = from_m * half_rad.tan();
        let of_circle = (0..400).map(|i| {
            let (away_m, (sine, cosine)) = (radius_m * even(i, 400).sqrt(), (2.4 * i as f64).sin_cos());
            let squared_m2 = from_m * from_m + away_m * away_m;
            let radiance = reflectance / PI * from_m / squared_m2.powf(1.5);
            let of_hole = (0..400).map(|j| {
                let [v, w] = [1.4 + 0.2 * even(j / 20, 20), 1.4 + 0.2 * even(j % 20, 20)];
                let across_m2 = (v - y - away_m * cosine).powi(2) + (w - z - away_m * sine).powi(2);
                4.0 / (4.0 + across_m2).powi(2)
            });
            radiance * of_hole.sum::<f64>() * 0.04 / 400.0
        });
        let expected = of_circle.sum::<f64>() * PI * radius_m * radius_m / 400.0;
        // Of its own light the spot beyond may err by ten tolerances.
        for gather in [GatherKind::Faces, GatherKind::Regression] {
            let bake = baked_by(gather, &scene, 0.02);
            let shown = flux_w(&bake, is_beyond_the_hole);
            assert!((shown / expected - 1.0).abs() < 0.1, "{shown} is not {expected} for {gather:?} at {y}, {z}");
            assert!(bake.report.triangles < 10_000, "{} triangles for {gather:?}", bake.report.triangles);
            assert!(bake.report.energy.error().abs() < 1e-2, "{} for {gather:?}", bake.report.energy.error());
        }
    }
}

#[test]
fn a_lamp_that_lights_nothing_is_told() {
    let mut scene = room(DVec3::splat(2.0), 0.5);
    scene.lamps.push(bulb(DVec3::splat(1.0)));
    scene.lamps.push(spot(DVec3::new(1.0, 1.0, 9.0), DVec3::Z, [0.1, 0.2]));
    let bake = baked(&scene, 0.05);
    let defects: Vec<_> = bake.report.lamps.iter().map(umbrage::shade::LampAccount::defect).collect();
    assert_eq!(defects, [None, Some(LampDefect::LightsNothing)]);
    assert_eq!(bake.report.lamps[1].escaped_w, bake.report.lamps[1].sent_w);
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(12))]
    #[test]
    fn what_a_spot_sends_into_a_room_is_shown_or_told(
        degrees in 1.0..60.0_f64, inner in 0.0..0.95_f64,
        at in (0.02..0.98_f64, 0.02..0.98_f64, 0.02..0.98_f64), aim in (-1.0..1.0_f64, -1.0..1.0_f64, -1.0..1.0_f64),
    ) {
        let size_m = DVec3::new(6.0, 4.0, 3.0);
        let direction = DVec3::from(aim);
        prop_assume!(direction.length() > 0.1);
        let mut scene = room(size_m, 0.5);
        let outer_rad = degrees.to_radians();
        scene.lamps.push(spot(size_m * DVec3::from(at), direction, [inner * outer_rad, outer_rad]));
        let bake = baked(&scene, 0.03);
        let account = &bake.report.lamps[0];
        prop_assert!(account.escaped_w.x + account.on_backs_w.x <= 1e-9, "{:?}", account);
        let is_right = (account.received_w.x / scene.lamps.first().unwrap().flux_w().unwrap().x - 1.0).abs() < 0.05;
        prop_assert!(is_right || account.defect().is_some(), "{:?}", account);
        // The bake itself may be told to be wrong; it should not be.
        prop_assert!(is_right, "{:?}", account);
    }
}
