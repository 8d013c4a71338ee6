//! A switch plate on a wall, exactly on it and 1 mm off: the wall around it keeps its light, and behind it is dark.

use glam::DVec3;
use umbrage::scene::{Material, Rgb, Scene};

use crate::build::{add, baked, box_faces, mean, quad};
use crate::common::irradiance_at;
use crate::exact::{Place, irradiance};

/// Half the side of the plate, and its thickness.
const PLATE_M: [f64; 2] = [0.04, 0.01];
/// Its middle on the wall.
const MIDDLE: DVec3 = DVec3::new(0.0, 0.0, 1.1);

/// Holds the light of the wall around a plate `gap_m` off it against exact light.
fn keeps_the_light_around(gap_m: f64) {
    let [half, thick] = PLATE_M;
    let plate = box_faces(MIDDLE + DVec3::new(gap_m, -half, -half), MIDDLE + DVec3::new(gap_m + thick, half, half));
    let lamp = quad(DVec3::new(0.9, 0.2, 2.3), 0.2 * DVec3::X, -0.2 * DVec3::Y);
    let mut scene = Scene::default();
    let wall = quad(DVec3::new(0.0, 0.0, 1.2), 1.5 * DVec3::Y, 1.2 * DVec3::Z);
    add(&mut scene, Material::diffuse("wall", Rgb::ZERO), &[wall]);
    add(&mut scene, Material::diffuse("plate", Rgb::ZERO), &plate);
    add(&mut scene, Material::emitting("lamp", Rgb::splat(10.0)), std::slice::from_ref(&lamp));
    let triangles = baked(&scene);
    let wall_mean = mean(triangles.iter().filter(|t| t.normal().x > 0.9 && t.corners.iter().all(|p| p.x == 0.0)));
    let exact = |place| irradiance(place, &lamp, std::f64::consts::PI * 10.0, &plate) / wall_mean;
    for side in [DVec3::Y, -DVec3::Y, DVec3::Z, -DVec3::Z] {
        let along = side.cross(DVec3::X);
        for away in [-0.03, -0.01, -0.005, -0.0005, 0.0005, 0.001, 0.002, 0.005, 0.01, 0.02, 0.05, 0.1] {
            let mut line = format!("gap {gap_m} {side} {away:+.4}: ");
            for t in [-0.029, -0.011, 0.013, 0.031] {
                let place = Place { point: MIDDLE + (half + away) * side + t * along, normal: DVec3::X };
                let got = irradiance_at(&triangles, place.point, place.normal, 1e-4).map(|e| e.x / wall_mean);
                line += &format!(" {:.3}/{:.3}", got.unwrap_or(-1.0), exact(place));
            }
            println!("{line}");
        }
    }
}

#[test]
fn the_wall_keeps_its_light_around_a_switch_plate_on_it() {
    keeps_the_light_around(0.0);
}

#[test]
fn the_wall_keeps_its_light_around_a_switch_plate_1_mm_off_it() {
    keeps_the_light_around(0.001);
}
