//! Stage `mesh`: the triangles that are shown, and the light at their corners.

use glam::DVec3;
use umbrage::scene::Scene;
use umbrage::shade::{BakedMesh, BakedPart};

use crate::json::{self, Document, Record, Rounding, list, quantity};
use crate::receiver::DrawingFrame;
use crate::sheet::{Drawing, Polygon, Sheet};

/// Triangles whose normals differ by less are in one drawing, if their planes are also near: a sine.
const SAME_NORMAL: f64 = 1e-4;
/// The same for planes, as a share of the extent.
const SAME_PLANE: f64 = 1e-5;
/// The display's transfer function, nearly.
const GAMMA: f64 = 1.0 / 2.2;

fn point(p: [f32; 3]) -> DVec3 {
    DVec3::from(p.map(f64::from))
}

fn extent_m(mesh: &BakedMesh) -> f64 {
    let points = || mesh.parts.iter().flat_map(|part| part.positions_m.iter().map(|&p| point(p)));
    let (lo, hi) = (points().fold(DVec3::INFINITY, DVec3::min), points().fold(DVec3::NEG_INFINITY, DVec3::max));
    (hi - lo).max_element().max(0.0)
}

/// The baked mesh as JSON: the vertices and triangles of each part, numbered within the part.
pub fn json(scene: &Scene, mesh: &BakedMesh) -> String {
    let rounding = Rounding::of_extent(extent_m(mesh));
    let numbered = || mesh.parts.iter().enumerate();
    let vertices = numbered().flat_map(|(number, part)| {
        part.positions_m.iter().zip(&part.irradiance).enumerate().map(move |(id, (&position, irradiance))| {
            Record::default()
                .with("part", number.to_string())
                .with("id", id.to_string())
                .with("at_m", rounding.point(mesh.origin_m + point(position)))
                .with("irradiance", list(irradiance.map(|e| quantity(f64::from(e)))))
        })
    });
    let triangles = numbered().flat_map(|(number, part)| {
        part.triangles.iter().map(move |corners| {
            let corners = json::ids(corners.map(|corner| corner as usize));
            Record::default().with("part", number.to_string()).with("corners", corners)
        })
    });
    let parts = numbered().map(|(number, part)| {
        let surface = &scene.surfaces[part.surface];
        let node = scene.nodes[surface.node].name.as_deref().unwrap_or_default();
        Record::default()
            .with("id", number.to_string())
            .with("node", json::text(node))
            .with("material", json::text(&scene.materials[surface.material].name))
            .with("vertices", part.positions_m.len().to_string())
            .with("triangles", part.triangles.len().to_string())
    });
    Document::of_stage("mesh", &scene.name)
        .table("parts", parts)
        .table("vertices", vertices)
        .table("triangles", triangles)
        .end()
}

/// The triangles of one plane.
struct PlaneDrawing {
    normal: DVec3,
    offset_m: f64,
    frame: DrawingFrame,
    drawing: Drawing,
}

/// The baked mesh drawn: triangles, grey by their light.
pub fn svg(scene: &Scene, mesh: &BakedMesh) -> String {
    let slack_m = SAME_PLANE * extent_m(mesh);
    let mean = |part: &BakedPart, i: u32| part.irradiance[i as usize].iter().map(|&e| f64::from(e)).sum::<f64>() / 3.0;
    let all = || mesh.parts.iter().flat_map(|part| part.triangles.iter().map(move |corners| (part, corners)));
    let brightest = all().flat_map(|(part, corners)| corners.map(|i| mean(part, i))).fold(0.0, f64::max);
    let mut planes: Vec<PlaneDrawing> = Vec::new();
    for (part, corners) in all() {
        let points = corners.map(|i| point(part.positions_m[i as usize]));
        let normal = (points[1] - points[0]).cross(points[2] - points[0]).normalize_or_zero();
        let offset_m = normal.dot(points[0]);
        let same =
            |p: &PlaneDrawing| p.normal.distance(normal) < SAME_NORMAL && (p.offset_m - offset_m).abs() < slack_m;
        let number = planes.iter().position(same).unwrap_or_else(|| {
            let material = &scene.materials[scene.surfaces[part.surface].material].name;
            let title =
                format!("{material}, normal {}", normal.to_array().map(|x| format!("{:.2}", x + 0.0)).join(" "));
            let drawing = Drawing { title, ..Drawing::default() };
            planes.push(PlaneDrawing { normal, offset_m, frame: DrawingFrame::facing(normal), drawing });
            planes.len() - 1
        });
        let plane = &mut planes[number];
        let light = corners.map(|i| mean(part, i)).iter().sum::<f64>() / 3.0;
        plane.drawing.polygons.push(Polygon {
            corners_m: points.map(|p| plane.frame.flat(p)).to_vec(),
            class: "lit",
            grey: Some((light / brightest.max(f64::MIN_POSITIVE)).powf(GAMMA)),
        });
    }
    Sheet {
        title: format!("{}: mesh", scene.name),
        legend: Vec::new(),
        notes: vec![format!(
            "{} triangles; white is {} W/m2 of irradiance",
            mesh.triangle_count(),
            quantity(brightest)
        )],
        drawings: planes.into_iter().map(|plane| plane.drawing).collect(),
    }
    .svg()
}
