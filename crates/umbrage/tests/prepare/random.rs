//! Random scenes: boxes that stand on and touch each other on a grid, tilted polygons, and soups.

use glam::{DQuat, DVec3};
use proptest::prelude::*;
use umbrage::prepare::prepare;
use umbrage::progress::Progress;

use crate::build::{Build, RED, SHEET, WHITE};
use crate::check;

/// Cases of each property: the brute-force checks are quadratic.
const CASES: u32 = 64;

type Block = ([u8; 3], [u8; 3], bool);

fn block() -> impl Strategy<Value = Block> {
    let place = prop::array::uniform3(0..4_u8);
    (place, prop::array::uniform3(1..3_u8), any::<bool>())
}

/// Puts blocks on a floor, each where no earlier one is; two sides that touch are back to back, not overlapping.
fn room(blocks: &[Block], grid: f64) -> Build {
    let mut b = Build::new();
    b.floor(WHITE, [0.0, 0.0, 6.0 * grid, 6.0 * grid], 0.0).wall(WHITE, [0.0, 0.0, 6.0 * grid, 5.0 * grid], 0.0);
    let mut taken: Vec<([u8; 3], [u8; 3])> = Vec::new();
    for &(low, size, bottom) in blocks {
        let high = [0, 1, 2].map(|k| low[k] + size[k]);
        let hits = |(l, h): &([u8; 3], [u8; 3])| (0..3).all(|k| low[k] < h[k] && l[k] < high[k]);
        if !taken.iter().any(hits) {
            taken.push((low, high));
            let metres = |p: [u8; 3]| p.map(|x| f64::from(x) * grid);
            b.block(if bottom { RED } else { WHITE }, metres(low), metres(high), bottom);
        }
    }
    b
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(CASES))]

    #[test]
    fn blocks_on_a_grid(blocks in prop::collection::vec(block(), 1..8), grid in 0.1..3.0) {
        let scene = room(&blocks, grid).0;
        let p = prepare(&scene, Progress::silent()).unwrap();
        prop_assert_eq!(check::check(&scene, &p, 0.0), Ok(()));
    }

    #[test]
    fn blocks_on_a_turned_grid(
        blocks in prop::collection::vec(block(), 1..6),
        axis in prop::array::uniform3(-1.0..1.0),
        angle in 0.0..6.0,
        jitter in 0.0..1e-7,
    ) {
        let axis = DVec3::from(axis);
        prop_assume!(axis.length() > 0.1);
        let turn = DQuat::from_axis_angle(axis.normalize(), angle);
        let noise = |p: DVec3| jitter * DVec3::new((p.x * 91.7).sin(), (p.y * 57.3).sin(), (p.z * 71.9).cos());
        let scene = room(&blocks, 1.0).moved(|p| turn * p + noise(p) + DVec3::splat(20.0));
        let p = prepare(&scene, Progress::silent()).unwrap();
        prop_assert_eq!(check::check(&scene, &p, 0.0), Ok(()));
    }

    #[test]
    fn tilted_polygons_that_stand_on_a_floor(sheets in prop::collection::vec(
        (prop::array::uniform2(1.0..9.0), 0.0..6.3, 0.3..3.0, prop::array::uniform2(-1.0..1.0), 0.5..2.0), 1..6,
    )) {
        let mut b = Build::new();
        b.floor(WHITE, [0.0, 0.0, 10.0, 10.0], 0.0);
        for ([x, z], angle, length, [lean_x, lean_z], height) in sheets {
            let (from, along) = (DVec3::new(x, 0.0, z), DVec3::new(f64::cos(angle), 0.0, f64::sin(angle)) * length);
            let up = DVec3::new(lean_x, height, lean_z);
            let corners = [from, from + along, from + along + up, from + up].map(|p| p.to_array());
            b.polygon(SHEET, &corners);
        }
        let p = prepare(&b.0, Progress::silent()).unwrap();
        prop_assert_eq!(check::check(&b.0, &p, 0.0), Ok(()));
    }

    #[test]
    fn triangles_that_cross_anywhere(
        triangles in prop::collection::vec((prop::array::uniform3(prop::array::uniform3(0..4_i8)), 0..3_usize), 1..8),
        jitter in prop_oneof![Just(0.0), Just(1e-8)],
    ) {
        let mut b = Build::new();
        for (corners, material) in triangles {
            let place = |c: [i8; 3]| c.map(|x| f64::from(x) * (1.0 + jitter * f64::from(c[0] - 2 * c[1] + 3 * c[2])));
            b.polygon(material, &corners.map(place));
        }
        if let Ok(p) = prepare(&b.0, Progress::silent()) {
            prop_assert_eq!(check::check_topology(&p), Ok(()));
        }
    }

    #[test]
    fn a_soup_never_panics(polygons in prop::collection::vec(
        (prop::collection::vec(prop::array::uniform3(0..4_i8), 3..7), 0..3_usize, 0.0..1e-5), 1..8,
    )) {
        let mut b = Build::new();
        for (corners, material, jitter) in polygons {
            let place = |(i, c): (usize, [i8; 3])| c.map(|x| f64::from(x) + jitter * i as f64);
            let corners: Vec<_> = corners.into_iter().enumerate().map(place).collect();
            b.polygon(material, &corners);
        }
        if let Ok(p) = prepare(&b.0, Progress::silent()) {
            prop_assert_eq!(p.validate(), Ok(()));
        }
    }
}
