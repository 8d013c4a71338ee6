//! A source edge and an occluder edge in one plane: where the plane meets the receiver, the occluder edge lies upon the
//! source edge, and the slope of irradiance jumps (degree 1).
//!
//! In buildings most edges are parallel to others, so this is the common case and the strongest. All EV and VE wedges
//! of the two edges lie in their plane; one event stands for them.

use super::features::Surroundings;
use super::in_plane::InPlane;
use super::silhouette::OccluderEdge;
use super::source::SourceEdge;
use super::{DSegment, Event, merge};
use crate::scene::Rgb;

impl Surroundings<'_> {
    /// The event of two edges, if they lie in one plane.
    pub(super) fn edge_edge(&self, source: &SourceEdge, edge: &OccluderEdge) -> Vec<DSegment> {
        let Some(plane) = self.common_plane(source.ends_m, edge.ends_m) else { return Vec::new() };
        let emitter = &self.features.emitters[source.emitter];
        // What lies behind the emitter's plane hides nothing of it, but of its neighbours at the edge it may.
        let occluder = self.part_in_front(emitter, edge.ends_m).unwrap_or(edge.ends_m);
        let middle = occluder[0].midpoint(occluder[1]);
        if source.edge == edge.edge
            || edge.hidden_sides(&plane, self.coplanar_m()) == [true, true]
            || source.step(middle, self.coplanar_m(), Rgb::ZERO) == Rgb::ZERO
        {
            return Vec::new();
        }
        let event = Event::EdgeEdge { emitter: source.emitter, source: source.edge, occluder: edge.edge };
        let given = InPlane { plane, source: source.ends_m, occluder, beside: &|face| edge.is_beside(face) };
        merge::merge(self.in_plane(&given, event), self.weld_m())
    }
}
