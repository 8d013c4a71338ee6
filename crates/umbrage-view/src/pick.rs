//! What is under the pointer: the nearest front that a ray meets, and the light there.
//!
//! Source of the intersection: T. Möller and B. Trumbore, Fast, Minimum Storage Ray/Triangle Intersection, 1997.

use std::f64::consts::PI;

use glam::DVec3;
use umbrage_formats::BakedFile;

/// A point of a surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Hit {
    /// Number of the part of the file.
    pub(crate) part: usize,
    /// Number of the triangle in the part.
    pub(crate) triangle: usize,
    /// How much each corner of the triangle counts there; their sum is 1.
    pub(crate) weights: [f64; 3],
    /// The point in the world, in metres.
    pub(crate) point_m: DVec3,
    /// Unit normal of the triangle, towards its front.
    pub(crate) normal: DVec3,
}

/// Light at a point, linear RGB.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct PointLight {
    /// Irradiance on the front, in W/m2.
    pub(crate) irradiance: [f64; 3],
    /// Radiosity: what is reflected and emitted, in W/m2, as if there were no texture.
    pub(crate) radiosity: [f64; 3],
}

/// The nearest front that the ray from `eye_m`, relative to the file's origin, meets.
pub(crate) fn nearest(file: &BakedFile, eye_m: DVec3, ray: DVec3) -> Option<Hit> {
    let mut best = f64::INFINITY;
    let mut hit = None;
    for (part, table) in file.parts.iter().enumerate() {
        for (triangle, corners) in table.triangles.iter().enumerate() {
            let [a, b, c] = corners.map(|i| DVec3::from(table.positions_m[i as usize].map(f64::from)));
            let (u, v) = (b - a, c - a);
            let across = ray.cross(v);
            // Six times the volume of ray and triangle: positive where the front is seen.
            let volume = u.dot(across);
            if volume <= 0.0 {
                continue;
            }
            let from_a = eye_m - a;
            let second = from_a.dot(across) / volume;
            let turned = from_a.cross(u);
            let (third, distance) = (ray.dot(turned) / volume, v.dot(turned) / volume);
            let inside = second >= 0.0 && third >= 0.0 && second + third <= 1.0;
            if inside && distance > 0.0 && distance < best {
                best = distance;
                let weights = [1.0 - second - third, second, third];
                let point_m = file.origin_m + eye_m + distance * ray;
                hit = Some(Hit { part, triangle, weights, point_m, normal: u.cross(v).normalize_or_zero() });
            }
        }
    }
    hit
}

/// The light at a point.
pub(crate) fn light(file: &BakedFile, hit: &Hit) -> PointLight {
    let part = &file.parts[hit.part];
    let corners = part.triangles[hit.triangle];
    let irradiance: [f64; 3] = std::array::from_fn(|channel| {
        let at = |corner: u32| f64::from(part.irradiance[corner as usize][channel]);
        corners.iter().zip(hit.weights).map(|(&corner, weight)| weight * at(corner)).sum()
    });
    let radiosity = std::array::from_fn(|channel| match part.emission {
        Some(emission) => emission.reflectance[channel] * irradiance[channel] + PI * emission.radiance[channel],
        None => f64::from(part.base_color[channel]) * irradiance[channel],
    });
    PointLight { irradiance, radiosity }
}

#[cfg(test)]
mod tests {
    use umbrage_formats::BakedEmission;

    use super::*;
    use crate::layout::tests::{shown, square};

    #[test]
    fn the_nearest_front_is_hit_and_no_back() {
        let mut far = square(0.0, 2.0);
        far.positions_m.iter_mut().for_each(|p| p[2] = -1.0);
        let mut back = square(0.0, 3.0);
        back.positions_m.iter_mut().for_each(|p| p[2] = 1.0);
        back.triangles.iter_mut().for_each(|t| t.reverse());
        let shown = shown(vec![far, square(0.0, 1.0), back]);
        let hit = nearest(&shown.file, DVec3::new(0.75, 0.25, 5.0), DVec3::NEG_Z).unwrap();
        assert_eq!((hit.part, hit.triangle, hit.normal), (1, 0, DVec3::Z));
        assert_eq!(hit.point_m, DVec3::new(10.75, 0.25, 0.0));
        assert_eq!(hit.weights, [0.25, 0.5, 0.25]);
        assert!(nearest(&shown.file, DVec3::new(1.5, 0.5, 5.0), DVec3::NEG_Z).is_none());
        assert!(nearest(&shown.file, DVec3::new(0.5, 0.5, 5.0), DVec3::Z).is_none());
    }

    #[test]
    fn light_is_interpolated_and_reflected() {
        let mut part = square(0.0, 0.0);
        part.irradiance = vec![[4.0; 3], [8.0; 3], [0.0; 3], [0.0; 3]];
        let hit = |part| {
            let shown = shown(vec![part]);
            let hit = nearest(&shown.file, DVec3::new(0.75, 0.25, 5.0), DVec3::NEG_Z).unwrap();
            light(&shown.file, &hit)
        };
        let reflected = hit(part.clone());
        assert_eq!((reflected.irradiance, reflected.radiosity), ([5.0; 3], [2.5, 1.25, 5.0]));
        part.emission = Some(BakedEmission { radiance: [1.0, 0.0, 2.0], reflectance: [0.0, 0.5, 1.0] });
        assert_eq!(hit(part).radiosity, [PI, 2.5, 5.0 + 2.0 * PI]);
    }
}
