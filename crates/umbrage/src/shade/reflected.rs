//! What the visible part of a source reflects towards a point: a sum down the source's patches.
//!
//! Lambert's sum is linear in polygons. So the part of a face that a point sees is found once, as its outline less shadows, and cut
//! along the cuts of its patches. A patch stands for its parts where the difference is a trifle. A leaf that varies by
//! more is taken in slices across its gradient:
//!
//! ```text
//!    ____________________          ##  in shadow, as seen from the point: taken from what it lies on
//!   |        |    |######|
//!   |  one   | two|#.....|         the cuts are those of the patch tree, the values its radiosity
//!   |________|____|______|
//! ```
//!
//! Most patches are seen whole: of these all but the factor is known beforehand.

use glam::{DMat2, DVec2};
use serde::{Deserialize, Serialize};

use super::part::{Part, Pieces};
use crate::geometry::convex::{self, Convex, Line, Moments};
use crate::id::{PatchId, Table};
use crate::mesh::Mesh;
use crate::scene::Rgb;
use crate::transport::Linear;
use crate::transport::form_factor::factor_in_view;
use crate::visibility::{PlaneView, Seen, Shadows};

/// A patch stands for its parts, and a slice for its points, where that changes irradiance by no more than this share of
/// its mean, at the default tolerance: a point gathers over some hundred patches, whose errors partly cancel.
const TRIFLE_OF_MEAN: f64 = 1e-4;
/// A leaf is sliced into at most two to this power.
const MOST_HALVINGS: usize = 3;

/// No factor is more than 1, but for rounding.
const MOST_FACTOR: f32 = 1.001;

/// The middle that is seen lies within this share of a part's reach from its centroid: next to the horizon the factor
/// changes by more than an exponential tells.
const MOST_SHIFT: f64 = 0.5;

/// How the radiosity of a patch varies, in the worst colour, in W/m2.
#[derive(Clone, Copy, Debug, Default)]
struct Variation {
    /// How far its linear fit departs from the mean.
    linear: f64,
    /// How far the radiosity of its leaves departs from its linear fit.
    departure: f64,
}

/// A patch in the frame of its face.
#[derive(Clone, Debug)]
pub(super) struct FlatPatch {
    pub(super) corners_m: Convex,
    pub(super) centroid_m: DVec2,
    /// Area mean of the outer product of the offset from the centroid with itself, in square metres.
    spread_m2: DMat2,
    /// The line that cuts it in two, with the first part to its left.
    cut: Option<(Line, [PatchId; 2])>,
}

impl FlatPatch {
    fn of(mesh: &Mesh, patch: PatchId) -> Self {
        let frame = mesh.frame(mesh.patch(patch).face);
        let corners_m: Convex = mesh.polygon_2d_m(patch).into();
        let middle = Moments::of(&corners_m).centroid_and_spread();
        let (centroid_m, spread_m2) =
            middle.unwrap_or_else(|| (frame.to_2d(mesh.patch(patch).centroid_m), DMat2::ZERO));
        let line = mesh.cut_m(patch).map(|ends| Line::through(frame.to_2d(ends[0]), frame.to_2d(ends[1])));
        Self { corners_m, centroid_m, spread_m2, cut: line.zip(mesh.patch(patch).subpatches) }
    }
}

/// What a patch, or a part of it, brings to a point: a factor times its linear fit at one of its points.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct Term {
    pub(super) patch: PatchId,
    pub(super) factor: f32,
    /// From the centroid of the patch, in metres.
    offset_m: [f32; 2],
}

impl Term {
    pub(super) fn new(patch: PatchId, factor: f64, offset_m: DVec2) -> Self {
        Self { patch, factor: factor as f32, offset_m: offset_m.as_vec2().to_array() }
    }

    /// Whether its patch is one of so many, its factor is one, and its point lies in a scene of this extent.
    pub(super) fn fits(&self, patches: usize, extent_m: f64) -> bool {
        let is_inside = self.offset_m.iter().all(|&offset_m| f64::from(offset_m).abs() <= 2.0 * extent_m);
        self.patch.index() < patches && (0.0..=MOST_FACTOR).contains(&self.factor) && is_inside
    }

    /// What it brings where patches reflect `radiosity`, in W/m2.
    pub(super) fn of(&self, radiosity: &Table<PatchId, Linear<Rgb>>) -> Rgb {
        f64::from(self.factor) * radiosity[self.patch].at(self.offset_m())
    }

    /// Where on the patch it is taken, from its centroid, in metres.
    pub(super) fn offset_m(&self) -> DVec2 {
        self.offset_m.map(f64::from).into()
    }
}

