//! Lamps in the frame of the prepared faces, off the surfaces that they are mounted on.
//!
//! A lamp that lies in a surface within rounding would be before it or behind it by chance: on the edge of a box, in the corner of a
//! room. It is taken to be in front, since there its maker put it: each face that it lies on pushes it forward, to twice the
//! distance below which a point lies in a plane. Of a sheet with two sides, the side that it is on counts, and within rounding the first
//! face's; and a lamp on the border of a sheet is moved as far inward, since rounding would decide what sees it past that border.
//!
//! Holds after: no lamp lies in a face within rounding, unless faces that look at each other are nearer than that.

use glam::DVec3;

use crate::geometry::polygon;
use crate::id::{FaceId, LampId, Table};
use crate::prepare::Prepared;
use crate::scene::{Lamp, LampKind, Scene};

/// A lamp on a surface is moved so many times as far before it as a point that lies in its plane may be.
const BEFORE_OF_COPLANAR: f64 = 2.0;
/// Normals with a cosine below this look opposite ways: the two sides of a sheet.
const OPPOSITE: f64 = -0.999;
/// A lamp farther behind a face than this share of that distance may be on the other side of a sheet: more than corners are rounded by.
const ON_A_SIDE_OF_COPLANAR: f64 = 0.1;

/// Moves the lamps of a scene into the frame of its prepared faces, and those that lie on surfaces before them.
pub fn lamps(scene: &Scene, prepared: &Prepared) -> Table<LampId, Lamp> {
    let in_frame = |lamp: &Lamp| {
        let mut lamp = lamp.clone().moved(|p| p - prepared.origin_m, |d| d, 1.0);
        if let LampKind::Point { position_m, .. } | LampKind::Spot { position_m, .. } = &mut lamp.kind {
            *position_m = before_surfaces(prepared, *position_m);
        }
        lamp
    };
    scene.lamps.iter().map(in_frame).collect()
}

/// A point before all faces that it lies on.
fn before_surfaces(prepared: &Prepared, point_m: DVec3) -> DVec3 {
    let near_m = prepared.tolerance.coplanar_m();
    let least_m = BEFORE_OF_COPLANAR * near_m;
    let lies_on = |&face: &FaceId| {
        let plane = prepared.oriented_plane(face);
        plane.signed_distance_m(point_m).abs() < near_m
            && polygon::distance_m(point_m, &prepared.polygon_m(face), &plane) < near_m
    };
    let mut lies_on: Vec<FaceId> = prepared.faces.keys().filter(lies_on).collect();
    // Those that it is clearly before come first.
    let is_behind =
        |&face: &FaceId| prepared.oriented_plane(face).signed_distance_m(point_m) < -ON_A_SIDE_OF_COPLANAR * near_m;
    lies_on.sort_by_key(is_behind);
    let Some(&first) = lies_on.first() else { return point_m };
    let (mut moved_m, mut pushed): (DVec3, Vec<DVec3>) = (point_m, Vec::new());
    for &face in &lies_on {
        let plane = prepared.oriented_plane(face);
        if pushed.iter().all(|normal| normal.dot(plane.normal) > OPPOSITE) {
            moved_m += (least_m - plane.signed_distance_m(moved_m)).max(0.0) * plane.normal;
            pushed.push(plane.normal);
        }
    }
    let is_sheet = lies_on.iter().all(|&face| prepared.faces[face].plane == prepared.faces[first].plane);
    if is_sheet { inward(prepared, first, moved_m, near_m, least_m) } else { moved_m }
}

/// A point before a face, at least `least_m` inside of those sides that it is nearer to than `near_m`.
fn inward(prepared: &Prepared, face: FaceId, point_m: DVec3, near_m: f64, least_m: f64) -> DVec3 {
    let (corners_m, normal) = (prepared.polygon_m(face), prepared.normal(face));
    let next = |i: usize| corners_m[(i + 1) % corners_m.len()];
    let sides =
        corners_m.iter().enumerate().map(|(i, &from_m)| (from_m, normal.cross(next(i) - from_m).normalize_or_zero()));
    let move_in = |moved_m: DVec3, (from_m, inward): (DVec3, DVec3)| {
        let inside_m = inward.dot(moved_m - from_m);
        if inside_m < near_m { moved_m + (least_m - inside_m) * inward } else { moved_m }
    };
    sides.fold(point_m, move_in)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::Rgb;
    use crate::visibility::fixture;

    fn moved_m(polygons: &[Vec<DVec3>], position_m: DVec3) -> DVec3 {
        let mut scene = Scene::default();
        let kind = LampKind::Point { position_m, intensity: Rgb::ONE, range_m: None };
        scene.lamps.push(Lamp { name: String::new(), kind });
        let prepared = fixture::prepared(polygons);
        lamps(&scene, &prepared)[LampId::from(0)].position_m().unwrap()
    }

    #[test]
    fn a_lamp_in_the_corner_of_a_room_is_in_the_room() {
        let room = fixture::inward_box(DVec3::ZERO, DVec3::ONE);
        for slip in [-5e-7, 0.0, 5e-7] {
            let at_m = moved_m(&room, DVec3::splat(slip));
            assert!((at_m - DVec3::splat(2e-6)).abs().max_element() < 1e-12, "{at_m}");
        }
        assert_eq!(moved_m(&room, DVec3::new(0.0, 0.5, 2e-6)).x, 2e-6);
        assert_eq!(moved_m(&room, DVec3::splat(0.5)), DVec3::splat(0.5));
    }

    #[test]
    fn a_lamp_on_the_edge_of_a_box_is_outside_of_it() {
        let at_m = moved_m(&fixture::outward_box(DVec3::ZERO, DVec3::ONE), DVec3::new(0.5, 1.0, 1.0));
        assert!(at_m.y > 1.0 && at_m.z > 1.0 && at_m.x == 0.5, "{at_m}");
    }

    #[test]
    fn a_lamp_in_a_sheet_is_before_one_side_of_it() {
        let sheet = [fixture::square(DVec3::ZERO, 1.0, true), fixture::square(DVec3::ZERO, 1.0, false)];
        let at_m = moved_m(&sheet, DVec3::new(0.1, 0.2, 0.0));
        assert!(at_m.z.abs() > 1e-6, "{at_m}");
        // On the side that it is on, though it be near.
        for z in [-4e-7, 4e-7] {
            let at_m = moved_m(&sheet, DVec3::new(0.1, 0.2, z));
            assert!(at_m.z * z > 0.0 && at_m.z.abs() > 1e-6, "{at_m} for {z}");
        }
        // On its border and in its corner, too, where it would be seen past them by chance.
        for (x, y) in [(1.0, 0.2), (1.0 + 3e-13, 1.0 - 1e-13)] {
            let at_m = moved_m(&sheet, DVec3::new(x, y, 0.0));
            assert!(at_m.z.abs() > 1e-6 && at_m.x < 1.0 - 1e-6 && (y < 0.9 || at_m.y < 1.0 - 1e-6), "{at_m}");
        }
    }
}
