//! What is laid over polygons: texture coordinates and smooth normals, as affine functions of the position.
//!
//! A triangle says by its three corners what the coordinates are everywhere in its plane. So whatever polygons become
//! later, merged with neighbours, cut along shadows, split into triangles, each point of them still has exactly the
//! place in the image that it had, by evaluation. Polygons of one surface and plane share a *skin* where the functions
//! are the same; only then are they merged into one.
//!
//! Normals matter only where they make a surface smooth: along an edge between polygons of two planes that has the same
//! normals on both sides and bends by little. Elsewhere, as on the walls of a room that was shaded smooth by oversight,
//! they are left. A normal that is turned away from its polygon is left, too, and counted: there the polygon is flat.
//!
//! Skins grow from the largest polygons to their neighbours across edges; each neighbour is compared with the function
//! of the first, so that nothing drifts.

use glam::{DVec2, DVec3};
use smallvec::SmallVec;

use super::Facing;
use super::coplanar::Planes;
use super::soup::Polygon;
use super::weld::Points;
use crate::geometry::polygon::doubled_area_vector;
use crate::id::{PlaneId, SkinId, SurfaceId, Table, VertexId};
use crate::scene::{Scene, Surface};

/// Texture coordinates that differ by less are the same: 0.4 texels of an image 4096 wide, more than the rounding of
/// coordinates that files keep in 16 bits.
const SAME_UV: f64 = 1e-4;
/// A function of the position that gives a normal within this, in radians, gives it: the light of a smooth surface changes with its
/// normal, so this is what it may err at grazing incidence.
const SAME_NORMAL_RAD: f64 = 0.01;
/// A normal with a smaller cosine to the front of its polygon (it is turned away by more than 84 degrees) tells nothing of the
/// surface there.
const LEAST_FACING_COSINE: f64 = 0.1;
/// At a smooth edge, the normals of its two faces differ by less than this share of the bend. In a flat surface they
/// differ by all of it, in a smooth one by nothing but rounding.
const SMOOTH_OF_BEND: f64 = 0.5;
/// An edge that bends by more is a crease, whatever the normals say: the cosine of 61 degrees, so that a column of six
/// sides may be round.
const LEAST_SMOOTH_COSINE: f64 = 0.485;
/// Edges of more polygons than this are not looked at: nothing smooth has them.
const MOST_POLYGONS_OF_EDGE: usize = 8;

/// A number as an affine function of the position.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Affine {
    gradient: DVec3,
    offset: f64,
}

impl Affine {
    fn at(&self, at_m: DVec3) -> f64 {
        self.gradient.dot(at_m) + self.offset
    }
}

/// Texture coordinates and normals as functions of the position, relative to the prepared scene's origin.
#[derive(Clone, Debug, PartialEq)]
pub struct Skin {
    uv: Option<[Affine; 2]>,
    normal: Option<[Affine; 3]>,
    /// At corners the product of position and normal, in metres, where there are normals.
    support_m: Affine,
}

impl Skin {
    /// The texture coordinates at a point.
    pub fn uv(&self, at_m: DVec3) -> Option<DVec2> {
        self.uv.map(|uv| DVec2::from(uv.map(|affine| affine.at(at_m))))
    }

    /// The unit normal of the smooth surface at a point, on the side to which `front` points; `front` where there is
    /// none.
    pub fn normal(&self, at_m: DVec3, front: DVec3) -> DVec3 {
        let smooth = self.normal.map(|normal| DVec3::from(normal.map(|affine| affine.at(at_m))));
        let smooth = smooth.and_then(DVec3::try_normalize).unwrap_or(front);
        if smooth.dot(front) < 0.0 { -smooth } else { smooth }
    }

    /// How far the planes that touch the smooth surface at the corners lie over a point, each by the weight of its corner, in metres:
    /// towards the normals of the skin, below zero where they lie under it.
    pub(super) fn over_m(&self, at_m: DVec3) -> f64 {
        // The sum over corners c with weights w of w (c - x) . n, where w c sums to x and w n to the normal at x.
        self.normal.map_or(0.0, |normal| self.support_m.at(at_m) - at_m.dot(DVec3::from(normal.map(|n| n.at(at_m)))))
    }

    /// 1 where a vector at a point looks to the side of the normals of the skin, or else -1.
    pub(super) fn side_of(&self, vector: DVec3, at_m: DVec3) -> f64 {
        let normal = self.normal.map_or(vector, |normal| DVec3::from(normal.map(|affine| affine.at(at_m))));
        normal.dot(vector).signum()
    }

    /// Whether it has normals of a smooth surface.
    pub fn is_smooth(&self) -> bool {
        self.normal.is_some()
    }

