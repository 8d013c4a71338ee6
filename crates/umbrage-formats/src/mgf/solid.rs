//! Curved and extruded shapes as plane polygons, with their fronts outward.
//!
//! A circle becomes a regular polygon whose corners are on it, in a frame that depends on its axis only up to sign, so
//! that a cylinder, a cone and a ring that share a circle share its corners. All polygons are plane: bands between
//! parallel circles are trapezoids. Negative radii (and lengths of prisms) put the fronts inward.

use std::f64::consts::{PI, TAU};

use glam::DVec3;

/// Positions, and polygons as indices into them.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Solid {
    pub(super) positions: Vec<DVec3>,
    /// Unit normals of the curved surface at the positions, or against its fronts; zero where it has a tip; none for a shape
    /// with plane sides, or as many as positions.
    pub(super) normals: Vec<DVec3>,
    pub(super) polygons: Vec<Vec<u32>>,
}

impl Solid {
    /// One polygon.
    pub(super) fn polygon(positions: Vec<DVec3>, normals: Vec<DVec3>) -> Self {
        let polygon = (0..positions.len() as u32).collect();
        Self { positions, normals, polygons: vec![polygon] }
    }

    /// Corners of all polygons.
    pub(super) fn corners(&self) -> usize {
        self.polygons.iter().map(Vec::len).sum()
    }

    /// Turns every polygon over.
    pub(super) fn turn_over(&mut self) {
        self.polygons.iter_mut().for_each(|polygon| polygon.reverse());
    }

    /// Adds a circle's corners, or one point where the radius is 0; the number of the first and how many there are. The normals
    /// are made of the direction away from the axis and that along it.
    fn circle(
        &mut self,
        centre: DVec3,
        [u, v]: [DVec3; 2],
        radius: f64,
        [away, along]: [f64; 2],
        segments: usize,
    ) -> (u32, u32) {
        let first = self.positions.len() as u32;
        let axis = u.cross(v);
        if radius == 0.0 {
            self.positions.push(centre);
            self.normals.push(if away.abs() < along.abs() { along.signum() * axis } else { DVec3::ZERO });
            return (first, 1);
        }
        for k in 0..segments {
            let (sin, cos) = (TAU * k as f64 / segments as f64).sin_cos();
            let out = cos * u + sin * v;
            self.positions.push(centre + radius * out);
            self.normals.push((away * out + along * axis).normalize_or_zero());
        }
        (first, segments as u32)
    }

    /// Adds the band between two circles of one frame: seen with the second above the first, the front is outside.
    fn band(&mut self, (a, a_count): (u32, u32), (b, b_count): (u32, u32)) {
        let segments = a_count.max(b_count);
        if segments < 2 {
            return;
        }
        for k in 0..segments {
            let next = (k + 1) % segments;
            let mut polygon = vec![a + k % a_count, a + next % a_count, b + next % b_count, b + k % b_count];
            polygon.dedup();
            self.polygons.push(polygon);
        }
    }
}

/// Two unit vectors that make a right-handed frame with the axis; those of the opposite axis are the first one and the
/// negative of the second.
fn frame(axis: DVec3) -> [DVec3; 2] {
    let a = axis.abs();
    // Slack, so that rounding in the axis does not choose another frame for the same circle.
    let slack = 1e-9 * a.max_element();
    let least = if a.x <= a.y + slack && a.x <= a.z + slack {
        DVec3::X
    } else if a.y <= a.z + slack {
        DVec3::Y
    } else {
        DVec3::Z
    };
    let u = (least - axis * (axis.dot(least) / axis.length_squared())).normalize();
    [u, axis.cross(u).normalize()]
}

/// A sphere, in bands of equal angle. The radius is not 0.
pub(super) fn sphere(centre: DVec3, radius: f64, segments: usize) -> Solid {
    let frame = [DVec3::X, DVec3::Y];
    let bands = segments.div_ceil(2).max(2);
    let mut solid = Solid::default();
    let circles: Vec<_> = (0..=bands)
        .map(|i| {
            let (sin, cos) = (PI * i as f64 / bands as f64).sin_cos();
            let pole = i == 0 || i == bands;
            let ring = if pole { 0.0 } else { radius.abs() * sin };
            solid.circle(centre - radius.abs() * cos * DVec3::Z, frame, ring, [sin, -cos], segments)
        })
        .collect();
    circles.windows(2).for_each(|pair| solid.band(pair[0], pair[1]));
    if radius < 0.0 {
        solid.turn_over();
    }
    solid
}

