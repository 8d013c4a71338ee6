//! Sheets that lie closely one over another, parallel or at a tiny angle: what is covered is exactly dark, the other lit, and few
//! triangles tell it, however small the gap is, wherever the scene is, and whatever the lamp.
#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

mod common;

use common::build::{add, quad, room_faces};
use common::{irradiance_at, lit_triangles};
use glam::{DQuat, DVec3};
use umbrage::bake::{BakeSettings, bake};
use umbrage::progress::Progress;
use umbrage::scene::{Lamp, LampKind, Material, Rgb, Scene};
use umbrage::shade::ShadeSettings;

/// Two sheets in a scene of its own.
#[derive(Clone, Copy, Debug)]
struct Pair {
    /// Between their middles, in metres.
    gap_m: f64,
    /// By which the upper is turned around the middle of both, in radians.
    angle_rad: f64,
    /// How large the upper is beside the lower.
    size: f64,
    double_sided: bool,
    /// Where the middle is, in metres.
    at_m: DVec3,
    lamp: Light,
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum Light {
    Bulb,
    Sun,
    Area,
}

/// Half the side of the lower sheet, in metres.
const HALF_M: f64 = 0.6;

fn turn() -> DQuat {
    DQuat::from_xyzw(0.3, -0.2, 0.4, 0.8).normalize()
}

impl Pair {
    /// The corner of the lower sheet's plane, its two axes and the normal.
    fn axes(&self) -> [DVec3; 3] {
        [DVec3::X, DVec3::Y, DVec3::Z].map(|axis| turn() * axis)
    }

    /// How far the upper sheet is over the lower, at a place along the first axis.
    fn height_m(&self, x: f64) -> f64 {
        self.gap_m + x * self.angle_rad.tan()
    }

    fn scene(&self) -> Scene {
        let [u, v, n] = self.axes();
        let mut scene = Scene::default();
        let grey =
            |name: &str| Material { double_sided: self.double_sided, ..Material::diffuse(name, Rgb::splat(0.5)) };
        add(&mut scene, grey("lower"), &[quad(self.at_m, HALF_M * u, HALF_M * v)]);
        let along = (u * self.angle_rad.cos() + n * self.angle_rad.sin()) * self.size * HALF_M;
        add(&mut scene, grey("upper"), &[quad(self.at_m + self.gap_m * n, along, self.size * HALF_M * v)]);
        let from_m = self.at_m + 1.5 * n + 0.4 * u + 0.3 * v;
        let kind = match self.lamp {
            Light::Bulb => Some(LampKind::Point { position_m: from_m, intensity: Rgb::ONE, range_m: None }),
            Light::Sun => {
                let direction = (self.at_m - from_m).normalize();
                Some(LampKind::Directional { direction, irradiance: Rgb::ONE })
            }
            Light::Area => None,
        };
        match kind {
            Some(kind) => {
                scene.lamps.push(Lamp { name: "lamp".to_owned(), kind });
            }
            None => add(&mut scene, Material::emitting("lamp", Rgb::splat(5.0)), &[quad(from_m, 0.2 * v, 0.2 * u)]),
        }
        scene
    }

