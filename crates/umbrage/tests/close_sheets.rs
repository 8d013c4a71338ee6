//! Sheets that lie closely one over another, parallel or at a tiny angle: what is covered is exactly dark, the other lit, and few
//! triangles tell it, however small the gap is, wherever the scene is, and whatever the lamp.
#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

use std::f64::consts::TAU;

mod common;

use common::build::{add, quad, room_faces};
use common::{irradiance_at, lit_triangles};
use glam::{DQuat, DVec2, DVec3};
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

/// A sheet of a heap: where its middle is, half its side and how it is turned, and its height over y = 0 as a linear function of x and z.
struct Sheet {
    middle: DVec2,
    half: DVec2,
    height_m: [f64; 3],
}

impl Sheet {
    /// Some of a heap whose sheets lie within `thick_m` of a plane, at places that are spread evenly and that no two runs change.
    fn of_heap(number: usize, thick_m: f64) -> Self {
        let spread =
            |k: usize| ((number + 1) as f64 * [0.6180, 0.7549, 0.5698, 0.8191, 0.6711, 0.4497, 0.3247][k]).fract();
        let turned = TAU * spread(2);
        Self {
            middle: 4.0 * DVec2::new(spread(0), spread(1)) - 2.0,
            half: (0.2 + 0.3 * spread(3)) * DVec2::from_angle(turned),
            height_m: [4, 5, 6].map(|k| thick_m * (2.0 * spread(k) - 1.0)),
        }
    }

    fn height_m(&self, at: DVec2) -> f64 {
        let [height_m, slope_x, slope_z] = self.height_m;
        let offset = at - self.middle;
        height_m + slope_x * offset.x + slope_z * offset.y
    }

    fn corners(&self) -> Vec<DVec3> {
        let (u, v) = (self.half, self.half.perp());
        let corners = [-u - v, v - u, u + v, u - v].map(|offset| self.middle + offset);
        corners.map(|at| DVec3::new(at.x, self.height_m(at), at.y)).to_vec()
    }

    /// How far a place is within the sheet, in metres.
    fn depth_m(&self, at: DVec2) -> f64 {
        let (offset, side) = (at - self.middle, self.half.length());
        side - (offset.dot(self.half) / side).abs().max((offset.perp_dot(self.half) / side).abs())
    }
}

/// Heights over each other that tell which sheet is on top, in metres: five times what counts as one plane in a scene of this size.
const APART_M: f64 = 2.5e-5;

/// Sheets that nearly lie in one plane cross at tiny angles. Most borders of what covers another were missed once, as the corners of both
/// told which is on top, wherever they are: up to 20,000 triangles for each sheet. Where all is within a few roundings of one plane
/// (1e-5) parts are still taken to lie in it that others are not.
#[test]
fn a_heap_of_sheets_that_nearly_lie_in_one_plane_takes_few_triangles() {
    for (thick_m, most_of_sheet) in [(1e-6, 10), (1e-5, 1000), (3e-5, 120), (1e-4, 120), (3e-4, 120)] {
        let sheets: Vec<Sheet> = (0..60).map(|number| Sheet::of_heap(number, thick_m)).collect();
        let mut scene = Scene::default();
        let grey = Material::diffuse("grey", Rgb::splat(0.5));
        add(&mut scene, grey, &sheets.iter().map(Sheet::corners).collect::<Vec<_>>());
        add(
            &mut scene,
            Material::emitting("lamp", Rgb::splat(10.0)),
            &[quad(5.0 * DVec3::Y, 0.2 * DVec3::X, 0.2 * DVec3::Z)],
        );
        let baked = bake(&scene, &BakeSettings::default(), Progress::silent()).unwrap();
        assert!(baked.report.triangles <= most_of_sheet * sheets.len(), "{thick_m}: {}", baked.report.triangles);
        let triangles = lit_triangles(&baked.mesh);
        let mut told = [0, 0];
        for (number, sheet) in sheets.iter().enumerate() {
            let at = sheet.middle;
            // Borders nearby and heights that count as equal say nothing.
            let others = || sheets.iter().enumerate().filter(|&(other, _)| other != number).map(|(_, other)| other);
            if others().any(|other| other.depth_m(at).abs() < 1e-2) {
                continue;
            }
            let over_m: Vec<f64> = others()
                .filter(|other| other.depth_m(at) > 0.0)
                .map(|other| other.height_m(at) - sheet.height_m(at))
                .collect();
            if over_m.iter().any(|over_m| over_m.abs() < APART_M) {
                continue;
            }
            // Where parts are taken to lie in the plane of another sheet, they are moved into it.
            let near = (-4..=4).filter_map(|step| {
                let height_m = sheet.height_m(at) + 2.5e-6 * f64::from(step);
                irradiance_at(&triangles, DVec3::new(at.x, height_m, at.y), DVec3::Y, 1.3e-6)
            });
            let light = near.map(|light| light.x).fold(0.0, f64::max);
            let is_covered = over_m.iter().any(|&over_m| over_m > 0.0);
            assert_eq!(light < DARK, is_covered, "{thick_m}: sheet {number}: {light}");
            told[usize::from(is_covered)] += 1;
        }
        assert!(thick_m < 1e-4 || told.iter().all(|&count| count > 3), "{thick_m}: {told:?}");
    }
}

/// Next to a ceiling, nearer than what is welded or a little farther, a panel has corners in common with a piece of it: what is laid on
/// another is shown, and a lamp is not lost.
#[test]
fn a_luminous_panel_a_few_roundings_before_a_ceiling_shines() {
    let on_floor = |gap_m: f64, half_m: f64| {
        let mut scene = Scene::default();
        let grey = |name: &str| Material::diffuse(name, Rgb::splat(0.5));
        add(&mut scene, grey("floor"), &[quad(DVec3::ZERO, 2.0 * DVec3::X, 2.0 * DVec3::Y)]);
        let above = |height_m: f64, half_m: f64| quad(height_m * DVec3::Z, half_m * DVec3::Y, half_m * DVec3::X);
        add(&mut scene, grey("ceiling"), &[above(3.0, half_m)]);
        add(&mut scene, Material::emitting("panel", Rgb::splat(10.0)), &[above(3.0 - gap_m, 0.3)]);
        let baked = bake(&scene, &BakeSettings::default(), Progress::silent()).unwrap();
        irradiance_at(&lit_triangles(&baked.mesh), DVec3::new(0.11, 0.07, 0.0), DVec3::Z, 1e-4).unwrap().x
    };
    // A panel of the size of the ceiling, too.
    for half_m in [2.0, 0.3] {
        let far_off = on_floor(1e-3, half_m);
        for gap_m in [0.0, 1e-6, 3e-6, 5e-6, 7e-6, 9e-6, 1.1e-5, 2e-5, 1e-4] {
            let light = on_floor(gap_m, half_m);
            assert!((light / far_off - 1.0).abs() < 0.02, "{gap_m} {half_m}: {light} is not {far_off}");
        }
    }
}
