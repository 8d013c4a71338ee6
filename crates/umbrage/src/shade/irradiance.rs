//! Irradiance at a point: direct light exactly, the rest from the hierarchy.
//!
//! Indirect light is gathered from all faces, from each as exactly as it can matter there:
//! - of a strong one the part that the point sees is found exactly, and what that part reflects is summed down the face's
//!   patches ([`Reflected`]). So a shadow in indirect light is as sharp as it is, however coarse the links are;
//! - of a weak one the whole factor is exact, and one ray or a few tell how much of it is seen, of its subpatches where it
//!   reflects unevenly;
//! - faces far away that are faint together are a crowd ([`super::crowd`]);
//! - where much stands before a strong one, its subpatches are looked at one by one, past what stands before it, and are
//!   weak sooner or later.
//!
//! No light passes a wall either way. Links have no part in this: they are linear over their receivers, and at the borders
//! of these the sum over all faint sources would jump, which refinement would take for shadows.
//!
//! Before: a point lies inside its triangle, never on an edge or a contact: there the limit depends on the direction, and
//! the caller chooses it by where it puts the point.

use glam::DVec2;
use serde::{Deserialize, Serialize};

use super::crowd::{Crowd, CrowdTerm};
use super::field::Field;
use super::gathering::Gathering;
use super::reflected::{FlatPatch, Reflected, Term};
use crate::id::{ClusterId, FaceId, PatchId, Table};
use crate::mesh::{Mesh, Patch};
use crate::prepare::Prepared;
use crate::scene::Rgb;
use crate::transport::{BrightPlace, Linear};
use crate::visibility::{FlatSource, Memory, ReceiverPoint, Visibility};

/// A patch that could not bring more than this share of the mean irradiance is weak: what a few rays err about the part of
/// it that is seen is a fraction of that, and independent from patch to patch.
const WEAK_OF_MEAN: f64 = 2e-2;

/// What was found at a point is looked for again where a patch that it sees is split since, and light on that departs by more than so
/// many trifles from what the patch stood for: those of many patches cancel.
const STALE_TRIFLES: f64 = 20.0;

/// Evaluates irradiance at points.
#[derive(Debug)]
pub struct Irradiance<'a> {
    prepared: &'a Prepared,
    pub(super) visibility: &'a Visibility,
    pub(super) mesh: &'a Mesh,
    pub(super) reflected: Reflected<'a>,
    /// What the faces of each cluster send.
    pub(super) crowds: Table<ClusterId, Crowd>,
    /// The most that they could send if all of them reflected as their brightest points do, in W.
    pub(super) most: Table<ClusterId, f64>,
    pub(super) sources: Table<PatchId, ReflectingPatch>,
    /// Mean irradiance of all faces, over the three colours, in W/m2.
    pub(super) mean: f64,
    /// Where a patch is weak, by what it could bring, in W/m2.
    pub(super) weak: f64,
    memory: Memory<'a, Terms>,
}

/// A patch as a source.
#[derive(Debug)]
pub(super) struct ReflectingPatch {
    pub(super) source: FlatSource,
    pub(super) middle_m: DVec2,
    pub(super) radius_m: f64,
    pub(super) area_m2: f64,
    /// The most that it reflects anywhere, in W/m2.
    pub(super) greatest: f64,
}

impl<'a> Irradiance<'a> {
    /// Prepares the evaluation of what patches reflect, or of a change of it, in a scene whose mean irradiance is `mean`, in
    /// W/m2.
    pub fn new(
        prepared: &'a Prepared,
        visibility: &'a Visibility,
        mesh: &'a Mesh,
        reflected: &'a Table<PatchId, Linear<Rgb>>,
        mean: Rgb,
    ) -> Self {
        let crowds = crowds(prepared, visibility, mesh, reflected);
        let reflected = Reflected::new(mesh, reflected, mean.max_element());
        let reflecting = |(id, patch): (PatchId, &Patch)| {
            let FlatPatch { corners_m, centroid_m, .. } = reflected.flat(id);
            let plane = prepared.faces[patch.face].plane;
            ReflectingPatch {
                middle_m: *centroid_m,
                radius_m: corners_m.iter().map(|corner_m| corner_m.distance(*centroid_m)).fold(0.0, f64::max),
                area_m2: patch.area_m2,
                greatest: reflected.greatest(id),
                source: FlatSource { frame: *mesh.frame(patch.face), corners_m: corners_m.clone(), plane },
            }
        };
        let sources: Table<PatchId, ReflectingPatch> = mesh.patches().map(reflecting).collect();
        let most = visibility.over_clusters(0.0, |face| {
            let root = &sources[mesh.root(face)];
            root.greatest.max(0.0) * root.area_m2
        });
        let (mean, memory) = (mean.element_sum() / 3.0, Memory::None);
        let weak = WEAK_OF_MEAN * mean;
        Self { prepared, visibility, mesh, reflected, crowds, most, sources, mean, weak, memory }
    }