/// A truncated cone without ends, or a cylinder. The ends differ, and the radii are not both 0 and not of two signs.
pub(super) fn cone(ends: [DVec3; 2], radii: [f64; 2], segments: usize) -> Solid {
    let frame = frame(ends[1] - ends[0]);
    let mut solid = Solid::default();
    let slope = [(ends[1] - ends[0]).length(), radii[0].abs() - radii[1].abs()];
    let low = solid.circle(ends[0], frame, radii[0].abs(), slope, segments);
    let high = solid.circle(ends[1], frame, radii[1].abs(), slope, segments);
    solid.band(low, high);
    if radii[0] + radii[1] < 0.0 {
        solid.turn_over();
    }
    solid
}

/// A flat ring, or a disc if the inner radius is 0; its front is where the normal points. The outer radius is larger.
pub(super) fn ring(centre: DVec3, normal: DVec3, [inner, outer]: [f64; 2], segments: usize) -> Solid {
    let frame = frame(normal);
    let mut solid = Solid::default();
    if inner == 0.0 {
        let (first, count) = solid.circle(centre, frame, outer, [0.0, 1.0], segments);
        solid.polygons.push((first..first + count).collect());
    } else {
        let low = solid.circle(centre, frame, outer, [0.0, 1.0], segments);
        let high = solid.circle(centre, frame, inner, [0.0, 1.0], segments);
        solid.band(low, high);
    }
    solid
}

/// A torus about the normal. The outer radius is larger in size, and both have one sign.
pub(super) fn torus(centre: DVec3, normal: DVec3, [inner, outer]: [f64; 2], segments: usize) -> Solid {
    let (middle, tube) = ((inner.abs() + outer.abs()) / 2.0, (outer.abs() - inner.abs()) / 2.0);
    let frame = frame(normal);
    let axis = normal.normalize();
    let around = segments.div_ceil(2).max(3);
    let mut solid = Solid::default();
    let circles: Vec<_> = (0..around)
        .map(|i| {
            let (sin, cos) = (TAU * i as f64 / around as f64).sin_cos();
            // At an inner radius of 0 the innermost circle is a point, up to rounding.
            let ring = middle + tube * cos;
            let ring = if ring < 1e-12 * middle { 0.0 } else { ring };
            solid.circle(centre + tube * sin * axis, frame, ring, [cos, sin], segments)
        })
        .collect();
    for i in 0..around {
        solid.band(circles[i], circles[(i + 1) % around]);
    }
    if outer < 0.0 {
        solid.turn_over();
    }
    solid
}

