//! Display refinement: splits leaves until interpolation of a field over their triangles is within a tolerance.
//!
//! Light decides where, hints decide how: the leaf that errs most is split by `split`, along its d-segments first. What a leaf
//! errs is told by the elements that `point_split` would make of it ([`super::element`]).
//!
//! A leaf that errs much by its own light is split too, though it be too dim to count in the mean. In each round the smallest set of leaves that makes up a share of the error is split, until the root of the mean
//! square error over all receiving sides is within the tolerance times the mean of the field (bulk marking, Dörfler
//! 1996). Points are evaluated in parallel, splits follow in the order of ids.
//!
//! After: values at all boundary points of the leaves are known.

use rayon::prelude::*;

use super::element::{Closer, Element, Outlined};
use super::errors::Errors;
use super::field::{Field, Places, Values};
use super::local_light::negligible;
use crate::id::PatchId;
use crate::mesh::{Attempt, Mesh};
use crate::progress::{Cancelled, Progress, Stage, share_of_way};
use crate::scene::Rgb;
use crate::transport::PlacesOfLeaves;

/// The leaves that make up this share of the squared error are split in a round.
const SHARE_A_ROUND: f64 = 0.6;
/// A round that would split less than this share of the leaves splits so many, so that rounds stay few.
const LEAST_SHARE_OF_LEAVES: f64 = 0.02;
/// Elements larger than this share of all area are looked at in more points before interpolation over them is trusted.
const LARGE_OF_ALL: f64 = 2e-3;
/// No element may err by more than so many tolerances of its own light, besides one tolerance of the mean light, or less in dim places
/// ([`negligible`]): what is dim is little of the mean error, and is looked at all the same.
pub(super) const OWN_TOLERANCES: f64 = 10.0;
/// An error is the harder to see, the smaller its place is. Below this share of all area (a square of 5 pixels where a picture of a
/// megapixel shows all surfaces) an element may err more, as the square root of its size falls: four times as much at 1e-7. With 0, a
/// quarter of the triangles of a toy of smooth parts stood along kinks of a few per cent.
const SEEN_OF_ALL: f64 = 3e-5;
/// Leaves smaller than this share of all area may.
pub(super) const LEAST_OF_ALL: f64 = 1e-7;
/// No leaf is split that has no more area than a square with sides of this share of the scene's extent: a sixteenth of the radius over
/// which light is spread where a lamp touches a surface, and 30 times the size of what input and output round.
const MIN_EDGE_OF_SCENE: f64 = 2.5e-5;
/// Leaves smaller than this share of all area may leak.
const LEAKING_OF_ALL: f64 = 1e-5;
/// Light of more than this share of the mean that is shown where it is exactly dark is a leak.
const LEAK_OF_MEAN: f64 = 1e-3;
/// No refinement needs more rounds: each halves the greatest errors at least, and those at its end look at few leaves.
const MOST_ROUNDS: usize = 100;

/// A split makes no more triangles than this, but for very many faces along one edge: two points in edges between two leaves, or
/// one in each long edge of a badly shaped leaf.
const MOST_OF_A_SPLIT: usize = 16;

/// How a field is interpolated over a triangle.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Interpolation {
    /// From the values at its corners.
    Linear,
    /// From those and the values at the middles of its sides.
    Quadratic,
}

/// When refinement ends.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct RefineSettings {
    /// What the error is of.
    pub(super) interpolation: Interpolation,
    /// Root mean square error over the mean of the field.
    pub(super) tolerance: f64,
    /// The mean irradiance that the tolerance refers to, in W/m2.
    pub(super) mean: f64,
    /// The leaves never are more triangles than this, in the count of [`Mesh::triangle_count`].
    pub(super) max_triangles: usize,
}

/// What refinement leaves.
pub(super) struct Refined {
    /// The field at the points of the mesh.
    pub(super) values: Values,
    /// The elements of each patch that was looked at, by its number.
    pub(super) elements: Vec<Vec<Element>>,
    /// What each value is shifted by to be shown, for linear interpolation.
    pub(super) shifts: Vec<Rgb>,
    /// Estimated root mean square error over the mean.
    pub(super) error: f64,
}

