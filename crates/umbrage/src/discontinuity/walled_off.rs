//! Whether a wall stands between a source and an occluder, so that no ray of an event gets from one to the other.
//!
//! In a building most lamps and edges are in different rooms. To trace their wedges is to look at all that is in their plane, only
//! to find that nothing arrives; one wall between them tells the same at once. A wall is all faces of one plane that cross the
//! plane of the rays without a gap: where both ends of the source are before the wall and both ends of the occluder behind
//! it, all rays between them cross it between the crossings of the outermost ones. In space, the same holds of the hull of the
//! crossings.
//!
//! ```text
//!    p === q     source                  p, q on one side, a, b on the other;
//!     \  /|
//!   ---+-++----  wall, without a gap     all rays cross it between the first + and the last
//!      | |  \
//!      a === b   occluder
//! ```

use glam::{DVec2, DVec3};
use smallvec::SmallVec;

use super::features::Surroundings;
use super::wedge::{Crossing, Wedge, chord};
use crate::geometry::{clip, convex, polygon};
use crate::id::{FaceId, PlaneId};
use crate::prepare::Facing;

/// A wall is whole if what it leaves open of the hull of the crossings is less than this share: rounding of its border, on which a
/// ceiling that shines may end.
const OPEN: f64 = 1e-5;

/// A piece of a wall, from one place along it to another, and the places between which rays cross the wall.
type Piece = (PlaneId, [f64; 2], [f64; 2]);

