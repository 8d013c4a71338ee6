//! Scenes whose d-segments are known by hand. +Z is up; the floor is z = 0.

use std::f64::consts::TAU;

use glam::{DQuat, DVec2, DVec3, Vec2Swizzles as _};
use umbrage::bake::{Traced, trace};
use umbrage::discontinuity::{DSegment, Degree, Event, Features};
use umbrage::id::{EdgeId, VertexId};
use umbrage::progress::Progress;
use umbrage::visibility::Visibility;

use super::breaks::{self, Break};
use super::random::{Stage, all_moved, block, l_shape, moved, pyramid, rectangle};

/// Rounding of `f32` coordinates, magnified by a shadow, in metres.
const ROUNDING_M: f64 = 2e-5;

fn lamp(half: f64, at: DVec3) -> Vec<DVec3> {
    moved(&rectangle(half, half), DQuat::from_rotation_x(TAU / 2.0), at)
}

fn with_floor() -> Stage {
    let mut stage = Stage::default();
    stage.add(&rectangle(3.0, 3.0), 0.0);
    stage
}

/// d-segments in the world, on the floor or elsewhere.
struct Found {
    traced: Traced,
}

impl Found {
    fn of(stage: &Stage) -> Self {
        Self { traced: trace(&stage.scene, crate::all_sides(), 0.0, Progress::silent()).unwrap() }
    }

    fn world(&self, segment: &DSegment) -> [DVec3; 2] {
        segment.ends_m.map(|end| end + self.traced.prepared.origin_m)
    }

    /// The segments in the plane through `point` whose faces look along `normal`.
    fn on(&self, point: DVec3, normal: DVec3) -> Vec<&DSegment> {
        let lies = |segment: &&DSegment| {
            self.traced.prepared.normal(segment.face).dot(normal) > 0.9999
                && self.world(segment).iter().all(|end| (*end - point).dot(normal).abs() < ROUNDING_M)
        };
        self.traced.discontinuities.segments.iter().filter(lies).collect()
    }

    fn on_floor(&self) -> Vec<&DSegment> {
        self.on(DVec3::ZERO, DVec3::Z)
    }

    /// Whether pieces of segments of this degree cover the floor between two points.
    fn covers_on_floor(&self, degree: Degree, from: DVec2, to: DVec2) -> bool {
        let along = (to - from).normalize();
        let mut parts: Vec<[f64; 2]> = self
            .on_floor()
            .iter()
            .filter(|segment| segment.degree == degree)
            .map(|segment| self.world(segment).map(DVec3::truncate))
            .filter(|ends| ends.iter().all(|end| along.perp_dot(*end - from).abs() < ROUNDING_M))
            .map(|ends| {
                let [p, q] = ends.map(|end| along.dot(end - from));
                [p.min(q), p.max(q)]
            })
            .collect();
        parts.sort_by(|p, q| p[0].total_cmp(&q[0]));
        let reached = parts.iter().fold(0.0, |to, part| if part[0] <= to + ROUNDING_M { part[1].max(to) } else { to });
        reached >= from.distance(to) - ROUNDING_M
    }
}

fn count(segments: &[&DSegment], name: &str) -> usize {
    segments.iter().filter(|segment| segment.event.name() == name).count()
}

#[test]
fn a_parallel_plate_has_its_lines_at_half_and_one_and_a_half_and_their_strength() {
    let mut stage = with_floor();
    stage.add(&moved(&rectangle(0.5, 0.5), DQuat::IDENTITY, DVec3::Z), 0.0);
    stage.add(&lamp(0.5, 2.0 * DVec3::Z), 10.0);
    let found = Found::of(&stage);
    let on_floor = found.on_floor();
    assert_eq!((on_floor.len(), count(&on_floor, "edge-edge")), (8, 8));
    // The far lamp edge is seen upon the plate's edge from (1.5, 0): with y along it, r2 = 8 + y2, cosines 2 / r, the
    // sine of the plane sqrt(1/2), twice as far as the plate. The jump of slope is 4 L times the integral of dy / r4.
    let primitive = |y: f64| y / (16.0 * (8.0 + y * y)) + (y / 8f64.sqrt()).atan() / (16.0 * 8f64.sqrt());
    let expected = 4.0 * 10.0 * (primitive(0.5) - primitive(-0.5));
    for segment in on_floor {
        let middle = found.world(segment).map(DVec3::truncate).iter().sum::<DVec2>() / 2.0;
        let offset = middle.length();
        assert!((offset - 0.5).abs() < ROUNDING_M || (offset - 1.5).abs() < ROUNDING_M, "{offset}");
        assert!((segment.length_m() - 3.0).abs() < ROUNDING_M);
        if offset > 1.0 {
            assert!((segment.strength / expected - 1.0).abs() < 1e-5, "{} {expected}", segment.strength);
        }
    }
}

