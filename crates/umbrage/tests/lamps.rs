//! Whole bakes under lamps without extent: light jumps at the edges of shadows, exactly there.
#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

mod common;

use common::{irradiance_at, lit_triangles};
use glam::DVec3;
use umbrage::bake::{Bake, BakeSettings, bake};
use umbrage::id::NodeId;
use umbrage::progress::Progress;
use umbrage::scene::{Lamp, LampKind, Material, Node, Rgb, Scene, Surface};

/// A square in a plane of constant height, looking up.
fn square(middle: DVec3, half: f64) -> [DVec3; 4] {
    [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)].map(|(x, y)| middle + half * DVec3::new(x, y, 0.0))
}

/// A floor of 4 x 4 m with a plate of 1 x 1 m above its middle at 1 m, both black and two-sided, under a lamp.
fn plate_under(kind: LampKind) -> Scene {
    let mut scene = Scene::default();
    scene.nodes.push(Node::default());
    let material = scene.materials.push_and_get_key(Material::diffuse("black", Rgb::ZERO));
    let positions_m = [square(DVec3::ZERO, 2.0), square(DVec3::Z, 0.5)].concat();
    let polygons = vec![(0..4).collect(), (4..8).collect()];
    scene.surfaces.push(Surface { positions_m, polygons, ..Surface::new(NodeId::from(0), material) });
    scene.lamps.push(Lamp { name: "lamp".into(), kind });
    scene
}

fn baked(scene: &Scene) -> Bake {
    bake(scene, &BakeSettings::default(), Progress::silent()).unwrap()
}

/// Root mean square error over the floor relative to its mean, and the greatest error nearer than 1 cm to a jump.
fn errors(bake: &Bake, truth: impl Fn(f64, f64) -> f64) -> [f64; 2] {
    let triangles = lit_triangles(&bake.mesh);
    let n = 161;
    let (mut sum, mut squares, mut worst) = (0.0, 0.0, 0.0_f64);
    for (i, j) in (0..n).flat_map(|i| (0..n).map(move |j| (i, j))) {
        // No point lies on an edge of a shadow.
        let [x, y] = [i, j].map(|k| 4.0 * (f64::from(k) + 0.437) / f64::from(n) - 2.0);
        let got = irradiance_at(&triangles, DVec3::new(x, y, 0.0), DVec3::Z, 1e-4).unwrap().x;
        sum += truth(x, y);
        squares += (got - truth(x, y)).powi(2);
        let near = |d: f64| [(d, 0.0), (-d, 0.0), (0.0, d), (0.0, -d)].map(|(dx, dy)| truth(x + dx, y + dy));
        if near(0.01).iter().any(|&beside| (beside == 0.0) != (truth(x, y) == 0.0)) {
            worst = worst.max((got - truth(x, y)).abs());
        }
    }
    let count = f64::from(n * n);
    [(squares / count).sqrt() / (sum / count), worst / (sum / count)]
}

#[test]
fn a_point_lamps_shadow_is_sharp_and_where_it_is() {
    let kind = LampKind::Point { position_m: DVec3::Z * 2.0, intensity: Rgb::splat(8.0), range_m: None };
    let bake = baked(&plate_under(kind));
    let truth = |x: f64, y: f64| {
        let squared = x * x + y * y + 4.0;
        if x.abs() < 1.0 && y.abs() < 1.0 { 0.0 } else { 8.0 * 2.0 / squared.powf(1.5) }
    };
    let [rms, at_the_edge] = errors(&bake, truth);
    println!("{rms} {at_the_edge} {} triangles", bake.report.triangles);
    assert!(bake.report.d_segments[0] >= 4, "{:?}", bake.report.d_segments);
    assert!(rms < 0.01, "rms {rms}");
    assert!(at_the_edge < 0.05, "{at_the_edge}");
}

#[test]
fn a_suns_light_needs_no_more_triangles_than_its_shadow_has_corners() {
    let kind = LampKind::Directional { direction: DVec3::new(0.36, 0.48, -0.8), irradiance: Rgb::splat(5.0) };
    let bake = baked(&plate_under(kind));
    // The shadow is moved by 0.45 and 0.6.
    let truth = |x: f64, y: f64| if (x - 0.45).abs() < 0.5 && (y - 0.6).abs() < 0.5 { 0.0 } else { 4.0 };
    let [rms, at_the_edge] = errors(&bake, truth);
    println!("{rms} {at_the_edge} {} triangles", bake.report.triangles);
    assert!(rms < 1e-5 && at_the_edge < 1e-5, "{rms} {at_the_edge}");
    assert!(bake.report.triangles < 60, "{}", bake.report.triangles);
}

