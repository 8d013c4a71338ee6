//! Which emitters cast d-segments where they are many: the brightest, as many as there is time for.
//!
//! Pairs of features go with the emitters times the edges of the scene: three thousand small emitters among each other are a quarter of a
//! billion. Each of them brings a three-thousandth of the light, and so do its shadows, which refinement finds where they can be seen.
//!
//! Holds: light does not depend on it, only where the mesh is cut; a few emitters always cast all their lines.

use crate::id::EmitterId;

use super::Features;
use super::emitter::Emitter;

/// So many emitters, the brightest by power, always cast lines.
const ALWAYS: usize = 32;
/// Further ones do as long as all have no more than so many pairs of a corner and an edge of the scene. A pair takes about ten
/// microseconds with all that belongs to it: this is ten seconds' work.
const MOST_PAIRS: usize = 1_000_000;

/// The features of sources that cast lines, by number.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Casting {
    pub(super) emitters: Vec<EmitterId>,
    pub(super) vertices: Vec<usize>,
    pub(super) edges: Vec<usize>,
}

impl Casting {
    pub(super) fn new(features: &Features) -> Self {
        let sources = &features.sources;
        let power_w = |emitter: &Emitter| emitter.mean_radiance() * emitter.area_m2;
        let mut by_power: Vec<EmitterId> = features.emitters.keys().collect();
        // Of equal power the first: the sort is stable.
        by_power.sort_by(|&p, &q| power_w(&features.emitters[q]).total_cmp(&power_w(&features.emitters[p])));
        let mut pairs = 0_usize;
        let mut casts = |&(rank, id): &(usize, EmitterId)| {
            pairs = pairs.saturating_add(sources.of_emitter[id].len() * features.occluders.edges.len());
            rank < ALWAYS || pairs <= MOST_PAIRS
        };
        let mut emitters: Vec<EmitterId> =
            by_power.into_iter().enumerate().take_while(|ranked| casts(ranked)).map(|(_, id)| id).collect();
        emitters.sort_unstable();
        let casts = |id: &EmitterId| emitters.binary_search(id).is_ok();
        let edge_casts = |edge: &usize| sources.edges[*edge].emitters.iter().any(casts);
        let edges: Vec<usize> = (0..sources.edges.len()).filter(edge_casts).collect();
        let vertex_casts = |vertex: &usize| sources.vertices[*vertex].edges.iter().any(edge_casts);
        let vertices = (0..sources.vertices.len()).filter(vertex_casts).collect();
        Self { emitters, vertices, edges }
    }
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::*;
    use crate::scene::{Material, Rgb};
    use crate::visibility::fixture;

    /// The features of so many small lamps, the last of which is the largest, over as many plates.
    fn features(lamps: usize, plates: usize) -> Features {
        let row =
            |i: usize, half: f64, height: f64| fixture::square(DVec3::new(i as f64, 0.0, height), half, height < 1.5);
        let plate = |i: usize| (row(i, 0.3, 1.0), 0);
        let lamp = |i: usize| (row(i, if i + 1 == lamps { 0.2 } else { 0.1 }, 2.0), 1);
        let polygons: Vec<_> = (0..plates).map(plate).chain((0..lamps).map(lamp)).collect();
        let materials = vec![Material::diffuse("grey", Rgb::splat(0.5)), Material::emitting("light", Rgb::ONE)];
        Features::new(&fixture::scene(materials), &fixture::prepared_of_materials(&polygons))
    }

    #[test]
    fn a_few_emitters_all_cast_lines_and_of_thousands_the_brightest() {
        let few = Casting::new(&features(20, 20));
        assert_eq!([few.emitters.len(), few.edges.len(), few.vertices.len()], [20, 80, 80]);
        let features = features(600, 600);
        let many = Casting::new(&features);
        // Four corners of each, and 4,800 edges.
        assert_eq!(many.emitters.len(), MOST_PAIRS / 4 / 4800);
        assert_eq!(many.edges.len(), 4 * many.emitters.len());
        let largest = features.emitters.iter_enumerated().max_by(|p, q| p.1.area_m2.total_cmp(&q.1.area_m2)).unwrap().0;
        assert!(many.emitters.contains(&largest));
    }
}
