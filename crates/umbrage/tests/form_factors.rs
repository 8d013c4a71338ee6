//! Form factors of whole scenes: rows of closed rooms sum to 1.
#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

use glam::{DVec2, DVec3};
use umbrage::geometry::polygon;
use umbrage::id::NodeId;
use umbrage::prepare::prepare;
use umbrage::progress::Progress;
use umbrage::scene::{Material, Node, Rgb, Scene, Surface};
use umbrage::transport::exact::{Effort, FactorTable, FactorTotals};
use umbrage::visibility::Visibility;

/// A prism over a counter-clockwise outline, between two heights, looking outward; without its bottom if it stands.
fn prism(outline: &[DVec2], heights: [f64; 2], stands: bool) -> Vec<Vec<DVec3>> {
    let at = |p: DVec2, z: f64| DVec3::new(p.x, p.y, z);
    let n = outline.len();
    let mut polygons: Vec<Vec<DVec3>> = (0..n)
        .map(|i| (outline[i], outline[(i + 1) % n]))
        .map(|(p, q)| vec![at(p, heights[0]), at(q, heights[0]), at(q, heights[1]), at(p, heights[1])])
        .collect();
    polygons.push(outline.iter().map(|&p| at(p, heights[1])).collect());
    if !stands {
        polygons.push(outline.iter().rev().map(|&p| at(p, heights[0])).collect());
    }
    polygons
}

fn rectangle(middle: DVec2, half: DVec2, turn_rad: f64) -> Vec<DVec2> {
    let corners = [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)];
    corners.map(|c| middle + DVec2::from_angle(turn_rad).rotate(DVec2::from(c) * half)).to_vec()
}

fn scene(polygons: Vec<Vec<DVec3>>) -> Scene {
    let mut scene = Scene::default();
    scene.nodes.push(Node::default());
    let material = scene.materials.push_and_get_key(Material::diffuse("grey", Rgb::splat(0.5)));
    let mut surface = Surface::new(NodeId::from(0), material);
    for polygon in polygons {
        surface.push_polygon(polygon);
    }
    scene.surfaces.push(surface);
    scene
}

/// Every face's middle, moved 1 mm to its front, its row sum and the bound of its error.
fn row_sums(scene: &Scene, tolerance: f64) -> Vec<(DVec3, f64, f64)> {
    let prepared = prepare(scene, Progress::silent()).unwrap();
    let visibility = Visibility::new(&prepared);
    let effort = Effort { tolerance, ..Effort::default() };
    let table = FactorTable::new(&prepared, &visibility, |_| true, |_| true, &effort, Progress::silent()).unwrap();
    let totals = table.totals(prepared.faces.len(), |face| Some(face.index()));
    for pair in &table.pairs {
        let least = pair.faces.map(|face| table.areas_m2[face]).into_iter().fold(f64::INFINITY, f64::min);
        assert!(pair.residual_m2.abs() <= 2.0 * tolerance * least, "one face tells another {pair:?}");
    }
    let before = |face| polygon::centroid(&prepared.polygon_m(face)) + 1e-3 * prepared.normal(face) + prepared.origin_m;
    let sum = |of: fn(&FactorTotals) -> f64, row: &[FactorTotals]| row.iter().map(of).sum::<f64>();
    let rows = prepared.faces.keys().zip(&totals);
    rows.map(|(face, row)| (before(face), sum(|t| t.factor, row), sum(|t| t.error_bound, row))).collect()
}

fn inward(polygons: Vec<Vec<DVec3>>) -> Vec<Vec<DVec3>> {
    polygons.into_iter().map(|polygon| polygon.into_iter().rev().collect()).collect()
}

#[test]
fn rows_of_a_skew_room_without_occluders_sum_to_one_within_rounding() {
    let outline = [(0.0, 0.0), (4.0, 0.3), (5.0, 2.0), (3.0, 4.0), (-0.5, 3.0)].map(DVec2::from);
    let sums = row_sums(&scene(inward(prism(&outline, [0.0, 2.5], false))), 1e-6);
    assert_eq!(sums.len(), 7);
    for (_, sum, bound) in sums {
        assert!((sum - 1.0).abs() < 1e-10 && bound < 1e-10, "{sum} within {bound}");
    }
}

#[test]
fn rows_of_a_room_of_boxes_sum_to_one() {
    let room = rectangle(DVec2::new(2.0, 1.5), DVec2::new(2.0, 1.5), 0.0);
    // One turned and on the floor, one in the floor's and a wall's contact, one that floats; none of them has a bottom
    // where it stands.
    let boxes = [
        (rectangle(DVec2::new(1.2, 1.0), DVec2::new(0.4, 0.3), 0.5), [0.0, 0.8], true),
        (rectangle(DVec2::new(3.5, 2.0), DVec2::new(0.5, 0.4), 0.0), [0.0, 1.5], true),
        (rectangle(DVec2::new(2.2, 1.9), DVec2::new(0.3, 0.2), 1.1), [1.2, 1.5], false),
    ];
    let mut polygons = inward(prism(&room, [0.0, 2.5], false));
    boxes.iter().for_each(|(outline, heights, stands)| polygons.extend(prism(outline, *heights, *stands)));
    let within = |outline: &[DVec2], p: DVec3| {
        let side = |i: usize| (outline[(i + 1) % outline.len()] - outline[i]).perp_dot(p.truncate() - outline[i]);
        (0..outline.len()).all(|i| side(i) > 0.0)
    };
    let buried = |p: DVec3| {
        !within(&room, p)
            || boxes.iter().any(|(outline, heights, _)| within(outline, p) && p.z < heights[1] && p.z > heights[0])
    };
    let (mut open, mut covered) = (0, 0);
    for (place, sum, bound) in row_sums(&scene(polygons), 2e-5) {
        if buried(place) {
            covered += 1;
            assert!(sum < 0.5, "{sum} at {place}");
        } else {
            open += 1;
            assert!((sum - 1.0).abs() < 1e-4, "{sum} within {bound} at {place}");
            assert!((sum - 1.0).abs() <= bound, "{sum} is not within {bound} at {place}");
        }
    }
    assert!(open > 20 && covered >= 4, "{open} {covered}");
}