/// Splits the leaves that `receives` admits until the field is interpolated within the tolerance; `known` are values of it that are
/// known.
pub(super) fn refine(
    mesh: &mut Mesh,
    places: &Places<'_>,
    field: &mut impl Field,
    known: Values,
    receives: impl Fn(&Mesh, PatchId) -> bool,
    settings: RefineSettings,
    progress: Progress<'_>,
) -> Result<Refined, Cancelled> {
    let mut refined = Refined { values: known, elements: Vec::new(), shifts: Vec::new(), error: 0.0 };
    let mut errors = Errors::new(settings.interpolation, settings.mean);
    let bright = field.bright_places().to_vec();
    let mut bright = PlacesOfLeaves::new(mesh, &bright);
    let least_m2 = (MIN_EDGE_OF_SCENE * places.extent_m()).powi(2);
    // Boundary points that each patch had when it was looked at.
    let mut points_of: Vec<Option<usize>> = Vec::new();
    // Whether they are too narrow to be split further.
    let mut is_finest: Vec<bool> = Vec::new();
    // Once the mean error is small enough, rounds tell what changed alone; at the end all is told once more.
    let (mut tells_all, mut is_coarse, mut area_m2) = (true, true, 0.0);
    let mut way = Way::default();
    for round in 0..MOST_ROUNDS {
        let progress = progress.part(Stage::Shade, way.next_round());
        points_of.resize(mesh.patch_count(), None);
        is_finest.extend((is_finest.len()..mesh.patch_count()).map(|patch| mesh.is_finest(PatchId::from(patch))));
        refined.elements.resize(mesh.patch_count(), Vec::new());
        let leaves: Vec<PatchId> = mesh.leaves().filter(|&leaf| receives(mesh, leaf)).collect();
        let large_m2 = LARGE_OF_ALL * leaves.iter().map(|&leaf| mesh.patch(leaf).area_m2).sum::<f64>();
        // With more points the triangles are others.
        let is_stale = |leaf: PatchId| points_of[leaf.index()].is_none_or(|points| points != mesh.boundary_count(leaf));
        let stale: Vec<Outlined> =
            leaves.par_iter().filter(|leaf| is_stale(**leaf)).map(|&leaf| Outlined::of(mesh, leaf)).collect();
        let patches: Vec<PatchId> = stale.iter().map(|leaf| leaf.patch).collect();
        field.look_around(mesh, &patches, &|| progress.report(Stage::Shade, 0, 0))?;
        let field = &*field;
        let requests = stale.par_iter().flat_map_iter(|leaf| leaf.requests(mesh, places)).collect();
        refined.values.evaluate(mesh, field, requests, Stage::Shade, progress)?;
        // Elements may ask for more of the field.
        let fresh = stale.par_iter().map(|leaf| {
            progress.report(Stage::Shade, 0, 0)?;
            let closer = Closer { large_m2, bright: bright.of(leaf.patch) };
            Ok(leaf.elements(mesh, places, &refined.values, field, &closer, &refined.elements[leaf.patch.index()]))
        });
        let fresh: Vec<Vec<Element>> = fresh.collect::<Result<_, Cancelled>>()?;
        for (leaf, elements) in stale.iter().zip(fresh) {
            points_of[leaf.patch.index()] = Some(leaf.point_count());
            let before = std::mem::replace(&mut refined.elements[leaf.patch.index()], elements);
            errors.replace(&before, &refined.elements[leaf.patch.index()]);
        }
        let changed: Vec<PatchId> = stale.iter().map(|leaf| leaf.patch).collect();
        if tells_all {
            area_m2 =
                leaves.iter().flat_map(|leaf| &refined.elements[leaf.index()]).map(|element| element.area_m2).sum();
            errors.tell_all(&leaves, &refined.elements, &refined.values);
        } else {
            let told = if is_coarse { &leaves } else { &changed };
            errors.tell(told, &refined.elements, &refined.values);
        }
        let total = errors.total(&leaves);
        if total <= 0.0 || settings.mean <= 0.0 {
            refined.error = 0.0;
            break;
        }
        refined.error = (total / area_m2).sqrt() / settings.mean;
        let (triangles, points) = (errors.triangles(), refined.values.as_slice().len());
        tracing::debug!(leaves = leaves.len(), triangles, points, error = refined.error, "refined");
        let target = (settings.tolerance * settings.mean).powi(2) * area_m2;
        let errs_locally = |leaf: PatchId| {
            !is_finest[leaf.index()]
                && mesh.patch(leaf).area_m2 > least_m2.max(LEAST_OF_ALL * area_m2)
                && refined.elements[leaf.index()].iter().any(|element| {
                    let squared = is_seen(element, area_m2) * errors.of(element);
                    let of_own = OWN_TOLERANCES * settings.tolerance;
                    let errs = |least: f64| element.errs_locally(squared, &refined.values, of_own, least);
                    // The light around is looked up where it decides.
                    let least = |around: f64| negligible(settings.tolerance, settings.mean, around);
                    errs(least(0.0)) && errs(least(field.around(mesh, leaf)))
                })
        };
        let leaks = |leaf: PatchId| {
            settings.interpolation == Interpolation::Linear
                && !is_finest[leaf.index()]
                && mesh.patch(leaf).area_m2 > LEAKING_OF_ALL * area_m2
                && refined.elements[leaf.index()]
                    .iter()
                    .any(|element| element.leaks(&refined.values, LEAK_OF_MEAN * settings.mean))
        };
        // Where triangles are few, the mean error comes first.
        let room = settings.max_triangles.saturating_sub(mesh.triangle_count());
        // What cannot be split does not drive the others.
        let is_divisible = |leaf: &PatchId| !is_finest[leaf.index()] && mesh.patch(*leaf).area_m2 > least_m2;
        let divisible: Vec<PatchId> = leaves.iter().copied().filter(is_divisible).collect();
        let total = errors.total(&divisible);
        is_coarse = total > target;
        way.is_at(total, target);
        let mut marked: Vec<PatchId> = if is_coarse {
            worst(errors.of_leaves(&divisible), total, target)
        } else {
            let looked_at = if tells_all { &leaves } else { &changed };
            let marked: Vec<PatchId> =
                looked_at.par_iter().copied().filter(|&leaf| errs_locally(leaf) || leaks(leaf)).collect();
            worst(errors.of_leaves(&marked), f64::INFINITY, 0.0)
        };
        // Where there is room for all, the order does not matter: that of numbers is the same however errors are rounded.
        if room / MOST_OF_A_SPLIT >= marked.len() {
            marked.sort_unstable();
        }
        // What is split must be looked at: the last round does not.
        if round + 1 == MOST_ROUNDS || room == 0 || progress.is_hurried() {
            break;
        }
        let most = settings.max_triangles;
        marked.retain(|&leaf| mesh.split_within(leaf, most.saturating_sub(mesh.triangle_count())) == Attempt::Split);
        bright.hand_down(mesh);
        for &leaf in &marked {
            errors.replace(&std::mem::take(&mut refined.elements[leaf.index()]), &[]);
        }
        if marked.is_empty() && tells_all {
            break;
        }
        tells_all = marked.is_empty();
    }
    refined.shifts = errors.into_shifts();
    Ok(refined)
}

