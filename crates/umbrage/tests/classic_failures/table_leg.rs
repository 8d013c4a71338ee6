//! A table leg of 2 cm keeps its shadow on the floor, in the light of a lamp and in reflected light.

use glam::DVec3;
use umbrage::scene::{Material, Rgb, Scene};

use crate::build::{add, baked, box_faces, mean, quad};
use crate::common::{Lit, irradiance_at};
use crate::exact::{Place, irradiance};

/// Half the side of the floor.
const FLOOR_M: f64 = 1.5;
/// The leg: 2 cm, and as high as a low table.
const LEG_M: [DVec3; 2] = [DVec3::new(0.49, 0.29, 0.0), DVec3::new(0.51, 0.31, 0.5)];
/// Radiance of the lamp.
const RADIANCE: f64 = 10.0;

fn leg() -> Vec<Vec<DVec3>> {
    box_faces(LEG_M[0], LEG_M[1])
}

/// The floor and the leg, both black.
fn floor_and_leg() -> Scene {
    let mut scene = Scene::default();
    add(&mut scene, Material::diffuse("floor", Rgb::ZERO), &[quad(DVec3::ZERO, FLOOR_M * DVec3::X, FLOOR_M * DVec3::Y)]);
    add(&mut scene, Material::diffuse("leg", Rgb::ZERO), &leg());
    scene
}

/// Points across the leg's shadow under a source above the origin, away from the leg to beyond the shadow's end.
fn across_the_shadow() -> Vec<Place> {
    let foot = 0.5 * (LEG_M[0] + LEG_M[1]).with_z(0.0);
    let along = foot.normalize();
    let across = along.cross(DVec3::Z);
    let places = (1..=15).flat_map(|i| (-12..=12).map(move |j| (0.017 + 0.02 * f64::from(i), 0.004 * f64::from(j) + 3e-4)));
    places.map(|(s, t)| Place { point: foot + s * along + t * across, normal: DVec3::Z }).collect()
}

/// Holds baked light across the shadow against exact light, and the shadow itself against its exact depth.
fn keeps_its_shadow(triangles: &[Lit], exact: impl Fn(Place, &[Vec<DVec3>]) -> f64) {
    let floor_mean = mean(triangles.iter().filter(|t| t.normal().z > 0.9 && t.corners.iter().all(|p| p.z == 0.0)));
    let away = box_faces(DVec3::splat(90.0), DVec3::splat(91.0));
    let (mut squares, mut lost, mut shadow) = (0.0, 0.0, 0.0);
    let places = across_the_shadow();
    for &place in &places {
        let got = irradiance_at(triangles, place.point, place.normal, 1e-4).unwrap().element_sum() / 3.0;
        let (truth, without_leg) = (exact(place, &leg()), exact(place, &away));
        squares += (got - truth).powi(2);
        lost += got - truth;
        shadow += without_leg - truth;
    }
    let rms = (squares / places.len() as f64).sqrt() / floor_mean;
    println!("table leg: rms {rms:.4} of the mean, {:+.4} of the shadow lost; shadow {:.3} of the mean", lost / shadow, shadow / places.len() as f64 / floor_mean);
    assert!(shadow > 0.0);
}

#[test]
fn a_table_leg_of_2_cm_keeps_its_shadow_under_a_lamp() {
    let mut scene = floor_and_leg();
    let lamp = quad(DVec3::new(0.0, 0.0, 2.0), 0.15 * DVec3::X, -0.15 * DVec3::Y);
    add(&mut scene, Material::emitting("lamp", Rgb::splat(RADIANCE)), std::slice::from_ref(&lamp));
    let exitance = std::f64::consts::PI * RADIANCE;
    keeps_its_shadow(&baked(&scene), |place, leg| irradiance(place, &lamp, exitance, leg));
}

#[test]
fn a_table_leg_of_2_cm_keeps_its_shadow_in_reflected_light() {
    // A lamp that looks away from the floor lights a panel above it, which alone reflects; the panel's light on the floor past
    // the leg is summed over small parts of it, each as bright as its middle.
    const REFLECTANCE: f64 = 0.8;
    const PARTS: i32 = 24;
    let mut scene = floor_and_leg();
    let (middle, half) = (DVec3::new(0.0, 0.0, 2.0), 0.15);
    let panel = |middle: DVec3, half: f64| quad(middle, half * DVec3::X, -half * DVec3::Y);
    add(&mut scene, Material::diffuse("panel", Rgb::splat(REFLECTANCE)), &[panel(middle, half)]);
    // Its plane passes above all of the floor.
    let lamp = quad(DVec3::new(-0.6, 0.0, 1.4), 0.2 * DVec3::new(3.0, 0.0, -1.0).normalize(), 0.2 * DVec3::Y);
    add(&mut scene, Material::emitting("lamp", Rgb::splat(RADIANCE)), std::slice::from_ref(&lamp));

    let away = box_faces(DVec3::splat(90.0), DVec3::splat(91.0));
    let part = half / f64::from(PARTS);
    let offset = |i: i32| part * f64::from(2 * i + 1 - PARTS);
    let parts: Vec<(Vec<DVec3>, f64)> = (0..PARTS * PARTS)
        .map(|i| middle + DVec3::new(offset(i % PARTS), offset(i / PARTS), 0.0))
        .map(|point| {
            let place = Place { point, normal: -DVec3::Z };
            let lit = irradiance(place, &lamp, std::f64::consts::PI * RADIANCE, &away);
            (panel(point, part), REFLECTANCE * lit)
        })
        .collect();
    keeps_its_shadow(&baked(&scene), |place, leg| {
        parts.iter().map(|(part, radiosity)| irradiance(place, part, *radiosity, leg)).sum()
    });
}
