//! Irradiance at a point by paths of light, without bias.
//!
//! From the point, rays go out by the cosine; where one meets a side that reflects, light is gathered there in turn by
//! one ray more. At each place a point of an emitter is chosen too (next event estimation), and both ways of meeting an
//! emitter are weighed by the balance heuristic (Veach, *Robust Monte Carlo methods for light transport simulation*,
//! 1997): near an emitter the rays do better, far from it the chosen points. A path ends by Russian roulette.
//!
//! On a smooth surface light arrives by the interpolated normal ([`crate::smooth`]), at the first place and at all others.
//!
//! The rays of the first place are stratified. They come in batches that know nothing of one another, so that the
//! spread of the batches tells the error of their mean, stratified or not.

use std::f64::consts::PI;

use fastrand::Rng;
use glam::DVec3;
use umbrage::scene::{Rgb, Scene};

use crate::emitters::Emitters;
use crate::lamps::{self, PlacedLamp};
use crate::stratified;
use crate::tracer::Tracer;

/// Batches at each point.
pub(crate) const BATCHES: usize = 8;
/// From this bounce on a path ends by chance.
const FIRST_ROULETTE: usize = 2;
/// A path goes on with at most this chance, so that it ends in a room without losses too.
const MOST_SURVIVAL: f64 = 0.99;

/// A ray of so many extents of the scene leaves it.
const OUTSIDE_OF_EXTENT: f64 = 2.0;

/// A point of a side.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Place {
    pub(crate) position_m: DVec3,
    /// Unit normal of the side.
    pub(crate) front: DVec3,
    /// Unit normal by which it receives light: that of the smooth surface where it is part of one.
    pub(crate) normal: DVec3,
    /// From where it sees what is around it, on a smooth surface.
    pub(crate) near: Option<Near>,
}

/// From where a point of a smooth surface sees its polygon and those around.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Near {
    pub(crate) polygon: usize,
    pub(crate) from_m: DVec3,
}

/// What the paths from a point tell.
#[derive(Clone, Debug)]
pub(crate) struct Gathered {
    /// Irradiance by each batch, in W/m2.
    pub(crate) batches: [Rgb; BATCHES],
    /// Whether any first ray met the front of a side.
    pub(crate) sees_a_side: bool,
    /// How many rays were sent.
    pub(crate) rays: u64,
}

/// Paths through a scene.
pub(crate) struct Paths<'a> {
    pub(crate) scene: &'a Scene,
    pub(crate) tracer: &'a Tracer,
    pub(crate) emitters: &'a Emitters,
    pub(crate) lamps: &'a [PlacedLamp],
}

/// What a path carries: random numbers, and a count.
struct Walk {
    rng: Rng,
    rays: u64,
}

