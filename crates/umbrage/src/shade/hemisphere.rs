//! What a point sees along rays that are spread over its hemisphere.
//!
//! Each ray stands for an equal share of the point's view: the leaf that it meets first brings so much of what it reflects there
//! (Keller, *Quasi-Monte Carlo radiosity*, 1996). What that errs falls with the number of rays, whatever the number of faces is: in a
//! scene of thousands it takes a fraction of the time that looking at each of them does ([`super::gathering`]). It has no direction,
//! and is independent from leaf to leaf; so of what many leaves reflect together nothing is left of it.
//!
//! Rays follow a lattice over the square, which is mapped to the disk (Shirley and Chiu, *A low distortion map between disk and
//! square*, 1997) and raised to the hemisphere. The lattice of each point is shifted by its position: at the same place it is always
//! the same, and no pattern runs over a wall.

use std::f64::consts::FRAC_PI_4;

use glam::{DVec2, DVec3};

use super::irradiance::{Irradiance, Terms};
use super::reflected::Term;
use crate::id::PatchId;
use crate::visibility::ReceiverPoint;

/// One over the golden ratio: its multiples fill the unit interval evenly, however many they are.
const GOLDEN: f64 = 0.618_033_988_749_895;
/// A ray ends so many times the extent of the scene away, outside.
const FAR_EXTENTS: f64 = 4.0;

impl Irradiance<'_> {
    /// The terms of what a point receives by reflection, as so many rays see it.
    pub(super) fn terms_along_rays(&self, receiver: &ReceiverPoint, count: usize) -> Terms {
        let frame = receiver.normal.any_orthonormal_pair();
        let far_m = FAR_EXTENTS * self.visibility.tolerance().extent_m;
        let shift = shift_of(receiver.position_m);
        let hit = |number: usize| {
            let [x, y] = on_disk(on_square(number, count, shift)).to_array();
            let height = (1.0 - x * x - y * y).max(0.0).sqrt();
            let direction = x * frame.0 + y * frame.1 + height * receiver.normal;
            let to_m = receiver.position_m + far_m * direction;
            let (face, at_m) = self.visibility.first_front_of(receiver, to_m)?;
            Some((self.mesh.leaf_at(face, at_m), self.mesh.frame(face).to_2d(at_m)))
        };
        let mut hits: Vec<(PatchId, DVec2)> = (0..count).filter_map(hit).collect();
        // Stable: hits of one leaf stay in the order of their rays.
        hits.sort_by_key(|&(leaf, _)| leaf);
        let term = |of_leaf: &[(PatchId, DVec2)]| {
            let (leaf, hits) = (of_leaf[0].0, of_leaf.len() as f64);
            let middle_m = of_leaf.iter().map(|(_, at_m)| *at_m).sum::<DVec2>() / hits;
            Term::new(leaf, hits / count as f64, middle_m - self.sources[leaf].middle_m)
        };
        Terms::of_patches(hits.chunk_by(|hit, next| hit.0 == next.0).map(term).collect())
    }
}

/// One of the points of a lattice over the unit square that is shifted around it.
fn on_square(number: usize, count: usize, shift: DVec2) -> DVec2 {
    let lattice = DVec2::new((number as f64 + 0.5) / count as f64, (number as f64 * GOLDEN).fract());
    (lattice + shift).fract()
}

/// The map from the unit square to the unit disk that keeps shares of area.
fn on_disk(square: DVec2) -> DVec2 {
    let p = 2.0 * square - 1.0;
    if p == DVec2::ZERO {
        return p;
    }
    let (radius, angle) =
        if p.x.abs() > p.y.abs() { (p.x, FRAC_PI_4 * p.y / p.x) } else { (p.y, FRAC_PI_4 * (2.0 - p.x / p.y)) };
    radius * DVec2::from_angle(angle)
}

/// A shift in the unit square that tells nothing of the position that it comes from, and is always the same there.
fn shift_of(position_m: DVec3) -> DVec2 {
    let mixed = position_m.to_array().into_iter().fold(0, |mixed: u64, coordinate| mix(mixed ^ coordinate.to_bits()));
    let share = |bits: u64| (bits >> 11) as f64 / (1_u64 << 53) as f64;
    DVec2::new(share(mixed), share(mix(mixed)))
}

