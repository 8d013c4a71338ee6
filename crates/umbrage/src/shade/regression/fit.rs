//! The fit: rounds of samples, equations, evidence and splits, until noise and misfit are what the tolerance allows.
//!
//! Before: a mesh whose cuts hold the jumps of reflected light (contacts, edges close before faces), and the light of texels. After: a
//! function that is continuous wherever light is, quadratic over the triangles of the leaves, never below zero, and exactly zero on
//! leaves that no sample found light on. It ends for every scene: splits and samples are bounded, and each must pay.

use glam::{DVec2, Vec3};
use rayon::prelude::*;
use rustc_hash::FxHashMap;

use super::bright::split_around;
use super::element::{Element, ElementEquations, NODES, SMOOTHING, element_at, equations};
use super::evidence::{Classes, Evidence, Judged, Pool};
use super::normal_equations::{Part, solve};
use super::plan::{Need, Plan, WORTHWHILE, plan};
use super::sample::{Gathering, Sample};
use crate::id::{FaceId, PatchId};
use crate::mesh::Mesh;
use crate::prepare::Prepared;
use crate::progress::{Cancelled, Progress, Stage};
use crate::scene::Rgb;
use crate::shade::element::Outlined;
use crate::shade::field::{MeshPoint, Places};
use crate::texels::TexelRadiosity;
use crate::transport::BrightPlace;

/// Noise and misfit may be this share of the tolerance; what is left is for interpolation between vertices.
const SHARE_OF_TOLERANCE: f64 = 0.85;
/// The square of the misfit is so many times what cells show: they see its means. Measured against references: with 8 a furnished room
/// asked for 2 % erred 1.40 % in a half more time, with 2 a plate 1 mm off a wall erred 2.2 %.
const HIDDEN_MISFIT: f64 = 4.0;
/// Stratified samples err by this share of the variance of independent ones.
const STRATIFIED: f64 = 0.5;
/// A quadratic function over a leaf has so many values of its own beside its neighbours', at the least and with many samples.
const VALUES_OF_LEAF: [f64; 2] = [1.5, 6.0];
/// Leaves of this share of the area and more begin with the most samples, smaller ones with fewer, by the root of their area.
const FULL_OF_ALL: f64 = 1e-3;
const FIRST_SAMPLES: [f64; 2] = [32.0, 256.0];
/// Samples of a leaf where no light was found are raised to this before it counts as dark.
const OF_DARK_LEAF: usize = 96;
/// Samples that look whether a face is dark that no light of texels falls on.
const OF_DARK_FACE: usize = 16;
/// No leaf of a smaller share of the area is split.
const LEAST_OF_ALL: f64 = 1e-6;
/// No spread is taken to be less than this share of the mean irradiance.
const LEAST_SPREAD: f64 = 0.02;
/// No more rounds, samples and leaves.
const MAX_ROUNDS: usize = 30;
const MAX_SAMPLES: f64 = 16e6;
const MAX_LEAVES: usize = 300_000;
/// Squared relative residual of the equations, between rounds and at the end.
const RESIDUALS: [f64; 2] = [1e-4, 1e-6];

/// The size of the least leaf that is split, in metres, where all faces have this area: what is smaller must be cut in beforehand.
pub(crate) fn least_of_fit_m(area_m2: f64) -> f64 {
    (LEAST_OF_ALL * area_m2).sqrt()
}

/// Reflected irradiance as a function of the place.
#[derive(Debug)]
pub(crate) struct FittedLight {
    mesh: Mesh,
    /// The elements of each leaf; none where it is dark.
    elements: Vec<Vec<Element>>,
    values: Vec<Rgb>,
    /// Estimated root mean square error over the mean irradiance.
    pub(crate) error: f64,
    /// Samples that were drawn.
    pub(crate) samples: usize,
}

impl FittedLight {
    /// Irradiance at a point of a face, in W/m2.
    pub(crate) fn at(&self, point_m: glam::DVec3, face: FaceId) -> Rgb {
        let leaf = self.mesh.leaf_at(face, point_m);
        let elements = &self.elements[leaf.index()];
        let at = self.mesh.frame(face).to_2d(point_m);
        let Some((number, coordinates)) = element_at(elements, at) else { return Rgb::ZERO };
        let clamped = coordinates.map(|coordinate| coordinate.clamp(0.0, 1.0));
        let sum: f64 = clamped.iter().sum();
        let element = &elements[number];
        let least = element.nodes.iter().map(|&node| self.values[node as usize]).reduce(Rgb::min).unwrap_or_default();
        // Beside a dark corner a parabola may fall below the light at all of its nodes: that would be a black dot.
        element.value(clamped.map(|coordinate| coordinate / sum), &self.values).max(least.max(Rgb::ZERO))
    }
}