/// A closed right prism: a face, the same one moved against its normal by `length`, and the sides between; `None` if the
/// face has no area.
pub(super) fn prism(face: &[DVec3], length: f64) -> Option<Solid> {
    let first = *face.first()?;
    let area: DVec3 = face.windows(2).map(|side| (side[0] - first).cross(side[1] - first)).sum();
    let normal = area.try_normalize()?;
    let n = face.len() as u32;
    let polygons = vec![(0..n).collect(), (n..2 * n).rev().collect()];
    let mut solid = Solid { positions: face.to_vec(), normals: Vec::new(), polygons };
    solid.positions.extend(face.iter().map(|p| *p - length * normal));
    let sides = (0..n).map(|i| {
        let next = (i + 1) % n;
        vec![next, i, n + i, n + next]
    });
    solid.polygons.extend(sides);
    Some(solid)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn vector_area(solid: &Solid, polygon: &[u32]) -> DVec3 {
        let p: Vec<DVec3> = polygon.iter().map(|&i| solid.positions[i as usize]).collect();
        (1..p.len() - 1).map(|i| (p[i] - p[0]).cross(p[i + 1] - p[0]) / 2.0).sum()
    }

    fn area(solid: &Solid) -> f64 {
        solid.polygons.iter().map(|p| vector_area(solid, p).length()).sum()
    }

    /// Volume by the divergence theorem; positive where the fronts are outward.
    fn volume(solid: &Solid) -> f64 {
        let part = |p: &Vec<u32>| solid.positions[p[0] as usize].dot(vector_area(solid, p)) / 3.0;
        solid.polygons.iter().map(part).sum()
    }

    fn is_plane(solid: &Solid) -> bool {
        solid.polygons.iter().all(|p| {
            let normal = vector_area(solid, p).normalize();
            let height = |&i: &u32| normal.dot(solid.positions[i as usize] - solid.positions[p[0] as usize]).abs();
            p.len() >= 3 && p.iter().map(height).all(|h| h < 1e-12)
        })
    }

    fn is_closed(solid: &Solid) -> bool {
        let edges: std::collections::BTreeSet<(u32, u32)> =
            solid.polygons.iter().flat_map(|p| (0..p.len()).map(|i| (p[i], p[(i + 1) % p.len()]))).collect();
        edges.iter().all(|&(a, b)| edges.contains(&(b, a)))
    }

    #[test]
    fn normals_are_those_of_the_curve() {
        let centre = DVec3::new(3.0, -2.0, 1.0);
        let sphere = sphere(centre, -2.0, 12);
        for (position, normal) in sphere.positions.iter().zip(&sphere.normals) {
            assert!(normal.distance((position - centre) / 2.0) < 1e-12, "{position} {normal}");
        }
        // A cone of half a right angle, whose tip has none of its own.
        let cone = cone([DVec3::ZERO, DVec3::Z], [1.0, 0.0], 12);
        for (position, normal) in cone.positions.iter().zip(&cone.normals).take(12) {
            assert!(normal.distance((position + DVec3::Z).normalize()) < 1e-12, "{position} {normal}");
        }
        assert_eq!(cone.normals[12], DVec3::ZERO);
        let torus = torus(centre, DVec3::Y, [1.0, 3.0], 12);
        for (position, normal) in torus.positions.iter().zip(&torus.normals) {
            let out = (position - centre).with_y(0.0).normalize();
            assert!(normal.distance(position - centre - 2.0 * out) < 1e-12, "{position} {normal}");
        }
    }

    #[test]
    fn spheres_and_tori_are_closed_and_near_their_measures() {
        let centre = DVec3::new(3.0, -2.0, 1.0);
        for (segments, share) in [(24, 0.03), (96, 0.002)] {
            for sign in [1.0, -1.0] {
                let sphere = sphere(centre, sign * 2.0, segments);
                assert!(is_plane(&sphere) && is_closed(&sphere));
                let exact = 4.0 / 3.0 * PI * 8.0;
                assert!((sign * volume(&sphere) / exact - 1.0).abs() < share, "{}", volume(&sphere));
                assert!((area(&sphere) / (PI * 16.0) - 1.0).abs() < share);
                let torus = torus(centre, DVec3::new(1.0, 2.0, -0.5), [sign, sign * 2.0], segments);
                assert!(is_plane(&torus) && is_closed(&torus));
                let exact = PI * 0.25 * TAU * 1.5;
                assert!((sign * volume(&torus) / exact - 1.0).abs() < 3.0 * share, "{}", volume(&torus));
            }
        }
        let spindle = torus(DVec3::ZERO, DVec3::Z, [0.0, 1.0], 24);
        assert!(is_plane(&spindle) && is_closed(&spindle));
    }

    #[test]
    fn a_cylinder_with_two_discs_is_closed_in_space() {
        for axis in [DVec3::Z, -DVec3::X, DVec3::new(0.3, -0.8, 0.1), DVec3::new(1.0, 1.0, 1.0)] {
            let ends = [DVec3::new(1.0, 2.0, 3.0), DVec3::new(1.0, 2.0, 3.0) + axis];
            let side = cone(ends, [0.5, 0.5], 24);
            let discs = [ring(ends[0], -axis, [0.0, 0.5], 24), ring(ends[1], axis * 3.0, [0.0, 0.5], 24)];
            let total = volume(&side) + volume(&discs[0]) + volume(&discs[1]);
            let exact = 12.0 * (TAU / 24.0).sin() * 0.25 * axis.length();
            assert!((total - exact).abs() < 1e-12, "{axis}: {total} {exact}");
            for p in discs.iter().flat_map(|disc| &disc.positions) {
                assert!(side.positions.iter().any(|q| q.distance(*p) < 1e-12), "{axis}: {p}");
            }
            assert!(is_plane(&side) && discs.iter().all(is_plane));
        }
    }

    #[test]
    fn cones_end_in_points_and_rings_have_holes() {
        let cone = cone([DVec3::ZERO, DVec3::Z], [1.0, 0.0], 24);
        assert!(is_plane(&cone) && cone.polygons.len() == 24 && cone.polygons.iter().all(|p| p.len() == 3));
        let ring = ring(DVec3::ZERO, DVec3::Z, [1.0, 2.0], 24);
        assert!((area(&ring) - 12.0 * (TAU / 24.0).sin() * 3.0).abs() < 1e-12);
        assert!(ring.polygons.iter().all(|p| vector_area(&ring, p).z > 0.0));
    }

    #[test]
    fn prisms_extrude_against_their_normal() {
        let square = [DVec3::ZERO, DVec3::Y, DVec3::new(1.0, 1.0, 0.0), DVec3::X];
        let cube = prism(&square, 1.0).unwrap();
        assert!(is_plane(&cube) && is_closed(&cube) && cube.polygons.len() == 6);
        assert!((volume(&cube) - 1.0).abs() < 1e-12);
        assert!(cube.positions.iter().all(|p| (0.0..=1.0).contains(&p.z)));
        let inside_out = prism(&square, -2.0).unwrap();
        assert!((volume(&inside_out) + 2.0).abs() < 1e-12);
        assert!(prism(&[DVec3::ZERO, DVec3::X, DVec3::X * 2.0], 1.0).is_none() && prism(&[], 1.0).is_none());
    }
}
