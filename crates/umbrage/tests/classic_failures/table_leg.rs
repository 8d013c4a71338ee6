//! A table leg of 2 cm keeps its shadow on the floor, in the light of a lamp and in reflected light.

use std::f64::consts::PI;
use std::slice;

use glam::{DQuat, DVec3};
use umbrage::bake::BakeSettings;
use umbrage::scene::{Lamp, LampKind, Material, Rgb, Scene};
use umbrage::shade::ShadeSettings;

use crate::common::Lit;
use crate::common::build::{add, box_faces, quad};
use crate::exact::{Place, irradiance, rms, shown};
use crate::{TOLERANCE, baked, baked_with, mean};

/// Half the side of the floor.
const FLOOR_M: f64 = 1.5;
/// Points of the floor on a side that are looked at.
const FLOOR_POINTS: i32 = 100;
/// The leg's corners: 2 cm, and as high as a low table.
const LEG_M: [DVec3; 2] = [DVec3::new(0.49, 0.29, 0.0), DVec3::new(0.51, 0.31, 0.5)];
/// Radiance of the lamp, in W/(m2 sr).
const RADIANCE: f64 = 10.0;

/// Where light comes from, to the floor and the leg: half a side, and how high it is above the origin.
const SOURCE_M: [f64; 2] = [0.15, 2.0];

fn leg() -> Vec<Vec<DVec3>> {
    box_faces(LEG_M[0], LEG_M[1])
}

/// The floor and the leg, both black.
fn floor_and_leg() -> Scene {
    let mut scene = Scene::default();
    let floor = quad(DVec3::ZERO, FLOOR_M * DVec3::X, FLOOR_M * DVec3::Y);
    add(&mut scene, Material::diffuse("floor", Rgb::ZERO), &[floor]);
    add(&mut scene, Material::diffuse("leg", Rgb::ZERO), &leg());
    scene
}

/// A square that looks down.
fn looking_down(middle: DVec3, half_m: f64) -> Vec<DVec3> {
    quad(middle, half_m * DVec3::X, -half_m * DVec3::Y)
}

/// Points all over the floor but under the leg.
fn all_over_the_floor() -> Vec<Place> {
    // No point lies on an edge of the mesh by chance.
    let at = |i: i32| FLOOR_M * ((2.0 * f64::from(i) + 1.037) / f64::from(FLOOR_POINTS) - 1.0);
    let points = (0..FLOOR_POINTS * FLOOR_POINTS).map(|i| DVec3::new(at(i % FLOOR_POINTS), at(i / FLOOR_POINTS), 0.0));
    let beside =
        |p: &DVec3| (p - LEG_M[0]).truncate().min_element() < 0.0 || (LEG_M[1] - p).truncate().min_element() < 0.0;
    points.filter(beside).map(|point| Place { point, normal: DVec3::Z }).collect()
}

/// Points across the leg's shadow under a source above the origin, from the leg to beyond the shadow's end.
fn across_the_shadow() -> Vec<Place> {
    let foot = 0.5 * (LEG_M[0] + LEG_M[1]).with_z(0.0);
    let along = foot.normalize();
    let across = along.cross(DVec3::Z);
    let offsets_m =
        (1..=15).flat_map(|i| (-12..=12).map(move |j| (0.017 + 0.02 * f64::from(i), 0.0003 + 0.004 * f64::from(j))));
    offsets_m.map(|(s, t)| Place { point: foot + s * along + t * across, normal: DVec3::Z }).collect()
}

/// Holds the floor against exact light, and the shadow against its exact depth: by at most `most_lost` of the light
/// that the leg takes from the floor the shadow may be paler or darker than it is.
fn keeps_its_shadow(surfaces: &[Vec<Lit>], most_lost: f64, exact: impl Fn(Place, &[Vec<DVec3>]) -> f64) {
    let (floor, lamp) = (&surfaces[0], surfaces.len() - 1);
    let mean = mean(surfaces[..lamp].iter().flatten());
    let error = rms(floor, &all_over_the_floor(), |place| exact(place, &leg())) / mean;
    let (mut lost, mut taken) = (0.0, 0.0);
    for place in across_the_shadow() {
        let truth = exact(place, &leg());
        lost += shown(floor, place).unwrap().element_sum() / 3.0 - truth;
        taken += exact(place, &[]) - truth;
    }
    println!("table leg: rms {error:.5} of the mean, {:+.4} of the shadow is lost", lost / taken);
    assert!(error <= TOLERANCE, "relative RMSE {error}");
    assert!(lost.abs() <= most_lost * taken, "{} of the shadow is lost", lost / taken);
}