#[test]
fn a_turned_plate_has_a_line_for_every_vertex_and_edge() {
    let mut stage = with_floor();
    stage.add(&moved(&rectangle(0.5, 0.5), DQuat::from_rotation_z(0.4), DVec3::Z), 0.0);
    stage.add(&lamp(0.5, 2.0 * DVec3::Z), 10.0);
    let found = Found::of(&stage);
    let on_floor = found.on_floor();
    assert_eq!((count(&on_floor, "vertex-edge"), count(&on_floor, "edge-vertex"), on_floor.len()), (16, 16, 32));
    let Traced { prepared, .. } = &found.traced;
    for segment in on_floor {
        // The plate is half way: the floor sees a lamp's point through a plate's point at twice the latter less the
        // former.
        let (source, occluder) = match segment.event {
            Event::VertexEdge { source, occluder, .. } => ([source; 2], prepared.edges[occluder].ends),
            Event::EdgeVertex { source, occluder, .. } => (prepared.edges[source].ends, [occluder; 2]),
            _ => panic!("{segment:?}"),
        };
        let expected = [0, 1].map(|i| 2.0 * prepared.vertices_m[occluder[i]] - prepared.vertices_m[source[i]]);
        let same = |p: DVec3, q: DVec3| p.distance(q) < ROUNDING_M;
        let [p, q] = segment.ends_m;
        assert!(same(p, expected[0]) && same(q, expected[1]) || same(p, expected[1]) && same(q, expected[0]));
        assert_eq!(segment.degree, Degree::D2);
    }
}

#[test]
fn the_top_of_a_pyramid_casts_the_lamp_upside_down() {
    let mut stage = with_floor();
    stage.add_all(&all_moved(&pyramid(0.2, 1.0), DQuat::from_rotation_z(0.3), DVec3::ZERO), 0.0);
    stage.add(&lamp(0.2, DVec3::new(1.5, 0.0, 3.0)), 5.0);
    let found = Found::of(&stage);
    let Traced { prepared, .. } = &found.traced;
    let top = |segment: &&&DSegment| match segment.event {
        Event::EdgeVertex { occluder, .. } => (prepared.vertices_m[occluder] + prepared.origin_m).z > 0.9,
        _ => false,
    };
    // The lamp is 2 m above the top and the floor 1 m below: half as large, and on the other side.
    let corner = |x: f64, y: f64| DVec2::new(-0.75 + 0.1 * x, 0.1 * y);
    let corners = [corner(-1.0, -1.0), corner(1.0, -1.0), corner(1.0, 1.0), corner(-1.0, 1.0)];
    let on_floor = found.on_floor();
    for segment in on_floor.iter().filter(top) {
        for end in found.world(segment) {
            assert!(corners.iter().any(|corner| corner.distance(end.truncate()) < ROUNDING_M), "{end}");
        }
    }
    assert_eq!(on_floor.iter().filter(top).count(), 4);
}

