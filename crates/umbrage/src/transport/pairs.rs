//! The pairs of faces that `subdivide` begins with: all that could exchange much, found by clusters.
//!
//! ```text
//! pairs(cluster a, cluster b) {
//!     if (a is so far from all of b, and b from all of a, that no form factor is LEAST)   return;
//!     split the larger; pairs of its parts and the other; of two faces: this pair
//! }
//! ```
//!
//! What a patch misses by that is many faint links. It is not lost: the exact bounce gathers it, and the solution is corrected by what
//! links miss. So the number of pairs grows with that of the faces, not with its square.
//!
//! Between walls of other rooms nothing is exchanged, but that is not known here: where pairs would be too many, only those of greater
//! form factors are taken.
//!
//! Holds: pairs are in the order of their faces, the smaller first.

use std::f64::consts::PI;

use glam::DVec3;

use crate::geometry::polygon;
use crate::id::{ClusterId, FaceId, Table};
use crate::prepare::Prepared;
use crate::visibility::Visibility;

/// Faces that have a smaller form factor to one another, whatever stands between, are not linked: links are good enough to start
/// from without them.
const LEAST_FACTOR: f64 = 0.01;
/// Where there would be more pairs than this and so many for each face, twice the factor is the least, and so on: in a building with
/// many rooms most of them have walls in between.
const MOST_PAIRS: usize = 20_000;
const MOST_A_FACE: usize = 8;

/// The pairs of faces of different planes that could exchange much.
pub(super) fn pairs(prepared: &Prepared, visibility: &Visibility) -> Vec<[FaceId; 2]> {
    let balls: Table<FaceId, Ball> =
        prepared.faces.keys().map(|face| Ball::around(&prepared.polygon_m(face))).collect();
    let areas_m2 = visibility.over_clusters(0.0, |face| balls[face].area_m2);
    let most = MOST_PAIRS + MOST_A_FACE * prepared.faces.len();
    let mut least_factor = LEAST_FACTOR;
    loop {
        let mut search =
            Search { prepared, visibility, balls: &balls, areas_m2: &areas_m2, least_factor, most, pairs: Vec::new() };
        if let Some(whole) = visibility.whole_cluster() {
            search.within(whole);
        }
        // No form factor is more than 1: then only what touches is left.
        if search.pairs.len() <= most || least_factor > 1.0 {
            search.pairs.sort_unstable();
            return search.pairs;
        }
        least_factor *= 2.0;
    }
}

/// A face's area, and the ball around its middle that holds it.
struct Ball {
    area_m2: f64,
    middle_m: DVec3,
    radius_m: f64,
}

impl Ball {
    fn around(corners_m: &[DVec3]) -> Self {
        let middle_m = corners_m.iter().sum::<DVec3>() / corners_m.len() as f64;
        let radius_m = corners_m.iter().map(|corner_m| corner_m.distance(middle_m)).fold(0.0, f64::max);
        Self { area_m2: polygon::area_m2(corners_m), middle_m, radius_m }
    }
}

struct Search<'a> {
    prepared: &'a Prepared,
    visibility: &'a Visibility,
    balls: &'a Table<FaceId, Ball>,
    areas_m2: &'a Table<ClusterId, f64>,
    least_factor: f64,
    /// With more pairs than this, they are not wanted.
    most: usize,
    pairs: Vec<[FaceId; 2]>,
}

impl Search<'_> {
    /// The pairs of faces of one cluster.
    fn within(&mut self, cluster: ClusterId) {
        if let Some([first, second]) = self.visibility.cluster(cluster).parts {
            self.within(first);
            self.within(second);
            return self.between(first, second);
        }
        let faces: Vec<FaceId> = self.visibility.cluster_faces(cluster).collect();
        for (i, &p) in faces.iter().enumerate() {
            faces[i + 1..].iter().for_each(|&q| self.pair(p, q));
        }
    }

    /// The pairs of a face of one cluster and one of another.
    fn between(&mut self, first: ClusterId, second: ClusterId) {
        let clusters = [first, second].map(|id| self.visibility.cluster(id));
        let apart_m = clusters[0].distance_m(&clusters[1]);
        let most_m2 = self.areas_m2[first].max(self.areas_m2[second]);
        if most_m2 < self.least_factor * PI * apart_m * apart_m || self.pairs.len() > self.most {
            return;
        }
        match clusters.map(|cluster| cluster.parts) {
            [Some(parts), of_second] if of_second.is_none() || self.areas_m2[first] >= self.areas_m2[second] => {
                parts.into_iter().for_each(|part| self.between(part, second));
            }
            [_, Some(parts)] => {
                parts.into_iter().for_each(|part| self.between(first, part));
            }
            _ => {
                for p in self.visibility.cluster_faces(first) {
                    self.visibility.cluster_faces(second).for_each(|q| self.pair(p, q));
                }
            }
        }
    }

    fn pair(&mut self, p: FaceId, q: FaceId) {
        let [plane_p, plane_q] = [p, q].map(|face| self.prepared.faces[face].plane);
        let [of_p, of_q] = [p, q].map(|face| &self.balls[face]);
        let apart_m = (of_p.middle_m.distance(of_q.middle_m) - of_p.radius_m - of_q.radius_m).max(0.0);
        let is_faint = of_p.area_m2.max(of_q.area_m2) < self.least_factor * PI * apart_m * apart_m;
        if plane_p != plane_q && !is_faint {
            self.pairs.push([p.min(q), p.max(q)]);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::visibility::fixture;

    /// Cubes in a row, so far apart that only neighbours matter to one another.
    fn row(count: i32) -> Vec<[FaceId; 2]> {
        let cubes = (0..count).flat_map(|i| {
            let low = DVec3::new(8.0 * f64::from(i), 0.0, 0.0);
            fixture::outward_box(low, low + 1.0)
        });
        let prepared = fixture::prepared(&cubes.collect::<Vec<_>>());
        pairs(&prepared, &Visibility::new(&prepared))
    }

    #[test]
    fn pairs_grow_with_the_faces_not_with_their_square() {
        let [some, many] = [row(100).len(), row(400).len()];
        assert!(many < 5 * some, "{some} and {many}");
        assert!(some > 100 * 12, "{some}");
    }

    #[test]
    fn in_a_crowd_pairs_stay_few_for_each_face() {
        // Cubes in a block: all are near enough to all others to be paired by form factor alone.
        let cubes = (0..1000).flat_map(|i| {
            let low = 1.5 * DVec3::new(f64::from(i % 10), f64::from(i / 10 % 10), f64::from(i / 100));
            fixture::outward_box(low, low + 1.0)
        });
        let prepared = fixture::prepared(&cubes.collect::<Vec<_>>());
        let found = pairs(&prepared, &Visibility::new(&prepared)).len();
        // The 12 pairs of each cube, whose faces touch, are left however few there may be.
        assert!(found >= 12 * 1000 && found <= MOST_PAIRS.max(12 * 6000) + MOST_A_FACE * 6000, "{found}");
    }

    #[test]
    fn near_one_another_all_pairs_are_found_once() {
        let prepared = fixture::prepared(&fixture::inward_box(DVec3::ZERO, DVec3::new(1.0, 2.0, 3.0)));
        let found = pairs(&prepared, &Visibility::new(&prepared));
        assert_eq!(found.len(), 15);
        assert!(found.windows(2).all(|two| two[0] < two[1]));
    }
}
