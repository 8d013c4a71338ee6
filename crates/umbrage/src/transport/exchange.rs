//! The exchange of light between two nodes: the form factors of their links, both ways from one computation,
//! `A1 F12 = A2 F21`.
//!
//! Four ways, by how much the ends can bring each other:
//! - weak ends are constant to one another, and a ray or four tell what they see of one another;
//! - ends in clear sight have the double contour integral where they are near, samples on the smaller where they are far;
//! - of ends with something between, sixteen rays tell the share that is seen;
//! - of strong ones rays between all their sample points tell what each point sees.
//!
//! Rays will do: links carry only what is reflected, and what is shown of that is gathered once more, with exact visibility.

use std::f64::consts::PI;

use glam::{DVec2, DVec3};

use super::contour;
use super::fit::Linear;
use super::form_factor::point_to_polygon;
use super::link::{Link, Node};
use super::sample;
use crate::geometry::{PlaneFrame, clip, polygon};
use crate::mesh::Mesh;
use crate::prepare::Prepared;
use crate::visibility::{SourcePolygon, Visibility};

/// One end of a link, with what its factors need.
#[derive(Debug)]
struct End {
    node: Node,
    centroid_m: DVec3,
    radius_m: f64,
    area_m2: f64,
    polygon: SourcePolygon,
    frame: PlaneFrame,
}

impl End {
    fn new(prepared: &Prepared, mesh: &Mesh, node: Node) -> Self {
        let patch = mesh.patch(node);
        let polygon = SourcePolygon::on_face(prepared, patch.face, mesh.polygon_m(node));
        Self {
            node,
            centroid_m: patch.centroid_m,
            radius_m: polygon.reach_m(patch.centroid_m),
            area_m2: patch.area_m2,
            polygon,
            frame: *mesh.frame(patch.face),
        }
    }
}

/// Ends whose distance is at least this many radii of the smaller one are far: samples on it are better than 1e-3 there,
/// and the contour integral starts to lose digits.
const FAR_RADII: f64 = 6.0;
/// Ends whose form factors are below this, whatever stands between them, are constant to one another, and one ray tells
/// whether they see one another: there are very many of them, whose errors cancel.
const FAINT_FACTOR: f64 = 0.001;
/// Ends whose form factors are below this are constant to one another too, and four rays tell how much they see.
const WEAK_FACTOR: f64 = 0.005;
/// Partly hidden ends whose form factors are below this see a share of one another that sixteen rays tell; above it each
/// sample point has its own rays.
const STRONG_FACTOR: f64 = 0.05;

/// The links between two nodes, one each way.
pub(super) fn link_both_ways(prepared: &Prepared, visibility: &Visibility, mesh: &Mesh, pair: [Node; 2]) -> [Link; 2] {
    let [first, second] = pair.map(|node| End::new(prepared, mesh, node));
    let most = first.most_factor(&second);
    if most < WEAK_FACTOR {
        let rays = if most < FAINT_FACTOR { 1 } else { RAY_POINTS };
        return weak_links(visibility, &first, &second, rays);
    }
    let hidden = visibility.may_be_blocked(&first.polygon, &second.polygon);
    let samples = [first.factors_to(&second), second.factors_to(&first)];
    let clear = [fit(&samples[0]), fit(&samples[1])];
    let near = f64::min(first.radii_to(&second), second.radii_to(&first)) < FAR_RADII;
    let exchange_m2 =
        if near { first.clear_exchange_area_m2(&second) } else { smaller_exchange_m2(&first, &second, &clear) };
    if !hidden {
        return links_of(&first, &second, exchange_m2, clear);
    }
    if most < STRONG_FACTOR {
        let share = visible_share(visibility, &first, &second);
        return links_of(&first, &second, share * exchange_m2, clear.map(|fit| fit * share));
    }
    let seen = seen_factors(visibility, [&first, &second], &samples).map(|samples| fit(&samples));
    let clear_m2 = smaller_exchange_m2(&first, &second, &clear);
    let share = if clear_m2 > 0.0 { smaller_exchange_m2(&first, &second, &seen) / clear_m2 } else { 0.0 };
    links_of(&first, &second, share * exchange_m2, seen)
}

/// Form factor times area, the same both ways, from the mean over the smaller end.
fn smaller_exchange_m2(first: &End, second: &End, fits: &[Linear<f64>; 2]) -> f64 {
    if first.area_m2 <= second.area_m2 { first.area_m2 * fits[0].mean } else { second.area_m2 * fits[1].mean }
}

/// The two links of an exchange of light.
fn links_of(first: &End, second: &End, exchange_m2: f64, fits: [Linear<f64>; 2]) -> [Link; 2] {
    [(first, second, fits), (second, first, [fits[1], fits[0]])].map(|(receiver, source, [there, back])| Link {
        receiver: receiver.node,
        source: source.node,
        form_factor: exchange_m2 / receiver.area_m2,
        gradient: DVec2::from(there.gradient).as_vec2(),
        moment_factor: (source.area_m2 / receiver.area_m2 * DVec2::from(back.gradient)).as_vec2(),
    })
}

/// Points on each end between which rays are sent.
const RAY_POINTS: usize = 4;

/// The share of rays between all pairs of inner points that nothing blocks.
fn visible_share(visibility: &Visibility, first: &End, second: &End) -> f64 {
    let pairs = (0..RAY_POINTS).flat_map(|i| (0..RAY_POINTS).map(move |j| (i, j)));
    let clear = pairs.filter(|&(i, j)| first.sees(visibility, i, second, j)).count();
    clear as f64 / (RAY_POINTS * RAY_POINTS) as f64
}

