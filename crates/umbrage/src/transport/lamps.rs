//! Direct light of lamps: what arrives at a point, where an exact ray sees the lamp. Where a lamp nearly touches the surface, its
//! light is spread a little ([`super::near_surface`]).

use glam::DVec3;
use rayon::prelude::*;
use smallvec::SmallVec;

use super::lamp_flux;
use super::near_surface::{self, SPREAD_OF_EXTENT, SpreadDisc};
use crate::geometry::Plane;
use crate::id::{LampId, PlaneId, Table};
use crate::prepare::Prepared;
use crate::scene::{Lamp, LampKind, Rgb, Scene};
use crate::visibility::{self, FlatSource, ReceiverPoint, Visibility};

/// The lamps of a scene, in the frame of its prepared faces.
#[derive(Debug)]
pub(super) struct Lamps {
    lamps: Table<LampId, Lamp>,
    /// A ray of this length from anywhere inside the scene leaves it, in metres.
    outside_m: f64,
    /// Where the light of each is spread, on surfaces that it nearly touches.
    discs: Table<LampId, Vec<SpreadDisc>>,
    /// The cone of each spot.
    cones: Table<LampId, Option<Cone>>,
    /// A plane that no face lies in.
    no_plane: PlaneId,
}

/// The diagonal of a box is at most this many times its longest side, and a little for rounding.
const DIAGONAL_OF_EXTENT: f64 = 1.75;

impl Lamps {
    pub(super) fn new(scene: &Scene, prepared: &Prepared, visibility: &Visibility) -> Self {
        let lamps = visibility::lamps(scene, prepared);
        let no_plane = PlaneId::from(prepared.planes.len());
        let spread_m = SPREAD_OF_EXTENT * prepared.tolerance.extent_m;
        let discs = |lamp: &Lamp| near_surface::discs(lamp, prepared, visibility, no_plane, spread_m);
        let discs = lamps.raw.par_iter().map(discs).collect::<Vec<_>>().into();
        let cones = lamps.iter().map(Cone::of).collect();
        Self { lamps, outside_m: DIAGONAL_OF_EXTENT * prepared.tolerance.extent_m, discs, cones, no_plane }
    }

    /// The lamps.
    pub(super) fn iter(&self) -> impl Iterator<Item = (LampId, &Lamp)> {
        self.lamps.iter_enumerated()
    }

    /// A ray of this length from anywhere inside the scene leaves it, in metres.
    pub(super) fn outside_m(&self) -> f64 {
        self.outside_m
    }

    /// Irradiance that one lamp would bring to a point if nothing stood between, in W/m2: spread, where it nearly touches the surface.
    pub(super) fn unoccluded(&self, id: LampId, receiver: &ReceiverPoint) -> Rgb {
        let lamp = &self.lamps[id];
        let spread = self.discs[id].iter().find_map(|disc| disc.irradiance(lamp, receiver));
        spread.unwrap_or_else(|| near_surface::unoccluded(lamp, receiver.position_m, receiver.normal))
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
        let from = |id: LampId| {
            let light = self.of_one(id, visibility, receiver, known(id));
            if light.is_some() {
                seen.push(id);
            }
            light.unwrap_or_default()
        };
        self.lamps.keys().map(from).sum()
    }

    /// Irradiance that one lamp brings to a point, in W/m2; `None` where the point does not see it. `known` tells whether it does, where
    /// that is known.
    pub(super) fn of_one(
        &self,
        id: LampId,
        visibility: &Visibility,
        receiver: &ReceiverPoint,
        known: Option<bool>,
    ) -> Option<Rgb> {
        let looking = receiver.looking_for_lamps();
        let (light, to_m) = self.unoccluded_and_end(id, &looking)?;
        let is_seen = known.unwrap_or_else(|| visibility.stopper(&looking, to_m, None, None).is_none());
        let light_here = || receiver.beside_jump.and_then(|_| self.unoccluded_and_end(id, receiver));
        is_seen.then(|| light_here().map_or(light, |(light, _)| light))
    }

    /// Irradiance that one lamp brings to a point if nothing stands between, in W/m2, and where a ray to it ends, in metres; `None`
    /// where it brings none.
    pub(super) fn unoccluded_and_end(&self, id: LampId, receiver: &ReceiverPoint) -> Option<(Rgb, DVec3)> {
        let lamp = &self.lamps[id];
        let light = self.unoccluded(id, receiver);
        // Grazing light brings nothing, and whether it is seen is rounding.
        if light.max_element() <= 0.0 {
            return None;
        }
        let to_m = match lamp.kind {
            LampKind::Point { position_m, .. } | LampKind::Spot { position_m, .. } => position_m,
            LampKind::Directional { direction, .. } => receiver.position_m - self.outside_m * direction,
        };
        Some((light, to_m))
    }

