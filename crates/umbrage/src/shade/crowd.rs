//! What a crowd of faces reflects towards a point far away, as if it were in one place.
//!
//! A face of area `A` with the normal `n` and the radiosity `B` sends `A B max(0, n . w)` in the direction `w`. Of many faces that is
//! a function on the sphere which three moments of their normals tell: `max(0, x)` is nearly `3/32 + x/2 + 15/32 x^2`, the first
//! terms of its expansion in spherical harmonics (Ramamoorthi and Hanrahan, *An efficient representation for irradiance environment
//! maps*, 2001).
//!
//! Whether a crowd is seen one ray tells, to one of its faces: which one is drawn by lot, in proportion to what they send to the point.
//! The lots of a crowd are always the same; so what a few crowds err has no direction, and does not change from point to point.

use std::ops::AddAssign;

use glam::DVec3;
use serde::{Deserialize, Serialize};

use crate::id::{ClusterId, FaceId, Table};
use crate::scene::Rgb;
use crate::visibility::{Cluster, Visibility};

/// Moments of the normals of a crowd, weighted by what its faces reflect, in W.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Crowd {
    whole: Rgb,
    /// Of `n_x`, `n_y`, `n_z`.
    first: [Rgb; 3],
    /// Of `n_x n_x`, `n_y n_y`, `n_z n_z`, `n_x n_y`, `n_y n_z`, `n_z n_x`.
    second: [Rgb; 6],
}

impl Crowd {
    /// Of one face that reflects `power`, in W.
    pub(super) fn of_face(normal: DVec3, power: Rgb) -> Self {
        let [x, y, z] = normal.to_array();
        Self {
            whole: power,
            first: [x, y, z].map(|weight| weight * power),
            second: [x * x, y * y, z * z, x * y, y * z, z * x].map(|weight| weight * power),
        }
    }

    /// What is sent in the direction `towards`, in W; over pi and the square of the distance it is irradiance on what faces the crowd.
    pub(super) fn sent(&self, towards: DVec3) -> Rgb {
        let [x, y, z] = towards.to_array();
        let first = x * self.first[0] + y * self.first[1] + z * self.first[2];
        let squares = x * x * self.second[0] + y * y * self.second[1] + z * z * self.second[2];
        let products = x * y * self.second[3] + y * z * self.second[4] + z * x * self.second[5];
        let sent = 3.0 / 32.0 * self.whole + 0.5 * first + 15.0 / 32.0 * (squares + 2.0 * products);
        sent.max(Rgb::ZERO)
    }
}

impl AddAssign for Crowd {
    fn add_assign(&mut self, other: Self) {
        self.whole += other.whole;
        self.first.iter_mut().zip(other.first).for_each(|(mine, others)| *mine += others);
        self.second.iter_mut().zip(other.second).for_each(|(mine, others)| *mine += others);
    }
}

/// What a crowd brings to a point: a factor times what it sends there.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct CrowdTerm {
    crowd: ClusterId,
    /// Cosine at the receiver over pi and the square of the distance, per square metre.
    factor_per_m2: f32,
    /// The direction from the crowd to the receiver.
    towards: [f32; 3],
}

impl CrowdTerm {
    /// Whether its crowd is one of so many, and its numbers can be what they say.
    pub(super) fn fits(&self, clusters: usize) -> bool {
        let is_unit = self.towards.iter().all(|x| x.abs() <= 1.001);
        self.crowd.index() < clusters && self.factor_per_m2 >= 0.0 && self.factor_per_m2.is_finite() && is_unit
    }

    /// What it brings where crowds are these, in W/m2.
    pub(super) fn of(&self, crowds: &Table<ClusterId, Crowd>) -> Rgb {
        let towards = DVec3::from(self.towards.map(f64::from));
        f64::from(self.factor_per_m2) * crowds[self.crowd].sent(towards)
    }
}

/// A crowd as a point sees it.
#[derive(Clone, Copy, Debug)]
pub(super) struct CrowdView {
    /// From the receiver point to its middle, in metres.
    along_m: DVec3,
    /// Mean of the heights of its points over the receiver's plane, those below counted as in it, in metres.
    over_m: f64,
    /// The most irradiance that it could bring with 1 W, per square metre.
    most_per_m2: f64,
    /// Whether it is so far away that it is nearly in one place.
    is_far: bool,
}

/// A crowd farther away than so many of its radii is in one place.
const FAR_RADII: f64 = 4.0;

