//! Samples: what one ray each brings to points all over a leaf.

use glam::{DVec2, Vec3};

use crate::geometry::polygon;
use crate::id::{FaceId, PatchId};
use crate::mesh::Mesh;
use crate::prepare::Prepared;
use crate::texels::{BrightTexels, Draws, NextEvents, Ray, RayTree, Sequence, Sources, Start, TexelRadiosity, key_of};
use crate::visibility::Visibility;

/// What a ray meets nearer than so many texels is looked at closely where direct light varies: its texel is too coarse.
const CLOSE_OF_TEXEL: f64 = 2.0;
/// Nodes of the tree of bright texels that the next events of a leaf choose from.
const NODES_OF_CUT: usize = 48;
/// For points of the leaf that stand for all, as even numbers.
const POINTS_OF_CUT: [[f64; 2]; 4] = [[0.17, 0.3], [0.42, 0.8], [0.67, 0.2], [0.92, 0.6]];
/// Uses of random numbers.
const OF_SAMPLES: u64 = 5;
const OF_CLOSE_LIGHT: u64 = 6;

/// What one ray brings.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Sample {
    /// Where it starts, in the frame of the face, in metres.
    pub(super) at_m: [f32; 2],
    /// The radiosity that it meets, in W/m2: its mean over many is the irradiance.
    pub(super) light: Vec3,
    /// One over the distance of that, in 1/m; 0 where it meets nothing.
    pub(super) nearness: f32,
    /// Its direction as a place in the unit square, in shares of 65,536.
    pub(super) direction: [u16; 2],
    /// The number that chose its next event, in shares of 65,536.
    pub(super) event: u16,
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

    /// The number of its class, of so many equally probable ones of next events.
    pub(super) fn class_of_event(&self, classes: usize) -> usize {
        (usize::from(self.event) * classes) >> 16
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
    /// Its bright texels, where next events pay.
    pub(crate) bright: Option<&'a BrightTexels>,
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
        let events = self.bright.map(|bright| {
            let point = |[s, t]: [f64; 2]| {
                let point_m = frame.to_3d(polygon::point_of_2d(&polygon, s, t));
                self.tree.start(point_m, self.prepared.normal(face))
            };
            let normal = self.prepared.normal(face).as_vec3();
            bright.events(&POINTS_OF_CUT.map(point), normal, 1.0, NODES_OF_CUT)
        });
        samples.reserve_exact(count);
        for number in drawn..drawn + count {
            let [s, t, u, v] = sequence.at(number);
            let at_m = polygon::point_of_2d(&polygon, s.into(), t.into());
            let point_m = frame.to_3d(at_m);
            // On a plane face all starts are alike but for their place.
            let start = match flat {
                Some(flat) => flat.moved_to(self.tree, point_m),
                None => Start::new(self.prepared, self.tree, face, point_m),
            };
            let mut draws = Draws::new(key_of(number, OF_CLOSE_LIGHT) ^ key);
            // From a closed gap nothing is seen: rays start beyond what covers it.
            let is_covered = self.visibility.is_covered(&start.receiver);
            let (mut light, nearness) = match is_covered {
                true => (Vec3::ZERO, 0.0),
                false => self.along(&start, [u, v], events.as_ref(), &mut draws),
            };
            let mut sample = Sample::default();
            if let Some(events) = events.as_ref().filter(|_| !is_covered) {
                let numbers = sequence.more_at(number);
                sample.event = (numbers[0] * 65_536.0) as u16;
                if let Some(event) = events.draw(self.tree, start.from, start.axes[2], numbers) {
                    light +=
                        event.weight * self.sent(event.face, event.texel, event.point, event.distance_m, &mut draws);
                }
            }
            let direction = [u, v].map(|share| (share * 65_536.0) as u16);
            samples.push(Sample { at_m: at_m.as_vec2().to_array(), light, nearness, direction, ..sample });
        }
    }

    /// What a ray brings, less the share that next events bring in its place, and one over its length.
    fn along(
        &self,
        start: &Start,
        [u, v]: [f32; 2],
        events: Option<&NextEvents<'_>>,
        draws: &mut Draws,
    ) -> (Vec3, f32) {
        let ray = Ray { from: start.from, along: start.direction(u, v) };
        let Some(hit) = self.tree.first(ray) else { return (Vec3::ZERO, 0.0) };
        let nearness = hit.distance_m.recip();
        let Some(face) = hit.front else { return (Vec3::ZERO, nearness) };
        let point = ray.from + hit.distance_m * ray.along;
        let texel = self.light.grid.texel_at(face, point);
        let light = self.sent(face, texel, point, hit.distance_m, draws);
        let of_events = events.map_or(0.0, |events| events.share_of(texel, start.axes[2], ray, hit.distance_m));
        ((1.0 - of_events) * light, nearness)
    }

    /// What a point of a texel reflects, seen from this distance.
    fn sent(&self, face: FaceId, texel: usize, point: Vec3, distance_m: f32, draws: &mut Draws) -> Vec3 {
        let is_close = f64::from(distance_m) < CLOSE_OF_TEXEL * self.light.grid.side_m();
        match is_close && self.light.rough[texel] {
            true => self.close_light(face, texel, point, draws),
            false => self.light.reflected[texel],
        }
    }

    /// What a point reflects, from direct light of its own.
    fn close_light(&self, face: FaceId, texel: usize, point: Vec3, draws: &mut Draws) -> Vec3 {
        let start = Start::new(self.prepared, self.tree, face, point.as_dvec3());
        let direct = self.sources.irradiance_from_one(&start, || draws.next()).as_vec3();
        self.light.reflectance[face] * (direct + self.light.indirect[texel])
    }
}
