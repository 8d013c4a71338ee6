//! The check against closed forms: light that is known is found right, and errors that are put in are found.
#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

use std::f64::consts::PI;
use std::ops::ControlFlow;

use glam::{BVec3, DVec3};
use umbrage::id::NodeId;
use umbrage::scene::{Lamp, LampKind, Material, Node, Rgb, Scene, Surface, cornell};
use umbrage_verify::{BakedTriangle, Report, Settings, VerifyError, verify};

/// Adds the faces of a box, looking outward or inward, as a surface.
fn add_box(scene: &mut Scene, low: DVec3, high: DVec3, inward: bool, material: Material) {
    let at = |i: u32| DVec3::select(BVec3::new(i & 1 > 0, i & 2 > 0, i & 4 > 0), high, low);
    let outward = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    let mut polygons: Vec<Vec<u32>> = outward.map(|corners| corners.to_vec()).to_vec();
    if inward {
        polygons.iter_mut().for_each(|corners| corners.reverse());
    }
    if scene.nodes.is_empty() {
        scene.nodes.push(Node::default());
    }
    let material = scene.materials.push_and_get_key(material);
    scene.surfaces.push(Surface {
        positions_m: (0..8).map(at).collect(),
        polygons,
        ..Surface::new(NodeId::from(0), material)
    });
}

/// Two triangles for each quadrilateral of a surface, lit by a function of the place.
fn lit(scene: &Scene, surface: usize, light: impl Fn(DVec3) -> Rgb) -> Vec<BakedTriangle> {
    let surface = &scene.surfaces.raw[surface];
    let triangles = surface.polygons.iter().flat_map(|p| [[p[0], p[1], p[2]], [p[0], p[2], p[3]]]);
    triangles
        .map(|corners| corners.map(|i| surface.positions_m[i as usize]))
        .map(|corners_m| BakedTriangle { corners_m, irradiance: corners_m.map(&light) })
        .collect()
}

fn check(scene: &Scene, baked: &[BakedTriangle], points: usize, paths: usize) -> Report {
    verify(scene, baked, &Settings { points, paths, ..Settings::default() }, &|_, _| ControlFlow::Continue(())).unwrap()
}

/// A cube whose faces all emit 1 W/m2 and reflect a half: irradiance is 2 W/m2 everywhere.
fn furnace() -> Scene {
    let mut scene = Scene::default();
    let glow = Material { reflectance: Rgb::splat(0.5), ..Material::emitting("glow", Rgb::ONE / PI) };
    add_box(&mut scene, DVec3::ZERO, DVec3::ONE, true, glow);
    scene
}

#[test]
fn a_furnace_is_right_and_a_wrong_one_is_wrong_by_as_much() {
    let scene = furnace();
    let right = check(&scene, &lit(&scene, 0, |_| Rgb::splat(2.0)), 400, 1152);
    assert_eq!((right.compared, right.uncovered, right.buried, right.dark), (400, 0, 0, 0));
    assert!(
        right.bias.value.abs() < 4.0 * right.bias.standard_error && right.bias.standard_error < 1.5e-3,
        "{right:?}"
    );
    assert!((right.mean_irradiance / 2.0 - 1.0).abs() < 4.0 * right.bias.standard_error, "{right:?}");
    assert!(right.error.value < 4e-3, "{right:?}");

    // Off by up to 2 % either way along one axis: the mean square over the cube is (2 x 1 + 4 x 1/3) / 6 of its square.
    let skew = check(&scene, &lit(&scene, 0, |p| Rgb::splat(2.0 + 0.04 * (2.0 * p.x - 1.0))), 400, 1152);
    let truth = 0.02 * ((2.0 + 4.0 / 3.0) / 6.0_f64).sqrt();
    assert!((skew.error.value - truth).abs() < 4.0 * skew.error.standard_error, "{skew:?} {truth}");
    assert!(skew.error.standard_error < 0.1 * truth, "{skew:?} {truth}");
    let high = check(&scene, &lit(&scene, 0, |_| Rgb::splat(2.02)), 400, 1152);
    assert!((high.bias.value - 0.01).abs() < 4.0 * high.bias.standard_error, "{high:?}");
}

#[test]
fn the_mean_light_of_a_room_with_a_lamp_that_loses_nothing_is_exact() {
    // CIE 171, 5.8: irradiance of the walls is flux / area / (1 - rho) in the mean where the lamp reflects all.
    for rho in [0.3, 0.8] {
        let mean = 10_000.0 / 96.0 / (1.0 - rho);
        let mut scene = Scene::default();
        add_box(&mut scene, DVec3::ZERO, DVec3::splat(4.0), true, Material::diffuse("wall", Rgb::splat(rho)));
        let radiance = Rgb::splat(10_000.0 / (6.0 * 0.25) / PI);
        let lamp = Material { reflectance: Rgb::ONE, ..Material::emitting("lamp", radiance) };
        add_box(&mut scene, DVec3::splat(1.75), DVec3::splat(2.25), false, lamp);
        let report = check(&scene, &lit(&scene, 0, |_| Rgb::splat(mean)), 2000, 128);
        assert_eq!(report.compared, 2000);
        assert!((report.mean_irradiance / mean - 1.0).abs() < 4.0 * report.bias.standard_error, "{report:?} {mean}");
        assert!(report.bias.standard_error < 0.01, "{report:?}");
    }
}

