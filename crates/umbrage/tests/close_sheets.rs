//! Sheets that lie closely one over another, parallel or at a tiny angle: what is covered is exactly dark, the other lit, and few
//! triangles tell it, however small the gap is, wherever the scene is, and whatever the lamp.
#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

mod common;

use common::build::{add, quad};
use common::{irradiance_at, lit_triangles};
use glam::{DQuat, DVec3};
use umbrage::bake::{BakeSettings, bake};
use umbrage::progress::Progress;
use umbrage::scene::{Lamp, LampKind, Material, Rgb, Scene};

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
        let grey = |name: &str| Material {
            double_sided: self.double_sided,
            ..Material::diffuse(name, Rgb::splat(0.5))
        };
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

    /// What is wrong with the bake, and how many triangles it has.
    fn judged(&self) -> (Vec<String>, usize) {
        let baked = bake(&self.scene(), &BakeSettings::default(), Progress::silent()).unwrap();
        let triangles = lit_triangles(&baked.mesh);
        let [u, v, n] = self.axes();
        let mut wrong = Vec::new();
        for (i, j) in (0..12).flat_map(|i| (0..12).map(move |j| (i, j))) {
            let [x, y] = [i, j].map(|k| 0.9 * self.size * HALF_M * (f64::from(k) / 5.5 - 1.0));
            let height_m = self.height_m(x);
            // Nothing is said of where the sheets meet.
            if x.abs() < 0.06 && self.angle_rad != 0.0 {
                continue;
            }
            let covered = self.at_m + x * u + y * v + height_m.min(0.0) * n;
            let lit = self.at_m + x * u + y * v + height_m.max(0.0) * n;
            // Both may be found within a gap of a millimetre: the brighter is the upper.
            let at = |point: DVec3| irradiance_at(&triangles, point, n, 1e-7).map(|light| light.x);
            if at(covered).is_some_and(|light| light > 0.0) && (lit - covered).length() > 4e-6 {
                wrong.push(format!("{:?} at covered {x} {y}", at(covered)));
            }
            if !at(lit).is_some_and(|light| light > 0.0) && (lit - covered).length() > 4e-6 {
                wrong.push(format!("{:?} at lit {x} {y}", at(lit)));
            }
        }
        (wrong, baked.report.triangles)
    }
}

#[test]
fn explore() {
    for lamp in [Light::Bulb, Light::Sun, Light::Area] {
        for at_m in [DVec3::ZERO, DVec3::new(100.0, -60.0, 80.0)] {
            for double_sided in [false, true] {
                for size in [1.0, 0.7] {
                    for (gap_m, angle_rad) in [(1e-6, 0.0), (3e-6, 0.0), (1e-5, 0.0), (1e-4, 0.0), (2e-4, 0.0), (0.0, 1e-5), (0.0, 1e-4), (0.0, 1e-3), (1e-5, 3e-5), (1e-4, 1e-5)] {
                        let pair = Pair { gap_m, angle_rad, size, double_sided, at_m, lamp };
                        let (wrong, triangles) = pair.judged();
                        println!("{lamp:?} far {} double {double_sided} size {size} gap {gap_m:e} angle {angle_rad:e}: {triangles} triangles, wrong {} {:?}", at_m.x > 0.0, wrong.len(), wrong.first());
                    }
                }
            }
        }
    }
}
