//! Finds all d-segments of a scene: the preprocessing step of the meshing algorithm (paper, section 4).
//!
//! Every feature of a source is paired with every feature of an occluder; most pairs are dismissed by a look at their
//! own geometry, the others are traced. Pairs are numbered and dealt out in equal parts, traced in parallel, and what
//! they find is gathered in the order of their numbers, so that the result does not depend on threads.

use std::sync::atomic::{AtomicUsize, Ordering};

use glam::DVec3;
use rayon::prelude::*;

use super::casting::Casting;
use super::features::Surroundings;
use super::light_met::mean_irradiance;
use super::strength::effect;
use super::{DSegment, Emitter, Event, Features, closed_gap, contact};
use crate::id::{DSegmentId, EmitterId, FaceId, LampId, PlaneId, Table};
use crate::prepare::Prepared;
use crate::progress::{Cancelled, Progress, Stage};
use crate::scene::Scene;
use crate::visibility::Visibility;

/// Pairs that are traced between two reports of progress: as few as make so many parts, within bounds. A pair of an emitter and an edge
/// that stands for many triples may take milliseconds, one of a corner and an edge takes less than a microsecond.
const PARTS: usize = 16_384;
const PAIRS_A_PART: [usize; 2] = [32, 4096];

/// d-segments that change irradiance by less than asked, but no less than this share of it, are kept apart: a tenth of the mean light is
/// the most that is dim, and a thousandth the least that is looked at. A scene of a thousand polygons has half as many of them again.
const OF_DIM_PLACES: f64 = 1e-2;

/// Emitters and d-segments of a scene.
#[derive(Clone, Debug, Default)]
pub struct Discontinuities {
    /// The emitters.
    pub emitters: Table<EmitterId, Emitter>,
    /// The d-segments, by face and event.
    pub segments: Table<DSegmentId, DSegment>,
    /// Those that are too weak to be among them, and not `OF_DIM_PLACES` times as weak: they count where light is dim.
    pub faint: Vec<DSegment>,
    /// How many wedges were traced.
    pub wedges: usize,
    /// About the mean irradiance of all faces, in W/m2; light of distant lamps counts for nothing.
    pub mean_irradiance: f64,
}

impl Discontinuities {
    /// Number of d-segments of degree 0, 1 and 2.
    pub fn count_by_degree(&self) -> [usize; 3] {
        let mut count = [0; 3];
        self.segments.iter().for_each(|segment| count[segment.degree.number()] += 1);
        count
    }
}

impl Discontinuities {
    /// Returns the faint d-segments that change irradiance by at least `least` at their face and middle, in W/m2.
    pub fn faint_that_count<'a>(
        &'a self,
        prepared: &'a Prepared,
        visibility: &'a Visibility,
        least: impl Fn(FaceId, DVec3) -> f64 + 'a,
    ) -> impl Iterator<Item = &'a DSegment> {
        self.faint.iter().filter(move |segment| {
            let middle_m = segment.ends_m[0].midpoint(segment.ends_m[1]);
            effect(prepared, visibility, segment) >= least(segment.face, middle_m)
        })
    }
}

/// Calculates all discontinuity segments, but for those that change irradiance by less than `least_share` of its mean
/// over the width of their face: nothing would be seen of them. 0 keeps all, and those of degree 0 are always kept.
///
/// # Errors
/// [`Cancelled`] where the progress callback asks to stop.
pub fn find(
    scene: &Scene,
    prepared: &Prepared,
    visibility: &Visibility,
    least_share: f64,
    progress: Progress<'_>,
) -> Result<Discontinuities, Cancelled> {
    let features = Features::new(scene, prepared);
    let mean_irradiance = mean_irradiance(prepared, visibility, &features);
    let least = least_share * mean_irradiance;
    let (traced, wedges) = traced(prepared, visibility, &features, Kinds::All, OF_DIM_PLACES * least, progress)?;
    let around = Surroundings { prepared, visibility, features: &features, wedges: &AtomicUsize::new(0) };
    let (mut segments, mut faint): (Vec<_>, Vec<_>) =
        traced.into_iter().partition(|segment| around.counts(segment, least));
    let mut contacts = contact::contacts(prepared, |face: FaceId| features.receives[face]);
    contacts.extend(closed_gap::contacts(prepared, visibility, |face: FaceId| features.receives[face]));
    segments.extend(contacts.into_iter().map(|segment| with_strength(&around, segment)));
    segments.par_sort_by(DSegment::by_face_and_event);
    faint.par_sort_by(DSegment::by_face_and_event);
    Ok(Discontinuities { emitters: features.emitters, segments: segments.into(), faint, wedges, mean_irradiance })
}

