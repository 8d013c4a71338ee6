//! Direct light of texels and of places that rays meet: what sources bring if nothing stood between, times what shadow rays see of them.
//!
//! **Texels** have a few rays to each source that matters. A luminous face is cut into pieces that are small beside their distance; each
//! has its exact form factor, and rays go to pieces in proportion to that. So nothing is said of a part that no ray was sent to, and
//! the estimate has no bias near a large source. Where sources are many, a cut through a light tree stands for them: one source of each
//! part, drawn by power. Those that bring little are represented by one of them, drawn by its light.
//!
//! **Other places** are met once, and have one ray, to a source that is drawn by its light.

use glam::{DVec3, Vec3};
use smallvec::SmallVec;

use super::light_tree::{Light, LightTree};
use super::ray_tree::RayTree;
use crate::geometry::polygon;
use crate::id::{FaceId, LampId};
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
/// Of more sources than this, one stands for each part of a cut of so many through the light tree.
const MOST_SOURCES: usize = 24;
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

/// A luminous face, or a lamp at a place.
#[derive(Clone, Debug)]
enum Source {
    Area(AreaSource),
    Lamp(LampId),
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
    /// Those at a place, in the order of the tree.
    placed: Vec<Source>,
    lights: LightTree,
    /// Distant lamps.
    distant: Vec<LampId>,
    direct: &'a DirectLight<'a>,
    tree: &'a RayTree,
}

/// What a source brings to a point if nothing stands between.
struct Bare<'b> {
    light: Rgb,
    to: Target<'b>,
}

/// Where shadow rays go.
enum Target<'b> {
    Area(&'b AreaSource),
    Lamp(LampId, DVec3),
}

/// A triangle of a source, and its form factor.
type Piece = ([DVec3; 3], f64);

impl<'a> Sources<'a> {
    pub(crate) fn new(scene: &Scene, prepared: &Prepared, direct: &'a DirectLight<'a>, tree: &'a RayTree) -> Self {
        let (mut placed, mut distant, mut lights) = (Vec::new(), Vec::new(), Vec::new());
        for (id, face) in prepared.faces.iter_enumerated() {
            let material = &scene.materials[face.material];
            if material.emits() {
                let (corners_m, normal) = (prepared.polygon_m(id), prepared.normal(id));
                let source = AreaSource { corners_m, normal, exitance: material.exitance() };
                lights.push(source.light());
                placed.push(Source::Area(source));
            }
        }
        for (id, lamp) in direct.lamps() {
            match lamp.position_m() {
                Some(position_m) if lamp.emits() => {
                    // At a metre.
                    let power = lamp.brightness().element_sum() as f32;
                    lights.push(Light { middle: position_m.as_vec3(), radius_m: 0.0, normal: None, power });
                    placed.push(Source::Lamp(id));
                }
                Some(_) => {}
                None => distant.push(id),
            }
        }
        let (lights, order) = LightTree::new(&lights);
        let placed = order.iter().map(|&number| placed[number as usize].clone()).collect();
        Self { placed, lights, distant, direct, tree }
    }

    /// An unbiased estimate of the direct irradiance at a point, from `rays` shadow rays to each source that matters, of all sources
    /// but some lamps.
    pub(crate) fn irradiance(&self, start: &Start, but: &[LampId], rays: usize, mut draw: impl FnMut() -> f32) -> Rgb {
        let mut bare = self.bare(start, &mut draw);
        bare.retain(|bare| !matches!(bare.to, Target::Lamp(lamp, _) if but.contains(&lamp)));
        let all: f64 = bare.iter().map(|bare| bare.light.element_sum()).sum();
        let is_weak = |bare: &Bare<'_>| bare.light.element_sum() < MIN_SHARE * all;
        let (weak, strong): (Vec<&Bare<'_>>, Vec<&Bare<'_>>) =
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
        let bare = self.bare(start, &mut draw);
        let all: Vec<&Bare<'_>> = bare.iter().collect();
        let one = drawn(&all, draw());
        one.map_or(Rgb::ZERO, |(source, weight)| weight * self.seen(start, &source.to, 1, &mut draw) * source.light)
    }

    /// The sources that would light a point; where they are many, some for all.
    fn bare(&self, start: &Start, draw: &mut impl FnMut() -> f32) -> Vec<Bare<'_>> {
        let mut bare = Vec::new();
        if self.placed.len() <= MOST_SOURCES {
            bare.extend(self.placed.iter().filter_map(|source| self.bare_of(start, source, 1.0)));
        } else {
            let cut = self.lights.cut(&[start.from], start.axes[2], MOST_SOURCES);
            for lights in self.lights.parts(&cut) {
                let (number, probability) = self.lights.draw_of(lights, draw());
                bare.extend(self.bare_of(start, &self.placed[number], 1.0 / f64::from(probability)));
            }
        }
        self.distant.iter().for_each(|&lamp| bare.extend(self.bare_of_lamp(start, lamp, 1.0)));
        bare
    }

    fn bare_of<'b>(&'b self, start: &Start, source: &'b Source, weight: f64) -> Option<Bare<'b>> {
        let ReceiverPoint { position_m, normal, .. } = start.receiver;
        match source {
            Source::Lamp(lamp) => self.bare_of_lamp(start, *lamp, weight),
            Source::Area(source) => {
                let faces = source.normal.dot(position_m - source.corners_m[0]) > 0.0;
                let factor = if faces { point_to_polygon(position_m, normal, &source.corners_m) } else { 0.0 };
                (factor > 0.0).then(|| Bare { light: weight * factor * source.exitance, to: Target::Area(source) })
            }
        }
    }

    fn bare_of_lamp(&self, start: &Start, lamp: LampId, weight: f64) -> Option<Bare<'_>> {
        let (light, to_m) = self.direct.unoccluded_lamp(lamp, &start.receiver)?;
        Some(Bare { light: weight * light, to: Target::Lamp(lamp, to_m) })
    }

    /// The share of a source's light that rays see.
    fn seen(&self, start: &Start, to: &Target<'_>, rays: usize, draw: &mut impl FnMut() -> f32) -> f64 {
        let ReceiverPoint { position_m, normal, .. } = start.receiver;
        let source = match *to {
            Target::Lamp(_, to_m) => return f64::from(u8::from(self.tree.is_clear(start.from, to_m.as_vec3()))),
            Target::Area(source) => source,
        };
        let pieces = pieces(position_m, normal, &source.corners_m);
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
            let to_m = source.point_of(&triangle, position_m, normal, draw);
            clear += u32::from(self.tree.is_clear(start.from, to_m.as_vec3()));
        }
        f64::from(clear) / rays as f64
    }
}

