//! Everything that is wrong with the scenes that people have, thrown into a sound room at random.
//!
//! Each kind of defect is tried by itself, so that a failure says its name, and then all of them together.

use glam::{DQuat, DVec3};
use proptest::prelude::*;
use proptest::test_runner::{RngSeed, TestRunner};
use umbrage::bake::{BakeSettings, bake};
use umbrage::id::SurfaceId;
use umbrage::prepare::{PrepareError, prepare};
use umbrage::progress::Progress;
use umbrage::scene::Scene;

use crate::build::{Build, RED, SHEET, WHITE};
use crate::check;

/// Rooms of each kind of defect.
const CASES: u32 = 24;

/// A way to spoil a room of 6 x 6 x 5 m. The numbers are between 0 and 1.
type Spoil = fn(&mut Build, [f64; 6]);

const KINDS: [(&str, Spoil); 12] = [
    ("coplanar", |b, [x, y, w, h, ..]| {
        b.wall(RED, [5.0 * x, 4.0 * y, 5.0 * x + 0.1 + w, 4.0 * y + 0.1 + h], 0.0);
    }),
    ("nearly coplanar", |b, [x, z, w, h, up, _]| {
        // Within the tolerance of a plane, or far beyond it: the check cannot tell what lies between.
        let up = if up < 0.5 { 1e-6 * (up - 0.25) } else { 1e-3 * up };
        b.floor(SHEET, [4.0 * x, 4.0 * z, 4.0 * x + 0.1 + w, 4.0 * z + 0.1 + h], up);
    }),
    ("touching", |b, [x, z, w, h, up, _]| {
        b.block(RED, [4.0 * x, 0.0, 4.0 * z], [4.0 * x + 0.1 + w, 0.1 + up, 4.0 * z + 0.1 + h], true);
        b.block(WHITE, [4.0 * x, 0.1 + up, 4.0 * z], [4.0 * x + 0.1 + w / 2.0, 1.3 + up, 4.0 * z + 0.1 + h], true);
    }),
    ("sharing edges", |b, [x, z, w, up, ..]| {
        let (x0, x1, z) = (5.0 * x, 5.0 * x + 0.1 + w, 5.0 * z);
        b.polygon(RED, &[[x0, 0.0, z], [x1, 0.0, z], [x1, 0.1 + up, z], [x0, 0.1 + up, z]]);
        b.polygon(SHEET, &[[x0, 0.0, z], [x1, 0.0, z], [x1, 0.1 + up, z + 0.5], [x0, 0.1 + up, z + 0.5]]);
        b.polygon(WHITE, &[[x1, 0.0, z], [x0, 0.0, z], [x0, 0.0, z + 0.7], [x1, 0.0, z + 0.7]]);
    }),
    ("turned by 1e-9", |b, [x, y, z, ..]| {
        let turn = DQuat::from_scaled_axis(1e-9 * DVec3::new(x - 0.5, y - 0.5, z - 0.5));
        let turned = b.moved(|p| turn * p);
        b.0.surfaces.extend(turned.surfaces.iter().cloned());
    }),
    ("duplicated", |b, [x, ..]| {
        let times = 1 + (3.0 * x) as usize;
        let all: Vec<_> = b.0.surfaces.iter().cloned().collect();
        (0..times).for_each(|_| b.0.surfaces.extend(all.iter().cloned()));
    }),
    ("sliver", |b, [x, z, w, thin, up, _]| {
        let thin = 10_f64.powf(-1.0 - 9.0 * thin);
        b.polygon(RED, &[[5.0 * x, up, z], [5.0 * x + w + 0.1, up, z], [5.0 * x + w + 0.1, up + thin, z + thin]]);
    }),
    ("needle", |b, [x, z, thin, up, ..]| {
        let (x, z, thin) = (5.0 * x, 5.0 * z, 10_f64.powf(-1.0 - 9.0 * thin));
        b.block(RED, [x, 0.0, z], [x + thin, 0.5 + up, z + thin], true);
    }),
    ("bow-tie", |b, [x, y, w, h, turn, _]| {
        let corners = [[0.0, 0.0], [1.0 + w, 1.0 + h], [1.0 + w, 0.0], [0.0, 1.2]];
        let at = |[u, v]: [f64; 2]| [4.0 * x + u, 0.5 * y + v, 2.0 * turn + 0.3 * u];
        b.polygon(SHEET, &corners.map(at));
    }),
    ("without area", |b, [x, y, z, ..]| {
        let p = DVec3::new(5.0 * x, 4.0 * y, 5.0 * z);
        let on_line = |t: f64| (p + t * DVec3::new(0.3, 0.2, 0.1)).to_array();
        b.polygon(RED, &[on_line(0.0), on_line(1.0), on_line(2.0), on_line(0.5)]);
        b.polygon(WHITE, &[p.to_array(); 5]);
        b.polygon(SHEET, &[on_line(0.0), on_line(1.0), on_line(0.0), on_line(1.0)]);
    }),
    ("crossing", |b, [x, y, z, w, turn, _]| {
        let turn = DQuat::from_rotation_y(6.0 * turn) * DQuat::from_rotation_x(6.0 * w);
        let square = [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]];
        let middle = DVec3::new(6.0 * x, 2.0 * y, 6.0 * z);
        b.polygon(SHEET, &square.map(|[u, v]| (middle + turn * DVec3::new(u, v, 0.0)).to_array()));
    }),
    ("bent", |b, [x, y, z, w, ..]| {
        let bend = 10_f64.powf(-8.0 * w);
        b.polygon(
            RED,
            &[[x, y, z], [x + 1.0, y, z], [x + 1.0, y + 1.0, z + bend], [x, y + 1.0, z], [x - 0.5, y + 0.5, z]],
        );
    }),
];

