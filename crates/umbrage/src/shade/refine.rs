//! Display refinement: splits leaves until linear interpolation of a field over their triangles is within a tolerance.
//!
//! Light decides where, hints decide how: the leaf that errs most is split by `split`, along its d-segments first. The
//! error of a leaf is estimated on the triangles that `point_split` would make of it: the field at the middles of their
//! sides, less the mean of its values at their ends, gives the quadratic part of the field, whose mean square over a
//! triangle is `8/45 (d1^2 + d2^2 + d3^2 + d1 d2 + d2 d3 + d3 d1)`; the centroid is looked at besides.
//!
//! In each round the smallest set of leaves that makes up a share of the error is split, until the root of the mean
//! square error over all receiving sides is within the tolerance times the mean of the field (bulk marking, Dörfler
//! 1996). Points are evaluated in parallel, splits follow in the order of ids.
//!
//! After: values at all boundary points of the leaves are known.

use rayon::prelude::*;

use super::field::{Field, Places, Request, Values};
use crate::id::PatchId;
use crate::mesh::{BoundaryPoint, Mesh};
use crate::progress::{Cancelled, Progress};
use crate::scene::Rgb;

/// The leaves that make up this share of the squared error are split in a round.
const SHARE_A_ROUND: f64 = 0.6;
/// A round that would split less than this share of the leaves splits so many, so that rounds stay few.
const LEAST_SHARE_OF_LEAVES: f64 = 0.02;
/// No refinement needs more rounds: each halves the greatest errors at least.
const MOST_ROUNDS: usize = 60;

/// When refinement ends.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct RefineSettings {
    /// Root mean square error over the mean of the field.
    pub(super) tolerance: f64,
    /// The mean irradiance that the tolerance refers to, in W/m2.
    pub(super) mean: f64,
    /// Leaves with more triangles in all are not made.
    pub(super) max_triangles: usize,
}

/// What is known of the error of a leaf.
#[derive(Clone, Copy, Debug)]
struct Estimate {
    /// Boundary points at the time: with more of them the triangles are others.
    points: usize,
    /// Integral of the squared error, in W2/m2.
    squared: f64,
    area_m2: f64,
    triangles: usize,
}

/// The triangles of a leaf.
struct Outlined {
    patch: PatchId,
    boundary: Vec<BoundaryPoint>,
    triangles: Vec<[usize; 3]>,
}

impl Outlined {
    fn of(mesh: &Mesh, patch: PatchId) -> Self {
        let boundary = mesh.boundary(patch);
        let triangles = mesh.triangles_of(patch, &boundary);
        Self { patch, boundary, triangles }
    }

    /// The points that the estimate needs.
    fn requests(&self, mesh: &Mesh, places: &Places<'_>) -> Vec<Request> {
        let vertices = self.boundary.iter().map(|point| places.vertex(mesh, self.patch, point.vertex));
        let middles = self.triangles.iter().flat_map(|triangle| {
            (0..3).map(|i| {
                let ends = [triangle[i], triangle[(i + 1) % 3]].map(|k| &self.boundary[k]);
                places.middle(mesh, self.patch, ends)
            })
        });
        vertices.chain(middles).collect()
    }

    fn estimate(&self, mesh: &Mesh, places: &Places<'_>, values: &Values, field: &impl Field) -> Estimate {
        let value = |request: Request| values.get(&request.key).unwrap_or(Rgb::ZERO);
        let at: Vec<Rgb> =
            self.boundary.iter().map(|point| value(places.vertex(mesh, self.patch, point.vertex))).collect();
        let position = |k: usize| mesh.vertex_m(self.boundary[k].vertex);
        let mut estimate =
            Estimate { points: self.boundary.len(), squared: 0.0, area_m2: 0.0, triangles: self.triangles.len() };
        for triangle in &self.triangles {
            let [a, b, c] = triangle.map(position);
            let area_m2 = 0.5 * (b - a).cross(c - a).length();
            let deviation = |i: usize| {
                let (j, k) = (triangle[i], triangle[(i + 1) % 3]);
                value(places.middle(mesh, self.patch, [&self.boundary[j], &self.boundary[k]])) - 0.5 * (at[j] + at[k])
            };
            let d = [deviation(0), deviation(1), deviation(2)];
            let quadratic =
                8.0 / 45.0 * (d[0] * d[0] + d[1] * d[1] + d[2] * d[2] + d[0] * d[1] + d[1] * d[2] + d[2] * d[0]);
            let mean = triangle.map(|k| at[k]).into_iter().sum::<Rgb>() / 3.0;
            let centroid = places.inside(mesh, self.patch, (a + b + c) / 3.0);
            let middle = field.at(mesh, &centroid, self.patch) - mean;
            // A bump of height h over the centroid alone has a mean square of about h^2 / 6.
            let squared = quadratic.max(middle * middle / 6.0);
            estimate.squared += area_m2 * squared.element_sum() / 3.0;
            estimate.area_m2 += area_m2;
        }
        estimate
    }
}

