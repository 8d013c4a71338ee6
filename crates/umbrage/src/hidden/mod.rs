//! Sides that no light reaches and nobody can see: the inside of a closed box, the floor under it, the outside of a room
//! that is lit inside. They get no faces, no patches and no triangles.
//!
//! All surfaces together divide space into *regions*. Light that is in a region stays there, since both sides of every
//! surface block it. So a region without a source is exactly dark, and nothing in it can be seen from where there is
//! light.
//!
//! 1. `sides`: every face has a side in front and one behind; around each edge, neighbours in angle face one region.
//! 2. `sight`: rays join what hangs apart, a box and the room around it, and bear out what edges say.
//! 3. `light`: which regions hold an emitter, a lamp, or see the sky where there is a sun.
//! 4. Here: a dark region is hidden, unless it is a *dark room*, made to be entered: large, and bounded mostly by fronts.
//!
//! Holds: a side is only hidden where its region is closed. A gap, however small, makes one region of two, which is then
//! lit as it is.

mod light;
mod sides;
mod sight;

use glam::DVec3;

use self::sides::{Region, Sides};
use crate::geometry::polygon;
use crate::id::{FaceId, Table};
use crate::prepare::{self, FaceOrigins, PrepareError, PrepareSettings, Prepared};
use crate::progress::{Cancelled, Progress, Stage};
use crate::scene::Scene;
use crate::visibility::Visibility;

/// A dark room's least extent along each axis, as a share of the scene's greatest: the space under a cupboard has less.
const MIN_ROOM_OF_EXTENT: f64 = 0.1;
/// A dark room is bounded by fronts over this share of its area at least; the inside of a box has backs alone.
const MIN_FRONTS_OF_ROOM: f64 = 0.5;
/// Where lit regions have less than this share of the area of all sides, the light is shut in by mistake, as a bulb in
/// its glass, and nothing is hidden.
const MIN_LIT_OF_SCENE: f64 = 0.01;

/// About the share of `prepare` that the draft takes; the rest is for rays.
const DRAFT_SHARE: f64 = 0.5;

/// Which faces of a scene are hidden.
#[derive(Clone, Debug, PartialEq)]
pub struct Hidden {
    /// Whether each face is.
    pub faces: Table<FaceId, bool>,
    /// Their share of the area of all faces, 0 to 1.
    pub share: f64,
}

/// Makes faces of the sides of a scene that are not hidden, and their index: what a bake is about. All sides where the
/// settings keep what is hidden.
///
/// # Errors
/// As [`prepare::prepare_with`].
pub fn faces_in_sight(
    scene: &Scene,
    settings: PrepareSettings,
    progress: Progress<'_>,
) -> Result<(Prepared, Visibility), PrepareError> {
    let draft = prepare::draft(scene, settings, progress.part(Stage::Prepare, [0.0, DRAFT_SHARE]))?;
    let (all, origins) = draft.faces(scene);
    let visibility = Visibility::new(&all);
    if settings.keep_hidden {
        return Ok((all, visibility));
    }
    let of_sight = progress.part(Stage::Prepare, [DRAFT_SHARE, 1.0]);
    let Hidden { faces, share } = hidden(scene, &all, &visibility, &origins, of_sight)?;
    if !faces.iter().any(|hidden| *hidden) {
        return Ok((all, visibility));
    }
    let pulse = || progress.report(Stage::Prepare, 0, 0);
    let (mut prepared, _) = draft.without(&faces, &origins, pulse)?.faces(scene);
    prepared.report.hidden_share = share;
    let visibility = Visibility::new(&prepared);
    Ok((prepared, visibility))
}

/// Finds the faces that no light reaches and nobody can see.
///
/// # Errors
/// [`Cancelled`] where `progress` asks to stop.
pub fn hidden(
    scene: &Scene,
    prepared: &Prepared,
    visibility: &Visibility,
    origins: &FaceOrigins,
    progress: Progress<'_>,
) -> Result<Hidden, Cancelled> {
    let mut sides = Sides::around_edges(prepared);
    sight::join(prepared, visibility, &mut sides, progress)?;
    let is_lit = light::lit_regions(scene, prepared, visibility, &mut sides);

    let areas_m2: Table<FaceId, f64> =
        prepared.faces.keys().map(|face| polygon::area_m2(&prepared.polygon_m(face))).collect();
    let total_m2: f64 = areas_m2.iter().sum();
    let regions: Vec<Region> = prepared.faces.keys().map(|face| sides.region_before(face)).collect();
    let lit_m2: f64 = regions.iter().zip(&areas_m2).filter(|(region, _)| is_lit[**region]).map(|(_, m2)| m2).sum();
    if lit_m2 < MIN_LIT_OF_SCENE * total_m2 {
        return Ok(Hidden { faces: areas_m2.iter().map(|_| false).collect(), share: 0.0 });
    }

    let mut rooms: Vec<Room> = vec![Room::default(); sides.count()];
    for ((face, &area_m2), &region) in areas_m2.iter_enumerated().zip(&regions) {
        let front_m2 = if origins.is_reverse[face] { 0.0 } else { area_m2 };
        rooms[region].add(front_m2, area_m2, prepared, face);
        // A surface with one face has a back, too.
        if !sides.has_opposite(face) {
            rooms[sides.region_behind(face)].add(0.0, area_m2, prepared, face);
        }
    }
    let outside = sides.outside();
    let is_room = |region: Region| rooms[region].is_meant(prepared.tolerance.extent_m, region == outside);
    let faces: Table<FaceId, bool> =
        regions.iter().map(|&region| !is_lit[region] && !is_room(region)).collect::<Vec<_>>().into();
    let hidden_m2: f64 = faces.iter().zip(&areas_m2).filter(|(hidden, _)| **hidden).map(|(_, m2)| m2).sum();
    Ok(Hidden { faces, share: hidden_m2 / total_m2 })
}

/// What bounds a region.
#[derive(Clone, Copy, Debug)]
struct Room {
    front_m2: f64,
    area_m2: f64,
    min_m: DVec3,
    max_m: DVec3,
}

impl Default for Room {
    fn default() -> Self {
        Self { front_m2: 0.0, area_m2: 0.0, min_m: DVec3::INFINITY, max_m: DVec3::NEG_INFINITY }
    }
}

impl Room {
    fn add(&mut self, front_m2: f64, area_m2: f64, prepared: &Prepared, face: FaceId) {
        self.front_m2 += front_m2;
        self.area_m2 += area_m2;
        for corner in prepared.corners(face).map(|vertex| prepared.vertices_m[vertex]) {
            (self.min_m, self.max_m) = (self.min_m.min(corner), self.max_m.max(corner));
        }
    }

    /// Whether it was made to be entered.
    fn is_meant(&self, extent_m: f64, is_outside: bool) -> bool {
        let is_large = is_outside || (self.max_m - self.min_m).min_element() >= MIN_ROOM_OF_EXTENT * extent_m;
        is_large && self.front_m2 >= MIN_FRONTS_OF_ROOM * self.area_m2
    }
}
