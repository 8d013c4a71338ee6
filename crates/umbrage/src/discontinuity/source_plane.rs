//! The event of the source's own plane: irradiance grows from zero with the depth below it.
//!
//! A one-sided source below a ceiling cuts every wall in a line of degree 1. The plane is traced like a wedge, from each
//! corner of the emitter, a quarter turn at a time.

use super::event::Surroundings;
use super::strength::Sight;
use super::trace;
use super::wedge::Wedge;
use super::{DSegment, Degree, Emitter, Event};
use crate::geometry::PlaneFrame;
use crate::id::EmitterId;

impl Surroundings<'_> {
    /// The segments in which the plane of an emitter meets the faces that its corners see.
    pub(super) fn source_plane(&self, id: EmitterId, emitter: &Emitter) -> Vec<DSegment> {
        let frame = PlaneFrame::new(emitter.plane, emitter.centroid_m);
        let reach_m = self.prepared.tolerance.extent_m;
        let axes = [frame.u, frame.v, -frame.u, -frame.v].map(|axis| axis * reach_m);
        let mut segments = Vec::new();
        for &corner in &emitter.corners {
            let apex = self.prepared.vertices_m[corner];
            for quarter in 0..4 {
                let ends = [apex + axes[quarter], apex + axes[(quarter + 1) % 4]];
                let Some(wedge) = Wedge::new(apex, ends, self.prepared.tolerance.weld_m()) else { continue };
                let beyond = wedge.pieces(self.prepared, self.visibility, 0.0, |_| false);
                for part in trace::received(&[], &beyond, |face| self.lit(face, apex)) {
                    let ends_m = [0, 1].map(|i| wedge.point(part.s[i], part.nearness[i]));
                    let receiver = self.prepared.oriented_plane(part.face);
                    let at = ends_m[0].midpoint(ends_m[1]);
                    let sight = Sight { emitter, receiver: &receiver, wedge: &emitter.plane, at };
                    segments.push(DSegment {
                        face: part.face,
                        ends_m,
                        degree: Degree::D1,
                        strength: sight.of_source_plane(),
                        event: Event::SourcePlane { emitter: id },
                    });
                }
            }
        }
        segments
    }
}
