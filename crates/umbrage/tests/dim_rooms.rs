//! Dim rooms beside a lit one: light through a slit and past an ajar door. What falls there is little of the mean light and is all that
//! there is to see, so it must be right as a share of itself. The reference is exact: the part of the lamp that is seen through what is
//! open, by half-spaces through the point, and Lambert's sum over its edges.
#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

mod common;

use common::build::{add, box_faces, quad, room_faces};
use common::{Lit, irradiance_at, lit_triangles};
use glam::DVec3;
use umbrage::bake::{BakeSettings, bake};
use umbrage::progress::Progress;
use umbrage::scene::{Material, Rgb, Scene};

const RADIANCE: f64 = 10.0;
/// Points along a side of each face that is looked at.
const SIDE: u32 = 200;

/// Two rooms of 4 x 4 x 3 m that look inward, one lit by a lamp of 0.5 m under its ceiling, and between them a wall of 10 cm with a slit.
struct Slit {
    width_m: f64,
}

impl Slit {
    fn lamp() -> Vec<DVec3> {
        quad(DVec3::new(-2.0, 0.0, 2.99), 0.25 * DVec3::Y, 0.25 * DVec3::X)
    }

    fn scene(&self) -> Scene {
        let mut scene = Scene::default();
        let half_m = 0.5 * self.width_m;
        let part = |y: [f64; 2], z: [f64; 2]| box_faces(DVec3::new(-0.1, y[0], z[0]), DVec3::new(0.0, y[1], z[1]));
        let mut faces = room_faces(DVec3::new(-4.0, -2.0, 0.0), DVec3::new(4.0, 2.0, 3.0));
        faces.extend(part([-2.0, -half_m], [0.0, 3.0]));
        faces.extend(part([half_m, 2.0], [0.0, 3.0]));
        faces.extend(part([-half_m, half_m], [2.0, 3.0]));
        add(&mut scene, Material::diffuse("black", Rgb::ZERO), &faces);
        add(&mut scene, Material::emitting("lamp", Rgb::splat(RADIANCE)), &[Self::lamp()]);
        scene
    }

    /// Direct irradiance at a point of the dim room.
    fn exact(&self, at: DVec3, normal: DVec3) -> f64 {
        let half_m = 0.5 * self.width_m;
        let mut seen = Self::lamp();
        for x in [-0.1, 0.0] {
            let corner = |y: f64, z: f64| DVec3::new(x, y, z);
            let open = [corner(-half_m, 0.0), corner(half_m, 0.0), corner(half_m, 2.0), corner(-half_m, 2.0)];
            let middle = corner(0.0, 1.0) - at;
            for i in 0..4 {
                let [from, to] = [open[i] - at, open[(i + 1) % 4] - at];
                let side = from.cross(to);
                let side = if side.dot(middle) < 0.0 { -side } else { side };
                seen = clipped(&seen, |p| side.dot(p - at));
            }
        }
        lambert(&clipped(&seen, |p| normal.dot(p - at)), at, normal)
    }
}

/// The part of a polygon where `side` is positive.
fn clipped(polygon: &[DVec3], side: impl Fn(DVec3) -> f64) -> Vec<DVec3> {
    let mut part = Vec::new();
    for (i, &from) in polygon.iter().enumerate() {
        let to = polygon[(i + 1) % polygon.len()];
        let [here, there] = [side(from), side(to)];
        if here >= 0.0 {
            part.push(from);
        }
        if (here >= 0.0) != (there >= 0.0) {
            part.push(from.lerp(to, here / (here - there)));
        }
    }
    part
}

/// Irradiance from a polygon of the lamp's radiance.
fn lambert(polygon: &[DVec3], at: DVec3, normal: DVec3) -> f64 {
    let edge = |i: usize| {
        let [u, v] = [polygon[i] - at, polygon[(i + 1) % polygon.len()] - at];
        let across = u.cross(v);
        across.length().atan2(u.dot(v)) * normal.dot(across.normalize_or_zero())
    };
    0.5 * RADIANCE * (0..polygon.len()).map(edge).sum::<f64>().abs()
}

/// Root mean square of the relative errors at even points of the dim room's floor and far wall, where there is more than a thousandth of
/// the mean light.
fn error_of_own_light(slit: &Slit, lit: &[Lit]) -> f64 {
    let flux = |t: &Lit| t.area() * t.irradiance.iter().map(|e| e.x).sum::<f64>() / 3.0;
    let mean = lit.iter().map(flux).sum::<f64>() / lit.iter().map(Lit::area).sum::<f64>();
    let (mut sum, mut count) = (0.0, 0.0);
    for (i, j) in (0..SIDE).flat_map(|i| (0..SIDE).map(move |j| (i, j))) {
        let [u, v] = [i, j].map(|k| (f64::from(k) + 0.37) / f64::from(SIDE));
        let floor = (DVec3::new(4.0 * u, 4.0 * v - 2.0, 0.0), DVec3::Z);
        let wall = (DVec3::new(4.0, 4.0 * u - 2.0, 3.0 * v), DVec3::NEG_X);
        for (at, normal) in [floor, wall] {
            let exact = slit.exact(at, normal);
            if exact > 1e-3 * mean {
                let shown = irradiance_at(lit, at, normal, 1e-6).unwrap().x;
                sum += (shown / exact - 1.0).powi(2);
                count += 1.0;
            }
        }
    }
    assert!(count > 1000.0, "{count} points are lit");
    (sum / count).sqrt()
}

#[test]
fn what_falls_through_a_slit_is_right_as_a_share_of_itself() {
    for (width_m, most) in [(0.01, 0.13), (0.02, 0.1), (0.05, 0.1)] {
        let slit = Slit { width_m };
        let bake = bake(&slit.scene(), &BakeSettings::default(), Progress::silent()).unwrap();
        let error = error_of_own_light(&slit, &lit_triangles(&bake.mesh));
        assert!(error < most, "{error} behind {width_m} m");
        assert!(bake.report.triangles < 12_000, "{} triangles", bake.report.triangles);
    }
}
