//! Links: which node of the hierarchy gathers light from which other, and by what factor.
//!
//! A link's form factor is the area mean, over its receiver, of the exact visible point-to-source factor: it holds the
//! occlusion, so that no separate visibility is needed. A pair of patches has a link each way, and both come from one
//! computation, `A1 F12 = A2 F21`, on the smaller end.
//!
//! Holds: links are in the order of their receivers, then of their sources; no factor is zero.

use std::f64::consts::PI;
use std::ops::Range;

use glam::{DMat2, DVec2, DVec3, Vec2};

use super::contour;
use super::form_factor::{point_to_polygon, point_to_visible_part};
use super::sample::{self, Rule};
use crate::geometry::{PlaneFrame, clip, polygon};
use crate::id::PatchId;
use crate::mesh::Mesh;
use crate::prepare::Prepared;
use crate::visibility::{ReceiverPoint, SourcePolygon, Visibility};

/// A node of the hierarchy that links join: a patch.
pub type Node = PatchId;

/// Whether anything stands between the ends of a link.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Sight {
    /// Nothing: the shaft between them is empty.
    Clear,
    /// Perhaps something.
    Partial,
}

/// Light travels from `source` to `receiver`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Link {
    /// The node that gathers.
    pub receiver: Node,
    /// The node that it gathers from.
    pub source: Node,
    /// Share of the light that leaves the receiver, uniformly, and arrives at the source unhindered: the mean of the
    /// visible point factor over the receiver.
    pub form_factor: f64,
    /// How the point factor changes over the receiver, along the axes of its face's frame, per metre: the best linear
    /// fit.
    pub gradient: Vec2,
    /// How the mean irradiance on the receiver changes with the first moment of the source's radiosity, along the axes of
    /// the source's frame, per metre: the gradient of the link back, times the source's area over the receiver's.
    pub moment_factor: Vec2,
    /// Whether anything stands between.
    pub sight: Sight,
}

/// All links, by receiver.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Links {
    links: Vec<Link>,
    starts: Vec<u32>,
}

/// A broken promise of [`Links`]: always a defect of this library.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum LinkError {
    /// A factor is not above 0, or more than 1.
    #[error("{0:?} has a form factor outside of 0 to 1")]
    BadFactor(Link),
    /// A patch that holds a contact (D0) has a link.
    #[error("{0:?} ends at a patch that holds a D0 split-hint")]
    AcrossContact(Link),
}

impl Links {
    /// Orders links by their ends, and drops those of factor zero.
    pub fn new(mut links: Vec<Link>, node_count: usize) -> Self {
        links.retain(|link| link.form_factor > 0.0);
        links.sort_by_key(|link| (link.receiver, link.source));
        let mut starts = Vec::with_capacity(node_count + 1);
        let mut next = 0;
        for node in 0..=node_count {
            while next < links.len() && links[next].receiver.index() < node {
                next += 1;
            }
            starts.push(next as u32);
        }
        Self { links, starts }
    }

    /// All links, in order.
    pub fn as_slice(&self) -> &[Link] {
        &self.links
    }

    /// Number of links.
    pub fn len(&self) -> usize {
        self.links.len()
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.links.is_empty()
    }

    /// The links that `receiver` gathers over.
    pub fn of(&self, receiver: Node) -> &[Link] {
        &self.links[self.range(receiver)]
    }

    fn range(&self, receiver: Node) -> Range<usize> {
        let start = |node: usize| self.starts.get(node).map_or(self.links.len(), |&start| start as usize);
        start(receiver.index())..start(receiver.index() + 1)
    }

    /// Checks what can be checked of the promises above, and that no link ends at a patch that holds a D0 hint.
    ///
    /// # Errors
    /// The first broken promise.
    pub fn validate(&self, mesh: &Mesh) -> Result<(), LinkError> {
        for link in &self.links {
            if !(link.form_factor > 0.0 && link.form_factor <= 1.0 + FACTOR_SLACK) {
                return Err(LinkError::BadFactor(*link));
            }
            if mesh.has_d0_hint(link.receiver) || mesh.has_d0_hint(link.source) {
                return Err(LinkError::AcrossContact(*link));
            }
        }
        Ok(())
    }
}

/// Rounding of a sum of angles: by no more than this a factor may exceed 1.
const FACTOR_SLACK: f64 = 1e-9;

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
/// Ends whose form factors are below this, whatever stands between them, are constant to one another, and four rays tell
/// how much of one another they see.
const WEAK_FACTOR: f64 = 0.005;
/// Partly hidden ends whose form factors are below this see a share of one another that sixteen rays tell; above it the
/// exact visible part is averaged.
const STRONG_FACTOR: f64 = 0.05;

/// The links between two nodes, one each way.
pub(super) fn link_both_ways(prepared: &Prepared, visibility: &Visibility, mesh: &Mesh, pair: [Node; 2]) -> [Link; 2] {
    let [first, second] = pair.map(|node| End::new(prepared, mesh, node));
    let most = first.most_factor(&second);
    if most < WEAK_FACTOR {
        return weak_links(visibility, &first, &second);
    }
    let hidden = visibility.may_be_blocked(&first.polygon, &second.polygon);
    if !hidden || most < STRONG_FACTOR {
        let clear = clear_links(&first, &second);
        return if hidden { shaded(clear, visible_share(visibility, &first, &second)) } else { clear };
    }
    let fits = [first.visible_fit(visibility, &second), second.visible_fit(visibility, &first)];
    let exchange_m2 = smaller_exchange_m2(&first, &second, &fits);
    links_of(&first, &second, exchange_m2, fits, Sight::Partial)
}