/// How finely light is fitted.
#[derive(Clone, Copy, Debug)]
pub(crate) struct RegressionSettings<'a> {
    /// Root mean square error of all that is shown over the mean irradiance.
    pub(crate) tolerance: f64,
    /// That mean, in W/m2.
    pub(crate) mean: f64,
    /// Small places that are known to be bright.
    pub(crate) bright: &'a [BrightPlace],
}

/// A leaf and what is known of it.
#[derive(Debug, Default)]
struct Leaf {
    samples: Vec<Sample>,
    /// Samples that were drawn for it: it may have others from the leaf that it is part of.
    drawn: usize,
    elements: Vec<Element>,
    keys: Vec<[MeshPoint; NODES]>,
    equations: Vec<ElementEquations>,
    /// Boundary points and samples that the equations are of.
    seen: (usize, usize),
    /// Whether its equations are not those of the last solution, or it was not judged since.
    changed: bool,
    /// Whether a sample found light.
    lit: bool,
    classes: Classes,
    evidence: Evidence,
    judged: Judged,
}

/// Fits reflected irradiance over the leaves of a mesh. Squared errors of a face count `weight` times; one without weight has no fit.
///
/// # Errors
/// [`Cancelled`] where the progress callback asks to stop.
pub(crate) fn regress(
    gathering: Gathering<'_>,
    mut mesh: Mesh,
    places: &Places<'_>,
    weight: impl Fn(FaceId) -> f64 + Sync,
    RegressionSettings { tolerance, mean, bright }: RegressionSettings<'_>,
    progress: Progress<'_>,
) -> Result<FittedLight, Cancelled> {
    let has_events = gathering.bright.is_some();
    let lit_faces = lit_faces(gathering.prepared, gathering.light);
    let mut leaves: FxHashMap<PatchId, Leaf> = FxHashMap::default();
    let mut nodes = Nodes::default();
    let receiving = |mesh: &Mesh| -> Vec<PatchId> {
        mesh.leaves().filter(|&leaf| weight(mesh.patch(leaf).face) > 0.0 && mesh.patch(leaf).area_m2 > 0.0).collect()
    };
    // Area counts as errors on it do.
    let counted_m2 = |mesh: &Mesh, leaf: PatchId| weight(mesh.patch(leaf).face) * mesh.patch(leaf).area_m2;
    let area_m2: f64 = receiving(&mesh).iter().map(|&leaf| counted_m2(&mesh, leaf)).sum();
    split_around(&mut mesh, bright, LEAST_OF_ALL * area_m2);
    let allowed = (SHARE_OF_TOLERANCE * tolerance * mean).powi(2) * area_m2;
    let mut price = f64::INFINITY;
    let (mut error, mut drawn) = (0.0, 0);
    for round in 0..MAX_ROUNDS {
        progress.report(Stage::Shade, drawn, 0)?;
        let mut work: Vec<(PatchId, Leaf)> = receiving(&mesh)
            .into_iter()
            .map(|leaf| (leaf, leaves.remove(&leaf).unwrap_or_else(|| Leaf { changed: true, ..Leaf::default() })))
            .collect();
        let fresh = work.par_iter_mut().map(|(id, leaf)| {
            progress.report(Stage::Shade, drawn, 0)?;
            let patch = mesh.patch(*id);
            let of_patch_m2 = counted_m2(&mesh, *id);
            let first = FIRST_SAMPLES[1] * (of_patch_m2 / (FULL_OF_ALL * area_m2)).sqrt();
            let first = first.clamp(FIRST_SAMPLES[0], FIRST_SAMPLES[1]) as usize;
            let wanted = match (leaf.lit, leaf.samples.is_empty()) {
                (true, _) => first.max((leaf.noise(of_patch_m2) / price).sqrt() as usize),
                (false, true) => {
                    if lit_faces[patch.face.index()] {
                        first
                    } else {
                        OF_DARK_FACE
                    }
                }
                (false, false) => {
                    if lit_faces[patch.face.index()] {
                        first.max(OF_DARK_LEAF)
                    } else {
                        0
                    }
                }
            };
            let there = leaf.samples.len();
            if wanted as f64 <= WORTHWHILE * there as f64 {
                return Ok(0);
            }
            gathering.draw(&mesh, *id, leaf.drawn, wanted - there, &mut leaf.samples);
            leaf.lit |= leaf.samples[there..].iter().any(|sample| sample.light != Vec3::ZERO);
            leaf.drawn += wanted - there;
            leaf.changed = true;
            Ok(wanted - there)
        });
        let fresh: usize = fresh.collect::<Result<Vec<usize>, Cancelled>>()?.iter().sum();
        drawn += fresh;
        work.par_iter_mut().filter(|(_, leaf)| leaf.lit).for_each(|(id, leaf)| leaf.renew(&mesh, places, *id));
        nodes.number(work.iter_mut().filter(|(_, leaf)| leaf.lit).map(|(_, leaf)| leaf));
        solve(&parts(&work, false), &mut nodes.values, RESIDUALS[0]);
        let values = &nodes.values;
        work.par_iter_mut().filter(|(_, leaf)| leaf.lit && leaf.changed).for_each(|(id, leaf)| {
            leaf.changed = false;
            (leaf.evidence, leaf.classes) =
                Evidence::of(&mesh.polygon_2d_m(*id), (&leaf.samples, has_events), &leaf.elements, values);
        });
        let lit = || work.iter().filter(|(_, leaf)| leaf.lit);
        let pool = Pool::new(lit().map(|(id, leaf)| (counted_m2(&mesh, *id), &leaf.evidence)), LEAST_SPREAD * mean);
        work.par_iter_mut().filter(|(_, leaf)| leaf.lit).for_each(|(_, leaf)| leaf.judged = pool.judge(&leaf.evidence));
        let needs: Vec<Need> = work
            .iter()
            .filter(|(_, leaf)| leaf.lit)
            .map(|(id, leaf)| leaf.need(*id, counted_m2(&mesh, *id), area_m2))
            .collect();
        let squared: f64 = needs.iter().map(|need| need.misfit + need.noise / need.samples).sum();
        error = (squared / area_m2).sqrt() / mean;
        tracing::debug!(round, leaves = work.len(), samples = drawn, error, "regression");
        let is_last = round + 1 == MAX_ROUNDS || progress.is_hurried();
        let mut splits = Vec::new();
        if !is_last && (round == 0 || squared > allowed) {
            Plan { price, splits } = plan(&needs, allowed, MAX_SAMPLES);
            if work.len() >= MAX_LEAVES {
                splits.clear();
            }
        }
        let wants_samples = needs.iter().any(|need| need.wanted(price) > need.samples);
        leaves.extend(work);
        let is_stuck = splits.is_empty() && (!wants_samples || (round > 0 && fresh == 0));
        if is_last || is_stuck || (round > 0 && squared <= allowed) {
            break;
        }
        for leaf in splits {
            if mesh.split(leaf) {
                hand_down(&mesh, leaf, &mut leaves);
            }
        }
    }
    let mut work: Vec<(PatchId, Leaf)> = leaves.drain().filter(|(_, leaf)| leaf.lit).collect();
    work.sort_unstable_by_key(|(id, _)| *id);
    // Once more with what is known of directions now.
    work.par_iter_mut().for_each(|(id, leaf)| {
        leaf.seen.1 = 0;
        leaf.renew(&mesh, places, *id);
    });
    nodes.number(work.iter_mut().map(|(_, leaf)| leaf));
    solve(&parts(&work, true), &mut nodes.values, RESIDUALS[1]);
    let mut elements = vec![Vec::new(); mesh.patch_count()];
    work.into_iter().for_each(|(id, leaf)| elements[id.index()] = leaf.elements);
    Ok(FittedLight { mesh, elements, values: nodes.values, error, samples: drawn })
}

