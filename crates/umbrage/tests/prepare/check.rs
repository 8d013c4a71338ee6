//! Brute-force checks of what `prepare` promises, quadratic and independent of how it works.

use glam::DVec3;
use umbrage::geometry::polygon;
use umbrage::id::{FaceId, SurfaceId};
use umbrage::prepare::{Facing, Prepared, prepare};
use umbrage::progress::Progress;
use umbrage::scene::Scene;

/// Edges nearer than this share of the extent overlap or cross.
const NEAR_OF_EXTENT: f64 = 1e-6;
/// Cosine of the angle within which polygons are coplanar: the Cornell box has walls that bend by 0.47 degrees.
const STRAIGHT: f64 = 1.0 - 1e-7;
/// How far beside a border is looked, as a share of the extent.
const BESIDE_OF_EXTENT: f64 = 1e-4;

/// Prepares a scene and checks all promises; `overlap_m2` is the area where polygons overlap.
pub(crate) fn prepared(scene: &Scene, overlap_m2: f64) -> Prepared {
    let result = prepare(scene, Progress::silent()).unwrap();
    check(scene, &result, overlap_m2).unwrap();
    result
}

pub(crate) fn check(scene: &Scene, p: &Prepared, overlap_m2: f64) -> Result<(), String> {
    check_topology(p)?;
    area_is_conserved(scene, p, overlap_m2)?;
    borders_are_true(scene, p)
}

/// Everything that holds even where polygons cross and cover each other.
pub(crate) fn check_topology(p: &Prepared) -> Result<(), String> {
    p.validate().map_err(|e| e.to_string())?;
    if p.report.dropped_cuts != 0 {
        return Err(format!("{} cuts dropped", p.report.dropped_cuts));
    }
    edges_meet_in_ends_only(p)?;
    edges_and_faces_know_each_other(p)?;
    faces_do_not_overlap(p)
}

fn polygons(scene: &Scene) -> impl Iterator<Item = (SurfaceId, Vec<DVec3>)> + '_ {
    scene
        .surfaces
        .iter_enumerated()
        .flat_map(move |(id, s)| (0..s.polygons.len()).map(move |n| (id, scene.corners_m(id, n).collect())))
}

pub(crate) fn face_area_m2(p: &Prepared, face: FaceId) -> f64 {
    polygon::area_m2(&p.polygon_m(face))
}

fn area_is_conserved(scene: &Scene, p: &Prepared, overlap_m2: f64) -> Result<(), String> {
    let sides = |s: SurfaceId| if scene.materials[scene.surfaces[s].material].double_sided { 2.0 } else { 1.0 };
    let given: f64 =
        polygons(scene).map(|(s, corners)| sides(s) * polygon::area_m2(&corners)).sum::<f64>() - overlap_m2;
    let made: f64 = p.faces.keys().map(|f| face_area_m2(p, f)).sum();
    if (made - given).abs() <= 1e-5 * given { Ok(()) } else { Err(format!("area {made} of {given}")) }
}

/// Distance of two segments, by the ends and by the foot of the common perpendicular.
fn distance_m([a, b]: [DVec3; 2], [c, d]: [DVec3; 2]) -> f64 {
    let ends = [to_segment_m(a, c, d), to_segment_m(b, c, d), to_segment_m(c, a, b), to_segment_m(d, a, b)];
    let least = ends.into_iter().fold(f64::INFINITY, f64::min);
    let normal = (b - a).cross(d - c);
    if normal.length() < 1e-12 * (b - a).length() * (d - c).length() {
        return least;
    }
    let side = |from: DVec3, to: DVec3, x: DVec3| normal.cross(to - from).dot(x - from);
    let crosses = side(a, b, c) * side(a, b, d) < 0.0 && side(c, d, a) * side(c, d, b) < 0.0;
    if crosses { least.min((c - a).dot(normal.normalize()).abs()) } else { least }
}

fn to_segment_m(p: DVec3, a: DVec3, b: DVec3) -> f64 {
    let t = ((p - a).dot(b - a) / (b - a).length_squared()).clamp(0.0, 1.0);
    p.distance(a.lerp(b, t))
}

fn edges_meet_in_ends_only(p: &Prepared) -> Result<(), String> {
    let near_m = NEAR_OF_EXTENT * p.tolerance.extent_m;
    let edges: Vec<_> = p.edges.iter().map(|e| (e.ends, e.ends.map(|v| p.vertices_m[v]))).collect();
    for (i, (ends, at)) in edges.iter().enumerate() {
        if ends[0] >= ends[1] {
            return Err(format!("edge {ends:?} is not ascending"));
        }
        for (other_ends, other) in &edges[..i] {
            let meets = match ends.iter().filter(|v| other_ends.contains(v)).count() {
                0 => distance_m(*at, *other) < near_m,
                1 => {
                    let inside = |from: &[_; 2], at: [DVec3; 2], to: &[_; 2], others: [DVec3; 2]| {
                        (0..2).any(|k| !to.contains(&from[k]) && to_segment_m(at[k], others[0], others[1]) < near_m)
                    };
                    inside(ends, *at, other_ends, *other) || inside(other_ends, *other, ends, *at)
                }
                _ => true,
            };
            if meets {
                return Err(format!("edges {at:?} and {other:?} meet not only in an end"));
            }
        }
    }
    Ok(())
}

