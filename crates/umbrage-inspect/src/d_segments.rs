//! Stage `d-segments`: where light, its slope or its curvature jumps, and what makes it.

use glam::DVec3;
use umbrage::bake::Traced;
use umbrage::discontinuity::{DSegment, Degree, Emitter, Event};
use umbrage::id::{EdgeId, VertexId};
use umbrage::prepare::Prepared;
use umbrage::scene::Scene;

use crate::json::{self, Document, Record, Rounding, ids, quantity};
use crate::receiver::{Receiver, face_records, receivers};
use crate::sheet::{Drawing, Line, Polygon, Sheet};

/// Width of the strongest lines of each degree, in pixels.
const WIDEST: f64 = 3.2;
/// Width of lines this many powers of ten weaker, and more.
const THINNEST: f64 = 0.5;
const DECADES: f64 = 3.0;

/// What the strength of each degree is measured in.
const UNITS: [&str; 3] = ["W/m2", "W/m3", "W/m4"];

/// Class of each degree in drawings.
pub(crate) const CLASSES: [&str; 3] = ["d0", "d1", "d2"];

/// The d-segments as JSON.
pub fn json(scene: &Scene, traced: &Traced) -> String {
    let Traced { prepared, discontinuities } = traced;
    let rounding = Rounding::of_extent(prepared.tolerance.extent_m);
    let (receivers, of_face) = receivers(scene, prepared);
    let writer = Writer { prepared, rounding };
    Document::of_stage("d-segments", &scene.name)
        .table("emitters", discontinuities.emitters.iter().enumerate().map(|(id, emitter)| writer.emitter(id, emitter)))
        .table("receivers", receivers.iter().enumerate().map(|(number, receiver)| receiver.record(number)))
        .table("faces", face_records(prepared, &of_face, rounding))
        .table(
            "d_segments",
            discontinuities
                .segments
                .iter_enumerated()
                .map(|(id, segment)| writer.segment(id.index(), of_face[segment.face], segment)),
        )
        .end()
}

/// Writes records of one scene.
struct Writer<'a> {
    prepared: &'a Prepared,
    rounding: Rounding,
}

impl Writer<'_> {
    fn emitter(&self, id: usize, emitter: &Emitter) -> Record {
        Record::default()
            .with("id", id.to_string())
            .with("faces", ids(emitter.faces.iter().map(|face| face.index())))
            .with("radiance", json::list(emitter.radiance.to_array().map(quantity)))
            .with("area_m2", quantity(emitter.area_m2))
            .with("outline", ids(emitter.outline.iter().map(|edge| edge.index())))
    }

    fn segment(&self, id: usize, receiver: usize, segment: &DSegment) -> Record {
        let degree = segment.degree.number();
        let record = Record::default()
            .with("id", id.to_string())
            .with("receiver", receiver.to_string())
            .with("face", segment.face.index().to_string())
            .with("degree", degree.to_string())
            .with("strength", quantity(segment.strength))
            .with("unit", json::text(UNITS[degree]))
            .with("ends_m", self.rounding.points(segment.ends_m.map(|end| self.prepared.origin_m + end)));
        let record = self.event(record, segment.event);
        match segment.visible_interval(self.prepared) {
            Some(interval) => record.with("visible", json::list(interval.map(quantity))),
            None => record,
        }
    }

    fn event(&self, record: Record, event: Event) -> Record {
        let record = record.with("event", json::text(event.name()));
        match event {
            Event::Contact { edge } => record.with("occluder", self.edge(edge)),
            Event::SourcePlane { emitter } => record.with("emitter", emitter.index().to_string()),
            Event::OccluderPlane { emitter, occluder } => {
                let in_plane = self.prepared.faces.iter_enumerated().filter(|(_, face)| face.plane == occluder);
                record
                    .with("emitter", emitter.index().to_string())
                    .with("occluder", Record::default().with("faces", ids(in_plane.map(|(id, _)| id.index()))).end())
            }
            Event::LampEdge { lamp, occluder } => {
                record.with("lamp", lamp.index().to_string()).with("occluder", self.edge(occluder))
            }
            Event::LampCurve { lamp, .. } => record.with("lamp", lamp.index().to_string()),
            Event::EdgeEdge { emitter, source, occluder } => record
                .with("emitter", emitter.index().to_string())
                .with("source", self.edge(source))
                .with("occluder", self.edge(occluder)),
            Event::ThreeEdges { emitter, source, occluders: [nearer, last] } => record
                .with("emitter", emitter.index().to_string())
                .with("source", self.edge(source))
                .with("nearer", self.edge(nearer))
                .with("occluder", self.edge(last)),
            Event::VertexEdge { emitter, source, occluder } => record
                .with("emitter", emitter.index().to_string())
                .with("source", self.vertex(source))
                .with("occluder", self.edge(occluder)),
            Event::EdgeVertex { emitter, source, occluder } => record
                .with("emitter", emitter.index().to_string())
                .with("source", self.edge(source))
                .with("occluder", self.vertex(occluder)),
        }
    }

    fn world(&self, vertex: VertexId) -> DVec3 {
        self.prepared.origin_m + self.prepared.vertices_m[vertex]
    }

    fn edge(&self, edge: EdgeId) -> String {
        let ends = self.prepared.edges[edge].ends.map(|vertex| self.world(vertex));
        Record::default().with("edge", edge.index().to_string()).with("ends_m", self.rounding.points(ends)).end()
    }

    fn vertex(&self, vertex: VertexId) -> String {
        let at = self.rounding.point(self.world(vertex));
        Record::default().with("vertex", vertex.index().to_string()).with("at_m", at).end()
    }
}

