//! Smooth surfaces: light by the normals that facets carry, without a trace of the facets.
#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

use std::collections::BTreeMap;
use std::f64::consts::{PI, TAU};

use glam::DVec3;
use proptest::prelude::*;
use umbrage::bake::{BakeSettings, bake};
use umbrage::id::{MaterialId, NodeId, SurfaceId};
use umbrage::prepare::{Prepared, prepare};
use umbrage::progress::Progress;
use umbrage::scene::{Lamp, LampKind, Material, Node, Rgb, Scene, Surface};
use umbrage::transport::DirectLight;
use umbrage::visibility::{ReceiverPoint, Visibility};

/// A scene of one surface of this reflectance under a lamp.
fn scene(material: Material, lamp: LampKind) -> Scene {
    let mut scene = Scene::default();
    scene.nodes.push(Node::default());
    let material = scene.materials.push_and_get_key(material);
    scene.surfaces.push(Surface::new(NodeId::from(0), material));
    scene.lamps.push(Lamp { name: "lamp".into(), kind: lamp });
    scene
}

fn grey() -> Material {
    Material::diffuse("grey", Rgb::splat(0.5))
}

/// A ball around the origin of rings and sectors, whose radius at a direction is `radius_m`; its normals are those that `normal` tells.
fn ball(surface: &mut Surface, rings: u32, sectors: u32, radius_m: impl Fn(u32, DVec3) -> f64) {
    let direction = |ring: u32, sector: u32| {
        let (sine, cosine) = (PI * f64::from(ring) / f64::from(rings)).sin_cos();
        let (y, x) = (TAU * f64::from(sector) / f64::from(sectors)).sin_cos();
        DVec3::new(sine * x, sine * y, cosine)
    };
    let mut add = |direction: DVec3| {
        let number = surface.positions_m.len() as u32;
        surface.positions_m.push((radius_m(number, direction) * direction).as_vec3().as_dvec3());
        surface.normals.push(direction);
    };
    add(DVec3::Z);
    (1..rings).for_each(|ring| (0..sectors).for_each(|sector| add(direction(ring, sector))));
    add(DVec3::NEG_Z);
    let last = surface.positions_m.len() as u32 - 1;
    let at = |ring: u32, sector: u32| 1 + (ring - 1) * sectors + sector % sectors;
    for s in 0..sectors {
        surface.polygons.push(vec![0, at(1, s), at(1, s + 1)]);
        for r in 1..rings - 1 {
            surface.polygons.push(vec![at(r, s), at(r + 1, s), at(r + 1, s + 1)]);
            surface.polygons.push(vec![at(r, s), at(r + 1, s + 1), at(r, s + 1)]);
        }
        surface.polygons.push(vec![last, at(rings - 1, s + 1), at(rings - 1, s)]);
    }
}

/// Direct light at points of each face, next to its corners and inside, with the point and the interpolated normal.
fn direct_light(scene: &Scene) -> Vec<(DVec3, DVec3, f64)> {
    let prepared = prepare(scene, Progress::silent()).unwrap();
    let visibility = Visibility::new(&prepared);
    let direct = DirectLight::new(scene, &prepared, &visibility);
    let light = |prepared: &Prepared, face, at_m: DVec3| {
        let receiver = ReceiverPoint::on_face(prepared, face, at_m);
        (prepared.origin_m + receiver.position_m, receiver.normal, direct.at(&receiver).x)
    };
    let of_face = |face| {
        let corners_m = prepared.polygon_m(face);
        assert!(prepared.is_smooth(face));
        let middle_m = corners_m.iter().sum::<DVec3>() / corners_m.len() as f64;
        let mut lights = Vec::new();
        for (i, &corner_m) in corners_m.iter().enumerate() {
            let next_m = corners_m[(i + 1) % corners_m.len()];
            let on_edge = [0.0, 0.3, 0.5, 0.98].map(|share| corner_m.lerp(next_m, share));
            let inside = on_edge.map(|at_m| at_m.lerp(middle_m, 0.4));
            lights.extend(on_edge.into_iter().chain(inside).map(|at_m| light(&prepared, face, at_m)));
        }
        lights
    };
    prepared.faces.keys().flat_map(of_face).collect()
}

