//! Baking again from what a bake before left: the same bytes where nothing changed, the light of a bake from scratch
//! where lamps or colours did, and a refusal where surfaces did.

#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

mod common;

use common::{Lit, lit_triangles};
use glam::DVec3;
use umbrage::bake::{Bake, BakeSettings, bake};
use umbrage::progress::Progress;
use umbrage::rebake::{Change, Kept, NotReusable, RebakeError, bake_to_reuse, rebake};
use umbrage::scene::cornell::cornell_box;
use umbrage::scene::{Lamp, LampKind, Rgb, Scene};
use umbrage::shade::ShadeSettings;

/// Root mean square error over the mean irradiance that the bakes are asked for.
const TOLERANCE: f64 = 0.05;

fn settings() -> BakeSettings {
    let default = BakeSettings::default();
    BakeSettings { shade: ShadeSettings { tolerance: TOLERANCE, ..default.shade }, ..default }
}

fn kept(scene: &Scene) -> (Bake, Kept) {
    bake_to_reuse(scene, &settings(), Progress::silent()).unwrap()
}

fn again(scene: &Scene, kept: &Kept) -> (Bake, Change) {
    rebake(scene, &settings(), kept, Progress::silent()).unwrap()
}

fn afresh(scene: &Scene) -> Bake {
    bake(scene, &settings(), Progress::silent()).unwrap()
}

/// The Cornell box with a lamp without extent beside its own.
fn with_lamp(x_m: f64, intensity: f64) -> Scene {
    let mut scene = cornell_box();
    let position_m = DVec3::new(x_m, 0.25, 0.35) * extent_m(&scene);
    let kind =
        LampKind::Point { position_m: low_m(&scene) + position_m, intensity: Rgb::splat(intensity), range_m: None };
    scene.lamps.push(Lamp { name: "bulb".into(), kind });
    scene
}

fn low_m(scene: &Scene) -> DVec3 {
    scene.surfaces.iter().flat_map(|s| &s.positions_m).fold(DVec3::INFINITY, |low, p| low.min(*p))
}

fn extent_m(scene: &Scene) -> DVec3 {
    let high = scene.surfaces.iter().flat_map(|s| &s.positions_m).fold(DVec3::NEG_INFINITY, |high, p| high.max(*p));
    high - low_m(scene)
}

/// A material of the Cornell box, by a part of its name.
fn material<'a>(scene: &'a mut Scene, name: &str) -> &'a mut umbrage::scene::Material {
    scene.materials.iter_mut().find(|material| material.name.contains(name)).unwrap()
}

/// Root mean square difference of two bakes at the centroids of the first one's triangles, weighted by area, and the
/// difference of their means, over the mean.
fn difference(first: &Bake, second: &Bake) -> [f64; 2] {
    let (first, second) = (lit_triangles(&first.mesh), lit_triangles(&second.mesh));
    let [mean, other] = [&first, &second].map(|triangles| mean(triangles));
    let squared = |triangle: &Lit| {
        let at = triangle.corners.iter().sum::<DVec3>() / 3.0;
        let apart = light_at(&second, at, triangle.normal()) - triangle.irradiance.iter().sum::<DVec3>() / 3.0;
        triangle.area() * apart.length_squared() / 3.0
    };
    let area: f64 = first.iter().map(Lit::area).sum();
    [(first.iter().map(squared).sum::<f64>() / area).sqrt() / mean, other / mean - 1.0]
}

/// Area mean of the irradiance, over the three colours.
fn mean(triangles: &[Lit]) -> f64 {
    let light = |triangle: &Lit| triangle.area() * triangle.irradiance.iter().sum::<DVec3>().element_sum() / 9.0;
    triangles.iter().map(light).sum::<f64>() / triangles.iter().map(Lit::area).sum::<f64>()
}

/// What a bake shows at a point.
fn light_at(triangles: &[Lit], at: DVec3, normal: DVec3) -> DVec3 {
    let weights = |triangle: &Lit| {
        let whole = triangle.doubled_area_vector();
        let [a, b, c] = triangle.corners;
        [(b, c), (c, a), (a, b)].map(|(p, q)| (p - at).cross(q - at).dot(whole) / whole.length_squared())
    };
    let same_side =
        |triangle: &&Lit| triangle.normal().dot(normal) > 0.999 && (triangle.corners[0] - at).dot(normal).abs() < 1e-4;
    let inside = |triangle: &Lit| weights(triangle).into_iter().fold(f64::INFINITY, f64::min);
    let best = triangles.iter().filter(same_side).max_by(|p, q| inside(p).total_cmp(&inside(q))).unwrap();
    weights(best).into_iter().zip(best.irradiance).map(|(weight, light)| weight * light).sum()
}

