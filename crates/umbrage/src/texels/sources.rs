//! Direct light of texels: the light of every source that falls on a point if nothing stood between, times the share of it that shadow
//! rays see.
//!
//! A luminous face is cut into pieces that are small beside their distance; each has its exact form factor, and rays go to pieces in
//! proportion to that. So nothing is said of a part that no ray was sent to, and the estimate has no bias near a large source. Of
//! many sources those that bring little are represented by one of them, chosen in proportion to its light.

use glam::{DVec3, Vec3};
use smallvec::SmallVec;

use super::ray_tree::RayTree;
use crate::id::FaceId;
use crate::prepare::Prepared;
use crate::scene::{Rgb, Scene};
use crate::transport::DirectLight;
use crate::transport::form_factor::point_to_polygon;
use crate::visibility::ReceiverPoint;

/// A piece of a source is cut while the square of its size is more than this share of the square of its distance.
const MAX_SIZE_OF_DISTANCE: f64 = 0.8;
/// It is cut into quarters at most so many times.
const MAX_QUARTERINGS: u32 = 6;
/// Sources that bring less than this share of the light of all have one ray together, where there are more than so many.
const MIN_SHARE: f64 = 0.03;
const FEW_SOURCES: usize = 4;
/// The end of a ray is chosen among so many points of a piece: with one, the shadow of a thing near a large source is off by 5 %.
const CANDIDATES: usize = 6;

/// Where rays leave a surface.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Start {
    pub(crate) receiver: ReceiverPoint,
    pub(crate) from: Vec3,
    /// Two vectors across the normal, and the normal.
    pub(crate) axes: [Vec3; 3],
}

impl Start {
    /// The start of rays at a point of a face; over the curved surface where it is smooth.
    pub(crate) fn new(prepared: &Prepared, tree: &RayTree, face: FaceId, point_m: DVec3) -> Self {
        let receiver = ReceiverPoint::on_face(prepared, face, point_m);
        let over_m = receiver.near.map_or(receiver.position_m, |near| near.from_m);
        let normal = receiver.normal.as_vec3();
        let (across, along) = normal.any_orthonormal_pair();
        let flat = prepared.normal(face);
        Self { receiver, from: tree.start(over_m, flat), axes: [across, along, normal] }
    }

    /// The same at another point of a plane face.
    pub(crate) fn moved_to(self, tree: &RayTree, point_m: DVec3) -> Self {
        let receiver = ReceiverPoint { position_m: point_m, ..self.receiver };
        Self { receiver, from: tree.start(point_m, receiver.normal), ..self }
    }

    /// A direction over the surface, distributed as its cosine, for two even random numbers.
    pub(crate) fn direction(&self, s: f32, t: f32) -> Vec3 {
        let [x, y] = on_disk(s, t);
        let height = (1.0 - x * x - y * y).max(1e-8).sqrt();
        x * self.axes[0] + y * self.axes[1] + height * self.axes[2]
    }
}

/// The map from the unit square to the unit disk that keeps shares of area (Shirley and Chiu, *A low distortion map between disk and
/// square*, 1997).
fn on_disk(s: f32, t: f32) -> [f32; 2] {
    let (x, y) = (2.0 * s - 1.0, 2.0 * t - 1.0);
    if x == 0.0 && y == 0.0 {
        return [0.0; 2];
    }
    let quarter = std::f32::consts::FRAC_PI_4;
    let (radius, angle) = if x.abs() > y.abs() { (x, quarter * y / x) } else { (y, quarter * (2.0 - x / y)) };
    let (sine, cosine) = angle.sin_cos();
    [radius * cosine, radius * sine]
}

/// A luminous face.
#[derive(Clone, Debug)]
struct AreaSource {
    corners_m: Vec<DVec3>,
    normal: DVec3,
    exitance: Rgb,
}

/// The sources of a scene, for shadow rays.
#[derive(Debug)]
pub(crate) struct Sources<'a> {
    areas: Vec<AreaSource>,
    direct: &'a DirectLight<'a>,
    tree: &'a RayTree,
}

/// What a source brings to a point if nothing stands between.
struct Bare {
    light: Rgb,
    to: Target,
}

/// Where shadow rays go.
enum Target {
    Area(usize),
    Point(DVec3),
}

/// A triangle of a source, and its form factor.
type Piece = ([DVec3; 3], f64);

