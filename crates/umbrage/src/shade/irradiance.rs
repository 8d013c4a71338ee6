//! Irradiance at a point: direct light exactly, the rest from the hierarchy.
//!
//! Indirect light is gathered from all faces, from each as exactly as it can matter there:
//! - of a strong one the part that the point sees is found exactly, and what that part reflects is summed down the face's
//!   patches ([`Reflected`]). So a shadow in indirect light is as sharp as it is, however coarse the links are;
//! - of a weak one the whole factor is exact, and one ray or a few tell how much of it is seen, of its
//!   subpatches where it reflects unevenly;
//! - where much stands before a strong one, its subpatches are looked at one by one, and are weak sooner or later.
//!
//! No light passes a wall either way. Links have no part in this: they are linear over their receivers, and at the borders
//! of these the sum over all faint sources would jump, which refinement would take for shadows.
//!
//! Before: a point lies inside its triangle, never on an edge or a contact: there the limit depends on the direction, and
//! the caller chooses it by where it puts the point.

use glam::DVec3;
use smallvec::smallvec;

use super::field::Field;
use super::reflected::{Part, Reflected};
use crate::id::{PatchId, Table};
use crate::mesh::{Mesh, Patch};
use crate::prepare::Prepared;
use crate::scene::Rgb;
use crate::transport::form_factor::point_to_polygon;
use crate::transport::{DirectLight, Linear};
use crate::visibility::{FEW_SHADOWS, ReceiverPoint, SourcePolygon, Visibility, VisiblePart};

/// A patch that could not bring more than this share of the mean irradiance is weak: what a few rays err about the part of
/// it that is seen is a fraction of that, and independent from patch to patch.
const WEAK_OF_MEAN: f64 = 2e-2;
/// And of a change of light, of which the greatest stands for all of a patch, and what is missed is gathered next time.
const WEAK_OF_CHANGE: f64 = 6e-2;
/// Below this share of what is weak one ray tells whether a patch is seen.
const ONE_RAY_OF_WEAK: f64 = 0.25;
/// Rays to a weak patch above that.
const RAYS: usize = 4;

/// Evaluates irradiance at points.
#[derive(Debug)]
pub struct Irradiance<'a> {
    visibility: &'a Visibility,
    mesh: &'a Mesh,
    reflected: Reflected<'a>,
    roots: Vec<PatchId>,
    sources: Table<PatchId, ReflectingPatch>,
    /// Mean irradiance of all faces, over the three colours, in W/m2.
    pub(super) mean: f64,
    weak_of_mean: f64,
}

/// A patch as a source.
#[derive(Debug)]
struct ReflectingPatch {
    polygon: SourcePolygon,
    middle_m: DVec3,
    radius_m: f64,
    /// The most that it reflects anywhere, in W/m2.
    greatest: f64,
}

impl<'a> Irradiance<'a> {
    /// Prepares the evaluation of what patches reflect, or of a change of it, in a scene whose mean irradiance is `mean`, in
    /// W/m2.
    pub fn new(
        prepared: &Prepared,
        visibility: &'a Visibility,
        mesh: &'a Mesh,
        reflected: &'a Table<PatchId, Linear<Rgb>>,
        mean: Rgb,
    ) -> Self {
        let roots: Vec<PatchId> = prepared.faces.keys().map(|face| mesh.root(face)).collect();
        let reflected = Reflected::new(mesh, reflected, mean.max_element());
        let reflecting = |(id, patch): (PatchId, &Patch)| {
            let polygon = SourcePolygon::on_face(prepared, patch.face, mesh.polygon_m(id));
            ReflectingPatch {
                middle_m: patch.centroid_m,
                radius_m: polygon.reach_m(patch.centroid_m),
                greatest: reflected.greatest(id),
                polygon,
            }
        };
        let sources = mesh.patches().map(reflecting).collect();
        Self { visibility, mesh, reflected, roots, sources, mean: mean.element_sum() / 3.0, weak_of_mean: WEAK_OF_MEAN }
    }

