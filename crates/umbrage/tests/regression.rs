//! Reflected light that is fitted to samples, against closed forms and against exact gathers by faces, which share nothing with it but
//! the direct light.
#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

mod common;

use std::f64::consts::PI;

use common::build::{add, box_faces, quad, room_faces};
use common::{Lit, irradiance_at, lit_triangles};
use glam::DVec3;
use umbrage::bake::{Bake, BakeSettings, GatherKind, bake};
use umbrage::progress::Progress;
use umbrage::scene::{Material, Rgb, Scene};
use umbrage::shade::ShadeSettings;

fn baked(scene: &Scene, gather: GatherKind, tolerance: f64) -> Bake {
    let default = BakeSettings::default();
    let settings = BakeSettings { gather, shade: ShadeSettings { tolerance, ..default.shade }, ..default };
    bake(scene, &settings, Progress::silent()).unwrap()
}

fn lit(scene: &Scene, gather: GatherKind, tolerance: f64) -> Vec<Lit> {
    shown(&baked(scene, gather, tolerance))
}

/// What shows light: not the lamp, which hangs at 2.2 m.
fn shown(bake: &Bake) -> Vec<Lit> {
    let is_lamp = |triangle: &Lit| triangle.corners.iter().all(|corner| (corner.z - 2.2).abs() < 1e-6);
    lit_triangles(&bake.mesh).into_iter().filter(|triangle| !is_lamp(triangle)).collect()
}

/// Root mean square of how far two bakes differ at the middles of the triangles of the first, over the mean.
fn difference(one: &[Lit], other: &[Lit], extent_m: f64) -> f64 {
    let (mut squared, mut light, mut area_m2) = (0.0, 0.0, 0.0);
    for triangle in one {
        let [a, b, c] = triangle.corners;
        let at_m = 0.45 * a + 0.33 * b + 0.22 * c;
        let here = 0.45 * triangle.irradiance[0] + 0.33 * triangle.irradiance[1] + 0.22 * triangle.irradiance[2];
        let there = irradiance_at(other, at_m, triangle.normal(), 1e-5 * extent_m).unwrap_or(here);
        squared += triangle.area() * (here - there).length_squared() / 3.0;
        light += triangle.area() * here.element_sum() / 3.0;
        area_m2 += triangle.area();
    }
    (squared / area_m2).sqrt() / (light / area_m2)
}

/// A room with a lamp under its ceiling, and things that stand and lean in it.
fn furnished(double_sided: bool) -> Scene {
    let mut scene = Scene::default();
    let material = |name: &str, reflectance: Rgb| Material { double_sided, ..Material::diffuse(name, reflectance) };
    add(&mut scene, material("walls", Rgb::new(0.7, 0.6, 0.5)), &room_faces(DVec3::ZERO, DVec3::new(4.0, 3.0, 2.5)));
    let mut things = box_faces(DVec3::new(0.5, 0.5, 0.0), DVec3::new(1.4, 1.2, 0.8));
    things.extend(box_faces(DVec3::new(2.5, 1.0, 0.0), DVec3::new(3.0, 2.0, 1.6)));
    add(&mut scene, material("things", Rgb::new(0.3, 0.5, 0.6)), &things);
    let leaning = quad(DVec3::new(2.0, 2.4, 0.8), DVec3::new(0.6, 0.0, 0.0), DVec3::new(0.0, 0.2, 0.5));
    add(&mut scene, Material { double_sided: true, ..material("sheet", Rgb::splat(0.8)) }, &[leaning]);
    let lamp = quad(DVec3::new(2.0, 1.5, 2.2), DVec3::new(0.0, 0.3, 0.0), DVec3::new(0.4, 0.0, 0.0));
    add(&mut scene, Material::emitting("lamp", Rgb::splat(20.0)), &[lamp]);
    scene
}

