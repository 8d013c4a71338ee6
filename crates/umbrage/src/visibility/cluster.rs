//! Clusters: the nodes of the spatial index, as crowds of faces that send or receive light together (Smits, Arvo and
//! Greenberg, *A clustering algorithm for radiosity in complex environments*, 1994).
//!
//! Holds: a face is in one cluster that has no parts, and in all that this one is a part of; the numbers depend on the
//! faces only.

use glam::DVec3;

use super::Visibility;
use crate::id::{ClusterId, FaceId, Table};

/// A crowd of faces.
#[derive(Clone, Copy, Debug)]
pub struct Cluster {
    /// The middle of its box, in metres.
    pub middle_m: DVec3,
    /// Half the size of its box, in metres.
    pub half_m: DVec3,
    /// The clusters that it is made of, if there are any.
    pub parts: Option<[ClusterId; 2]>,
}

impl Cluster {
    /// Distance between the boxes of two clusters, in metres.
    pub fn distance_m(&self, other: &Cluster) -> f64 {
        let apart_m = (self.middle_m - other.middle_m).abs() - self.half_m - other.half_m;
        apart_m.max(DVec3::ZERO).length()
    }

    /// Distance of a point from its box, in metres.
    pub fn distance_from_m(&self, point_m: DVec3) -> f64 {
        ((self.middle_m - point_m).abs() - self.half_m).max(DVec3::ZERO).length()
    }
}

impl Visibility {
    /// The cluster of all faces, if there are any.
    pub fn whole_cluster(&self) -> Option<ClusterId> {
        (!self.is_empty()).then(|| ClusterId::from(0))
    }

    /// Number of clusters.
    pub fn cluster_count(&self) -> usize {
        self.tree().nodes.len()
    }

    /// A cluster.
    pub fn cluster(&self, id: ClusterId) -> Cluster {
        let node = &self.tree().nodes[id.index()];
        let (min_m, max_m) = (node.aabb().min.as_dvec3(), node.aabb().max.as_dvec3());
        let first = node.first_index as usize;
        let parts = (!node.is_leaf()).then(|| [ClusterId::from(first), ClusterId::from(first + 1)]);
        Cluster { middle_m: 0.5 * (min_m + max_m), half_m: 0.5 * (max_m - min_m), parts }
    }

    /// The faces of a cluster that has no parts.
    pub fn cluster_faces(&self, id: ClusterId) -> impl Iterator<Item = FaceId> + '_ {
        let node = &self.tree().nodes[id.index()];
        let range = if node.is_leaf() { node.first_index..node.first_index + node.prim_count } else { 0..0 };
        self.tree().primitive_indices[range.start as usize..range.end as usize]
            .iter()
            .map(|&face| FaceId::from(face as usize))
    }

    /// Sums of a property of faces, over each cluster.
    pub fn over_clusters<T: Clone + std::ops::AddAssign>(
        &self,
        nothing: T,
        of: impl Fn(FaceId) -> T,
    ) -> Table<ClusterId, T> {
        let mut sums: Table<ClusterId, T> = vec![nothing; self.tree().nodes.len()].into();
        let mut order: Vec<ClusterId> = self.whole_cluster().into_iter().collect();
        let mut next = 0;
        while let Some(&id) = order.get(next) {
            order.extend(self.cluster(id).parts.into_iter().flatten());
            next += 1;
        }
        for id in order.into_iter().rev() {
            for part in self.cluster(id).parts.into_iter().flatten() {
                let of_part = sums[part].clone();
                sums[id] += of_part;
            }
            for face in self.cluster_faces(id) {
                sums[id] += of(face);
            }
        }
        sums
    }
}

#[cfg(test)]
mod tests {
    use super::super::fixture;
    use super::*;

    #[test]
    fn every_face_counts_once_in_every_cluster_around_it() {
        let boxes = (0..40).flat_map(|i| {
            let low = DVec3::new(f64::from(i % 7), f64::from(i % 5), f64::from(i));
            fixture::outward_box(low, low + 0.5)
        });
        let prepared = fixture::prepared(&boxes.collect::<Vec<_>>());
        let index = Visibility::new(&prepared);
        let counts = index.over_clusters(0, |_| 1);
        let whole = index.whole_cluster().unwrap();
        assert_eq!(counts[whole], prepared.faces.len());
        let mut open = vec![whole];
        while let Some(id) = open.pop() {
            let cluster = index.cluster(id);
            for face in index.cluster_faces(id) {
                for corner in index.boundary_m(face) {
                    assert!(cluster.distance_from_m(*corner) == 0.0);
                }
            }
            if let Some(parts) = cluster.parts {
                assert_eq!(counts[id], counts[parts[0]] + counts[parts[1]]);
                open.extend(parts);
            }
        }
        assert!(Visibility::new(&fixture::prepared(&[])).whole_cluster().is_none());
    }
}