impl<'a> Sources<'a> {
    pub(crate) fn new(scene: &Scene, prepared: &Prepared, direct: &'a DirectLight<'a>, tree: &'a RayTree) -> Self {
        let luminous = prepared.faces.iter_enumerated().filter_map(|(id, face)| {
            let material = &scene.materials[face.material];
            let source = || AreaSource {
                corners_m: prepared.polygon_m(id),
                normal: prepared.normal(id),
                exitance: material.exitance(),
            };
            material.emits().then(source)
        });
        Self { areas: luminous.collect(), direct, tree }
    }

    /// An unbiased estimate of the direct irradiance at a point, from `rays` shadow rays to each source that matters.
    pub(crate) fn irradiance(&self, start: &Start, rays: usize, mut draw: impl FnMut() -> f32) -> Rgb {
        let bare = self.bare(start);
        let all: f64 = bare.iter().map(|bare| bare.light.element_sum()).sum();
        let is_weak = |bare: &Bare| bare.light.element_sum() < MIN_SHARE * all;
        let (weak, strong): (Vec<&Bare>, Vec<&Bare>) =
            bare.iter().partition(|source| bare.len() > FEW_SOURCES && is_weak(source));
        let mut light: Rgb =
            strong.iter().map(|source| self.seen(start, &source.to, rays, &mut draw) * source.light).sum();
        if let Some((source, weight)) = drawn(&weak, draw()) {
            light += weight * self.seen(start, &source.to, 1, &mut draw) * source.light;
        }
        light
    }

    /// The same from one shadow ray to one source, for points over which the mean is taken.
    pub(crate) fn irradiance_from_one(&self, start: &Start, mut draw: impl FnMut() -> f32) -> Rgb {
        let bare = self.bare(start);
        let all: Vec<&Bare> = bare.iter().collect();
        let one = drawn(&all, draw());
        one.map_or(Rgb::ZERO, |(source, weight)| weight * self.seen(start, &source.to, 1, &mut draw) * source.light)
    }

    /// The sources that would light a point.
    fn bare(&self, start: &Start) -> Vec<Bare> {
        let ReceiverPoint { position_m, normal, .. } = start.receiver;
        let mut bare = Vec::new();
        for (number, source) in self.areas.iter().enumerate() {
            if source.normal.dot(position_m - source.corners_m[0]) > 0.0 {
                let factor = point_to_polygon(position_m, normal, &source.corners_m).max(0.0);
                if factor > 0.0 {
                    bare.push(Bare { light: factor * source.exitance, to: Target::Area(number) });
                }
            }
        }
        self.direct.unoccluded_lamps(&start.receiver, |light, to_m| bare.push(Bare { light, to: Target::Point(to_m) }));
        bare
    }

    /// The share of a source's light that rays see.
    fn seen(&self, start: &Start, to: &Target, rays: usize, draw: &mut impl FnMut() -> f32) -> f64 {
        let ReceiverPoint { position_m, normal, .. } = start.receiver;
        let number = match *to {
            Target::Point(to_m) => return f64::from(u8::from(self.tree.is_clear(start.from, to_m.as_vec3()))),
            Target::Area(number) => number,
        };
        let pieces = pieces(position_m, normal, &self.areas[number].corners_m);
        let whole: f64 = pieces.iter().map(|(_, factor)| factor).sum();
        if whole <= 0.0 {
            return 0.0;
        }
        let shift = f64::from(draw());
        let mut clear = 0_u32;
        for ray in 0..rays {
            let mut left = (shift + ray as f64) / rays as f64 * whole;
            let is_drawn = |(_, factor): &Piece| {
                left -= factor;
                left < 0.0
            };
            let (triangle, _) = pieces[pieces.iter().position(is_drawn).unwrap_or(pieces.len() - 1)];
            let to_m = self.point_of(number, &triangle, position_m, normal, draw);
            clear += u32::from(self.tree.is_clear(start.from, to_m.as_vec3()));
        }
        f64::from(clear) / rays as f64
    }
}

impl Sources<'_> {
    /// A point of a piece of a luminous face, drawn about in proportion to what it brings (sampling importance resampling).
    fn point_of(
        &self,
        source: usize,
        [a, b, c]: &[DVec3; 3],
        position_m: DVec3,
        normal: DVec3,
        draw: &mut impl FnMut() -> f32,
    ) -> DVec3 {
        let (mut chosen, mut all) = (*a, 0.0);
        for _ in 0..CANDIDATES {
            let (away, across) = (f64::from(draw()).sqrt(), f64::from(draw()));
            let point_m = a + away * ((1.0 - across) * (b - a) + across * (c - a));
            let towards = point_m - position_m;
            let height = -self.areas[source].normal.dot(towards);
            let brings = normal.dot(towards).max(0.0) * height.max(0.0) / towards.length_squared().powi(2);
            all += brings;
            if brings > 0.0 && f64::from(draw()) * all < brings {
                chosen = point_m;
            }
        }
        chosen
    }
}