#[test]
fn a_ball_in_the_sun_is_lit_by_its_normals_up_to_the_terminator() {
    for direction in [DVec3::new(-0.6, 0.0, -0.8), DVec3::new(0.31, 0.87, -0.2), DVec3::new(0.05, -0.1, 1.0)] {
        let direction = direction.normalize();
        let mut scene = scene(grey(), LampKind::Directional { direction, irradiance: Rgb::splat(2.0) });
        ball(&mut scene.surfaces.raw[0], 9, 12, |_, _| 1.0);
        let mut turned_away = 0;
        for (at_m, normal, light) in direct_light(&scene) {
            let truth = 2.0 * normal.dot(-direction).max(0.0);
            assert!((light - truth).abs() < 1e-9, "{light} is not {truth} at {at_m}");
            // At the corners that is the ball's own normal, and so the light of the ball.
            let is_corner = (at_m.length() - 1.0).abs() < 1e-6;
            assert!(!is_corner || (light - 2.0 * at_m.dot(-direction).max(0.0)).abs() < 1e-5);
            turned_away += usize::from(truth == 0.0);
        }
        assert!(turned_away > 500, "{turned_away}");
    }
}

#[test]
fn a_ball_under_a_point_lamp_is_lit_by_its_normals() {
    let position_m = DVec3::new(1.0, 2.0, 1.5);
    let lamp = LampKind::Point { position_m, intensity: Rgb::splat(3.0), range_m: None };
    let mut scene = scene(grey(), lamp);
    ball(&mut scene.surfaces.raw[0], 9, 12, |_, _| 1.0);
    for (at_m, normal, light) in direct_light(&scene) {
        let between = position_m - at_m;
        let truth = 3.0 * normal.dot(between).max(0.0) / between.length().powi(3);
        assert!((light - truth).abs() < 1e-9, "{light} is not {truth} at {at_m}");
    }
}

/// Half of a tube around the y axis as an open sheet of facets, its front outside; lit by a sun.
fn half_tube(direction: DVec3) -> Scene {
    let material = Material { double_sided: true, ..grey() };
    let mut scene = scene(material, LampKind::Directional { direction, irradiance: Rgb::ONE });
    let surface = &mut scene.surfaces.raw[0];
    for i in 0..=12 {
        let (x, z) = (PI * f64::from(i) / 12.0).sin_cos();
        for y in [0.0, 3.0] {
            surface.positions_m.push(DVec3::new(x, y, z).as_vec3().as_dvec3());
            surface.normals.push(DVec3::new(x, 0.0, z));
        }
    }
    for i in (0..24).step_by(2) {
        surface.polygons.extend([vec![i, i + 2, i + 3], vec![i, i + 3, i + 1]]);
    }
    scene
}

#[test]
fn nothing_shines_through_a_sheet() {
    // From the closed side, and grazing along it.
    for direction in [DVec3::NEG_X, DVec3::new(-1.0, 0.0, 0.9), DVec3::new(-0.2, 0.0, -1.0)] {
        let scene = half_tube(direction.normalize());
        let prepared = prepare(&scene, Progress::silent()).unwrap();
        let visibility = Visibility::new(&prepared);
        let direct = DirectLight::new(&scene, &prepared, &visibility);
        let (mut inside, mut lit) = (0, 0);
        for face in prepared.faces.keys() {
            let corners_m = prepared.polygon_m(face);
            let middle_m = corners_m.iter().sum::<DVec3>() / corners_m.len() as f64;
            for corner_m in corners_m {
                for share in [0.0, 0.3, 0.9, 0.999] {
                    let receiver = ReceiverPoint::on_face(&prepared, face, middle_m.lerp(corner_m, share));
                    let light = direct.at(&receiver).x;
                    let world_m = prepared.origin_m + receiver.position_m;
                    if receiver.normal.dot(world_m.with_y(0.0)) > 0.0 {
                        lit += usize::from(light > 0.1);
                        continue;
                    }
                    // Inside, the sun comes in through the open side at x = 0 alone.
                    let towards = -direction.normalize();
                    let to_opening = -world_m.x / towards.x;
                    let through = world_m + to_opening * towards;
                    let open = to_opening > 0.0 && through.z.abs() < 1.0;
                    assert!(open || light == 0.0, "{light} at {world_m} along {direction}");
                    inside += 1;
                }
            }
        }
        assert!(inside > 100 && lit > 20, "{inside} {lit}");
    }
}