    /// The functions that three corners of a polygon, as far apart as can be, say. `corners` are not in a line.
    fn of(corners: &Corners<'_>, smooth: bool) -> Self {
        let [a, b, c] = wide_corners(&corners.at_m);
        let [p, q, r] = [a, b, c].map(|i| corners.at_m[i]);
        let normal = (q - p).cross(r - p);
        let area_squared = normal.length_squared();
        let (along_q, along_r) = ((r - p).cross(normal) / area_squared, normal.cross(q - p) / area_squared);
        let affine = |value: &dyn Fn(usize) -> f64| {
            let gradient = (value(b) - value(a)) * along_q + (value(c) - value(a)) * along_r;
            Affine { gradient, offset: value(a) - gradient.dot(p) }
        };
        let uv = (!corners.uvs.is_empty()).then(|| [0, 1].map(|k| affine(&|i| corners.uvs[i][k])));
        let normal =
            (smooth && !corners.normals.is_empty()).then(|| [0, 1, 2].map(|k| affine(&|i| corners.normal(i)[k])));
        let support_m = affine(&|i| if smooth { corners.at_m[i].dot(corners.normal(i)) } else { 0.0 });
        Self { uv, normal, support_m }
    }

    /// Whether it says what the corners of a polygon say.
    fn fits(&self, corners: &Corners<'_>) -> bool {
        let is_same = |(i, &at_m): (usize, &DVec3)| {
            let uv = self.uv(at_m).is_none_or(|uv| uv.distance(corners.uvs[i]) <= SAME_UV);
            let normal = self.normal.map(|normal| DVec3::from(normal.map(|affine| affine.at(at_m))));
            uv && normal.is_none_or(|normal| normal.distance(corners.normal(i)) <= SAME_NORMAL_RAD)
        };
        corners.at_m.iter().enumerate().all(is_same)
    }
}

/// Three corners that are far from each other: the first, the farthest from it, and the farthest from the line of both.
fn wide_corners(at_m: &[DVec3]) -> [usize; 3] {
    let farthest = |distance: &dyn Fn(usize) -> f64| {
        let order = |&i: &usize, &j: &usize| distance(i).total_cmp(&distance(j)).then(j.cmp(&i));
        (0..at_m.len()).max_by(order).unwrap_or(0)
    };
    let b = farthest(&|i| at_m[i].distance_squared(at_m[0]));
    let c = farthest(&|i| (at_m[b] - at_m[0]).cross(at_m[i] - at_m[0]).length_squared());
    [0, b, c]
}

/// The corners of a polygon with what its surface says of them.
struct Corners<'a> {
    at_m: SmallVec<[DVec3; 4]>,
    uvs: SmallVec<[DVec2; 4]>,
    /// Unit normals towards the front; zero where there is none of use.
    normals: SmallVec<[DVec3; 4]>,
    /// Unit normal of the polygon.
    front: DVec3,
    /// Normals that are turned away from the front.
    unusable: usize,
    surface: &'a Surface,
}

impl<'a> Corners<'a> {
    fn of(polygon: &Polygon, surface: &'a Surface, points: &Points) -> Self {
        let source = || polygon.sources.iter().map(|&i| i as usize);
        let uvs = if surface.uvs.is_empty() { SmallVec::new() } else { source().map(|i| surface.uvs[i]).collect() };
        let mut normals: SmallVec<[DVec3; 4]> =
            if surface.normals.is_empty() { SmallVec::new() } else { source().map(|i| surface.normals[i]).collect() };
        let at_m: SmallVec<[DVec3; 4]> = polygon.corners.iter().map(|&v| points[v]).collect();
        let front = doubled_area_vector(&at_m).normalize_or_zero();
        // Files do not agree on the normals of polygons that look the other way.
        let sign = if normals.iter().sum::<DVec3>().dot(front) < 0.0 { -1.0 } else { 1.0 };
        let mut unusable = 0;
        for normal in normals.iter_mut().filter(|normal| **normal != DVec3::ZERO) {
            *normal = (sign * *normal).normalize_or_zero();
            if normal.dot(front) < LEAST_FACING_COSINE {
                *normal = DVec3::ZERO;
                unusable += 1;
            }
        }
        Self { at_m, uvs, normals, front, unusable, surface }
    }

    /// The normal at a corner: the polygon's own where there is none of use.
    fn normal(&self, corner: usize) -> DVec3 {
        self.normals.get(corner).copied().filter(|normal| *normal != DVec3::ZERO).unwrap_or(self.front)
    }

    fn is_bare(&self) -> bool {
        self.surface.uvs.is_empty() && self.surface.normals.is_empty()
    }
}

