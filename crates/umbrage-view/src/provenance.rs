//! Where the light at a point is from, as far as the bake tells: the face and the patch there, and what cut it.

use glam::DVec3;
use umbrage::bake::Meshed;
use umbrage::discontinuity::Event;
use umbrage::id::{DSegmentId, EdgeId, EmitterId, FaceId, PatchId, VertexId};
use umbrage::mesh::Cut;
use umbrage::scene::Scene;

use crate::marks::level_of;

/// A point this far from a face still belongs to it, as a share of the scene's extent: what single precision leaves of
/// it.
const BESIDE: f64 = 1e-5;
/// Cosine of the angle by which a face and the triangle shown of it may differ.
const SAME_WAY: f64 = 0.999;

/// What strengths are measured in, by degree.
const UNITS: [&str; 3] = ["W/m²", "W/m³", "W/m⁴"];
/// The same in a photometric scene.
const PHOTOMETRIC_UNITS: [&str; 3] = ["lx", "lx/m", "lx/m²"];

/// The patch at a point, and its history.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Provenance {
    pub(crate) face: FaceId,
    /// The patch that carries transport there: one that is not split.
    pub(crate) patch: PatchId,
    /// How often the face was split to make it.
    pub(crate) level: usize,
    pub(crate) area_m2: f64,
    /// The last cut that made it, in words; nothing where it is the whole face.
    pub(crate) cut: Option<String>,
    /// The d-segment of that cut.
    pub(crate) hint: Option<DSegmentId>,
    /// What made that d-segment, in words.
    pub(crate) event: Option<String>,
}

/// The provenance of a point of the world on a surface that looks along `normal`.
pub(crate) fn provenance(scene: &Scene, meshed: &Meshed, point_m: DVec3, normal: DVec3) -> Option<Provenance> {
    let local_m = point_m - meshed.prepared.origin_m;
    let face = face_at(meshed, local_m, normal)?;
    let id = meshed.mesh.leaf_at(face, local_m);
    let patch = meshed.mesh.patch(id);
    let last = patch.parent.and_then(|parent| meshed.mesh.patch(parent).cut);
    let hint = match last {
        Some(Cut::EdgeHint(d_segment)) => Some(d_segment),
        _ => None,
    };
    Some(Provenance {
        face,
        patch: id,
        level: level_of(meshed, patch),
        area_m2: patch.area_m2,
        cut: last.map(|cut| cut_in_words(meshed, cut, if scene.photometric { PHOTOMETRIC_UNITS } else { UNITS })),
        hint,
        event: hint.map(|hint| Teller { scene, meshed }.event(meshed.discontinuities.segments[hint].event)),
    })
}

/// The face whose plane and outline the point is nearest to, if it is near at all.
fn face_at(meshed: &Meshed, point_m: DVec3, normal: DVec3) -> Option<FaceId> {
    let prepared = &meshed.prepared;
    let away_m = |face: FaceId| {
        let corners = prepared.polygon_m(face);
        let own = prepared.normal(face);
        let off_plane = corners.first().map_or(f64::INFINITY, |&corner| own.dot(point_m - corner).abs());
        let outside = (0..corners.len()).map(|i| {
            let (p, q) = (corners[i], corners[(i + 1) % corners.len()]);
            (q - p).cross(own).normalize_or_zero().dot(point_m - p)
        });
        outside.fold(off_plane, f64::max)
    };
    let alike = prepared.faces.keys().filter(|&face| prepared.normal(face).dot(normal) > SAME_WAY);
    let (away_m, face) = alike.map(|face| (away_m(face), face)).min_by(|x, y| x.0.total_cmp(&y.0))?;
    (away_m <= BESIDE * prepared.tolerance.extent_m).then_some(face)
}

fn cut_in_words(meshed: &Meshed, cut: Cut, units: [&str; 3]) -> String {
    match cut {
        Cut::EdgeHint(id) => {
            let segment = &meshed.discontinuities.segments[id];
            let degree = segment.degree.number();
            format!("edge_split along d-segment {}: D{degree}, {:.3} {}", id.index(), segment.strength, units[degree])
        }
        Cut::Points => "point_split, for its form factor or shape".into(),
        Cut::Triangle => "triangle_split, for its form factor".into(),
    }
}

/// Puts events into words.
struct Teller<'a> {
    scene: &'a Scene,
    meshed: &'a Meshed,
}