    /// The same, of a change of what patches reflect.
    pub(super) fn of_change(self) -> Self {
        Self { weak_of_mean: WEAK_OF_CHANGE, reflected: self.reflected.of_change(), ..self }
    }

    /// Irradiance by reflection, in W/m2, at a point; below zero where what is reflected is a change for less, or falls so
    /// steeply that its linear fit does.
    pub fn indirect(&self, receiver: &ReceiverPoint) -> Rgb {
        self.roots.iter().map(|&root| self.by_patch(receiver, root)).sum()
    }

    /// Irradiance by what a patch reflects.
    fn by_patch(&self, receiver: &ReceiverPoint, patch: PatchId) -> Rgb {
        let source = &self.sources[patch];
        let factor = source.factor(receiver);
        let most_of_mean = source.greatest * factor / self.mean;
        if most_of_mean <= 0.0 {
            return Rgb::ZERO;
        }
        let subpatches = self.mesh.patch(patch).subpatches;
        let by_subpatches = || subpatches.into_iter().flatten().map(|part| self.by_patch(receiver, part)).sum();
        if most_of_mean < self.weak_of_mean {
            if subpatches.is_some() && !self.reflected.is_linear(patch, factor) {
                return by_subpatches();
            }
            let rays = if most_of_mean < ONE_RAY_OF_WEAK * self.weak_of_mean { 1 } else { RAYS };
            return factor * self.seen_by_rays(receiver, patch, rays);
        }
        let most_shadows = if subpatches.is_some() { FEW_SHADOWS } else { usize::MAX };
        match self.visibility.visible_part_past(receiver, &source.polygon, most_shadows) {
            Some(part) => self.by_visible_part(receiver, patch, part),
            None => by_subpatches(),
        }
    }

    /// What a point sees a patch reflect, on average over all of it above the horizon, in W/m2.
    fn seen_by_rays(&self, receiver: &ReceiverPoint, patch: PatchId, rays: usize) -> Rgb {
        let ReflectingPatch { polygon, middle_m, .. } = &self.sources[patch];
        let (mut whole, mut seen) = (0.0, Rgb::ZERO);
        for ray in 0..rays {
            let at_m = if rays == 1 { *middle_m } else { polygon.inner_point_m(*middle_m, ray, rays) };
            let along = at_m - receiver.position_m;
            let cosines = receiver.normal.dot(along).max(0.0) * -polygon.oriented_plane.normal.dot(along);
            let exchange = cosines / along.length_squared().powi(2);
            whole += exchange;
            if exchange > 0.0 && !self.visibility.occluded(receiver.position_m, at_m, [receiver.plane, polygon.plane]) {
                seen += exchange * self.reflected.at(patch, at_m);
            }
        }
        if whole > 0.0 { seen / whole } else { Rgb::ZERO }
    }

    /// Irradiance by what the visible part of a patch reflects.
    fn by_visible_part(&self, receiver: &ReceiverPoint, patch: PatchId, part: VisiblePart) -> Rgb {
        let part: Part = match part {
            VisiblePart::Nothing => return Rgb::ZERO,
            VisiblePart::Whole(corners_m) => smallvec![corners_m],
            VisiblePart::Part(contours) => contours.iter().map(<[DVec3]>::to_vec).collect(),
        };
        self.reflected.by(receiver, patch, &part)
    }
}

impl ReflectingPatch {
    /// Factor of a point to the patch, if nothing stood between; 0 where the patch reflects nothing.
    fn factor(&self, receiver: &ReceiverPoint) -> f64 {
        let SourcePolygon { corners_m, oriented_plane, plane } = &self.polygon;
        let to_middle = self.middle_m - receiver.position_m;
        let faces = self.greatest > 0.0
            && receiver.plane != *plane
            && oriented_plane.signed_distance_m(receiver.position_m) > 0.0
            && receiver.normal.dot(to_middle) > -self.radius_m;
        if faces { point_to_polygon(receiver.position_m, receiver.normal, corners_m) } else { 0.0 }
    }
}

