//! The account of each lamp: what it sends, and what the surfaces that are shown get of it.
//!
//! What it sends is followed by rays from the lamp ([`crate::transport::LightSent`]); what surfaces get is summed over the triangles
//! that are shown. The two share nothing, so a circle of light that no triangle shows is told here. Vertices show all light together,
//! and a little more or less than there is ([`super::element`]); a lamp has the same share of it as of the light.
//! Light by the normals of a curved surface is more or less than falls on its facets; the account is of the facets.

use rayon::prelude::*;

use super::element::Element;
use super::field::{Places, Values};
use crate::id::{FaceId, LampId, PatchId, Table};
use crate::mesh::Mesh;
use crate::prepare::Prepared;
use crate::scene::{Rgb, Scene};
use crate::transport::{DirectLight, LampFate, LightSent};
use crate::visibility::ReceiverPoint;

/// By how much a lamp's account may be off, as a share: besides what few rays do not tell.
const MOST_OFF: f64 = 0.05;
/// What `n` rays tell errs by about `n` to this power, as a share: less than by chance, since they are even.
const RAYS_POWER: f64 = -0.75;
/// A lamp of whose light less than this share falls on anything lights nothing.
const NOTHING: f64 = 1e-6;
/// Vertices of which one task sums up what they get.
const VERTICES_A_TASK: usize = 1024;

/// What becomes of the light of one lamp, before it is reflected, in W.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct LampAccount {
    /// Its name.
    pub name: String,
    /// What it sends; of a distant lamp, what meets the scene.
    pub sent_w: Rgb,
    /// What falls on the fronts of surfaces, by rays.
    pub expected_w: Rgb,
    /// The same, as surfaces show it.
    pub received_w: Rgb,
    /// What falls on the backs of surfaces, which show nothing.
    pub on_backs_w: Rgb,
    /// What leaves the scene.
    pub escaped_w: Rgb,
    /// What a range takes.
    pub faded_w: Rgb,
    /// Rays that `expected_w` is known from.
    pub rays: usize,
}

/// What is wrong with the light of a lamp.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum LampDefect {
    /// It gives light, but none falls on the front of a surface.
    LightsNothing,
    /// Surfaces show more of its light than falls on them, by this share, or less.
    OffBy(f64),
}

impl LampAccount {
    /// How much more surfaces show of it than falls on them, as a share of that; below 0 light is lost.
    pub fn error(&self) -> f64 {
        let (expected_w, received_w) = (self.expected_w.element_sum(), self.received_w.element_sum());
        if expected_w > 0.0 { received_w / expected_w - 1.0 } else { 0.0 }
    }

    /// What is wrong with it, if anything is.
    pub fn defect(&self) -> Option<LampDefect> {
        let (sent_w, expected_w) = (self.sent_w.element_sum(), self.expected_w.element_sum());
        if self.rays == 0 && self.received_w.element_sum() <= NOTHING * sent_w {
            return Some(LampDefect::LightsNothing);
        }
        let most = MOST_OFF + (self.rays.max(1) as f64).powf(RAYS_POWER);
        (expected_w > 0.0 && self.error().abs() > most).then(|| LampDefect::OffBy(self.error()))
    }
}

/// What is shown: the mesh, its elements by patch, the true values, and the shifts of those that are shown.
pub(super) struct Shown<'a> {
    pub(super) prepared: &'a Prepared,
    pub(super) mesh: &'a Mesh,
    pub(super) places: &'a Places<'a>,
    pub(super) elements: &'a [Vec<Element>],
    pub(super) values: &'a Values,
    pub(super) shifts: &'a [Rgb],
}

/// A vertex, and the area times the share of its light that it stands for, in square metres.
type Weighted = (ReceiverPoint, f64);

/// A vertex by its number; of a smooth face, its corner on that face.
type Corner = (u32, Option<FaceId>);