#[test]
fn a_box_on_the_floor_touches_it_in_lines_of_degree_0() {
    let mut stage = with_floor();
    let standing = all_moved(&block(DVec3::new(0.5, 0.3, 0.4)), DQuat::IDENTITY, 0.4 * DVec3::Z);
    stage.add_all(&standing[1..], 0.0);
    stage.add(&lamp(0.2, DVec3::new(1.0, 1.5, 2.0)), 5.0);
    let found = Found::of(&stage);
    let corners = [(-0.5, -0.3), (0.5, -0.3), (0.5, 0.3), (-0.5, 0.3)].map(DVec2::from);
    for i in 0..4 {
        assert!(found.covers_on_floor(Degree::D0, corners[i], corners[(i + 1) % 4]), "side {i}");
    }
    // At the lit side no more can jump than the lamp gives there, as a point nearly: pi L A cos2 / (pi r2).
    let lit = found.on_floor().into_iter().find(|segment| {
        segment.degree == Degree::D0 && found.world(segment).iter().all(|end| (end.y - 0.3).abs() < ROUNDING_M)
    });
    let r2 = 1.0 + 1.2_f64.powi(2) + 4.0;
    let as_a_point = 5.0 * 0.16 * (4.0 / r2) / r2;
    assert!((lit.unwrap().strength / as_a_point - 1.0).abs() < 0.02);
}

#[test]
fn a_plate_a_millimetre_off_the_wall_casts_a_thin_penumbra() {
    let mut stage = with_floor();
    let upright = DQuat::from_rotation_x(TAU / 4.0);
    stage.add(&moved(&rectangle(3.0, 1.5), upright, DVec3::new(0.0, 3.0, 1.5)), 0.0);
    stage.add(&moved(&rectangle(0.05, 0.05), upright, DVec3::new(0.0, 3.0 - 1.0 / 1024.0, 1.5)), 0.0);
    // A lamp of the plate's directions, 2 m before it.
    stage.add(&moved(&rectangle(0.5, 0.5), DQuat::from_rotation_x(-TAU / 4.0), DVec3::new(0.0, 1.0, 1.5)), 5.0);
    let found = Found::of(&stage);
    let on_wall = found.on(DVec3::Y * 3.0, -DVec3::Y);
    let lines: Vec<_> = on_wall.iter().filter(|segment| segment.event.name() == "edge-edge").collect();
    assert_eq!(lines.len(), 8, "umbra and penumbra of four edges");
    let d = 1.0 / 1024.0;
    for segment in lines {
        let middle = found.world(segment).iter().sum::<DVec3>() / 2.0 - DVec3::new(0.0, 3.0, 1.5);
        let offset = middle.x.abs().max(middle.z.abs());
        // From the lamp's edge at +-0.5 past the plate's at 0.05, over d of 2 - d.
        let expected = [-0.5, 0.5].map(|source| 0.05 + (0.05 - source) * d / (2.0 - d));
        assert!(expected.iter().any(|e| (offset - e).abs() < ROUNDING_M), "{offset} {expected:?}");
    }
}

#[test]
fn all_six_edges_of_an_l_cast_the_inner_ones_too() {
    let mut stage = with_floor();
    let (outline, pieces) = l_shape(0.5);
    let lifted = |polygon: &Vec<DVec3>| moved(polygon, DQuat::IDENTITY, DVec3::Z);
    stage.add_in_pieces(&lifted(&outline), &pieces.each_ref().map(lifted), 0.0);
    stage.add(&lamp(0.2, 2.0 * DVec3::Z), 5.0);
    let found = Found::of(&stage);
    let on_floor = found.on_floor();
    assert!(on_floor.iter().all(|segment| segment.degree == Degree::D1));
    // Each edge at x = e casts at 2 e -+ 0.2, from 2 e0 - 0.2 to 2 e1 + 0.2, and likewise in y; at the inner corner
    // (0.5, 0.5) both inner edges are seen from all sides, since the L lies beside them.
    for (edge, from, to) in [(0.0, 0.0, 1.0), (1.0, 0.0, 0.5), (0.5, 0.5, 1.0)] {
        for source in [-0.2, 0.2] {
            let (at, from, to) = (2.0 * edge + source, 2.0 * from - 0.2, 2.0 * to + 0.2);
            let x = [DVec2::new(at, from), DVec2::new(at, to)];
            assert!(found.covers_on_floor(Degree::D1, x[0], x[1]), "{x:?}");
            assert!(found.covers_on_floor(Degree::D1, x[0].yx(), x[1].yx()), "{x:?}");
        }
    }
}

