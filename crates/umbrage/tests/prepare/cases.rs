//! Rooms, boxes and walls whose faces are known.

use glam::DVec3;
use umbrage::id::FaceId;
use umbrage::scene::cornell;

use crate::build::{Build, RED, SHEET, WHITE};
use crate::check::{face_area_m2, face_under, faces_at, facings, length_along_m, prepared};

const UP: [f64; 3] = [0.0, 1.0, 0.0];

#[test]
fn the_cornell_box() {
    let p = prepared(&cornell::cornell_box(), 0.0);
    // The ceiling surrounds the light: four faces are enough, and no fewer are convex.
    assert_eq!(faces_at(&p, 0, [0.0, -1.0, 0.0], [0.1, 0.5488, 0.1]).len(), 4);
    // The wall bends by 3.2 mm: two planes, which the ids tell apart.
    let red: Vec<_> = p.faces.iter().filter(|f| f.surface.index() == 1).collect();
    assert_eq!(red.len(), 2);
    assert_ne!(red[0].plane, red[1].plane);
    // The floor is cut around both blocks, and what is under them are faces of their own.
    for [x, z, area] in [[0.186, 0.169, 0.16 * 0.165], [0.368, 0.351, 0.1655 * 0.1665]] {
        let under = face_under(&p, UP, [x, 0.0, z]).unwrap();
        assert!((face_area_m2(&p, under) - area).abs() < 0.05 * area, "{}", face_area_m2(&p, under));
    }
    let area = |surface: usize| {
        p.faces.keys().filter(|&f| p.faces[f].surface.index() == surface).map(|f| face_area_m2(&p, f)).sum::<f64>()
    };
    assert!((area(3) - 0.13 * 0.105).abs() < 1e-7);
    assert_eq!(p.report.welded_corners, 78 - 28);
    assert_eq!(p.report.contact_edges, 8);
    assert_eq!(p.report.nonplanar_polygons, 0);
}

#[test]
fn a_wall_of_eight_triangles_is_one_face() {
    let mut b = Build::new();
    for (x, y) in [(0.0, 0.0), (1.0, 0.0), (0.0, 1.0), (1.0, 1.0)] {
        b.polygon(WHITE, &[[x, y, 0.0], [x + 1.0, y, 0.0], [x + 1.0, y + 1.0, 0.0]]);
        b.polygon(WHITE, &[[x, y, 0.0], [x + 1.0, y + 1.0, 0.0], [x, y + 1.0, 0.0]]);
    }
    let p = prepared(&b.0, 0.0);
    assert_eq!((p.faces.len(), p.edges.len(), p.vertices_m.len()), (1, 4, 4));
}

#[test]
fn material_borders_stay() {
    let mut b = Build::new();
    b.floor(WHITE, [0.0, 0.0, 1.0, 1.0], 0.0).floor(RED, [1.0, 0.0, 2.0, 1.0], 0.0);
    let p = prepared(&b.0, 0.0);
    assert_eq!((p.faces.len(), p.edges.len(), p.planes.len()), (2, 7, 1));
}

#[test]
fn a_box_on_a_floor_cuts_it() {
    for bottom in [false, true] {
        let mut b = Build::new();
        b.floor(WHITE, [0.0, 0.0, 4.0, 4.0], 0.0).block(RED, [1.0, 0.0, 1.5], [2.0, 1.0, 3.0], bottom);
        let p = prepared(&b.0, 0.0);
        let under = face_under(&p, UP, [1.5, 0.0, 2.0]).unwrap();
        assert!((face_area_m2(&p, under) - 1.5).abs() < 1e-5);
        assert_eq!(faces_at(&p, WHITE, UP, [0.0; 3]).len(), 5);
        assert_eq!(faces_at(&p, RED, [0.0, -1.0, 0.0], [0.0; 3]).len(), usize::from(bottom));
        assert_eq!(p.report.contact_edges, 4);
    }
}

#[test]
fn a_box_in_a_corner_cuts_floor_and_walls() {
    let mut b = Build::new();
    b.floor(WHITE, [0.0, 0.0, 3.0, 3.0], 0.0).wall(WHITE, [0.0, 0.0, 3.0, 3.0], 0.0);
    b.polygon(WHITE, &[[0.0, 0.0, 3.0], [0.0, 0.0, 0.0], [0.0, 3.0, 0.0], [0.0, 3.0, 3.0]]);
    b.block(RED, [0.0; 3], [1.0, 1.0, 1.0], true);
    let p = prepared(&b.0, 0.0);
    for (normal, at) in [(UP, [0.5, 0.0, 0.5]), ([0.0, 0.0, 1.0], [0.5, 0.5, 0.0]), ([1.0, 0.0, 0.0], [0.0, 0.5, 0.5])]
    {
        let covered = face_under(&p, normal, at).unwrap();
        assert!((face_area_m2(&p, covered) - 1.0).abs() < 1e-5);
    }
    // Each wall: the covered square, and an L in two convex faces.
    assert_eq!(p.faces.len(), 3 * 3 + 6);
}