/// A floor, a wall and two blocks that touch.
fn room() -> Build {
    let mut b = Build::new();
    b.floor(WHITE, [0.0, 0.0, 6.0, 6.0], 0.0).wall(WHITE, [0.0, 0.0, 6.0, 5.0], 0.0);
    b.block(RED, [1.0, 0.0, 1.0], [2.0, 1.0, 2.0], false).block(WHITE, [2.0, 0.0, 1.0], [3.0, 2.0, 2.0], true);
    b
}

fn runner() -> TestRunner {
    TestRunner::new(ProptestConfig {
        cases: CASES,
        rng_seed: RngSeed::Fixed(7),
        failure_persistence: None,
        ..ProptestConfig::default()
    })
}

fn sound(scene: &Scene) -> Result<(), TestCaseError> {
    match prepare(scene, Progress::silent()) {
        Ok(p) => check::check_topology(&p).map_err(TestCaseError::fail),
        Err(PrepareError::NoArea { .. }) => Err(TestCaseError::fail("the room has area")),
        Err(error) => Err(TestCaseError::fail(error.to_string())),
    }
}

#[test]
fn each_defect_by_itself_leaves_faces_that_meet_in_edges() {
    for (name, spoil) in KINDS {
        let spoilt = prop::collection::vec(prop::array::uniform6(0.0..1.0), 1..4);
        let tried = runner().run(&spoilt, |numbers| {
            let mut b = room();
            numbers.into_iter().for_each(|numbers| spoil(&mut b, numbers));
            sound(&b.0)
        });
        assert!(tried.is_ok(), "{name}: {}", tried.unwrap_err());
    }
}

#[test]
fn all_defects_together_leave_faces_that_meet_in_edges_wherever_the_scene_is() {
    let spoilt = prop::collection::vec((0..KINDS.len(), prop::array::uniform6(0.0..1.0)), 2..6);
    let placed = (prop::sample::select(vec![0.0, 1e3, 1e6]), prop::sample::select(vec![1e-3, 1.0, 1e3]));
    let tried = runner().run(&(spoilt, placed), |(spoilt, (shift, scale))| {
        let mut b = room();
        for (kind, numbers) in spoilt {
            KINDS[kind].1(&mut b, numbers);
        }
        sound(&b.moved(|p| scale * (p + DVec3::splat(shift))))
    });
    assert!(tried.is_ok(), "{}", tried.unwrap_err());
}

#[test]
fn what_no_scene_may_have_is_refused_by_name_and_place() {
    let refused = |spoil: fn(&mut Scene)| {
        let mut scene = room().0;
        scene.materials.raw[1].radiance = DVec3::ONE;
        spoil(&mut scene);
        bake(&scene, &BakeSettings::default(), Progress::silent()).unwrap_err().to_string()
    };
    let red = SurfaceId::from(RED);
    for (spoil, words) in [
        ((|s: &mut Scene| s.surfaces[SurfaceId::from(RED)].positions_m[3].y = f64::NAN) as fn(&mut Scene), "finite"),
        (|s| s.surfaces[SurfaceId::from(RED)].positions_m[3].x = f64::INFINITY, "finite"),
        (|s| s.surfaces[SurfaceId::from(RED)].polygons[1][2] = u32::MAX, "4294967295"),
    ] {
        let message = refused(spoil);
        assert!(message.contains(words) && message.contains("red"), "{message}");
    }
    assert_eq!(room().0.surfaces[red].polygons.len(), 5);
}