#[test]
fn a_triangular_lamp_has_three_corners_and_three_edges() {
    let mut stage = with_floor();
    stage.add(&moved(&rectangle(0.5, 0.5), DQuat::from_rotation_z(0.4), DVec3::Z), 0.0);
    let corners: Vec<DVec3> =
        (0..3).map(|i| DQuat::from_rotation_z(-f64::from(i) * TAU / 3.0) * (0.3 * DVec3::X) + 2.0 * DVec3::Z).collect();
    stage.add(&corners, 5.0);
    let found = Found::of(&stage);
    let on_floor = found.on_floor();
    assert_eq!((count(&on_floor, "vertex-edge"), count(&on_floor, "edge-vertex"), on_floor.len()), (12, 12, 24));
}

#[test]
fn edges_in_one_plane_need_not_be_parallel_to_make_one_line_of_degree_1() {
    let mut stage = with_floor();
    // The lamp's edge at x = 0.25, z = 2 and the plate's from (0.25, -0.3, 0.9) to (0.25, 0.4, 1.2) lie in x = 0.25.
    let plate = [DVec3::new(0.25, -0.3, 0.9), DVec3::new(0.25, 0.4, 1.2), DVec3::new(-0.6, 0.2, 1.1)];
    stage.add(&plate, 0.0);
    stage.add(&lamp(0.25, 2.0 * DVec3::Z), 5.0);
    let found = Found::of(&stage);
    let on_floor = found.on_floor();
    let on_line = |segment: &&&DSegment| found.world(segment).iter().all(|end| (end.x - 0.25).abs() < ROUNDING_M);
    let lines: Vec<_> = on_floor.iter().filter(on_line).collect();
    assert_eq!(lines.len(), 1, "{lines:?}");
    assert_eq!(lines[0].degree, Degree::D1);
    // Its ends: from the lamp's corner (y = 0.25) past the plate's end at y = -0.3, z = 0.9, and from -0.25 past 0.4,
    // 1.2.
    let mut y = found.world(lines[0]).map(|end| end.y);
    y.sort_by(f64::total_cmp);
    let expected = [0.25 + (-0.3 - 0.25) * 2.0 / 1.1, -0.25 + (0.4 + 0.25) * 2.0 / 0.8];
    assert!(y.iter().zip(expected).all(|(y, e)| (y - e).abs() < ROUNDING_M), "{y:?} {expected:?}");
}

#[test]
fn an_occluder_through_the_plane_of_the_lamp_casts_from_below_it_alone() {
    let mut stage = with_floor();
    let upright = DQuat::from_rotation_x(TAU / 4.0) * DQuat::from_rotation_y(0.3);
    // Upright, from 1 m to 3 m, the lamp at 2 m.
    stage.add(&moved(&rectangle(0.3, 1.0), upright, DVec3::new(0.9, 0.3, 2.0)), 0.0);
    stage.add(&lamp(0.25, 2.0 * DVec3::Z), 5.0);
    let found = Found::of(&stage);
    let Traced { prepared, discontinuities } = &found.traced;
    let height = |v: VertexId| (prepared.vertices_m[v] + prepared.origin_m).z;
    for segment in &discontinuities.segments {
        match segment.event {
            Event::EdgeVertex { occluder, .. } => assert!(height(occluder) < 2.0),
            Event::VertexEdge { occluder, .. } | Event::EdgeEdge { occluder, .. } => {
                assert!(prepared.edges[occluder].ends.map(height).iter().any(|&z| z < 2.0));
            }
            _ => {}
        }
    }
    assert!(count(&found.on_floor(), "vertex-edge") > 0 && count(&found.on_floor(), "edge-vertex") > 0);
}