#[test]
fn light_in_a_sealed_box_is_a_leak() {
    let mut scene = furnace();
    let grey = || Material::diffuse("grey", Rgb::splat(0.5));
    add_box(&mut scene, DVec3::splat(0.25), DVec3::splat(0.75), false, grey());
    // A chamber within it, looking inward: it sees its own sides, and none of them is lit.
    add_box(&mut scene, DVec3::splat(0.3), DVec3::splat(0.5), true, grey());
    // A block within it, looking outward: it sees the backs of the first alone.
    add_box(&mut scene, DVec3::splat(0.55), DVec3::splat(0.7), false, grey());
    let leaking = |p: DVec3| if p.x < 0.6 { Rgb::splat(0.1) } else { Rgb::ZERO };
    let mut baked = lit(&scene, 1, |_| Rgb::splat(2.0));
    baked.extend([2, 3].into_iter().flat_map(|surface| lit(&scene, surface, leaking)));
    let report = check(&scene, &baked, 1000, 64);
    assert!(report.dark > 50 && report.buried > 30 && report.uncovered == 0, "{report:?}");
    assert!(report.leaks.len() > 50 && report.leaks.len() < report.dark + report.buried, "{report:?}");
    assert!(report.leaks.iter().all(|leak| leak.position_m.x < 0.7 && leak.traced == Rgb::ZERO), "{report:?}");
}

#[test]
fn lamps_shine_without_noise_and_cast_shadows() {
    let mut scene = Scene::default();
    add_box(&mut scene, DVec3::ZERO, DVec3::ONE, true, Material::diffuse("black", Rgb::ZERO));
    let sun = LampKind::Directional { direction: DVec3::new(0.0, 0.6, -0.8), irradiance: Rgb::splat(5.0) };
    scene.lamps.push(Lamp { name: "sun".into(), kind: sun });
    // The box is closed: its backs keep the sun out.
    let dark = lit(&scene, 0, |_| Rgb::ZERO);
    let closed = check(&scene, &dark, 100, 8);
    assert_eq!((closed.dark, closed.error.value, closed.noise), (100, 0.0, 0.0), "{closed:?}");
    // Without its ceiling (the second face, towards +z) and its wall at y = 0 the floor has 4 and the wall behind it 3.
    for face in [2, 1] {
        scene.surfaces.raw[0].polygons.remove(face);
    }
    let open = |p: &BakedTriangle| (p.corners_m[1] - p.corners_m[0]).cross(p.corners_m[2] - p.corners_m[0]).normalize();
    let mut baked = lit(&scene, 0, |_| Rgb::ZERO);
    for triangle in &mut baked {
        triangle.irradiance = [Rgb::splat(5.0 * open(triangle).dot(DVec3::new(0.0, -0.6, 0.8)).max(0.0)); 3];
    }
    let report = check(&scene, &baked, 100, 8);
    assert!(report.error.value < 1e-12 && report.noise < 1e-12, "{report:?}");
    assert!((report.mean_irradiance - 7.0 / 4.0).abs() < 0.1 && report.dark > 40, "{report:?}");
}

#[test]
fn the_report_depends_on_the_seed_and_not_on_threads() {
    let scene = furnace();
    let baked = lit(&scene, 0, |p| Rgb::new(2.0, 2.0 + 0.1 * p.y, 1.9));
    let with = |threads: usize, seed: u64| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        let settings = Settings { points: 50, paths: 32, seed, ..Settings::default() };
        pool.install(|| verify(&scene, &baked, &settings, &|_, _| ControlFlow::Continue(())).unwrap())
    };
    assert_eq!(with(1, 1), with(2, 1));
    assert_ne!(with(1, 1).worst, with(1, 2).worst);
}

#[test]
fn what_cannot_be_compared_is_told() {
    let scene = cornell::cornell_box();
    let settings = Settings { points: 10, paths: 8, seed: 1, ..Settings::default() };
    assert_eq!(verify(&scene, &[], &settings, &|_, _| ControlFlow::Continue(())), Err(VerifyError::NothingToCompare));
    let refused = verify(&Scene::default(), &[], &settings, &|_, _| ControlFlow::Continue(()));
    assert!(matches!(refused, Err(VerifyError::Scene(_))));
    assert_eq!(verify(&scene, &[], &settings, &|_, _| ControlFlow::Break(())), Err(VerifyError::Cancelled));
}