/// Of discontinuities that were found with a lesser share, those that [`find`] finds with `least_share`.
pub fn at_least(
    scene: &Scene,
    prepared: &Prepared,
    visibility: &Visibility,
    found: &Discontinuities,
    least_share: f64,
) -> Discontinuities {
    let features = Features::new(scene, prepared);
    let least = least_share * found.mean_irradiance;
    let around = Surroundings { prepared, visibility, features: &features, wedges: &AtomicUsize::new(0) };
    let counts = |segment: &DSegment| matches!(segment.event, Event::Contact { .. }) || around.counts(segment, least);
    let (segments, mut faint): (Vec<DSegment>, Vec<DSegment>) = found.segments.iter().copied().partition(counts);
    let is_faint = |segment: &DSegment| around.counts(segment, OF_DIM_PLACES * least);
    faint.extend(&found.faint);
    faint.retain(is_faint);
    faint.par_sort_by(DSegment::by_face_and_event);
    Discontinuities { segments: segments.into(), faint, ..found.clone() }
}

/// Which events are traced.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Kinds {
    /// All that there are.
    All,
    /// All but those of three edges: the faintest, and the ones whose number grows fastest with that of the edges.
    OfTwoFeatures,
}

/// The d-segments of all pairs of features that change irradiance by at least `least`, in W/m2, over the width of their
/// face; and how many wedges were traced.
pub(super) fn traced(
    prepared: &Prepared,
    visibility: &Visibility,
    features: &Features,
    kinds: Kinds,
    least: f64,
    progress: Progress<'_>,
) -> Result<(Vec<DSegment>, usize), Cancelled> {
    let around = Surroundings { prepared, visibility, features, wedges: &AtomicUsize::new(0) };
    let pairs = Pairs::new(&around, kinds);
    let of_part = (pairs.count() / PARTS).clamp(PAIRS_A_PART[0], PAIRS_A_PART[1]);
    let parts = pairs.count().div_ceil(of_part);
    let done = AtomicUsize::new(0);
    let found: Vec<Vec<DSegment>> = (0..parts)
        .into_par_iter()
        .map(|part| {
            progress.report(Stage::Discontinuity, done.fetch_add(1, Ordering::Relaxed), parts)?;
            let numbers = part * of_part..((part + 1) * of_part).min(pairs.count());
            let segments = numbers.flat_map(|number| pairs.trace(number, &around));
            Ok(segments
                .map(|segment| with_strength(&around, segment))
                .filter(|segment| around.counts(segment, least))
                .collect())
        })
        .collect::<Result<_, Cancelled>>()?;
    Ok((found.into_iter().flatten().collect(), around.wedges.load(Ordering::Relaxed)))
}

fn with_strength(around: &Surroundings<'_>, segment: DSegment) -> DSegment {
    let strength = around.jump(&segment, segment.ends_m[0].midpoint(segment.ends_m[1]));
    DSegment { strength, ..segment }
}

/// All pairs of a source feature and an occluder feature, numbered: first all VE, then all EV, and so on.
struct Pairs<'a> {
    prepared: &'a Prepared,
    features: &'a Features,
    casting: Casting,
    /// Of three edges, the most that one pair may stand for.
    most_triples: usize,
    /// Where the numbers of each kind end.
    ends: [usize; 8],
}