#[test]
fn lines_of_an_occluder_through_the_floor_begin_where_it_pierces() {
    let mut stage = with_floor();
    // Upright in the plane y = 0.25, from 1 m below the floor to 1 m above.
    stage.add(&moved(&rectangle(0.5, 1.0), DQuat::from_rotation_x(TAU / 4.0), DVec3::Y * 0.25), 0.0);
    stage.add(&lamp(0.2, DVec3::new(0.1, 2.0, 3.0)), 5.0);
    let found = Found::of(&stage);
    assert!(found.covers_on_floor(Degree::D0, DVec2::new(-0.5, 0.25), DVec2::new(0.5, 0.25)));
    let Traced { prepared, .. } = &found.traced;
    let mut from_upright_edges = 0;
    for segment in found.on_floor() {
        let Event::VertexEdge { source, occluder, .. } = segment.event else { continue };
        let ends = prepared.edges[occluder].ends.map(|v| prepared.vertices_m[v] + prepared.origin_m);
        if ends[0].truncate().distance(ends[1].truncate()) < ROUNDING_M {
            // From the foot of the edge, away from the lamp's corner.
            let foot = ends[0].with_z(0.0);
            let [p, q] = found.world(segment);
            let (near, far) = if p.distance(foot) < q.distance(foot) { (p, q) } else { (q, p) };
            assert!(near.distance(foot) < ROUNDING_M, "{near} {foot}");
            let corner = prepared.vertices_m[source] + prepared.origin_m;
            assert!((foot - corner).truncate().perp_dot((far - foot).truncate()).abs() < ROUNDING_M);
            from_upright_edges += 1;
        }
    }
    assert_eq!(from_upright_edges, 8, "two edges, four corners");
}

/// Two lamps that share an edge in x = 0, and a plate with an edge parallel to it.
fn touching_lamps(radiances: [f64; 2]) -> Found {
    let mut stage = with_floor();
    stage.add(&moved(&rectangle(0.25, 0.25), DQuat::IDENTITY, DVec3::new(0.5, 0.0, 1.0)), 0.0);
    stage.add(&lamp(0.25, DVec3::new(-0.25, 0.0, 2.0)), radiances[0]);
    stage.add(&lamp(0.25, DVec3::new(0.25, 0.0, 2.0)), radiances[1]);
    Found::of(&stage)
}

#[test]
fn the_edge_between_touching_lamps_counts_with_their_difference() {
    // The edge at x = 0 and the plate's at x = 0.25 fall on x = 0.5.
    let strength = |radiances: [f64; 2]| {
        let found = touching_lamps(radiances);
        let at = |segment: &&&DSegment| found.world(segment).iter().all(|end| (end.x - 0.5).abs() < ROUNDING_M);
        let found: Vec<f64> = found.on_floor().iter().filter(at).map(|segment| segment.strength).collect();
        assert!(found.len() <= 1, "{found:?}");
        found.first().copied()
    };
    assert_eq!(strength([4.0, 4.0]), None);
    let (whole, half) = (strength([4.0, 0.0]).unwrap(), strength([4.0, 2.0]).unwrap());
    assert!((half / whole - 0.5).abs() < 1e-9, "{half} of {whole}");
    assert_eq!(strength([2.0, 4.0]), Some(half));
}

#[test]
fn a_lamp_in_the_corner_of_a_room_casts_no_line_of_its_own_plane() {
    let mut stage = Stage::default();
    let room: Vec<Vec<DVec3>> = all_moved(&block(DVec3::new(2.0, 2.0, 1.5)), DQuat::IDENTITY, 1.5 * DVec3::Z)
        .into_iter()
        .map(|mut wall| {
            wall.reverse();
            wall
        })
        .collect();
    // The ceiling around the lamp, which touches two walls, in two pieces.
    for (i, wall) in room.iter().enumerate() {
        if i != 1 {
            stage.add(wall, 0.0);
        }
    }
    let ceiling = |x: [f64; 2], y: [f64; 2]| {
        [(x[0], y[0]), (x[0], y[1]), (x[1], y[1]), (x[1], y[0])].map(|(x, y)| DVec3::new(x, y, 3.0))
    };
    stage.add(&ceiling([-2.0, 1.5], [-2.0, 2.0]), 0.0);
    stage.add(&ceiling([1.5, 2.0], [-2.0, 1.5]), 0.0);
    stage.add(&ceiling([1.5, 2.0], [1.5, 2.0]), 5.0);
    stage.add(&moved(&rectangle(0.2, 0.2), DQuat::from_rotation_z(0.3), DVec3::new(1.0, 1.0, 1.5)), 0.0);
    let found = Found::of(&stage);
    let all: Vec<&DSegment> = found.traced.discontinuities.segments.iter().collect();
    assert_eq!(count(&all, "source-plane") + count(&all, "contact"), 0);
    assert_eq!(count(&found.on_floor(), "vertex-edge"), 16);
}