impl Surroundings<'_> {
    /// Whether a wall stands between a line on a source and one on an occluder (or a point, as a line between equal ends), in a plane
    /// with both. `wedge` is of that plane, and every ray of it crosses such a wall before nearness 1. Faces `but` are no walls.
    pub(super) fn is_walled_off(
        &self,
        wedge: &Wedge,
        source: [DVec3; 2],
        occluder: [DVec3; 2],
        but: impl Fn(FaceId) -> bool,
    ) -> bool {
        let slack_m = self.coplanar_m();
        let mut pieces: SmallVec<[Piece; 8]> = SmallVec::new();
        for face in wedge.faces(self.visibility, 1.0) {
            let wall = self.prepared.oriented_plane(face);
            let [from, to] = [source, occluder].map(|line| line.map(|end| wall.signed_distance_m(end)));
            let apart = |one: [f64; 2], other: [f64; 2]| {
                one.iter().all(|&height_m| height_m > slack_m) && other.iter().all(|&height_m| height_m < -slack_m)
            };
            if !(apart(from, to) || apart(to, from)) || but(face) {
                continue;
            }
            let Some((Crossing::Through, ends)) = chord(self.visibility, face, &wedge.plane) else { continue };
            let along = wall.normal.cross(wedge.plane.normal).normalize_or_zero();
            let at = |point: DVec3| point.dot(along);
            let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
            for i in 0..2 {
                for j in 0..2 {
                    let crossing = at(source[i].lerp(occluder[j], from[i] / (from[i] - to[j])));
                    (low, high) = (low.min(crossing), high.max(crossing));
                }
            }
            let ends = ends.map(at);
            // Faces of one plane may look either way, and then run along it either way.
            let facing = self.prepared.faces[face].facing == Facing::Along;
            let turned = |[p, q]: [f64; 2]| if facing { [p.min(q), p.max(q)] } else { [-p.max(q), -p.min(q)] };
            pieces.push((self.prepared.faces[face].plane, turned(ends), turned([low, high])));
        }
        pieces.sort_by(|p, q| p.0.cmp(&q.0).then(p.1[0].total_cmp(&q.1[0])).then(p.1[1].total_cmp(&q.1[1])));
        pieces.chunk_by(|p, q| p.0 == q.0).any(|wall| {
            let [low, high] = wall[0].2;
            let whole_to = wall
                .iter()
                .map(|piece| piece.1)
                .fold(low, |whole_to, [from, to]| if from <= whole_to + slack_m { whole_to.max(to) } else { whole_to });
            whole_to + slack_m >= high
        })
    }

    /// Whether a wall stands between the hull of some points, some of which may be on the wall, and an edge. `faces` are all that
    /// reach into the hull of both.
    pub(super) fn is_edge_walled_off(&self, faces: &[FaceId], points: &[DVec3], edge: [DVec3; 2]) -> bool {
        let slack_m = self.coplanar_m();
        let wall_of = |face: FaceId| (self.prepared.faces[face].plane, self.prepared.faces[face].facing);
        let is_between = |&face: &FaceId| {
            let wall = self.prepared.oriented_plane(face);
            [1.0, -1.0].into_iter().any(|sign| {
                let mut heights_m = points.iter().map(|&point| sign * wall.signed_distance_m(point));
                edge.iter().all(|&end| sign * wall.signed_distance_m(end) < -slack_m)
                    && heights_m.clone().all(|height_m| height_m >= -slack_m)
                    && heights_m.any(|height_m| height_m > slack_m)
            })
        };
        let mut between: SmallVec<[FaceId; 8]> = faces.iter().copied().filter(is_between).collect();
        between.sort_unstable_by_key(|&face| (wall_of(face), face));
        between.chunk_by(|&one, &other| wall_of(one) == wall_of(other)).any(|wall| {
            let frame = &self.prepared.planes[wall_of(wall[0]).0];
            let crossing = |from: DVec3, to: DVec3| {
                let [from_m, to_m] = [from, to].map(|p| frame.plane.signed_distance_m(p));
                frame.to_2d(from.lerp(to, from_m / (from_m - to_m)))
            };
            let hull = convex::hull(points.iter().flat_map(|&point| edge.map(|end| crossing(point, end))).collect());
            let area_m2 = |corners: &[DVec2]| polygon::signed_area_2d_m2(corners).abs();
            let covered_m2 = |&face: &FaceId| {
                let mut flat: SmallVec<[DVec2; 8]> =
                    self.visibility.boundary_m(face).iter().map(|&p| frame.to_2d(p)).collect();
                // Clipping takes polygons that run counter-clockwise.
                if polygon::signed_area_2d_m2(&flat) < 0.0 {
                    flat.reverse();
                }
                area_m2(&clip::intersection(&hull, &flat))
            };
            let whole_m2 = area_m2(&hull);
            whole_m2 > slack_m * slack_m && wall.iter().map(covered_m2).sum::<f64>() >= (1.0 - OPEN) * whole_m2
        })
    }
}

#[cfg(test)]
mod tests {
    use std::sync::atomic::AtomicUsize;

    use super::super::Features;
    use super::*;
    use crate::scene::{Material, Rgb};
    use crate::visibility::{Visibility, fixture};