#[test]
fn a_table_leg_of_2_cm_keeps_its_shadow_under_a_lamp() {
    let mut scene = floor_and_leg();
    let lamp = looking_down(SOURCE_M[1] * DVec3::Z, SOURCE_M[0]);
    add(&mut scene, Material::emitting("lamp", Rgb::splat(RADIANCE)), slice::from_ref(&lamp));
    keeps_its_shadow(&baked(&scene), 0.05, |place, leg| irradiance(place, &lamp, PI * RADIANCE, leg));
}

/// A lamp that looks away from the floor lights a panel above it, which alone reflects; and the light on the floor past
/// an occluder: that of the panel is summed over small parts of it, each as bright as its middle.
fn under_a_panel() -> (Scene, impl Fn(Place, &[Vec<DVec3>]) -> f64) {
    const REFLECTANCE: f64 = 0.8;
    const PARTS: i32 = 12;
    let [half_m, height_m] = SOURCE_M;
    let mut scene = floor_and_leg();
    add(&mut scene, Material::diffuse("panel", Rgb::splat(REFLECTANCE)), &[looking_down(height_m * DVec3::Z, half_m)]);
    // Its plane passes above all of the floor.
    let lamp = quad(DVec3::new(-0.6, 0.0, 1.4), 0.2 * DVec3::new(3.0, 0.0, -1.0).normalize(), 0.2 * DVec3::Y);
    add(&mut scene, Material::emitting("lamp", Rgb::splat(RADIANCE)), slice::from_ref(&lamp));

    let part_m = half_m / f64::from(PARTS);
    let offset_m = move |i: i32| part_m * f64::from(2 * i + 1 - PARTS);
    let middles = (0..PARTS * PARTS).map(|i| DVec3::new(offset_m(i % PARTS), offset_m(i / PARTS), height_m));
    let parts: Vec<(Vec<DVec3>, f64)> = middles
        .map(|point| {
            let lit = irradiance(Place { point, normal: -DVec3::Z }, &lamp, PI * RADIANCE, &[]);
            (looking_down(point, part_m), REFLECTANCE * lit)
        })
        .collect();
    // The lamp's back shades the floor, too, on the other side of the origin than the leg.
    let lamps_back = [lamp.clone(), lamp.iter().rev().copied().collect()];
    let exact = move |place: Place, leg: &[Vec<DVec3>]| {
        let occluder = if place.point.x < 0.0 { &lamps_back } else { leg };
        parts.iter().map(|(part, radiosity)| irradiance(place, part, *radiosity, occluder)).sum()
    };
    (scene, exact)
}

#[test]
fn a_table_leg_of_2_cm_keeps_its_shadow_in_reflected_light() {
    let (scene, exact) = under_a_panel();
    // The tolerance is a share of the mean of all, and most of the light is on the panel: the floor's own mean is much
    // less.
    keeps_its_shadow(&baked(&scene), 0.1, exact);
}

#[test]
fn cuts_along_shadows_in_reflected_light_pay() {
    // Finer than the default: the mean light is that of the panel, and the floor's a small part of it.
    const FINE: f64 = 0.001;
    let (scene, exact) = under_a_panel();
    let [with, without] = [true, false].map(|secondary_sources| {
        let shade = ShadeSettings { tolerance: FINE, ..ShadeSettings::default() };
        let settings = BakeSettings { secondary_sources, shade, ..BakeSettings::default() };
        let floor = baked_with(&scene, settings).swap_remove(0);
        let error = rms(&floor, &across_the_shadow(), |place| exact(place, &leg()));
        let triangles = floor.len();
        println!("secondary sources {secondary_sources}: {triangles} triangles, error {error:.6} W/m2 in the shadow");
        triangles as f64 * error
    });
    // Error falls as triangles grow in number.
    assert!(with < without, "{with} and {without}");
}

