//! The event of the source's own plane: irradiance grows from zero with the depth below it (degree 1).
//!
//! A one-sided source below a ceiling cuts every wall in a line. What sees the source edge-on is reached by rays in its
//! plane from its corners, traced like a wedge a quarter turn at a time, and from its edges past the ends of what
//! stands in the plane.

use super::features::Surroundings;
use super::wedge::Wedge;
use super::{DSegment, Degree, Event, merge};
use crate::geometry::PlaneFrame;
use crate::id::EmitterId;

impl Surroundings<'_> {
    /// The segments in which the plane of an emitter meets the faces that see the emitter.
    pub(super) fn source_plane(&self, id: EmitterId) -> Vec<DSegment> {
        let emitter = &self.features.emitters[id];
        let event = Event::SourcePlane { emitter: id };
        let frame = PlaneFrame::new(emitter.plane, emitter.centroid_m);
        let reach_m = self.prepared.tolerance.extent_m;
        let axes = [frame.u, frame.v, -frame.u, -frame.v].map(|axis| axis * reach_m);
        let faces = self.visibility.faces_meeting_plane(&emitter.plane, |_, _| true);
        let mut segments = Vec::new();
        for &corner in &emitter.corners {
            let apex = emitter.plane.project(self.position(corner));
            for quarter in 0..4 {
                let ends = [apex + axes[quarter], apex + axes[(quarter + 1) % 4]];
                let Some(wedge) = Wedge::new(apex, ends, self.weld_m()) else { continue };
                let beyond = wedge.pieces_of(self.visibility, &faces);
                let received = self.received(&wedge, &[], &beyond);
                segments.extend(received.iter().filter_map(|part| self.segment(&wedge, part, event, Degree::D1)));
            }
        }
        for apex in self.ends_of_blockers(&faces, &emitter.plane) {
            for &edge in &emitter.outline {
                let source = self.ends(edge).map(|end| emitter.plane.project(end));
                segments.extend(self.pencil(apex, source, None, &faces, event));
            }
        }
        merge::merge(segments, self.weld_m())
    }
}
