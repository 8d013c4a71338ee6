//! Merging of coincident d-segments, by their origin: parts of one event on one face that overlap become one.
//!
//! The pencils of two coplanar edges share a plane, and so do those of a source's plane and an occluder's; their
//! segments on a face lie on one line. Equal origin says so, no coordinate has to.

use super::DSegment;

/// Sorts by face and event and unites segments of the same face and event that overlap or touch within `gap_m`. They
/// have no strength yet, and get none.
pub(super) fn merge(mut segments: Vec<DSegment>, gap_m: f64) -> Vec<DSegment> {
    if segments.len() < 2 {
        return segments;
    }
    segments.sort_by(DSegment::by_face_and_event);
    let mut merged = Vec::with_capacity(segments.len());
    for group in segments.chunk_by(|p, q| p.face == q.face && p.event == q.event) {
        unite(group, gap_m, &mut merged);
    }
    merged
}

/// Unites the overlapping ones of collinear segments.
fn unite(group: &[DSegment], gap_m: f64, merged: &mut Vec<DSegment>) {
    let longest =
        group.iter().fold(&group[0], |best, next| if next.length_m() > best.length_m() { next } else { best });
    let origin = longest.ends_m[0];
    let along = (longest.ends_m[1] - origin).normalize_or_zero();
    let mut intervals: Vec<([f64; 2], &DSegment)> = group
        .iter()
        .map(|segment| {
            let [p, q] = segment.ends_m.map(|end| (end - origin).dot(along));
            ([p.min(q), p.max(q)], segment)
        })
        .collect();
    intervals.sort_by(|p, q| p.0[0].total_cmp(&q.0[0]).then(p.0[1].total_cmp(&q.0[1])));
    let mut open: Option<([f64; 2], DSegment)> = None;
    for (interval, segment) in intervals {
        match &mut open {
            Some((reach, _)) if interval[0] <= reach[1] + gap_m => {
                reach[1] = reach[1].max(interval[1]);
            }
            _ => {
                close(open.take(), origin, along, merged);
                open = Some((interval, *segment));
            }
        }
    }
    close(open, origin, along, merged);
}

fn close(open: Option<([f64; 2], DSegment)>, origin: glam::DVec3, along: glam::DVec3, merged: &mut Vec<DSegment>) {
    merged.extend(open.map(|(reach, kept)| DSegment { ends_m: reach.map(|t| origin + t * along), ..kept }));
}

#[cfg(test)]
mod tests {
    use super::super::{Degree, Event};
    use super::*;
    use crate::id::{EmitterId, FaceId};
    use glam::DVec3;

    fn segment(from: f64, to: f64, emitter: usize) -> DSegment {
        DSegment {
            face: FaceId::from(0),
            ends_m: [DVec3::X * from, DVec3::X * to],
            degree: Degree::D1,
            strength: 0.0,
            event: Event::SourcePlane { emitter: EmitterId::from(emitter) },
        }
    }

    #[test]
    fn overlapping_parts_of_one_event_are_one() {
        let merged = merge(vec![segment(0.0, 1.0, 0), segment(2.0, 0.5, 0), segment(3.0, 4.0, 0)], 1e-6);
        let mut spans: Vec<f64> = merged.iter().map(DSegment::length_m).collect();
        spans.sort_by(f64::total_cmp);
        assert_eq!(spans, [1.0, 2.0]);
    }

    #[test]
    fn parts_of_different_events_stay_apart() {
        assert_eq!(merge(vec![segment(0.0, 1.0, 0), segment(0.0, 1.0, 1)], 1e-6).len(), 2);
    }
}
