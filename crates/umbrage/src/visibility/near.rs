//! The faces around the facets of smooth surfaces, and the rays that these stop.
//!
//! A point of a smooth surface sees its own facet and the faces that have a corner in common with it from a place of its own
//! ([`super::receiver`]). Here is which faces these are, and what becomes of a ray from a receiver point to another point.

use glam::DVec3;

use super::{ReceiverPoint, Visibility};
use crate::id::{FaceId, PlaneId, Table, VertexId};
use crate::prepare::Prepared;

/// Of a vertex where more faces meet (the tip of a cone), only those that share an edge with a facet are around it.
const MOST_AT_VERTEX: usize = 32;

/// For each facet of a smooth surface, itself and the faces around it, ascending; none for flat faces.
pub(super) fn faces_around(prepared: &Prepared) -> Table<FaceId, Box<[FaceId]>> {
    let mut around: Table<FaceId, Box<[FaceId]>> = vec![Box::default(); prepared.faces.len()].into();
    if !prepared.faces.keys().any(|face| prepared.is_smooth(face)) {
        return around;
    }
    let mut at_vertex: Table<VertexId, Vec<FaceId>> = vec![Vec::new(); prepared.vertices_m.len()].into();
    for face in prepared.faces.keys() {
        prepared.boundary(face).for_each(|vertex| at_vertex[vertex].push(face));
    }
    for face in prepared.faces.keys().filter(|&face| prepared.is_smooth(face)) {
        let at_edges = prepared.faces[face].sides.iter().flatten().flat_map(|side| &prepared.edges[side.edge].faces);
        let few = prepared.boundary(face).map(|vertex| &at_vertex[vertex]).filter(|at| at.len() <= MOST_AT_VERTEX);
        let mut near: Vec<FaceId> = at_edges.chain(few.flatten()).copied().collect();
        near.sort_unstable();
        near.dedup();
        around[face] = near.into();
    }
    around
}

impl Visibility {
    /// The faces that a receiver point sees from its near view, ascending.
    pub(super) fn near(&self, receiver: &ReceiverPoint) -> &[FaceId] {
        receiver.near.map_or(&[], |near| self.around_facet(near.face))
    }

    /// Whether a receiver point sees a face from its near view.
    pub(super) fn is_near(&self, receiver: &ReceiverPoint, face: FaceId) -> bool {
        receiver.near.is_some() && self.near(receiver).binary_search(&face).is_ok()
    }

    /// A face that stands between a receiver point and another point, of some faces, or of all where none are given. Faces in the
    /// plane of the `source` that the other point belongs to do not.
    pub(crate) fn stopper(
        &self,
        receiver: &ReceiverPoint,
        to_m: DVec3,
        source: Option<PlaneId>,
        among: Option<&[FaceId]>,
    ) -> Option<FaceId> {
        let stops = |face: &&FaceId| self.stops(**face, receiver, to_m, source);
        if let Some(&near) = self.near(receiver).iter().find(stops) {
            return Some(near);
        }
        let passing = [receiver.plane, source.unwrap_or(receiver.plane)];
        self.blocker_but(among, receiver.position_m, to_m, passing, |face| self.is_near(receiver, face))
    }

    /// Whether a face stands between a receiver point and another point.
    pub(crate) fn stops(&self, face: FaceId, receiver: &ReceiverPoint, to_m: DVec3, source: Option<PlaneId>) -> bool {
        let plane = self.plane(face);
        if source == Some(plane) {
            return false;
        }
        match receiver.near {
            Some(near) if self.is_near(receiver, face) => self.is_crossed(face, near.from_m, to_m),
            _ => plane != receiver.plane && self.is_crossed(face, receiver.position_m, to_m),
        }
    }
}