    /// The same, for light that may err so many times what it may at the default tolerance: what is weak or a trifle may be so much
    /// brighter.
    pub fn coarser(self, times: f64) -> Self {
        Self { weak: times * self.weak, reflected: self.reflected.coarser(times), ..self }
    }

    /// The same, which looks into `memory` for what points see of the patches, or notes it there.
    pub fn with_memory(self, memory: Memory<'a, Terms>) -> Self {
        Self { memory, ..self }
    }

    /// The mesh whose patches reflect.
    pub(super) fn mesh(&self) -> &'a Mesh {
        self.mesh
    }

    /// The faces that are there.
    pub(super) fn prepared(&self) -> &'a Prepared {
        self.prepared
    }

    /// Irradiance by reflection, in W/m2, at a point; below zero where what is reflected falls so steeply that its linear fit
    /// does.
    pub fn indirect(&self, receiver: &ReceiverPoint) -> Rgb {
        if !matches!(self.memory, Memory::None) {
            return self.of_terms(receiver, |terms| self.sum_of(terms));
        }
        let mut sum = Rgb::ZERO;
        let crowds = Gathering::new(self, receiver, |term| sum += self.reflected.of(&term)).gather();
        sum + crowds.iter().map(|term| term.of(&self.crowds)).sum::<Rgb>()
    }

    /// The terms of which irradiance by reflection at a point is the sum, for other light that patches reflect about as much of.
    pub(super) fn terms(&self, receiver: &ReceiverPoint) -> Terms {
        self.of_terms(receiver, Terms::clone)
    }

    fn of_terms<T>(&self, receiver: &ReceiverPoint, of: impl Fn(&Terms) -> T) -> T {
        match self.memory {
            Memory::None => of(&self.find_terms(receiver)),
            _ => self.memory.read(receiver, || self.find_terms(receiver), of),
        }
    }

    /// Irradiance by reflection where these are the terms, in W/m2.
    pub(super) fn sum_of(&self, terms: &Terms) -> Rgb {
        terms.sum(self.reflected.radiosity(), &self.crowds)
    }

    /// Terms that were found before patches were split, with those of faces anew that are not as good now: where what is split is
    /// neither linear nor little of what is seen.
    pub(super) fn renewed(&self, receiver: &ReceiverPoint, terms: &Terms) -> Terms {
        let face = |term: &Term| self.mesh.patch(term.patch).face;
        let is_stale = |of_patch: &&[Term]| {
            let factor: f64 = of_patch.iter().map(|term| f64::from(term.factor)).sum();
            self.reflected.departs(of_patch[0].patch, factor, STALE_TRIFLES)
        };
        let of_patches = terms.of_patches.chunk_by(|term, next| term.patch == next.patch);
        let mut stale: Vec<FaceId> = of_patches.filter(is_stale).map(|of_patch| face(&of_patch[0])).collect();
        stale.sort_unstable();
        stale.dedup();
        if stale.is_empty() {
            return terms.clone();
        }
        let as_good = |term: &&Term| stale.binary_search(&face(term)).is_err();
        let mut of_patches: Vec<Term> = terms.of_patches.iter().filter(as_good).copied().collect();
        let mut gathering = Gathering::new(self, receiver, |term| of_patches.push(term));
        stale.iter().for_each(|&face| gathering.gather_from(face));
        Terms { of_patches: of_patches.into_boxed_slice(), of_crowds: terms.of_crowds.clone() }
    }

    /// About how much irradiance varies over a distance around a point where these are its terms, in W/m2: what comes from as near
    /// as that may change wholly.
    pub(super) fn variation(&self, point: &ReceiverPoint, terms: &Terms, distance_m: f64) -> f64 {
        let of = |term: &Term| {
            let ReflectingPatch { source, middle_m, radius_m, .. } = &self.sources[term.patch];
            let seen_m = source.frame.to_3d(*middle_m + term.offset_m());
            // No point of the patch is nearer.
            let to_plane_m = source.frame.plane.signed_distance_m(point.position_m);
            let apart_m = to_plane_m.max(seen_m.distance(point.position_m) - 2.0 * radius_m);
            let light = self.reflected.of(term).max_element().max(0.0);
            if apart_m <= distance_m { light } else { light * distance_m / apart_m }
        };
        terms.of_patches.iter().map(of).sum()
    }

    /// The share of its view in which a point sees patches that are nearer than so many of their radii, or of `radius_m`.
    pub(super) fn share_of_near(&self, point: &ReceiverPoint, terms: &Terms, radii: f64, radius_m: f64) -> f64 {
        let is_near = |term: &&Term| {
            let ReflectingPatch { source, middle_m, radius_m: of_patch_m, .. } = &self.sources[term.patch];
            let at_m = source.frame.to_3d(*middle_m + term.offset_m());
            at_m.distance(point.position_m) <= radii * radius_m.max(*of_patch_m)
        };
        terms.of_patches.iter().filter(is_near).map(|term| f64::from(term.factor)).sum()
    }

    fn find_terms(&self, receiver: &ReceiverPoint) -> Terms {
        let mut of_patches = Vec::new();
        let of_crowds = Gathering::new(self, receiver, |term| of_patches.push(term)).gather();
        Terms { of_patches: of_patches.into_boxed_slice(), of_crowds: of_crowds.into_boxed_slice() }
    }

    /// What crowds send where patches reflect `radiosity`, in W/m2.
    pub(super) fn crowds_of(&self, radiosity: &Table<PatchId, Linear<Rgb>>) -> Table<ClusterId, Crowd> {
        crowds(self.prepared, self.visibility, self.mesh, radiosity)
    }
}

