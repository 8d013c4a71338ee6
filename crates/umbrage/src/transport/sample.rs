//! Points of a receiver patch, and their weights, at which a form factor is averaged.
//!
//! A convex patch is cut into a fan of triangles; each gets the six points of a rule that is exact for
//! polynomials up to degree 4 (Dunavant, *High degree efficient symmetrical Gaussian quadrature rules for the triangle*, 1985).
//!
//! Holds after: points lie strictly inside the patch; weights sum to 1.

use glam::DVec3;

/// Barycentric coordinates and weight of the orbits of the six-point rule.
const SIX: [(f64, f64, f64); 2] = [
    (0.108103018168070, 0.445948490915965, 0.223381589678011),
    (0.816847572980459, 0.091576213509771, 0.109951743655322),
];

/// Points and weights over a convex polygon, in the order of its corners.
pub(super) fn points(corners: &[DVec3]) -> Vec<(DVec3, f64)> {
    let mut points = Vec::new();
    for pair in corners[1..].windows(2) {
        add_triangle(&mut points, [corners[0], pair[0], pair[1]]);
    }
    let area: f64 = points.iter().map(|(_, weight)| weight).sum();
    points.iter_mut().for_each(|(_, weight)| *weight /= area);
    points
}

/// Adds the points of one triangle, weighted by its area.
fn add_triangle(points: &mut Vec<(DVec3, f64)>, t: [DVec3; 3]) {
    let doubled_area = (t[1] - t[0]).cross(t[2] - t[0]).length();
    for (major, minor, weight) in SIX {
        for i in 0..3 {
            let point = major * t[i] + minor * (t[(i + 1) % 3] + t[(i + 2) % 3]);
            points.push((point, weight * doubled_area));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_rule_is_exact_to_its_degree() {
        let rectangle = [(0.0, 0.0), (2.0, 0.0), (2.0, 1.0), (0.0, 1.0)].map(|(x, y)| DVec3::new(x, y, 0.0));
        let points = points(&rectangle);
        for (i, j) in (0..=4).flat_map(|i| (0..=4 - i).map(move |j| (i, j))) {
            let mean: f64 = points.iter().map(|(p, w)| w * p.x.powi(i) * p.y.powi(j)).sum();
            let truth = 2.0_f64.powi(i) / f64::from((i + 1) * (j + 1));
            assert!((mean - truth).abs() < 1e-12, "x^{i} y^{j}: {mean} is not {truth}");
        }
    }
}
