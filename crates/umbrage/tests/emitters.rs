//! Emitters of many polygons: what they cast does not depend on how they are divided, and bakes end.

#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

mod common;

use glam::{DVec2, DVec3};
use umbrage::bake::{Bake, BakeSettings, GatherKind, bake};
use umbrage::id::{NodeId, SurfaceId};
use umbrage::progress::Progress;
use umbrage::scene::{Image, Material, Node, Rgb, Scene, Surface, Texture, Wrap};
use umbrage::shade::ShadeSettings;

fn scene_of(polygons: impl IntoIterator<Item = (usize, Vec<DVec3>, Vec<DVec2>)>, materials: Vec<Material>) -> Scene {
    let mut scene = Scene::default();
    scene.nodes.push(Node::default());
    scene.images.push(Image { name: None, bytes: Vec::new().into() });
    for material in materials {
        let material = scene.materials.push_and_get_key(material);
        scene.surfaces.push(Surface::new(NodeId::from(0), material));
    }
    for (surface, corners, uvs) in polygons {
        scene.surfaces[SurfaceId::from(surface)].push_polygon(corners);
        scene.surfaces[SurfaceId::from(surface)].uvs.extend(uvs);
    }
    scene
}

fn baked(scene: &Scene, gather: GatherKind) -> Bake {
    let shade = ShadeSettings { tolerance: 0.05, ..ShadeSettings::default() };
    bake(scene, &BakeSettings { shade, gather, ..BakeSettings::default() }, Progress::silent()).unwrap()
}

fn level([x0, z0]: [f64; 2], [x1, z1]: [f64; 2], y: f64, up: bool) -> Vec<DVec3> {
    let corners = [[x0, z1], [x1, z1], [x1, z0], [x0, z0]].map(|[x, z]| DVec3::new(x, y, z)).to_vec();
    if up { corners } else { corners.into_iter().rev().collect() }
}

/// Plates over a floor, under a sky of `n` by `n` tiles with a picture each.
fn under_tiles(n: usize) -> Scene {
    let picture = Texture { image: 0.into(), wrap: [Wrap::Repeat; 2], filters: [None; 2], factor: Rgb::ONE };
    let mut sky = Material::emitting("sky", Rgb::ONE);
    sky.look.texture = Some(picture);
    let plates = [[-0.9, -0.7], [0.2, 0.3], [-0.4, 0.5]]
        .map(|[x, z]| (0, level([x, z], [x + 0.5, z + 0.3], 0.4, true), Vec::new()));
    let floor = (0, level([-2.0, -2.0], [2.0, 2.0], 0.0, true), Vec::new());
    let at = |i: usize| 4.0 * i as f64 / n as f64 - 2.0;
    let tile = |(i, j): (usize, usize)| {
        let uvs = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]].map(DVec2::from).to_vec();
        (1, level([at(i), at(j)], [at(i + 1), at(j + 1)], 2.0, false), uvs)
    };
    let tiles = (0..n).flat_map(|i| (0..n).map(move |j| (i, j))).map(tile);
    scene_of(plates.into_iter().chain([floor]).chain(tiles), vec![Material::diffuse("grey", Rgb::splat(0.5)), sky])
}

#[test]
fn a_sky_of_tiles_gives_the_light_of_one() {
    let [one, many] = [1, 9].map(|n| baked(&under_tiles(n), GatherKind::Faces));
    assert_eq!(many.report.faces, one.report.faces + 80, "each tile has a picture of its own");
    let shares = [one.report.triangles, many.report.triangles - 160].map(|triangles| triangles as f64);
    assert!((0.8..1.25).contains(&(shares[1] / shares[0])), "{shares:?} triangles");
    assert!(many.report.energy.error().abs() < 0.01, "{}", many.report.energy.error());
    // The same light at the same places: both meshes but for the sky.
    let lit = |bake: &Bake| {
        let triangles = common::lit_triangles(&bake.mesh);
        let below = triangles.into_iter().filter(|t| t.corners.iter().all(|p| p.y < 1.0));
        below.map(|t| t.area() * t.irradiance.iter().map(|e| e.x).sum::<f64>() / 3.0).sum::<f64>()
    };
    let [one, many] = [lit(&one), lit(&many)];
    assert!((many - one).abs() < 0.003 * one, "{many} W instead of {one}");
}

#[test]
fn where_nothing_shows_light_there_is_no_error_of_it() {
    let lamp = |i: usize| {
        let at = DVec3::new(0.37 * (i % 9) as f64, 0.41 * (i / 9 % 9) as f64, 0.43 * (i / 81) as f64);
        (0, [DVec3::ZERO, 0.05 * DVec3::X, 0.05 * DVec3::Z].map(|p| p + at).to_vec(), Vec::new())
    };
    let scene = scene_of((0..400).map(lamp), vec![Material::emitting("lamp", Rgb::ONE)]);
    let baked = baked(&scene, GatherKind::Regression);
    assert_eq!(baked.report.error, 0.0);
}
