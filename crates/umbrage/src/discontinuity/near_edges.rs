//! Edges close before a face, cast on it along its normal: there reflected light has a jump, or a kink as sharp as the edge is near.
//!
//! Direct light has its d-segments from the sources. Reflected light comes from everywhere; what changes it fast is what stands close: a
//! plate on a wall, a book before a shelf's back, a lamp under a ceiling. Seen from a point of the face right below its edge, half
//! of it comes or goes. So the outlines of what is nearer than [`NEAR_OF_LEAST`] times the smallest thing that is resolved
//! are lines of degree 0, and up to [`HINT_OF_LEAST`] times it of degree 1.

use glam::DVec3;
use rayon::prelude::*;
use rstar::primitives::{GeomWithData, Rectangle};
use rstar::{AABB, RTree};

use super::{DSegment, Degree, Event};
use crate::geometry::clip;
use crate::id::{EdgeId, FaceId};
use crate::prepare::Prepared;

/// Outlines this near are jumps, as a share of the least size.
const NEAR_OF_LEAST: f64 = 0.4;
/// Outlines this near are kinks, as a share of the least size.
const HINT_OF_LEAST: f64 = 5.0;
/// Nearer than so many times the distance at which vertices are one, an edge lies in the face.
const IN_FACE_OF_WELD: f64 = 2.0;
/// Shorter lines are left out, as a share of the distance of jumps.
const SHORT_OF_NEAR: f64 = 0.2;
/// Two faces whose normals have a greater cosine are one outline-free surface.
const FLAT: f64 = 0.999;
/// Faces with a smaller cosine to the normal are seen from the side.
const SIDEWAYS: f64 = 0.02;

type Edges = RTree<GeomWithData<Rectangle<[f64; 3]>, EdgeId>>;

/// The outlines close before the faces that show light, where things smaller than `least_m` are not resolved.
pub fn near_edges(prepared: &Prepared, least_m: f64, receives: impl Fn(FaceId) -> bool + Sync) -> Vec<DSegment> {
    let outline =
        |faces: &[FaceId]| !(faces.len() == 2 && prepared.normal(faces[0]).dot(prepared.normal(faces[1])) > FLAT);
    let boxes = prepared.edges.iter_enumerated().filter(|(_, edge)| outline(&edge.faces)).map(|(id, edge)| {
        let [p, q] = edge.ends.map(|end| prepared.vertices_m[end].to_array());
        GeomWithData::new(Rectangle::from_corners(p, q), id)
    });
    let edges: Edges = RTree::bulk_load(boxes.collect());
    let faces: Vec<FaceId> = prepared.faces.keys().filter(|&face| receives(face)).collect();
    faces.par_iter().flat_map_iter(|&face| before(prepared, &edges, face, least_m)).collect()
}

/// The outlines close before one face.
fn before(prepared: &Prepared, edges: &Edges, face: FaceId, least_m: f64) -> Vec<DSegment> {
    let (near_m, hint_m) = (NEAR_OF_LEAST * least_m, HINT_OF_LEAST * least_m);
    let in_face_m = IN_FACE_OF_WELD * prepared.tolerance.weld_m();
    let (plane, frame) = (prepared.oriented_plane(face), prepared.face_frame(face));
    let corners = prepared.polygon_m(face);
    let flat: Vec<_> = corners.iter().map(|&corner| frame.to_2d(corner)).collect();
    let reach = |corner: &DVec3| [*corner, *corner + hint_m * plane.normal];
    let low = corners.iter().flat_map(reach).fold(DVec3::INFINITY, DVec3::min);
    let high = corners.iter().flat_map(reach).fold(DVec3::NEG_INFINITY, DVec3::max);
    let mut found: Vec<EdgeId> = edges
        .locate_in_envelope_intersecting(AABB::from_corners(low.to_array(), high.to_array()))
        .map(|edge| edge.data)
        .collect();
    found.sort_unstable();
    let segment = |&id: &EdgeId| {
        let edge = &prepared.edges[id];
        let ends = edge.ends.map(|end| prepared.vertices_m[end]);
        let heights = ends.map(|end| plane.signed_distance_m(end));
        let [lower, upper] = [heights[0].min(heights[1]), heights[0].max(heights[1])];
        if upper <= in_face_m || lower > hint_m || edge.faces.contains(&face) {
            return None;
        }
        // Seen along the normal it must be an outline.
        let leans =
            |way: f64| edge.faces.iter().all(|&other| way * prepared.normal(other).dot(plane.normal) > SIDEWAYS);
        if edge.faces.len() >= 2 && (leans(1.0) || leans(-1.0)) {
            return None;
        }
        let rise = heights[1] - heights[0];
        let at_height = |height: f64| if rise == 0.0 { 0.0 } else { (height - heights[0]) / rise };
        let [from, to] = match rise {
            rise if rise > 0.0 => [at_height(0.0), at_height(hint_m)],
            rise if rise < 0.0 => [at_height(hint_m), at_height(0.0)],
            _ => [0.0, 1.0],
        }
        .map(|t| t.clamp(0.0, 1.0));
        let foot = |t: f64| frame.to_2d(ends[0].lerp(ends[1], t));
        let (t0, t1) = clip::line_in_convex(foot(0.0), foot(1.0), &flat, (from, to))?;
        let ends_m = [t0, t1].map(|t| frame.to_3d(foot(t)));
        let short_m = SHORT_OF_NEAR * near_m.max(10.0 * prepared.tolerance.weld_m());
        let top_m = upper.min(hint_m);
        let degree = if top_m <= near_m { Degree::D0 } else { Degree::D1 };
        let strength = 1.0 / top_m;
        (ends_m[0].distance(ends_m[1]) >= short_m).then_some(DSegment {
            face,
            ends_m,
            degree,
            strength,
            event: Event::Contact { edge: id },
        })
    };
    found.iter().filter_map(segment).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::visibility::fixture;

    #[test]
    fn a_plate_close_to_a_wall_casts_its_outline_on_it() {
        let wall = fixture::square(DVec3::ZERO, 1.0, true);
        let plate = |gap_m: f64| {
            let low = DVec3::new(-0.25, -0.5, gap_m);
            fixture::outward_box(low, low + DVec3::new(0.5, 0.75, 0.01))
        };
        let on_wall = |gap_m: f64| {
            let polygons: Vec<_> = std::iter::once(wall.clone()).chain(plate(gap_m)).collect();
            let prepared = fixture::prepared(&polygons);
            let face = prepared
                .faces
                .keys()
                .find(|&face| prepared.polygon_m(face).iter().all(|p| (p + prepared.origin_m).z.abs() < 1e-6))
                .unwrap();
            let found: Vec<DSegment> =
                near_edges(&prepared, 0.01, |_| true).into_iter().filter(|segment| segment.face == face).collect();
            let length: f64 = found.iter().map(DSegment::length_m).sum();
            let jumps = found.iter().filter(|segment| segment.degree == Degree::D0).count();
            (found.len(), length, jumps)
        };
        let (_, length, jumps) = on_wall(0.001);
        // Its lower outline, and the upper one as a kink.
        assert!(jumps == 4 && (length - 5.0).abs() < 1e-6, "{length}, {jumps}");
        let (_, length, jumps) = on_wall(0.02);
        assert!(jumps == 0 && (length - 5.0).abs() < 1e-6, "{length}, {jumps}");
        assert_eq!(on_wall(0.06).0, 0);
    }
}