#[test]
fn a_lamp_in_a_closed_room_lights_it_by_reflection_too() {
    // A spot at the ceiling's height, straight down; the walls see the floor alone.
    let mut scene = Scene::default();
    scene.nodes.push(Node::default());
    let material = scene.materials.push_and_get_key(Material::diffuse("grey", Rgb::splat(0.5)));
    let at = |i: u32| 2.0 * DVec3::new(f64::from(i & 1), f64::from(i >> 1 & 1), f64::from(i >> 2 & 1));
    let inward = [[1, 3, 2, 0], [6, 7, 5, 4], [4, 5, 1, 0], [3, 7, 6, 2], [2, 6, 4, 0], [5, 7, 3, 1]];
    let polygons = inward.map(|corners| corners.to_vec()).to_vec();
    scene.surfaces.push(Surface {
        positions_m: (0..8).map(at).collect(),
        polygons,
        ..Surface::new(NodeId::from(0), material)
    });
    let kind = LampKind::Spot {
        position_m: DVec3::new(1.0, 1.0, 1.9),
        direction: DVec3::NEG_Z,
        intensity: Rgb::splat(10.0),
        range_m: None,
        inner_rad: 0.2,
        outer_rad: 0.4,
    };
    scene.lamps.push(Lamp { name: "spot".into(), kind });
    let flux = scene.lamps.raw[0].flux_w().unwrap().x;
    let triangles = lit_triangles(&baked(&scene).mesh);
    // What falls on all sides is the flux and all that comes back of it: 1 / (1 - rho).
    let arrives: f64 = triangles.iter().map(|t| t.area() * t.irradiance.iter().map(|e| e.x).sum::<f64>() / 3.0).sum();
    println!("{}", arrives / (2.0 * flux));
    assert!((arrives / (2.0 * flux) - 1.0).abs() < 0.02, "{arrives} {flux}");
}

/// A black two-sided disc of radius 1 with `corners` at 1 m over a floor of 6 x 6 m, under a bulb at 2.5 m that is off its axis.
fn disc_under_a_bulb(corners: u32) -> (Scene, DVec3) {
    let bulb_m = DVec3::new(0.3, 0.2, 2.5);
    let kind = LampKind::Point { position_m: bulb_m, intensity: Rgb::splat(10.0), range_m: None };
    let mut scene = plate_under(kind);
    let angle = |i: u32| std::f64::consts::TAU * f64::from(i) / f64::from(corners);
    let rim = (0..corners).map(|i| DVec3::new(angle(i).cos(), angle(i).sin(), 1.0));
    let surface = &mut scene.surfaces.raw[0];
    surface.positions_m = square(DVec3::ZERO, 3.0).into_iter().chain(rim).collect();
    surface.polygons = vec![(0..4).collect(), (4..4 + corners).collect()];
    (scene, bulb_m)
}

/// Area of the floor, in square metres, that shows the light of the other side of the disc's shadow.
fn area_on_the_wrong_side(bake: &Bake, corners: u32, bulb_m: DVec3) -> f64 {
    let grows = bulb_m.z / (bulb_m.z - 1.0);
    let middle = bulb_m + grows * (DVec3::Z - bulb_m);
    let step = std::f64::consts::TAU / f64::from(corners);
    let is_dark = |p: DVec3| {
        let from_middle = p - middle;
        let around = from_middle.y.atan2(from_middle.x).rem_euclid(step) - 0.5 * step;
        from_middle.length() * around.cos() < grows * (0.5 * step).cos()
    };
    let wrong = |triangle: &common::Lit| {
        // Ten by ten points of a parallelogram, folded into the triangle: none lies on a side.
        let [a, b, c] = triangle.corners;
        let [p, q, r] = triangle.irradiance.map(|e| e.x);
        let at = |i: u32, j: u32| {
            let (u, v) = ((f64::from(i) + 0.3) / 10.0, (f64::from(j) + 0.4) / 10.0);
            let (u, v) = if u + v > 1.0 { (1.0 - u, 1.0 - v) } else { (u, v) };
            (a + u * (b - a) + v * (c - a), p + u * (q - p) + v * (r - p))
        };
        let is_wrong = |&(i, j): &(u32, u32)| {
            let (point, shown) = at(i, j);
            let clear = 10.0 * bulb_m.z / (point - bulb_m).length().powi(3);
            (shown - if is_dark(point) { 0.0 } else { clear }).abs() > 0.3 * clear
        };
        let points = (0..10).flat_map(|i| (0..10).map(move |j| (i, j)));
        triangle.area() * points.filter(is_wrong).count() as f64 / 100.0
    };
    let triangles = lit_triangles(&bake.mesh);
    triangles.iter().filter(|t| t.corners.iter().all(|p| p.z == 0.0) && t.normal().z > 0.5).map(wrong).sum()
}

#[test]
fn the_rim_of_a_round_shadow_is_as_sharp_as_that_of_a_square_one() {
    for corners in [192, 450, 700] {
        let (scene, bulb_m) = disc_under_a_bulb(corners);
        let bake = baked(&scene);
        let wrong_m2 = area_on_the_wrong_side(&bake, corners, bulb_m);
        println!("{corners} corners: {wrong_m2:.1e} m2 of 36 are wrong, {} triangles", bake.report.triangles);
        // Edges are straightened by up to 0.4 of the mesh's shortest edge, 1.7e-4 m: along the rim of 10.5 m, 7e-4 m2 at most.
        assert!(wrong_m2 < 7e-4, "{wrong_m2} m2 at {corners} corners");
        assert!(bake.report.triangles < 12 * corners as usize, "{}", bake.report.triangles);
    }
}