/// How far refinement is: the logarithm of the mean error goes down evenly, then what errs in single places is split.
#[derive(Debug, Default)]
struct Way {
    first: Option<f64>,
    share: f64,
}

impl Way {
    /// About the share that the mean error takes.
    const OF_MEAN: f64 = 0.8;
    /// A round takes about so much of what is left.
    const OF_REST: f64 = 0.2;

    /// The shares at which the next round begins and ends.
    fn next_round(&self) -> [f64; 2] {
        [self.share, self.share + Self::OF_REST * (1.0 - self.share)]
    }

    /// The squared error is `total`, and should be `target`.
    fn is_at(&mut self, total: f64, target: f64) {
        let first = *self.first.get_or_insert(total);
        let of_mean = Self::OF_MEAN * share_of_way(total / first, target / first);
        self.share = if total > target { self.share.max(of_mean) } else { self.next_round()[1].max(Self::OF_MEAN) };
    }
}

/// How much of the square of a local error counts, for the size of its element.
fn is_seen(element: &Element, all_m2: f64) -> f64 {
    (element.area_m2 / (SEEN_OF_ALL * all_m2)).sqrt().min(1.0)
}

/// The leaves that make up a share of the squared error, no fewer than a share of all and no more than are needed for the target; those
/// that err most come first.
pub(super) fn worst(mut errors: Vec<(PatchId, f64)>, total: f64, target: f64) -> Vec<PatchId> {
    errors.par_sort_unstable_by(|(p, first), (q, second)| second.total_cmp(first).then(p.cmp(q)));
    let enough = (SHARE_A_ROUND * total).min(total - 0.5 * target);
    let least = (LEAST_SHARE_OF_LEAVES * errors.len() as f64) as usize;
    let mut marked = Vec::new();
    let mut sum = 0.0;
    for (leaf, squared) in errors {
        if (sum >= enough && marked.len() >= least) || squared <= 0.0 {
            break;
        }
        sum += squared;
        marked.push(leaf);
    }
    marked
}