impl CrowdView {
    /// The view from a point on a plane with this unit normal; `None` where the crowd is below its horizon.
    pub(super) fn new(position_m: DVec3, normal: DVec3, cluster: &Cluster) -> Option<Self> {
        let along_m = cluster.middle_m - position_m;
        let (height_m, reach_m) = (normal.dot(along_m), normal.abs().dot(cluster.half_m));
        if height_m + reach_m <= 0.0 {
            return None;
        }
        let distance_m = cluster.distance_from_m(position_m);
        let cosine = ((height_m + reach_m) / distance_m).min(1.0);
        let above_m = height_m + reach_m;
        Some(Self {
            along_m,
            over_m: if height_m >= reach_m { height_m } else { above_m * above_m / (4.0 * reach_m) },
            most_per_m2: cosine / (std::f64::consts::PI * distance_m * distance_m),
            is_far: along_m.length_squared() >= FAR_RADII * FAR_RADII * cluster.half_m.length_squared(),
        })
    }

    /// The most that a crowd of `most` watts could bring if it is seen as one, in W/m2; `None` where it is too near for that.
    pub(super) fn most(&self, most: f64) -> Option<f64> {
        self.is_far.then_some(most * self.most_per_m2)
    }

    /// The unit vector from the crowd to the point.
    pub(super) fn towards(&self) -> DVec3 {
        -self.along_m.normalize_or_zero()
    }

    /// The term of a crowd that is seen.
    pub(super) fn term(&self, crowd: ClusterId) -> CrowdTerm {
        let squared_m2 = self.along_m.length_squared();
        let factor_per_m2 = self.over_m / (std::f64::consts::PI * squared_m2 * squared_m2.sqrt());
        CrowdTerm { crowd, factor_per_m2: factor_per_m2 as f32, towards: self.towards().as_vec3().to_array() }
    }
}

/// The face of a crowd that is drawn, in proportion to what each sends in a direction, which `sent` tells of a single face;
/// `None` where none sends anything.
pub(super) fn drawn(
    visibility: &Visibility,
    crowds: &Table<ClusterId, Crowd>,
    sent: impl Fn(FaceId) -> f64,
    crowd: ClusterId,
    towards: DVec3,
) -> Option<FaceId> {
    // The golden ratio spreads the lots of any run of crowds evenly.
    let mut lot = (crowd.index() as f64 * GOLDEN).fract();
    let mut cluster = crowd;
    while let Some([first, second]) = visibility.cluster(cluster).parts {
        let [of_first, of_second] = [first, second].map(|part| crowds[part].sent(towards).element_sum());
        let share = if of_first + of_second > 0.0 { of_first / (of_first + of_second) } else { 0.5 };
        (cluster, lot) = if lot < share { (first, lot / share) } else { (second, (lot - share) / (1.0 - share)) };
    }
    let mut left = lot * visibility.cluster_faces(cluster).map(&sent).sum::<f64>();
    let mut last = None;
    for face in visibility.cluster_faces(cluster).filter(|&face| sent(face) > 0.0) {
        last = Some(face);
        left -= sent(face);
        if left < 0.0 {
            break;
        }
    }
    last
}

/// The golden ratio less 1.
const GOLDEN: f64 = 0.618_033_988_749_895;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn moments_tell_what_a_crowd_of_faces_sends() {
        // Faces turned every way, as on a sphere: each direction has a quarter of the power.
        let count = 1000;
        let mut sphere = Crowd::default();
        for i in 0..count {
            let z = 1.0 - (2.0 * f64::from(i) + 1.0) / f64::from(count);
            let (sine, cosine) = (f64::from(i) * 2.399963).sin_cos();
            let normal = DVec3::new((1.0 - z * z).sqrt() * cosine, (1.0 - z * z).sqrt() * sine, z);
            sphere += Crowd::of_face(normal, Rgb::splat(1.0 / f64::from(count)));
        }
        for towards in [DVec3::X, DVec3::NEG_Z, DVec3::new(0.6, 0.0, 0.8)] {
            assert!((sphere.sent(towards).x - 0.25).abs() < 1e-3, "{}", sphere.sent(towards).x);
        }
        // A single face: within a tenth of what it sends straight ahead.
        let face = Crowd::of_face(DVec3::Z, Rgb::ONE);
        for i in 0..=10 {
            let z = f64::from(i) / 5.0 - 1.0;
            let sent = face.sent(DVec3::new((1.0 - z * z).sqrt(), 0.0, z)).x;
            assert!((sent - z.max(0.0)).abs() < 0.1, "{sent} at {z}");
        }
    }
}