impl Paths<'_> {
    /// Gathers light by `BATCHES` times `side` squared paths.
    pub(crate) fn gather(&self, place: &Place, side: usize, seed: u64) -> Gathered {
        let mut walk = Walk { rng: Rng::with_seed(seed), rays: 0 };
        let mut sees_a_side = false;
        let batches = [(); BATCHES].map(|()| {
            let n = side * side;
            let directions = stratified::square(side, &mut walk.rng);
            let (shares, spots) = (stratified::interval(n, &mut walk.rng), stratified::square(side, &mut walk.rng));
            let mut sum = self.by_lamps(place, true, &mut walk) * n as f64;
            for ((direction, share), spot) in directions.into_iter().zip(shares).zip(spots) {
                sum += self.by_emitter(place, share, spot, &mut walk) + self.by_spots(place, &mut walk);
                let (light, met) = self.along(place, direction, &mut walk);
                sum += light;
                sees_a_side |= met;
            }
            sum / n as f64
        });
        Gathered { batches, sees_a_side, rays: walk.rays }
    }

    /// Irradiance by a chosen point of an emitter, over the chance of the choice; weighed against rays that meet it.
    fn by_emitter(&self, place: &Place, share: f64, [s, t]: [f64; 2], walk: &mut Walk) -> Rgb {
        let Some(number) = self.emitters.choose(share) else { return Rgb::ZERO };
        let triangle = &self.tracer.triangles[number];
        let material = &self.scene.materials[triangle.material];
        let target_m = triangle.point_m([s, t]);
        let between = target_m - place.position_m;
        let distance_m = between.length();
        let cosine = place.normal.dot(between) / distance_m;
        let facing = -triangle.normal.dot(between) / distance_m;
        let lit = facing > 0.0 || (material.double_sided && facing < 0.0);
        // Not even a number where the point is on the emitter.
        if !(cosine > 0.0 && lit) {
            return Rgb::ZERO;
        }
        walk.rays += 1;
        if self.tracer.blocked(place, target_m) {
            return Rgb::ZERO;
        }
        let density = self.emitters.density(material.exitance()) * distance_m * distance_m / facing.abs();
        material.radiance * cosine / (density + cosine / PI)
    }

    /// Irradiance by all lamps that a place sees; not by those that it is near to, unless it is the `first` of a path: their light is found
    /// from them.
    fn by_lamps(&self, place: &Place, first: bool, walk: &mut Walk) -> Rgb {
        let from = |PlacedLamp { lamp, near_m }: &PlacedLamp| {
            let Some(arriving) = lamp.arriving(place.position_m) else { return Rgb::ZERO };
            if !first && arriving.distance_m < *near_m {
                return Rgb::ZERO;
            }
            let cosine = place.normal.dot(arriving.towards);
            if cosine <= 0.0 {
                return Rgb::ZERO;
            }
            walk.rays += 1;
            let outside_m = OUTSIDE_OF_EXTENT * self.tracer.extent_m;
            let distance_m = if arriving.distance_m.is_finite() { arriving.distance_m } else { outside_m };
            let blocked = self.tracer.blocked(place, place.position_m + distance_m * arriving.towards);
            if blocked { Rgb::ZERO } else { cosine * arriving.irradiance }
        };
        self.lamps.iter().map(from).sum()
    }

    /// Irradiance by what is lit next to lamps: by a place that one of their rays meets, for each.
    fn by_spots(&self, place: &Place, walk: &mut Walk) -> Rgb {
        let near = self.lamps.iter().filter(|lamp| lamp.near_m > 0.0);
        near.map(|lamp| self.by_spot(place, lamp, walk).unwrap_or(Rgb::ZERO)).sum()
    }

    fn by_spot(&self, place: &Place, PlacedLamp { lamp, near_m }: &PlacedLamp, walk: &mut Walk) -> Option<Rgb> {
        let (towards, solid_angle_sr) = lamps::direction(lamp, &mut walk.rng)?;
        let from_m = lamp.position_m()?;
        let start = Place { position_m: from_m, front: towards, normal: towards, near: None };
        walk.rays += 1;
        let hit = self.tracer.nearest(&start, towards).filter(|hit| hit.distance_m < *near_m)?;
        let triangle = &self.tracer.triangles[hit.triangle];
        let material = &self.scene.materials[triangle.material];
        if !(hit.front || material.double_sided) {
            return None;
        }
        let lit = self.tracer.place(hit.triangle, from_m + hit.distance_m * towards, hit.front);
        let arriving = lamp.arriving(lit.position_m)?;
        // The flux of the ray, by the true area, and the cosine by which a smooth surface takes it.
        let flux = arriving.irradiance * (hit.distance_m * hit.distance_m * solid_angle_sr);
        let taken = lit.normal.dot(arriving.towards).max(0.0) / lit.front.dot(arriving.towards);
        let between = lit.position_m - place.position_m;
        let distance_m = between.length();
        let cosines = [place.normal.dot(between), -lit.front.dot(between)].map(|cosine| cosine / distance_m);
        // Not even a number in the spot itself.
        if !(cosines[0] > 0.0 && cosines[1] > 0.0) {
            return None;
        }
        walk.rays += 1;
        let sent = taken * flux * material.reflectance / PI;
        let seen = !self.tracer.blocked(place, lit.position_m);
        seen.then(|| sent * cosines[0] * cosines[1] / (distance_m * distance_m))
    }

    /// Irradiance by a ray that leaves by the cosine, and whether it met the front of a side.
    fn along(&self, from: &Place, direction: [f64; 2], walk: &mut Walk) -> (Rgb, bool) {
        let (mut place, mut square) = (*from, direction);
        // What irradiance at the point a unit of irradiance here makes.
        let mut carried = Rgb::ONE;
        let (mut sum, mut sees_a_side) = (Rgb::ZERO, false);
        for bounce in 0.. {
            let (outward, cosine) = cosine_direction(place.normal, square);
            walk.rays += 1;
            let Some(hit) = self.tracer.nearest(&place, outward) else { break };
            let triangle = &self.tracer.triangles[hit.triangle];
            let material = &self.scene.materials[triangle.material];
            if !(hit.front || material.double_sided) {
                break;
            }
            sees_a_side = true;
            if material.emits() {
                let facing = triangle.normal.dot(outward).abs();
                let density = self.emitters.density(material.exitance()) * hit.distance_m * hit.distance_m / facing;
                sum += carried * PI * material.radiance * (cosine / PI / (density + cosine / PI));
            }
            carried *= material.reflectance;
            if bounce + 1 >= FIRST_ROULETTE {
                let survival = carried.max_element().min(MOST_SURVIVAL);
                if walk.rng.f64() >= survival {
                    break;
                }
                carried /= survival;
            } else if carried == Rgb::ZERO {
                break;
            }
            place = self.tracer.place(hit.triangle, place.position_m + hit.distance_m * outward, hit.front);
            let (share, spot) = (walk.rng.f64(), [walk.rng.f64(), walk.rng.f64()]);
            let lamps = self.by_lamps(&place, false, walk) + self.by_spots(&place, walk);
            sum += carried * (self.by_emitter(&place, share, spot, walk) + lamps);
            square = [walk.rng.f64(), walk.rng.f64()];
        }
        (sum, sees_a_side)
    }
}

/// A direction over a side, by the cosine (Malley's method), and its cosine.
fn cosine_direction(normal: DVec3, [s, t]: [f64; 2]) -> (DVec3, f64) {
    let (u, v) = normal.any_orthonormal_pair();
    let (radius, angle) = (s.sqrt(), 2.0 * PI * t);
    let cosine = (1.0 - s).sqrt();
    (radius * angle.cos() * u + radius * angle.sin() * v + cosine * normal, cosine)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn directions_are_spread_by_the_cosine() {
        let normal = DVec3::new(0.6, -0.48, 0.64);
        let mut rng = Rng::with_seed(1);
        let directions: Vec<(DVec3, f64)> =
            stratified::square(64, &mut rng).into_iter().map(|square| cosine_direction(normal, square)).collect();
        assert!(directions.iter().all(|(d, c)| (d.length() - 1.0).abs() < 1e-12 && (d.dot(normal) - c).abs() < 1e-12));
        // The mean of the cosine, weighed by itself, is 2/3; that of the direction lies along the normal.
        let mean: DVec3 = directions.iter().map(|(d, _)| d).sum::<DVec3>() / directions.len() as f64;
        assert!(mean.distance(2.0 / 3.0 * normal) < 1e-3, "{mean}");
    }
}