/// Whether what a surface says of a polygon's corners is one affine function, as it always is for a triangle.
pub(super) fn is_affine(polygon: &Polygon, surface: &Surface, points: &Points) -> bool {
    let corners = Corners::of(polygon, surface, points);
    polygon.corners.len() <= 3 || corners.is_bare() || Skin::of(&corners, true).fits(&corners)
}

/// The skins of a scene, and that of each polygon.
#[derive(Debug, Default)]
pub(super) struct Skins {
    pub(super) all: Table<SkinId, Skin>,
    pub(super) of_polygon: Vec<Option<SkinId>>,
    /// Corners of smooth polygons whose normals are turned away from the front: there the polygon's own counts.
    pub(super) unusable_normals: usize,
}

impl Skins {
    /// Finds the skins; `smooth` says whether normals count.
    pub(super) fn new(scene: &Scene, soup: &[Polygon], planes: &Planes, points: &Points, smooth: bool) -> Self {
        let corners: Vec<Corners<'_>> =
            soup.iter().map(|polygon| Corners::of(polygon, &scene.surfaces[polygon.surface], points)).collect();
        let mut skins = Self { all: Table::new(), of_polygon: vec![None; soup.len()], unusable_normals: 0 };
        if corners.iter().all(Corners::is_bare) {
            return skins;
        }
        let neighbours = Neighbours::new(soup, &corners);
        let is_smooth = if smooth { neighbours.smooth(&corners, planes) } else { vec![false; soup.len()] };
        skins.unusable_normals = corners.iter().zip(&is_smooth).filter(|(_, is)| **is).map(|(c, _)| c.unusable).sum();
        let mut largest_first: Vec<usize> = (0..soup.len()).filter(|&p| !corners[p].is_bare()).collect();
        largest_first.sort_by(|&p, &q| soup[q].area_m2.total_cmp(&soup[p].area_m2).then(p.cmp(&q)));
        let kind = |p: usize| -> (PlaneId, Facing, SurfaceId, bool) {
            (planes.of_polygon[p].0, planes.of_polygon[p].1, soup[p].surface, is_smooth[p])
        };
        let mut open = Vec::new();
        for seed in largest_first {
            let has_any = is_smooth[seed] || !corners[seed].uvs.is_empty();
            if skins.of_polygon[seed].is_some() || !has_any {
                continue;
            }
            let id = skins.all.push_and_get_key(Skin::of(&corners[seed], is_smooth[seed]));
            skins.of_polygon[seed] = Some(id);
            open.push(seed);
            while let Some(p) = open.pop() {
                for &Neighbour { polygon: q, .. } in &neighbours.of_polygon[p] {
                    if skins.of_polygon[q].is_none() && kind(q) == kind(seed) && skins.all[id].fits(&corners[q]) {
                        skins.of_polygon[q] = Some(id);
                        open.push(q);
                    }
                }
            }
        }
        skins
    }
}

/// A polygon beyond a common edge, which both pass in opposite directions.
#[derive(Clone, Copy, Debug)]
struct Neighbour {
    polygon: usize,
    /// Which corners of this polygon the edge's ends are.
    here: [usize; 2],
    /// And of the other polygon, in the same order.
    there: [usize; 2],
}

struct Neighbours {
    of_polygon: Vec<SmallVec<[Neighbour; 4]>>,
}

/// A side of a polygon: its ends ascending, the polygon, and the number of the side.
type NumberedSide = ([VertexId; 2], usize, usize);