/// Splits the leaves that `receives` admits until the field is interpolated within the tolerance.
///
/// Returns the values at the points of the mesh, and the estimate of the relative error that is left.
pub(super) fn refine(
    mesh: &mut Mesh,
    places: &Places<'_>,
    field: &impl Field,
    receives: impl Fn(&Mesh, PatchId) -> bool,
    settings: RefineSettings,
    progress: Progress<'_>,
) -> Result<(Values, f64), Cancelled> {
    let mut values = Values::default();
    let mut estimates: Vec<Option<Estimate>> = Vec::new();
    let mut error = 0.0;
    for _ in 0..MOST_ROUNDS {
        estimates.resize(mesh.patch_count(), None);
        let leaves: Vec<PatchId> = mesh.leaves().filter(|&leaf| receives(mesh, leaf)).collect();
        let stale: Vec<Outlined> = leaves
            .par_iter()
            .filter(|leaf| {
                estimates[leaf.index()].is_none_or(|estimate| estimate.points != mesh.boundary(**leaf).len())
            })
            .map(|&leaf| Outlined::of(mesh, leaf))
            .collect();
        let requests = stale.par_iter().flat_map_iter(|leaf| leaf.requests(mesh, places)).collect();
        values.evaluate(mesh, field, requests, progress)?;
        let fresh: Vec<Estimate> = stale.par_iter().map(|leaf| leaf.estimate(mesh, places, &values, field)).collect();
        for (leaf, estimate) in stale.iter().zip(fresh) {
            estimates[leaf.patch.index()] = Some(estimate);
        }
        let known: Vec<(PatchId, Estimate)> =
            leaves.iter().filter_map(|&leaf| estimates[leaf.index()].map(|estimate| (leaf, estimate))).collect();
        let sum = |part: &dyn Fn(&Estimate) -> f64| known.iter().map(|(_, estimate)| part(estimate)).sum::<f64>();
        let (squared, area_m2) = (sum(&|e| e.squared), sum(&|e| e.area_m2));
        if squared <= 0.0 || settings.mean <= 0.0 {
            error = 0.0;
            break;
        }
        error = (squared / area_m2).sqrt() / settings.mean;
        let triangles: usize = known.iter().map(|(_, estimate)| estimate.triangles).sum();
        tracing::debug!(leaves = known.len(), triangles, points = values.len(), error, "refined");
        let target = (settings.tolerance * settings.mean).powi(2) * area_m2;
        if squared <= target || triangles >= settings.max_triangles {
            break;
        }
        split_worst(mesh, known, squared, target, settings.max_triangles - triangles);
    }
    Ok((values, error))
}

/// Splits the leaves that make up a share of the squared error, and no more than are needed for the target.
fn split_worst(mesh: &mut Mesh, mut known: Vec<(PatchId, Estimate)>, squared: f64, target: f64, room: usize) {
    known.sort_by(|(p, first), (q, second)| second.squared.total_cmp(&first.squared).then(p.cmp(q)));
    let enough = (SHARE_A_ROUND * squared).min(squared - 0.5 * target);
    let least = (LEAST_SHARE_OF_LEAVES * known.len() as f64) as usize;
    let mut marked = Vec::new();
    let mut sum = 0.0;
    for (leaf, estimate) in known {
        if (sum >= enough && marked.len() >= least) || marked.len() >= room.max(1) || estimate.squared <= 0.0 {
            break;
        }
        sum += estimate.squared;
        marked.push(leaf);
    }
    marked.sort_unstable();
    for leaf in marked {
        mesh.split(leaf);
    }
}
