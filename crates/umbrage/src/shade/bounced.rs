//! What every leaf receives of what all patches reflect, as sums of terms in its middle and, where that is not enough, at its corners:
//! what is seen does not change with the light.
//!
//! What a leaf reflects is a linear function over it. Where the light that it gathers is none, as in a narrow gap that is bright at its
//! mouth and dark inside, what lies opposite receives a wrong share; what lies far away does not, since the mean is right. So leaves
//! are split by what they err times the share of their view that near surfaces fill.
//!
//! After: over all leaves, what gathered light departs from linear functions, as its effect nearby, is within a share of the
//! tolerance.

use std::collections::BTreeMap;

use glam::DVec2;
use rayon::prelude::*;
use smallvec::SmallVec;

use super::bright_leaves::BrightLeaves;
use super::field::{MeshPoint, Places};
use super::irradiance::{Irradiance, Terms};
use super::refine::{OWN_TOLERANCES, least_within, worst};
use crate::id::{PatchId, Table};
use crate::mesh::Mesh;
use crate::progress::{Cancelled, Progress, Stage};
use crate::scene::Rgb;
use crate::transport::{BrightPlace, Linear, PlacesOfLeaves};
use crate::visibility::{AtPoints, ReceiverPoint};

/// Points between two reports of progress.
const POINTS_A_REPORT: usize = 16;
/// Leaves at whose corners nothing is gathered may err by this share of the tolerance, root mean square.
const PLAIN_OF_TOLERANCE: f64 = 0.05;
/// Of what light varies over a leaf, about this share is the root mean square of what a constant errs.
const OF_VARIATION: f64 = 0.5;
/// What leaves reflect unevenly may make this share of the tolerance, root mean square.
const UNEVEN_OF_TOLERANCE: f64 = 0.5;
/// Rounds of splits: a leaf may get as small as by so many halvings.
const MOST_ROUNDS: usize = 24;
/// Leaves smaller than this share of all area are not split.
const LEAST_OF_ALL: f64 = 1e-7;
/// A patch is near a leaf within so many of the greater one's radii.
const NEAR_RADII: f64 = 2.0;

/// How even what leaves gather must be.
#[derive(Clone, Copy, Debug)]
pub(super) struct Evenness<'a> {
    /// Of all patches that there were before leaves are split.
    pub(super) reflectance: &'a Table<PatchId, Rgb>,
    /// The tolerance of the whole, as a share of the mean irradiance.
    pub(super) tolerance: f64,
    /// Small places that are known to be bright.
    pub(super) bright: &'a [BrightPlace],
    /// Whether to gather in the middles of leaves alone, and split none.
    pub(super) in_middles_alone: bool,
}

/// A point of a leaf.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum Spot {
    Corner(MeshPoint),
    Middle(PatchId),
}

/// What leaves receive.
#[derive(Debug, Default)]
pub(super) struct BouncedLight {
    leaves: BTreeMap<PatchId, BouncedLeaf>,
    numbers: BTreeMap<Spot, u32>,
    points: Vec<(ReceiverPoint, Terms)>,
}

/// A leaf, by the numbers of its points.
#[derive(Clone, Debug)]
struct BouncedLeaf {
    /// Offsets of the corners from the centroid, in metres, and their numbers; none where nothing was gathered there.
    corners: SmallVec<[(DVec2, u32); 4]>,
    in_middle: u32,
    /// About the integral of the square of what a constant errs, in W2/m2, and whether that is much for light as dim as here.
    plain: (f64, bool),
    /// Integral of the square of what it errs nearby, in W2/m2.
    uneven: f64,
}

impl BouncedLeaf {
    /// The values in its middle and at its corners, these with their offsets from the centroid, in metres.
    fn values(&self, value: impl Fn(u32) -> Rgb) -> (Rgb, SmallVec<[(DVec2, Rgb); 4]>) {
        let corners = self.corners.iter().map(|&(offset_m, number)| (offset_m, value(number))).collect();
        (value(self.in_middle), corners)
    }
}

