//! A lit room and a dark one on one floor: the dark one is exactly dark, the lit one is lit up to the wall.

use glam::DVec3;
use umbrage::scene::{Material, Rgb, Scene};

use crate::baked;
use crate::common::build::{add, box_faces, quad, room_faces};
use crate::common::{Lit, irradiance_at};

const SIZE_M: DVec3 = DVec3::new(4.0, 3.0, 2.4);
/// Where the wall begins.
const WALL_M: f64 = 2.0;
/// Vertices are rounded by less.
const NEAR_M: f64 = 1e-6;

/// A house of one room, whose floor, ceiling and long walls are one polygon each, with a lamp on the one side of
/// `wall`, which parts it.
fn house(wall: &[Vec<DVec3>], double_sided: bool) -> Scene {
    let mut scene = Scene::default();
    add(&mut scene, Material::diffuse("house", Rgb::splat(0.6)), &room_faces(DVec3::ZERO, SIZE_M));
    add(&mut scene, Material { double_sided, ..Material::diffuse("wall", Rgb::splat(0.6)) }, wall);
    let lamp = quad(DVec3::new(1.0, 1.3, 2.3), 0.3 * DVec3::X, -0.2 * DVec3::Y);
    add(&mut scene, Material::emitting("lamp", Rgb::splat(10.0)), &[lamp]);
    scene
}

/// Holds the room behind a wall that ends at `end_m` against darkness.
fn is_dark_behind(scene: &Scene, end_m: f64) {
    let triangles = baked(scene).concat();
    let looks_into_the_lit_room =
        |t: &Lit| t.normal().x < -0.5 && t.corners.iter().all(|p| (p.x - end_m).abs() < NEAR_M);
    let is_behind = |t: &&Lit| t.corners.iter().all(|p| p.x > end_m - NEAR_M) && !looks_into_the_lit_room(t);
    let dark: Vec<&Lit> = triangles.iter().filter(is_behind).collect();
    let area: f64 = dark.iter().map(|t| t.area()).sum();
    let depth_m = SIZE_M.x - end_m;
    let whole = 2.0 * (depth_m * SIZE_M.y + depth_m * SIZE_M.z + SIZE_M.y * SIZE_M.z);
    assert!((area / whole - 1.0).abs() < 1e-4, "{area} of {whole} m2 of the dark room are shown");
    for triangle in dark {
        assert_eq!(triangle.irradiance, [DVec3::ZERO; 3], "at {:?}", triangle.corners);
    }
    let lit = |x: f64| irradiance_at(&triangles, DVec3::new(x, 1.3, 0.0), DVec3::Z, NEAR_M).unwrap().x;
    let (beside, before) = (lit(WALL_M - 0.001), lit(WALL_M - 0.2));
    assert!(beside > 0.8 * before && before > 0.0, "{beside} beside the wall, {before} before it");
}

#[test]
fn no_light_leaks_under_a_wall_of_5_cm() {
    let wall = box_faces(DVec3::new(WALL_M, 0.0, 0.0), DVec3::new(WALL_M + 0.05, SIZE_M.y, SIZE_M.z));
    is_dark_behind(&house(&wall, false), WALL_M + 0.05);
}

#[test]
fn no_light_leaks_under_a_wall_without_thickness() {
    let middle = 0.5 * DVec3::new(2.0 * WALL_M, SIZE_M.y, SIZE_M.z);
    let wall = quad(middle, 0.5 * SIZE_M.y * DVec3::Y, 0.5 * SIZE_M.z * DVec3::Z);
    is_dark_behind(&house(&[wall], true), WALL_M);
}