impl<'a> Pairs<'a> {
    fn new(around: &Surroundings<'a>, kinds: Kinds) -> Self {
        let Surroundings { prepared, features, .. } = *around;
        let (edges, vertices) = (features.occluders.edges.len(), features.occluders.vertices.len());
        let casting = Casting::new(features);
        let counts = [
            casting.vertices.len() * edges,
            casting.edges.len() * vertices,
            casting.edges.len() * edges,
            casting.emitters.len() * prepared.planes.len(),
            casting.emitters.len(),
            features.lamps.len() * edges,
            features.lamps.len() * prepared.faces.len(),
            if kinds == Kinds::All { casting.emitters.len() * edges } else { 0 },
        ];
        let mut end = 0;
        let ends = counts.map(|count| {
            end += count;
            end
        });
        let most_triples = if kinds == Kinds::All { around.most_triples(&casting.emitters) } else { 0 };
        Self { prepared, features, casting, most_triples, ends }
    }

    fn count(&self) -> usize {
        self.ends[7]
    }

    fn trace(&self, number: usize, around: &Surroundings<'_>) -> Vec<DSegment> {
        let Features { sources, occluders, .. } = self.features;
        let Casting { emitters, vertices, edges } = &self.casting;
        let kind = self.ends.iter().take_while(|&&end| end <= number).count();
        let number = if kind == 0 { number } else { number - self.ends[kind - 1] };
        let pair = |count: usize| (number / count, number % count);
        match kind {
            0 => {
                let (source, occluder) = pair(occluders.edges.len());
                around.vertex_edge(&sources.vertices[vertices[source]], &occluders.edges[occluder])
            }
            1 => {
                let (source, occluder) = pair(occluders.vertices.len());
                around.edge_vertex(&sources.edges[edges[source]], occluders.vertices[occluder])
            }
            2 => {
                let (source, occluder) = pair(occluders.edges.len());
                around.edge_edge(&sources.edges[edges[source]], &occluders.edges[occluder])
            }
            3 => {
                let (source, occluder) = pair(self.prepared.planes.len());
                around.occluder_plane(emitters[source], PlaneId::from(occluder))
            }
            4 => around.source_plane(emitters[number]),
            5 => {
                let (lamp, occluder) = pair(occluders.edges.len());
                around.lamp_edge(LampId::from(lamp), &occluders.edges[occluder])
            }
            6 => {
                let (lamp, face) = pair(self.prepared.faces.len());
                around.lamp_curves(LampId::from(lamp), FaceId::from(face))
            }
            _ => {
                let (source, occluder) = pair(occluders.edges.len());
                around.three_edges(emitters[source], &occluders.edges[occluder], self.most_triples)
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::Degree;
    use super::*;
    use crate::id::VertexId;
    use crate::scene::{Material, Rgb};
    use crate::visibility::fixture;
    use glam::DVec3;

    /// d-segments of grey polygons under lights, which come last.
    fn find_in(grey: &[Vec<DVec3>], lights: &[Vec<DVec3>]) -> (Prepared, Discontinuities) {
        let all: Vec<_> = grey.iter().map(|p| (p.clone(), 0)).chain(lights.iter().map(|p| (p.clone(), 1))).collect();
        let prepared = fixture::prepared_of_materials(&all);
        let materials = vec![Material::diffuse("grey", Rgb::splat(0.5)), Material::emitting("light", Rgb::ONE)];
        let scene = Scene { materials: materials.into(), ..Scene::default() };
        let visibility = Visibility::new(&prepared);
        let found = find(&scene, &prepared, &visibility, 0.0, Progress::silent()).unwrap();
        (prepared, found)
    }

    fn square(middle: DVec3, half: f64, turn_rad: f64, up: bool) -> Vec<DVec3> {
        let (u, v) =
            (DVec3::new(turn_rad.cos(), turn_rad.sin(), 0.0), DVec3::new(-turn_rad.sin(), turn_rad.cos(), 0.0));
        let mut corners = [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)]
            .map(|(x, y)| fixture::f32_point(middle + half * (x * u + y * v)))
            .to_vec();
        if !up {
            corners.reverse();
        }
        corners
    }

    fn floor() -> Vec<DVec3> {
        square(DVec3::ZERO, 3.0, 0.0, true)
    }

    fn on_floor(found: &Discontinuities) -> Vec<&DSegment> {
        found.segments.iter().filter(|segment| segment.face == FaceId::from(0)).collect()
    }

    /// The line through a segment in the plane z = 0: unit normal and offset, in one canonical direction.
    fn line(segment: &DSegment) -> (f64, f64, f64) {
        let [p, q] = segment.ends_m.map(DVec3::truncate);
        let n = (q - p).perp().normalize();
        let n = if n.x < -1e-9 || (n.x.abs() < 1e-9 && n.y < 0.0) { -n } else { n };
        (n.x, n.y, n.dot(p))
    }

    #[test]
    fn fig_2_an_edge_vertex_event_falls_where_the_plane_of_both_meets_the_receiver() {
        // One corner of a turned plate between one edge of the light and the floor.
        let plate = square(DVec3::Z, 0.5, 0.4, true);
        let light = square(DVec3::Z * 2.0, 0.5, 0.0, false);
        let (prepared, found) = find_in(&[floor(), plate], &[light]);
        let mut events = 0;
        for segment in on_floor(&found) {
            let Event::EdgeVertex { source, occluder, .. } = segment.event else { continue };
            events += 1;
            assert_eq!(segment.degree, Degree::D2);
            let [p, q] = prepared.edges[source].ends.map(|v| prepared.vertices_m[v]);
            let apex = prepared.vertices_m[occluder];
            // Light at height 2, plate at 1: the floor is as far behind the vertex as the light before it.
            let expected = [p, q].map(|source| 2.0 * apex - source);
            for end in segment.ends_m {
                let along = expected[1] - expected[0];
                let t = (end - expected[0]).dot(along) / along.length_squared();
                assert!((-1e-9..=1.0 + 1e-9).contains(&t), "inside the pencil: {t}");
                assert!(end.distance(expected[0] + t * along) < 1e-6, "{end} is not on the line of {expected:?}");
            }
        }
        assert_eq!(events, 16, "four edges of the light, four corners of the plate");
    }

    #[test]
    fn a_parallel_plate_casts_umbra_and_penumbra_lines_of_degree_1_alone() {
        let (_, found) =
            find_in(&[floor(), square(DVec3::Z, 0.5, 0.0, true)], &[square(DVec3::Z * 2.0, 0.5, 0.0, false)]);
        let segments = on_floor(&found);
        assert!(segments.iter().all(|segment| segment.degree == Degree::D1));
        let mut offsets: Vec<_> = segments.iter().map(|s| (line(s).2.abs() * 1e6).round() / 1e6).collect();
        offsets.sort_by(f64::total_cmp);
        offsets.dedup();
        assert_eq!(offsets, [0.5, 1.5]);
        assert_eq!(segments.len(), 8, "EV and VE of coplanar edges are merged: {segments:#?}");
        assert!(
            segments
                .iter()
                .all(|segment| (segment.length_m() - 3.0).abs() < 1e-6 || (segment.length_m() - 1.0).abs() < 1e-6)
        );
    }

    #[test]
    fn a_turned_plate_casts_vertex_edge_lines_too() {
        let (_, found) =
            find_in(&[floor(), square(DVec3::Z, 0.5, 0.4, true)], &[square(DVec3::Z * 2.0, 0.5, 0.0, false)]);
        let segments = on_floor(&found);
        let vertex_edge = segments.iter().filter(|s| matches!(s.event, Event::VertexEdge { .. })).count();
        assert_eq!((segments.len(), vertex_edge), (32, 16));
    }

    #[test]
    fn what_is_left_of_all_is_what_is_found_of_the_strong_ones() {
        let all = [floor(), square(DVec3::Z, 0.5, 0.4, true), square(DVec3::Z * 0.1, 0.2, 0.7, true)].map(|p| (p, 0));
        let light = (square(DVec3::Z * 2.0, 0.5, 0.0, false), 1);
        let prepared = fixture::prepared_of_materials(&[&all[..], &[light]].concat());
        let materials = vec![Material::diffuse("grey", Rgb::splat(0.5)), Material::emitting("light", Rgb::ONE)];
        let scene = Scene { materials: materials.into(), ..Scene::default() };
        let visibility = Visibility::new(&prepared);
        let found = |share| find(&scene, &prepared, &visibility, share, Progress::silent()).unwrap();
        let (whole, counts) = (
            found(1e-3),
            [1e-3, 0.1, 10.0, 1e3].map(|share| {
                let strong = found(share).segments;
                let left = at_least(&scene, &prepared, &visibility, &found(1e-3), share).segments;
                assert_eq!(left.iter().collect::<Vec<_>>(), strong.iter().collect::<Vec<_>>());
                strong.len()
            }),
        );
        assert!(counts[0] == whole.segments.len() && counts[3] < counts[0], "{counts:?}");
    }

    #[test]
    fn what_a_second_plate_hides_casts_nothing() {
        let low = square(DVec3::Z * 0.5, 0.2, 0.4, true);
        let screen = square(DVec3::Z * 1.5, 2.5, 0.0, true);
        let light = square(DVec3::Z * 2.0, 0.1, 0.0, false);
        let (prepared, found) = find_in(&[floor(), low, screen], &[light]);
        let low_vertices: Vec<VertexId> = prepared.boundary(FaceId::from(1)).collect();
        let from_low = on_floor(&found).into_iter().filter(|segment| match segment.event {
            Event::EdgeVertex { occluder, .. } => low_vertices.contains(&occluder),
            Event::VertexEdge { occluder, .. } | Event::EdgeEdge { occluder, .. } => {
                prepared.edges[occluder].ends.iter().all(|end| low_vertices.contains(end))
            }
            _ => false,
        });
        assert_eq!(from_low.count(), 0);
    }

    #[test]
    fn only_the_silhouette_of_a_box_casts() {
        // Seen from a light right above, the lower edges of a box are no silhouette, the upper ones are.
        let block = fixture::outward_box(DVec3::new(-0.5, -0.5, 0.5), DVec3::new(0.5, 0.5, 1.0));
        let mut grey = vec![floor()];
        grey.extend(block);
        let (prepared, found) = find_in(&grey, &[square(DVec3::Z * 3.0, 0.1, 0.3, false)]);
        for segment in on_floor(&found) {
            let height = match segment.event {
                Event::VertexEdge { occluder, .. } => {
                    prepared.edges[occluder].ends.map(|v| prepared.vertices_m[v].z).into_iter().fold(0.0, f64::max)
                }
                Event::EdgeVertex { occluder, .. } => prepared.vertices_m[occluder].z,
                _ => continue,
            };
            assert_eq!(height, 1.0, "{segment:?}");
        }
        assert_eq!(on_floor(&found).len(), 32);
    }

    #[test]
    fn the_plane_of_a_light_below_the_ceiling_cuts_the_walls() {
        let room = fixture::inward_box(DVec3::new(-2.0, -2.0, 0.0), DVec3::new(2.0, 2.0, 3.0));
        let (_, found) = find_in(&room, &[square(DVec3::Z * 2.0, 0.3, 0.0, false)]);
        let walls: Vec<_> = found.segments.iter().filter(|s| matches!(s.event, Event::SourcePlane { .. })).collect();
        assert_eq!(walls.len(), 4);
        for segment in walls {
            assert!(segment.ends_m.iter().all(|end| (end.z - 2.0).abs() < 1e-6));
            assert!((segment.length_m() - 4.0).abs() < 1e-5, "{segment:?}");
            assert_eq!(segment.degree, Degree::D1);
        }
    }

    #[test]
    fn lamps_cast_shadows_of_degree_0_where_they_fall() {
        use crate::scene::{Lamp, LampKind};
        let polygons = [floor(), square(DVec3::Z, 0.5, 0.0, true)];
        let prepared = fixture::prepared(&polygons);
        let visibility = Visibility::new(&prepared);
        let cast = |kind: LampKind| {
            let mut scene = fixture::scene(vec![Material::diffuse("grey", Rgb::splat(0.5))]);
            scene.lamps.push(Lamp { name: String::new(), kind });
            let found = find(&scene, &prepared, &visibility, 0.0, Progress::silent()).unwrap();
            let mut lines: Vec<_> = on_floor(&found)
                .into_iter()
                .map(|segment| {
                    assert_eq!(segment.degree, Degree::D0);
                    let (x, y, offset) = line(segment);
                    [x, y, offset, segment.length_m()].map(|v| (v * 1e9).round() / 1e9 + 0.0)
                })
                .collect();
            lines.sort_by(|p, q| p.partial_cmp(q).unwrap());
            lines
        };
        // From twice the plate's height its shadow is twice as large.
        let point = LampKind::Point { position_m: DVec3::Z * 2.0, intensity: Rgb::ONE, range_m: None };
        assert_eq!(
            cast(point),
            [[0.0, 1.0, -1.0, 2.0], [0.0, 1.0, 1.0, 2.0], [1.0, 0.0, -1.0, 2.0], [1.0, 0.0, 1.0, 2.0]]
        );
        // Light that goes 3 to the side while it falls by 4 moves it by 0.75 and leaves its size.
        let sun = LampKind::Directional { direction: DVec3::new(0.6, 0.0, -0.8), irradiance: Rgb::ONE };
        assert_eq!(
            cast(sun),
            [[0.0, 1.0, -0.5, 1.0], [0.0, 1.0, 0.5, 1.0], [1.0, 0.0, 0.25, 1.0], [1.0, 0.0, 1.25, 1.0]]
        );
        // From below the floor's front is dark.
        assert!(cast(LampKind::Point { position_m: DVec3::NEG_Z, intensity: Rgb::ONE, range_m: None }).is_empty());
    }

    #[test]
    fn the_same_segments_come_from_one_and_two_threads() {
        let find_with = |threads: usize| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            pool.install(|| {
                let plate = square(DVec3::Z, 0.5, 0.4, true);
                find_in(&[floor(), plate], &[square(DVec3::Z * 2.0, 0.5, 0.0, false)]).1.segments
            })
        };
        assert_eq!(find_with(1), find_with(2));
    }

    #[test]
    fn weak_segments_are_left_out_and_the_others_stay_as_they_are() {
        let plate = square(DVec3::Z, 0.5, 0.4, true);
        let light = square(DVec3::Z * 2.0, 0.5, 0.0, false);
        let all: Vec<_> = [(floor(), 0), (plate, 0), (light, 1)].to_vec();
        let prepared = fixture::prepared_of_materials(&all);
        let materials = vec![Material::diffuse("grey", Rgb::splat(0.5)), Material::emitting("light", Rgb::ONE)];
        let scene = Scene { materials: materials.into(), ..Scene::default() };
        let visibility = Visibility::new(&prepared);
        let found = |least_share: f64| {
            find(&scene, &prepared, &visibility, least_share, Progress::silent()).unwrap().segments.raw
        };
        let all = found(0.0);
        let shares = (-10..10).map(|exponent| 2f64.powi(exponent));
        let strong = shares.map(found).find(|strong| strong.len() < all.len()).unwrap();
        assert!(!strong.is_empty());
        let weakest = strong.iter().map(|segment| segment.strength).fold(f64::INFINITY, f64::min);
        let on_floor = |segment: &&DSegment| segment.face == FaceId::from(0) && segment.strength > 2.0 * weakest;
        assert!(all.iter().filter(on_floor).all(|segment| strong.contains(segment)));
        assert!(found(f64::INFINITY).is_empty());
    }

    #[test]
    fn a_cancelled_search_stops() {
        let stop = |_| std::ops::ControlFlow::Break(());
        let prepared = fixture::prepared_of_materials(&[(floor(), 0), (square(DVec3::Z, 0.5, 0.0, false), 1)]);
        let materials = vec![Material::diffuse("grey", Rgb::ONE), Material::emitting("light", Rgb::ONE)];
        let scene = Scene { materials: materials.into(), ..Scene::default() };
        let visibility = Visibility::new(&prepared);
        assert_eq!(find(&scene, &prepared, &visibility, 0.0, Progress::new(&stop)).unwrap_err(), Cancelled);
    }
}