impl BouncedLight {
    /// Gathers at all leaves of `mesh`, and splits those over which the light is uneven. What was gathered `before` is taken, and
    /// renewed where it is not as good now.
    ///
    /// # Errors
    /// [`Cancelled`] where the progress callback asks to stop.
    pub(super) fn gather(
        before: Self,
        mesh: &mut Mesh,
        places: &Places<'_>,
        light: &Irradiance<'_>,
        evenness: Evenness<'_>,
        progress: Progress<'_>,
    ) -> Result<Self, Cancelled> {
        let mut bounced = Self::default();
        let area_m2: f64 = mesh.leaves().map(|leaf| mesh.patch(leaf).area_m2).sum();
        let target = (UNEVEN_OF_TOLERANCE * evenness.tolerance * light.mean).powi(2) * area_m2;
        let mut bright = PlacesOfLeaves::new(mesh, evenness.bright);
        for round in 0..=MOST_ROUNDS {
            bounced.look_at_leaves(&before, mesh, places, light, evenness, progress)?;
            let leaves: Vec<PatchId> = mesh.leaves().collect();
            let uneven = |&leaf: &PatchId| {
                let missed = bounced.missed(mesh, leaf, &bright.of(leaf), light, evenness.reflectance);
                (leaf, bounced.leaves[&leaf].uneven + missed)
            };
            let uneven: Vec<(PatchId, f64)> = leaves.iter().map(uneven).collect();
            let total: f64 = uneven.iter().map(|(_, uneven)| uneven).sum();
            tracing::debug!(leaves = leaves.len(), uneven = (total / area_m2).sqrt() / light.mean, "leaves");
            if evenness.in_middles_alone || round == MOST_ROUNDS || !target.is_finite() || total <= target {
                break;
            }
            let mut marked = worst(uneven, total, target);
            marked.retain(|&leaf| mesh.patch(leaf).area_m2 > LEAST_OF_ALL * area_m2);
            marked.sort_unstable();
            if marked.into_iter().filter(|&leaf| mesh.split(leaf)).count() == 0 {
                break;
            }
            bright.hand_down(mesh);
        }
        Ok(bounced)
    }

    /// Gathers at the leaves that were not looked at yet: in their middles, and at the corners of those over which that is not enough.
    fn look_at_leaves(
        &mut self,
        before: &Self,
        mesh: &Mesh,
        places: &Places<'_>,
        light: &Irradiance<'_>,
        evenness: Evenness<'_>,
        progress: Progress<'_>,
    ) -> Result<(), Cancelled> {
        let fresh: Vec<PatchId> = mesh.leaves().filter(|leaf| !self.leaves.contains_key(leaf)).collect();
        let in_middle =
            |&leaf: &PatchId| (Spot::Middle(leaf), leaf, places.inside(mesh, leaf, mesh.patch(leaf).centroid_m));
        self.gather_at(fresh.iter().map(in_middle).collect(), before, light, progress)?;
        let plain = |&leaf: &PatchId| {
            let in_middle = *self.numbers.get(&Spot::Middle(leaf))?;
            let plain = self.plain(mesh, leaf, in_middle, light, evenness.tolerance);
            Some((leaf, BouncedLeaf { corners: SmallVec::new(), in_middle, plain, uneven: 0.0 }))
        };
        let leaves: Vec<(PatchId, BouncedLeaf)> = fresh.par_iter().filter_map(plain).collect();
        self.leaves.retain(|&patch, _| mesh.patch(patch).subpatches.is_none());
        self.leaves.extend(leaves);
        if evenness.in_middles_alone {
            return Ok(());
        }
        let uneven = self.not_plain(mesh, light, evenness.tolerance);
        let corners = |&leaf: &PatchId| {
            mesh.corners(leaf).map(move |vertex| {
                let request = places.vertex(mesh, leaf, vertex);
                (Spot::Corner(request.key), leaf, request.point)
            })
        };
        self.gather_at(uneven.iter().flat_map(corners).collect(), before, light, progress)?;
        let looked_at = |&leaf: &PatchId| {
            let patch = mesh.patch(leaf);
            let frame = mesh.frame(patch.face);
            let corner = |vertex| {
                let spot = Spot::Corner(places.vertex_key(mesh, leaf, vertex));
                let offset_m = frame.to_2d(mesh.vertex_m(vertex)) - frame.to_2d(patch.centroid_m);
                Some((offset_m, *self.numbers.get(&spot)?))
            };
            let mut looked_at = self.leaves.get(&leaf)?.clone();
            looked_at.corners = mesh.corners(leaf).filter_map(corner).collect();
            let reflectance = evenness.reflectance[mesh.root(patch.face)].max_element();
            looked_at.uneven = patch.area_m2 * reflectance.powi(2) * self.uneven_nearby(&looked_at, light);
            Some((leaf, looked_at))
        };
        let leaves: Vec<(PatchId, BouncedLeaf)> = uneven.par_iter().filter_map(looked_at).collect();
        self.leaves.extend(leaves);
        Ok(())
    }