/// What patches reflect.
#[derive(Debug)]
pub(super) struct Reflected<'a> {
    flat: Table<PatchId, FlatPatch>,
    /// Radiosity by reflection, `B - M`, in W/m2.
    radiosity: &'a Table<PatchId, Linear<Rgb>>,
    variation: Table<PatchId, Variation>,
    /// A change of irradiance that does not matter, in W/m2.
    trifle: f64,
}

impl<'a> Reflected<'a> {
    /// What the patches of `mesh` reflect, for points whose mean irradiance is `mean`, in W/m2.
    pub(super) fn new(mesh: &'a Mesh, radiosity: &'a Table<PatchId, Linear<Rgb>>, mean: f64) -> Self {
        let flat: Table<PatchId, FlatPatch> = mesh.patches().map(|(patch, _)| FlatPatch::of(mesh, patch)).collect();
        let mut variation: Table<PatchId, Variation> = vec![Variation::default(); mesh.patch_count()].into();
        for index in (0..mesh.patch_count()).rev() {
            let id = PatchId::from(index);
            let greatest = |of: PatchId, change: &dyn Fn(DVec2) -> Rgb| {
                flat[of].corners_m.iter().map(|&corner| change(corner).abs().max_element()).fold(0.0, f64::max)
            };
            let at = |patch: PatchId, corner: DVec2| radiosity[patch].at(corner - flat[patch].centroid_m);
            let linear = greatest(id, &|corner| at(id, corner) - radiosity[id].mean);
            let from_part =
                |part: PatchId| greatest(part, &|corner| at(id, corner) - at(part, corner)) + variation[part].departure;
            let departure = flat[id].cut.map_or(0.0, |(_, [left, right])| from_part(left).max(from_part(right)));
            variation[id] = Variation { linear, departure };
        }
        Self { flat, radiosity, variation, trifle: TRIFLE_OF_MEAN * mean }
    }

    /// The same, where a change that is so many times greater does not matter either.
    pub(super) fn coarser(self, times: f64) -> Self {
        Self { trifle: times * self.trifle, ..self }
    }

