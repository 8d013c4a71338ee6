//! Bakes of smooth surfaces against paths: both by the interpolated normal, each by its own way to the definition.
#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

use std::f64::consts::{PI, TAU};
use std::ops::ControlFlow;

use glam::DVec3;
use umbrage::bake::{BakeSettings, bake};
use umbrage::id::{MaterialId, NodeId};
use umbrage::progress::Progress;
use umbrage::scene::{Lamp, LampKind, Material, Node, Rgb, Scene, Surface};
use umbrage_verify::{BakedTriangle, Report, Settings, verify};

fn empty() -> Scene {
    let mut scene = Scene::default();
    scene.nodes.push(Node::default());
    scene.materials.push(Material::diffuse("grey", Rgb::splat(0.6)));
    scene
}

fn lamp(scene: &mut Scene, position_m: DVec3, intensity: f64) {
    let kind = LampKind::Point { position_m, intensity: Rgb::splat(intensity), range_m: None };
    scene.lamps.push(Lamp { name: "lamp".into(), kind });
}

/// A surface of facets between the rows of a grid of points with their normals.
fn grid(scene: &mut Scene, rows: u32, columns: u32, at: impl Fn(u32, u32) -> (DVec3, DVec3)) {
    let mut surface = Surface::new(NodeId::from(0), MaterialId::from(0));
    for (row, column) in (0..=rows).flat_map(|row| (0..=columns).map(move |column| (row, column))) {
        let (at_m, normal) = at(row, column);
        surface.positions_m.push(at_m.as_vec3().as_dvec3());
        surface.normals.push(normal);
    }
    for (row, column) in (0..rows).flat_map(|row| (0..columns).map(move |column| (row, column))) {
        let [a, b] = [row, row + 1].map(|row| row * (columns + 1) + column);
        surface.polygons.extend([vec![a, b, b + 1], vec![a, b + 1, a + 1]]);
    }
    scene.surfaces.push(surface);
}

fn flat(scene: &mut Scene, corners_m: &[DVec3]) {
    let mut surface = Surface::new(NodeId::from(0), MaterialId::from(0));
    surface.push_polygon(corners_m.iter().copied());
    scene.surfaces.push(surface);
}

/// A ball of 192 triangles on a floor under a lamp and a panel.
fn ball() -> Scene {
    let mut scene = empty();
    grid(&mut scene, 9, 12, |row, column| {
        let (sine, cosine) = (PI * f64::from(row) / 9.0).sin_cos();
        // The seam is in one place.
        let (y, x) = (TAU * f64::from(column % 12) / 12.0).sin_cos();
        let outward = DVec3::new(sine * x, sine * y, cosine);
        (0.6 * outward + 0.601 * DVec3::Z, outward)
    });
    flat(&mut scene, &[(-3.0, -3.0), (3.0, -3.0), (3.0, 3.0), (-3.0, 3.0)].map(|(x, y)| DVec3::new(x, y, 0.0)));
    lamp(&mut scene, DVec3::new(1.3, 0.4, 2.0), 5.0);
    let glow = scene.materials.push_and_get_key(Material::emitting("panel", Rgb::splat(4.0)));
    flat(&mut scene, &[(-2.0, -0.6), (-2.0, 0.6), (-1.2, 0.6), (-1.2, -0.6)].map(|(x, y)| DVec3::new(x, y, 2.0)));
    scene.surfaces.raw[2].material = glow;
    scene
}

/// A hall under a barrel vault of twelve facets, seen from inside.
fn vault() -> Scene {
    let mut scene = empty();
    grid(&mut scene, 12, 1, |row, column| {
        let (sine, cosine) = (PI * f64::from(row) / 12.0).sin_cos();
        (DVec3::new(2.0 * cosine, 6.0 * f64::from(column) - 3.0, 2.0 * sine), DVec3::new(-cosine, 0.0, -sine))
    });
    flat(&mut scene, &[(-2.0, -3.0), (2.0, -3.0), (2.0, 3.0), (-2.0, 3.0)].map(|(x, y)| DVec3::new(x, y, 0.0)));
    let arch = |y: f64| -> Vec<DVec3> {
        let point = |i: u32| PI * f64::from(i) / 12.0;
        (0..=12).map(|i| DVec3::new(2.0 * point(i).cos(), y, 2.0 * point(i).sin()).as_vec3().as_dvec3()).collect()
    };
    flat(&mut scene, &arch(3.0));
    flat(&mut scene, &arch(-3.0).into_iter().rev().collect::<Vec<_>>());
    lamp(&mut scene, DVec3::new(-0.5, 0.4, 1.1), 10.0);
    scene
}

fn checked(scene: &Scene, smooth: bool) -> Report {
    let bake = bake(scene, &BakeSettings::default(), Progress::silent()).unwrap();
    let parts = bake.mesh.parts.iter().flat_map(|part| {
        let triangle = |&corners| BakedTriangle::new(bake.mesh.origin_m, corners, &part.positions_m, &part.irradiance);
        part.triangles.iter().map(triangle)
    });
    let triangles: Vec<BakedTriangle> = parts.collect();
    let settings = Settings { points: 600, paths: 2048, seed: 5, smooth };
    verify(scene, &triangles, &settings, &|_, _| ControlFlow::Continue(())).unwrap()
}

#[test]
fn smooth_surfaces_are_lit_as_paths_tell() {
    for (name, scene) in [("ball", ball()), ("vault", vault())] {
        let report = checked(&scene, true);
        println!("{name}: {:?} {:?} {:?}", report.error, report.bias, report.noise);
        let slack = 2.0 * report.error.standard_error;
        assert!(report.error.value < 0.015 + slack && slack < 0.01, "{name}: {:?}", report.error);
        assert!(report.bias.value.abs() < 0.005 + 2.0 * report.bias.standard_error, "{name}: {:?}", report.bias);
        assert!(report.leaks.is_empty() && report.uncovered == 0, "{name}: {:?}", report.leaks);
    }
    // By the facets' own normals the ball has another field.
    let by_facets = checked(&ball(), false);
    assert!(by_facets.error.value > 0.03, "{:?}", by_facets.error);
}