    /// Gathers at those of some points where nothing is known yet.
    fn gather_at(
        &mut self,
        mut wanted: Vec<(Spot, PatchId, ReceiverPoint)>,
        before: &Self,
        light: &Irradiance<'_>,
        progress: Progress<'_>,
    ) -> Result<(), Cancelled> {
        wanted.retain(|(spot, ..)| !self.numbers.contains_key(spot));
        wanted.sort_by_key(|&(spot, leaf, _)| (spot, leaf));
        wanted.dedup_by_key(|&mut (spot, ..)| spot);
        let known = self.points.len();
        let gathered = |(number, (spot, _, point)): (usize, &(Spot, PatchId, ReceiverPoint))| {
            if number.is_multiple_of(POINTS_A_REPORT) {
                progress.report(Stage::Solve, number, wanted.len())?;
            }
            let as_before = before.terms(spot).map(|terms| light.renewed(point, terms));
            Ok((*point, as_before.unwrap_or_else(|| light.terms(point))))
        };
        let gathered = wanted.par_iter().enumerate().map(gathered).collect::<Result<Vec<_>, Cancelled>>()?;
        self.numbers.extend(wanted.iter().enumerate().map(|(i, &(spot, ..))| (spot, (known + i) as u32)));
        self.points.extend(gathered);
        Ok(())
    }

    /// About the integral of the square of what a constant errs over a leaf, in W2/m2, and whether that is much of its own light.
    fn plain(&self, mesh: &Mesh, leaf: PatchId, in_middle: u32, light: &Irradiance<'_>, tolerance: f64) -> (f64, bool) {
        let (point, terms) = &self.points[in_middle as usize];
        let centroid_m = mesh.patch(leaf).centroid_m;
        let radius_m = mesh.corners(leaf).map(|corner| mesh.vertex_m(corner).distance(centroid_m)).fold(0.0, f64::max);
        let error = OF_VARIATION * light.variation(point, terms, radius_m);
        let own = light.sum_of(terms).element_sum() / 3.0;
        (mesh.patch(leaf).area_m2 * error * error, error > tolerance * (OWN_TOLERANCES * own + light.mean))
    }

    /// The leaves at whose corners light must be gathered, and is not yet: the others together err little by one value each.
    fn not_plain(&self, mesh: &Mesh, light: &Irradiance<'_>, tolerance: f64) -> Vec<PatchId> {
        let of_all_m2: f64 = self.leaves.keys().map(|&leaf| mesh.patch(leaf).area_m2).sum();
        let budget = (PLAIN_OF_TOLERANCE * tolerance * light.mean).powi(2) * of_all_m2;
        // Where there is no tolerance, all are looked at.
        let budget = if budget.is_finite() { budget } else { f64::NEG_INFINITY };
        let (mut uneven, mut others) = (Vec::new(), Vec::new());
        for (&leaf, BouncedLeaf { plain: (error, is_much), .. }) in
            self.leaves.iter().filter(|(_, leaf)| leaf.corners.is_empty())
        {
            if *is_much { uneven.push(leaf) } else { others.push((leaf, *error)) }
        }
        let plain = least_within(&mut others, budget);
        uneven.extend(others[plain..].iter().map(|(leaf, _)| *leaf));
        uneven
    }