/// The terms of what a point receives.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Terms {
    of_patches: Box<[Term]>,
    of_crowds: Box<[CrowdTerm]>,
}

impl Terms {
    /// Whether all that is named is among so many patches and clusters, in a scene of this extent: where terms come from a file, it must be
    /// checked.
    pub fn fits(&self, (patches, clusters): (usize, usize), extent_m: f64) -> bool {
        self.of_patches.iter().all(|term| term.fits(patches, extent_m))
            && self.of_crowds.iter().all(|term| term.fits(clusters))
    }

    /// Those of patches.
    pub(super) fn patches(&self) -> &[Term] {
        &self.of_patches
    }

    /// Their sum where patches reflect `radiosity` and crowds send what they do then, in W/m2.
    pub(super) fn sum(&self, radiosity: &Table<PatchId, Linear<Rgb>>, crowds: &Table<ClusterId, Crowd>) -> Rgb {
        self.of_patches.iter().map(|term| term.of(radiosity)).sum::<Rgb>()
            + self.of_crowds.iter().map(|term| term.of(crowds)).sum::<Rgb>()
    }
}

/// What the faces of each cluster send where patches reflect `radiosity`, in W/m2.
fn crowds(
    prepared: &Prepared,
    visibility: &Visibility,
    mesh: &Mesh,
    radiosity: &Table<PatchId, Linear<Rgb>>,
) -> Table<ClusterId, Crowd> {
    visibility.over_clusters(Crowd::default(), |face| {
        let root = mesh.root(face);
        Crowd::of_face(prepared.normal(face), mesh.patch(root).area_m2 * radiosity[root].mean)
    })
}

/// Indirect light as a field, and the places that are known to be bright.
#[derive(Clone, Copy, Debug)]
pub(super) struct Indirect<'a> {
    pub(super) light: &'a Irradiance<'a>,
    pub(super) bright: &'a [BrightPlace],
}

