//! Events of occluders alone: told by their generators.
//!
//! Seen from the eye, three edges pass through one point (EEE), or an edge of one occluder passes a vertex of another,
//! before an emitter. Both are found by a change of sign over a short step of the eye, and count where the point and an
//! emitter there can be seen.

use glam::DVec3;

use super::light::{Convex, World};

/// Edges end where they end; the eye's step moves what it sees by less than this share of an edge.
const SLACK: f64 = 1e-3;
/// A ray that passes inside a polygon by less than this, in metres, may pass beside it after a short step of the eye,
/// which shadows magnify.
const MARGIN_M: f64 = 3e-3;

struct Edge {
    ends: [DVec3; 2],
    lit: bool,
}

impl Edge {
    /// Normal of the plane through the edge and the eye.
    fn plane(&self, eye: DVec3) -> DVec3 {
        (self.ends[0] - eye).cross(self.ends[1] - eye)
    }

    fn meets(&self, other: &Self) -> bool {
        self.ends.iter().any(|end| other.ends.contains(end))
    }

    /// How far along a ray, in its length, the edge is passed.
    fn passed_at(&self, eye: DVec3, ray: DVec3) -> Option<f64> {
        let (along, from) = (self.ends[1] - self.ends[0], self.ends[0] - eye);
        let across = ray.cross(along);
        let share = from.cross(ray).dot(across) / across.length_squared();
        let distance = from.cross(along).dot(across) / across.length_squared();
        (distance > 0.0 && (-SLACK..=1.0 + SLACK).contains(&share)).then_some(distance)
    }
}

/// The edges of all polygons, since a light hides what is behind it; and the lines in which polygons pierce one
/// another, whose ends are vertices as good as any.
fn edges(world: &World) -> Vec<Edge> {
    let mut edges: Vec<Edge> = Vec::new();
    for piece in &world.pieces {
        for (i, &from) in piece.corners.iter().enumerate() {
            let ends = [from, piece.corners[(i + 1) % piece.corners.len()]];
            if !edges.iter().any(|edge| edge.ends == ends || edge.ends == [ends[1], ends[0]]) {
                edges.push(Edge { ends, lit: piece.radiance > 0.0 });
            }
        }
    }
    for (i, one) in world.pieces.iter().enumerate() {
        for other in &world.pieces[i + 1..] {
            if let Some(ends) = common_line(one, other) {
                edges.push(Edge { ends, lit: one.radiance > 0.0 || other.radiance > 0.0 });
            }
        }
    }
    edges
}

/// The line in which two polygons pierce one another.
fn common_line(one: &Convex, other: &Convex) -> Option<[DVec3; 2]> {
    let normal = |c: &[DVec3]| (c[1] - c[0]).cross(c[2] - c[0]).normalize();
    let crossings = |of: &Convex, through: &Convex| -> Vec<DVec3> {
        let (n, c) = (normal(&through.corners), &of.corners);
        let height = |p: DVec3| n.dot(p - through.corners[0]);
        let crossing = |i: usize| {
            let (p, q) = (c[i], c[(i + 1) % c.len()]);
            (height(p) * height(q) < 0.0).then(|| p.lerp(q, height(p) / (height(p) - height(q))))
        };
        (0..c.len()).filter_map(crossing).collect()
    };
    let along = normal(&one.corners).cross(normal(&other.corners)).normalize_or_zero();
    let (mut of_one, mut of_other) = (crossings(one, other), crossings(other, one));
    if of_one.len() != 2 || of_other.len() != 2 {
        return None;
    }
    let by_place = |p: &DVec3, q: &DVec3| along.dot(*p).total_cmp(&along.dot(*q));
    of_one.sort_by(by_place);
    of_other.sort_by(by_place);
    let later = |p: DVec3, q: DVec3| if along.dot(p) > along.dot(q) { p } else { q };
    let (from, to) = (
        later(of_one[0], of_other[0]),
        if along.dot(of_one[1]) < along.dot(of_other[1]) { of_one[1] } else { of_other[1] },
    );
    (along.dot(to - from) > 1e-6).then_some([from, to])
}

/// Where a ray meets a polygon, in its length, farther than `margin_m` inside.
fn hit(piece: &Convex, eye: DVec3, ray: DVec3, margin_m: f64) -> Option<f64> {
    let c = &piece.corners;
    let normal = (c[1] - c[0]).cross(c[2] - c[0]).normalize();
    let t = normal.dot(c[0] - eye) / normal.dot(ray);
    let at = eye + t * ray;
    let inside = (0..c.len()).all(|i| {
        let side = (c[(i + 1) % c.len()] - c[i]).normalize();
        normal.cross(side).dot(at - c[i]) > margin_m
    });
    (t.is_finite() && t > 1e-9 && inside).then_some(t)
}