    /// Integral over a leaf of the square of how much less light its points tell of than falls on its bright places, as it is
    /// reflected, in W2/m2.
    fn missed(
        &self,
        mesh: &Mesh,
        leaf: PatchId,
        bright: &[&BrightPlace],
        light: &Irradiance<'_>,
        reflectance: &Table<PatchId, Rgb>,
    ) -> f64 {
        if bright.is_empty() {
            return 0.0;
        }
        let patch = mesh.patch(leaf);
        let (frame, looked_at) = (mesh.frame(patch.face), &self.leaves[&leaf]);
        let (in_middle, corners) = looked_at.values(|number| light.sum_of(&self.points[number as usize].1));
        let linear = over_leaf(in_middle, &corners);
        let middle_m = frame.to_2d(patch.centroid_m);
        let squared = |place: &&BrightPlace| {
            let missed = (place.irradiance - linear.at(frame.to_2d(place.point_m) - middle_m)).max(Rgb::ZERO);
            place.area_m2.min(patch.area_m2) * (missed * missed).element_sum() / 3.0
        };
        reflectance[mesh.root(patch.face)].max_element().powi(2) * bright.iter().map(squared).sum::<f64>()
    }

    fn terms(&self, spot: &Spot) -> Option<&Terms> {
        self.numbers.get(spot).map(|&number| &self.points[number as usize].1)
    }

    /// Mean square of how far the light of a leaf departs from a linear function, times the square of the share of its view that
    /// near patches fill.
    fn uneven_nearby(&self, leaf: &BouncedLeaf, light: &Irradiance<'_>) -> f64 {
        let (in_middle, corners) = leaf.values(|number| light.sum_of(&self.points[number as usize].1));
        let linear = over_leaf(in_middle, &corners);
        let squared = |value: Rgb| (value * value).element_sum() / 3.0;
        let at_corners = corners.iter().map(|&(offset_m, value)| squared(value - linear.at(offset_m)));
        let count = corners.len() as f64;
        let departure = 0.5 * (squared(in_middle - linear.mean) + at_corners.sum::<f64>() / count);
        let radius_m = corners.iter().map(|(offset_m, _)| offset_m.length()).fold(0.0, f64::max);
        let near = |number: u32| {
            let (point, terms) = &self.points[number as usize];
            light.share_of_near(point, terms, NEAR_RADII, radius_m)
        };
        let at_corners: f64 = leaf.corners.iter().map(|&(_, number)| near(number)).sum();
        departure * (0.5 * (near(leaf.in_middle) + at_corners / count)).powi(2)
    }

    /// Irradiance of the leaves of `mesh` where patches reflect `radiosity`, in W/m2; of those at whose corners nothing was gathered with
    /// the slope that is given.
    pub(super) fn over_leaves(
        &self,
        mesh: &Mesh,
        light: &Irradiance<'_>,
        radiosity: &Table<PatchId, Linear<Rgb>>,
        bright: &mut BrightLeaves,
        slope: impl Fn(PatchId) -> [Rgb; 2] + Sync,
    ) -> Vec<(PatchId, Linear<Rgb>)> {
        let gathered = self.over_leaves_by_terms(light, radiosity, &slope);
        let power_w =
            |(patch, gathered): &(PatchId, Linear<Rgb>)| mesh.patch(*patch).area_m2 * gathered.mean.element_sum();
        let received_w = gathered.iter().map(power_w).sum();
        match bright.scaled(light, radiosity, received_w, || self.weighted_terms(mesh)) {
            Some(scaled) => self.over_leaves_by_terms(light, &scaled, &slope),
            None => gathered,
        }
    }

