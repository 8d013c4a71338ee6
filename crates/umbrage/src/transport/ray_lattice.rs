//! Even points of polygons and even directions: where rays start, and where they go.

use std::f64::consts::TAU;

use glam::DVec3;

/// A point of a convex polygon, evenly by area for `s` and `t` that are even.
pub(crate) fn point_of(corners_m: &[DVec3], s: f64, t: f64) -> DVec3 {
    let spokes: Vec<DVec3> = corners_m[1..].iter().map(|corner| corner - corners_m[0]).collect();
    let areas: Vec<f64> = spokes.windows(2).map(|pair| pair[0].cross(pair[1]).length()).collect();
    let mut left = s * areas.iter().sum::<f64>();
    let mut triangle = 0;
    while triangle + 1 < areas.len() && left > areas[triangle] {
        left -= areas[triangle];
        triangle += 1;
    }
    let share = if areas[triangle] > 0.0 { (left / areas[triangle]).min(1.0) } else { 0.5 };
    // Of a triangle, by the distance from its first corner and the way across there.
    let away = share.sqrt();
    corners_m[0] + away * spokes[triangle].lerp(spokes[triangle + 1], t)
}

/// A direction of the hemisphere over a plane, in proportion to its cosine.
pub(crate) fn cosine_direction(normal: DVec3, u: f64, v: f64) -> DVec3 {
    let (across, along) = normal.any_orthonormal_pair();
    let (sine, cosine) = (TAU * v).sin_cos();
    (u.sqrt() * (cosine * across + sine * along) + (1.0 - u).sqrt() * normal).normalize()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn points_of_a_polygon_are_even() {
        let corners = [DVec3::ZERO, 2.0 * DVec3::X, 2.0 * DVec3::X + DVec3::Y, DVec3::Y];
        let points =
            (0..4096).map(|i| point_of(&corners, (f64::from(i) + 0.5) / 4096.0, (0.618_034 * f64::from(i)).fract()));
        let mean: DVec3 = points.sum::<DVec3>() / 4096.0;
        assert!((mean - DVec3::new(1.0, 0.5, 0.0)).length() < 2e-3, "{mean}");
    }
}
