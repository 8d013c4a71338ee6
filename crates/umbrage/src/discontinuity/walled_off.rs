//! Whether a wall stands between a source and an occluder, so that no ray of an event gets from one to the other.
//!
//! In a building most lamps and edges are in different rooms. To trace their wedges is to look at all that is in their plane, only
//! to find that nothing arrives; one wall between them tells the same at once. A wall is all faces of one plane that cross the
//! plane of the rays without a gap: where both ends of the source are before the wall and both ends of the occluder behind
//! it, all rays between them cross it between the crossings of the outermost ones.
//!
//! ```text
//!    p === q     source                  p, q on one side, a, b on the other;
//!     \  /|
//!   ---+-++----  wall, without a gap     all rays cross it between the first + and the last
//!      | |  \
//!      a === b   occluder
//! ```

use glam::DVec3;
use smallvec::SmallVec;

use super::features::Surroundings;
use super::wedge::{Crossing, Wedge, chord};
use crate::id::{FaceId, PlaneId};
use crate::prepare::Facing;

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
    fn a_point_is_a_line_without_length() {
        assert!(walled(&[[0.4, 2.6]], [0.0, 0.0], [1.0, 5.0]));
        assert!(!walled(&[[0.6, 2.6]], [0.0, 0.0], [1.0, 5.0]));
    }
}