    fn over_leaves_by_terms(
        &self,
        light: &Irradiance<'_>,
        radiosity: &Table<PatchId, Linear<Rgb>>,
        slope: &(impl Fn(PatchId) -> [Rgb; 2] + Sync),
    ) -> Vec<(PatchId, Linear<Rgb>)> {
        let crowds = light.crowds_of(radiosity);
        let values: Vec<Rgb> = self.points.par_iter().map(|(_, terms)| terms.sum(radiosity, &crowds)).collect();
        let over = |(&patch, leaf): (&PatchId, &BouncedLeaf)| {
            let (in_middle, corners) = leaf.values(|number| values[number as usize]);
            let is_plain = corners.is_empty();
            let plain = || Linear { mean: in_middle, gradient: slope(patch) };
            (patch, if is_plain { plain() } else { over_leaf(in_middle, &corners) })
        };
        self.leaves.par_iter().map(over).collect()
    }

    /// What its points see, with the area of the leaves that each stands for, in square metres.
    fn weighted_terms(&self, mesh: &Mesh) -> Vec<(&Terms, f64)> {
        let mut weighted: Vec<(&Terms, f64)> = self.points.iter().map(|(_, terms)| (terms, 0.0)).collect();
        for (&patch, leaf) in &self.leaves {
            let area_m2 = mesh.patch(patch).area_m2;
            // The mean over a leaf is a sum over its points: each has the weight of a field that is 1 there and 0 at the others.
            let of_point = |number: Option<usize>| {
                let one = |is_there: bool| Rgb::splat(f64::from(u8::from(is_there)));
                let corners: SmallVec<[(DVec2, Rgb); 4]> = leaf
                    .corners
                    .iter()
                    .enumerate()
                    .map(|(i, &(offset_m, _))| (offset_m, one(number == Some(i))))
                    .collect();
                area_m2 * over_leaf(one(number.is_none()), &corners).mean.x
            };
            let all = (0..leaf.corners.len()).map(Some).chain([None]);
            for (number, at) in all.map(|at| (at.map_or(leaf.in_middle, |i| leaf.corners[i].1), at)) {
                weighted[number as usize].1 += if leaf.corners.is_empty() { area_m2 } else { of_point(at) };
            }
        }
        weighted
    }

    /// What its points see.
    pub(super) fn into_points(self) -> AtPoints<Terms> {
        AtPoints::new(self.points)
    }
}

