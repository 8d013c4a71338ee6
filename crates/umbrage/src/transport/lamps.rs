//! Direct light of lamps: what arrives at a point, where an exact ray sees the lamp.

use crate::id::{LampId, Table};
use crate::prepare::Prepared;
use crate::scene::{Lamp, Rgb, Scene};
use crate::visibility::{ReceiverPoint, Visibility};

/// The lamps of a scene, in the frame of its prepared faces.
#[derive(Debug)]
pub(super) struct Lamps {
    lamps: Table<LampId, Lamp>,
    /// A ray of this length from anywhere inside the scene leaves it, in metres.
    outside_m: f64,
}

/// The diagonal of a box is at most this many times its longest side, and a little for rounding.
const DIAGONAL_OF_EXTENT: f64 = 1.75;

impl Lamps {
    pub(super) fn new(scene: &Scene, prepared: &Prepared) -> Self {
        let lamps = scene.lamps.iter().cloned();
        Self {
            lamps: lamps.map(|lamp| lamp.moved(|p| p - prepared.origin_m, |d| d, 1.0)).collect(),
            outside_m: DIAGONAL_OF_EXTENT * prepared.tolerance.extent_m,
        }
    }

    /// Whether there are none.
    pub(super) fn is_empty(&self) -> bool {
        self.lamps.is_empty()
    }

    /// Irradiance at a point, in W/m2. `known` tells of lamps whether the point sees them, where that is known; those that it sees are
    /// added to `seen`.
    pub(super) fn at(
        &self,
        visibility: &Visibility,
        receiver: &ReceiverPoint,
        known: impl Fn(LampId) -> Option<bool>,
        seen: &mut Vec<LampId>,
    ) -> Rgb {
        let from = |(id, lamp): (LampId, &Lamp)| {
            let Some(arriving) = lamp.arriving(receiver.position_m) else { return Rgb::ZERO };
            let cosine = receiver.normal.dot(arriving.towards);
            let to_m = lamp.position_m().unwrap_or(receiver.position_m + self.outside_m * arriving.towards);
            // Grazing light brings nothing, and whether it is seen is rounding.
            let sees = || !visibility.hidden_from(receiver, to_m);
            if cosine <= 0.0 || !known(id).unwrap_or_else(sees) {
                return Rgb::ZERO;
            }
            seen.push(id);
            cosine * arriving.irradiance
        };
        self.lamps.iter_enumerated().map(from).sum()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::id::FaceId;
    use crate::scene::LampKind;
    use crate::visibility::fixture::{self, square};
    use glam::DVec3;

    #[test]
    fn a_plate_that_meets_a_floor_at_a_small_angle_hides_all_of_one_side_and_nothing_of_the_other() {
        // It crosses the floor at x = 0, and is 8 um over it or under it at its ends.
        let slope = 8e-6;
        let plate = [(-1.0, -1.0), (-1.0, 1.0), (1.0, 1.0), (1.0, -1.0)].map(|(x, y)| DVec3::new(x, y, slope * x));
        let prepared = fixture::prepared(&[square(DVec3::ZERO, 2.0, true), plate.to_vec()]);
        let visibility = Visibility::new(&prepared);
        let mut scene = Scene::default();
        let kind = LampKind::Point { position_m: DVec3::Z * 2.0, intensity: Rgb::ONE, range_m: None };
        scene.lamps.push(Lamp { name: String::new(), kind });
        let lamps = Lamps::new(&scene, &prepared);
        let up = |face: &FaceId| {
            prepared.normal(*face).z > 0.9 && prepared.polygon_m(*face).iter().all(|p| p.z.abs() < 1e-7)
        };
        for i in 1..400 {
            // Off the plane by rounding.
            let x = f64::from(i - 200) / 400.0 + 1e-4;
            let at_m = DVec3::new(x, 0.3, if i % 2 == 0 { 6e-8 } else { -6e-8 });
            let Some(face) = prepared.faces.keys().find(up) else { panic!("no floor") };
            let receiver = ReceiverPoint { position_m: at_m, ..ReceiverPoint::on_face(&prepared, face, at_m) };
            let light = lamps.at(&visibility, &receiver, |_| None, &mut Vec::new()).x;
            assert_eq!(light > 0.0, x < 0.0, "at {x}");
        }
    }

    #[test]
    fn lamps_light_what_they_see() {
        let prepared = fixture::prepared(&[square(DVec3::ZERO, 2.0, true), square(DVec3::Z, 0.5, true)]);
        let visibility = Visibility::new(&prepared);
        let lit = |kind: LampKind, p: DVec3| {
            let mut scene = Scene::default();
            scene.lamps.push(Lamp { name: String::new(), kind });
            let receiver = ReceiverPoint::on_face(&prepared, FaceId::from(0), p);
            Lamps::new(&scene, &prepared).at(&visibility, &receiver, |_| None, &mut Vec::new()).x
        };
        let lamp = LampKind::Point { position_m: DVec3::Z * 2.0, intensity: Rgb::ONE, range_m: None };
        // The shadow of the plate is twice as large as it.
        for (x, seen) in [(0.0, false), (0.999, false), (1.001, true), (1.9, true)] {
            let squared: f64 = x * x + 4.0;
            let truth = if seen { 2.0 / squared.sqrt() / squared } else { 0.0 };
            assert!((lit(lamp, DVec3::X * x) - truth).abs() < 1e-15, "at {x}");
        }
        let slanted = DVec3::new(-0.6, 0.0, -0.8);
        let sun = LampKind::Directional { direction: slanted, irradiance: Rgb::splat(5.0) };
        // The plate's shadow is moved by 0.75.
        for (x, seen) in [(-1.26, true), (-1.24, false), (-0.26, false), (-0.24, true)] {
            assert!((lit(sun, DVec3::X * x) - if seen { 4.0 } else { 0.0 }).abs() < 1e-14, "at {x}");
        }
        let below = LampKind::Point { position_m: DVec3::NEG_Z, intensity: Rgb::ONE, range_m: None };
        assert_eq!(lit(below, DVec3::X), 0.0);
    }
}