/// A bijection after which every bit depends on all bits (Steele, Lea and Flood, *Fast splittable pseudorandom number generators*,
/// 2014).
fn mix(bits: u64) -> u64 {
    let next = bits.wrapping_add(0x9e37_79b9_7f4a_7c15);
    let once = (next ^ (next >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    let twice = (once ^ (once >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    twice ^ (twice >> 31)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::id::{FaceId, Table};
    use crate::mesh::{Mesh, MeshSettings};
    use crate::scene::Rgb;
    use crate::transport::Linear;
    use crate::visibility::{Visibility, fixture};

    #[test]
    fn the_map_to_the_disk_keeps_shares_of_area() {
        let count = 10_000;
        let points: Vec<DVec2> = (0..count).map(|i| on_disk(on_square(i, count, DVec2::new(0.3, 0.9)))).collect();
        for share in [0.1, 0.5, 0.9] {
            let within = points.iter().filter(|p| p.length_squared() < share).count() as f64 / f64::from(count as u32);
            let beside = points.iter().filter(|p| p.x < 0.0 && p.length_squared() < share).count() as f64;
            assert!((within - share).abs() < 0.005 && (beside / f64::from(count as u32) - 0.5 * share).abs() < 0.005);
        }
    }

    /// A room of faces that reflect each another radiosity, with boxes in it, and points on its floor: root mean square and mean of
    /// what rays err there, over the mean irradiance.
    fn errors(rays: usize) -> [f64; 2] {
        let mut polygons = fixture::inward_box(DVec3::ZERO, DVec3::new(4.0, 3.0, 2.0));
        for i in 0..20 {
            let low =
                DVec3::new(0.2 + 0.7 * f64::from(i % 5), 0.3 + 0.65 * f64::from(i / 5), 0.3 + 0.06 * f64::from(i));
            polygons.extend(fixture::outward_box(low, low + DVec3::new(0.3, 0.2, 0.1)));
        }
        let prepared = fixture::prepared(&polygons);
        let visibility = Visibility::new(&prepared);
        let mut mesh = Mesh::new(&prepared, &Table::new(), MeshSettings::default());
        for _ in 0..3 {
            mesh.leaves().collect::<Vec<PatchId>>().into_iter().for_each(|leaf| assert!(mesh.split(leaf)));
        }
        let bright = |face: FaceId| Rgb::splat(0.2 + (face.index() * 7 % 5) as f64);
        let reflecting = mesh.patches().map(|(_, patch)| Linear { mean: bright(patch.face), ..Linear::default() });
        let reflected: Table<PatchId, Linear<Rgb>> = reflecting.collect();
        let light = Irradiance::new(&prepared, &visibility, &mesh, &reflected, Rgb::splat(2.0)).coarser(1e-6);
        let count = 100;
        let floor = prepared.faces.keys().find(|&face| prepared.normal(face).z > 0.5).unwrap();
        let error = |i: u32| {
            let [s, t] = [0.618034, 0.754878].map(|step| (f64::from(i) * step).fract());
            let point = ReceiverPoint::on_face(&prepared, floor, DVec3::new(4.0 * s, 3.0 * t, 0.0));
            let terms = light.terms_along_rays(&point, rays);
            assert!((terms.factors() - 1.0).abs() < 1e-5, "no ray leaves a closed room");
            (light.sum_of(&terms) - light.indirect(&point)).x / light.mean
        };
        let errors: Vec<f64> = (1..=count).map(error).collect();
        let mean = errors.iter().sum::<f64>() / f64::from(count);
        [(errors.iter().map(|error| error * error).sum::<f64>() / f64::from(count)).sqrt(), mean]
    }

    #[test]
    fn more_rays_err_less_and_without_a_direction() {
        let [few, many] = [64, 1024].map(errors);
        assert!(few[0] < 0.12 && many[0] < 0.3 * few[0], "{few:?} {many:?}");
        assert!(few[1].abs() < 0.3 * few[0] && many[1].abs() < 0.3 * many[0], "{few:?} {many:?}");
    }
}
