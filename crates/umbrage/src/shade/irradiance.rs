//! Irradiance at a point: direct light exactly, the rest from the hierarchy.
//!
//! Direct: `E = pi L F` for each emitting face, with Lambert's factor `F` of its exact visible part. Indirect: the links of
//! the point's leaf and of all its ancestors, each evaluated at the point itself rather than averaged over the patch:
//! their sources reflect `B - M`, and `E` sums `(B - M) F`. Where a link found its ends in clear sight of one another, the
//! factor is the unoccluded one; else the exact visible part counts. A point may be nearer to a source than its patch is
//! on the whole; so a source that is split gives way to its parts where that changes the sum by more than a trifle. A link
//! that brings next to nothing is taken to be linear over its receiver, which it is to first order.
//!
//! Before: a point lies inside its triangle, never on an edge or a contact: there the limit depends on the direction, and
//! the caller chooses it by where it puts the point.

use super::field::Field;
use crate::id::{FaceId, PatchId, Table};
use crate::mesh::Mesh;
use crate::prepare::Prepared;
use crate::scene::{Rgb, Scene};
use crate::solve::Solution;
use crate::transport::form_factor::{point_to_polygon, point_to_visible_part};
use crate::transport::{Link, Links, Sight};
use crate::visibility::{ReceiverPoint, SourcePolygon, Visibility};

/// A link that brings less than this share of the mean irradiance is weak: what its linear form errs is a part of that.
const WEAK_OF_MEAN: f64 = 5e-3;

/// A source gives way to its parts where that may change irradiance by more than this share of its mean: a point gathers
/// over some hundred links, whose errors partly cancel.
const TRIFLE_OF_MEAN: f64 = 1e-3;

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
    /// Mean irradiance of all faces, in W/m2.
    mean: f64,
    /// What each patch sends on of what it receives, `B - M`, in W/m2.
    reflected: Table<PatchId, Rgb>,
    /// Polygons of the patches that reflect.
    polygons: Table<PatchId, Option<SourcePolygon>>,
    /// A source gives way to its parts where that may change the sum by more, in W/m2.
    trifle: f64,
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
        let polygon = |id: PatchId| SourcePolygon::on_face(prepared, mesh.patch(id).face, mesh.polygon_m(id));
        let polygons =
            reflected.iter_enumerated().map(|(id, &light)| (light != Rgb::ZERO).then(|| polygon(id))).collect();
        let roots = || prepared.faces.keys().map(|face| mesh.root(face));
        let area_m2: f64 = roots().map(|root| mesh.patch(root).area_m2).sum();
        let power: Rgb = roots().map(|root| solution.irradiance[root] * mesh.patch(root).area_m2).sum();
        let mean = power.element_sum() / 3.0 / area_m2;
        let trifle = TRIFLE_OF_MEAN * power.max_element() / area_m2;
        Self { visibility, mesh, links, emitters, mean, trifle, reflected, polygons }
    }

    /// Mean irradiance of all faces, over the three colours, in W/m2.
    pub fn mean(&self) -> f64 {
        self.mean
    }

    /// Irradiance straight from the emitters, in W/m2.
    pub fn direct(&self, receiver: &ReceiverPoint) -> Rgb {
        self.emitters.iter().map(|emitter| emitter.exitance * self.visible_factor(receiver, &emitter.polygon)).sum()
    }

    /// Irradiance by reflection, in W/m2, at a point of `face`.
    pub fn indirect(&self, receiver: &ReceiverPoint, face: FaceId) -> Rgb {
        let mut sum = Rgb::ZERO;
        let mut node = Some(self.mesh.leaf_at(face, receiver.position_m));
        while let Some(patch) = node {
            for link in self.links.of(patch) {
                sum += self.over_link(receiver, link);
            }
            node = self.mesh.patch(patch).parent;
        }
        sum
    }

    /// Irradiance over a link at a point of its receiver.
    fn over_link(&self, receiver: &ReceiverPoint, link: &Link) -> Rgb {
        let light = self.reflected[link.source];
        if light.max_element() * link.form_factor < WEAK_OF_MEAN * self.mean {
            let patch = self.mesh.patch(link.receiver);
            let frame = self.mesh.frame(patch.face);
            let away = frame.to_2d(receiver.position_m) - frame.to_2d(patch.centroid_m);
            return (link.form_factor + link.gradient.as_dvec2().dot(away)).max(0.0) * light;
        }
        self.reflected_by(receiver, link.source, link.sight)
    }

    /// Irradiance by what a patch reflects, taken by parts where it varies enough.
    fn reflected_by(&self, receiver: &ReceiverPoint, source: PatchId, sight: Sight) -> Rgb {
        let Some(polygon) = &self.polygons[source] else { return Rgb::ZERO };
        let unhindered = point_to_polygon(receiver.position_m, receiver.normal, &polygon.corners_m);
        if unhindered == 0.0 {
            return Rgb::ZERO;
        }
        let light = self.reflected[source];
        if let Some(parts) = self.mesh.patch(source).subpatches {
            let change =
                parts.iter().map(|&part| (self.reflected[part] - light).abs().max_element()).fold(0.0, f64::max);
            if unhindered * change > self.trifle {
                return parts.iter().map(|&part| self.reflected_by(receiver, part, sight)).sum();
            }
        }
        match sight {
            Sight::Clear => unhindered * light,
            Sight::Partial => self.visible_factor(receiver, polygon) * light,
        }
    }

    fn visible_factor(&self, receiver: &ReceiverPoint, source: &SourcePolygon) -> f64 {
        let part = self.visibility.visible_part(receiver, source);
        point_to_visible_part(receiver.position_m, receiver.normal, &part)
    }
}

/// Direct light as a field.
#[derive(Clone, Copy, Debug)]
pub(super) struct Direct<'a>(pub(super) &'a Irradiance<'a>);

impl Field for Direct<'_> {
    fn at(&self, _: &Mesh, point: &ReceiverPoint, _: PatchId) -> Rgb {
        self.0.direct(point)
    }
}

/// Indirect light as a field.
#[derive(Clone, Copy, Debug)]
pub(super) struct Indirect<'a>(pub(super) &'a Irradiance<'a>);

impl Field for Indirect<'_> {
    fn at(&self, mesh: &Mesh, point: &ReceiverPoint, patch: PatchId) -> Rgb {
        self.0.indirect(point, mesh.patch(patch).face)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
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
        let surfaces = Surfaces::new(&scene, &prepared, &mesh);
        let settings = SolveSettings { max_residual: 1e-7, max_iterations: 99 };
        let solution = solve(&mesh, &surfaces, &links, settings, Progress::silent()).unwrap();
        let irradiance = Irradiance::new(&scene, &prepared, &index, &mesh, &links, &solution);
        let face = FaceId::from(face);
        let corners = prepared.polygon_m(face);
        let evaluate = |&[s, t]: &[f64; 2]| {
            let p = corners[0] + s * (corners[1] - corners[0]) + t * (corners[corners.len() - 1] - corners[0]);
            let receiver = ReceiverPoint::on_face(&prepared, face, p);
            [irradiance.direct(&receiver), irradiance.indirect(&receiver, face)]
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