#[test]
fn a_partition_between_two_walls_divides_the_floor() {
    let mut b = Build::new();
    b.floor(WHITE, [0.0, 0.0, 4.0, 2.0], 0.0);
    b.wall(WHITE, [0.0, 0.0, 4.0, 2.0], 0.0);
    b.polygon(WHITE, &[[4.0, 0.0, 2.0], [0.0, 0.0, 2.0], [0.0, 2.0, 2.0], [4.0, 2.0, 2.0]]);
    b.polygon(SHEET, &[[1.5, 0.0, 0.0], [1.5, 0.0, 2.0], [1.5, 2.0, 2.0], [1.5, 2.0, 0.0]]);
    let p = prepared(&b.0, 0.0);
    assert_eq!(faces_at(&p, WHITE, UP, [0.0; 3]).len(), 2);
    assert_eq!(faces_at(&p, WHITE, [0.0, 0.0, 1.0], [0.0; 3]).len(), 2);
    assert_eq!(faces_at(&p, WHITE, [0.0, 0.0, -1.0], [0.0, 0.0, 2.0]).len(), 2);
    assert_eq!(p.faces.len(), 8);
    assert_eq!(p.edges.len(), 3 * 7 - 2 + 1 - 2);
}

#[test]
fn a_partition_that_ends_in_mid_floor_cuts_it_as_far() {
    let mut b = Build::new();
    b.floor(WHITE, [0.0, 0.0, 4.0, 4.0], 0.0);
    b.polygon(SHEET, &[[2.0, 0.0, 1.0], [2.0, 0.0, 2.5], [2.0, 2.0, 2.5], [2.0, 2.0, 1.0]]);
    let p = prepared(&b.0, 0.0);
    assert_eq!(p.report.contact_edges, 1);
    assert!((length_along_m(&p, [2.0, 0.0, 1.0], [2.0, 0.0, 2.5]) - 1.5).abs() < 1e-5);
    assert!(faces_at(&p, WHITE, UP, [0.0; 3]).len() <= 4);
}

#[test]
fn vertices_inside_an_edge_cut_it() {
    let mut b = Build::new();
    b.floor(WHITE, [0.0, 0.0, 1.0, 2.0], 0.0);
    b.floor(RED, [1.0, 0.0, 2.0, 0.7], 0.0).floor(WHITE, [1.0, 0.7, 2.0, 2.0], 0.0);
    let p = prepared(&b.0, 0.0);
    assert_eq!(p.report.t_vertices, 1);
    // The white faces are one L now, in two convex pieces.
    assert_eq!(p.faces.len(), 3);

    let mut b = Build::new();
    b.floor(WHITE, [0.0, 0.0, 1.0, 2.0], 0.0);
    b.polygon(RED, &[[1.0, 0.0, 0.7], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [1.0, 1.0, 0.7]]);
    b.polygon(RED, &[[1.0, 0.0, 2.0], [1.0, 0.0, 0.7], [2.0, 1.0, 0.7], [2.0, 1.0, 2.0]]);
    let p = prepared(&b.0, 0.0);
    assert_eq!(p.report.t_vertices, 1);
    let floor = faces_at(&p, WHITE, UP, [0.0; 3]);
    assert_eq!(floor.len(), 1);
    assert_eq!((p.corners(floor[0]).count(), p.boundary(floor[0]).count()), (4, 5));
}

#[test]
fn an_l_and_a_c_fall_into_few_convex_faces() {
    let mut b = Build::new();
    let l = [[0.0, 0.0], [2.0, 0.0], [2.0, 1.0], [1.0, 1.0], [1.0, 3.0], [0.0, 3.0]].map(|[x, y]| [x, y, 0.0]);
    b.polygon(WHITE, &l);
    assert_eq!(prepared(&b.0, 0.0).faces.len(), 2);
    let mut b = Build::new();
    let c = [[0.0, 0.0], [3.0, 0.0], [3.0, 1.0], [1.0, 1.0], [1.0, 2.0], [3.0, 2.0], [3.0, 3.0], [0.0, 3.0]];
    b.polygon(WHITE, &c.map(|[x, y]| [x, y, 0.0]));
    assert_eq!(prepared(&b.0, 0.0).faces.len(), 3);
}

#[test]
fn a_bridge_to_a_hole_vanishes() {
    let mut b = Build::new();
    let ring = [
        [0.0, 0.0],
        [3.0, 0.0],
        [3.0, 3.0],
        [0.0, 3.0],
        [0.0, 0.0],
        [1.0, 1.0],
        [1.0, 2.0],
        [2.0, 2.0],
        [2.0, 1.0],
        [1.0, 1.0],
    ];
    b.polygon(WHITE, &ring.map(|[x, y]| [x, y, 0.0]));
    let p = prepared(&b.0, 0.0);
    assert_eq!(p.faces.len(), 4);
    assert!(face_under(&p, [0.0, 0.0, 1.0], [1.5, 1.5, 0.0]).is_none());
}

