//! Events of degree 1: rays in one plane, from a line on a source through a line on an occluder.
//!
//! A receiver point in the plane sees a part of the source line through the occluder line, or none. That part begins and ends
//! at an end of the source line, at an end of the occluder line, or at an end of something that stands in the plane
//! before or behind. So the points that see any of it are those which the pencils of rays through all of these ends reach:
//! the VE and EV wedges of the two lines, and one more pencil for each end of a blocker.
//!
//! ```text
//!    p ========= q      source line
//!       \     /
//!      a ==+== b        occluder line: a hole through which the source line is seen
//!         / | x--x      a blocker: its end x has a pencil too
//!   _____/__|___________ receiver: reached between the outermost rays
//! ```

use glam::DVec3;

use super::features::Surroundings;
use super::trace::{self, Received};
use super::wedge::{Crossing, Wedge, chord};
use super::{DSegment, Degree, Event};
use crate::geometry::Plane;
use crate::id::FaceId;

/// More blockers than this in one plane get no pencils of their own: their number would be squared. What is missed
/// is a part of a segment that only their ends let through.
const MOST_BLOCKERS: usize = 200;

/// A plane with a line on a source in it, and one on an occluder that rays must pass.
pub(super) struct InPlane<'a> {
    pub(super) plane: Plane,
    pub(super) source: [DVec3; 2],
    pub(super) occluder: [DVec3; 2],
    /// Faces that do not stop rays, since they lie along the occluder's line.
    pub(super) beside: &'a dyn Fn(FaceId) -> bool,
}

impl Surroundings<'_> {
    /// The segments of the points that see a part of the source line through the occluder line.
    pub(super) fn in_plane(&self, given: &InPlane<'_>, event: Event) -> Vec<DSegment> {
        let flat = |line: [DVec3; 2]| line.map(|end| given.plane.project(end));
        let (source, occluder) = (flat(given.source), flat(given.occluder));
        let between = source.iter().find_map(|&apex| Wedge::new(apex, occluder, self.weld_m()));
        if between.is_some_and(|wedge| self.is_walled_off(&wedge, source, occluder, given.beside)) {
            return Vec::new();
        }
        let mut faces: Vec<FaceId> = Vec::new();
        let mut segments = Vec::new();
        for apex in source {
            let Some(wedge) = Wedge::new(apex, occluder, self.weld_m()) else { continue };
            let found = wedge.faces(self.visibility, 0.0);
            let pieces = wedge.pieces_of(self.visibility, &without(&found, given.beside));
            faces.extend(found);
            let hiding = trace::part_at(&pieces, 1.0, true);
            let beyond = trace::part_at(&pieces, 1.0, false);
            let received = self.received(&wedge, &hiding, &beyond);
            segments.extend(received.iter().filter_map(|part| self.segment(&wedge, part, event, Degree::D1)));
        }
        for apex in occluder {
            let Some(towards) = Wedge::new(apex, source, self.weld_m()) else { continue };
            faces.extend(towards.faces(self.visibility, 1.0));
            faces.extend(towards.opposite().faces(self.visibility, 0.0));
        }
        faces.sort_unstable();
        faces.dedup();
        let faces = without(&faces, given.beside);
        for apex in occluder {
            segments.extend(self.pencil(apex, source, None, &faces, event));
        }
        for apex in self.ends_of_blockers(&faces, &given.plane) {
            segments.extend(self.pencil(apex, source, Some(occluder), &faces, event));
        }
        segments
    }

    /// The ends of what may hide a part of the source line: all but a lone receiver.
    pub(super) fn ends_of_blockers(&self, faces: &[FaceId], plane: &Plane) -> Vec<DVec3> {
        let chords: Vec<[DVec3; 2]> = faces
            .iter()
            .filter_map(|&face| chord(self.visibility, face, plane))
            .map(|(_, ends)| ends)
            .filter(|ends| ends[0].distance(ends[1]) > self.weld_m())
            .collect();
        if chords.len() < 2 || chords.len() > MOST_BLOCKERS {
            return Vec::new();
        }
        let mut ends: Vec<DVec3> = chords.into_iter().flatten().map(|end| plane.project(end)).collect();
        ends.sort_by(|p, q| p.x.total_cmp(&q.x).then(p.y.total_cmp(&q.y)).then(p.z.total_cmp(&q.z)));
        ends.dedup();
        ends
    }

    /// The segments on which rays fall that come from the source line and pass `apex`, and the occluder line, if
    /// there is one, before or after.
    pub(super) fn pencil(
        &self,
        apex: DVec3,
        source: [DVec3; 2],
        occluder: Option<[DVec3; 2]>,
        faces: &[FaceId],
        event: Event,
    ) -> Vec<DSegment> {
        let Some(towards) = Wedge::new(apex, source, self.weld_m()) else { return Vec::new() };
        let away = towards.opposite();
        // Any face id does: these pieces are not received.
        let line = |wedge: &Wedge| wedge.piece(FaceId::from(0), Crossing::Through, occluder?);
        // Where the occluder line is passed: between source and apex (in front), or beyond the apex.
        let (before, after) = (line(&towards), line(&away));
        if occluder.is_some() && before.is_none() && after.is_none() {
            return Vec::new();
        }
        let hiding = trace::part_at(&towards.pieces_of(self.visibility, faces), 1.0, true);
        let beyond = away.pieces_of(self.visibility, faces);
        let received = self.received(&away, &hiding, &beyond);
        let passed = |part: &Received| -> Vec<Received> {
            if occluder.is_none() {
                return vec![*part];
            }
            let before = before.iter().filter(|line| line.nearness[0] + line.nearness[1] > 2.0);
            let mut parts: Vec<Received> = before.filter_map(|line| part.clipped(line.s)).collect();
            if let Some(line) = &after {
                // Lines in one plane do not cross but at ends: what is received beyond the middle is so all along.
                parts.extend(part.clipped(line.s).filter(|part| {
                    let middle = 0.5 * (part.s[0] + part.s[1]);
                    line.nearness_at(middle) > 0.5 * (part.nearness[0] + part.nearness[1])
                }));
            }
            parts
        };
        received.iter().flat_map(passed).filter_map(|part| self.segment(&away, &part, event, Degree::D1)).collect()
    }
}

fn without(faces: &[FaceId], but: &dyn Fn(FaceId) -> bool) -> Vec<FaceId> {
    faces.iter().copied().filter(|&face| !but(face)).collect()
}