/// A spot of light on a ceiling, which alone reflects, maybe with the square around the spot as a face of its own; and
/// the light on the floor past the leg.
fn under_a_spot(own_face: bool) -> (Scene, impl Fn(Place, &[Vec<DVec3>]) -> f64) {
    const REFLECTANCE: f64 = 0.8;
    const PARTS: i32 = 24;
    let [half_m, height_m] = SOURCE_M;
    let mut scene = floor_and_leg();
    let ceiling = |name: &str| Material::diffuse(name, Rgb::splat(REFLECTANCE));
    let around = [0.0, 0.5, 1.0, 1.5].map(|turns| {
        let turn = DQuat::from_rotation_z(turns * PI);
        let corners = [(half_m, half_m), (half_m, -half_m), (FLOOR_M, -FLOOR_M), (FLOOR_M, FLOOR_M)];
        corners.map(|(x, y)| turn * DVec3::new(x, y, height_m)).to_vec()
    });
    if own_face {
        add(&mut scene, ceiling("around the spot"), &[looking_down(height_m * DVec3::Z, half_m)]);
        add(&mut scene, ceiling("ceiling"), &around);
    } else {
        add(&mut scene, ceiling("ceiling"), &[looking_down(height_m * DVec3::Z, FLOOR_M)]);
    }
    let spot = Lamp {
        name: "spot".into(),
        kind: LampKind::Spot {
            // A metre below the ceiling: there the radius is the tangent of the cone's angle.
            position_m: (height_m - 1.0) * DVec3::Z,
            direction: DVec3::Z,
            intensity: Rgb::splat(RADIANCE),
            range_m: None,
            inner_rad: (0.5 * half_m).atan(),
            outer_rad: half_m.atan(),
        },
    };
    let part_m = half_m / f64::from(PARTS);
    let offset_m = move |i: i32| part_m * f64::from(2 * i + 1 - PARTS);
    let middles = (0..PARTS * PARTS).map(|i| DVec3::new(offset_m(i % PARTS), offset_m(i / PARTS), height_m));
    let parts: Vec<(Vec<DVec3>, f64)> = middles
        .filter_map(|point| {
            let arriving = spot.arriving(point)?;
            Some((looking_down(point, part_m), -REFLECTANCE * arriving.towards.z * arriving.irradiance.x))
        })
        .collect();
    scene.lamps.push(spot);
    let exact = move |place: Place, leg: &[Vec<DVec3>]| {
        parts.iter().map(|(part, radiosity)| irradiance(place, part, *radiosity, leg)).sum()
    };
    (scene, exact)
}

#[test]
fn a_spot_on_a_ceiling_is_reflected_from_where_it_lies() {
    // The mean light is that of the spot, and the floor's a small part of it.
    let shade = ShadeSettings { tolerance: 0.004, ..ShadeSettings::default() };
    for own_face in [true, false] {
        let (scene, exact) = under_a_spot(own_face);
        let floor = baked_with(&scene, BakeSettings { shade, ..BakeSettings::default() }).swap_remove(0);
        let places = all_over_the_floor();
        let truth: f64 = places.iter().map(|&place| exact(place, &leg())).sum::<f64>() / places.len() as f64;
        let error = rms(&floor, &places, |place| exact(place, &leg())) / truth;
        println!("own face {own_face}: {} triangles, error {error:.4} of the floor's light", floor.len());
        assert!(error < 0.03, "{error} where the spot has a face of its own: {own_face}");
    }
}

#[test]
#[ignore = "sixteen bakes: a measurement for docs/events.md"]
fn cuts_along_shadows_in_the_light_of_a_spot_on_a_ceiling_pay_where_it_is_fine() {
    for (own_face, tolerance) in [true, false].into_iter().flat_map(|own| [0.01, 0.003, 0.002, 0.001].map(|t| (own, t)))
    {
        let (scene, exact) = under_a_spot(own_face);
        let [with, without] = [true, false].map(|secondary_sources| {
            let shade = ShadeSettings { tolerance, ..ShadeSettings::default() };
            let settings = BakeSettings { secondary_sources, shade, ..BakeSettings::default() };
            let floor = baked_with(&scene, settings).swap_remove(0);
            let error = rms(&floor, &across_the_shadow(), |place| exact(place, &leg()));
            let triangles = floor.len();
            println!(
                "own face {own_face}, {tolerance}, cuts {secondary_sources}: {triangles} triangles, error {error:.6} W/m2"
            );
            triangles as f64 * error
        });
        println!("triangles times error: {:+.1} %", 100.0 * (with / without - 1.0));
    }
}
