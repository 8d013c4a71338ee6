//! Sides that no light reaches and nobody can see: which they are, and that leaving them out changes nothing that is seen.
#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

mod common;

use common::build::{add, box_faces, quad, room_faces};
use common::{Lit, irradiance_at, lit_triangles};
use glam::DVec3;
use proptest::prelude::*;
use umbrage::bake::{Bake, BakeSettings, bake};
use umbrage::prepare::PrepareSettings;
use umbrage::progress::Progress;
use umbrage::scene::{Lamp, LampKind, Material, Rgb, Scene};
use umbrage::shade::ShadeSettings;

const SIZE_M: DVec3 = DVec3::new(4.0, 3.0, 2.4);
/// Rims are no wider than a thousandth of the scene's extent.
const RIM_M: f64 = 4e-3;

fn baked(scene: &Scene, tolerance: f64, keep_hidden: bool) -> Bake {
    let prepare = PrepareSettings { keep_hidden, ..PrepareSettings::default() };
    let shade = ShadeSettings { tolerance, ..ShadeSettings::default() };
    bake(scene, &BakeSettings { prepare, shade, ..BakeSettings::default() }, Progress::silent()).unwrap()
}

/// Adds surfaces that reflect 0.6, on both sides if so.
fn furnish(scene: &mut Scene, name: &str, double_sided: bool, faces: &[Vec<DVec3>]) {
    add(scene, Material { double_sided, ..Material::diffuse(name, Rgb::splat(0.6)) }, faces);
}

/// A room that looks in, double-sided or not, with a lamp under its ceiling.
fn room(double_sided: bool) -> Scene {
    let mut scene = Scene::default();
    furnish(&mut scene, "room", double_sided, &room_faces(DVec3::ZERO, SIZE_M));
    let lamp = quad(DVec3::new(2.0, 1.5, 2.39), 0.3 * DVec3::X, -0.2 * DVec3::Y);
    add(&mut scene, Material::emitting("lamp", Rgb::splat(10.0)), &[lamp]);
    scene
}

/// The furniture: a box on the floor, one on it, one that reaches through a wall and one through another box.
fn furniture() -> Vec<Vec<DVec3>> {
    [
        ([0.5, 0.5, 0.0], [1.5, 1.4, 0.8]),
        ([0.7, 0.6, 0.8], [1.1, 1.0, 1.2]),
        ([3.5, 1.0, 0.4], [4.2, 1.5, 0.9]),
        ([1.2, 0.9, 0.3], [2.0, 1.2, 0.6]),
    ]
    .into_iter()
    .flat_map(|(low, high)| box_faces(low.into(), high.into()))
    .collect()
}

/// Area of the triangles that show no light.
fn black_m2(triangles: &[Lit]) -> f64 {
    triangles.iter().filter(|t| t.irradiance == [DVec3::ZERO; 3]).map(Lit::area).sum()
}

#[test]
fn double_sided_shells_cost_what_single_sided_ones_do_and_look_the_same() {
    let of = |double_sided: bool| {
        let mut scene = room(double_sided);
        furnish(&mut scene, "box", double_sided, &furniture());
        baked(&scene, 0.03, false)
    };
    let (single, double) = (of(false), of(true));
    assert_eq!(single.mesh, double.mesh);
    assert!(double.report.prepare.hidden_share > 0.5, "{}", double.report.prepare.hidden_share);
    assert_eq!(
        black_m2(&lit_triangles(&double.mesh).into_iter().filter(|t| t.corners[0].z < 2.38).collect::<Vec<_>>()),
        0.0
    );
}

#[test]
fn what_is_seen_is_as_bright_as_with_all_that_is_hidden() {
    let mut scene = room(true);
    furnish(&mut scene, "box", true, &furniture());
    let [without, with] = [false, true].map(|keep| lit_triangles(&baked(&scene, 0.01, keep).mesh));
    let (mut compared, mut squares, mut mean) = (0.0, 0.0, 0.0);
    for triangle in with.iter().filter(|t| t.irradiance.iter().all(|e| e.x > 0.0)) {
        let middle = triangle.corners.iter().sum::<DVec3>() / 3.0;
        let shown = irradiance_at(&without, middle, triangle.normal(), 1e-4).unwrap();
        let truth = triangle.irradiance.iter().map(|e| e.x).sum::<f64>() / 3.0;
        compared += triangle.area();
        squares += triangle.area() * (shown.x - truth).powi(2);
        mean += triangle.area() * truth;
    }
    let error = (squares / compared).sqrt() / (mean / compared);
    assert!(error < 0.015, "{error}");
}

