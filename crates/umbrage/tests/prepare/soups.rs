//! Polygons that are broken, and scenes that cannot be prepared.

use std::ops::ControlFlow;

use umbrage::prepare::{PrepareError, prepare};
use umbrage::progress::{Cancelled, Progress, Update};
use umbrage::scene::{Scene, cornell};

use crate::build::{Build, RED, WHITE};
use crate::check::prepared;

#[test]
fn degenerate_polygons_and_duplicates_are_counted() {
    let mut b = Build::new();
    b.floor(WHITE, [0.0, 0.0, 1.0, 1.0], 0.0).floor(WHITE, [0.0, 0.0, 1.0, 1.0], 0.0);
    b.polygon(RED, &[[0.0; 3], [1.0, 0.0, 0.0], [2.0, 0.0, 0.0]]);
    b.polygon(RED, &[[0.5; 3], [0.5; 3], [0.5; 3]]);
    let p = prepared(&b.0, 1.0);
    assert_eq!((p.faces.len(), p.report.polygons), (1, 4));
    assert_eq!((p.report.degenerate_polygons, p.report.duplicate_polygons), (2, 1));
}

#[test]
fn a_bent_quad_becomes_triangles() {
    let mut b = Build::new();
    b.polygon(WHITE, &[[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.01], [0.0, 1.0, 0.0]]);
    let p = prepare(&b.0, Progress::silent()).unwrap();
    p.validate().unwrap();
    assert_eq!((p.faces.len(), p.planes.len(), p.report.nonplanar_polygons), (2, 2, 1));
}

#[test]
fn a_bow_tie_is_survived() {
    let mut b = Build::new();
    b.polygon(WHITE, &[[0.0; 3], [1.0, 1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.2, 0.0]]);
    b.floor(RED, [0.0, 0.0, 1.0, 1.0], 0.0);
    prepare(&b.0, Progress::silent()).unwrap().validate().unwrap();
}

#[test]
fn a_scene_without_area_is_refused_by_name() {
    let mut b = Build::new();
    b.polygon(RED, &[[0.0; 3], [1.0, 0.0, 0.0], [2.0, 0.0, 0.0]]);
    let error = prepare(&b.0, Progress::silent()).unwrap_err();
    assert!(matches!(&error, PrepareError::NoArea { others: 0, .. }));
    assert!(error.to_string().contains("red"), "{error}");
    b.0.surfaces[umbrage::id::SurfaceId::from(1)].positions_m.fill(glam::DVec3::ONE);
    assert!(matches!(prepare(&b.0, Progress::silent()), Err(PrepareError::NoArea { .. })));
}

#[test]
fn a_scene_of_absurd_size_is_refused_by_name() {
    for size in [1e300, 1e40, 1e-30] {
        let mut b = Build::new();
        b.floor(WHITE, [0.0, 0.0, size, size], 0.0);
        let error = prepare(&b.0, Progress::silent()).unwrap_err();
        assert!(matches!(&error, PrepareError::Extent { .. }), "{error}");
        assert!(error.to_string().contains("white"), "{error}");
    }
    let mut b = Build::new();
    b.floor(WHITE, [1e300, 1e300, 2e300, 2e300], 1e300);
    assert!(prepare(&b.0, Progress::silent()).is_err());
}

#[test]
fn a_cancelled_prepare_stops() {
    for step in 0..7 {
        let stop = |u: Update| if u.done >= step { ControlFlow::Break(()) } else { ControlFlow::Continue(()) };
        let result = prepare(&cornell::cornell_box(), Progress::new(&stop));
        assert!(matches!(result, Err(PrepareError::Cancelled(Cancelled))));
    }
}

#[test]
fn an_empty_scene_is_refused() {
    assert!(prepare(&Scene::default(), Progress::silent()).is_err());
}

#[test]
fn faces_do_not_depend_on_the_number_of_threads() {
    let mut b = Build::new();
    b.floor(WHITE, [0.0, 0.0, 9.0, 9.0], 0.0);
    for i in 0..9 {
        let (x, z) = (f64::from(i % 3) * 3.0 + 0.5, f64::from(i / 3) * 3.0 + 0.5);
        b.block(RED, [x, 0.0, z], [x + 1.0 + 0.1 * f64::from(i), 1.0, z + 2.0], i % 2 == 0);
    }
    let [p, q] = [1, 4].map(|threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| prepared(&b.0, 0.0))
    });
    assert_eq!((p.vertices_m, p.edges, p.faces, p.planes), (q.vertices_m, q.edges, q.faces, q.planes));
}
