//! Irradiance at a point: direct light exactly, the rest from the hierarchy.
//!
//! Direct: `E = pi L F` for each emitting face, with Lambert's factor `F` of its exact visible part. Indirect: the links of
//! the point's leaf and of all its ancestors, each evaluated at the point itself rather than averaged over the patch:
//! their sources reflect `B - M`, and `E` sums `(B - M) F`. Where a link found its ends in clear sight of one another, the
//! factor is the unoccluded one; else the exact visible part counts.
//!
//! Before: a point lies inside its triangle, never on an edge or a contact: there the limit depends on the direction, and
//! the caller chooses it by where it puts the point.

use crate::id::{FaceId, PatchId, Table};
use crate::mesh::Mesh;
use crate::prepare::Prepared;
use crate::scene::{Rgb, Scene};
use crate::solve::Solution;
use crate::transport::form_factor::{point_to_polygon, point_to_visible_part};
use crate::transport::{Links, Sight};
use crate::visibility::{ReceiverPoint, SourcePolygon, Visibility};

/// An emitting face.
#[derive(Clone, Debug)]
struct Emitter {
    polygon: SourcePolygon,
    /// Emitted exitance, in W/m2.
    exitance: Rgb,
}

/// Evaluates irradiance at points.
#[derive(Debug)]
pub struct Irradiance<'a> {
    visibility: &'a Visibility,
    mesh: &'a Mesh,
    links: &'a Links,
    emitters: Vec<Emitter>,
    /// What each patch sends on of what it receives, `B - M`, in W/m2.
    reflected: Table<PatchId, Rgb>,
    /// Polygons of the patches that links gather from.
    polygons: Table<PatchId, Option<SourcePolygon>>,
}

impl<'a> Irradiance<'a> {
    /// Prepares the evaluation of a solved scene.
    pub fn new(
        scene: &Scene,
        prepared: &Prepared,
        visibility: &'a Visibility,
        mesh: &'a Mesh,
        links: &'a Links,
        solution: &Solution,
    ) -> Self {
        let material = |face: FaceId| &scene.materials[prepared.faces[face].material];
        let emitting = prepared.faces.keys().filter(|&face| material(face).emits());
        let emitters = emitting
            .map(|face| Emitter {
                polygon: SourcePolygon::of_face(prepared, face),
                exitance: material(face).exitance(),
            })
            .collect();
        let reflected: Table<PatchId, Rgb> = solution
            .radiosity
            .iter_enumerated()
            .map(|(id, &radiosity)| (radiosity - material(mesh.patch(id).face).exitance()).max(Rgb::ZERO))
            .collect();
        let mut polygons: Table<PatchId, Option<SourcePolygon>> = Table::from(vec![None; reflected.len()]);
        for link in links.as_slice() {
            if reflected[link.source] != Rgb::ZERO {
                polygons[link.source].get_or_insert_with(|| {
                    SourcePolygon::on_face(prepared, mesh.patch(link.source).face, mesh.polygon_m(link.source))
                });
            }
        }
        Self { visibility, mesh, links, emitters, reflected, polygons }
    }

    /// Irradiance at a point that `patches` share, in W/m2: indirect light is the mean of what they gather there.
    pub fn at(&self, receiver: &ReceiverPoint, patches: &[PatchId]) -> Rgb {
        let mut gathering: Vec<PatchId> = patches.iter().map(|&patch| self.solved_ancestor(patch)).collect();
        gathering.sort_unstable();
        gathering.dedup();
        let indirect: Rgb = gathering.iter().map(|&patch| self.indirect(receiver, patch)).sum();
        self.direct(receiver) + indirect / gathering.len().max(1) as f64
    }

    /// The patch itself, or the part that it was split from after the solution.
    fn solved_ancestor(&self, mut patch: PatchId) -> PatchId {
        while patch.index() >= self.reflected.len() {
            let Some(parent) = self.mesh.patch(patch).parent else { break };
            patch = parent;
        }
        patch
    }

    /// Irradiance straight from the emitters, in W/m2.
    pub fn direct(&self, receiver: &ReceiverPoint) -> Rgb {
        self.emitters.iter().map(|emitter| emitter.exitance * self.visible_factor(receiver, &emitter.polygon)).sum()
    }

    /// Irradiance by reflection, in W/m2, at a point of the unsplit patch `leaf`.
    pub fn indirect(&self, receiver: &ReceiverPoint, leaf: PatchId) -> Rgb {
        let mut sum = Rgb::ZERO;
        let mut node = Some(leaf);
        while let Some(patch) = node {
            for link in self.links.of(patch) {
                if let Some(source) = &self.polygons[link.source] {
                    let factor = match link.sight {
                        Sight::Clear => point_to_polygon(receiver.position_m, receiver.normal, &source.corners_m),
                        Sight::Partial => self.visible_factor(receiver, source),
                    };
                    sum += factor * self.reflected[link.source];
                }
            }
            node = self.mesh.patch(patch).parent;
        }
        sum
    }

    fn visible_factor(&self, receiver: &ReceiverPoint, source: &SourcePolygon) -> f64 {
        let part = self.visibility.visible_part(receiver, source);
        point_to_visible_part(receiver.position_m, receiver.normal, &part)
    }
}