/// Which faces have a texel that other faces light.
fn lit_faces(prepared: &Prepared, light: &TexelRadiosity) -> Vec<bool> {
    let mut lit = vec![false; prepared.faces.len()];
    for (texel, indirect) in light.grid.texels().iter().zip(&light.indirect) {
        lit[texel.face.index()] |= *indirect != Vec3::ZERO;
    }
    lit
}

/// The equations of all lit leaves; with `all`, as if all had changed.
fn parts(work: &[(PatchId, Leaf)], all: bool) -> Vec<Part<'_>> {
    let lit = work.iter().filter(|(_, leaf)| leaf.lit);
    let mut parts = Vec::new();
    for (_, leaf) in lit {
        for (element, equations) in leaf.elements.iter().zip(&leaf.equations) {
            parts.push(Part { nodes: element.nodes, equations, changed: all || leaf.changed });
        }
    }
    parts
}

/// Gives the samples of a leaf that was split to its parts.
fn hand_down(mesh: &Mesh, split: PatchId, leaves: &mut FxHashMap<PatchId, Leaf>) {
    let (Some(parts), Some(Leaf { samples, lit, classes, .. })) = (mesh.patch(split).subpatches, leaves.remove(&split))
    else {
        return;
    };
    let frame = mesh.frame(mesh.patch(split).face);
    let [from, to] = mesh.cut_m(split).unwrap_or_default().map(|end| frame.to_2d(end));
    let is_left = |sample: &Sample| (to - from).perp_dot(sample.at() - from) >= 0.0;
    let (left, right): (Vec<Sample>, Vec<Sample>) = samples.into_iter().partition(is_left);
    for (part, samples) in parts.into_iter().zip([left, right]) {
        let leaf = Leaf { samples, lit, classes: classes.clone(), changed: true, ..Leaf::default() };
        leaves.insert(part, leaf);
    }
}

