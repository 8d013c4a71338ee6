//! What events are made of: emitters, the features of sources and occluders, and the questions that all events ask.

use std::sync::atomic::{AtomicUsize, Ordering};

use glam::DVec3;

use super::corner::Corners;
use super::silhouette::OccluderEdges;
use super::source::{SourceEdge, Sources};
use super::trace::{self, Received};
use super::wedge::{Piece, Wedge};
use super::{DSegment, Degree, Emitter, Event, emitter};
use crate::geometry::Plane;
use crate::id::{EdgeId, EmitterId, FaceId, LampId, PlaneId, Table, VertexId};
use crate::prepare::Prepared;
use crate::scene::{Lamp, Rgb, Scene};
use crate::visibility::Visibility;

/// Emitters, edges and corners of a scene: what its events are made of.
#[derive(Clone, Debug)]
pub struct Features {
    pub(super) emitters: Table<EmitterId, Emitter>,
    /// Lamps without extent, in the frame of the prepared faces.
    pub(super) lamps: Table<LampId, Lamp>,
    pub(super) sources: Sources,
    pub(super) occluders: OccluderEdges,
    pub(super) corners: Corners,
    /// Whether a face shows received light: emitters are drawn in their own colour.
    pub(super) receives: Table<FaceId, bool>,
    /// Faces by plane.
    by_plane: Vec<(PlaneId, FaceId)>,
}

impl Features {
    /// The features of a scene.
    pub fn new(scene: &Scene, prepared: &Prepared) -> Self {
        let radiance = prepared.faces.iter().map(|face| scene.materials[face.material].radiance).collect();
        let lamps = scene.lamps.iter().map(|lamp| lamp.clone().moved(|p| p - prepared.origin_m, |d| d, 1.0));
        Self { lamps: lamps.collect(), ..Self::shining(scene, prepared, &radiance, Vec::new()) }
    }

    /// The features of a scene where nothing gives light but faces, which have these radiances, and parts of faces.
    pub(super) fn shining(
        scene: &Scene,
        prepared: &Prepared,
        radiance: &Table<FaceId, Rgb>,
        parts: Vec<Emitter>,
    ) -> Self {
        let mut emitters = emitter::emitters(prepared, radiance);
        emitters.extend(parts);
        let mut by_plane: Vec<(PlaneId, FaceId)> =
            prepared.faces.iter_enumerated().map(|(id, face)| (face.plane, id)).collect();
        by_plane.sort_unstable();
        Self {
            sources: Sources::new(prepared, radiance, &emitters),
            corners: Corners::new(prepared, radiance, &emitters),
            emitters,
            lamps: Table::new(),
            occluders: OccluderEdges::new(prepared),
            receives: prepared.faces.iter().map(|face| !scene.materials[face.material].emits()).collect(),
            by_plane,
        }
    }

    /// The faces in a plane, ascending.
    pub(super) fn faces_in(&self, plane: PlaneId) -> impl Iterator<Item = FaceId> + '_ {
        let first = self.by_plane.partition_point(|entry| entry.0 < plane);
        self.by_plane[first..].iter().take_while(move |entry| entry.0 == plane).map(|entry| entry.1)
    }

    /// The source edge of an edge.
    pub(super) fn source_edge(&self, edge: EdgeId) -> Option<&SourceEdge> {
        let edges = &self.sources.edges;
        edges.binary_search_by_key(&edge, |source| source.edge).ok().map(|number| &edges[number])
    }
}

/// What the tracing of events reads.
#[derive(Clone, Copy)]
pub(super) struct Surroundings<'a> {
    pub(super) prepared: &'a Prepared,
    pub(super) visibility: &'a Visibility,
    pub(super) features: &'a Features,
    /// Wedges traced so far.
    pub(super) wedges: &'a AtomicUsize,
}

impl Surroundings<'_> {
    pub(super) fn position(&self, vertex: VertexId) -> DVec3 {
        self.prepared.vertices_m[vertex]
    }

    pub(super) fn ends(&self, edge: EdgeId) -> [DVec3; 2] {
        self.prepared.edges[edge].ends.map(|vertex| self.position(vertex))
    }

    pub(super) fn coplanar_m(&self) -> f64 {
        self.prepared.tolerance.coplanar_m()
    }

    pub(super) fn weld_m(&self) -> f64 {
        self.prepared.tolerance.weld_m()
    }

    /// The faces that receive the rays of a wedge (see [`trace::received`]).
    pub(super) fn received(&self, wedge: &Wedge, hiding: &[Piece], beyond: &[Piece]) -> Vec<Received> {
        self.wedges.fetch_add(1, Ordering::Relaxed);
        trace::received(hiding, beyond, |face| self.lit(face, wedge.apex), |face| self.visibility.plane(face))
    }

    /// Whether the front of a face is turned to `eye`, and it shows received light.
    pub(super) fn lit(&self, face: FaceId, eye: DVec3) -> bool {
        self.features.receives[face] && self.prepared.oriented_plane(face).signed_distance_m(eye) > self.coplanar_m()
    }

    /// The plane of two edges, if they have one: where one of the four ends is nearer to the plane of the other three
    /// than the coplanar tolerance. A short edge says little of a plane, so it is the ends that count and not the
    /// angle.
    pub(super) fn common_plane(&self, one: [DVec3; 2], other: [DVec3; 2]) -> Option<Plane> {
        let corners = [one[0], one[1], other[0], other[1]];
        let volume = (one[1] - one[0]).cross(other[0] - one[0]).dot(other[1] - one[0]);
        let normal = |i: usize| {
            let [p, q, r] = [corners[(i + 1) % 4], corners[(i + 2) % 4], corners[(i + 3) % 4]];
            ((q - p).cross(r - p), p)
        };
        let (largest, through) =
            (0..4).map(normal).reduce(|p, q| if q.0.length_squared() > p.0.length_squared() { q } else { p })?;
        if volume.abs() > self.coplanar_m() * largest.length() {
            return None;
        }
        Some(Plane::through(through, largest.try_normalize()?))
    }

    /// The part of a line in front of the plane of an emitter.
    pub(super) fn part_in_front(&self, emitter: &Emitter, ends: [DVec3; 2]) -> Option<[DVec3; 2]> {
        let heights_m = ends.map(|end| emitter.plane.signed_distance_m(end) - self.coplanar_m());
        let crossing = || ends[0].lerp(ends[1], heights_m[0] / (heights_m[0] - heights_m[1]));
        match heights_m.map(|height_m| height_m > 0.0) {
            [true, true] => Some(ends),
            [true, false] => Some([ends[0], crossing()]),
            [false, true] => Some([crossing(), ends[1]]),
            [false, false] => None,
        }
    }

    /// The segment on a face that receives a part of a wedge, if it is long enough to be one.
    pub(super) fn segment(&self, wedge: &Wedge, part: &Received, event: Event, degree: Degree) -> Option<DSegment> {
        let ends_m = [0, 1].map(|i| wedge.point(part.s[i], part.nearness[i]));
        self.segment_between(part.face, ends_m, event, degree)
    }

    /// The segment between two points of a face, if it is long enough to be one.
    pub(super) fn segment_between(
        &self,
        face: FaceId,
        ends_m: [DVec3; 2],
        event: Event,
        degree: Degree,
    ) -> Option<DSegment> {
        let segment = DSegment { face, ends_m, degree, strength: 0.0, event };
        (segment.length_m() > self.weld_m()).then_some(segment)
    }
}