/// Direct light as a field.
#[derive(Clone, Copy, Debug)]
pub(super) struct Direct<'a>(pub(super) &'a DirectLight<'a>);

impl Field for Direct<'_> {
    fn at(&self, _: &Mesh, point: &ReceiverPoint, _: PatchId) -> Rgb {
        self.0.at(point)
    }
}

/// Indirect light as a field.
#[derive(Clone, Copy, Debug)]
pub(super) struct Indirect<'a>(pub(super) &'a Irradiance<'a>);

impl Field for Indirect<'_> {
    fn at(&self, _: &Mesh, point: &ReceiverPoint, _: PatchId) -> Rgb {
        self.0.indirect(point)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::id::FaceId;
    use crate::mesh::MeshSettings;
    use crate::progress::Progress;
    use crate::scene::Material;
    use crate::solve::{SolveSettings, Surfaces, solve};
    use crate::transport::{FormFactorOracle, link_all};
    use crate::visibility::fixture;
    use glam::DVec3;
    use std::f64::consts::PI;

    /// Irradiance, direct and indirect, at points of a face given by shares of its first and last side.
    fn at_points(
        polygons: &[(Vec<DVec3>, usize)],
        materials: Vec<Material>,
        face: usize,
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
            Irradiance::new(&prepared, &index, &mesh, &solution.reflected, solution.mean_irradiance(&mesh));
        let face = FaceId::from(face);
        let corners = prepared.polygon_m(face);
        let evaluate = |&[s, t]: &[f64; 2]| {
            let p = corners[0] + s * (corners[1] - corners[0]) + t * (corners[corners.len() - 1] - corners[0]);
            let receiver = ReceiverPoint::on_face(&prepared, face, p);
            [direct.at(&receiver), irradiance.indirect(&receiver)]
        };
        points.iter().map(evaluate).collect()
    }

    const POINTS: [[f64; 2]; 5] = [[0.5, 0.5], [0.013, 0.4], [0.1, 0.11], [0.999, 0.001], [0.31, 0.77]];

    #[test]
    fn a_furnace_is_evenly_lit_up_to_its_corners() {
        let glow = Material { reflectance: Rgb::splat(0.5), ..Material::emitting("glow", Rgb::ONE / PI) };
        let room: Vec<_> = fixture::inward_box(DVec3::ZERO, DVec3::ONE).into_iter().map(|wall| (wall, 0)).collect();
        for [direct, indirect] in at_points(&room, vec![glow], 0, &POINTS) {
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
        let [direct, indirect] = at_points(&scene, materials, 0, &[[0.5, 0.5]])[0];
        assert!((direct / (PI * 0.2394564705) - Rgb::new(1.0, 2.0, 0.0)).abs().max_element() < 1e-9);
        assert_eq!(indirect, Rgb::ZERO);
    }

    #[test]
    fn a_closed_room_beside_a_lit_one_is_exactly_dark() {
        let corner = |x: f64, z: f64| DVec3::new(x, 0.0, z);
        let lit = fixture::inward_box(corner(0.0, 0.0), DVec3::ONE);
        let dark = fixture::inward_box(corner(1.0, 0.0), DVec3::new(2.0, 1.0, 1.0));
        let mut room: Vec<_> = lit.into_iter().enumerate().map(|(i, wall)| (wall, usize::from(i == 1))).collect();
        room.extend(dark.into_iter().map(|wall| (wall, 0)));
        let materials = vec![Material::diffuse("white", Rgb::splat(0.9)), Material::emitting("lamp", Rgb::ONE)];
        for face in 6..12 {
            for light in at_points(&room, materials.clone(), face, &POINTS) {
                assert_eq!(light, [Rgb::ZERO; 2]);
            }
        }
    }
}
