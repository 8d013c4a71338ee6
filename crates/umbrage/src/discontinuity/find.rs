//! Finds all d-segments of a scene: the preprocessing step of the meshing algorithm (paper, section 4).
//!
//! For every emitter: its plane, VE of its corners with every occluder edge, EV of its outline with every occluder
//! vertex. Then contacts. Events are traced in parallel, and gathered in the order of their features.

use std::sync::atomic::{AtomicUsize, Ordering};

use rayon::prelude::*;

use super::event::Surroundings;
use super::silhouette::OccluderEdges;
use super::{DSegment, Emitter, contact, emitter, merge};
use crate::id::{DSegmentId, EdgeId, EmitterId, FaceId, Table, VertexId};
use crate::prepare::Prepared;
use crate::progress::{Cancelled, Progress, Stage};
use crate::scene::Scene;
use crate::visibility::Visibility;

/// Events traced between two reports of progress.
const EVENTS_A_REPORT: usize = 1024;

/// Emitters and d-segments of a scene.
#[derive(Clone, Debug, Default)]
pub struct Discontinuities {
    /// The emitters.
    pub emitters: Table<EmitterId, Emitter>,
    /// The d-segments, by face and event.
    pub segments: Table<DSegmentId, DSegment>,
}

impl Discontinuities {
    /// Number of d-segments of degree 0, 1 and 2.
    pub fn count_by_degree(&self) -> [usize; 3] {
        let mut count = [0; 3];
        self.segments.iter().for_each(|segment| count[segment.degree.number()] += 1);
        count
    }
}

/// A source feature and an occluder feature that may cast a shadow boundary.
#[derive(Clone, Copy, Debug)]
enum Pair {
    Plane(EmitterId),
    VertexEdge(EmitterId, VertexId, usize),
    EdgeVertex(EmitterId, EdgeId, VertexId),
}

/// Calculates all discontinuity segments.
///
/// # Errors
/// [`Cancelled`] where the progress callback asks to stop.
pub fn find(
    scene: &Scene,
    prepared: &Prepared,
    visibility: &Visibility,
    progress: Progress<'_>,
) -> Result<Discontinuities, Cancelled> {
    let emitters = emitter::emitters(scene, prepared);
    let occluders = OccluderEdges::new(prepared);
    let receives = |face: FaceId| !scene.materials[prepared.faces[face].material].emits();
    let around = Surroundings { prepared, visibility, occluders: &occluders, receives: &receives };
    let pairs = pairs(&emitters, &occluders);
    let traced = AtomicUsize::new(0);
    let segments: Vec<Vec<DSegment>> = pairs
        .par_iter()
        .map(|pair| {
            let number = traced.fetch_add(1, Ordering::Relaxed);
            if number.is_multiple_of(EVENTS_A_REPORT) {
                progress.report(Stage::Discontinuity, number, pairs.len())?;
            }
            Ok(match *pair {
                Pair::Plane(id) => around.source_plane(id, &emitters[id]),
                Pair::VertexEdge(id, corner, number) => {
                    around.vertex_edge(id, &emitters[id], corner, &occluders.edges[number])
                }
                Pair::EdgeVertex(id, source, vertex) => around.edge_vertex(id, &emitters[id], source, vertex),
            })
        })
        .collect::<Result<_, Cancelled>>()?;
    let brightest = emitters.iter().map(Emitter::mean_radiance).fold(0.0, f64::max);
    let mut segments: Vec<DSegment> = segments.into_iter().flatten().collect();
    segments.extend(contact::contacts(prepared, receives, std::f64::consts::PI * brightest));
    let segments = merge::merge(segments, prepared.tolerance.weld_m()).into();
    Ok(Discontinuities { emitters, segments })
}

/// All pairs of a source feature and an occluder feature.
fn pairs(emitters: &Table<EmitterId, Emitter>, occluders: &OccluderEdges) -> Vec<Pair> {
    let mut pairs = Vec::new();
    for (id, emitter) in emitters.iter_enumerated() {
        pairs.push(Pair::Plane(id));
        for &corner in &emitter.corners {
            pairs.extend((0..occluders.edges.len()).map(|number| Pair::VertexEdge(id, corner, number)));
        }
        let vertices = occluders.at_vertex.iter_enumerated().filter(|(_, edges)| !edges.is_empty());
        for (vertex, _) in vertices {
            pairs.extend(emitter.outline.iter().map(|&source| Pair::EdgeVertex(id, source, vertex)));
        }
    }
    pairs
}
