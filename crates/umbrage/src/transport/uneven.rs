//! Patches over which direct light is uneven are split further, once links are made: a spot of light on a wall, or a shadow, is then
//! reflected from where it lies.
//!
//! The oracle knows form factors and coarse brightness only; a patch that it leaves whole may hold a spot of light which a linear
//! function over the patch spreads, or misses. Links stay at their nodes; the new leaves hand what they reflect up, and are
//! gathered from as all others are. Leaves around uneven ones are split until they are about as small: what few sample points miss
//! lies across a border.
//!
//! A small bright place falls between sample points. So light is followed from its sources, too ([`super::bright_places`]): a leaf
//! whose fit is darker than light that falls there is uneven.
//!
//! After: on no leaf but the smallest does direct light depart from a linear function by more than a share of all that is reflected,
//! as far as its sample points tell, and its bright places.

use std::collections::BTreeSet;
use std::f64::consts::PI;
use std::sync::atomic::{AtomicUsize, Ordering};

use glam::DVec2;
use rayon::prelude::*;

use super::direct::DirectLight;
use super::places_of_leaves::PlacesOfLeaves;
use crate::id::PatchId;
use crate::mesh::Mesh;
use crate::prepare::Prepared;
use crate::progress::{Cancelled, Progress, Stage};
use crate::scene::{Rgb, Scene};

/// What departs from a linear function on one patch may be this share of all direct light that is reflected.
const UNEVEN_OF_ALL: f64 = 2e-4;
/// Rounds of splits: a patch may get as small as by so many halvings.
const MOST_ROUNDS: usize = 14;

/// Directions in which leaves around a leaf are looked for, and how far from its middle, in its radii.
const DIRECTIONS: u32 = 8;
const BEYOND: f64 = 1.1;
/// A leaf around an uneven one is split where it has more than so many times its area.
const LARGER: f64 = 2.5;

/// What a leaf reflects of direct light, in W over the three colours.
struct Lit {
    leaf: PatchId,
    whole_w: f64,
    /// What of it departs from a linear function, or is uncertain.
    departing_w: f64,
}

/// The leaves around a leaf of a face that are larger: the sample points of these may miss what lies across their border.
fn larger_around(mesh: &Mesh, leaf: PatchId) -> impl Iterator<Item = PatchId> + '_ {
    let patch = mesh.patch(leaf);
    let (frame, corners_m) = (mesh.frame(patch.face), mesh.polygon_m(leaf));
    let radius_m = corners_m.iter().map(|corner_m| corner_m.distance(patch.centroid_m)).fold(0.0, f64::max);
    let directions = (0..DIRECTIONS).map(|i| DVec2::from_angle(2.0 * PI * f64::from(i) / f64::from(DIRECTIONS)));
    let beyond_m = directions.map(move |way| BEYOND * radius_m * (way.x * frame.u + way.y * frame.v));
    beyond_m
        .map(move |beyond_m| mesh.leaf_at(patch.face, patch.centroid_m + beyond_m))
        .filter(move |&other| mesh.patch(other).area_m2 > LARGER * patch.area_m2)
}

/// Splits the leaves over which direct light is uneven.
///
/// # Errors
/// [`Cancelled`] where `progress` asks to stop; the mesh is then split in part.
pub fn split_where_uneven(
    scene: &Scene,
    prepared: &Prepared,
    direct: &DirectLight<'_>,
    mesh: &mut Mesh,
    progress: Progress<'_>,
) -> Result<(), Cancelled> {
    let sent = direct.light_sent();
    let mut places = PlacesOfLeaves::new(mesh, &sent.places);
    // Every round has about half of the work that is left.
    let done = AtomicUsize::new(0);
    let reflected_w = |mesh: &Mesh, places: &PlacesOfLeaves<'_>, leaf: PatchId| {
        let done = done.fetch_add(1, Ordering::Relaxed);
        progress.report(Stage::Transport, done, done + mesh.patch_count())?;
        let patch = mesh.patch(leaf);
        let reflectance = scene.materials[prepared.faces[patch.face].material].reflectance;
        let in_watts = |irradiance: Rgb| patch.area_m2 * (reflectance * irradiance).element_sum();
        let [whole_w, departing_w] = direct.mean_and_departure(mesh, leaf, &places.of(leaf)).map(in_watts);
        Ok(Lit { leaf, whole_w, departing_w })
    };
    let leaves: Vec<PatchId> = mesh.leaves().collect();
    let mut open =
        leaves.par_iter().map(|&leaf| reflected_w(mesh, &places, leaf)).collect::<Result<Vec<Lit>, Cancelled>>()?;
    let least_w = UNEVEN_OF_ALL * open.iter().map(|lit| lit.whole_w).sum::<f64>();
    for _ in 0..MOST_ROUNDS {
        open.retain(|lit| lit.departing_w > least_w);
        let mut around: BTreeSet<PatchId> = open.iter().flat_map(|lit| larger_around(mesh, lit.leaf)).collect();
        for lit in &open {
            around.remove(&lit.leaf);
        }
        let around: Vec<PatchId> = around.into_iter().collect();
        let around =
            around.par_iter().map(|&leaf| reflected_w(mesh, &places, leaf)).collect::<Result<Vec<Lit>, Cancelled>>()?;
        open.extend(around);
        open.retain(|lit| mesh.split(lit.leaf));
        places.hand_down(mesh);
        let halves = |lit: &Lit| {
            let Some([first, second]) = mesh.patch(lit.leaf).subpatches else { return Ok(None) };
            let mut halves = [reflected_w(mesh, &places, first)?, reflected_w(mesh, &places, second)?];
            // What the halves tell otherwise than the whole lies between their sample points, too.
            let missed_w = (lit.whole_w - halves[0].whole_w - halves[1].whole_w).abs();
            halves.iter_mut().for_each(|half| half.departing_w = half.departing_w.max(missed_w));
            Ok(Some(halves))
        };
        let halves = open.par_iter().map(halves).collect::<Result<Vec<_>, Cancelled>>()?;
        open = halves.into_iter().flatten().flatten().collect();
        if open.is_empty() {
            break;
        }
    }
    Ok(())
}