#[test]
fn a_double_sided_sheet_is_two_faces_back_to_back() {
    let mut b = Build::new();
    b.floor(SHEET, [0.0, 0.0, 1.0, 1.0], 0.0);
    let p = prepared(&b.0, 0.0);
    assert_eq!(facings(&p), [1, 1]);
    assert_eq!((p.edges.len(), p.vertices_m.len(), p.planes.len()), (4, 4, 1));
    assert!(p.faces.iter().all(|f| f.plane == p.faces[FaceId::from(0)].plane));
}

#[test]
fn a_picture_makes_a_hole_in_its_wall_however_the_wall_is_divided() {
    for pieces in [1, 8] {
        let mut b = Build::new();
        for i in 0..pieces {
            let width = 4.0 / f64::from(pieces);
            b.wall(WHITE, [f64::from(i) * width, 0.0, f64::from(i + 1) * width, 3.0], 0.0);
        }
        b.wall(RED, [1.2, 1.0, 2.7, 2.0], 0.0);
        let p = prepared(&b.0, 1.5);
        let picture = faces_at(&p, RED, [0.0, 0.0, 1.0], [0.0; 3]);
        assert_eq!(picture.len(), 1);
        assert!((face_area_m2(&p, picture[0]) - 1.5).abs() < 1e-5);
        assert_eq!(p.faces.len(), 5);
        assert!(p.report.overlaps >= 1);
    }
}

#[test]
fn polygons_back_to_back_do_not_overlap() {
    let mut b = Build::new();
    b.wall(WHITE, [0.0, 0.0, 1.0, 1.0], 0.0);
    b.polygon(RED, &[[1.0, 0.0, 0.0], [0.0, 0.0, 0.0], [0.0, 1.0, 0.0], [1.0, 1.0, 0.0]]);
    let p = prepared(&b.0, 0.0);
    assert_eq!((p.faces.len(), p.edges.len(), p.report.overlaps), (2, 4, 0));
}

#[test]
fn jitter_changes_nothing() {
    let mut b = Build::new();
    b.floor(WHITE, [0.0, 0.0, 4.0, 4.0], 0.0).wall(WHITE, [0.0, 0.0, 4.0, 3.0], 0.0);
    b.block(RED, [1.0, 0.0, 1.5], [2.0, 1.0, 3.0], true).block(WHITE, [3.0, 0.0, 0.0], [4.0, 1.0, 1.0], false);
    let exact = prepared(&b.0, 0.0);
    let mut state = 1_u32;
    let mut noise = || {
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        1e-7 * (f64::from(state >> 8) / f64::from(1 << 23) - 1.0)
    };
    let mut scene = b.0.clone();
    scene
        .surfaces
        .iter_mut()
        .flat_map(|s| &mut s.positions_m)
        .for_each(|p| *p += DVec3::new(noise(), noise(), noise()));
    let jittered = prepared(&scene, 0.0);
    let counts = |p: &umbrage::prepare::Prepared| (p.faces.len(), p.edges.len(), p.vertices_m.len(), p.planes.len());
    assert_eq!(counts(&jittered), counts(&exact));
}

#[test]
fn a_kilometre_from_the_origin_and_in_millimetres_is_the_same() {
    let mut b = Build::new();
    b.floor(WHITE, [0.0, 0.0, 4.0, 4.0], 0.0).block(RED, [1.0, 0.0, 1.5], [2.0, 1.0, 3.0], false);
    let near = prepared(&b.0, 0.0);
    for scene in [b.moved(|p| p + DVec3::new(1000.3, -700.1, 1000.7)), b.moved(|p| p * 1000.0), b.moved(|p| p * 1e-6)] {
        let other = prepared(&scene, 0.0);
        assert_eq!((other.faces.len(), other.edges.len()), (near.faces.len(), near.edges.len()));
    }
}

#[test]
fn blocks_that_cross_are_cut_along_each_other() {
    let mut b = Build::new();
    b.block(WHITE, [0.0; 3], [2.0, 2.0, 2.0], true).block(RED, [0.5, 0.5, -1.0], [1.5, 1.5, 3.0], true);
    let p = prepared(&b.0, 0.0);
    assert!((length_along_m(&p, [0.5, 0.5, 2.0], [1.5, 0.5, 2.0]) - 1.0).abs() < 1e-5);
    assert!((face_area_m2(&p, face_under(&p, [0.0, 0.0, 1.0], [1.0, 1.0, 2.0]).unwrap()) - 1.0).abs() < 1e-5);
}

#[test]
fn two_hundred_boxes_on_a_floor() {
    let mut b = Build::new();
    b.floor(WHITE, [0.0, 0.0, 60.0, 60.0], 0.0);
    for i in 0..200 {
        let (x, z) = (3.0 + 2.7 * f64::from(i % 20), 3.0 + 5.1 * f64::from(i / 20));
        b.block(RED, [x, 0.0, z], [x + 1.0 + 0.1 * f64::from(i % 7), 1.0, z + 2.0], false);
    }
    let p = prepared(&b.0, 0.0);
    assert_eq!(p.report.contact_edges, 800);
    let floor = faces_at(&p, WHITE, UP, [0.0; 3]).len();
    assert!(floor > 400 && floor < 1000, "{floor}");
}
