//! Half spaces around a point, four at a time in `f32`: which boxes reach into all of them.
//!
//! A beam looks at some tens of boxes for each that it meets. So boxes are told apart first without the exact test, by numbers of half
//! the size and four sides at once.
//!
//! Holds: a box that reaches into all of them passes; one that does not may pass too, by rounding.

use glam::{DVec3, Vec3A, Vec4};
use smallvec::SmallVec;

/// Heights over a half space are good to this share of the extent of the scene: coordinates are rounded to 6e-8 of it, and a height
/// is a sum of six products of up to two extents.
const ROUNDED_OF_EXTENT: f64 = 4e-6;

/// Half spaces, given by their unit normals and the least height of what counts over the plane through a point.
#[derive(Clone, Debug)]
pub(super) struct HalfSpaces {
    point_m: Vec3A,
    fours: SmallVec<[Four; 2]>,
}

/// Four of them.
#[derive(Clone, Copy, Debug)]
struct Four {
    /// Coordinates of the normals.
    normals: [Vec4; 3],
    least_m: Vec4,
}

impl HalfSpaces {
    /// Half spaces by their inward normals, of any length, and the least height, times that length, over planes through a point, in a
    /// scene of this extent.
    pub(super) fn around(point_m: DVec3, sides: impl IntoIterator<Item = (DVec3, f64)>, extent_m: f64) -> Self {
        let unit = |(normal, least): (DVec3, f64)| {
            let length = normal.length();
            (length > 0.0).then(|| (normal / length, least / length - ROUNDED_OF_EXTENT * extent_m))
        };
        let sides: SmallVec<[(DVec3, f64); 12]> = sides.into_iter().filter_map(unit).collect();
        let four = |sides: &[(DVec3, f64)]| {
            // What is missing of four is everywhere.
            let of = |i: usize| sides.get(i).map_or((DVec3::ZERO, f64::from(f32::MIN)), |side| *side);
            let lanes = |get: fn((DVec3, f64)) -> f64| Vec4::from_array([0, 1, 2, 3].map(|i| get(of(i)) as f32));
            Four { normals: [lanes(|s| s.0.x), lanes(|s| s.0.y), lanes(|s| s.0.z)], least_m: lanes(|s| s.1) }
        };
        Self { point_m: point_m.as_vec3a(), fours: sides.chunks(4).map(four).collect() }
    }

    /// Whether a box may reach into all of them.
    pub(super) fn may_meet(&self, min_m: Vec3A, max_m: Vec3A) -> bool {
        let (middle, half) = (0.5 * (min_m + max_m) - self.point_m, 0.5 * (max_m - min_m));
        self.fours.iter().all(|Four { normals: [x, y, z], least_m }| {
            let height = *x * middle.x + *y * middle.y + *z * middle.z;
            let reach = x.abs() * half.x + y.abs() * half.y + z.abs() * half.z;
            (height + reach).cmpgt(*least_m).all()
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn what_reaches_into_all_of_them_passes_and_what_is_far_from_one_does_not(
            point in (-1.0..1.0, -1.0..1.0, -1.0..1.0),
            sides in prop::collection::vec(((-1.0..1.0, -1.0..1.0, -1.0..1.0), -0.1..0.1), 1..11),
            middle in (-1.0..1.0, -1.0..1.0, -1.0..1.0), half in (0.0..0.3, 0.0..0.3, 0.0..0.3),
        ) {
            let (point_m, middle, half) = (DVec3::from(point), DVec3::from(middle), DVec3::from(half));
            let sides: Vec<(DVec3, f64)> = sides.into_iter().map(|(normal, least)| (DVec3::from(normal), least)).collect();
            let spaces = HalfSpaces::around(point_m, sides.iter().copied(), 1.0);
            let over = |(normal, least): &(DVec3, f64)| {
                (normal.dot(middle - point_m) + normal.abs().dot(half) - least) / normal.length()
            };
            let least_m = sides.iter().map(over).fold(f64::INFINITY, f64::min);
            let passes = spaces.may_meet((middle - half).as_vec3a(), (middle + half).as_vec3a());
            prop_assert!(passes || least_m <= 0.0);
            prop_assert!(!passes || least_m > -2.0 * ROUNDED_OF_EXTENT);
        }
    }
}
