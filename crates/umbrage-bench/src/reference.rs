//! Points at which the light of a scene is known from elsewhere (`testdata/reference`), and what a bake errs there.

use std::fs;

use anyhow::{Context, bail, ensure};
use glam::DVec3;
use umbrage_verify::BakedTriangle;

use crate::scenes::in_project;

/// Scenes with reference points, and the standard error of these as a share of the mean: path tracing, or exact.
const NOISE: [(&str, f64); 3] = [("cornell", 0.0028), ("touching", 0.0024), ("occluder", 0.0)];

/// The share of the points that must lie on the baked mesh.
const LEAST_COVERED: f64 = 0.995;
/// A triangle further from a point than this share of the mesh's extent is not its own.
const ON_PLANE_OF_EXTENT: f64 = 1e-4;
/// Nor is one that looks another way: the least cosine.
const SAME_WAY: f64 = 0.999;
/// A point may lie outside of its triangle by this share of it: corners are rounded.
const OUTSIDE: f64 = 1e-3;

/// Names of the scenes that have reference points.
pub(crate) const NAMES: [&str; 3] = [NOISE[0].0, NOISE[1].0, NOISE[2].0];

/// A point at which the irradiance is known.
#[derive(Clone, Copy, Debug)]
struct Point {
    position_m: DVec3,
    normal: DVec3,
    /// W/m2.
    irradiance: DVec3,
}

/// The points of a scene.
#[derive(Clone, Debug)]
pub(crate) struct Reference {
    points: Vec<Point>,
    /// Standard error of the points, as a share of the mean.
    pub(crate) noise: f64,
}

impl Reference {
    /// Reads the points of a scene.
    pub(crate) fn read(scene: &str) -> anyhow::Result<Self> {
        let Some(&(_, noise)) = NOISE.iter().find(|(name, _)| *name == scene) else {
            bail!("{scene} has no reference points; these have: {}", NAMES.join(", "));
        };
        let path = in_project("testdata/reference").join(format!("{scene}.csv"));
        let text = fs::read_to_string(&path).with_context(|| format!("cannot read {}", path.display()))?;
        let points: Vec<Point> = text
            .lines()
            .skip(1)
            .map(|line| point(line).with_context(|| format!("{}: {line}", path.display())))
            .collect::<Result<_, _>>()?;
        ensure!(!points.is_empty(), "{}: no points", path.display());
        Ok(Self { points, noise })
    }

    /// Relative root mean square error of a bake over the points and the colours; the noise of the points is in it.
    pub(crate) fn error(&self, baked: &[BakedTriangle]) -> anyhow::Result<f64> {
        let corners = || baked.iter().flat_map(|triangle| triangle.corners_m);
        let size_m = corners().fold(DVec3::NEG_INFINITY, DVec3::max) - corners().fold(DVec3::INFINITY, DVec3::min);
        let near_m = ON_PLANE_OF_EXTENT * size_m.max_element();
        let count = self.points.len() as f64;
        let mean = self.points.iter().map(|point| point.irradiance.element_sum() / 3.0).sum::<f64>() / count;
        let squared: Vec<f64> = self
            .points
            .iter()
            .filter_map(|point| shown(baked, point, near_m).map(|shown| shown - point.irradiance))
            .map(|error| error.length_squared() / 3.0)
            .collect();
        let covered = squared.len() as f64;
        ensure!(covered >= LEAST_COVERED * count, "{covered} of {count} reference points are on the mesh");
        Ok((squared.iter().sum::<f64>() / covered).sqrt() / mean)
    }
}

/// A row: position, normal, irradiance.
fn point(line: &str) -> anyhow::Result<Point> {
    let numbers: Vec<f64> = line.split(',').map(|field| field.trim().parse()).collect::<Result<_, _>>()?;
    ensure!(numbers.len() == 9, "{} numbers", numbers.len());
    let vector = |from: usize| DVec3::new(numbers[from], numbers[from + 1], numbers[from + 2]);
    Ok(Point { position_m: vector(0), normal: vector(3), irradiance: vector(6) })
}

/// What a bake shows at a point: the light of the triangle that it lies deepest in, between the corners.
fn shown(baked: &[BakedTriangle], point: &Point, near_m: f64) -> Option<DVec3> {
    let weights = |triangle: &BakedTriangle| {
        let [p, q, r] = triangle.corners_m;
        let across = (q - p).cross(r - p);
        let normal = across.normalize_or_zero();
        let away = point.position_m - p;
        let own = normal.dot(point.normal) > SAME_WAY && away.dot(normal).abs() <= near_m;
        let weight =
            |p: DVec3, q: DVec3| (p - point.position_m).cross(q - point.position_m).dot(normal) / across.length();
        own.then(|| [weight(q, r), weight(r, p), weight(p, q)])
    };
    let least = |weights: &[f64; 3]| weights.iter().copied().fold(f64::INFINITY, f64::min);
    let (weights, triangle) = baked
        .iter()
        .filter_map(|triangle| weights(triangle).map(|weights| (weights, triangle)))
        .max_by(|(p, _), (q, _)| least(p).total_cmp(&least(q)))?;
    let light = weights.iter().zip(triangle.irradiance).map(|(weight, light)| weight.clamp(0.0, 1.0) * light).sum();
    (least(&weights) >= -OUTSIDE).then_some(light)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Two triangles that make a square of 2 m, with light `of` the place.
    fn square(of: impl Fn(DVec3) -> f64) -> Vec<BakedTriangle> {
        let at = |x: f64, y: f64| DVec3::new(x, y, 0.0);
        [[at(-1.0, -1.0), at(1.0, -1.0), at(1.0, 1.0)], [at(-1.0, -1.0), at(1.0, 1.0), at(-1.0, 1.0)]]
            .map(|corners_m| BakedTriangle { corners_m, irradiance: corners_m.map(|p| DVec3::splat(of(p))) })
            .to_vec()
    }

    fn reference(points: &[[f64; 2]], of: impl Fn(DVec3) -> f64) -> Reference {
        let at = |&[x, y]: &[f64; 2]| {
            let position_m = DVec3::new(x, y, 0.0);
            Point { position_m, normal: DVec3::Z, irradiance: DVec3::splat(of(position_m)) }
        };
        Reference { points: points.iter().map(at).collect(), noise: 0.0 }
    }

    #[test]
    fn linear_light_is_shown_without_error_and_an_offset_is_the_error() {
        let linear = |p: DVec3| 4.0 + p.x - 0.5 * p.y;
        // Their mean is 4.
        let points = [[0.5, 0.25], [-0.5, -0.25], [0.9, -0.9], [-0.9, 0.9], [0.0, 0.0]];
        assert!(reference(&points, linear).error(&square(linear)).unwrap() < 1e-12);
        let error = reference(&points, linear).error(&square(|p| linear(p) + 0.04)).unwrap();
        assert!((error - 0.01).abs() < 1e-12, "{error}");
    }

    #[test]
    fn points_that_are_not_on_the_mesh_are_told() {
        let error = reference(&[[0.0, 0.0], [1.5, 0.0]], |_| 1.0).error(&square(|_| 1.0));
        assert!(error.is_err());
    }

    #[test]
    fn every_scene_with_reference_points_has_400() {
        for name in NAMES {
            assert_eq!(Reference::read(name).unwrap().points.len(), 400);
        }
        assert!(Reference::read("room").unwrap_err().to_string().contains("cornell, touching, occluder"));
    }
}
