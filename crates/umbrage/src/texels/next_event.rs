//! Next events: what few bright texels send is looked for where they are, and not only by rays that happen to meet them.
//!
//! A texel beside a lamp may send a hundred times the mean. Rays by the cosine that seldom meet it make most of the noise. So what a texel sends
//! is cut at a cap of a few means: what is below comes by rays alone, and what is above by the ray *and* by one shadow ray to a
//! texel that a light tree chooses, both weighed by the balance heuristic (Veach and Guibas, *Optimally combining sampling techniques*,
//! 1995). An event is never worth more than what its texel sends, so contacts need no rule of their own.
//!
//! Holds: the sum of both has the mean that rays alone have, whatever the tree chooses.

use std::f32::consts::PI;

use glam::{DVec3, Vec3};
use rayon::prelude::*;

use super::grid::TexelGrid;
use super::light_tree::{Cut, Light, LightTree};
use super::ray_tree::{Ray, RayTree};
use crate::geometry::polygon;
use crate::id::FaceId;
use crate::prepare::Prepared;

/// What texels send above so many means of all is bright.
const CAP_OF_MEAN: f64 = 4.0;
/// Of the square of the mean, so much is no variance of rays: they meet what is alike around a point.
const EVEN: f64 = 0.7;
/// Events below this share of the mean are sent by chance, and then count for as much.
const LEAST_OF_MEAN: f32 = 0.05;

/// No bright texel.
const NONE: u32 = u32::MAX;

/// A texel that sends more than the cap.
#[derive(Clone, Debug)]
struct BrightTexel {
    texel: u32,
    face: FaceId,
    normal: Vec3,
    corners_m: Vec<DVec3>,
    area_m2: f32,
    /// Mean of what it sends over the colours, in W/m2, and the share of that above the cap.
    sent: f32,
    above: f32,
}

/// All bright texels.
#[derive(Debug)]
pub(crate) struct BrightTexels {
    tree: LightTree,
    texels: Vec<BrightTexel>,
    /// The bright texel of each texel.
    of_texel: Vec<u32>,
    /// An event that brings less is sent by chance, in W/m2.
    least: f32,
}

/// What a next event brings.
#[derive(Clone, Copy, Debug)]
pub(crate) struct NextEvent {
    pub(crate) texel: usize,
    pub(crate) face: FaceId,
    pub(crate) point: Vec3,
    pub(crate) distance_m: f32,
    /// By which what is sent there counts.
    pub(crate) weight: f32,
}

/// Next events for points of a small place.
#[derive(Clone, Debug)]
pub(crate) struct NextEvents<'a> {
    bright: &'a BrightTexels,
    cut: Cut,
    /// Events for each ray.
    per_ray: f32,
}

