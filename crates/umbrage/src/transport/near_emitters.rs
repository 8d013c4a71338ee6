//! Mean irradiance of a patch from an emitter that is small and near, which the sample points of the patch cannot resolve.
//!
//! A lamp of 2 cm, 2 cm off a wall, lights a spot of a few centimetres. Of a patch of 30 cm a few points see the spot or miss it, and
//! their mean is off by several times. Seen from the lamp, the patch is large and its form factor is smooth. So the factor is averaged
//! over points of the emitter instead, each with the exact visible part of the patch, and turned around by reciprocity:
//! `F(patch, emitter) = F(emitter, patch) A_emitter / A_patch`. From each point of the emitter the factors of all patches sum to the
//! share of its hemisphere that the scene fills, so no light is lost or made, wherever borders of patches lie.
//!
//! Holds: for emitters that are large, or far for the size of the patch, nothing is done.

use glam::DVec3;

use crate::geometry::polygon;
use crate::id::{FaceId, PatchId};
use crate::mesh::Mesh;
use crate::prepare::Prepared;
use crate::visibility::{FlatSource, ReceiverPoint, SourcePolygon, Visibility};

use super::form_factor::factor_of_seen;
use super::sample;

/// An emitter nearer to the middle of a patch than so many of its radii is near. Two radii over the middle, the six-point rule errs by
/// about 1 % of the mean.
const NEAR_RADII: f64 = 3.0;

/// The size of an emitter.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct EmitterExtent {
    middle_m: DVec3,
    /// Distance of its farthest corner from the middle, in metres.
    radius_m: f64,
    area_m2: f64,
}

impl EmitterExtent {
    pub(super) fn new(corners_m: &[DVec3]) -> Self {
        let middle_m = corners_m.iter().sum::<DVec3>() / corners_m.len().max(1) as f64;
        Self { middle_m, radius_m: radius_m(corners_m, middle_m), area_m2: polygon::area_m2(corners_m) }
    }
}

/// A patch that receives light.
pub(super) struct ReceivingPatch<'a> {
    prepared: &'a Prepared,
    visibility: &'a Visibility,
    face: FaceId,
    corners_m: Vec<DVec3>,
    middle_m: DVec3,
    radius_m: f64,
    area_m2: f64,
}

impl<'a> ReceivingPatch<'a> {
    pub(super) fn new(prepared: &'a Prepared, visibility: &'a Visibility, mesh: &Mesh, patch: PatchId) -> Self {
        let (corners_m, patch) = (mesh.polygon_m(patch), mesh.patch(patch));
        let (middle_m, area_m2) = (patch.centroid_m, patch.area_m2);
        let radius_m = radius_m(&corners_m, middle_m);
        Self { prepared, visibility, face: patch.face, corners_m, middle_m, radius_m, area_m2 }
    }

    /// Whether an emitter is too small and too near for sample points of the patch.
    pub(super) fn is_small_and_near(&self, emitter: &EmitterExtent) -> bool {
        emitter.radius_m <= self.radius_m
            && emitter.area_m2 <= self.area_m2
            && emitter.middle_m.distance(self.middle_m) < NEAR_RADII * self.radius_m + emitter.radius_m
    }

    /// The mean form factor of the patch to an emitter in the plane of `face`, by points of the emitter.
    pub(super) fn factor_by_reciprocity(&self, emitter: &SourcePolygon, face: FaceId, extent: &EmitterExtent) -> f64 {
        let polygon = SourcePolygon::on_face(self.prepared, self.face, self.corners_m.clone());
        let patch = FlatSource::new(&polygon, self.prepared.face_frame(self.face));
        let at = |(point_m, weight)| {
            let receiver = ReceiverPoint::on_face(self.prepared, face, point_m);
            weight * factor_of_seen(self.visibility, &receiver, &patch, None)
        };
        let factor: f64 = sample::points(&emitter.corners_m).into_iter().map(at).sum();
        if self.area_m2 > 0.0 { factor * extent.area_m2 / self.area_m2 } else { 0.0 }
    }
}