/// The links between two small ends that are far apart: constant over both, and seen as far as `rays` tell.
fn weak_links(visibility: &Visibility, first: &End, second: &End, rays: usize) -> [Link; 2] {
    let (smaller, larger) = if first.area_m2 <= second.area_m2 { (first, second) } else { (second, first) };
    let normal = smaller.polygon.oriented_plane.normal;
    let factor = point_to_polygon(smaller.centroid_m, normal, &larger.polygon.corners_m);
    let clear = |i: &usize| smaller.sees(visibility, *i, larger, RAY_POINTS - 1 - i);
    let seen = if factor > 0.0 { (0..rays).filter(clear).count() } else { 0 };
    let exchange_m2 = smaller.area_m2 * factor * seen as f64 / rays as f64;
    links_of(first, second, exchange_m2, [Linear::default(); 2])
}

impl End {
    /// A bound of the form factors between two ends, `A / (pi r^2)`, whatever stands between and however they are turned.
    fn most_factor(&self, other: &End) -> f64 {
        let apart_m = self.centroid_m.distance(other.centroid_m) - self.radius_m - other.radius_m;
        if apart_m > 0.0 { self.area_m2.max(other.area_m2) / (PI * apart_m * apart_m) } else { f64::INFINITY }
    }

    /// Whether an inner point of this end sees one of another, both from their fronts.
    fn sees(&self, visibility: &Visibility, number: usize, other: &End, other_number: usize) -> bool {
        let inner_point_m = |end: &End, number| end.polygon.inner_point_m(end.centroid_m, number, RAY_POINTS);
        let (from_m, to_m) = (inner_point_m(self, number), inner_point_m(other, other_number));
        self.polygon.oriented_plane.signed_distance_m(to_m) > 0.0
            && other.polygon.oriented_plane.signed_distance_m(from_m) > 0.0
            && !visibility.occluded(from_m, to_m, [self.polygon.plane, other.polygon.plane])
    }

    /// Distance of this end's middle from the other end, in this end's radii.
    fn radii_to(&self, other: &End) -> f64 {
        let distance_m = polygon::distance_m(self.centroid_m, &other.polygon.corners_m, &other.polygon.oriented_plane);
        distance_m / self.radius_m
    }

    /// Form factor times area, the same both ways, of ends in clear sight of one another.
    fn clear_exchange_area_m2(&self, other: &End) -> f64 {
        let in_front = |of: &End, plane| clip::in_front_of(&of.polygon.corners_m, plane, 0.0);
        contour::exchange_area_m2(
            &in_front(self, &other.polygon.oriented_plane),
            &in_front(other, &self.polygon.oriented_plane),
        )
    }

    /// The factors of this end's sample points to another end, as if nothing stood between.
    fn factors_to(&self, source: &End) -> Vec<Sample> {
        let plane = self.polygon.oriented_plane;
        let sample = |(point_m, weight)| Sample {
            point_m,
            offset_m: self.frame.to_2d(point_m) - self.frame.to_2d(self.centroid_m),
            weight,
            factor: point_to_polygon(plane.project(point_m), plane.normal, &source.polygon.corners_m),
        };
        sample::points(&self.polygon.corners_m).into_iter().map(sample).collect()
    }
}

/// A point of an end, with its factor to another.
#[derive(Clone, Copy, Debug)]
struct Sample {
    point_m: DVec3,
    /// From the end's centroid.
    offset_m: DVec2,
    weight: f64,
    factor: f64,
}

/// The best linear fit to the factors of an end's points.
fn fit(samples: &[Sample]) -> Linear<f64> {
    Linear::fit(samples.iter().map(|sample| (sample.offset_m, sample.weight, sample.factor)))
}

/// The factors of two ends' points to one another, of which each point sees as much as rays to the other's points tell.
fn seen_factors(visibility: &Visibility, [first, second]: [&End; 2], clear: &[Vec<Sample>; 2]) -> [Vec<Sample>; 2] {
    let passing = [first.polygon.plane, second.polygon.plane];
    let normals = [first, second].map(|end| end.polygon.oriented_plane.normal);
    // What could pass between two points, and what does.
    let exchange = |from: &Sample, to: &Sample| {
        let along = to.point_m - from.point_m;
        let cosines = normals[0].dot(along).max(0.0) * -normals[1].dot(along).min(0.0);
        let could = from.weight * to.weight * cosines / along.length_squared().powi(2);
        let does = could > 0.0 && !visibility.occluded(from.point_m, to.point_m, passing);
        (could, if does { could } else { 0.0 })
    };
    let [mine, others] = clear;
    let exchanges: Vec<Vec<(f64, f64)>> =
        mine.iter().map(|from| others.iter().map(|to| exchange(from, to)).collect()).collect();
    let dimmed = |sample: &Sample, pairs: &mut dyn Iterator<Item = (f64, f64)>| {
        let (could, does) = pairs.fold((0.0, 0.0), |(could, does), pair| (could + pair.0, does + pair.1));
        let share = if could > 0.0 { does / could } else { 0.0 };
        Sample { factor: share * sample.factor, ..*sample }
    };
    let of_first = mine.iter().zip(&exchanges).map(|(sample, row)| dimmed(sample, &mut row.iter().copied()));
    let of_second =
        others.iter().enumerate().map(|(j, sample)| dimmed(sample, &mut exchanges.iter().map(|row| row[j])));
    [of_first.collect(), of_second.collect()]
}