/// The faces of a receiver, to draw upon.
fn faces(prepared: &Prepared, receiver: &Receiver) -> Vec<Polygon> {
    let flat = |&face: &_| prepared.polygon_m(face).iter().map(|&p| receiver.frame.flat(p)).collect();
    receiver.faces.iter().map(|face| Polygon { corners_m: flat(face), class: "face", grey: None }).collect()
}

/// A drawing of each receiver's faces, without lines.
pub(crate) fn drawings(prepared: &Prepared, receivers: &[Receiver]) -> Vec<Drawing> {
    let drawing = |(number, receiver): (usize, &Receiver)| Drawing {
        title: receiver.title(number),
        polygons: faces(prepared, receiver),
        lines: Vec::new(),
    };
    receivers.iter().enumerate().map(drawing).collect()
}

/// The d-segments drawn: a picture of each receiver that has any, coloured by degree, the stronger the wider.
pub fn svg(scene: &Scene, traced: &Traced) -> String {
    let Traced { prepared, discontinuities } = traced;
    let (receivers, of_face) = receivers(scene, prepared);
    let mut strongest = [0.0_f64; 3];
    for segment in &discontinuities.segments {
        let most = &mut strongest[segment.degree.number()];
        *most = most.max(segment.strength);
    }
    let mut drawings = drawings(prepared, &receivers);
    for degree in [Degree::D2, Degree::D1, Degree::D0] {
        for segment in discontinuities.segments.iter().filter(|segment| segment.degree == degree) {
            let number = of_face[segment.face];
            drawings[number].lines.push(Line {
                ends_m: segment.ends_m.map(|end| receivers[number].frame.flat(end)),
                class: CLASSES[degree.number()],
                width: width(segment.strength, strongest[degree.number()]),
            });
        }
    }
    drawings.retain(|drawing| !drawing.lines.is_empty());
    let jumps = ["value", "slope", "curvature"];
    let count = discontinuities.count_by_degree();
    let legend = (0..3)
        .map(|i| {
            let strongest = quantity(strongest[i]);
            let text = format!("D{i}, the {} jumps: {} d-segments, up to {strongest} {}", jumps[i], count[i], UNITS[i]);
            (CLASSES[i], WIDEST, text)
        })
        .collect();
    Sheet {
        title: format!("{}: d-segments", scene.name),
        legend,
        notes: vec![format!("lines are thinner the weaker they are, down to {DECADES} powers of ten")],
        drawings,
    }
    .svg()
}

fn width(strength: f64, strongest: f64) -> f64 {
    let decades = (strongest / strength.max(f64::MIN_POSITIVE)).log10().clamp(0.0, DECADES);
    WIDEST + (THINNEST - WIDEST) * decades / DECADES
}