/// Whether a ray from a point meets a triangle (Moeller and Trumbore).
fn meets(from_m: DVec3, direction: DVec3, [a, b, c]: [DVec3; 3]) -> bool {
    let (p, q) = (b - a, c - a);
    let across = direction.cross(q);
    let determinant = p.dot(across);
    let s = (from_m - a).dot(across) / determinant;
    let turned = (from_m - a).cross(p);
    let t = direction.dot(turned) / determinant;
    s >= 0.0 && t >= 0.0 && s + t <= 1.0 && q.dot(turned) / determinant > 0.0
}

#[test]
fn a_ball_that_is_sunk_into_another_shades_it_from_where_it_is() {
    let towards = DVec3::new(0.6, 0.0, 0.8);
    let mut scene = scene(grey(), LampKind::Directional { direction: -towards, irradiance: Rgb::ONE });
    ball(&mut scene.surfaces.raw[0], 9, 12, |_, _| 1.0);
    let mut head = Surface::new(NodeId::from(0), MaterialId::from(0));
    ball(&mut head, 9, 12, |_, _| 0.6);
    head.positions_m.iter_mut().for_each(|at_m| *at_m = (*at_m + 1.3 * DVec3::Z).as_vec3().as_dvec3());
    let triangles: Vec<[DVec3; 3]> =
        head.polygons.iter().map(|polygon| [0, 1, 2].map(|i| head.positions_m[polygon[i] as usize])).collect();
    scene.surfaces.push(head);
    let (mut shaded, mut lit) = (0, 0);
    // A point of an edge may lie on either side of a shadow's edge: those a hair to all sides must agree.
    for (at_m, normal, light) in direct_light(&scene) {
        if at_m.length() > 1.0 + 1e-6 || normal.dot(at_m.normalize()) < 0.9 || normal.dot(towards) < 0.5 {
            continue;
        }
        let hidden = |by: DVec3| triangles.iter().any(|&triangle| meets(at_m + 1e-3 * by, towards, triangle));
        let (u, v) = towards.any_orthonormal_pair();
        let all = [u, -u, v, -v].map(hidden);
        if all != [all[0]; 4] {
            continue;
        }
        let truth = if all[0] { 0.0 } else { normal.dot(towards) };
        assert!((light - truth).abs() < 1e-9, "{light} is not {truth} at {at_m}");
        *(if all[0] { &mut shaded } else { &mut lit }) += 1;
    }
    assert!(shaded > 50 && lit > 50, "{shaded} {lit}");
}

#[test]
fn a_normal_that_is_turned_away_counts_for_nothing() {
    let mut scene = scene(grey(), LampKind::Directional { direction: DVec3::NEG_Z, irradiance: Rgb::ONE });
    let surface = &mut scene.surfaces.raw[0];
    ball(surface, 9, 12, |_, _| 1.0);
    surface.normals[20] = DVec3::ZERO;
    surface.normals[40] = -surface.normals[40];
    let prepared = prepare(&scene, Progress::silent()).unwrap();
    // Six triangles meet at a corner of the ball; those that no other edge makes smooth are flat.
    assert!((1..=6).contains(&prepared.report.unusable_normals), "{}", prepared.report.unusable_normals);
    for face in prepared.faces.keys() {
        let front = prepared.normal(face);
        let worst = prepared.polygon_m(face).into_iter().map(|at_m| prepared.smooth_normal(face, at_m).dot(front));
        assert!(worst.fold(1.0, f64::min) > 0.9);
    }
}

