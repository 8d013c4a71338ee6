//! What light a bake was for, and what changed of it since.

use serde::{Deserialize, Serialize};

use super::Change;
use crate::id::{FaceId, LampId, Table};
use crate::prepare::Prepared;
use crate::scene::{Lamp, Material, Rgb, Scene};

/// Light is that of before times a factor where no source departs from it by more than this share of itself: rounding
/// of the numbers in a file.
const SAME_FACTOR: f64 = 1e-12;

/// What gives light in a scene, and what reflects it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct Lights {
    /// The faces that emit, ascending.
    pub(super) emitters: Vec<FaceId>,
    /// Emitted exitance of each of them, in W/m2.
    exitance: Vec<Rgb>,
    pub(super) lamps: Table<LampId, Lamp>,
    /// Of each face.
    reflectance: Vec<Rgb>,
}

impl Lights {
    pub(super) fn of(scene: &Scene, prepared: &Prepared) -> Self {
        let material = |face: FaceId| -> &Material { &scene.materials[prepared.faces[face].material] };
        let emitters: Vec<FaceId> = prepared.faces.keys().filter(|&face| material(face).emits()).collect();
        Self {
            exitance: emitters.iter().map(|&face| material(face).exitance()).collect(),
            emitters,
            lamps: scene.lamps.clone(),
            reflectance: prepared.faces.keys().map(|face| material(face).reflectance).collect(),
        }
    }

    /// What changed since `before`, and by how much all light together did in each colour.
    pub(super) fn since(&self, before: &Self) -> (Change, Rgb) {
        let factor = ratio(self.brightness().sum(), before.brightness().sum());
        let is_there = |lamp: &Lamp| before.lamps.iter().any(|old| old.emits() && old.shines_where(lamp));
        let lit = |lights: &Self| lights.lamps.iter().filter(|lamp| lamp.emits()).count();
        let same_lamps = lit(self) == lit(before) && self.lamps.iter().filter(|lamp| lamp.emits()).all(is_there);
        if self.emitters != before.emitters || !same_lamps {
            return (Change::Lamps, factor);
        }
        let in_order = self.lamps.len() == before.lamps.len()
            && self.lamps.iter().zip(&before.lamps).all(|(lamp, old)| lamp.shines_where(old));
        let by_factor = |(now, old): (Rgb, Rgb)| {
            let scaled = factor * old;
            (now - scaled).abs().max_element() <= SAME_FACTOR * scaled.max_element()
        };
        let all_by_factor = in_order && self.brightness().zip(before.brightness()).all(by_factor);
        let change =
            if all_by_factor && self.reflectance == before.reflectance { Change::Strength } else { Change::Light };
        (change, factor)
    }

    /// Of all light sources, each in its own unit.
    fn brightness(&self) -> impl Iterator<Item = Rgb> {
        self.exitance.iter().copied().chain(self.lamps.iter().map(Lamp::brightness))
    }

    /// Whether all that is named is there, and all numbers are finite: where it comes from a file, it must be checked.
    pub(super) fn fits(&self, faces: usize) -> bool {
        self.emitters.is_sorted()
            && self.emitters.iter().all(|face| face.index() < faces)
            && self.exitance.len() == self.emitters.len()
            && self.reflectance.len() == faces
            && self.brightness().all(Rgb::is_finite)
    }
}

/// The quotient of two colours; of a colour that was not there, 0.
fn ratio(now: Rgb, before: Rgb) -> Rgb {
    let of = |i: usize| if before[i] > 0.0 { now[i] / before[i] } else { 0.0 };
    Rgb::new(of(0), of(1), of(2))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::LampKind;
    use glam::DVec3;

    fn lamp(x: f64, intensity: f64) -> Lamp {
        let intensity = Rgb::splat(intensity);
        Lamp { name: String::new(), kind: LampKind::Point { position_m: DVec3::X * x, intensity, range_m: None } }
    }

    fn lights(exitance: [f64; 3], lamps: Vec<Lamp>, reflectance: f64) -> Lights {
        let emitters = vec![FaceId::from(1)];
        let reflectance = vec![Rgb::splat(reflectance); 3];
        Lights { emitters, exitance: vec![exitance.into()], lamps: lamps.into(), reflectance }
    }

    #[test]
    fn what_changed_is_told_by_what_it_costs() {
        let before = lights([1.0, 2.0, 0.0], vec![lamp(0.0, 3.0)], 0.5);
        let change = |now: Lights| now.since(&before).0;
        assert_eq!(before.since(&before), (Change::Strength, Rgb::ONE));
        let twice = lights([2.0, 4.0, 0.0], vec![lamp(0.0, 6.0)], 0.5);
        assert_eq!(twice.since(&before), (Change::Strength, Rgb::splat(2.0)));
        assert_eq!(change(lights([2.0, 4.0, 0.0], vec![lamp(0.0, 3.0)], 0.5)), Change::Light, "one of two lamps");
        assert_eq!(change(lights([1.0, 2.0, 0.1], vec![lamp(0.0, 3.0)], 0.5)), Change::Light, "a colour that was not");
        assert_eq!(change(lights([1.0, 2.0, 0.0], vec![lamp(0.0, 3.0)], 0.4)), Change::Light, "reflectance");
        assert_eq!(change(lights([1.0, 2.0, 0.0], vec![lamp(0.1, 3.0)], 0.5)), Change::Lamps, "moved");
        assert_eq!(change(lights([1.0, 2.0, 0.0], vec![lamp(0.0, 0.0)], 0.5)), Change::Lamps, "switched off");
        assert_eq!(change(lights([1.0, 2.0, 0.0], vec![lamp(0.0, 3.0), lamp(1.0, 1.0)], 0.5)), Change::Lamps, "new");
    }
}