/// Whether nothing stands on a ray before `until`.
fn is_open(world: &World, eye: DVec3, ray: DVec3, until: f64) -> bool {
    let stops = |piece: &Convex| hit(piece, eye, ray, MARGIN_M).is_some_and(|t| t < until * (1.0 - SLACK));
    !world.pieces.iter().any(stops)
}

/// Whether a ray sees an emitter behind all that it passes.
fn sees_light(world: &World, eye: DVec3, ray: DVec3, behind: f64) -> bool {
    world
        .pieces
        .iter()
        .filter(|piece| piece.radiance > 0.0)
        .any(|piece| hit(piece, eye, ray, -MARGIN_M).is_some_and(|t| t > behind && is_open(world, eye, ray, t)))
}

/// Rays through two edges in one plane that are followed.
const RAYS: u32 = 17;
/// Edges whose directions have a smaller sine are parallel: corners are rounded to 2e-6 m.
const PARALLEL_SINE: f64 = 1e-4;

/// Whether the eye passes the plane of two parallel edges of occluders between two places, where light is seen past
/// both.
pub fn is_owed_to_two_edges_in_a_plane(world: &World, from: DVec3, to: DVec3) -> bool {
    let dark: Vec<Edge> = edges(world).into_iter().filter(|edge| !edge.lit).collect();
    let eye = from.midpoint(to);
    let along = |edge: &Edge| (edge.ends[1] - edge.ends[0]).normalize_or_zero();
    dark.iter().enumerate().any(|(i, one)| {
        let parallel = |other: &&Edge| along(one).cross(along(other)).length() < PARALLEL_SINE && !one.meets(other);
        dark[i + 1..].iter().filter(parallel).any(|other| {
            let side = |eye: DVec3| one.plane(eye).dot(other.ends[0] - eye);
            let ray = |k: u32| other.ends[0].lerp(other.ends[1], (f64::from(k) + 0.5) / f64::from(RAYS)) - eye;
            side(from) * side(to) <= 0.0
                && (0..RAYS)
                    .map(ray)
                    .any(|ray| one.passed_at(eye, ray).is_some_and(|at| sees_light(world, eye, ray, at.max(1.0))))
        })
    })
}

/// Whether an event of occluders alone happens between two places of the eye: a vertex of one and an edge of another,
/// or three edges of which the farthest is not a source's.
pub fn is_owed_to_occluders(world: &World, from: DVec3, to: DVec3) -> bool {
    let edges = edges(world);
    let eye = from.midpoint(to);
    let changes = |f: &dyn Fn(DVec3) -> f64| f(from) * f(to) <= 0.0;
    for (i, one) in edges.iter().enumerate() {
        let other_dark = edges.iter().filter(|edge| !edge.lit && !one.lit).flat_map(|edge| edge.ends);
        for vertex in other_dark.filter(|vertex| !one.ends.contains(vertex)) {
            let ray = vertex - eye;
            if changes(&|eye| one.plane(eye).dot(vertex - eye))
                && one.passed_at(eye, ray).is_some_and(|at| sees_light(world, eye, ray, at.max(1.0)))
            {
                return true;
            }
        }
        for (j, other) in edges.iter().enumerate().skip(i + 1).filter(|(_, other)| !one.meets(other)) {
            let ray = one.plane(eye).cross(other.plane(eye)).normalize_or_zero();
            let both = |ray: DVec3| Some((ray, [one.passed_at(eye, ray)?, other.passed_at(eye, ray)?]));
            let Some((ray, at)) = both(ray).or_else(|| both(-ray)) else { continue };
            for third in edges[j + 1..].iter().filter(|third| !one.meets(third) && !other.meets(third)) {
                let Some(at_third) = third.passed_at(eye, ray) else { continue };
                let farthest = at[0].max(at[1]).max(at_third);
                let behind_a_source = [(one, at[0]), (other, at[1]), (third, at_third)]
                    .iter()
                    .any(|(edge, at)| edge.lit && *at == farthest);
                if !behind_a_source
                    && changes(&|eye| one.plane(eye).cross(other.plane(eye)).dot(third.plane(eye)))
                    && sees_light(world, eye, ray, farthest)
                {
                    return true;
                }
            }
        }
    }
    false
}