/// Distance of the farthest corner from a middle, in metres.
fn radius_m(corners_m: &[DVec3], middle_m: DVec3) -> f64 {
    corners_m.iter().map(|corner_m| corner_m.distance(middle_m)).fold(0.0, f64::max)
}

#[cfg(test)]
mod tests {
    use std::f64::consts::PI;

    use proptest::prelude::*;

    use super::*;
    use crate::id::Table;
    use crate::mesh::MeshSettings;
    use crate::scene::{Material, Rgb};
    use crate::transport::DirectLight;
    use crate::visibility::fixture;

    /// The flux that the unsplit walls of a box of 6 x 5 x 3 m receive from a square lamp of 1 W/m2, over the flux that it emits.
    fn received_share(middle_m: DVec3, side_m: f64, up: bool) -> f64 {
        let walls = fixture::inward_box(DVec3::ZERO, DVec3::new(6.0, 5.0, 3.0));
        let mut polygons: Vec<_> = walls.into_iter().map(|wall| (wall, 0)).collect();
        polygons.push((fixture::square(middle_m, 0.5 * side_m, up), 1));
        let prepared = fixture::prepared_of_materials(&polygons);
        let lamp = Material::emitting("lamp", Rgb::ONE / PI);
        let scene = fixture::scene(vec![Material::diffuse("black", Rgb::ZERO), lamp]);
        let visibility = Visibility::new(&prepared);
        let mesh = Mesh::new(&prepared, &Table::new(), MeshSettings::default());
        let direct = DirectLight::new(&scene, &prepared, &visibility);
        let received: f64 = mesh.leaves().map(|leaf| mesh.patch(leaf).area_m2 * direct.over(&mesh, leaf).mean.x).sum();
        received / (side_m * side_m)
    }

    #[test]
    fn a_small_lamp_at_a_wall_brings_it_all_its_light() {
        // 2 cm over the floor, away from the sample points and right over one of them.
        for middle_m in [DVec3::new(3.0, 2.5, 0.02), DVec3::new(1.7, 0.6, 0.02)] {
            let share = received_share(middle_m, 0.02, false);
            assert!((share - 1.0).abs() < 1e-3, "{share} at {middle_m}");
        }
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(64))]

        /// Whatever walls a lamp is near to, they receive together as much as it emits.
        #[test]
        fn walls_receive_all_light_of_a_small_lamp(
            x in 0.03..5.97_f64, y in 0.03..4.97_f64, height_m in 0.002..1.0_f64, side_m in 0.005..0.05_f64,
            up in any::<bool>(),
        ) {
            let z = if up { 3.0 - height_m } else { height_m };
            let share = received_share(DVec3::new(x, y, z), side_m, up);
            prop_assert!((share - 1.0).abs() < 5e-3, "{}", share);
        }
    }

    #[test]
    fn a_lamp_that_is_large_or_far_is_left_to_the_sample_points() {
        let polygons = [(fixture::square(DVec3::ZERO, 0.5, true), 0)];
        let prepared = fixture::prepared_of_materials(&polygons);
        let visibility = Visibility::new(&prepared);
        let mesh = Mesh::new(&prepared, &Table::new(), MeshSettings::default());
        let patch = ReceivingPatch::new(&prepared, &visibility, &mesh, PatchId::from(0));
        let extent = |radius_m: f64, distance_m: f64| EmitterExtent {
            middle_m: distance_m * DVec3::Z,
            radius_m,
            area_m2: 2.0 * radius_m * radius_m,
        };
        assert!(patch.is_small_and_near(&extent(0.1, 0.1)));
        assert!(!patch.is_small_and_near(&extent(0.8, 0.1)), "large");
        assert!(!patch.is_small_and_near(&extent(0.1, 2.3)), "far");
    }
}
