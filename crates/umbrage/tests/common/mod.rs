//! An independent check of a baked mesh: it reads nothing but the triangles and their irradiance.
#![allow(
    dead_code,
    unreachable_pub,
    clippy::unwrap_used,
    reason = "shared by test binaries, each of which uses a part"
)]

pub mod build;

use std::collections::BTreeMap;
use std::f64::consts::TAU;

use glam::DVec3;
use umbrage::shade::BakedMesh;

/// A triangle with the irradiance at its corners.
#[derive(Clone, Copy, Debug)]
pub struct Lit {
    pub corners: [DVec3; 3],
    pub irradiance: [DVec3; 3],
}

impl Lit {
    pub fn doubled_area_vector(&self) -> DVec3 {
        (self.corners[1] - self.corners[0]).cross(self.corners[2] - self.corners[0])
    }

    pub fn area(&self) -> f64 {
        0.5 * self.doubled_area_vector().length()
    }

    pub fn normal(&self) -> DVec3 {
        self.doubled_area_vector().normalize_or_zero()
    }
}

/// The triangles of a baked mesh, in the world.
pub fn lit_triangles(mesh: &BakedMesh) -> Vec<Lit> {
    let point = |p: [f32; 3]| DVec3::from(p.map(f64::from));
    mesh.parts
        .iter()
        .flat_map(|part| {
            part.triangles.iter().map(move |corners| Lit {
                corners: corners.map(|i| mesh.origin_m + point(part.positions_m[i as usize])),
                irradiance: corners.map(|i| point(part.irradiance[i as usize])),
            })
        })
        .collect()
}

pub fn extent(triangles: &[Lit]) -> f64 {
    let points = || triangles.iter().flat_map(|t| t.corners);
    let (lo, hi) = (points().fold(DVec3::INFINITY, DVec3::min), points().fold(DVec3::NEG_INFINITY, DVec3::max));
    (hi - lo).max_element()
}

/// Pairs of a vertex and an edge of some triangle that it lies inside, where a crack could show: not where a thing
/// stands on a surface that goes on beneath it, and the two cover the same place, each without a gap.
pub fn t_vertices(triangles: &[Lit], eps: f64) -> Vec<(DVec3, [DVec3; 2])> {
    let mut points: Vec<DVec3> = triangles.iter().flat_map(|t| t.corners).collect();
    points.sort_by(|p, q| p.x.total_cmp(&q.x).then(p.y.total_cmp(&q.y)).then(p.z.total_cmp(&q.z)));
    points.dedup();
    let mut found = Vec::new();
    for triangle in triangles {
        for k in 0..3 {
            let (p, q) = (triangle.corners[k], triangle.corners[(k + 1) % 3]);
            let length = p.distance(q);
            let first = points.partition_point(|v| v.x < p.x.min(q.x) - eps);
            for &v in points[first..].iter().take_while(|v| v.x <= p.x.max(q.x) + eps) {
                let along = (v - p).dot(q - p) / length;
                let away = (v - p).cross(q - p).length() / length;
                if along > 2.0 * eps && length - along > 2.0 * eps && away < eps {
                    found.push((v, [p, q]));
                }
            }
        }
    }
    found.retain(|&(vertex, edge)| !(is_surrounded(triangles, vertex) && is_inside_a_plane(triangles, edge)));
    found
}

/// Whether coplanar triangles that look the same way surround a vertex.
fn is_surrounded(triangles: &[Lit], vertex: DVec3) -> bool {
    let fan: Vec<(DVec3, f64)> = triangles
        .iter()
        .filter_map(|triangle| {
            let k = triangle.corners.iter().position(|&corner| corner == vertex)?;
            let [next, previous] = [1, 2].map(|step| triangle.corners[(k + step) % 3] - vertex);
            Some((triangle.normal(), next.angle_between(previous)))
        })
        .collect();
    let turn =
        |normal: DVec3| fan.iter().filter(|(other, _)| other.dot(normal) > 0.9999).map(|(_, angle)| angle).sum::<f64>();
    fan.iter().any(|&(normal, _)| turn(normal) > TAU - 1e-3)
}

/// Whether coplanar triangles that look the same way meet in an edge.
fn is_inside_a_plane(triangles: &[Lit], [p, q]: [DVec3; 2]) -> bool {
    let sides: Vec<DVec3> = triangles
        .iter()
        .filter(|triangle| [p, q].iter().all(|end| triangle.corners.contains(end)))
        .map(Lit::normal)
        .collect();
    sides.iter().enumerate().any(|(i, side)| sides[i + 1..].iter().any(|other| side.dot(*other) > 0.9999))
}

/// Triangles without area: less than the square of `eps`.
pub fn degenerate(triangles: &[Lit], eps: f64) -> usize {
    triangles.iter().filter(|t| t.area() < eps * eps).count()
}