impl Neighbours {
    /// Of all polygons on which something is laid.
    fn new(soup: &[Polygon], corners: &[Corners<'_>]) -> Self {
        let mut sides: Vec<NumberedSide> = Vec::new();
        for (p, polygon) in soup.iter().enumerate().filter(|&(p, _)| !corners[p].is_bare()) {
            sides.extend(polygon.sides().enumerate().map(|(i, [a, b])| ([a.min(b), a.max(b)], p, i)));
        }
        sides.sort_unstable();
        let mut of_polygon = vec![SmallVec::new(); soup.len()];
        for run in sides.chunk_by(|x, y| x.0 == y.0).filter(|run| run.len() <= MOST_POLYGONS_OF_EDGE) {
            for &(_, p, i) in run {
                for &(_, q, j) in run {
                    let next = |p: usize, i: usize| (i + 1) % soup[p].corners.len();
                    let opposite = soup[p].corners[i] == soup[q].corners[next(q, j)];
                    if p != q && opposite {
                        let (here, there) = ([i, next(p, i)], [next(q, j), j]);
                        of_polygon[p].push(Neighbour { polygon: q, here, there });
                    }
                }
            }
        }
        Self { of_polygon }
    }

    /// Which polygons have a smooth edge.
    fn smooth(&self, corners: &[Corners<'_>], planes: &Planes) -> Vec<bool> {
        let front = |p: usize| {
            let (plane, facing) = planes.of_polygon[p];
            let normal = planes.frames[plane].plane.normal;
            if facing == Facing::Along { normal } else { -normal }
        };
        let is_smooth = |p: usize, neighbour: &Neighbour| {
            let &Neighbour { polygon: q, here, there } = neighbour;
            planes.of_polygon[p].0 != planes.of_polygon[q].0
                && !corners[p].normals.is_empty()
                && !corners[q].normals.is_empty()
                && here
                    .iter()
                    .zip(there)
                    .all(|(&i, j)| is_smooth_at([front(p), front(q)], [corners[p].normals[i], corners[q].normals[j]]))
        };
        (0..corners.len()).map(|p| self.of_polygon[p].iter().any(|neighbour| is_smooth(p, neighbour))).collect()
    }
}

/// Whether the edge between two faces is smooth at a point, where their corners have these normals.
fn is_smooth_at(fronts: [DVec3; 2], normals: [DVec3; 2]) -> bool {
    let [one, other] = fronts;
    one.dot(other) >= LEAST_SMOOTH_COSINE
        && !normals.contains(&DVec3::ZERO)
        && normals[0].distance(normals[1]) <= SMOOTH_OF_BEND * one.distance(other)
}

/// Whether two faces of smooth surfaces, with these fronts, are one surface at a point of their common edge, where they have these
/// normals: then both receive the same light there. Facets of one plane are, if their normals are the same.
pub(crate) fn is_one_surface_at(fronts: [DVec3; 2], normals: [DVec3; 2]) -> bool {
    let bend = fronts[0].distance(fronts[1]).max(2.0 * SAME_NORMAL_RAD / SMOOTH_OF_BEND);
    fronts[0].dot(fronts[1]) >= LEAST_SMOOTH_COSINE && normals[0].distance(normals[1]) <= SMOOTH_OF_BEND * bend
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::id::{MaterialId, NodeId};

    #[test]
    fn an_affine_function_is_found_from_the_corners_of_a_polygon() {
        let surface = Surface::new(NodeId::from(0), MaterialId::from(0));
        let at_m: Vec<DVec3> =
            [(3.0, 1.0), (7.0, 2.0), (6.0, 5.0), (2.0, 4.0)].map(|(x, y)| DVec3::new(x, y, 0.5 * x + 2.0)).to_vec();
        let uv_at = |p: DVec3| DVec2::new(2.0 * p.x - 3.0 * p.y + 0.25, 0.5 * p.y + 7.0);
        let corners = Corners {
            at_m: at_m.iter().copied().collect(),
            uvs: at_m.iter().map(|&p| uv_at(p)).collect(),
            normals: SmallVec::new(),
            front: DVec3::Z,
            unusable: 0,
            surface: &surface,
        };
        let skin = Skin::of(&corners, true);
        assert!(skin.fits(&corners) && !skin.is_smooth());
        let middle = (at_m[0] + at_m[1] + at_m[2]) / 3.0;
        assert!(skin.uv(middle).unwrap().distance(uv_at(middle)) < 1e-12);
        let mut bent = corners;
        bent.uvs[3].x += 0.01;
        assert!(!Skin::of(&bent, true).fits(&bent), "four corners that no affine function fits");
    }

    #[test]
    fn an_edge_is_smooth_where_its_faces_agree_on_the_normal() {
        let normal = |angle: f64| DVec3::new(angle.sin(), 0.0, angle.cos());
        let fronts = |bend: f64| [normal(0.0), normal(bend)];
        for bend in [0.008, 0.3, 1.0] {
            assert!(is_smooth_at(fronts(bend), [normal(0.5 * bend); 2]), "smooth: {bend}");
            assert!(!is_smooth_at(fronts(bend), fronts(bend)), "flat: {bend}");
        }
        assert!(!is_smooth_at(fronts(1.2), [normal(0.6); 2]), "a crease, whatever the normals say");
        assert!(!is_smooth_at(fronts(0.3), [DVec3::ZERO; 2]), "no normals at all");
    }

    #[test]
    fn a_normal_looks_to_the_front() {
        let affine = |x: f64| Affine { gradient: DVec3::ZERO, offset: x };
        let skin = Skin { uv: None, normal: Some([affine(0.0), affine(0.6), affine(0.9)]), support_m: affine(0.0) };
        let front = skin.normal(DVec3::ZERO, DVec3::Z);
        assert!((front.length() - 1.0).abs() < 1e-12 && front.z > 0.0);
        assert_eq!(skin.normal(DVec3::ZERO, DVec3::NEG_Z), -front);
        assert_eq!(Skin { uv: None, normal: None, support_m: affine(0.0) }.normal(DVec3::ZERO, DVec3::X), DVec3::X);
    }
}
