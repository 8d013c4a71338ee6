//! Direct irradiance by a route of its own: every emitter is cut by the planes through the eye and the edges of every
//! other polygon, and what is left is summed by Lambert's formula. Slow, simple, and exact to rounding. It shares
//! nothing with the library but vectors.

use std::f64::consts::PI;

use glam::DVec3;

/// A convex polygon, counter-clockwise seen from its front; `radiance` of 0 for what only hides.
#[derive(Clone, Debug)]
pub struct Convex {
    pub corners: Vec<DVec3>,
    pub radiance: f64,
}

/// All polygons of a scene, in convex pieces.
#[derive(Clone, Debug, Default)]
pub struct World {
    pub pieces: Vec<Convex>,
}

/// What lies this near to a plane, in metres, is in it: f32 corners of a plane polygon are.
const IN_PLANE: f64 = 4e-6;

fn normal_of(corners: &[DVec3]) -> DVec3 {
    (1..corners.len() - 1)
        .map(|i| (corners[i] - corners[0]).cross(corners[i + 1] - corners[0]))
        .sum::<DVec3>()
        .normalize()
}

/// The part of a convex polygon where `height` is not negative.
fn clip(corners: &[DVec3], height: impl Fn(DVec3) -> f64) -> Vec<DVec3> {
    let mut kept = Vec::with_capacity(corners.len() + 1);
    for i in 0..corners.len() {
        let (p, q) = (corners[i], corners[(i + 1) % corners.len()]);
        let (at_p, at_q) = (height(p), height(q));
        if at_p >= 0.0 {
            kept.push(p);
        }
        if at_p * at_q < 0.0 {
            kept.push(p + (q - p) * (at_p / (at_p - at_q)));
        }
    }
    if kept.len() < 3 {
        kept.clear();
    }
    kept
}

/// A hider so small, in square metres, hides nothing that could be measured, and has no shape left after rounding.
const SPECK: f64 = 1e-11;
/// An eye this near to the plane of a hider, in metres, sees it edge-on.
const EDGE_ON: f64 = 1e-10;

/// Whether a hider hides anything from an eye.
fn hides(eye: DVec3, hider: &[DVec3]) -> bool {
    if hider.len() < 3 {
        return false;
    }
    let doubled: DVec3 = (1..hider.len() - 1).map(|i| (hider[i] - hider[0]).cross(hider[i + 1] - hider[0])).sum();
    doubled.length() > SPECK && doubled.normalize().dot(hider[0] - eye).abs() > EDGE_ON
}

/// Lambert's form factor of a polygon from a point.
fn factor(eye: DVec3, normal: DVec3, corners: &[DVec3]) -> f64 {
    let ray = |i: usize| corners[i % corners.len()] - eye;
    let side = |i: usize| {
        let cross = ray(i).cross(ray(i + 1));
        let sine = cross.length();
        if sine == 0.0 { 0.0 } else { sine.atan2(ray(i).dot(ray(i + 1))) * normal.dot(cross) / sine }
    };
    // The front of the emitter is turned to the eye: from there it runs clockwise.
    -(0..corners.len()).map(side).sum::<f64>() / (2.0 * PI)
}

impl World {
    /// Irradiance at a point of a surface with this normal, in W/m2.
    pub fn irradiance(&self, eye: DVec3, normal: DVec3) -> f64 {
        (0..self.pieces.len()).filter(|&i| self.pieces[i].radiance > 0.0).map(|i| self.from(i, eye, normal)).sum()
    }

    fn from(&self, emitter: usize, eye: DVec3, normal: DVec3) -> f64 {
        let source = &self.pieces[emitter];
        let facing = normal_of(&source.corners);
        let depth = |p: DVec3| facing.dot(p - source.corners[0]);
        if depth(eye) <= 0.0 {
            return 0.0;
        }
        let above = |p: DVec3| normal.dot(p - eye);
        let mut visible = vec![clip(&source.corners, above)];
        for (i, piece) in self.pieces.iter().enumerate() {
            let flat = |height: &dyn Fn(DVec3) -> f64| piece.corners.iter().all(|&p| height(p).abs() < IN_PLANE);
            if i == emitter || flat(&depth) || flat(&above) {
                continue;
            }
            let hider = clip(&clip(&piece.corners, above), depth);
            if hides(eye, &hider) {
                visible = visible.iter().flat_map(|part| without(eye, part, &hider)).collect();
            }
        }
        PI * source.radiance * visible.iter().map(|part| factor(eye, normal, part)).sum::<f64>()
    }
}

/// What is left of a part behind a hider.
fn without(eye: DVec3, part: &[DVec3], hider: &[DVec3]) -> Vec<Vec<DVec3>> {
    let inside = hider.iter().sum::<DVec3>() / hider.len() as f64 - eye;
    let sides: Vec<DVec3> = (0..hider.len())
        .map(|i| {
            let side = (hider[i] - eye).cross(hider[(i + 1) % hider.len()] - eye);
            if side.dot(inside) < 0.0 { -side } else { side }
        })
        // Corners that clipping made twice have no side between them.
        .filter(|side| side.length_squared() > f64::EPSILON * f64::EPSILON)
        .collect();
    if sides.iter().any(|side| part.iter().all(|&p| side.dot(p - eye) <= 0.0)) {
        return vec![part.to_vec()];
    }
    let mut left = Vec::new();
    let mut covered = part.to_vec();
    for side in sides {
        let outside = clip(&covered, |p| -side.dot(p - eye));
        if outside.len() >= 3 {
            left.push(outside);
        }
        covered = clip(&covered, |p| side.dot(p - eye));
        if covered.len() < 3 {
            break;
        }
    }
    left
}

#[cfg(test)]
mod tests {
    use super::*;

    fn square(z: f64, half: f64, radiance: f64) -> Convex {
        let corners =
            [(-1.0, -1.0), (-1.0, 1.0), (1.0, 1.0), (1.0, -1.0)].map(|(x, y)| DVec3::new(half * x, half * y, z));
        Convex { corners: corners.to_vec(), radiance }
    }

    #[test]
    fn a_unit_square_above_its_centre() {
        let world = World { pieces: vec![square(1.0, 0.5, 1.0)] };
        assert!((world.irradiance(DVec3::ZERO, DVec3::Z) / PI - 0.239_456_470_5).abs() < 1e-9);
    }

    #[test]
    fn half_of_it_is_hidden_by_a_plate_of_half_its_width() {
        let open = World { pieces: vec![square(2.0, 1.0, 1.0)] };
        let hidden = World { pieces: vec![square(2.0, 1.0, 1.0), square(1.0, 0.25, 0.0)] };
        let shadow = World { pieces: vec![square(2.0, 0.5, 1.0)] };
        let at = |world: &World| world.irradiance(DVec3::ZERO, DVec3::Z);
        assert!((at(&open) - at(&hidden) - at(&shadow)).abs() < 1e-12);
    }
}
