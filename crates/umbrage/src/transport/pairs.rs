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
//! Holds: pairs are in the order of their faces, the smaller first.

use std::f64::consts::PI;

use crate::geometry::polygon;
use crate::id::{ClusterId, FaceId, Table};
use crate::prepare::Prepared;
use crate::visibility::Visibility;

/// Clusters whose faces have a smaller form factor to all of one another are not linked: links are good enough to start from
/// without them.
const LEAST_FACTOR: f64 = 0.01;

/// The pairs of faces of different planes that could exchange much.
pub(super) fn pairs(prepared: &Prepared, visibility: &Visibility) -> Vec<[FaceId; 2]> {
    let of_faces_m2: Table<FaceId, f64> =
        prepared.faces.keys().map(|face| polygon::area_m2(&prepared.polygon_m(face))).collect();
    let areas_m2 = visibility.over_clusters(0.0, |face| of_faces_m2[face]);
    let mut search = Search { prepared, visibility, areas_m2, pairs: Vec::new() };
    if let Some(whole) = visibility.whole_cluster() {
        search.within(whole);
    }
    search.pairs.sort_unstable();
    search.pairs
}

struct Search<'a> {
    prepared: &'a Prepared,
    visibility: &'a Visibility,
    areas_m2: Table<ClusterId, f64>,
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
        if most_m2 < LEAST_FACTOR * PI * apart_m * apart_m {
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
        if plane_p != plane_q {
            self.pairs.push([p.min(q), p.max(q)]);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::visibility::fixture;
    use glam::DVec3;

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
    fn near_one_another_all_pairs_are_found_once() {
        let prepared = fixture::prepared(&fixture::inward_box(DVec3::ZERO, DVec3::new(1.0, 2.0, 3.0)));
        let found = pairs(&prepared, &Visibility::new(&prepared));
        assert_eq!(found.len(), 15);
        assert!(found.windows(2).all(|two| two[0] < two[1]));
    }
}