/// Edges between coplanar triangles, and those among them across which the irradiance jumps by over 0.5 % of the mean.
pub fn jumps(triangles: &[Lit]) -> (usize, usize) {
    let bits = |p: DVec3| p.to_array().map(f64::to_bits);
    let mean = triangles.iter().flat_map(|t| t.irradiance).map(|e| e.element_sum() / 3.0).sum::<f64>()
        / (3 * triangles.len()) as f64;
    let mut first = BTreeMap::new();
    let (mut inside, mut jumping) = (0, 0);
    for triangle in triangles {
        for k in 0..3 {
            let l = (k + 1) % 3;
            let (p, q) = (triangle.corners[k], triangle.corners[l]);
            let here = [triangle.irradiance[k], triangle.irradiance[l]];
            let normal = triangle.normal();
            match first.get(&(bits(q), bits(p))) {
                Some(&(there, other)) if normal.dot(other) > 0.9999 => {
                    let there: [DVec3; 2] = there;
                    inside += 1;
                    let jump = (here[0] - there[1]).abs().max((here[1] - there[0]).abs()).max_element();
                    jumping += usize::from(jump > 0.005 * mean);
                }
                _ => {
                    first.insert((bits(p), bits(q)), (here, normal));
                }
            }
        }
    }
    (inside, jumping)
}

/// Irradiance at a point from the triangle that it lies in, looking the same way; `None` where there is none.
pub fn irradiance_at(triangles: &[Lit], point: DVec3, normal: DVec3, eps: f64) -> Option<DVec3> {
    let weights = |t: &Lit| {
        let (n, doubled) = (t.normal(), t.doubled_area_vector().length());
        let [a, b, c] = t.corners;
        [(b, c), (c, a), (a, b)].map(|(p, q)| (p - point).cross(q - point).dot(n) / doubled)
    };
    triangles
        .iter()
        .filter(|t| t.normal().dot(normal) > 0.999 && (point - t.corners[0]).dot(t.normal()).abs() < eps)
        .map(|t| (weights(t), t))
        .max_by(|(p, _), (q, _)| {
            let least = |w: &[f64; 3]| w.iter().copied().fold(f64::INFINITY, f64::min);
            least(p).total_cmp(&least(q))
        })
        .filter(|(w, _)| w.iter().all(|&w| w > -1e-3))
        .map(|(w, t)| w.iter().zip(t.irradiance).map(|(w, e)| w.clamp(0.0, 1.0) * e).sum())
}

/// A row of a reference table: position, normal, irradiance.
pub struct Reference {
    pub position: DVec3,
    pub normal: DVec3,
    pub irradiance: DVec3,
}

/// Reads a table of `testdata/reference`.
pub fn reference(name: &str) -> Vec<Reference> {
    let path = format!("{}/../../testdata/reference/{name}.csv", env!("CARGO_MANIFEST_DIR"));
    let text = std::fs::read_to_string(&path).unwrap_or_else(|error| panic!("{path}: {error}"));
    text.lines()
        .skip(1)
        .map(|line| {
            let v: Vec<f64> = line.split(',').map(|field| field.parse().unwrap()).collect();
            Reference {
                position: DVec3::new(v[0], v[1], v[2]),
                normal: DVec3::new(v[3], v[4], v[5]),
                irradiance: DVec3::new(v[6], v[7], v[8]),
            }
        })
        .collect()
}

/// A bake shows a strip no wider than this share of the extent of area that is hidden, beside what is seen.
const RIM_OF_EXTENT: f64 = 1.5e-3;

/// Whether nothing is shown at some place beside a point, no farther away than a rim is wide.
pub fn ends_near(triangles: &[Lit], point: DVec3, normal: DVec3, extent: f64) -> bool {
    let (u, v) = normal.any_orthonormal_pair();
    (0..16).any(|i| {
        let (sine, cosine) = (f64::from(i) * TAU / 16.0).sin_cos();
        let beside = point + RIM_OF_EXTENT * extent * (cosine * u + sine * v);
        irradiance_at(triangles, beside, normal, 1e-4 * extent).is_none()
    })
}

/// Relative RMSE against a reference, and the most that a dark point of it shows, relative to the mean. What no light reaches
/// may be hidden and not be shown, and what is shown may go on in a rim into that.
pub fn error(mesh: &BakedMesh, reference: &[Reference]) -> (f64, f64) {
    let triangles = lit_triangles(mesh);
    let extent = extent(&triangles);
    let eps = 1e-4 * extent;
    let mean = reference.iter().map(|r| r.irradiance.element_sum() / 3.0).sum::<f64>() / reference.len() as f64;
    let (mut squares, mut covered, mut hidden, mut leak) = (0.0, 0, 0, 0.0_f64);
    for row in reference {
        let is_dark = row.irradiance == DVec3::ZERO;
        let got = irradiance_at(&triangles, row.position, row.normal, eps);
        let is_rim = || is_dark && ends_near(&triangles, row.position, row.normal, extent);
        let Some(got) = got.filter(|got| *got == DVec3::ZERO || !is_rim()) else {
            hidden += usize::from(is_dark);
            continue;
        };
        covered += 1;
        squares += (got - row.irradiance).length_squared() / 3.0;
        if is_dark {
            leak = leak.max(got.max_element() / mean);
        }
    }
    let known = covered + hidden;
    assert!(known * 200 >= reference.len() * 199, "{covered} of {} points are on the mesh", reference.len());
    // What is hidden is right: it counts with no error, as what is shown dark does.
    ((squares / known as f64).sqrt() / mean, leak)
}