fn edges_and_faces_know_each_other(p: &Prepared) -> Result<(), String> {
    for (id, edge) in p.edges.iter_enumerated() {
        let using: Vec<FaceId> = p
            .faces
            .iter_enumerated()
            .filter(|(_, f)| f.sides.iter().flatten().any(|e| e.edge == id))
            .map(|(f, _)| f)
            .collect();
        if using.is_empty() || using != edge.faces.to_vec() {
            return Err(format!("{id:?} lists {:?}, but is used by {using:?}", edge.faces));
        }
    }
    Ok(())
}

/// Where one face only lies beside an edge, of all that lie in its plane and look its way, no polygon goes on.
fn borders_are_true(scene: &Scene, p: &Prepared) -> Result<(), String> {
    let beside_m = BESIDE_OF_EXTENT * p.tolerance.extent_m;
    for (id, face) in p.faces.iter_enumerated() {
        let is_mate = |&other: &FaceId| p.faces[other].plane == face.plane && p.faces[other].facing == face.facing;
        for edge in face.sides.iter().flatten() {
            if p.edges[edge.edge].faces.iter().copied().filter(is_mate).count() > 1 {
                continue;
            }
            let [a, b] = [p.start(*edge), p.end(*edge)].map(|v| p.vertices_m[v]);
            if a.distance(b) < 4.0 * beside_m {
                continue;
            }
            let outside = 0.5 * (a + b) + beside_m * (b - a).cross(p.normal(id)).normalize() + p.origin_m;
            let goes_on = polygons(scene).any(|(s, corners)| {
                let both = scene.materials[scene.surfaces[s].material].double_sided;
                covers(&corners, outside, p.normal(id), both, p.tolerance.extent_m)
            });
            if goes_on {
                return Err(format!("{id:?} ends at {a} {b}, but a polygon goes on at {outside}"));
            }
        }
    }
    Ok(())
}

/// Whether a polygon that looks along `normal` (or any way, where it has both) covers a point, by winding angle.
fn covers(corners: &[DVec3], at: DVec3, normal: DVec3, both: bool, extent_m: f64) -> bool {
    let own = polygon::doubled_area_vector(corners).normalize_or_zero();
    let along = own.dot(normal);
    if (if both { along.abs() } else { along }) < STRAIGHT || own.dot(at - corners[0]).abs() > 3e-6 * extent_m {
        return false;
    }
    let n = corners.len();
    let angle: f64 = (0..n)
        .map(|i| (corners[i] - at, corners[(i + 1) % n] - at))
        .map(|(u, v)| u.cross(v).dot(own).atan2(u.dot(v)))
        .sum();
    angle.abs() > 3.0
}

/// The centre of each face lies on no other face that looks the same way.
fn faces_do_not_overlap(p: &Prepared) -> Result<(), String> {
    let all: Vec<_> = p.faces.keys().map(|f| p.polygon_m(f)).collect();
    for (id, corners) in p.faces.keys().zip(&all) {
        // The normal of a sliver's own corners is no measure.
        if polygon::area_m2(corners) < BESIDE_OF_EXTENT * p.tolerance.extent_m * polygon::perimeter_m(corners) {
            continue;
        }
        let centre = polygon::centroid(corners);
        let covering = all.iter().filter(|c| covers(c, centre, p.normal(id), false, p.tolerance.extent_m)).count();
        if covering != 1 {
            return Err(format!("{covering} faces cover the centre of {id:?}"));
        }
    }
    Ok(())
}

/// Faces of a surface that look along `normal` in the plane through a point of the world.
pub(crate) fn faces_at(p: &Prepared, surface: usize, normal: [f64; 3], through: [f64; 3]) -> Vec<FaceId> {
    let (normal, through) = (DVec3::from(normal), DVec3::from(through) - p.origin_m);
    let lies = |f: &FaceId| {
        p.faces[*f].surface.index() == surface
            && p.normal(*f).dot(normal) > 0.999_999
            && p.oriented_plane(*f).signed_distance_m(through).abs() < 1e-5 * p.tolerance.extent_m
    };
    p.faces.keys().filter(lies).collect()
}

/// Faces whose polygon covers a point of the world and look along `normal`.
pub(crate) fn face_under(p: &Prepared, normal: [f64; 3], at: [f64; 3]) -> Option<FaceId> {
    let (normal, at) = (DVec3::from(normal), DVec3::from(at) - p.origin_m);
    p.faces.keys().find(|&f| covers(&p.polygon_m(f), at, normal, false, p.tolerance.extent_m))
}

/// Length of the edges that lie between two points of the world.
pub(crate) fn length_along_m(p: &Prepared, from: [f64; 3], to: [f64; 3]) -> f64 {
    let [a, b] = [from, to].map(|x| DVec3::from(x) - p.origin_m);
    let near_m = 3e-6 * p.tolerance.extent_m;
    let on = |v: DVec3| to_segment_m(v, a, b) < near_m;
    p.edges
        .iter()
        .map(|e| e.ends.map(|v| p.vertices_m[v]))
        .filter(|[s, t]| on(*s) && on(*t))
        .map(|[s, t]| s.distance(t))
        .sum()
}

/// How many faces look along and against their plane's normal.
pub(crate) fn facings(p: &Prepared) -> [usize; 2] {
    [Facing::Along, Facing::Against].map(|f| p.faces.iter().filter(|face| face.facing == f).count())
}
