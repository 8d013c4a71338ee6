//! Points of a receiver patch, and their weights, at which a form factor is averaged.
//!
//! A convex patch is cut into a fan of triangles; each gets the points of a rule that is exact for polynomials up to a
//! degree (Dunavant, *High degree efficient symmetrical Gaussian quadrature rules for the triangle*, 1985).
//!
//! Holds after: points lie strictly inside the patch; weights sum to 1.

use glam::DVec3;

/// How finely a patch is sampled.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Rule {
    /// Six points a triangle: exact to degree 4.
    Six,
    /// Six points in each quarter of a triangle.
    FourTimesSix,
}

/// Past occluders the factor has kinks, so that a high degree alone does not help; where the source is nearer than this
/// many radii of the receiver, the factor also varies by itself, and points are four times as many.
const NEAR_RADII: f64 = 2.0;

/// The rule for a partly hidden source that is so many radii of the receiver away.
pub(super) fn rule_past_occluders(radii: f64) -> Rule {
    if radii < NEAR_RADII { Rule::FourTimesSix } else { Rule::Six }
}

/// Barycentric coordinates and weight of the orbits of the six-point rule.
const SIX: [(f64, f64, f64); 2] = [
    (0.108103018168070, 0.445948490915965, 0.223381589678011),
    (0.816847572980459, 0.091576213509771, 0.109951743655322),
];

/// Points and weights of a rule over a convex polygon, in the order of its corners.
pub(super) fn points(corners: &[DVec3], rule: Rule) -> Vec<(DVec3, f64)> {
    let mut points = Vec::new();
    for pair in corners[1..].windows(2) {
        add_triangle(&mut points, [corners[0], pair[0], pair[1]], rule);
    }
    let area: f64 = points.iter().map(|(_, weight)| weight).sum();
    points.iter_mut().for_each(|(_, weight)| *weight /= area);
    points
}

/// Adds the points of one triangle, weighted by its area.
fn add_triangle(points: &mut Vec<(DVec3, f64)>, t: [DVec3; 3], rule: Rule) {
    let doubled_area = (t[1] - t[0]).cross(t[2] - t[0]).length();
    let mut orbit = |major: f64, minor: f64, weight: f64| {
        for i in 0..3 {
            let point = major * t[i] + minor * (t[(i + 1) % 3] + t[(i + 2) % 3]);
            points.push((point, weight * doubled_area));
        }
    };
    match rule {
        Rule::Six => SIX.iter().for_each(|&(major, minor, weight)| orbit(major, minor, weight)),
        Rule::FourTimesSix => quarters(t).into_iter().for_each(|q| add_triangle(points, q, Rule::Six)),
    }
}

/// A triangle in four, by the middles of its sides.
fn quarters([p, q, r]: [DVec3; 3]) -> [[DVec3; 3]; 4] {
    let (pq, qr, rp) = (p.midpoint(q), q.midpoint(r), r.midpoint(p));
    [[p, pq, rp], [pq, q, qr], [rp, qr, r], [pq, qr, rp]]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rules_are_exact_to_their_degree() {
        let rectangle = [(0.0, 0.0), (2.0, 0.0), (2.0, 1.0), (0.0, 1.0)].map(|(x, y)| DVec3::new(x, y, 0.0));
        for (rule, degree) in [(Rule::Six, 4), (Rule::FourTimesSix, 4)] {
            let points = points(&rectangle, rule);
            for (i, j) in (0..=degree).flat_map(|i| (0..=degree - i).map(move |j| (i, j))) {
                let mean: f64 = points.iter().map(|(p, w)| w * p.x.powi(i) * p.y.powi(j)).sum();
                let truth = 2.0_f64.powi(i) / f64::from((i + 1) * (j + 1));
                assert!((mean - truth).abs() < 1e-12, "{rule:?} x^{i} y^{j}: {mean} is not {truth}");
            }
        }
    }
}
