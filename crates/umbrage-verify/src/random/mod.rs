//! Random scenes that are hard for a baker, to be judged by paths of light.
//!
//! A scene is a list of *parts*: its polygons, then its lamps, each with a number. A part can be left out, so that a scene that
//! fails can be [`reduce`]d to the few parts that make it fail.
//!
//! ```text
//! numbers -> shapes (one thing of a few polygons) -> room (things that stand, lean, touch, overlap) -> lights -> RandomScene
//! ```
//!
//! Holds: a seed and a [`Size`] always make the same scene; every scene is valid but for a lamp's cones, of which the inner may
//! be as wide as the outer.

mod degenerate;
mod lights;
mod numbers;
mod reduce;
mod room;
mod shapes;

use std::collections::BTreeSet;

use glam::DVec3;
use umbrage::id::NodeId;
use umbrage::scene::{Lamp, Material, Node, Scene, Surface};

pub use reduce::reduce;

use numbers::Numbers;
use shapes::Thing;

/// How large random scenes may be.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Size {
    /// Things of one or more polygons, at most.
    pub things: usize,
    /// Lamps without extent, at most.
    pub lamps: usize,
}

impl Default for Size {
    fn default() -> Self {
        Self { things: 40, lamps: 40 }
    }
}

/// A random scene in parts.
#[derive(Clone, Debug)]
pub struct RandomScene {
    things: Vec<Thing>,
    lamps: Vec<Lamp>,
    /// What is in it that often goes wrong, in words, sorted.
    pub traits: BTreeSet<&'static str>,
}

impl RandomScene {
    /// Makes the scene of a seed.
    pub fn new(seed: u64, size: Size) -> Self {
        let mut numbers = Numbers::new(seed);
        let mut traits = BTreeSet::new();
        let mut things = room::things(&mut numbers, size.things, &mut traits);
        let mut lamps = lights::lamps(&mut numbers, size.lamps, &mut things, &mut traits);
        place_in_world(&mut numbers, &mut things, &mut lamps, &mut traits);
        Self { things, lamps, traits }
    }

    /// Makes the tiny degenerate scene of a seed, whose light no path tracer tells for sure.
    pub fn degenerate(seed: u64) -> Self {
        let (mut numbers, mut traits) = (Numbers::new(seed), BTreeSet::new());
        let (things, lamps) = degenerate::things(&mut numbers, &mut traits);
        Self { things, lamps, traits }
    }

    /// Whether its things are far enough apart, where they do not touch, for a baker to tell them apart.
    pub fn is_distinct(&self) -> bool {
        !self.traits.contains("gap of a hair")
    }

    /// Number of its parts: polygons and lamps.
    pub fn part_count(&self) -> usize {
        self.things.iter().map(|thing| thing.polygons.len()).sum::<usize>() + self.lamps.len()
    }

    /// The parts of each thing, and of each lamp.
    pub fn groups(&self) -> Vec<Vec<usize>> {
        let sizes = self.things.iter().map(|thing| thing.polygons.len()).chain(self.lamps.iter().map(|_| 1));
        let mut next = 0..;
        sizes.map(|size| next.by_ref().take(size).collect()).collect()
    }

    /// The scene of those parts for which `keep` holds.
    pub fn scene(&self, keep: impl Fn(usize) -> bool) -> Scene {
        let mut scene = Scene { name: "random".into(), ..Scene::default() };
        scene.nodes.push(Node { name: Some("random".into()), ..Node::default() });
        let mut part = 0;
        for (number, thing) in self.things.iter().enumerate() {
            let material = Material { name: format!("{} {number}", thing.name), ..thing.material.clone() };
            let parts = part..;
            part += thing.polygons.len();
            let kept = thing.polygons.iter().zip(parts).filter(|&(_, part)| keep(part));
            let polygons: Vec<Vec<u32>> = kept.map(|(polygon, _)| polygon.clone()).collect();
            if polygons.is_empty() {
                continue;
            }
            let material = scene.materials.push_and_get_key(material);
            scene.surfaces.push(Surface {
                positions_m: thing.positions_m.clone(),
                normals: thing.normals.clone(),
                polygons,
                ..Surface::new(NodeId::from(0), material)
            });
        }
        scene.lamps.extend(self.lamps.iter().zip(part..).filter(|&(_, part)| keep(part)).map(|(lamp, _)| lamp.clone()));
        scene
    }
}

/// Moves a scene far from the origin or to another unit, now and then.
fn place_in_world(
    numbers: &mut Numbers,
    things: &mut [Thing],
    lamps: &mut [Lamp],
    traits: &mut BTreeSet<&'static str>,
) {
    let scale = match numbers.below(10) {
        0 => 0.01,
        1 => 100.0,
        _ => 1.0,
    };
    if scale != 1.0 {
        traits.insert(if scale < 1.0 { "small unit" } else { "big unit" });
    }
    let mut origin_m = DVec3::ZERO;
    if numbers.chance(0.1) {
        traits.insert("far from the origin");
        // Not farther: the check itself is in `f32` where it looks for what is near.
        origin_m = scale * numbers.log_between(10.0, 300.0) * numbers.direction();
    }
    let place = |p: DVec3| origin_m + scale * p;
    for thing in things {
        thing.positions_m.iter_mut().for_each(|p| *p = place(*p));
    }
    for lamp in lamps {
        // Light that falls on a surface stays what it was.
        *lamp = lights::brighter(lamp.clone().moved(place, |direction| direction, scale), scale * scale);
    }
}

#[cfg(test)]
mod tests {
    use umbrage::scene::SceneError;

    use super::*;

    #[test]
    fn scenes_are_valid_the_same_every_time_and_of_all_kinds() {
        let mut traits = BTreeSet::new();
        for seed in 0..400 {
            let random = RandomScene::new(seed, Size::default());
            let scene = random.scene(|_| true);
            assert_eq!(scene, RandomScene::new(seed, Size::default()).scene(|_| true));
            match scene.validate() {
                Ok(()) => {}
                Err(SceneError::BadLamp { .. }) if random.traits.contains("hard spot") => {}
                Err(error) => panic!("seed {seed}: {error}"),
            }
            assert_eq!(random.groups().concat(), (0..random.part_count()).collect::<Vec<_>>());
            assert_eq!(scene.polygon_count() + scene.lamps.len(), random.part_count());
            traits.extend(random.traits);
        }
        assert_eq!(traits.len(), 25, "{traits:?}");
    }

    #[test]
    fn degenerate_scenes_are_valid_tiny_and_of_all_kinds() {
        let mut traits = BTreeSet::new();
        for seed in 0..400 {
            let random = RandomScene::degenerate(seed);
            let scene = random.scene(|_| true);
            assert_eq!(scene.validate(), Ok(()), "seed {seed}");
            assert!(scene.polygon_count() <= 16 && scene.lamps.len() <= 2);
            traits.extend(random.traits);
        }
        assert_eq!(traits.len(), 13, "{traits:?}");
    }

    #[test]
    fn parts_can_be_left_out() {
        let random = RandomScene::new(3, Size::default());
        let last = random.part_count() - 1;
        let scene = random.scene(|part| part == 0 || part == last);
        assert_eq!(scene.polygon_count() + scene.lamps.len(), 2);
    }
}
