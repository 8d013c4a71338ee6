//! Curves on which light of lamps ends by itself: terminators, cones of spots, ranges.
#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

use std::f64::consts::{PI, TAU};

use glam::DVec3;
use umbrage::discontinuity::{DSegment, Degree, Event, LampCurve, find};
use umbrage::id::{MaterialId, NodeId};
use umbrage::prepare::{Prepared, prepare};
use umbrage::progress::Progress;
use umbrage::scene::{Lamp, LampKind, Material, Node, Rgb, Scene, Surface};
use umbrage::visibility::Visibility;

fn scene(lamp: LampKind) -> Scene {
    let mut scene = Scene::default();
    scene.nodes.push(Node::default());
    scene.materials.push(Material::diffuse("grey", Rgb::splat(0.5)));
    scene.surfaces.push(Surface::new(NodeId::from(0), MaterialId::from(0)));
    scene.lamps.push(Lamp { name: "lamp".into(), kind: lamp });
    scene
}

/// The d-segments of one curve.
fn curves(scene: &Scene, curve: LampCurve) -> (Prepared, Vec<DSegment>) {
    let prepared = prepare(scene, Progress::silent()).unwrap();
    let found = find(scene, &prepared, &Visibility::new(&prepared), 0.0, Progress::silent()).unwrap();
    let is_of = |segment: &&DSegment| matches!(segment.event, Event::LampCurve { curve: of, .. } if of == curve);
    let segments = found.segments.iter().filter(is_of).copied().collect();
    (prepared, segments)
}

fn length_m(segments: &[DSegment]) -> f64 {
    segments.iter().map(DSegment::length_m).sum()
}

/// A floor at z = 0, and a board over a part of it where y is greater than zero.
fn floor(lamp: LampKind, board: bool) -> Scene {
    let mut scene = scene(lamp);
    let surface = &mut scene.surfaces.raw[0];
    surface.push_polygon([(-4.0, -4.0), (4.0, -4.0), (4.0, 4.0), (-4.0, 4.0)].map(|(x, y)| DVec3::new(x, y, 0.0)));
    if board {
        surface.push_polygon([(-4.0, 0.0), (4.0, 0.0), (4.0, 4.0), (-4.0, 4.0)].map(|(x, y)| DVec3::new(x, y, 1.0)));
    }
    scene
}

fn spot(inner_rad: f64, outer_rad: f64) -> LampKind {
    let (position_m, direction, intensity) = (DVec3::new(0.3, 0.0, 2.0), DVec3::NEG_Z, Rgb::ONE);
    LampKind::Spot { position_m, direction, intensity, range_m: None, inner_rad, outer_rad }
}

#[test]
fn the_cones_of_a_spot_are_circles_on_a_floor() {
    let scene = floor(spot(0.2, 0.4), false);
    for (curve, angle, degree) in [(LampCurve::InnerCone, 0.2_f64, Degree::D1), (LampCurve::OuterCone, 0.4, Degree::D2)]
    {
        let (prepared, segments) = curves(&scene, curve);
        let radius_m = 2.0 * angle.tan();
        assert!((length_m(&segments) / (TAU * radius_m) - 1.0).abs() < 3e-3, "{}", length_m(&segments));
        for segment in segments {
            assert_eq!(segment.degree, degree);
            let ends = segment.ends_m.map(|end| prepared.origin_m + end - 0.3 * DVec3::X);
            assert!(ends.iter().all(|end| (end.length() - radius_m).abs() < 1e-6 && segment.strength > 0.0));
        }
    }
}

#[test]
fn a_spot_with_one_cone_has_a_hard_edge() {
    let (_, segments) = curves(&floor(spot(0.4 - 1e-9, 0.4), false), LampCurve::OuterCone);
    assert!(!segments.is_empty() && segments.iter().all(|segment| segment.degree == Degree::D0));
    // All light that arrives there, 1 W/sr from 2 m / cos 0.4, by the cosine to the floor.
    let jump = 0.4_f64.cos().powi(3) / 4.0;
    assert!(segments.iter().all(|segment| (segment.strength / jump - 1.0).abs() < 0.02), "{}", segments[0].strength);
}

#[test]
fn what_a_board_hides_has_no_curve() {
    let (prepared, segments) = curves(&floor(spot(0.2, 0.4), true), LampCurve::OuterCone);
    let on_floor: Vec<DSegment> =
        segments.into_iter().filter(|segment| (prepared.origin_m + segment.ends_m[0]).z < 0.5).collect();
    let half_m = PI * 2.0 * 0.4_f64.tan();
    assert!((length_m(&on_floor) / half_m - 1.0).abs() < 0.1, "{}", length_m(&on_floor));
}

#[test]
fn a_range_ends_in_a_circle() {
    let lamp = LampKind::Point { position_m: 2.0 * DVec3::Z, intensity: Rgb::ONE, range_m: Some(2.5) };
    let (_, segments) = curves(&floor(lamp, false), LampCurve::Range);
    assert!((length_m(&segments) / (TAU * 1.5) - 1.0).abs() < 3e-3, "{}", length_m(&segments));
}

#[test]
fn the_terminator_of_a_column_runs_along_it_and_lies_where_the_normal_says() {
    // The sun along a direction across the column: two lines, where the facets have their normals at right angles to it.
    let direction = DVec3::new(-0.8, -0.6, 0.0);
    let mut scene = scene(LampKind::Directional { direction, irradiance: Rgb::ONE });
    let surface = &mut scene.surfaces.raw[0];
    for i in 0..10 {
        let (y, x) = (TAU * f64::from(i) / 10.0).sin_cos();
        for z in [0.0, 3.0] {
            surface.positions_m.push(DVec3::new(x, y, z).as_vec3().as_dvec3());
            surface.normals.push(DVec3::new(x, y, 0.0));
        }
    }
    for i in 0..10 {
        let (a, b) = (2 * i, (2 * i + 2) % 20);
        surface.polygons.push(vec![a, b, b + 1, a + 1]);
    }
    let (prepared, segments) = curves(&scene, LampCurve::Terminator);
    assert!((length_m(&segments) - 6.0).abs() < 1e-5, "{}", length_m(&segments));
    for segment in segments {
        for end in segment.ends_m {
            assert!(prepared.smooth_normal(segment.face, end).dot(direction).abs() < 1e-6);
        }
        // The slope of the cosine across: of a normal that turns by 36 degrees over a chord.
        let slope = 2.0 * (PI / 10.0).tan() / (2.0 * (PI / 10.0).sin());
        assert!((segment.strength / slope - 1.0).abs() < 0.3, "{} is not about {slope}", segment.strength);
    }
}
