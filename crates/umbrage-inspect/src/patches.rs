//! Stage `patches`: the hierarchy that carries transport, and what made each cut.

use umbrage::bake::Meshed;
use umbrage::id::PatchId;
use umbrage::mesh::{Cut, Patch};
use umbrage::scene::Scene;

use crate::d_segments::{CLASSES, drawings};
use crate::json::{self, Document, Record, Rounding, ids, quantity};
use crate::receiver::{face_records, receivers};
use crate::sheet::{Line, Sheet};

/// Width of the first cut of a face, in pixels; later ones are thinner.
const FIRST_CUT: f64 = 3.0;
const LATER: f64 = 0.82;
const THINNEST: f64 = 0.4;

/// The patches as JSON, split ones included.
pub fn json(scene: &Scene, meshed: &Meshed) -> String {
    let Meshed { prepared, mesh, .. } = meshed;
    let rounding = Rounding::of_extent(prepared.tolerance.extent_m);
    let (receivers, of_face) = receivers(scene, prepared);
    let record = |(id, patch): (PatchId, &Patch)| {
        let corners_m = mesh.polygon_m(id).into_iter().map(|corner| prepared.origin_m + corner);
        let parent = patch.parent.map_or_else(|| "null".into(), |parent| parent.index().to_string());
        let record = Record::default()
            .with("id", id.index().to_string())
            .with("face", patch.face.index().to_string())
            .with("parent", parent)
            .with("area_m2", quantity(patch.area_m2))
            .with("corners_m", rounding.points(corners_m));
        let Some(cut) = patch.cut else {
            return record.with("open_hints", ids(patch.edge_hints().iter().map(|hint| hint.d_segment.index())));
        };
        let subpatches = patch.subpatches.into_iter().flatten().map(PatchId::index);
        let record = record.with("cut", json::text(name(cut))).with("subpatches", ids(subpatches));
        match cut {
            Cut::EdgeHint(d_segment) => record.with("d_segment", d_segment.index().to_string()),
            Cut::Points | Cut::Triangle => record,
        }
    };
    Document::of_stage("patches", &scene.name)
        .table("receivers", receivers.iter().enumerate().map(|(number, receiver)| receiver.record(number)))
        .table("faces", face_records(prepared, &of_face, rounding))
        .table("patches", mesh.patches().map(record))
        .end()
}

fn name(cut: Cut) -> &'static str {
    match cut {
        Cut::EdgeHint(_) => "edge-hint",
        Cut::Points => "points",
        Cut::Triangle => "triangle",
    }
}

/// The patches drawn: every cut in the colour of what made it, early ones wider.
pub fn svg(scene: &Scene, meshed: &Meshed) -> String {
    let Meshed { prepared, discontinuities, mesh } = meshed;
    let (receivers, of_face) = receivers(scene, prepared);
    let mut drawings = drawings(prepared, &receivers);
    let mut counts = [0; 5];
    // Subpatches come after their patch: widths are known when they are asked for.
    let mut widths = vec![FIRST_CUT; mesh.patch_count()];
    for (id, patch) in mesh.patches() {
        let (Some(cut), Some(subpatches)) = (patch.cut, patch.subpatches) else { continue };
        let kind = match cut {
            Cut::EdgeHint(d_segment) => discontinuities.segments[d_segment].degree.number(),
            Cut::Points => 3,
            Cut::Triangle => 4,
        };
        counts[kind] += 1;
        subpatches.iter().for_each(|part| widths[part.index()] = (LATER * widths[id.index()]).max(THINNEST));
        let number = of_face[patch.face];
        // The cut is the last side of both parts.
        let corners = mesh.polygon_m(subpatches[0]);
        let (Some(&from), Some(&to)) = (corners.last(), corners.first()) else { continue };
        drawings[number].lines.push(Line {
            ends_m: [from, to].map(|p| receivers[number].frame.flat(p)),
            class: class(kind),
            width: widths[id.index()],
        });
    }
    // The first cuts are drawn last, over the others.
    drawings.iter_mut().for_each(|drawing| drawing.lines.reverse());
    let made_by = ["a D0 hint", "a D1 hint", "a D2 hint", "point_split", "triangle_split"];
    let legend = (0..5).map(|kind| (class(kind), 2.0, format!("{} cuts by {}", counts[kind], made_by[kind])));
    let leaves = mesh.leaves().count();
    Sheet {
        title: format!("{}: patches", scene.name),
        legend: legend.collect(),
        notes: vec![format!("{} patches, {leaves} of them not split; early cuts are wider", mesh.patch_count())],
        drawings,
    }
    .svg()
}

fn class(kind: usize) -> &'static str {
    [CLASSES[0], CLASSES[1], CLASSES[2], "points", "triangle"][kind]
}
