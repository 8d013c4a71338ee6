//! Samples: what one ray each brings to points all over a leaf.

use glam::{DVec2, Vec3};

use crate::id::{FaceId, PatchId};
use crate::mesh::Mesh;
use crate::prepare::Prepared;
use crate::texels::{Draws, Ray, RayTree, Sequence, Sources, Start, TexelRadiosity, key_of, point_of};
use crate::visibility::Visibility;

/// What a ray meets nearer than so many texels is looked at closely where direct light varies: its texel is too coarse.
const CLOSE_OF_TEXEL: f64 = 2.0;
/// Uses of random numbers.
const OF_SAMPLES: u64 = 5;
const OF_CLOSE_LIGHT: u64 = 6;

/// What one ray brings.
#[derive(Clone, Copy, Debug)]
pub(super) struct Sample {
    /// Where it starts, in the frame of the face, in metres.
    pub(super) at_m: [f32; 2],
    /// The radiosity that it meets, in W/m2: its mean over many is the irradiance.
    pub(super) light: Vec3,
    /// One over the distance of that, in 1/m; 0 where it meets nothing.
    pub(super) nearness: f32,
    /// Its direction as a place in the unit square, in shares of 65,536.
    pub(super) direction: [u16; 2],
}

impl Sample {
    /// Where it starts, in the frame of the face, in metres.
    pub(super) fn at(&self) -> DVec2 {
        self.at_m.map(f64::from).into()
    }

    /// The number of its class, of `side` times `side` equally probable ones of directions.
    pub(super) fn class(&self, side: usize) -> usize {
        let [s, t] = self.direction.map(|share| (usize::from(share) * side) >> 16);
        s + side * t
    }
}

/// What samples gather from.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Gathering<'a> {
    pub(crate) prepared: &'a Prepared,
    pub(crate) visibility: &'a Visibility,
    pub(crate) tree: &'a RayTree,
    pub(crate) sources: &'a Sources<'a>,
    pub(crate) light: &'a TexelRadiosity,
}

impl Gathering<'_> {
    /// Adds `count` samples of a leaf, of which `drawn` were drawn before.
    pub(super) fn draw(&self, mesh: &Mesh, leaf: PatchId, drawn: usize, count: usize, samples: &mut Vec<Sample>) {
        let face = mesh.patch(leaf).face;
        let (frame, polygon) = (mesh.frame(face), mesh.polygon_2d_m(leaf));
        let key = key_of(leaf.index(), OF_SAMPLES);
        let sequence = Sequence::new(key);
        let is_smooth = self.prepared.is_smooth(face);
        let flat = (!is_smooth).then(|| Start::new(self.prepared, self.tree, face, mesh.patch(leaf).centroid_m));
        samples.reserve_exact(count);
        for number in drawn..drawn + count {
            let [s, t, u, v] = sequence.at(number);
            let at_m = point_of(&polygon, s.into(), t.into());
            let point_m = frame.to_3d(at_m);
            // On a plane face all starts are alike but for their place.
            let start = match flat {
                Some(flat) => flat.moved_to(self.tree, point_m),
                None => Start::new(self.prepared, self.tree, face, point_m),
            };
            let mut draws = Draws::new(key_of(number, OF_CLOSE_LIGHT) ^ key);
            // From a closed gap nothing is seen: rays start beyond what covers it.
            let (light, nearness) = match self.visibility.is_covered(&start.receiver) {
                true => (Vec3::ZERO, 0.0),
                false => self.along(&start, u, v, &mut draws),
            };
            let direction = [u, v].map(|share| (share * 65_536.0) as u16);
            samples.push(Sample { at_m: at_m.as_vec2().to_array(), light, nearness, direction });
        }
    }

    /// What a ray brings, and one over its length.
    fn along(&self, start: &Start, u: f32, v: f32, draws: &mut Draws) -> (Vec3, f32) {
        let ray = Ray { from: start.from, along: start.direction(u, v) };
        let Some(hit) = self.tree.first(ray) else { return (Vec3::ZERO, 0.0) };
        let nearness = hit.distance_m.recip();
        let Some(face) = hit.front else { return (Vec3::ZERO, nearness) };
        let point = ray.from + hit.distance_m * ray.along;
        let texel = self.light.grid.texel_at(face, point);
        let is_close = f64::from(hit.distance_m) < CLOSE_OF_TEXEL * self.light.grid.side_m();
        if is_close && self.light.rough[texel] {
            return (self.close_light(face, texel, point, draws), nearness);
        }
        (self.light.reflected[texel], nearness)
    }

    /// What a point reflects, from direct light of its own.
    fn close_light(&self, face: FaceId, texel: usize, point: Vec3, draws: &mut Draws) -> Vec3 {
        let start = Start::new(self.prepared, self.tree, face, point.as_dvec3());
        let direct = self.sources.irradiance_from_one(&start, || draws.next()).as_vec3();
        self.light.reflectance[face] * (direct + self.light.indirect[texel])
    }
}
