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
        let reach = |corner: &DVec3| corner.distance(patch.centroid_m);
        let radius_m = polygon.corners_m.iter().map(reach).fold(0.0, f64::max);
        Self {
            node,
            centroid_m: patch.centroid_m,
            radius_m,
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
    let clear = first.clear_fits(&second);
    let near = f64::min(first.radii_to(&second), second.radii_to(&first)) < FAR_RADII;
    let exchange_m2 =
        if near { first.clear_exchange_area_m2(&second) } else { smaller_exchange_m2(&first, &second, &clear) };
    if !hidden {
        return links_of(&first, &second, exchange_m2, clear);
    }
    if most < STRONG_FACTOR {
        let share = visible_share(visibility, &first, &second);
        return links_of(&first, &second, share * exchange_m2, clear.map(|fit| dimmed(fit, share)));
    }
    let seen = first.seen_fits(visibility, &second);
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

/// A fit of which only a share is seen.
fn dimmed(fit: Linear<f64>, share: f64) -> Linear<f64> {
    Linear { mean: share * fit.mean, gradient: fit.gradient.map(|slope| share * slope) }
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

    /// One of [`RAY_POINTS`] points inside, half way from the middle to corners that are spread around.
    fn inner_point_m(&self, number: usize) -> DVec3 {
        let corners_m = &self.polygon.corners_m;
        self.centroid_m.midpoint(corners_m[number * corners_m.len() / RAY_POINTS])
    }

    /// Whether an inner point of this end sees one of another, both from their fronts.
    fn sees(&self, visibility: &Visibility, number: usize, other: &End, other_number: usize) -> bool {
        let (from_m, to_m) = (self.inner_point_m(number), other.inner_point_m(other_number));
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

    /// The best linear fits to the factors of each end's points to the other end, as if nothing stood between.
    fn clear_fits(&self, other: &End) -> [Linear<f64>; 2] {
        [(self, other), (other, self)]
            .map(|(receiver, source)| receiver.fit(|_, position_m| receiver.factor_to(position_m, source)))
    }

    /// The best linear fits to the factors of each end's points to the other end, of which they see as much as rays to the
    /// other's points tell.
    fn seen_fits(&self, visibility: &Visibility, other: &End) -> [Linear<f64>; 2] {
        let [mine, others] = [self, other].map(|end| sample::points(&end.polygon.corners_m));
        let passing = [self.polygon.plane, other.polygon.plane];
        let normals = [self, other].map(|end| end.polygon.oriented_plane.normal);
        // What could pass between two points, and whether it does.
        let exchange = |i: usize, j: usize| {
            let along = others[j].0 - mine[i].0;
            let cosines = normals[0].dot(along).max(0.0) * -normals[1].dot(along).min(0.0);
            let could = mine[i].1 * others[j].1 * cosines / along.length_squared().powi(2);
            let does = could > 0.0 && !visibility.occluded(mine[i].0, others[j].0, passing);
            (could, if does { could } else { 0.0 })
        };
        let exchanges: Vec<Vec<(f64, f64)>> =
            (0..mine.len()).map(|i| (0..others.len()).map(|j| exchange(i, j)).collect()).collect();
        let share = |pairs: &mut dyn Iterator<Item = (f64, f64)>| {
            let (could, does) = pairs.fold((0.0, 0.0), |(could, does), pair| (could + pair.0, does + pair.1));
            if could > 0.0 { does / could } else { 0.0 }
        };
        [
            self.fit(|i, position_m| share(&mut exchanges[i].iter().copied()) * self.factor_to(position_m, other)),
            other.fit(|j, position_m| {
                share(&mut exchanges.iter().map(|row| row[j])) * other.factor_to(position_m, self)
            }),
        ]
    }

    /// Factor of a point of this end to all of another.
    fn factor_to(&self, position_m: DVec3, source: &End) -> f64 {
        point_to_polygon(position_m, self.polygon.oriented_plane.normal, &source.polygon.corners_m)
    }

    /// The best linear fit to a factor of this end's sample points, by number and position.
    fn fit(&self, factor: impl Fn(usize, DVec3) -> f64) -> Linear<f64> {
        let plane = self.polygon.oriented_plane;
        Linear::fit(sample::points(&self.polygon.corners_m).into_iter().enumerate().map(
            |(number, (point_m, weight))| {
                let offset_m = self.frame.to_2d(point_m) - self.frame.to_2d(self.centroid_m);
                (offset_m, weight, factor(number, plane.project(point_m)))
            },
        ))
    }
}
