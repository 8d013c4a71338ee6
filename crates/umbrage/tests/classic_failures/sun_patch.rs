//! A patch of sun on a floor lights a ceiling past a plate: the shadow in reflected light, of a source without edges of
//! its own.

use glam::{DVec2, DVec3};
use umbrage::bake::BakeSettings;
use umbrage::scene::{Lamp, LampKind, Material, Rgb, Scene};
use umbrage::shade::ShadeSettings;

use crate::baked_with;
use crate::common::build::{add, box_faces, quad};
use crate::exact::{Place, irradiance, rms};

/// Half a side of the room, how high it is, and half a side of the hole in its ceiling.
const ROOM_M: [f64; 2] = [2.0, 2.0];
const HOLE_M: f64 = 0.25;
/// Irradiance by the sun, which stands in the zenith, in W/m2, and what the floor reflects.
const SUN: f64 = 1000.0;
const REFLECTANCE: f64 = 0.8;

/// A plate under the ceiling; each number has another, turned against the hole by up to `most_turned_rad`.
fn plate(number: usize, most_turned_rad: f64) -> Vec<Vec<DVec3>> {
    // Additive recurrence with powers of the root of x^6 = x + 1: even in five dimensions.
    let at = |k: i32| (0.5 + number as f64 * 1.134_724_138_4_f64.powi(-1 - k)).fract();
    let turn = DVec2::from_angle(most_turned_rad * at(0));
    let middle_m = DVec3::new(0.4 + 0.4 * at(1), -0.2 + 0.4 * at(1), 1.0 + 0.85 * at(2));
    let half_m = DVec3::new(0.03 + 0.25 * at(3), 0.03 + 0.1 * at(4), 0.01);
    let place = |p: DVec3| turn.rotate(p.truncate()).extend(p.z) + middle_m;
    box_faces(-half_m, half_m).iter().map(|face| face.iter().map(|&p| place(p)).collect()).collect()
}

/// A floor that reflects, and a ceiling with a hole and the plate, which do not.
fn room(plate: &[Vec<DVec3>]) -> Scene {
    let [half_m, height_m] = ROOM_M;
    let mut scene = Scene::default();
    let around = [[1.0, 0.0], [0.0, 1.0], [-1.0, 0.0], [0.0, -1.0]].map(|[x, y]| {
        let (out, along) = (DVec2::new(x, y), DVec2::new(-y, x));
        let corners = [HOLE_M * (out - along), HOLE_M * (out + along), half_m * (out + along), half_m * (out - along)];
        corners.map(|corner| corner.extend(height_m)).to_vec()
    });
    add(&mut scene, Material::diffuse("ceiling", Rgb::ZERO), &around);
    add(&mut scene, Material::diffuse("plate", Rgb::ZERO), plate);
    let floor = quad(DVec3::ZERO, half_m * DVec3::X, half_m * DVec3::Y);
    add(&mut scene, Material::diffuse("floor", Rgb::splat(REFLECTANCE)), &[floor]);
    let sun = LampKind::Directional { direction: -DVec3::Z, irradiance: Rgb::splat(SUN) };
    scene.lamps.push(Lamp { name: "sun".into(), kind: sun });
    scene
}

/// Places on the ceiling, close together around the plates' shadows.
fn on_the_ceiling() -> Vec<Place> {
    let all = (0..2500).map(|k| (-1.9 + 0.0777 * f64::from(k % 50), -1.9 + 0.0777 * f64::from(k / 50))).step_by(3);
    let shadows = (0..6400).map(|k| (0.4 + 0.0163 * f64::from(k % 80), -0.5 + 0.0163 * f64::from(k / 80))).step_by(7);
    let beside_the_hole = |&(x, y): &(f64, f64)| x.abs().max(y.abs()) > HOLE_M + 0.01;
    let places = all.chain(shadows).filter(beside_the_hole);
    places.map(|(x, y)| Place { point: DVec3::new(x, y, ROOM_M[1]), normal: -DVec3::Z }).collect()
}

/// Mean logarithms, over rooms with different plates, of triangles and error of the ceiling with cuts along shadows in
/// reflected light over those without; and the standard error of that of their product. Error falls as triangles grow
/// in number.
fn gains(plates: usize, most_turned_rad: f64, tolerance: f64) -> ([f64; 2], f64) {
    let places = on_the_ceiling();
    let of_plate = |number: usize| {
        let plate = plate(number, most_turned_rad);
        let [with, without] = [true, false].map(|secondary_sources| {
            let shade = ShadeSettings { tolerance, ..ShadeSettings::default() };
            let settings = BakeSettings { secondary_sources, shade, ..BakeSettings::default() };
            let ceiling = baked_with(&room(&plate), settings).swap_remove(0);
            // The patch of sun is a square of even exitance.
            let sun = quad(DVec3::ZERO, HOLE_M * DVec3::X, HOLE_M * DVec3::Y);
            [ceiling.len() as f64, rms(&ceiling, &places, |place| irradiance(place, &sun, REFLECTANCE * SUN, &plate))]
        });
        [0, 1].map(|i| (with[i] / without[i]).ln())
    };
    let all: Vec<[f64; 2]> = (0..plates).map(of_plate).collect();
    let n = plates as f64;
    let mean = [0, 1].map(|i| all.iter().map(|logs| logs[i]).sum::<f64>() / n);
    let spread = all.iter().map(|[p, q]| (p + q - mean[0] - mean[1]).powi(2)).sum::<f64>() / n;
    (mean, (spread / n).sqrt())
}

#[test]
fn cuts_along_shadows_of_plates_that_are_parallel_to_a_patch_of_sun_pay() {
    let ([triangles, error], _) = gains(4, 0.0, 0.01);
    // Nearly half of triangles times error was saved with ten plates; a fifth must be with four.
    assert!(triangles + error < -0.2, "{triangles} {error}");
}

#[test]
#[ignore = "two hundred bakes: a measurement for docs/events.md"]
fn cuts_along_shadows_in_the_light_of_a_patch_of_sun_measured() {
    let percent = |log: f64| 100.0 * log.exp_m1();
    for (name, most_turned_rad) in [("parallel", 0.0), ("turned", 3.0)] {
        for tolerance in [0.01, 0.003, 0.002, 0.001] {
            let ([triangles, error], deviation) = gains(12, most_turned_rad, tolerance);
            println!(
                "{name} plates, tolerance {tolerance}: triangles {:+.0} %, error {:+.0} %, both {:+.0} +- {:.0} %",
                percent(triangles),
                percent(error),
                percent(triangles + error),
                100.0 * deviation
            );
        }
    }
}
