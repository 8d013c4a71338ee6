//! Direct light: irradiance straight from the emitters, exactly.
//!
//! At a point, `E = M F` for each emitting face, with its exitance `M` and Lambert's factor `F` of its exact visible part; and
//! what each lamp brings that an exact ray sees.
//! Over a patch, a linear fit to such points; its mean is right where an emitter is small and near, too ([`super::near_emitters`]).
//! Direct light carries the shadows; so it never goes over links, whose factors
//! are linear over patches that may be large. Links carry what is reflected.

use glam::{DVec2, DVec3};
use rayon::prelude::*;
use smallvec::SmallVec;

use crate::geometry::polygon;
use crate::id::{FaceId, LampId, PatchId, Table};
use crate::mesh::Mesh;
use crate::prepare::Prepared;
use crate::scene::{Lamp, Rgb, Scene};
use crate::visibility::{FlatSource, ReceiverPoint, SourcePolygon, Visibility};

use super::bright_places::{self, BrightPlace, LightSent};
use super::emitting_parts::{EmittingPart, emitting_parts};
use super::fit::Linear;
use super::form_factor::factor_of_seen;
use super::lamps::Lamps;
use super::near_emitters::{EmitterExtent, ReceivingPatch};
use super::obstacles::{MOST_EMITTERS, Obstacles};
use super::sample;
use super::seen::{KnownHere, SourceMemory, SourcesSeen};

/// A convex part of emitting faces, named by one of them.
#[derive(Clone, Debug)]
struct Emitter {
    face: FaceId,
    polygon: FlatSource,
    outline: SourcePolygon,
    extent: EmitterExtent,
    /// Emitted exitance, in W/m2.
    exitance: Rgb,
}

/// Evaluates direct light.
#[derive(Debug)]
pub struct DirectLight<'a> {
    prepared: &'a Prepared,
    visibility: &'a Visibility,
    emitters: Vec<Emitter>,
    lamps: Lamps,
    memory: SourceMemory<'a>,
}

impl<'a> DirectLight<'a> {
    /// The light of a scene's emitting faces.
    pub fn new(scene: &Scene, prepared: &'a Prepared, visibility: &'a Visibility) -> Self {
        let emitters = emitting_parts(scene, prepared)
            .into_iter()
            .map(|EmittingPart { face, corners_m }| {
                let outline = SourcePolygon::on_face(prepared, face, corners_m);
                Emitter {
                    face,
                    polygon: FlatSource::new(&outline, prepared.face_frame(face)),
                    extent: EmitterExtent::new(&outline.corners_m),
                    outline,
                    exitance: scene.materials[prepared.faces[face].material].exitance(),
                }
            })
            .collect();
        let lamps = Lamps::new(scene, prepared, visibility);
        Self { prepared, visibility, emitters, lamps, memory: SourceMemory::None }
    }

    /// The same, which looks into `memory` for what points see of the sources, or notes it there.
    pub fn with_memory(self, memory: SourceMemory<'a>) -> Self {
        Self { memory, ..self }
    }

    /// Irradiance at a point, in W/m2.
    pub fn at(&self, receiver: &ReceiverPoint) -> Rgb {
        self.at_past(receiver, None)
    }

    /// What may stand between a patch and each emitter; where those of a patch around it are given, it is found among them. Nothing is
    /// looked for where emitters are too many, or what points see of them is known, or on a smooth surface, which may see what is behind
    /// the plane of the patch.
    pub fn obstacles(&self, mesh: &Mesh, patch: PatchId, around: Option<&Obstacles>) -> Obstacles {
        let is_smooth = self.prepared.is_smooth(mesh.patch(patch).face);
        if is_smooth || self.emitters.len() > MOST_EMITTERS || matches!(self.memory, SourceMemory::Known(_)) {
            return Obstacles::default();
        }
        let receiver = SourcePolygon::on_face(self.prepared, mesh.patch(patch).face, mesh.polygon_m(patch));
        let before = |(number, emitter): (usize, &Emitter)| match around.and_then(|around| around.before(number)) {
            Some([]) => Vec::new(),
            among => self.visibility.faces_around(&receiver, &emitter.outline, among),
        };
        Obstacles::new(self.emitters.iter().enumerate().map(before))
    }

    /// Irradiance at a point, in W/m2, of a patch whose obstacles may be given.
    pub fn at_past(&self, receiver: &ReceiverPoint, obstacles: Option<&Obstacles>) -> Rgb {
        let known = self.memory.at(receiver);
        let mut seen = SourcesSeen::default();
        let from = |(number, emitter): (usize, &Emitter)| {
            let past = || {
                let among = obstacles.and_then(|obstacles| obstacles.before(number));
                factor_of_seen(self.visibility, receiver, &emitter.polygon, among)
            };
            let factor = known.and_then(|known| known.factor(emitter.face)).unwrap_or_else(past);
            if factor != 0.0 {
                seen.emitters.push((emitter.face, factor));
            }
            emitter.exitance * factor
        };
        let of_emitters = self.emitters.iter().enumerate().map(from).sum::<Rgb>();
        let light = of_emitters + self.of_lamps(receiver, known, &mut seen.lamps);
        self.memory.note(receiver, || seen);
        light
    }