impl BrightTexels {
    /// Those of texels that send so much, if the variance of rays under the cap is less by a factor of `worth`.
    pub(crate) fn new(prepared: &Prepared, grid: &TexelGrid, radiosity: &[Vec3], worth: f64) -> Option<Self> {
        let mean_of = |light: Vec3| f64::from(light.element_sum()) / 3.0;
        let lights = || grid.texels().iter().zip(radiosity).map(|(texel, &light)| (texel.area_m2, mean_of(light)));
        let area_m2: f64 = lights().map(|(area_m2, _)| area_m2).sum();
        let integral = |of: &dyn Fn(f64) -> f64| lights().map(|(area_m2, light)| area_m2 * of(light)).sum::<f64>();
        let mean = integral(&|light| light) / area_m2;
        let cap = CAP_OF_MEAN * mean;
        let [all, below] = [integral(&|light| light * light), integral(&|light| light.min(cap).powi(2))];
        let even = mean * mean * area_m2;
        if mean <= 0.0 || all - even < worth * (below - EVEN * even) {
            return None;
        }
        let bright = |(number, &light): (usize, &Vec3)| {
            let (light, texel) = (mean_of(light), &grid.texels()[number]);
            let corners_m = if light > cap { grid.outline_m(prepared, texel) } else { return None };
            (corners_m.len() >= 3).then(|| BrightTexel {
                texel: number as u32,
                face: texel.face,
                normal: prepared.normal(texel.face).as_vec3(),
                area_m2: polygon::area_m2(&corners_m) as f32,
                corners_m,
                sent: light as f32,
                above: (1.0 - cap / light) as f32,
            })
        };
        let found: Vec<BrightTexel> = radiosity.par_iter().enumerate().filter_map(bright).collect();
        let found: Vec<BrightTexel> = found.into_iter().filter(|texel| texel.area_m2 > 0.0).collect();
        let radius_m = std::f32::consts::FRAC_1_SQRT_2 * grid.side_m() as f32;
        let light = |texel: &BrightTexel| Light {
            middle: (texel.corners_m.iter().sum::<DVec3>() / texel.corners_m.len() as f64).as_vec3(),
            radius_m,
            normal: Some(texel.normal),
            power: texel.area_m2 * texel.above * texel.sent,
        };
        let lights: Vec<Light> = found.iter().map(light).collect();
        let (tree, order) = LightTree::new(&lights);
        let texels: Vec<BrightTexel> = order.iter().map(|&number| found[number as usize].clone()).collect();
        let mut of_texel = vec![NONE; radiosity.len()];
        texels.iter().enumerate().for_each(|(number, texel)| of_texel[texel.texel as usize] = number as u32);
        tracing::debug!(bright = texels.len(), variance = (all - even) / (below - EVEN * even), "bright texels");
        let least = LEAST_OF_MEAN * mean as f32;
        (!texels.is_empty()).then_some(Self { tree, texels, of_texel, least })
    }

    /// Next events for a place with these points, of which `per_ray` go with each ray; of at most `most` nodes of the tree.
    pub(crate) fn events(&self, points: &[Vec3], normal: Vec3, per_ray: f32, most: usize) -> NextEvents<'_> {
        NextEvents { bright: self, cut: self.tree.cut(points, normal, most), per_ray }
    }
}

impl NextEvents<'_> {
    /// The share of what a ray over a surface with this normal brings from a texel so far away that next events bring in its place.
    pub(crate) fn share_of(&self, texel: usize, normal: Vec3, ray: Ray, distance_m: f32) -> f32 {
        let number = self.bright.of_texel[texel];
        if number == NONE {
            return 0.0;
        }
        let bright = &self.bright.texels[number as usize];
        let of_events = self.per_ray * self.bright.tree.probability(&self.cut, number as usize) / bright.area_m2;
        let density = density(normal.dot(ray.along), -bright.normal.dot(ray.along), 1.0) / (distance_m * distance_m);
        if of_events > 0.0 { bright.above * of_events / (density + of_events) } else { 0.0 }
    }

    /// Sends one by four even random numbers: which, where, and whether at all if it brings little.
    pub(crate) fn draw(&self, tree: &RayTree, from: Vec3, normal: Vec3, numbers: [f32; 4]) -> Option<NextEvent> {
        let [which, s, t, chance] = numbers;
        let (number, probability) = self.bright.tree.draw(&self.cut, which)?;
        let bright = &self.bright.texels[number];
        let point = polygon::point_of(&bright.corners_m, s.into(), t.into()).as_vec3();
        let towards = point - from;
        let [received, sent] = [normal.dot(towards), -bright.normal.dot(towards)];
        if received <= 0.0 || sent <= 0.0 {
            return None;
        }
        let density = density(received, sent, towards.length_squared());
        let of_events = self.per_ray * probability / bright.area_m2;
        let mut weight = bright.above * density / (density + of_events);
        let brings = weight * bright.sent;
        if brings < self.bright.least {
            let is_sent = brings / self.bright.least;
            if chance >= is_sent {
                return None;
            }
            weight /= is_sent;
        }
        let event =
            NextEvent { texel: bright.texel as usize, face: bright.face, point, distance_m: towards.length(), weight };
        tree.is_clear(from, point).then_some(event)
    }
}

/// The density by area with which rays by the cosine meet a place, in 1/m2, for its heights over both planes in metres.
fn density(received: f32, sent: f32, squared_m2: f32) -> f32 {
    received * sent / (PI * squared_m2 * squared_m2).max(f32::MIN_POSITIVE)
}