/// Sorts errors, the least first, and tells how many of them add up to no more than `budget`.
pub(super) fn least_within(errors: &mut [(PatchId, f64)], budget: f64) -> usize {
    errors.sort_by(|(p, first), (q, second)| first.total_cmp(second).then(p.cmp(q)));
    let mut left = budget;
    let within = errors.iter().take_while(|(_, error)| {
        left -= error;
        left >= 0.0
    });
    within.count()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::discontinuity;
    use crate::id::{FaceId, Table};
    use crate::mesh::MeshSettings;
    use crate::prepare::prepare;
    use crate::scene::cornell::cornell_box;
    use crate::shade::direct::Direct;
    use crate::shade::interpolated::Interpolated;
    use crate::transport::DirectLight;
    use crate::visibility::{ReceiverPoint, Visibility, fixture};
    use glam::DVec3;

    /// Light that grows without bound towards some points, each much fainter than the one before: they are refined one after
    /// the other.
    struct Spikes;

    impl Field for Spikes {
        fn at(&self, _: &Mesh, point: &ReceiverPoint, _: PatchId) -> Rgb {
            let spike = |k: i32| {
                let at_m = DVec3::new(0.31, 0.17, 0.0) + 0.13 * DVec3::new(f64::from(k % 3), f64::from(k / 3), 0.0);
                10.0_f64.powi(-8 * k) / (point.position_m.distance(at_m) + 1e-9)
            };
            Rgb::splat((0..6).map(spike).sum())
        }
    }

    #[test]
    fn all_leaves_were_looked_at_though_rounds_or_triangles_ran_out() {
        let prepared = fixture::prepared(&[fixture::square(DVec3::ZERO, 1.0, true)]);
        for interpolation in [Interpolation::Linear, Interpolation::Quadratic] {
            let mut mesh = Mesh::new(&prepared, &Table::new(), MeshSettings::default());
            let settings = RefineSettings { interpolation, tolerance: 1e-60, mean: 1.0, max_triangles: 20_000 };
            let places = Places::new(&prepared);
            let refined =
                refine(&mut mesh, &places, &mut Spikes, Values::default(), |_, _| true, settings, Progress::silent())
                    .unwrap();
            let (unseen, seen): (Vec<PatchId>, Vec<PatchId>) =
                mesh.leaves().partition(|leaf| refined.elements.get(leaf.index()).is_none_or(Vec::is_empty));
            assert!(unseen.is_empty() && seen.len() > MOST_ROUNDS, "{} of {}", unseen.len(), seen.len());
        }
    }

    /// Light beside something that stands 0.1 m over the plane, with a fold in it.
    struct Bump;

    impl Bump {
        fn value(p: DVec3) -> f64 {
            1.0 / (1.0 + 100.0 * p.distance_squared(DVec3::new(0.21, 0.13, 0.0))) + 0.2 * (p.x + 0.3 * p.y + 0.4).abs()
        }
    }

    impl Field for Bump {
        fn at(&self, _: &Mesh, point: &ReceiverPoint, _: PatchId) -> Rgb {
            Rgb::splat(Self::value(point.position_m))
        }
    }

    #[test]
    fn what_quadratic_interpolation_errs_is_about_what_it_says() {
        let prepared = fixture::prepared(&[fixture::square(DVec3::ZERO, 1.0, true)]);
        let places = Places::new(&prepared);
        for tolerance in [1e-2, 3e-3, 1e-3] {
            let mut mesh = Mesh::new(&prepared, &Table::new(), MeshSettings::default());
            let interpolation = Interpolation::Quadratic;
            let settings = RefineSettings { interpolation, tolerance, mean: 0.3, max_triangles: usize::MAX };
            let refined =
                refine(&mut mesh, &places, &mut Bump, Values::default(), |_, _| true, settings, Progress::silent())
                    .unwrap();
            let field = Interpolated::new(&mesh, &refined, &Table::new());
            let n = 200;
            let squared = (0..n * n).map(|i| {
                let at = [i % n, i / n].map(|k| 2.0 * (f64::from(k) + 0.5) / f64::from(n) - 1.0);
                let point = ReceiverPoint::on_face(&prepared, FaceId::from(0), DVec3::new(at[0], at[1], 0.0));
                (field.at(&point, FaceId::from(0)).x - Bump::value(point.position_m)).powi(2)
            });
            let error = (squared.sum::<f64>() / f64::from(n * n)).sqrt() / settings.mean;
            assert!(error <= tolerance && refined.error <= tolerance, "{error}, {} of {tolerance}", refined.error);
            // Across the fold a parabola errs with the size, not with its cube: there more is left than is told.
            assert!((0.3..1.3).contains(&(error / refined.error)), "{error} is not {}", refined.error);
        }
    }

    /// Light in a window's reveal: it falls from the pane to the room, over much less than the reveal is long.
    struct Reveal;

    impl Reveal {
        fn value(p: DVec3) -> f64 {
            if p.z > 0.5 { 1.0 / (1.0 + (p.y / 0.03).powi(2)) } else { 0.1 }
        }
    }

    impl Field for Reveal {
        fn at(&self, _: &Mesh, point: &ReceiverPoint, _: PatchId) -> Rgb {
            Rgb::splat(Self::value(point.position_m))
        }
    }

    #[test]
    fn what_changes_across_a_strip_is_seen_however_the_strip_is_cut() {
        let strip = [(0.0, 0.0), (1.6, 0.0), (1.6, 0.15), (0.0, 0.15)].map(|(x, y)| DVec3::new(x, y, 1.0)).to_vec();
        let prepared = fixture::prepared(&[fixture::square(DVec3::ZERO, 10.0, true), strip]);
        let (places, face) = (Places::new(&prepared), FaceId::from(1));
        let mut mesh = Mesh::new(&prepared, &Table::new(), MeshSettings::default());
        let interpolation = Interpolation::Quadratic;
        let settings = RefineSettings { interpolation, tolerance: 3e-3, mean: 0.1, max_triangles: usize::MAX };
        let refined =
            refine(&mut mesh, &places, &mut Reveal, Values::default(), |_, _| true, settings, Progress::silent())
                .unwrap();
        let field = Interpolated::new(&mesh, &refined, &Table::new());
        let mut worst = 0.0_f64;
        for i in 0..10_000 {
            let [s, t] = [0.618034, 0.754878].map(|step| (f64::from(i) * step).fract());
            let point = ReceiverPoint::on_face(&prepared, face, DVec3::new(1.6 * s, 0.15 * t, 1.0));
            let (value, truth) = (field.at(&point, face).x, Reveal::value(point.position_m));
            // The bound is on the mean square over a triangle, as one point of it tells.
            let most = OWN_TOLERANCES * settings.tolerance * truth + settings.tolerance * settings.mean;
            worst = worst.max((value - truth).abs() / most);
        }
        assert!(worst < 6.0, "{worst}");
    }

    /// Light on one side of a line that no hint follows, which grows from it by so much, and jumps by so much on it.
    struct Side {
        slope: f64,
        jump: f64,
    }

    impl Field for Side {
        fn at(&self, _: &Mesh, point: &ReceiverPoint, _: PatchId) -> Rgb {
            let beyond = point.position_m.x + 0.37 * point.position_m.y - 0.113;
            Rgb::splat(if beyond > 0.0 { self.jump + self.slope * beyond } else { 0.0 })
        }
    }

    /// The smallest leaf that is made of a square of 2 x 2 m, as a share of it.
    fn smallest(mut side: Side) -> f64 {
        let prepared = fixture::prepared(&[fixture::square(DVec3::ZERO, 1.0, true)]);
        let places = Places::new(&prepared);
        let mut mesh = Mesh::new(&prepared, &Table::new(), MeshSettings::default());
        let interpolation = Interpolation::Linear;
        let settings = RefineSettings { interpolation, tolerance: 5e-3, mean: 1.0, max_triangles: 40_000 };
        refine(&mut mesh, &places, &mut side, Values::default(), |_, _| true, settings, Progress::silent()).unwrap();
        mesh.leaves().map(|leaf| mesh.patch(leaf).area_m2).fold(f64::INFINITY, f64::min) / 4.0
    }

    #[test]
    fn a_kink_ends_where_it_is_too_small_to_be_seen_and_a_jump_does_not() {
        let (kink, jump) = (smallest(Side { slope: 3.0, jump: 0.0 }), smallest(Side { slope: 0.0, jump: 0.3 }));
        assert!(kink > 3e-6, "{kink}");
        assert!(jump < 1e-6, "{jump}");
    }

    #[test]
    #[ignore = "a measurement for docs/convergence.md"]
    fn quadratic_elements_need_fewer_points_than_linear_ones() {
        let scene = cornell_box();
        let prepared = prepare(&scene, Progress::silent()).unwrap();
        let visibility = Visibility::new(&prepared);
        let segments = discontinuity::find(&scene, &prepared, &visibility, 1e-3, Progress::silent()).unwrap().segments;
        let direct = DirectLight::new(&scene, &prepared, &visibility);
        let places = Places::new(&prepared);
        let receives =
            |mesh: &Mesh, patch: PatchId| !scene.materials[prepared.faces[mesh.patch(patch).face].material].emits();
        let coarse = Mesh::new(&prepared, &segments, MeshSettings::default());
        let leaves: Vec<PatchId> = coarse.leaves().filter(|&leaf| receives(&coarse, leaf)).collect();
        let light: Rgb = leaves.iter().map(|&leaf| coarse.patch(leaf).area_m2 * direct.over(&coarse, leaf).mean).sum();
        let area_m2: f64 = leaves.iter().map(|&leaf| coarse.patch(leaf).area_m2).sum();
        let mean = light.element_sum() / (3.0 * area_m2);
        let (nothing, mut counts) = (Table::new(), Vec::new());
        for (hints, segments) in [(true, &segments), (false, &nothing)] {
            for tolerance in [0.02, 0.01, 0.005, 0.0025] {
                let points = [Interpolation::Linear, Interpolation::Quadratic].map(|interpolation| {
                    let mut mesh = Mesh::new(&prepared, segments, MeshSettings::default());
                    mesh.remove_d0_hints();
                    let settings = RefineSettings { interpolation, tolerance, mean, max_triangles: usize::MAX };
                    let refined = refine(
                        &mut mesh,
                        &places,
                        &mut Direct::new(&direct),
                        Values::default(),
                        receives,
                        settings,
                        Progress::silent(),
                    )
                    .unwrap();
                    let elements: usize = mesh.leaves().map(|leaf| refined.elements[leaf.index()].len()).sum();
                    let points = refined.values.as_slice().len();
                    println!(
                        "d-segments {hints}, {tolerance}, {interpolation:?}: {elements} elements, {points} points"
                    );
                    points
                });
                counts.push(points);
            }
        }
        assert!(counts.iter().all(|[linear, quadratic]| quadratic < linear), "{counts:?}");
    }
}