/// The nodes of all elements.
#[derive(Debug, Default)]
struct Nodes {
    numbers: FxHashMap<MeshPoint, u32>,
    values: Vec<Rgb>,
}

impl Nodes {
    /// Numbers the nodes of leaves, in order; a new one starts with the mean of the samples around it.
    fn number<'a>(&mut self, leaves: impl Iterator<Item = &'a mut Leaf>) {
        let known = self.values.len();
        let mut sums: Vec<(Rgb, f64)> = Vec::new();
        for leaf in leaves {
            for ((element, keys), equations) in leaf.elements.iter_mut().zip(&leaf.keys).zip(&leaf.equations) {
                element.nodes = keys.map(|key| {
                    let next = self.numbers.len() as u32;
                    *self.numbers.entry(key).or_insert(next)
                });
                sums.resize(self.numbers.len() - known, (Rgb::ZERO, 0.0));
                for (i, &node) in element.nodes.iter().enumerate().filter(|(_, node)| **node as usize >= known) {
                    let (light, weight) = &mut sums[node as usize - known];
                    *light += equations.light[i];
                    *weight += equations.products[i].iter().map(|&product| f64::from(product)).sum::<f64>();
                }
            }
        }
        let mean = |(light, weight): (Rgb, f64)| if weight > 0.0 { light / weight } else { Rgb::ZERO };
        self.values.extend(sums.into_iter().map(mean));
    }
}

impl Leaf {
    /// Makes its elements and their equations, where boundary points or samples are others than they were.
    fn renew(&mut self, mesh: &Mesh, places: &Places<'_>, id: PatchId) {
        let seen = (mesh.boundary_count(id), self.samples.len());
        if seen == self.seen {
            return;
        }
        self.changed = true;
        if seen.0 != self.seen.0 {
            let outlined = Outlined::of(mesh, id);
            let frame = mesh.frame(mesh.patch(id).face);
            let element = |corners: [crate::id::VertexId; 3]| -> [DVec2; 3] {
                corners.map(|corner| frame.to_2d(mesh.vertex_m(corner)))
            };
            (self.elements, self.keys) =
                outlined.nodes(mesh, places).map(|(corners, keys)| (Element::new(element(corners)), keys)).unzip();
        }
        self.seen = seen;
        self.equations = equations(&self.elements, &self.samples, |sample| self.classes.light(sample));
    }

    /// Integral of the squared noise that one sample would leave, in W2/m2.
    fn noise(&self, area_m2: f64) -> f64 {
        let samples = self.samples.len() as f64;
        let [least, most] = VALUES_OF_LEAF;
        let values = least + (most - least) * samples / (samples + SMOOTHING);
        STRATIFIED * area_m2 * values * self.judged.spread.powi(2)
    }

    fn need(&self, leaf: PatchId, area_m2: f64, of_all_m2: f64) -> Need {
        let splits = area_m2 > LEAST_OF_ALL * of_all_m2;
        // What cannot be split any more is not paid for elsewhere.
        let misfit = if splits { HIDDEN_MISFIT * area_m2 * self.judged.misfit } else { 0.0 };
        let samples = (self.samples.len() as f64).max(1.0);
        Need { leaf, misfit, noise: self.noise(area_m2), samples, fewest: FIRST_SAMPLES[0], splits }
    }
}