#[test]
fn the_plane_of_an_upright_plate_under_a_lamp_is_a_line_of_degree_1() {
    let mut stage = with_floor();
    stage.add(&moved(&rectangle(0.5, 0.25), DQuat::from_rotation_x(TAU / 4.0), DVec3::new(0.0, 0.1, 1.0)), 0.0);
    stage.add(&lamp(0.25, 2.0 * DVec3::Z), 5.0);
    let found = Found::of(&stage);
    // Seen edge-on from y = 0.1, before the lamp: from its ends at +-0.25 past the plate's at +-0.5, 0.75 m, on the far
    // side of it.
    let reach = 0.25 + (0.5 + 0.25) * 2.0 / (2.0 - 1.25);
    assert_eq!(count(&found.on_floor(), "occluder-plane"), 1);
    let least = [DVec2::new(-1.4, 0.1), DVec2::new(1.4, 0.1)];
    assert!(reach > 1.4 && found.covers_on_floor(Degree::D1, least[0], least[1]));
}

#[test]
fn three_edges_leave_a_hyperbola_in_chords() {
    let mut stage = with_floor();
    // A lamp with an edge along x at y = 0, z = 3; a plate below with an edge along y at x = 0, z = 2; an upright plate
    // with an edge along z at (-0.3, 0.2).
    let rectangle = |x: [f64; 2], y: [f64; 2], z: f64| {
        [(x[0], y[0]), (x[1], y[0]), (x[1], y[1]), (x[0], y[1])].map(|(x, y)| DVec3::new(x, y, z)).to_vec()
    };
    stage.add(&rectangle([0.5, -0.5], [0.0, 0.4], 3.0), 5.0);
    stage.add(&rectangle([-1.0, 0.0], [-1.0, 1.0], 2.0), 0.0);
    let away = DVec3::new(-1.0, 0.7, 0.0);
    let foot = DVec3::new(-0.3, 0.2, 0.5);
    let top = foot + 1.3 * DVec3::Z;
    stage.add(&[foot, foot + away, top + away, top], 0.0);
    let found = Found::of(&stage);
    let Traced { prepared, .. } = &found.traced;
    let of_these = |segment: &&&DSegment| match segment.event {
        Event::ThreeEdges { source, occluders, .. } => {
            let ends = |edge: EdgeId| prepared.edges[edge].ends.map(|end| prepared.vertices_m[end] + prepared.origin_m);
            let flat =
                |edge: EdgeId, axis: DVec3| ends(edge)[0].dot(axis).abs().max(ends(edge)[1].dot(axis).abs()) < 1e-6;
            let upright = ends(occluders[1])[0].z != ends(occluders[1])[1].z;
            flat(source, DVec3::Y) && flat(occluders[0], DVec3::X) && upright
        }
        _ => false,
    };
    let on_floor = found.on_floor();
    let chords: Vec<[DVec2; 2]> =
        on_floor.iter().filter(of_these).map(|segment| found.world(segment).map(DVec3::truncate)).collect();
    assert!(chords.len() > 1);
    // From (t, 0, 3) past (0, a, 2), the floor is reached at (-2 t, 3 a), and (-0.3, 0.2) passed where a = 0.2 t / (t +
    // 0.3).
    let y = |x: f64| 0.6 * x / (x - 0.6);
    for ends in &chords {
        for end in ends {
            assert!((end.y - y(end.x)).abs() < ROUNDING_M, "{end}");
        }
        let middle = ends[0].midpoint(ends[1]);
        assert!((middle.y - y(middle.x)).abs() < 0.01);
    }
    // The upright edge ends at z = 0.5 and 1.8, the lamp at t = 0.5: from t = 0.2 on.
    let x = chords.as_flattened().iter().map(|end| end.x);
    let (least, most) = x.fold((f64::INFINITY, f64::NEG_INFINITY), |(least, most), x| (least.min(x), most.max(x)));
    assert!((least + 1.0).abs() < ROUNDING_M && (most + 0.4).abs() < ROUNDING_M, "{least} {most}");
    let span = DVec2::new(-1.0, y(-1.0)).distance(DVec2::new(-0.4, y(-0.4)));
    let whole: f64 = chords.iter().map(|ends| ends[0].distance(ends[1])).sum();
    assert!(whole > span && whole < 1.05 * span);
    let interval = on_floor.iter().find(of_these).and_then(|segment| segment.visible_interval(prepared));
    assert!(interval.is_some_and(|[from, to]| 0.0 <= from && from < to && to <= 0.3 + 1e-5), "{interval:?}");
}

