//! Three failures that the manuals of earlier radiosity programs told their users to work around: light that leaks
//! under a wall into a dark room, a thin table leg that loses its shadow, a switch plate that floats off a wall or is
//! glued to it. Whole bakes with the default settings, against darkness, or against light that is calculated exactly
//! here (`exact.rs`).
#![allow(clippy::unwrap_used, clippy::print_stdout, reason = "a test fails by panicking, and says what it measured")]

#[path = "../common/mod.rs"]
mod common;

mod dark_room;
mod exact;
mod sun_patch;
mod switch_plate;
mod table_leg;

use umbrage::bake::{BakeSettings, bake};
use umbrage::progress::Progress;
use umbrage::scene::Scene;
use umbrage::shade::BakedMesh;

use common::{Lit, lit_triangles};

/// What a bake is asked for where nothing is said: root mean square error over the mean of all that receives and does
/// not emit.
const TOLERANCE: f64 = 0.01;

/// A bake with the default settings: the triangles of each surface.
fn baked(scene: &Scene) -> Vec<Vec<Lit>> {
    let settings = BakeSettings::default();
    assert_eq!(settings.shade.tolerance, TOLERANCE);
    baked_with(scene, settings)
}

/// A bake with other settings.
fn baked_with(scene: &Scene, settings: BakeSettings) -> Vec<Vec<Lit>> {
    let BakedMesh { origin_m, parts } = bake(scene, &settings, Progress::silent()).unwrap().mesh;
    parts.into_iter().map(|part| lit_triangles(&BakedMesh { origin_m, parts: vec![part] })).collect()
}

/// Mean irradiance over triangles, by area and over the colours.
fn mean<'a>(triangles: impl Iterator<Item = &'a Lit>) -> f64 {
    let (mut light, mut area) = (0.0, 0.0);
    for triangle in triangles {
        light += triangle.area() * triangle.irradiance.iter().map(|e| e.element_sum()).sum::<f64>() / 9.0;
        area += triangle.area();
    }
    light / area
}