    /// What there is in a scene of walls in the plane z = 1, each between two places along x, and of something behind them.
    fn with_walls<T>(walls: &[[f64; 2]], then: impl Fn(&Surroundings<'_>) -> T) -> T {
        let wall = |&[from, to]: &[f64; 2]| {
            [[from, -1.0], [to, -1.0], [to, 1.0], [from, 1.0]].map(|[x, y]| DVec3::new(x, y, 1.0)).to_vec()
        };
        let mut polygons: Vec<Vec<DVec3>> = walls.iter().map(wall).collect();
        let behind = [[-9.0, -9.0], [9.0, -9.0], [9.0, 9.0], [-9.0, 9.0]];
        polygons.push(behind.map(|[x, y]| DVec3::new(x, y, 9.0)).to_vec());
        let prepared = fixture::prepared(&polygons);
        let scene = fixture::scene(vec![Material::diffuse("grey", Rgb::splat(0.5))]);
        let (features, visibility) = (Features::new(&scene, &prepared), Visibility::new(&prepared));
        let wedges = AtomicUsize::new(0);
        then(&Surroundings { prepared: &prepared, visibility: &visibility, features: &features, wedges: &wedges })
    }

    /// Whether walls in the plane z = 1, each between two places along x, stand between lines at z = 0 and z = 2 in the plane y = 0.
    fn walled(walls: &[[f64; 2]], source: [f64; 2], occluder: [f64; 2]) -> bool {
        let line = |[from, to]: [f64; 2], z: f64| [DVec3::new(from, 0.0, z), DVec3::new(to, 0.0, z)];
        let (source, occluder) = (line(source, 0.0), line(occluder, 2.0));
        let wedge = Wedge::new(source[0], occluder, 1e-9).unwrap();
        with_walls(walls, |around| around.is_walled_off(&wedge, source, occluder, |_| false))
    }

    #[test]
    fn a_wall_that_all_rays_cross_is_one_and_a_shorter_one_is_none() {
        let (source, occluder) = ([0.0, 2.0], [1.0, 5.0]);
        // The outermost rays cross at 0.5 and 3.5.
        assert!(walled(&[[0.4, 3.6]], source, occluder));
        assert!(!walled(&[[0.6, 3.6]], source, occluder));
        assert!(!walled(&[[0.4, 3.4]], source, occluder));
    }

    #[test]
    fn a_wall_of_several_faces_is_one_if_it_has_no_gap() {
        let (source, occluder) = ([0.0, 2.0], [1.0, 5.0]);
        assert!(walled(&[[0.0, 1.0], [1.0, 2.5], [2.5, 4.0]], source, occluder));
        assert!(!walled(&[[0.0, 1.0], [1.1, 4.0]], source, occluder));
    }

    #[test]
    fn an_emitter_and_an_edge_are_walled_off_by_what_covers_the_hull_of_their_crossings() {
        // Crossings at z = 1: x from 0.5 to 2.5, y from -0.5 to 0.5.
        let emitter = [[0.0, -1.0], [2.0, -1.0], [2.0, 1.0], [0.0, 1.0]].map(|[x, y]| DVec3::new(x, y, 0.0));
        let edge = [DVec3::new(1.0, 0.0, 2.0), DVec3::new(3.0, 0.0, 2.0)];
        let walled = |walls: &[[f64; 2]]| {
            with_walls(walls, |around| {
                let faces: Vec<FaceId> = around.prepared.faces.keys().collect();
                around.is_edge_walled_off(&faces, &emitter, edge)
            })
        };
        assert!(walled(&[[0.4, 2.6]]));
        assert!(walled(&[[0.4, 1.0], [1.0, 2.6]]));
        assert!(!walled(&[[0.6, 2.6]]));
        assert!(!walled(&[[0.4, 1.0], [1.01, 2.6]]));
        assert!(!walled(&[]));
    }

    #[test]
    fn a_ceiling_that_ends_on_a_wall_is_walled_off_by_it() {
        let ceiling = [[1.0, -0.5, 1.0], [1.0, 0.5, 1.0], [1.0, 0.5, 0.0], [1.0, -0.5, 0.0]].map(DVec3::from);
        let edge = [DVec3::new(2.0, -0.5, 2.0), DVec3::new(3.0, 0.5, 2.0)];
        let walled = |walls: &[[f64; 2]]| {
            with_walls(walls, |around| {
                let faces: Vec<FaceId> = around.prepared.faces.keys().collect();
                around.is_edge_walled_off(&faces, &ceiling, edge)
            })
        };
        // Rays cross from where the ceiling is, at 1, to half way to the end of the edge.
        assert!(walled(&[[1.0, 2.1]]));
        assert!(!walled(&[[1.0, 1.8]]));
    }

    #[test]
    fn a_point_is_a_line_without_length() {
        assert!(walled(&[[0.4, 2.6]], [0.0, 0.0], [1.0, 5.0]));
        assert!(!walled(&[[0.6, 2.6]], [0.0, 0.0], [1.0, 5.0]));
    }
}