impl Field for Indirect<'_> {
    fn at(&self, _: &Mesh, point: &ReceiverPoint, _: PatchId) -> Rgb {
        self.light.indirect(point)
    }

    fn bright_places(&self) -> &[BrightPlace] {
        self.bright
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::MeshSettings;
    use crate::progress::Progress;
    use crate::scene::Material;
    use crate::solve::{SolveSettings, Surfaces, solve};
    use crate::transport::form_factor::factor_in_view;
    use crate::transport::{DirectLight, FormFactorOracle, link_all};
    use crate::visibility::fixture;
    use glam::{DVec3, Vec3Swizzles};
    use std::f64::consts::PI;

    /// Irradiance, direct and indirect, at points of faces given by shares of their first and last side.
    fn at_points(
        polygons: &[(Vec<DVec3>, usize)],
        materials: Vec<Material>,
        faces: &[usize],
        points: &[[f64; 2]],
    ) -> Vec<[Rgb; 2]> {
        let (prepared, scene) = (fixture::prepared_of_materials(polygons), fixture::scene(materials));
        let index = Visibility::new(&prepared);
        let mut mesh = Mesh::new(&prepared, &Table::new(), MeshSettings::default());
        let coplanar_m = prepared.tolerance.coplanar_m();
        let oracle = FormFactorOracle { max_form_factor: 0.02, min_area_m2: 0.002, coplanar_m };
        let links = link_all(&prepared, &index, &mut mesh, &oracle, Progress::silent()).unwrap();
        let direct = DirectLight::new(&scene, &prepared, &index);
        let surfaces = Surfaces::new(&scene, &prepared, &mesh, &direct);
        let settings = SolveSettings { max_residual: 1e-7, max_iterations: 99 };
        let solution = solve(&mesh, &surfaces, &links, settings, Progress::silent()).unwrap();
        let irradiance =
            Irradiance::new(&prepared, &index, &mesh, &solution.reflected, solution.mean_irradiance(&mesh, |_| true));
        let evaluate = |(&face, &[s, t]): (&usize, &[f64; 2])| {
            let face = FaceId::from(face);
            let corners = prepared.polygon_m(face);
            let p = corners[0] + s * (corners[1] - corners[0]) + t * (corners[corners.len() - 1] - corners[0]);
            let receiver = ReceiverPoint::on_face(&prepared, face, p);
            [direct.at(&receiver), irradiance.indirect(&receiver)]
        };
        faces.iter().flat_map(|face| points.iter().map(move |point| (face, point))).map(evaluate).collect()
    }

    const POINTS: [[f64; 2]; 5] = [[0.5, 0.5], [0.013, 0.4], [0.1, 0.11], [0.999, 0.001], [0.31, 0.77]];

    #[test]
    fn a_furnace_is_evenly_lit_up_to_its_corners() {
        let glow = Material { reflectance: Rgb::splat(0.5), ..Material::emitting("glow", Rgb::ONE / PI) };
        let room: Vec<_> = fixture::inward_box(DVec3::ZERO, DVec3::ONE).into_iter().map(|wall| (wall, 0)).collect();
        for [direct, indirect] in at_points(&room, vec![glow], &[0], &POINTS) {
            assert!((direct - 1.0).abs().max_element() < 1e-9, "direct {direct}");
            assert!((indirect - 1.0).abs().max_element() < 2e-2, "indirect {indirect}");
        }
    }

    #[test]
    fn direct_light_is_lamberts() {
        let square = |z: f64, up: bool| {
            let mut corners =
                [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)].map(|(x, y)| DVec3::new(x, y, z)).to_vec();
            if !up {
                corners.reverse();
            }
            corners
        };
        let materials =
            vec![Material::diffuse("grey", Rgb::splat(0.5)), Material::emitting("lamp", Rgb::new(1.0, 2.0, 0.0))];
        let scene = [(square(0.0, true), 0), (square(1.0, false), 1)];
        let [direct, indirect] = at_points(&scene, materials, &[0], &[[0.5, 0.5]])[0];
        assert!((direct / (PI * 0.2394564705) - Rgb::new(1.0, 2.0, 0.0)).abs().max_element() < 1e-9);
        assert_eq!(indirect, Rgb::ZERO);
    }

    /// The second of two rooms, of which the ceiling of the first glows, must be dark at points of all of its walls.
    fn is_exactly_dark([lit, dark]: [[DVec3; 2]; 2], others: Vec<Vec<DVec3>>, points: &[[f64; 2]]) {
        let walls = [lit, dark].into_iter().flat_map(|[low, high]| fixture::inward_box(low, high));
        let room: Vec<_> = walls.chain(others).enumerate().map(|(i, wall)| (wall, usize::from(i == 1))).collect();
        let materials = vec![Material::diffuse("white", Rgb::splat(0.9)), Material::emitting("lamp", Rgb::ONE)];
        for light in at_points(&room, materials, &[6, 7, 8, 9, 10, 11], points) {
            assert_eq!(light, [Rgb::ZERO; 2]);
        }
    }

    #[test]
    fn a_closed_room_beside_a_lit_one_is_exactly_dark() {
        let rooms = [[DVec3::ZERO, DVec3::ONE], [DVec3::X, DVec3::new(2.0, 1.0, 1.0)]];
        is_exactly_dark(rooms, Vec::new(), &POINTS);
    }

    #[test]
    fn a_closed_box_inside_a_lit_room_is_exactly_dark() {
        // The room's walls lie on both sides of the planes of the box, and so do small plates, lying and upright.
        let dark = [DVec3::new(1.9, 0.3, 0.2), DVec3::new(2.6, 0.9, 1.1)];
        let plate = |i: u32| {
            let middle = 0.1 + 2.8 * (f64::from(i) * DVec3::new(0.618034, 0.754878, 0.569840)).fract();
            let upright = |corner: DVec3| fixture::f32_point(middle + (corner - middle).zyx());
            let lying = fixture::square(middle, 0.04, i.is_multiple_of(2));
            let is_outside = (middle.cmplt(dark[0] - 0.1) | middle.cmpgt(dark[1] + 0.1)).any();
            is_outside.then(|| if i.is_multiple_of(3) { lying } else { lying.into_iter().map(upright).collect() })
        };
        let grid: Vec<[f64; 2]> = (0..25).map(|i| [i % 5, i / 5].map(|k| (f64::from(k) + 0.5) / 5.0)).collect();
        is_exactly_dark([[DVec3::ZERO, DVec3::splat(3.0)], dark], (0..200).filter_map(plate).collect(), &grid);
    }

    #[test]
    fn a_crowd_far_away_brings_what_its_faces_do() {
        // Cubes on arcs around the origin, one behind the other nowhere, over a floor that looks up at them.
        let mut polygons = vec![fixture::square(DVec3::ZERO, 1.0, true)];
        for i in 0..90 {
            let (sine, cosine) = (f64::from(i) * 2.0 * PI / 90.0).sin_cos();
            let low = 30.0 * DVec3::new(cosine, sine, 0.3 + 0.1 * f64::from(i % 3));
            polygons.extend(fixture::outward_box(low, low + 0.5));
        }
        let prepared = fixture::prepared(&polygons);
        let visibility = Visibility::new(&prepared);
        let mesh = Mesh::new(&prepared, &Table::new(), MeshSettings::default());
        // Faces that look east are brighter.
        let bright = |face: FaceId| 1.0 + prepared.normal(face).x.max(0.0);
        let reflected: Table<PatchId, Linear<Rgb>> = mesh
            .patches()
            .map(|(_, patch)| Linear { mean: Rgb::splat(bright(patch.face)), ..Linear::default() })
            .collect();
        let light = Irradiance::new(&prepared, &visibility, &mesh, &reflected, Rgb::ONE);
        let receiver = ReceiverPoint::on_face(&prepared, FaceId::from(0), DVec3::new(0.1, 0.2, 0.0));
        let one_by_one: f64 = prepared
            .faces
            .keys()
            .filter_map(|face| {
                let source = FlatSource::of_face(&prepared, face);
                let view = visibility.view(&receiver, &source)?;
                Some(bright(face) * factor_in_view(&view, &source.corners_m))
            })
            .sum();
        let crowds = light.terms(&receiver).of_crowds.len();
        let whole = light.indirect(&receiver).x;
        assert!(crowds > 0 && crowds < 90, "{crowds} crowds");
        assert!((whole / one_by_one - 1.0).abs() < 0.03, "{whole} is not {one_by_one}");
        let by_terms = light.terms(&receiver).sum(&reflected, &light.crowds_of(&reflected)).x;
        assert!((by_terms / whole - 1.0).abs() < 1e-6, "{by_terms} is not {whole}");
    }
}