    /// Irradiance that lamps bring to a point, in W/m2; those that are seen are added to `seen`.
    fn of_lamps(&self, receiver: &ReceiverPoint, known: Option<KnownHere<'_>>, seen: &mut Vec<LampId>) -> Rgb {
        self.lamps.at(self.visibility, receiver, |lamp| known.and_then(|known| known.sees(lamp)), seen)
    }

    /// Irradiance of a patch, in W/m2.
    pub fn over(&self, mesh: &Mesh, patch: PatchId) -> Linear<Rgb> {
        let samples = self.samples(mesh, patch, |receiver| self.at(receiver));
        Linear::fit(samples.iter().copied())
            + self.missed_of_lamps(mesh, patch)
            + self.missed_of_near_emitters(mesh, patch)
    }

    /// The light of emitters that are small and near, less what the sample points of a patch tell of it, in W/m2.
    fn missed_of_near_emitters(&self, mesh: &Mesh, patch: PatchId) -> Linear<Rgb> {
        let receiving = ReceivingPatch::new(self.prepared, self.visibility, mesh, patch);
        let near = self.emitters.iter().filter(|emitter| receiving.is_small_and_near(&emitter.extent));
        let missed = |emitter: &Emitter| {
            let at = |receiver: &ReceiverPoint| {
                emitter.exitance * factor_of_seen(self.visibility, receiver, &emitter.polygon, None)
            };
            let mean =
                emitter.exitance * receiving.factor_by_reciprocity(&emitter.outline, emitter.face, &emitter.extent);
            self.missed_by_samples(mesh, patch, mean, at)
        };
        near.map(missed).fold(Linear::default(), |sum, missed| sum + missed)
    }

    /// The light of lamps near a patch, whose flux into it is known, less what its sample points tell of it, in W/m2.
    fn missed_of_lamps(&self, mesh: &Mesh, patch: PatchId) -> Linear<Rgb> {
        if self.lamps.is_empty() {
            return Linear::default();
        }
        let face = mesh.patch(patch).face;
        let polygon = SourcePolygon::on_face(self.prepared, face, mesh.polygon_m(patch));
        let polygon = FlatSource::new(&polygon, *mesh.frame(face));
        let missed = |lamp: LampId| {
            let mean = self.lamps.flux_w(lamp, self.visibility, &polygon) / mesh.patch(patch).area_m2;
            self.missed_by_samples(mesh, patch, mean, |receiver| self.of_lamp(lamp, receiver))
        };
        let near = self.lamps.uneven_over(&polygon, mesh.patch(patch).centroid_m);
        near.map(missed).fold(Linear::default(), |sum, missed| sum + missed)
    }

    /// The light of a source whose mean over a patch is known, less what the sample points tell of it, in W/m2. Of how it varies they
    /// tell as little as of its mean: their slope is kept in proportion, as far as nothing gets below zero.
    fn missed_by_samples(
        &self,
        mesh: &Mesh,
        patch: PatchId,
        mean: Rgb,
        at: impl Fn(&ReceiverPoint) -> Rgb,
    ) -> Linear<Rgb> {
        let sampled = self.fit(mesh, patch, at);
        let share = mean.element_sum() / sampled.mean.element_sum();
        let in_proportion = |slope: Rgb| if share.is_finite() { share * slope } else { Rgb::ZERO };
        let mut exact = Linear { mean, gradient: sampled.gradient.map(in_proportion) };
        let frame = mesh.frame(mesh.patch(patch).face);
        let middle = frame.to_2d(mesh.patch(patch).centroid_m);
        let at_corner = |p: &DVec3| exact.at(frame.to_2d(*p) - middle).element_sum();
        let lowest = mesh.polygon_m(patch).iter().map(at_corner).fold(f64::INFINITY, f64::min);
        if lowest < 0.0 {
            let kept = mean.element_sum() / (mean.element_sum() - lowest);
            exact.gradient = exact.gradient.map(|slope| slope * kept);
        }
        exact - sampled
    }

    /// Mean irradiance of a patch, and the mean of how far that of its sample points, or of the bright places in it, departs from the
    /// best linear fit, in W/m2.
    pub(super) fn mean_and_departure(&self, mesh: &Mesh, patch: PatchId, places: &[&BrightPlace]) -> [Rgb; 2] {
        let samples = self.samples(mesh, patch, |receiver| self.at(receiver));
        let fit = Linear::fit(samples.iter().copied()) + self.missed_of_lamps(mesh, patch);
        let frame = mesh.frame(mesh.patch(patch).face);
        let centre = frame.to_2d(mesh.patch(patch).centroid_m);
        let at_place = |place: &&BrightPlace| {
            let shown = fit.at(frame.to_2d(place.point_m) - centre);
            place.area_m2 * (place.irradiance - shown).max(Rgb::ZERO)
        };
        let at_places = places.iter().map(at_place).sum::<Rgb>() / mesh.patch(patch).area_m2;
        let departure = |&(offset_m, weight, value): &(DVec2, f64, Rgb)| weight * (value - fit.at(offset_m)).abs();
        [fit.mean, samples.iter().map(departure).sum::<Rgb>().max(at_places)]
    }