/// The mean of the normals of the polygons around each corner.
fn mean_normals(surface: &mut Surface) {
    let mut sums = vec![DVec3::ZERO; surface.positions_m.len()];
    for polygon in &surface.polygons {
        let [a, b, c] = [0, 1, 2].map(|k| surface.positions_m[polygon[k] as usize]);
        polygon.iter().for_each(|&corner| sums[corner as usize] += (b - a).cross(c - a).normalize());
    }
    surface.normals = sums.into_iter().map(DVec3::normalize).collect();
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(6))]

    #[test]
    fn each_place_of_a_smooth_surface_has_one_light_on_each_side(
        dents in prop::collection::vec(0.98..1.02, 52), azimuth in 0.0..6.3, double_sided in any::<bool>(),
    ) {
        let mut scene = Scene::default();
        scene.nodes.push(Node::default());
        scene.materials.push(Material { double_sided, ..grey() });
        let mut surface = Surface::new(NodeId::from(0), MaterialId::from(0));
        ball(&mut surface, 6, 10, |number, _| dents[number as usize]);
        mean_normals(&mut surface);
        scene.surfaces.push(surface);
        // A panel: under a lamp without extent light would jump at true shadows.
        let glow = scene.materials.push_and_get_key(Material::emitting("panel", Rgb::splat(9.0)));
        let mut panel = Surface::new(NodeId::from(0), glow);
        let (away, up) = (DVec3::new(f64::cos(azimuth), f64::sin(azimuth), 0.0), DVec3::Z);
        let along = away.cross(up);
        panel.push_polygon([(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)].map(|(s, t)| 3.0 * away + s * along + t * up));
        scene.surfaces.push(panel);
        let bake = bake(&scene, &BakeSettings::default(), Progress::silent()).unwrap();
        let part = &bake.mesh.parts[0];
        let mut lights: BTreeMap<([u32; 3], bool), Vec<[u32; 3]>> = BTreeMap::new();
        for i in 0..part.positions_m.len() {
            let at_m = bake.mesh.origin_m + DVec3::from(part.positions_m[i].map(f64::from));
            let outside = DVec3::from(part.normals[i].map(f64::from)).dot(at_m) > 0.0;
            let key = (part.positions_m[i].map(f32::to_bits), outside);
            lights.entry(key).or_default().push(part.irradiance[i].map(f32::to_bits));
        }
        for ((place, _), mut light) in lights {
            light.dedup();
            prop_assert!(light.len() == 1, "{} lights at {:?}", light.len(), place.map(f32::from_bits));
        }
        prop_assert!(part.irradiance.iter().any(|light| light[0] > 0.5));
    }
}

#[test]
fn the_account_of_a_lamp_is_of_the_facets_that_its_rays_meet() {
    // Coarse facets show more by curved normals than falls on them; no light is lost or won for that.
    for (rings, sectors) in [(3, 4), (4, 6), (6, 9)] {
        let position_m = DVec3::new(0.6, 0.4, 1.3);
        let mut scene = scene(grey(), LampKind::Point { position_m, intensity: Rgb::ONE, range_m: None });
        ball(&mut scene.surfaces[SurfaceId::from(0)], rings, sectors, |_, _| 1.0);
        let report = bake(&scene, &BakeSettings::default(), Progress::silent()).unwrap().report;
        let account = &report.lamps[0];
        assert!(
            account.rays > 300 && account.error().abs() < 0.02,
            "{} for {rings} rings: {account:?}",
            account.error()
        );
    }
}