/// The links between ends in clear sight of one another.
fn clear_links(first: &End, second: &End) -> [Link; 2] {
    let fits = [first.clear_fit(second), second.clear_fit(first)];
    let near = f64::min(first.radii_to(second), second.radii_to(first)) < FAR_RADII;
    let exchange_m2 =
        if near { first.clear_exchange_area_m2(second) } else { smaller_exchange_m2(first, second, &fits) };
    links_of(first, second, exchange_m2, fits, Sight::Clear)
}

/// Form factor times area, the same both ways, from the mean over the smaller end.
fn smaller_exchange_m2(first: &End, second: &End, fits: &[Fit; 2]) -> f64 {
    if first.area_m2 <= second.area_m2 { first.area_m2 * fits[0].mean } else { second.area_m2 * fits[1].mean }
}

/// The two links of an exchange of light.
fn links_of(first: &End, second: &End, exchange_m2: f64, fits: [Fit; 2], sight: Sight) -> [Link; 2] {
    [(first, second, fits), (second, first, [fits[1], fits[0]])].map(|(receiver, source, [there, back])| Link {
        receiver: receiver.node,
        source: source.node,
        form_factor: exchange_m2 / receiver.area_m2,
        gradient: there.gradient.as_vec2(),
        moment_factor: (source.area_m2 / receiver.area_m2 * back.gradient).as_vec2(),
        sight,
    })
}

/// Clear links of which only a share is seen.
fn shaded(links: [Link; 2], share: f64) -> [Link; 2] {
    links.map(|link| Link {
        form_factor: share * link.form_factor,
        gradient: share as f32 * link.gradient,
        moment_factor: share as f32 * link.moment_factor,
        sight: Sight::Partial,
        ..link
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

/// The links between two small ends that are far apart: constant over both.
fn weak_links(visibility: &Visibility, first: &End, second: &End) -> [Link; 2] {
    let (smaller, larger) = if first.area_m2 <= second.area_m2 { (first, second) } else { (second, first) };
    let normal = smaller.polygon.oriented_plane.normal;
    let factor = point_to_polygon(smaller.centroid_m, normal, &larger.polygon.corners_m);
    let clear = |i: &usize| smaller.sees(visibility, *i, larger, RAY_POINTS - 1 - i);
    let seen = if factor > 0.0 { (0..RAY_POINTS).filter(clear).count() } else { 0 };
    let exchange_m2 = smaller.area_m2 * factor * seen as f64 / RAY_POINTS as f64;
    let constant = Fit { mean: 0.0, gradient: DVec2::ZERO };
    let sight = if seen == RAY_POINTS { Sight::Clear } else { Sight::Partial };
    links_of(first, second, exchange_m2, [constant; 2], sight)
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

    /// The best linear fit to the factor of this end's points to `source`, as if nothing stood between.
    fn clear_fit(&self, source: &End) -> Fit {
        let normal = self.polygon.oriented_plane.normal;
        self.fit(Rule::Six, |position_m| point_to_polygon(position_m, normal, &source.polygon.corners_m))
    }

    /// The best linear fit to the visible factor of this end's points to `source`.
    fn visible_fit(&self, visibility: &Visibility, source: &End) -> Fit {
        let (normal, plane) = (self.polygon.oriented_plane.normal, self.polygon.plane);
        self.fit(sample::rule_past_occluders(self.radii_to(source)), |position_m| {
            let part = visibility.visible_part(&ReceiverPoint { position_m, normal, plane }, &source.polygon);
            point_to_visible_part(position_m, normal, &part)
        })
    }

    fn fit(&self, rule: Rule, factor: impl Fn(DVec3) -> f64) -> Fit {
        let plane = self.polygon.oriented_plane;
        Fit::new(sample::points(&self.polygon.corners_m, rule).into_iter().map(|(point_m, weight)| {
            (self.frame.to_2d(point_m) - self.frame.to_2d(self.centroid_m), weight, factor(plane.project(point_m)))
        }))
    }
}

/// A linear function over a patch: its mean, and its gradient per metre.
#[derive(Clone, Copy, Debug)]
struct Fit {
    mean: f64,
    gradient: DVec2,
}

impl Fit {
    /// The least squares fit to offsets from the centroid, weights that sum to 1, and values.
    fn new(values: impl Iterator<Item = (DVec2, f64, f64)>) -> Self {
        let (mut mean, mut moment, mut spread) = (0.0, DVec2::ZERO, DMat2::ZERO);
        for (offset, weight, value) in values {
            mean += weight * value;
            moment += weight * value * offset;
            spread += weight * DMat2::from_cols(offset * offset.x, offset * offset.y);
        }
        let gradient = if spread.determinant() > 0.0 { spread.inverse() * moment } else { DVec2::ZERO };
        Self { mean, gradient: if gradient.is_finite() { gradient } else { DVec2::ZERO } }
    }
}
