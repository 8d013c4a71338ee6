//! Leaves that reflect much of all light by themselves: what they send arrives once, no more and no less.
//!
//! A lamp in the corner of a room makes a few leaves around it thousands of times as bright as all others. They light each other across
//! the corner, where a few points of each tell little of a mean, and each bounce would make light, or lose it, by a large factor. What
//! such a leaf sends is known: its power, times the share of its view in which there are fronts of surfaces, by rays. What all leaves
//! receive of it together is a sum of the same terms that light is gathered by. Where the two differ, the terms of that leaf are scaled.
//!
//! Holds after: of the light of each bright leaf what arrives is what is sent, and a bounce brings no more than is reflected. Where no leaf
//! is bright, and no light is made, nothing changes.

use std::collections::BTreeMap;

use super::irradiance::{Irradiance, Terms};
use crate::geometry::polygon;
use crate::id::{PatchId, Table};
use crate::mesh::Mesh;
use crate::scene::Rgb;
use crate::transport::{Linear, cosine_direction};
use crate::visibility::FirstMet;

/// A leaf that reflects more than this share of all that is reflected is bright. Below it, what one leaf errs by does not show in the
/// account of energy; in rooms that are lit as usual no leaf is bright.
const BRIGHT_OF_ALL: f64 = 0.02;
/// Bounces that bring more than what is reflected by this share make light: then leaves that reflect so much of all are bright.
const MOST_MADE: f64 = 0.02;
const BRIGHT_OF_MADE: f64 = 1e-5;
/// What arrives of its light may be more or less than what it sends by this share: as much as few points of large leaves commonly err.
const MAY_ERR: f64 = 0.05;
/// Scales stay within this factor either way: what arrives of a leaf without the scaled terms is not told by them.
const MOST_SCALE: f64 = 10.0;
/// Rays of one leaf: they tell the share that fronts fill to about 1 %, and of a closed room exactly.
const RAYS: usize = 512;
/// A ray is so many times as long as the scene.
const OUTSIDE_EXTENTS: f64 = 2.0;
/// Powers of the inverse of the golden ratio: the steps of even sequences that do not march together.
const STEPS: [f64; 3] = [0.618_033_988_749_895, 0.236_067_977_499_790, 0.145_898_033_750_315];

/// The bright leaves of a gathering.
#[derive(Debug, Default)]
pub(super) struct BrightLeaves {
    /// The share of its view in which a leaf sees fronts of surfaces, where it is known.
    on_fronts: BTreeMap<PatchId, f64>,
}

impl BrightLeaves {
    /// What patches reflect, in W/m2, with that of bright leaves scaled so that as much of it arrives as they send; `None` where there
    /// is nothing to scale. All leaves together receive `received_w` of it, over the three colours. `points` are the terms of all points,
    /// with the area of the leaves that each stands for, in square metres.
    pub(super) fn scaled<'t>(
        &mut self,
        light: &Irradiance<'_>,
        radiosity: &Table<PatchId, Linear<Rgb>>,
        received_w: f64,
        points: impl FnOnce() -> Vec<(&'t Terms, f64)>,
    ) -> Option<Table<PatchId, Linear<Rgb>>> {
        let mesh = light.mesh();
        let power_w = |patch: PatchId| mesh.patch(patch).area_m2 * radiosity[patch].mean.element_sum();
        let all_w: f64 = mesh.leaves().map(|leaf| power_w(leaf).max(0.0)).sum();
        let is_made = received_w > (1.0 + MOST_MADE) * all_w;
        let least_w = if is_made { BRIGHT_OF_MADE } else { BRIGHT_OF_ALL } * all_w;
        let bright: Vec<PatchId> = mesh.leaves().filter(|&leaf| power_w(leaf) > least_w).collect();
        if bright.is_empty() {
            return None;
        }
        let mut of_patch_w: BTreeMap<PatchId, f64> =
            bright.iter().flat_map(|&leaf| with_those_around(mesh, leaf)).map(|patch| (patch, 0.0)).collect();
        for (terms, area_m2) in points() {
            for term in terms.patches() {
                if let Some(of_patch_w) = of_patch_w.get_mut(&term.patch) {
                    *of_patch_w += area_m2 * term.of(radiosity).element_sum();
                }
            }
        }
        let mut scaled: Option<Table<PatchId, Linear<Rgb>>> = None;
        let mut left_w = received_w;
        for leaf in bright {
            // Of those that are not bright by themselves it matters alone whether they make light.
            let is_bright = power_w(leaf) > BRIGHT_OF_ALL * all_w;
            let on_fronts = match is_bright {
                true => *self.on_fronts.entry(leaf).or_insert_with(|| share_on_fronts(light, leaf)),
                false => 1.0,
            };
            let sent_w = on_fronts * power_w(leaf);
            // What points take of it in the sum of a larger patch.
            let of_larger = |patch: PatchId| of_patch_w[&patch] * power_w(leaf) / power_w(patch);
            let with_larger_w: f64 = with_those_around(mesh, leaf).skip(1).map(of_larger).sum();
            let by_itself_w = of_patch_w[&leaf];
            if (by_itself_w + with_larger_w - sent_w).abs() <= MAY_ERR * sent_w || by_itself_w <= 0.0 {
                continue;
            }
            let most = if is_bright { MOST_SCALE } else { 1.0 };
            let scale = ((sent_w - with_larger_w) / by_itself_w).clamp(1.0 / MOST_SCALE, most);
            left_w -= (1.0 - scale) * by_itself_w;
            let of = &mut scaled.get_or_insert_with(|| radiosity.clone())[leaf];
            *of = times(scale, of);
        }
        if left_w > (1.0 + MOST_MADE) * all_w {
            let scaled = scaled.get_or_insert_with(|| radiosity.clone());
            scaled.iter_mut().for_each(|of| *of = times(all_w / left_w, of));
        }
        scaled
    }
}

/// A linear function, times a number.
fn times(scale: f64, of: &Linear<Rgb>) -> Linear<Rgb> {
    Linear { mean: scale * of.mean, gradient: of.gradient.map(|slope| scale * slope) }
}

/// A patch, and those that it is a part of.
fn with_those_around(mesh: &Mesh, patch: PatchId) -> impl Iterator<Item = PatchId> + '_ {
    std::iter::successors(Some(patch), |&patch| mesh.patch(patch).parent)
}

/// The share of the view of a leaf in which there are fronts of surfaces.
fn share_on_fronts(light: &Irradiance<'_>, leaf: PatchId) -> f64 {
    let (mesh, prepared) = (light.mesh(), light.prepared());
    let face = mesh.patch(leaf).face;
    let (corners_m, plane) = (mesh.polygon_m(leaf), prepared.faces[face].plane);
    let outside_m = OUTSIDE_EXTENTS * prepared.tolerance.extent_m;
    let is_on_front = |number: &usize| {
        let even = (*number as f64 + 0.5) / RAYS as f64;
        let [s, t, around] = STEPS.map(|step| (0.5 + step * *number as f64).fract());
        let from_m = polygon::point_of(&corners_m, s, t);
        let to_m = from_m + outside_m * cosine_direction(prepared.normal(face), even, around);
        matches!(light.visibility.first_met(from_m, to_m, Some(plane)), FirstMet::Front(..))
    };
    (0..RAYS).filter(is_on_front).count() as f64 / RAYS as f64
}