#[test]
fn a_closed_box_shows_its_outside_and_an_open_one_both() {
    let extra = |scene: &mut Scene, faces: usize| {
        furnish(scene, "box", true, &box_faces(DVec3::splat(0.5), DVec3::splat(1.0))[..faces]);
    };
    let faces = |count: usize| {
        let mut scene = room(false);
        extra(&mut scene, count);
        baked(&scene, 0.1, false).report.faces
    };
    // The room, the lamp, and the box.
    assert_eq!(faces(6), 6 + 1 + 6);
    assert_eq!(faces(5), 6 + 1 + 10);
}

#[test]
fn a_rim_goes_on_under_what_stands_on_the_floor_and_is_as_bright() {
    let mut scene = room(false);
    furnish(&mut scene, "box", false, &box_faces(DVec3::new(1.0, 1.0, 0.0), DVec3::new(2.0, 2.0, 0.5)));
    let triangles = lit_triangles(&baked(&scene, 0.02, false).mesh);
    let on_floor = |x: f64, y: f64| irradiance_at(&triangles, DVec3::new(x, y, 0.0), DVec3::Z, 1e-5).map(|e| e.x);
    let (before, beneath) = (on_floor(1.5, 1.0 - 1e-4).unwrap(), on_floor(1.5, 1.0 + 1e-3).unwrap());
    assert!((beneath / before - 1.0).abs() < 0.02, "{beneath} beneath, {before} before the box");
    assert_eq!(on_floor(1.5, 1.0 + 1.5 * RIM_M), None);
    assert_eq!(on_floor(1.5, 1.5), None);
}

#[test]
fn a_dark_room_that_is_meant_to_be_entered_stays() {
    let mut scene = room(false);
    furnish(&mut scene, "other", false, &room_faces(DVec3::new(5.0, 0.0, 0.0), DVec3::new(8.0, 3.0, 2.4)));
    assert_eq!(baked(&scene, 0.1, false).report.faces, 6 + 1 + 6);
}

#[test]
fn a_bulb_shut_in_its_glass_hides_nothing() {
    let mut scene = room(true);
    scene.materials.iter_mut().for_each(|material| material.radiance = Rgb::ZERO);
    let (low, high) = (DVec3::new(2.0, 1.5, 2.0), DVec3::new(2.05, 1.55, 2.05));
    furnish(&mut scene, "glass", true, &box_faces(low, high));
    let kind = LampKind::Point { position_m: low.midpoint(high), intensity: Rgb::ONE, range_m: None };
    scene.lamps.push(Lamp { name: "bulb".to_owned(), kind });
    let report = baked(&scene, 0.1, false).report;
    assert_eq!((report.prepare.hidden_share, report.faces), (0.0, 12 + 1 + 12));
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(6))]

    /// A face that is left out is dark where all faces are kept: it shows less than a thousandth of the mean, which is a leak.
    #[test]
    fn what_is_hidden_is_dark(
        boxes in prop::collection::vec(([0.0..3.5, 0.0..2.5, -0.2..2.0], [0.1..1.5, 0.1..1.5, 0.1..1.5], any::<bool>()), 1..5),
        sheet in [0.2..3.8, 0.2..2.8, 0.2..2.2],
        open in any::<bool>(),
    ) {
        let mut scene = Scene::default();
        let walls = room_faces(DVec3::ZERO, SIZE_M);
        furnish(&mut scene, "room", true, &walls[usize::from(open)..]);
        let kind = LampKind::Point { position_m: DVec3::new(2.03, 1.51, 2.2), intensity: Rgb::ONE, range_m: None };
        scene.lamps.push(Lamp { name: "bulb".to_owned(), kind });
        for (low, size, double_sided) in boxes {
            let low = DVec3::from(low);
            furnish(&mut scene, "box", double_sided, &box_faces(low, low + DVec3::from(size)));
        }
        let sheet = quad(DVec3::from(sheet), 0.4 * DVec3::X, 0.3 * (DVec3::Y + DVec3::Z));
        furnish(&mut scene, "sheet", true, &[sheet]);
        let [without, with] = [false, true].map(|keep| lit_triangles(&baked(&scene, 0.3, keep).mesh));
        let light = |t: &Lit| t.area() * t.irradiance.iter().map(|e| e.x).sum::<f64>() / 3.0;
        let mean = without.iter().map(light).sum::<f64>() / without.iter().map(Lit::area).sum::<f64>();
        for triangle in with {
            let middle = triangle.corners.iter().sum::<DVec3>() / 3.0;
            if irradiance_at(&without, middle, triangle.normal(), 1e-4).is_none() {
                let shown = triangle.irradiance.iter().map(|e| e.x).fold(0.0, f64::max) / mean;
                prop_assert!(shown < 1e-3, "{shown} of the mean at {middle}");
            }
        }
    }
}