    /// The best linear fit to a function of the points of a patch.
    fn fit(&self, mesh: &Mesh, patch: PatchId, at: impl Fn(&ReceiverPoint) -> Rgb) -> Linear<Rgb> {
        Linear::fit(self.samples(mesh, patch, at).into_iter())
    }

    /// A function of the points of a patch at its sample points: offsets from the centroid, in metres, weights and values.
    fn samples(&self, mesh: &Mesh, patch: PatchId, at: impl Fn(&ReceiverPoint) -> Rgb) -> Vec<(DVec2, f64, Rgb)> {
        let face = mesh.patch(patch).face;
        let frame = mesh.frame(face);
        let centre = frame.to_2d(mesh.patch(patch).centroid_m);
        let sample = |(point_m, weight)| {
            let receiver = ReceiverPoint::on_face(self.prepared, face, point_m);
            (frame.to_2d(point_m) - centre, weight, at(&receiver))
        };
        sample::points(&mesh.polygon_m(patch)).into_iter().map(sample).collect()
    }

    /// Follows light from all sources to where it falls first.
    pub fn light_sent(&self) -> LightSent {
        let mut sent = bright_places::of_lamps(&self.lamps, self.prepared, self.visibility);
        let emitters: Vec<_> =
            self.emitters.iter().map(|emitter| (&emitter.outline, &emitter.polygon, emitter.exitance)).collect();
        sent.places.extend(bright_places::of_emitters(&emitters, self.prepared, self.visibility));
        sent
    }

    /// Irradiance that one lamp brings to a point, in W/m2.
    pub fn of_lamp(&self, lamp: LampId, receiver: &ReceiverPoint) -> Rgb {
        let known = self.memory.at(receiver).and_then(|known| known.sees(lamp));
        self.lamps.of_one(lamp, self.visibility, receiver, known).unwrap_or_default()
    }

    /// The lamps whose light one point does not tell over a small polygon around it that lies within a radius, in metres.
    pub(crate) fn untold_by_point(&self, face: FaceId, point_m: DVec3, radius_m: f64) -> SmallVec<[LampId; 4]> {
        self.lamps.untold_by_point(&self.prepared.oriented_plane(face), point_m, radius_m)
    }

    /// Mean irradiance that some lamps bring to a convex polygon of a face, in W/m2; its corners are asked for where there are any.
    pub(crate) fn mean_of_lamps(&self, lamps: &[LampId], face: FaceId, corners_m: impl Fn() -> Vec<DVec3>) -> Rgb {
        if lamps.is_empty() {
            return Rgb::ZERO;
        }
        let corners_m = corners_m();
        let area_m2 = polygon::area_m2(&corners_m);
        let polygon = SourcePolygon::on_face(self.prepared, face, corners_m);
        let polygon = FlatSource::new(&polygon, self.prepared.face_frame(face));
        let mean_of = |&lamp: &LampId| self.lamps.flux_w(lamp, self.visibility, &polygon) / area_m2;
        if area_m2 > 0.0 { lamps.iter().map(mean_of).sum() } else { Rgb::ZERO }
    }

    /// The lamps.
    pub(crate) fn lamps(&self) -> impl Iterator<Item = (LampId, &Lamp)> {
        self.lamps.iter()
    }

    /// What a lamp brings to a point if nothing stands between, in W/m2, and where a ray to it ends, in metres; `None` where it brings
    /// nothing.
    pub(crate) fn unoccluded_lamp(&self, lamp: LampId, receiver: &ReceiverPoint) -> Option<(Rgb, DVec3)> {
        self.lamps.unoccluded_and_end(lamp, receiver)
    }

    /// Irradiance of those patches that are leaves, in W/m2; zero for those that are split.
    pub fn over_leaves_of(&self, mesh: &Mesh, patches: &[PatchId]) -> Vec<Linear<Rgb>> {
        fit_leaves(mesh, patches, |leaf| self.over(mesh, leaf))
    }

    /// The part of it that lamps without extent bring.
    pub fn of_lamps_over_leaves(&self, mesh: &Mesh) -> Table<PatchId, Linear<Rgb>> {
        let at = |receiver: &ReceiverPoint| self.of_lamps(receiver, self.memory.at(receiver), &mut Vec::new());
        let patches: Vec<PatchId> = mesh.patches().map(|(patch, _)| patch).collect();
        let over = |leaf| match self.lamps.is_empty() {
            true => Linear::default(),
            false => self.fit(mesh, leaf, at) + self.missed_of_lamps(mesh, leaf),
        };
        fit_leaves(mesh, &patches, over).into()
    }
}

/// A function of leaves, in parallel; zero for patches that are split.
fn fit_leaves(mesh: &Mesh, patches: &[PatchId], of: impl Fn(PatchId) -> Linear<Rgb> + Sync) -> Vec<Linear<Rgb>> {
    let of = |&patch: &PatchId| if mesh.patch(patch).subpatches.is_some() { Linear::default() } else { of(patch) };
    patches.par_iter().map(of).collect()
}