#[test]
fn it_is_the_light_that_gathers_by_faces_find_on_single_and_double_sided_faces() {
    for double_sided in [false, true] {
        let scene = furnished(double_sided);
        let [faces, fitted] =
            [(GatherKind::Faces, 0.01), (GatherKind::Regression, 0.01)].map(|(gather, at)| lit(&scene, gather, at));
        let apart = difference(&fitted, &faces, 4.0);
        // Each errs about the tolerance.
        assert!(apart < 0.018, "{apart}, double-sided {double_sided}");
    }
}

#[test]
fn in_a_furnace_it_is_even_however_narrow_gaps_are() {
    // Everything emits 1 and reflects a half: irradiance is 2 everywhere, in a gap of 4 mm, too.
    let glow = Material { reflectance: Rgb::splat(0.5), ..Material::emitting("glow", Rgb::ONE / PI) };
    let mut scene = Scene::default();
    let mut faces = room_faces(DVec3::ZERO, DVec3::new(2.0, 1.5, 1.0));
    faces.extend(box_faces(DVec3::new(0.5, 0.004, 0.2), DVec3::new(1.0, 0.9, 0.7)));
    add(&mut scene, glow, &faces);
    let bake = baked(&scene, GatherKind::Regression, 0.01);
    assert!(bake.report.samples.is_some());
    // What emits is drawn in its own colour: the account tells.
    assert!(bake.report.energy.error().abs() < 5e-3, "{:?}", bake.report.energy);
}

#[test]
fn sealed_chambers_and_covered_faces_stay_exactly_dark() {
    let mut scene = furnished(false);
    let grey = || Material::diffuse("grey", Rgb::splat(0.6));
    // A chamber beside the room that no light enters, and a plate 0.2 mm before a wall, which covers it.
    add(&mut scene, grey(), &room_faces(DVec3::new(4.001, 0.0, 0.0), DVec3::new(5.0, 3.0, 2.5)));
    add(&mut scene, grey(), &box_faces(DVec3::new(1.5, 0.0002, 0.8), DVec3::new(2.1, 0.02, 1.4)));
    let settings = BakeSettings::default();
    let prepare = umbrage::prepare::PrepareSettings { keep_hidden: true, ..settings.prepare };
    let settings = BakeSettings {
        gather: GatherKind::Regression,
        prepare,
        shade: ShadeSettings { tolerance: 0.02, ..settings.shade },
        ..settings
    };
    let triangles = lit_triangles(&bake(&scene, &settings, Progress::silent()).unwrap().mesh);
    let greatest = |is_inside: &dyn Fn(DVec3) -> bool| {
        let inside = triangles.iter().filter(|triangle| triangle.corners.iter().all(|&corner| is_inside(corner)));
        let lights = inside.flat_map(|triangle| triangle.irradiance).map(|light| light.max_element());
        lights.fold(None, |most: Option<f64>, light| Some(most.map_or(light, |most| most.max(light))))
    };
    let chamber = greatest(&|p| p.x > 4.0005).unwrap();
    assert_eq!(chamber, 0.0, "light leaks into a chamber");
    let covered = |p: DVec3| p.y < 1e-4 && (1.51..2.09).contains(&p.x) && (0.81..1.39).contains(&p.z);
    assert_eq!(greatest(&covered).unwrap_or(0.0), 0.0, "light leaks behind a plate");
}

#[test]
fn its_estimate_of_the_error_is_honest() {
    let scene = furnished(false);
    let truth = lit(&scene, GatherKind::Faces, 0.004);
    for tolerance in [0.04, 0.02] {
        let bake = baked(&scene, GatherKind::Regression, tolerance);
        let found = difference(&shown(&bake), &truth, 4.0);
        assert!(bake.report.error <= 1.001 * tolerance, "{} of {tolerance}", bake.report.error);
        // Where one point of each triangle is looked at.
        assert!((0.4..1.5).contains(&(found / bake.report.error)), "{found} is not {}", bake.report.error);
    }
}
