//! A source edge and an occluder edge in one plane: where the plane meets the receiver, the occluder edge lies upon the
//! source edge, and the slope of irradiance jumps (degree 1).
//!
//! In buildings most edges are parallel to others, so this is the common case and the strongest. All EV and VE wedges
//! of the two edges lie in their plane; one event stands for them.

use glam::DVec3;

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
        if source.edge == edge.edge || edge.hidden_sides(&plane, self.coplanar_m()) == [true, true] {
            return Vec::new();
        }
        let event = Event::EdgeEdge { emitter: source.emitter, source: source.edge, occluder: edge.edge };
        // An occluder edge that crosses the source's line hides, on either side of it, other emitters along the edge.
        let steps =
            |part: &[DVec3; 2]| source.step(part[0].midpoint(part[1]), self.coplanar_m(), Rgb::ZERO) != Rgb::ZERO;
        let parts = source.parts_beside(&plane, edge.ends_m, self.coplanar_m()).into_iter().filter(steps);
        let segments = parts.flat_map(|occluder| {
            let given = InPlane { plane, source: source.ends_m, occluder, beside: &|face| edge.is_beside(face) };
            self.in_plane(&given, event)
        });
        merge::merge(segments.collect(), self.weld_m())
    }
}