#[cfg(test)]
mod tests {
    use super::super::radiosity::TexelRadiosity;
    use super::super::sequence::{Sequence, key_of};
    use super::super::sources::Start;
    use super::*;
    use crate::progress::Progress;
    use crate::scene::{Material, Rgb};
    use crate::transport::DirectLight;
    use crate::visibility::{Visibility, fixture};

    /// Mean and variance of what rays bring to a point, and of rays with next events.
    fn of_both(
        prepared: &Prepared,
        light: &TexelRadiosity,
        tree: &RayTree,
        start: &Start,
        per_ray: usize,
    ) -> [[f64; 2]; 2] {
        let bright = BrightTexels::new(prepared, &light.grid, &light.reflected, 2.0).unwrap();
        let normal = start.axes[2];
        let events = bright.events(&[start.from], normal, per_ray as f32, 48);
        let count = 60_000;
        let mut sums = [[0.0_f64; 2]; 2];
        for number in 0..count {
            let sequence = Sequence::new(key_of(number, 3));
            let [s, t, ..] = sequence.at(0);
            let ray = Ray { from: start.from, along: start.direction(s, t) };
            let (mut brought, mut share) = (0.0, 0.0);
            if let Some((face, distance_m)) = tree.first(ray).and_then(|hit| Some((hit.front?, hit.distance_m))) {
                let texel = light.grid.texel_at(face, ray.from + distance_m * ray.along);
                brought = light.reflected[texel].x;
                share = events.share_of(texel, normal, ray, distance_m);
            }
            let of_event = |number: usize| {
                let event = events.draw(tree, start.from, normal, sequence.more_at(number));
                event.map_or(0.0, |event| event.weight * light.reflected[event.texel].x)
            };
            let with_events = (1.0 - share) * brought + (0..per_ray).map(of_event).sum::<f32>();
            for (sum, value) in sums.iter_mut().zip([brought, with_events].map(f64::from)) {
                *sum = [sum[0] + value, sum[1] + value * value];
            }
        }
        sums.map(|[sum, squared]| {
            let mean = sum / count as f64;
            [mean, squared / count as f64 - mean * mean]
        })
    }

    #[test]
    fn events_change_the_variance_and_not_the_mean() {
        // A lamp close below the ceiling of a room, and a shelf before it.
        let materials = vec![Material::diffuse("grey", Rgb::splat(0.7)), Material::emitting("lamp", Rgb::ONE)];
        let mut polygons: Vec<_> = fixture::inward_box(DVec3::ZERO, DVec3::new(4.0, 3.0, 2.5))
            .into_iter()
            .map(|polygon| (polygon, 0))
            .collect();
        polygons.push((fixture::square(DVec3::new(2.0, 1.5, 2.4), 0.3, true), 1));
        polygons.push((fixture::square(DVec3::new(1.0, 1.5, 1.5), 0.5, true), 0));
        let (prepared, scene) = (fixture::prepared_of_materials(&polygons), fixture::scene(materials));
        let visibility = Visibility::new(&prepared);
        let direct = DirectLight::new(&scene, &prepared, &visibility);
        let tree = RayTree::new(&prepared);
        let light = TexelRadiosity::new(&scene, &prepared, &visibility, (&direct, &tree), Progress::silent()).unwrap();
        let floor = prepared.faces.keys().find(|&face| prepared.normal(face).z > 0.5).unwrap();
        for at_m in [DVec3::new(0.6, 1.4, 0.0), DVec3::new(2.0, 1.5, 0.0), DVec3::new(3.5, 0.2, 0.0)] {
            let start = Start::new(&prepared, &tree, floor, at_m);
            for per_ray in [1, 3] {
                let [[mean, variance], [with_events, with_less]] = of_both(&prepared, &light, &tree, &start, per_ray);
                let error = ((variance + with_less) / 60_000.0).sqrt();
                assert!((mean - with_events).abs() < 4.0 * error, "{mean}, {with_events} +- {error} at {at_m}");
                assert!(with_less < 0.5 * variance, "{with_less} of {variance} at {at_m}");
            }
        }
    }
}