    /// The lamps whose light samples of a polygon do not tell: it is large as seen from them, or from where their cone or range ends.
    pub(super) fn uneven_over(&self, polygon: &FlatSource, middle_m: DVec3) -> impl Iterator<Item = LampId> {
        let radius_m = polygon.corners_m.iter().map(|&p| polygon.frame.to_3d(p).distance(middle_m)).fold(0.0, f64::max);
        let is_uneven = |lamp: &Lamp| is_near(lamp, &polygon.frame.plane, middle_m, radius_m);
        let uneven: Vec<LampId> =
            self.lamps.iter_enumerated().filter(|(_, lamp)| is_uneven(lamp)).map(|(id, _)| id).collect();
        uneven.into_iter()
    }

    /// The same of a small polygon that lies within a ball around a point of it, and that a single point would stand for: the cone of
    /// a spot may end in it, too.
    pub(super) fn untold_by_point(&self, plane: &Plane, point_m: DVec3, radius_m: f64) -> SmallVec<[LampId; 4]> {
        let is_untold = |id: LampId, lamp: &Lamp| {
            is_near(lamp, plane, point_m, radius_m)
                || self.cones[id].is_some_and(|cone| cone.ends_in(point_m, radius_m))
        };
        self.lamps.iter_enumerated().filter(|&(id, lamp)| is_untold(id, lamp)).map(|(id, _)| id).collect()
    }

    /// Flux that a lamp sends into the part of a polygon that it sees, in W.
    pub(super) fn flux_w(&self, id: LampId, visibility: &Visibility, polygon: &FlatSource) -> Rgb {
        let lamp = &self.lamps[id];
        let Some(receiver) = lamp_flux::looking_at(self.no_plane, lamp, &polygon.frame.plane) else { return Rgb::ZERO };
        lamp_flux::flux_w(visibility, lamp, &receiver, polygon)
    }
}

/// A polygon with a radius of more than this share of its distance from a lamp is lit unevenly.
const NEAR: f64 = 0.3;

/// Whether a polygon in a plane that lies within a ball is large as seen from a lamp, or from where the lamp's cone ends.
fn is_near(lamp: &Lamp, plane: &Plane, middle_m: DVec3, radius_m: f64) -> bool {
    let Some(position_m) = lamp.position_m() else { return false };
    let squared_m2 = position_m.distance_squared(middle_m);
    let of_distance = match lamp.kind {
        LampKind::Spot { outer_rad, .. } => outer_rad.min(1.0),
        LampKind::Point { .. } | LampKind::Directional { .. } => 1.0,
    };
    // Beyond its cone and its range it does not shine at all.
    radius_m * radius_m > (NEAR * of_distance).powi(2) * squared_m2
        && plane.signed_distance_m(position_m) > 0.0
        && may_light(lamp, middle_m, radius_m)
}

/// The cone that a spot shines into.
#[derive(Clone, Copy, Debug)]
struct Cone {
    apex_m: DVec3,
    axis: DVec3,
    /// Cosines of the half angles.
    outer: f64,
    inner: f64,
    /// The angle over which light falls, in radians.
    soft_rad: f64,
}

impl Cone {
    fn of(lamp: &Lamp) -> Option<Self> {
        let LampKind::Spot { position_m, direction, inner_rad, outer_rad, .. } = lamp.kind else { return None };
        let [outer, inner] = [outer_rad, inner_rad].map(f64::cos);
        Some(Self { apex_m: position_m, axis: direction, outer, inner, soft_rad: outer_rad - inner_rad })
    }

    /// Whether light ends within a ball, or falls by much there. Cosines tell, since they differ by no more than their angles.
    fn ends_in(&self, middle_m: DVec3, radius_m: f64) -> bool {
        let to_middle_m = middle_m - self.apex_m;
        let distance_m = to_middle_m.length();
        let (cosine, within_rad) = (self.axis.dot(to_middle_m) / distance_m, radius_m / distance_m);
        cosine + within_rad > self.outer && cosine - within_rad < self.inner && within_rad > NEAR * self.soft_rad
    }
}

/// Whether a lamp may shine into a ball.
fn may_light(lamp: &Lamp, middle_m: DVec3, radius_m: f64) -> bool {
    let (position_m, range_m) = match lamp.kind {
        LampKind::Point { position_m, range_m, .. } | LampKind::Spot { position_m, range_m, .. } => {
            (position_m, range_m)
        }
        LampKind::Directional { .. } => return true,
    };
    let to_middle_m = middle_m - position_m;
    let distance_m = to_middle_m.length();
    if range_m.is_some_and(|range_m| distance_m - radius_m > range_m) {
        return false;
    }
    match lamp.kind {
        LampKind::Spot { direction, outer_rad, .. } if distance_m > radius_m => {
            direction.angle_between(to_middle_m) - (radius_m / distance_m).asin() < outer_rad
        }
        _ => true,
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
    fn lamps_light_what_they_see() {
        let prepared = fixture::prepared(&[square(DVec3::ZERO, 2.0, true), square(DVec3::Z, 0.5, true)]);
        let visibility = Visibility::new(&prepared);
        let lit = |kind: LampKind, p: DVec3| {
            let mut scene = Scene::default();
            scene.lamps.push(Lamp { name: String::new(), kind });
            let receiver = ReceiverPoint::on_face(&prepared, FaceId::from(0), p);
            Lamps::new(&scene, &prepared, &visibility).at(&visibility, &receiver, |_| None, &mut Vec::new()).x
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
