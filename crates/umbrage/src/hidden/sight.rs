//! Rays that join regions: whatever a side sees first bounds the same region.
//!
//! A box that stands free in a room has no edge with it; a ray from the one meets the other. Rays also bear out what edges
//! say: where surfaces cross that should have been cut and were not, some ray passes from one region to the other, and
//! makes them one. Rays that meet nothing lead outside.

use std::sync::atomic::{AtomicUsize, Ordering};

use glam::{DVec2, DVec3};
use rayon::prelude::*;

use super::sides::{Sides, back, front};
use crate::geometry::polygon;
use crate::id::FaceId;
use crate::prepare::Prepared;
use crate::progress::{Cancelled, Progress, Stage};
use crate::visibility::{FirstMet, Visibility};

/// Rays from each side. A piece of a surface that reaches into another region is in it with its middle, or has a part of its own
/// there since contacts cut it.
const RAYS: usize = 6;
/// Faces between two reports of progress.
const FACES_A_REPORT: usize = 256;
/// A ray of so many extents from anywhere in the scene leaves it.
pub(super) const LEAVES_EXTENTS: f64 = 2.0;

/// Joins the sides that see each other.
pub(super) fn join(
    prepared: &Prepared,
    visibility: &Visibility,
    sides: &mut Sides,
    progress: Progress<'_>,
) -> Result<(), Cancelled> {
    let done = AtomicUsize::new(0);
    let seen: Vec<[[Option<usize>; RAYS]; 2]> = prepared
        .faces
        .raw
        .par_iter()
        .enumerate()
        .map(|(number, _)| {
            let done = done.fetch_add(1, Ordering::Relaxed);
            if done.is_multiple_of(FACES_A_REPORT) {
                progress.report(Stage::Prepare, done, prepared.faces.len())?;
            }
            Ok([true, false].map(|is_front| seen_from(prepared, visibility, number.into(), is_front)))
        })
        .collect::<Result<_, Cancelled>>()?;
    let outside = sides.outside();
    for (face, seen) in prepared.faces.keys().zip(seen) {
        // The back of a face that has an opposite one is that one's front.
        let own = [Some(front(face)), Some(back(face)).filter(|_| !sides.has_opposite(face))];
        for (own, seen) in own.into_iter().zip(seen) {
            if let Some(own) = own {
                seen.into_iter().for_each(|other| sides.join(own, other.unwrap_or(outside)));
            }
        }
    }
    Ok(())
}

/// The sides that rays from the middle of a side meet; `None` where they leave the scene.
fn seen_from(prepared: &Prepared, visibility: &Visibility, face: FaceId, is_front: bool) -> [Option<usize>; RAYS] {
    let normal = prepared.normal(face);
    let (normal, plane) = (if is_front { normal } else { -normal }, prepared.faces[face].plane);
    let (u, v) = normal.any_orthonormal_pair();
    let middle_m = polygon::centroid(&prepared.polygon_m(face));
    let length_m = LEAVES_EXTENTS * prepared.tolerance.extent_m;
    std::array::from_fn(|number| {
        let [x, y] = in_disc(number, face);
        let direction = x * u + y * v + (1.0 - x * x - y * y).max(0.0).sqrt() * normal;
        match visibility.first_met(middle_m, middle_m + length_m * direction, Some(plane)) {
            FirstMet::Front(face, _) => Some(front(face)),
            FirstMet::Back(face) => Some(back(face)),
            FirstMet::Nothing => None,
        }
    })
}

/// Points spread over the unit disc, the first in its middle; turned by the number of the face, so that neighbours look along other
/// ways.
fn in_disc(number: usize, face: FaceId) -> [f64; 2] {
    /// Turns of the golden angle spread points evenly whatever their number.
    const GOLDEN_RAD: f64 = 2.399_963_229_728_653;
    let radius = 0.98 * (number as f64 / RAYS as f64).sqrt();
    (radius * DVec2::from_angle(GOLDEN_RAD * number as f64 + face.index() as f64)).to_array()
}

/// Directions spread evenly over the sphere.
pub(super) fn over_sphere(count: usize) -> impl Iterator<Item = DVec3> {
    (0..count).map(move |number| {
        let z = 1.0 - (2 * number + 1) as f64 / count as f64;
        let around = DVec2::from_angle(std::f64::consts::PI * (3.0 - 5.0_f64.sqrt()) * number as f64);
        ((1.0 - z * z).sqrt() * around).extend(z)
    })
}