/// The linear function over a convex polygon whose mean is that of the field with a value in the centroid and values at the
/// corners, which are given by their offsets from the centroid: exact to degree 2 over triangles and to degree 3 over
/// parallelograms, where it is Simpson's rule.
fn over_leaf(in_middle: Rgb, corners: &[(DVec2, Rgb)]) -> Linear<Rgb> {
    let count = corners.len();
    let doubled_m2: Vec<f64> = (0..count).map(|i| corners[i].0.perp_dot(corners[(i + 1) % count].0)).collect();
    let whole_m2: f64 = doubled_m2.iter().sum();
    if whole_m2 <= 0.0 {
        return Linear { mean: in_middle, ..Linear::default() };
    }
    let weight = |i: usize| 0.5 * (doubled_m2[i] + doubled_m2[(i + count - 1) % count]) / whole_m2;
    let linear = Linear::fit(corners.iter().enumerate().map(|(i, &(offset_m, value))| (offset_m, weight(i), value)));
    // What is left of the field beside its slope is zero in the middle, and grows with the square of the distance.
    let beside = |&(offset_m, value): &(DVec2, Rgb)| value - in_middle - (linear.at(offset_m) - linear.mean);
    let at_corners: Rgb = corners.iter().enumerate().map(|(i, corner)| weight(i) * beside(corner)).sum();
    let square_m2 = |i: usize| {
        let (p, q) = (corners[i].0, corners[(i + 1) % count].0);
        doubled_m2[i] / whole_m2 * (p.dot(p) + p.dot(q) + q.dot(q)) / 6.0
    };
    let over_area_m2: f64 = (0..count).map(square_m2).sum();
    let over_corners_m2: f64 = (0..count).map(|i| weight(i) * corners[i].0.length_squared()).sum();
    Linear { mean: in_middle + over_area_m2 / over_corners_m2 * at_corners, ..linear }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::MeshSettings;
    use crate::visibility::{Visibility, fixture};
    use glam::DVec3;

    #[test]
    fn the_mean_over_a_leaf_is_exact_to_its_degree() {
        let field = |p: DVec2| Rgb::splat(3.0 + p.x - 2.0 * p.y + p.x * p.x - 3.0 * p.x * p.y + 0.5 * p.y * p.y);
        let corners =
            |points: &[(f64, f64)]| points.iter().map(|&p| (DVec2::from(p), field(p.into()))).collect::<Vec<_>>();
        // Integrals of the squares by hand: a parallelogram with the half sides (2, 1) and (0, 1), and a triangle.
        let parallelogram = over_leaf(Rgb::splat(3.0), &corners(&[(-2.0, -2.0), (2.0, 0.0), (2.0, 2.0), (-2.0, 0.0)]));
        assert!((parallelogram.mean.x - (3.0 + 4.0 / 3.0 - 3.0 * 2.0 / 3.0 + 0.5 * 2.0 / 3.0)).abs() < 1e-12);
        let triangle = over_leaf(Rgb::splat(3.0), &corners(&[(-1.0, -1.0), (2.0, -1.0), (-1.0, 2.0)]));
        assert!((triangle.mean.x - (3.0 + 0.5 + 3.0 * 0.25 + 0.5 * 0.5)).abs() < 1e-12);
        assert!(over_leaf(Rgb::ONE, &corners(&[(0.0, 0.0), (0.0, 0.0), (0.0, 0.0)])).mean == Rgb::ONE);
    }

    /// How many leaves gathering adds to those of a room that glows, with a plate so far before one wall.
    fn splits_before_a_plate(gap_m: f64) -> usize {
        let mut polygons = fixture::inward_box(DVec3::ZERO, DVec3::ONE);
        polygons.extend(fixture::outward_box(DVec3::new(gap_m, 0.1, 0.1), DVec3::new(gap_m + 0.01, 0.9, 0.9)));
        let prepared = fixture::prepared(&polygons);
        let visibility = Visibility::new(&prepared);
        let mut mesh = Mesh::new(&prepared, &Table::new(), MeshSettings::default());
        for _ in 0..4 {
            let leaves: Vec<PatchId> = mesh.leaves().collect();
            leaves.into_iter().for_each(|leaf| assert!(mesh.split(leaf)));
        }
        // All that does not face the gap glows: it is bright at its mouth alone.
        let in_gap = |face| {
            let x = (prepared.origin_m + prepared.polygon_m(face)[0]).x;
            prepared.normal(face).x.abs() > 0.5 && x < gap_m + 1e-6
        };
        let glow = |face| Rgb::splat(if in_gap(face) { 0.0 } else { 1.0 });
        let glowing = mesh.patches().map(|(_, patch)| Linear { mean: glow(patch.face), ..Linear::default() });
        let reflected: Table<PatchId, Linear<Rgb>> = glowing.collect();
        let (sources, before) = (mesh.clone(), mesh.leaves().count());
        let light = Irradiance::new(&prepared, &visibility, &sources, &reflected, Rgb::ONE);
        let reflectance: Table<PatchId, Rgb> = vec![Rgb::splat(0.5); mesh.patch_count()].into();
        let evenness = Evenness { reflectance: &reflectance, tolerance: 0.01, bright: &[], in_middles_alone: false };
        let (places, nothing) = (Places::new(&prepared), BouncedLight::default());
        let silent = Progress::silent();
        let bounced = BouncedLight::gather(nothing, &mut mesh, &places, &light, evenness, silent).unwrap();
        assert!(bounced.leaves.keys().copied().eq(mesh.leaves()), "all leaves are known, and nothing else");
        mesh.leaves().count() - before
    }

    #[test]
    fn leaves_are_split_where_light_is_uneven_and_near_to_others() {
        let [narrow, wide] = [0.02, 0.45].map(splits_before_a_plate);
        assert!(narrow > 100 && wide < narrow / 2, "{narrow} and {wide}");
    }
}
