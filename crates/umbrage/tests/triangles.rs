//! Triangles are never more than were allowed, whatever the scene; where its shapes alone need more, the bake says how many.

#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

use glam::{DQuat, DVec3};
use proptest::prelude::*;
use proptest::strategy::ValueTree;
use umbrage::bake::{Bake, BakeError, BakeSettings, bake};
use umbrage::id::NodeId;
use umbrage::progress::Progress;
use umbrage::scene::{Lamp, LampKind, Material, Node, Rgb, Scene, Surface};
use umbrage::shade::ShadeSettings;

/// The sides of a box, looking outward.
fn block(lo: DVec3, hi: DVec3) -> Vec<Vec<DVec3>> {
    let corner = |x: usize, y: usize, z: usize| DVec3::new([lo.x, hi.x][x], [lo.y, hi.y][y], [lo.z, hi.z][z]);
    vec![
        vec![corner(0, 0, 1), corner(1, 0, 1), corner(1, 1, 1), corner(0, 1, 1)],
        vec![corner(0, 0, 0), corner(0, 1, 0), corner(1, 1, 0), corner(1, 0, 0)],
        vec![corner(0, 0, 0), corner(1, 0, 0), corner(1, 0, 1), corner(0, 0, 1)],
        vec![corner(0, 1, 0), corner(0, 1, 1), corner(1, 1, 1), corner(1, 1, 0)],
        vec![corner(0, 0, 0), corner(0, 0, 1), corner(0, 1, 1), corner(0, 1, 0)],
        vec![corner(1, 0, 0), corner(1, 1, 0), corner(1, 1, 1), corner(1, 0, 1)],
    ]
}

/// A floor with boxes that stand on it or over it and may touch, a tilted plate that two sheets meet at, and lamps of all kinds. The
/// last surface may be one that is not baked.
fn scene() -> impl Strategy<Value = Scene> {
    let boxes = proptest::collection::vec(((0u8..5, 0u8..5, 0u8..3), (1u8..3, 1u8..3, 1u8..3)), 0..4);
    (boxes, 0.0..1.5, 0.0..3.0, 0usize..8, any::<bool>()).prop_map(|(boxes, lean, turn, lights, baked)| {
        let mut scene = Scene::default();
        scene.nodes.push(Node::default());
        let grey = scene.materials.push_and_get_key(Material::diffuse("grey", Rgb::splat(0.5)));
        let glow = scene.materials.push_and_get_key(Material::emitting("glow", Rgb::splat(5.0)));
        let square = [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)].map(|(x, y)| DVec3::new(x, y, 0.0));
        let mut add = |polygons: Vec<Vec<DVec3>>, material, baked| {
            let mut surface = Surface::new(NodeId::from(0), material);
            surface.baked = baked;
            polygons.into_iter().for_each(|polygon| surface.push_polygon(polygon));
            scene.surfaces.push(surface);
        };
        add(vec![square.map(|p| 4.0 * p + DVec3::new(2.0, 2.0, 0.0)).to_vec()], grey, true);
        for ((x, y, z), (w, h, d)) in boxes {
            let lo = DVec3::new(f64::from(x), f64::from(y), 0.5 * f64::from(z));
            add(block(lo, lo + 0.7 * DVec3::new(f64::from(w), f64::from(h), f64::from(d))), grey, true);
        }
        let rotation = DQuat::from_rotation_z(turn) * DQuat::from_rotation_x(lean);
        let plate = square.map(|p| DVec3::new(2.0, 2.0, 2.5) + rotation * p);
        add(vec![plate.to_vec(), plate.iter().rev().copied().collect()], grey, baked);
        if lights & 1 == 1 {
            let lamp = square.map(|p| DVec3::new(1.0, 1.5, 4.0) + 0.5 * DVec3::new(p.y, p.x, 0.0));
            add(vec![lamp.to_vec()], glow, true);
        }
        let kinds = [
            LampKind::Point { position_m: DVec3::new(3.1, 1.2, 3.7), intensity: Rgb::splat(9.0), range_m: None },
            LampKind::Directional { direction: DVec3::new(-0.48, 0.36, -0.8), irradiance: Rgb::ONE },
        ];
        for (i, kind) in kinds.into_iter().enumerate() {
            if lights & (2 << i) != 0 || lights == 0 {
                scene.lamps.push(Lamp { name: String::new(), kind });
            }
        }
        scene
    })
}

fn baked(scene: &Scene, tolerance: f64, max_triangles: usize) -> Result<Bake, BakeError> {
    let shade = ShadeSettings { tolerance, max_triangles };
    bake(scene, &BakeSettings { shade, ..BakeSettings::default() }, Progress::silent())
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 24, ..ProptestConfig::default() })]
    #[test]
    fn no_more_triangles_are_made_than_are_allowed(scene in scene(), over in 0usize..400, fine in 0usize..3) {
        let tolerance = [0.02, 0.2, f64::INFINITY][fine];
        let is_refused = matches!(baked(&scene, tolerance, 0), Err(BakeError::TooFewTriangles { asked: 0, .. }));
        prop_assert!(is_refused);
        let Err(BakeError::TooFewTriangles { needed, .. }) = baked(&scene, tolerance, 1) else {
            return Err(TestCaseError::fail("a floor needs more than one triangle"));
        };
        prop_assert!(baked(&scene, tolerance, needed - 1).is_err());
        let least = baked(&scene, tolerance, needed).map_err(|error| TestCaseError::fail(error.to_string()))?;
        prop_assert!(least.mesh.triangle_count() <= needed);
        let bake = baked(&scene, tolerance, needed + over).map_err(|error| TestCaseError::fail(error.to_string()))?;
        prop_assert!(bake.mesh.triangle_count() <= needed + over);
        prop_assert_eq!(bake.report.triangles, bake.mesh.triangle_count());
        prop_assert_eq!(bake.mesh.validate(), Ok(()));
    }
}

#[test]
fn what_is_allowed_is_used_and_lessens_the_error() {
    let mut runner = proptest::test_runner::TestRunner::deterministic();
    let scene = scene().new_tree(&mut runner).unwrap().current();
    let mut last = f64::INFINITY;
    for most in [100, 200, 400, 800] {
        let bake = baked(&scene, 1e-3, most).unwrap();
        let triangles = bake.mesh.triangle_count();
        assert!(triangles <= most && triangles >= most - most / 20, "{triangles} of {most}");
        assert!(bake.report.error < last, "{} with {most}", bake.report.error);
        last = bake.report.error;
    }
}

#[test]
fn a_limit_out_of_reach_changes_nothing() {
    let mut runner = proptest::test_runner::TestRunner::deterministic();
    let scene = scene().new_tree(&mut runner).unwrap().current();
    let [free, limited] = [usize::MAX, 1_000_000].map(|most| baked(&scene, 0.02, most).unwrap());
    assert_eq!(free.mesh, limited.mesh);
    assert_eq!(limited.report.uncut, 0);
}