    /// Radiosity by reflection, in W/m2.
    pub(super) fn radiosity(&self) -> &'a Table<PatchId, Linear<Rgb>> {
        self.radiosity
    }

    /// A patch in the frame of its face.
    pub(super) fn flat(&self, patch: PatchId) -> &FlatPatch {
        &self.flat[patch]
    }

    /// The parts that a patch is split into.
    pub(super) fn subpatches(&self, patch: PatchId) -> Option<[PatchId; 2]> {
        self.flat[patch].cut.map(|(_, subpatches)| subpatches)
    }

    /// The most that a patch reflects anywhere, in the brightest colour, in W/m2.
    pub(super) fn greatest(&self, patch: PatchId) -> f64 {
        let Variation { linear, departure } = self.variation[patch];
        self.radiosity[patch].mean.abs().max_element() + linear + departure
    }

    /// Whether the linear fit of a patch tells what all of it reflects well enough for a point with this factor to it.
    pub(super) fn is_linear(&self, patch: PatchId, factor: f64) -> bool {
        factor * self.variation[patch].departure <= self.trifle
    }

    /// Whether the light of a patch departs from its linear fit by more than so many trifles for a point with this factor to it.
    pub(super) fn departs(&self, patch: PatchId, factor: f64, trifles: f64) -> bool {
        factor * factor.sqrt() * self.variation[patch].departure > trifles * self.trifle
    }

    /// What a term brings, in W/m2.
    pub(super) fn of(&self, term: &Term) -> Rgb {
        term.of(self.radiosity)
    }

    /// Adds the terms of what a point sees of a patch.
    pub(super) fn add_terms(&self, view: &PlaneView, patch: PatchId, seen: Seen, terms: &mut impl FnMut(Term)) {
        if seen.whole && seen.shadows.is_empty() {
            let factor = factor_in_view(view, &self.flat[patch].corners_m);
            return self.add_whole(view, patch, factor, terms);
        }
        let mut pieces = Pieces::new(view);
        let part = pieces.part(seen.outline, seen.shadows);
        self.add_part(&mut pieces, patch, &part, seen.whole, terms);
    }

    /// Adds the terms of a patch of which all is seen.
    fn add_whole(&self, view: &PlaneView, patch: PatchId, factor: f64, terms: &mut impl FnMut(Term)) {
        if factor <= 0.0 {
            return;
        }
        let flat = &self.flat[patch];
        if self.is_trifle(patch, factor, factor.sqrt()) {
            return terms(self.term_of_whole(view, patch, factor));
        }
        let Some((_, [left, right])) = flat.cut else {
            let mut pieces = Pieces::new(view);
            let part = pieces.part(flat.corners_m.clone(), Shadows::new());
            return self.add_slices(&mut pieces, patch, &part, MOST_HALVINGS, terms);
        };
        let of_left = factor_in_view(view, &self.flat[left].corners_m);
        self.add_whole(view, left, of_left, terms);
        self.add_whole(view, right, factor - of_left, terms);
    }

    /// Adds the terms of a part of a patch, of which `above_horizon` is all or not.
    fn add_part(
        &self,
        pieces: &mut Pieces<'_>,
        patch: PatchId,
        part: &Part,
        above_horizon: bool,
        terms: &mut impl FnMut(Term),
    ) {
        let factor = pieces.factor(part);
        if factor <= 0.0 {
            return;
        }
        if above_horizon && part.is_clear() {
            return self.add_whole(pieces.view, patch, factor, terms);
        }
        let dark = pieces.dark_share(part);
        let taken = if above_horizon { dark.min(1.0 - dark) } else { 1.0 };
        if self.is_trifle(patch, factor, (factor.sqrt() + taken).min(1.0)) {
            return terms(self.term_of_part(pieces, patch, part, factor));
        }
        let Some((line, subpatches)) = &self.flat[patch].cut else {
            return self.add_slices(pieces, patch, part, MOST_HALVINGS, terms);
        };
        for (half, &subpatch) in pieces.halves(part, line).iter().zip(subpatches) {
            if let Some(half) = half {
                self.add_part(pieces, subpatch, half, above_horizon, terms);
            }
        }
    }

    /// Adds the terms of a part of a leaf, in slices across its gradient.
    fn add_slices(
        &self,
        pieces: &mut Pieces<'_>,
        leaf: PatchId,
        part: &Part,
        halvings_left: usize,
        terms: &mut impl FnMut(Term),
    ) {
        let factor = pieces.factor(part);
        if factor <= 0.0 {
            return;
        }
        let gradient = self.radiosity[leaf].gradient;
        let left = DVec2::from(gradient.map(Rgb::element_sum)).normalize_or_zero();
        let (low_m, high_m) = convex::heights_m(pieces.outline_m(part), &Line { from_m: DVec2::ZERO, left });
        let slope = gradient.iter().map(|g| g.abs()).sum::<Rgb>().max_element();
        if halvings_left == 0 || factor * factor * slope * 0.5 * (high_m - low_m) <= self.trifle {
            return terms(self.term_of_part(pieces, leaf, part, factor));
        }
        let line = Line { from_m: 0.5 * (low_m + high_m) * left, left };
        for half in pieces.halves(part, &line).iter().flatten() {
            self.add_slices(pieces, leaf, half, halvings_left - 1, terms);
        }
    }

    /// All of a patch in one term.
    pub(super) fn term_of_whole(&self, view: &PlaneView, patch: PatchId, factor: f64) -> Term {
        let flat = &self.flat[patch];
        let middle_m = seen_middle_m(view, flat.centroid_m, flat.spread_m2, &flat.corners_m);
        Term::new(patch, factor, middle_m - flat.centroid_m)
    }

    /// A part of a patch in one term.
    fn term_of_part(&self, pieces: &Pieces<'_>, patch: PatchId, part: &Part, factor: f64) -> Term {
        let middle = pieces.moments(part).centroid_and_spread().map(|(centroid_m, spread_m2)| {
            seen_middle_m(pieces.view, centroid_m, spread_m2, pieces.outline_m(part)) - self.flat[patch].centroid_m
        });
        Term::new(patch, factor, middle.unwrap_or_default())
    }

    /// Whether a patch's linear fit is as good as its parts. The fit is taken at the middle of what is seen of it, weighted
    /// by the factor to second order: what is left goes with the square of the angle that it spans, which the factor is. What
    /// departs from the fit has no mean over the patch: the share `departing` of it is left, which goes with that angle where
    /// all is seen, and is at most what is taken or what is left of the patch.
    fn is_trifle(&self, patch: PatchId, factor: f64, departing: f64) -> bool {
        let Variation { linear, departure } = self.variation[patch];
        factor * (factor * linear + departing * departure) <= self.trifle
    }
}

/// The middle of a part of a source, weighted by the factor `cos cos / r^2` of each of its points, which is taken to be
/// exponential over the part.
fn seen_middle_m(view: &PlaneView, centroid_m: DVec2, spread_m2: DMat2, outline: &[DVec2]) -> DVec2 {
    let towards = view.towards_m(centroid_m);
    let growth =
        view.normal.truncate() / view.normal.dot(towards) - 4.0 * towards.truncate() / towards.length_squared();
    let shift = spread_m2 * growth;
    let reach_squared = outline.iter().map(|&p| p.distance_squared(centroid_m)).fold(0.0, f64::max);
    // On the horizon itself the factor's growth is infinite.
    let shift = shift.clamp_length_max(MOST_SHIFT * reach_squared.sqrt());
    centroid_m + if shift.is_finite() { shift } else { DVec2::ZERO }
}