impl Teller<'_> {
    fn event(&self, event: Event) -> String {
        let name = event.name();
        match event {
            Event::Contact { edge } => format!("{name}: touches {}", self.edge(edge)),
            Event::SourcePlane { emitter } => format!("{name}: of {}", self.emitter(emitter)),
            Event::OccluderPlane { emitter, occluder } => {
                let face = self.meshed.prepared.faces.iter_enumerated().find(|(_, face)| face.plane == occluder);
                let occluder = face.map_or_else(String::new, |(id, _)| self.surface(id));
                format!("{name}: {} before {}", occluder, self.emitter(emitter))
            }
            Event::EdgeEdge { emitter, occluder, .. } => {
                format!("{name}: an edge of {} before an edge of {}", self.edge(occluder), self.emitter(emitter))
            }
            Event::ThreeEdges { emitter, occluders: [nearer, last], .. } => {
                let (nearer, last) = (self.edge(nearer), self.edge(last));
                format!("{name}: an edge of {last} before one of {nearer} before an edge of {}", self.emitter(emitter))
            }
            Event::VertexEdge { emitter, occluder, .. } => {
                format!("{name}: an edge of {} before a corner of {}", self.edge(occluder), self.emitter(emitter))
            }
            Event::EdgeVertex { emitter, occluder, .. } => {
                format!("{name}: a corner of {} before an edge of {}", self.vertex(occluder), self.emitter(emitter))
            }
            Event::LampCurve { lamp, .. } => format!("{name}: of {:?}", self.scene.lamps[lamp].name),
            Event::LampEdge { lamp, occluder } => {
                format!("{name}: an edge of {} before {:?}", self.edge(occluder), self.scene.lamps[lamp].name)
            }
        }
    }

    fn emitter(&self, emitter: EmitterId) -> String {
        let faces = &self.meshed.discontinuities.emitters[emitter].faces;
        faces.first().map_or_else(String::new, |&face| self.surface(face))
    }

    fn edge(&self, edge: EdgeId) -> String {
        let faces = &self.meshed.prepared.edges[edge].faces;
        faces.first().map_or_else(String::new, |&face| self.surface(face))
    }

    fn vertex(&self, vertex: VertexId) -> String {
        let prepared = &self.meshed.prepared;
        let face = prepared.faces.keys().find(|&face| prepared.boundary(face).any(|other| other == vertex));
        face.map_or_else(String::new, |face| self.surface(face))
    }

    /// The name of a face's node and material, as far as they have one.
    fn surface(&self, face: FaceId) -> String {
        let face = &self.meshed.prepared.faces[face];
        let node = self.scene.nodes[self.scene.surfaces[face.surface].node].name.as_deref().unwrap_or_default();
        let material = &self.scene.materials[face.material].name;
        match (node, material.as_str()) {
            ("", "") => "a surface without name".into(),
            ("", name) | (name, "") => name.into(),
            (node, material) => format!("{node} ({material})"),
        }
    }
}

#[cfg(test)]
mod tests {
    use umbrage::scene::cornell::cornell_box;

    use super::*;
    use crate::marks::tests::cornell;

    #[test]
    fn the_middle_of_every_patch_is_in_it() {
        let (scene, meshed) = (cornell_box(), cornell());
        for id in meshed.mesh.leaves() {
            let patch = meshed.mesh.patch(id);
            let (point, normal) = (meshed.prepared.origin_m + patch.centroid_m, meshed.prepared.normal(patch.face));
            let found = provenance(&scene, &meshed, point, normal).unwrap();
            assert_eq!((found.face, found.patch, found.area_m2), (patch.face, id, patch.area_m2));
            assert_eq!(found.cut.is_some(), patch.parent.is_some());
            assert_eq!(found.hint.is_some(), found.event.is_some());
        }
    }

    #[test]
    fn a_cut_along_a_shadow_tells_what_casts_it() {
        let (scene, meshed) = (cornell_box(), cornell());
        let told = meshed.mesh.leaves().filter_map(|id| {
            let patch = meshed.mesh.patch(id);
            let (point, normal) = (meshed.prepared.origin_m + patch.centroid_m, meshed.prepared.normal(patch.face));
            provenance(&scene, &meshed, point, normal)?.event
        });
        let told: Vec<String> = told.collect();
        // The blocks are white, and there is one light.
        let expected = "vertex-edge: an edge of cornell (white) before a corner of cornell (light)";
        assert!(told.iter().any(|event| event == expected), "{told:?}");
        assert!(told.iter().all(|event| event.contains("(white)") || event.starts_with("source-plane")), "{told:?}");
    }

    #[test]
    fn a_point_off_all_faces_has_no_provenance() {
        let (scene, meshed) = (cornell_box(), cornell());
        let middle = meshed.mesh.patch(PatchId::from(0)).centroid_m + meshed.prepared.origin_m;
        let normal = meshed.prepared.normal(FaceId::from(0));
        assert!(provenance(&scene, &meshed, middle + 0.1 * normal, normal).is_none());
        assert!(provenance(&scene, &meshed, middle, -normal).is_none_or(|found| found.face != FaceId::from(0)));
    }
}