/// One of some sources, drawn in proportion to its light, and one over its probability.
fn drawn<'b>(sources: &[&'b Bare], number: f32) -> Option<(&'b Bare, f64)> {
    let all: f64 = sources.iter().map(|source| source.light.element_sum()).sum();
    let mut left = f64::from(number) * all;
    let is_drawn = |source: &&&Bare| {
        left -= source.light.element_sum();
        left < 0.0
    };
    let source = sources.iter().find(is_drawn).or(sources.last())?;
    (all > 0.0).then(|| (*source, all / source.light.element_sum()))
}

/// Pieces of a convex source that are small beside their distance from a point, with their form factors.
fn pieces(position_m: DVec3, normal: DVec3, corners_m: &[DVec3]) -> SmallVec<[Piece; 16]> {
    let mut pieces = SmallVec::new();
    let mut open: SmallVec<[([DVec3; 3], u32); 32]> =
        corners_m[1..].windows(2).map(|pair| ([corners_m[0], pair[0], pair[1]], 0)).collect();
    while let Some(([a, b, c], quarterings)) = open.pop() {
        let size = (b - a).length_squared().max((c - b).length_squared()).max((a - c).length_squared());
        let away = ((a + b + c) / 3.0 - position_m).length_squared();
        if size <= MAX_SIZE_OF_DISTANCE * away || quarterings >= MAX_QUARTERINGS {
            let factor = point_to_polygon(position_m, normal, &[a, b, c]);
            if factor > 0.0 {
                pieces.push(([a, b, c], factor));
            }
            continue;
        }
        let [ab, bc, ca] = [a.midpoint(b), b.midpoint(c), c.midpoint(a)];
        for quarter in [[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]] {
            if quarter.iter().any(|&corner| normal.dot(corner - position_m) > 0.0) {
                open.push((quarter, quarterings + 1));
            }
        }
    }
    pieces
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::{Lamp, LampKind, Material};
    use crate::texels::sequence::{Draws, key_of};
    use crate::visibility::{Visibility, fixture};

    /// Mean of many estimates at a point beside what it is exactly.
    fn mean_and_exact(polygons: &[(Vec<DVec3>, usize)], scene: &Scene, at_m: DVec3, one: bool) -> (f64, f64) {
        let prepared = fixture::prepared_of_materials(polygons);
        let visibility = Visibility::new(&prepared);
        let direct = DirectLight::new(scene, &prepared, &visibility);
        let tree = RayTree::new(&prepared);
        let sources = Sources::new(scene, &prepared, &direct, &tree);
        let floor = prepared.faces.keys().find(|&face| prepared.normal(face).z > 0.5).unwrap();
        let start = Start::new(&prepared, &tree, floor, at_m);
        let count = 20_000;
        let sum: f64 = (0..count)
            .map(|i| {
                let mut draws = Draws::new(key_of(i, 9));
                let light = match one {
                    true => sources.irradiance_from_one(&start, || draws.next()),
                    false => sources.irradiance(&start, 2, || draws.next()),
                };
                light.x
            })
            .sum();
        (sum / count as f64, direct.at(&start.receiver).x)
    }

    #[test]
    fn estimates_have_no_bias_near_a_large_source_that_is_partly_hidden() {
        let mut scene =
            fixture::scene(vec![Material::diffuse("grey", Rgb::splat(0.5)), Material::emitting("lamp", Rgb::ONE)]);
        scene.lamps.push(Lamp {
            name: String::new(),
            kind: LampKind::Point { position_m: DVec3::new(0.2, 0.1, 0.6), intensity: Rgb::splat(0.3), range_m: None },
        });
        let polygons = [
            (fixture::square(DVec3::ZERO, 2.0, true), 0),
            (fixture::square(DVec3::new(0.3, 0.0, 0.3), 1.0, false), 1),
            (fixture::square(DVec3::new(0.5, 0.4, 0.1), 0.2, true), 0),
        ];
        for (i, at_m) in
            [DVec3::new(0.4, 0.3, 0.0), DVec3::new(-0.9, 0.2, 0.0), DVec3::new(1.1, -0.8, 0.0)].iter().enumerate()
        {
            for one in [false, true] {
                let (mean, exact) = mean_and_exact(&polygons, &scene, *at_m, one);
                assert!((mean / exact - 1.0).abs() < 0.02, "{i}, {one}: {mean} is not {exact}");
            }
        }
    }
}
