//! A coarse bake of small polygon soups with bulbs, spots and suns, which may lie on corners, edges and faces.
//!
//! As in `bake`, corners lie on a grid of eight; lamps too, or off it by a little.
#![no_main]

#[path = "../../crates/umbrage/tests/common/mod.rs"]
mod common;

use glam::DVec3;
use umbrage::id::{MaterialId, NodeId, SurfaceId};
use umbrage::scene::{Lamp, LampKind, Material, Node, Rgb, Scene, Surface};
use umbrage_fuzz::coarse_bake;

/// Polygons of a soup at most: a bake should take milliseconds.
const MOST_POLYGONS: usize = 4;
/// How far a lamp may be off its place on the grid, in metres.
const OFF_M: [f64; 4] = [0.0, 3e-13, 1e-6, 1e-2];

fn soup(bytes: &[u8]) -> Option<Scene> {
    let mut bytes = bytes.iter().copied();
    let mut scene = Scene::default();
    scene.nodes.push(Node::default());
    let grey = Material { double_sided: bytes.next()? & 1 == 1, ..Material::diffuse("grey", Rgb::splat(0.5)) };
    let material: MaterialId = scene.materials.push_and_get_key(grey);
    scene.surfaces.push(Surface::new(NodeId::from(0), material));
    let lamps = 1 + bytes.next()? % 3;
    let mut point = || Some(DVec3::from([bytes.next()?, bytes.next()?, bytes.next()?].map(|byte| f64::from(byte & 7))));
    for number in 0..lamps {
        let (position_m, towards) = (point()?, point()? - DVec3::splat(3.5));
        let off_m = OFF_M[(position_m.element_sum() as usize) % 4];
        let (position_m, direction) = (position_m + DVec3::splat(off_m), towards.normalize());
        let intensity = Rgb::splat(5.0);
        let kind = match number {
            0 => LampKind::Point { position_m, intensity, range_m: None },
            1 => LampKind::Spot { position_m, direction, intensity, range_m: None, inner_rad: 0.2, outer_rad: 0.6 },
            _ => LampKind::Directional { direction, irradiance: intensity },
        };
        scene.lamps.push(Lamp { name: format!("lamp {number}"), kind });
    }
    for _ in 0..MOST_POLYGONS {
        let (Some(a), Some(b), Some(c)) = (point(), point(), point()) else { break };
        scene.surfaces[SurfaceId::from(0)].push_polygon([a, b, c]);
    }
    Some(scene)
}

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| {
    let Some(scene) = soup(bytes) else { return };
    let Some(baked) = coarse_bake(&scene) else { return };
    let triangles = common::lit_triangles(&baked);
    assert_eq!(common::degenerate(&triangles, 1e-6 * common::extent(&triangles)), 0);
});