    /// The most light that is shown where one covers the other, and the least where none does, as shares of what the middle gets
    /// without the other; and the number of triangles.
    fn baked(&self) -> (f64, f64, usize) {
        let baked = bake(&self.scene(), &BakeSettings::default(), Progress::silent()).unwrap();
        let triangles = lit_triangles(&baked.mesh);
        let [u, v, n] = self.axes();
        let (mut covered, mut lit) = (0.0_f64, f64::INFINITY);
        for (i, j) in (0..12).flat_map(|i| (0..12).map(move |j| (i, j))) {
            let [x, y] = [i, j].map(|k| 0.9 * self.size * HALF_M * (f64::from(k) / 5.5 - 1.0));
            let height_m = self.height_m(x);
            // Nothing is said of where the sheets meet, nor of sheets that are welded.
            if height_m.abs() < 7e-6 || (self.angle_rad > 0.0 && x.abs() < 0.06) {
                continue;
            }
            let at = |over_m: f64| irradiance_at(&triangles, self.at_m + x * u + y * v + over_m * n, n, 1e-7);
            covered = covered.max(at(height_m.min(0.0)).map_or(0.0, |light| light.x));
            lit = lit.min(at(height_m.max(0.0)).map_or(0.0, |light| light.x));
        }
        (covered, lit, baked.report.triangles)
    }
}

/// Light that is shown where it is covered is less than this, in W/m2: what a solution to 1e-4 of a thousandth may be off by, where a
/// lamp brings some tenths.
const DARK: f64 = 1e-6;

/// Gaps, in metres, and angles, in radians.
const GAPS: [(f64, f64); 9] = [
    (1e-6, 0.0),
    (3e-6, 0.0),
    (1e-5, 0.0),
    (1e-4, 0.0),
    (2e-4, 0.0),
    (0.0, 3e-5),
    (0.0, 1e-4),
    (1e-5, 3e-5),
    (1e-4, 1e-5),
];

/// Bakes pairs of all gaps, sizes and sides.
fn check(lamp: Light, at_m: DVec3, most_triangles: usize) {
    for double_sided in [false, true] {
        for (size, (gap_m, angle_rad)) in [1.0, 0.7].into_iter().flat_map(|size| GAPS.map(|gap| (size, gap))) {
            let pair = Pair { gap_m, angle_rad, size, double_sided, at_m, lamp };
            let (covered, lit, triangles) = pair.baked();
            assert!(covered < DARK && lit > 0.05, "{pair:?}: {covered} covered, {lit} lit");
            assert!(triangles <= most_triangles, "{pair:?}: {triangles} triangles");
        }
    }
}

const FAR_M: DVec3 = DVec3::new(100.0, -60.0, 80.0);

#[test]
fn under_a_bulb_one_of_two_close_sheets_is_dark() {
    check(Light::Bulb, DVec3::ZERO, 800);
    check(Light::Bulb, FAR_M, 800);
}

#[test]
fn under_a_sun_one_of_two_close_sheets_is_dark() {
    check(Light::Sun, DVec3::ZERO, 800);
    check(Light::Sun, FAR_M, 800);
}

#[test]
fn under_an_area_lamp_one_of_two_close_sheets_is_dark() {
    check(Light::Area, FAR_M, 3000);
}

#[test]
fn a_wall_that_stands_a_fraction_of_a_millimetre_behind_another_gets_no_light() {
    let mut scene = Scene::default();
    let grey = |name: &str| Material::diffuse(name, Rgb::splat(0.6));
    add(&mut scene, grey("room"), &room_faces(DVec3::ZERO, DVec3::new(12.0, 8.0, 3.0)));
    // Both look back along x; one lies before the middle of the other.
    let wall = |x: f64, half_m: f64| quad(DVec3::new(x, 4.0, 1.5), half_m * DVec3::NEG_Y, 1.2 * DVec3::Z);
    add(&mut scene, grey("behind"), &[wall(6.84032, 3.0)]);
    add(&mut scene, grey("before"), &[wall(6.83965, 2.0)]);
    let lamp = quad(DVec3::new(3.0, 4.0, 2.99), 0.3 * DVec3::X, -0.3 * DVec3::Y);
    add(&mut scene, Material::emitting("lamp", Rgb::splat(10.0)), &[lamp]);
    let position_m = DVec3::new(4.0, 2.0, 1.0);
    let kind = LampKind::Point { position_m, intensity: Rgb::ONE, range_m: None };
    scene.lamps.push(Lamp { name: "bulb".to_owned(), kind });
    let shade = ShadeSettings { tolerance: 0.05, ..ShadeSettings::default() };
    let baked = bake(&scene, &BakeSettings { shade, ..BakeSettings::default() }, Progress::silent()).unwrap();
    let triangles = lit_triangles(&baked.mesh);
    let at = |x: f64, y: f64, z: f64| irradiance_at(&triangles, DVec3::new(x, y, z), DVec3::NEG_X, 1e-4);
    for (y, z) in (0..15).flat_map(|i| (0..9).map(move |j| (2.05 + 0.278 * f64::from(i), 0.35 + 0.28 * f64::from(j)))) {
        let behind = at(6.84032, y, z).map_or(0.0, |light| light.x);
        let before = at(6.83965, y, z).map_or(0.0, |light| light.x);
        assert!(behind < DARK && before > 0.05, "{behind} behind, {before} before, at {y} {z}");
    }
    assert!(at(6.84032, 1.5, 1.5).unwrap().x > 0.05, "beside the one before it is lit");
    assert!(baked.report.triangles < 20_000, "{}", baked.report.triangles);
}