/// A bake again must show what one from scratch does, and both err by less than the tolerance; and the light must have
/// changed by much more than that, or nothing would be shown.
fn assert_like_afresh(scene: &Scene, (before, kept): &(Bake, Kept), change: Change) {
    let (baked, told) = again(scene, kept);
    assert_eq!(told, change);
    let afresh = afresh(scene);
    let [changed, _] = difference(&afresh, before);
    let [rms, mean] = difference(&afresh, &baked);
    assert!(changed > 2.0 * TOLERANCE, "no more than {changed} changed");
    assert!(rms < TOLERANCE && mean.abs() < 0.1 * TOLERANCE, "{rms} rms, {mean} in the mean");
    assert!(baked.report.error < TOLERANCE && baked.report.energy.error().abs() < 0.02, "{:?}", baked.report);
}

#[test]
fn where_nothing_changed_the_same_comes_out_whatever_the_threads() {
    let scene = with_lamp(0.5, 5.0);
    let of_threads = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| {
            let (first, kept) = kept(&scene);
            let (second, change) = again(&scene, &kept);
            assert_eq!(change, Change::Strength);
            assert_eq!(first.mesh, second.mesh);
            first
        })
    };
    let [one, three] = [1, 3].map(of_threads);
    assert_eq!(one.mesh, three.mesh);
    assert_eq!(one.mesh, afresh(&scene).mesh, "keeping it changes nothing");
}

#[test]
fn twice_the_light_is_exactly_twice_everywhere() {
    let (before, kept) = kept(&with_lamp(0.5, 5.0));
    let mut bright = with_lamp(0.5, 10.0);
    bright.materials.iter_mut().for_each(|material| material.radiance *= 2.0);
    let (after, change) = again(&bright, &kept);
    assert_eq!(change, Change::Strength);
    for (after, before) in after.mesh.parts.iter().zip(&before.mesh.parts) {
        assert_eq!((&after.positions_m, &after.triangles), (&before.positions_m, &before.triangles));
        let twice: Vec<[f32; 3]> = before.irradiance.iter().map(|e| e.map(|e| 2.0 * e)).collect();
        assert_eq!(after.irradiance, twice);
    }
}

#[test]
fn other_colours_give_the_light_of_a_bake_from_scratch() {
    let before = kept(&cornell_box());
    let mut bleached = cornell_box();
    material(&mut bleached, "red").reflectance = Rgb::splat(0.8);
    material(&mut bleached, "green").reflectance = Rgb::splat(0.8);
    assert_like_afresh(&bleached, &before, Change::Light);
    let mut dark = cornell_box();
    material(&mut dark, "white").reflectance = Rgb::splat(0.1);
    assert_like_afresh(&dark, &before, Change::Light);
    let mut tinted = cornell_box();
    material(&mut tinted, "light").radiance *= Rgb::new(0.5, 1.0, 3.0);
    assert_like_afresh(&tinted, &before, Change::Strength);
}

#[test]
fn other_lamps_give_the_light_of_a_bake_from_scratch() {
    let before = kept(&with_lamp(0.5, 5.0));
    assert_like_afresh(&with_lamp(0.5, 15.0), &before, Change::Light);
    assert_like_afresh(&with_lamp(0.9, 5.0), &before, Change::Lamps);
    assert_like_afresh(&with_lamp(0.5, 0.0), &before, Change::Lamps);
    assert_like_afresh(&cornell_box(), &before, Change::Lamps);
    let mut glowing = with_lamp(0.5, 5.0);
    material(&mut glowing, "green").radiance = Rgb::new(10.0, 30.0, 10.0);
    assert_like_afresh(&glowing, &before, Change::Lamps);
}

#[test]
fn a_bake_of_other_surfaces_or_with_other_settings_is_refused() {
    let scene = cornell_box();
    let (_, kept) = kept(&scene);
    let refused = |scene: &Scene, settings: &BakeSettings| {
        rebake(scene, settings, &kept, Progress::silent()).map(|(_, change)| change).unwrap_err()
    };
    let finer = BakeSettings { weak_of_tolerance: 0.5, ..settings() };
    assert_eq!(refused(&scene, &finer), RebakeError::NotReusable(NotReusable::Settings));
    let mut moved = scene.clone();
    let surface = moved.surfaces.iter_mut().last().unwrap();
    surface.positions_m.iter_mut().for_each(|p| p.y += 0.01);
    assert_eq!(refused(&moved, &settings()), RebakeError::NotReusable(NotReusable::Surfaces));
    let mut fewer = scene.clone();
    fewer.surfaces.iter_mut().next().unwrap().polygons.pop();
    assert_eq!(refused(&fewer, &settings()), RebakeError::NotReusable(NotReusable::Surfaces));
    // In a block: its inside, which was hidden, is lit.
    assert_eq!(refused(&with_lamp(0.25, 5.0), &settings()), RebakeError::NotReusable(NotReusable::Surfaces));
    let mut dark = scene;
    dark.materials.iter_mut().for_each(|material| material.radiance = Rgb::ZERO);
    assert!(matches!(refused(&dark, &settings()), RebakeError::Bake(_)));
}