impl Shown<'_> {
    /// The vertices of leaves. A smooth face shows light by its curved normal, and rays meet its facets: the light of a facet is told
    /// at its corners as if it were flat.
    fn vertices(&self, leaves: &[PatchId]) -> Vec<Weighted> {
        let mut corners: Vec<(Corner, f64)> = Vec::new();
        let mut points: Vec<Option<ReceiverPoint>> = vec![None; self.values.as_slice().len()];
        for &leaf in leaves {
            let face = self.mesh.patch(leaf).face;
            let smooth = self.prepared.is_smooth(face).then_some(face);
            for element in self.elements.get(leaf.index()).into_iter().flatten() {
                corners.extend(element.corners().map(|corner| ((corner, smooth), element.area_m2 / 3.0)));
            }
            for at in self.mesh.boundary(leaf) {
                let vertex = self.places.vertex(self.mesh, leaf, at.vertex);
                if let Some(number) = self.values.number(&vertex.key) {
                    points[number as usize].get_or_insert(vertex.point);
                }
            }
        }
        let shown_of_true = |number: usize| {
            let (value, shift) = (self.values.as_slice()[number], self.shifts.get(number).copied().unwrap_or_default());
            if value.element_sum() > 0.0 { 1.0 + shift.element_sum() / value.element_sum() } else { 1.0 }
        };
        // Stable: areas are added up in the order of the leaves.
        corners.par_sort_by_key(|&(corner, _)| corner);
        let weighted = |of_one: &[(Corner, f64)]| {
            let (number, smooth) = of_one.first()?.0;
            let weight: f64 = of_one.iter().map(|(_, area_m2)| area_m2).sum();
            let point = points[number as usize]?;
            let flat = |face| ReceiverPoint {
                beside_jump: point.beside_jump,
                ..ReceiverPoint::on_flat_face(self.prepared, face, point.position_m)
            };
            Some((smooth.map_or(point, flat), weight * shown_of_true(number as usize)))
        };
        corners.chunk_by(|(p, _), (q, _)| p == q).filter_map(weighted).collect()
    }
}

/// Takes the account of every lamp. `is_shown` tells whether the light of a face is shown; of other faces it is taken to be right.
pub(super) fn lamp_accounts(
    scene: &Scene,
    direct: &DirectLight<'_>,
    sent: &LightSent,
    shown: &Shown<'_>,
    is_shown: impl Fn(FaceId) -> bool,
) -> Vec<LampAccount> {
    let leaves: Vec<PatchId> = shown.mesh.leaves().filter(|&leaf| is_shown(shown.mesh.patch(leaf).face)).collect();
    let vertices = if sent.lamps.is_empty() { Vec::new() } else { shown.vertices(&leaves) };
    let of_part = |part: &[Weighted]| -> Table<LampId, Rgb> {
        let of_lamp = |lamp: LampId| part.iter().map(|(point, weight)| *weight * direct.of_lamp(lamp, point)).sum();
        sent.lamps.keys().map(of_lamp).collect()
    };
    let parts: Vec<Table<LampId, Rgb>> = vertices.par_chunks(VERTICES_A_TASK).map(of_part).collect();
    let mut received_w: Table<LampId, Rgb> = vec![Rgb::ZERO; sent.lamps.len()].into();
    let mut rays: Table<LampId, usize> = vec![0; sent.lamps.len()].into();
    for part in &parts {
        received_w.iter_mut().zip(part).for_each(|(all, part)| *all += *part);
    }
    for place in &sent.places {
        if let Some(lamp) = place.lamp {
            rays[lamp] += 1;
            if !is_shown(place.face) {
                received_w[lamp] += place.area_m2 * place.irradiance;
            }
        }
    }
    let account = |(id, fate): (LampId, &LampFate)| LampAccount {
        name: scene.lamps[id].name.clone(),
        sent_w: fate.sent_w,
        expected_w: fate.on_fronts_w,
        received_w: received_w[id],
        on_backs_w: fate.on_backs_w,
        escaped_w: fate.leaving_w,
        faded_w: fate.fading_w,
        rays: rays[id],
    };
    sent.lamps.iter_enumerated().filter(|(id, _)| scene.lamps[*id].emits()).map(account).collect()
}
