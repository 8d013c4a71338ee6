//! Where a room stands, what unit it is in and whether its parts touch or miss each other by a micrometre makes no difference
//! to its light.
#![allow(clippy::unwrap_used, reason = "a failure here is a failed test")]

mod common;

use common::build::{add, box_faces, quad, room_faces};
use common::{Lit, degenerate, extent, irradiance_at, lit_triangles, t_vertices};
use glam::DVec3;
use umbrage::bake::{BakeSettings, bake};
use umbrage::progress::Progress;
use umbrage::scene::{Material, Rgb, Scene};
use umbrage::shade::ShadeSettings;

/// How much the light may differ, as a share of its mean: rounding may cut a triangle elsewhere.
const SAME: f64 = 0.01;

/// A room with a lamp, a block on its floor and one against its wall, both `gap_m` away from what they touch.
fn room(gap_m: f64) -> Scene {
    let mut scene = Scene::default();
    add(&mut scene, Material::diffuse("room", Rgb::splat(0.5)), &room_faces(DVec3::ZERO, DVec3::new(4.0, 2.5, 3.0)));
    let on_floor = box_faces(DVec3::new(1.0, gap_m, 1.0), DVec3::new(1.7, 0.9, 1.8));
    let on_wall = box_faces(DVec3::new(2.5, 1.0, gap_m), DVec3::new(3.5, 1.2, 0.4));
    add(&mut scene, Material::diffuse("block", Rgb::new(0.6, 0.4, 0.2)), &[on_floor, on_wall].concat());
    let lamp = quad(DVec3::new(2.0, 2.3, 1.5), DVec3::X * 0.4, DVec3::Z * 0.3);
    add(&mut scene, Material::emitting("lamp", Rgb::splat(8.0)), &[lamp]);
    scene
}

fn baked(scene: &Scene) -> Vec<Lit> {
    let shade = ShadeSettings { tolerance: 0.05, ..ShadeSettings::default() };
    let baked = bake(scene, &BakeSettings { shade, ..BakeSettings::default() }, Progress::silent()).unwrap();
    let triangles = lit_triangles(&baked.mesh);
    // In the frame of the mesh: far from the origin, `f64` would be tried and not the mesh.
    let frame = baked.mesh.origin_m;
    let near: Vec<Lit> =
        triangles.iter().map(|t| Lit { corners: t.corners.map(|corner| corner - frame), ..*t }).collect();
    let eps = 1e-6 * extent(&near);
    assert_eq!((t_vertices(&near, eps).len(), degenerate(&near, eps)), (0, 0));
    triangles
}

/// The mean difference of the light of two bakes, as a share of the mean; a point of the first is at `to` of it in the other.
fn difference(one: &[Lit], other: &[Lit], to: impl Fn(DVec3) -> DVec3) -> f64 {
    let eps = 1e-4 * extent(other);
    let (mut sum, mut off, mut area, mut seen) = (DVec3::ZERO, DVec3::ZERO, 0.0, 0.0);
    for triangle in one {
        let middle = triangle.corners.iter().sum::<DVec3>() / 3.0;
        let light = triangle.irradiance.iter().sum::<DVec3>() / 3.0;
        area += triangle.area();
        let Some(there) = irradiance_at(other, to(middle), triangle.normal(), eps) else { continue };
        seen += triangle.area();
        sum += triangle.area() * light;
        off += triangle.area() * (there - light).abs();
    }
    assert!(seen > 0.999 * area, "{seen} of {area} m2 are in both");
    off.element_sum() / sum.element_sum()
}

fn moved(mut scene: Scene, to: impl Fn(DVec3) -> DVec3) -> Scene {
    scene.surfaces.iter_mut().flat_map(|surface| &mut surface.positions_m).for_each(|p| *p = to(*p));
    scene
}

#[test]
fn a_room_a_kilometre_away_has_the_same_light() {
    let to = |p: DVec3| p + DVec3::new(1000.3, -20.1, 999.7);
    let off = difference(&baked(&room(0.0)), &baked(&moved(room(0.0), to)), to);
    assert!(off < SAME, "{off}");
}

#[test]
fn a_room_a_thousand_times_as_large_or_small_has_the_same_light() {
    let here = baked(&room(0.0));
    for scale in [1000.0, 0.001] {
        let to = |p: DVec3| scale * p;
        let off = difference(&here, &baked(&moved(room(0.0), to)), to);
        assert!(off < SAME, "{scale}: {off}");
    }
}

#[test]
fn gaps_of_a_micrometre_are_none() {
    let here = baked(&room(0.0));
    for gap_m in [1e-6, -1e-6] {
        let off = difference(&here, &baked(&room(gap_m)), |p| p);
        assert!(off < SAME, "{gap_m}: {off}");
    }
}