impl AreaSource {
    fn light(&self) -> Light {
        let middle_m = self.corners_m.iter().sum::<DVec3>() / self.corners_m.len() as f64;
        let radius_m = self.corners_m.iter().map(|corner| corner.distance(middle_m)).fold(0.0, f64::max) as f32;
        let power = (polygon::area_m2(&self.corners_m) * self.exitance.element_sum()) as f32;
        Light { middle: middle_m.as_vec3(), radius_m, normal: Some(self.normal.as_vec3()), power }
    }

    /// A point of a piece, drawn about in proportion to what it brings (sampling importance resampling).
    fn point_of(
        &self,
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
            let height = -self.normal.dot(towards);
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
fn drawn<'b, 's>(sources: &[&'b Bare<'s>], number: f32) -> Option<(&'b Bare<'s>, f64)> {
    let all: f64 = sources.iter().map(|source| source.light.element_sum()).sum();
    let mut left = f64::from(number) * all;
    let is_drawn = |source: &&&Bare<'_>| {
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

    /// Mean of many estimates at a point, what it is exactly, and the standard error of the mean.
    fn mean_and_exact(polygons: &[(Vec<DVec3>, usize)], scene: &Scene, at_m: DVec3, one: bool) -> [f64; 3] {
        let prepared = fixture::prepared_of_materials(polygons);
        let visibility = Visibility::new(&prepared);
        let direct = DirectLight::new(scene, &prepared, &visibility);
        let tree = RayTree::new(&prepared);
        let sources = Sources::new(scene, &prepared, &direct, &tree);
        let floor = prepared.faces.keys().find(|&face| prepared.normal(face).z > 0.5).unwrap();
        let start = Start::new(&prepared, &tree, floor, at_m);
        let count = 20_000;
        let estimate = |i: usize| {
            let mut draws = Draws::new(key_of(i, 9));
            let light = match one {
                true => sources.irradiance_from_one(&start, || draws.next()),
                false => sources.irradiance(&start, &[], 2, || draws.next()),
            };
            light.x
        };
        let estimates: Vec<f64> = (0..count).map(estimate).collect();
        let mean = estimates.iter().sum::<f64>() / count as f64;
        let squared = estimates.iter().map(|light| (light - mean).powi(2)).sum::<f64>();
        [mean, direct.at(&start.receiver).x, squared.sqrt() / count as f64]
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
                let [mean, exact, _] = mean_and_exact(&polygons, &scene, *at_m, one);
                assert!((mean / exact - 1.0).abs() < 0.02, "{i}, {one}: {mean} is not {exact}");
            }
        }
    }

    #[test]
    fn a_cut_stands_for_many_sources_without_bias() {
        let materials = vec![Material::diffuse("grey", Rgb::splat(0.5)), Material::emitting("lamp", Rgb::ONE)];
        let mut scene = fixture::scene(materials);
        let at =
            |i: usize| DVec3::new(0.7 * (i % 9) as f64 - 3.0, 0.6 * (i / 9) as f64 - 2.0, 1.0 + 0.2 * (i % 4) as f64);
        let mut polygons: Vec<_> = (0..54).map(|i| (fixture::square(at(i), 0.1, false), 1)).collect();
        polygons.push((fixture::square(DVec3::ZERO, 4.0, true), 0));
        polygons.push((fixture::square(DVec3::new(0.2, 0.4, 0.5), 0.4, true), 0));
        for i in 0..30 {
            // No ray to one passes along an edge.
            let position_m = at(i) + DVec3::new(0.313, 0.177, 0.431);
            let kind = LampKind::Point { position_m, intensity: Rgb::splat(0.02), range_m: None };
            scene.lamps.push(Lamp { name: String::new(), kind });
        }
        let direction = DVec3::new(0.3, 0.2, -1.0).normalize();
        let kind = LampKind::Directional { direction, irradiance: Rgb::splat(0.1) };
        scene.lamps.push(Lamp { name: String::new(), kind });
        for (i, at_m) in [DVec3::new(0.4, 0.3, 0.0), DVec3::new(-2.9, 1.2, 0.0)].iter().enumerate() {
            for one in [false, true] {
                let [mean, exact, error] = mean_and_exact(&polygons, &scene, *at_m, one);
                assert!((mean - exact).abs() < 4.0 * error, "{i}, {one}: {mean} +- {error} is not {exact}");
                assert!(error < 0.02 * exact, "{i}, {one}: {error}");
            }
        }
    }
}