/// The strengths of all d-segments along y = 0 on the floor at x = `x`, and the jump of slope that is measured there.
fn strengths_and_jump_at(stage: &Stage, x: f64) -> (Vec<f64>, f64) {
    let found = Found::of(stage);
    let Traced { prepared, .. } = &found.traced;
    let (features, visibility) = (Features::new(&stage.scene, prepared), Visibility::new(prepared));
    let at = DVec3::new(x, 0.0, 0.0);
    let here = |segment: &&DSegment| {
        let [p, q] = found.world(segment);
        p.y.abs().max(q.y.abs()) < ROUNDING_M && p.x.min(q.x) < x && x < p.x.max(q.x)
    };
    let strengths = found
        .on_floor()
        .into_iter()
        .filter(here)
        .map(|segment| features.jump(prepared, &visibility, segment, at - prepared.origin_m))
        .collect();
    let light = |t: f64| stage.world.irradiance(at + (t - 0.05) * DVec3::Y, DVec3::Z);
    let line = Break { from: 0.05 - 1e-5, to: 0.05 + 1e-5 };
    (strengths, breaks::jumps(&light, &line, 0.03, 0.07)[1].abs())
}

#[test]
fn boards_whose_fronts_lie_in_one_plane_jump_together() {
    for (name, lamp_middle_m) in [("across the lamp", 0.0), ("along its edge", 0.25), ("along its other edge", -0.25)] {
        for count in [1, 3] {
            let mut stage = with_floor();
            stage.add(&lamp(0.25, DVec3::new(0.0, lamp_middle_m, 2.5)), 10.0);
            for i in 0..count {
                let board = DVec3::new(0.5, 0.25, 0.0625);
                let at = DVec3::new(0.0, board.y, 0.5 + 0.5 * f64::from(i));
                stage.add_all(&all_moved(&block(board), DQuat::IDENTITY, at), 0.0);
            }
            let (strengths, jump) = strengths_and_jump_at(&stage, 0.125);
            assert!(!strengths.is_empty() && jump > 0.01, "{name}: {strengths:?} {jump}");
            for strength in strengths {
                assert!((strength - jump).abs() < 1e-3 * jump, "{count} boards {name}: {strength} {jump}");
            }
        }
    }
}

#[test]
fn upright_plates_in_one_plane_jump_together() {
    for lamp_middle_m in [0.0, 0.25] {
        let mut stage = with_floor();
        stage.add(&lamp(0.25, DVec3::new(0.0, lamp_middle_m, 2.5)), 10.0);
        for z in [0.5, 1.5] {
            let plate = moved(&rectangle(0.5, 0.25), DQuat::from_rotation_x(TAU / 4.0), z * DVec3::Z);
            stage.add(&plate, 0.0);
        }
        let (strengths, jump) = strengths_and_jump_at(&stage, 0.125);
        assert!(!strengths.is_empty() && jump > 0.01);
        for strength in strengths {
            assert!((strength - jump).abs() < 1e-3 * jump, "{lamp_middle_m}: {strength} {jump}");
        }
    }
}
