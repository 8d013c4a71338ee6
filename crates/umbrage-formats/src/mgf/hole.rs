//! A face with holes as one polygon: each hole is joined to the outline by a seam that is passed both ways.
//!
//! ```text
//!   +---------------+        The seam runs from the hole's rightmost corner to a corner of the outline that it sees,
//!   |    +----+     |        so that it crosses nothing: to the right, to the first side met, and from there to the
//!   |    |hole|=====+        nearer end of that side, or to a corner that stands in the way.
//!   |    +----+     |
//!   +---------------+
//! ```
//! Holes may run either way around; they are turned against the outline. The result is weakly simple, and its area is
//! the outline's less the holes'.
//!
//! Source: D. Eberly, *Triangulation by Ear Clipping*, 2002, section 3.

use glam::{DVec2, DVec3};

/// Joins the first loop, the outline, with the others, its holes. Loops have three or more corners.
pub(super) fn bridged(loops: &[Vec<DVec3>]) -> Vec<DVec3> {
    let Some((outline, holes)) = loops.split_first() else { return Vec::new() };
    let normal = doubled_area(outline);
    let axis = normal.abs().max_position();
    // The plane that shows most of the outline, in which it runs counter-clockwise.
    let flat = |p: DVec3| {
        let (u, v) = ((axis + 1) % 3, (axis + 2) % 3);
        if normal[axis] < 0.0 { DVec2::new(p[v], p[u]) } else { DVec2::new(p[u], p[v]) }
    };
    let mut ring: Vec<Corner> = outline.iter().map(|&p| Corner { flat: flat(p), position: p }).collect();
    let mut holes: Vec<Vec<Corner>> = holes.iter().map(|hole| clockwise(hole, normal, flat)).collect();
    // From the right to the left, so that a seam never has to pass a hole that is not joined yet.
    holes.sort_by(|a, b| b[0].flat.x.total_cmp(&a[0].flat.x));
    for hole in holes {
        join(&mut ring, &hole);
    }
    ring.into_iter().map(|corner| corner.position).collect()
}

/// What looking for seams costs, in corners that are looked at.
pub(super) fn cost(loops: &[Vec<DVec3>]) -> u64 {
    let corners: usize = loops.iter().map(Vec::len).sum();
    (loops.len() as u64).saturating_mul(corners as u64)
}

#[derive(Clone, Copy, Debug)]
struct Corner {
    flat: DVec2,
    position: DVec3,
}

fn doubled_area(corners: &[DVec3]) -> DVec3 {
    let first = corners.first().copied().unwrap_or_default();
    corners.windows(2).map(|side| (side[0] - first).cross(side[1] - first)).sum()
}

/// A hole that runs against the outline, its rightmost corner first.
fn clockwise(hole: &[DVec3], normal: DVec3, flat: impl Fn(DVec3) -> DVec2) -> Vec<Corner> {
    let mut hole_corners: Vec<Corner> = hole.iter().map(|&p| Corner { flat: flat(p), position: p }).collect();
    if doubled_area(hole).dot(normal) > 0.0 {
        hole_corners.reverse();
    }
    let rightmost = (0..hole_corners.len()).max_by(|&a, &b| hole_corners[a].flat.x.total_cmp(&hole_corners[b].flat.x));
    hole_corners.rotate_left(rightmost.unwrap_or(0));
    hole_corners
}

/// Puts a hole, rightmost corner first, and its seam into the ring.
fn join(ring: &mut Vec<Corner>, hole: &[Corner]) {
    let at = seen_from(ring, hole[0].flat);
    let seam = hole.iter().copied().chain([hole[0], ring[at]]);
    let seam: Vec<Corner> = seam.collect();
    ring.splice(at + 1..at + 1, seam);
}

/// The ring's corner to which a seam from `m` leads; the nearest one if `m` is not inside.
fn seen_from(ring: &[Corner], m: DVec2) -> usize {
    let n = ring.len();
    let p = |i: usize| ring[i % n].flat;
    // Sides that bound the inside to the right run upwards.
    let side = (0..n)
        .filter(|&i| p(i).y <= m.y && m.y <= p(i + 1).y && p(i).y < p(i + 1).y)
        .map(|i| (i, p(i).x + (m.y - p(i).y) / (p(i + 1).y - p(i).y) * (p(i + 1).x - p(i).x)))
        .filter(|&(_, x)| x >= m.x)
        .min_by(|a, b| a.1.total_cmp(&b.1));
    let Some((i, x)) = side else {
        let nearest = (0..n).min_by(|&a, &b| p(a).distance_squared(m).total_cmp(&p(b).distance_squared(m)));
        return nearest.unwrap_or(0);
    };
    let hit = DVec2::new(x, m.y);
    let end = if p(i).x > p(i + 1).x { i } else { (i + 1) % n };
    let triangle = [m, hit, p(end)];
    let angle = |q: DVec2| (q.y - m.y).abs() / (q.x - m.x);
    // Corners that stand in the way: of those, the one seen at the least angle is seen.
    let in_the_way = (0..n)
        .filter(|&j| p(j) != p(end) && p(j).x > m.x && inside(triangle, p(j)) && opens_towards(ring, j, m))
        .min_by(|&a, &b| {
            let distance = |j: usize| p(j).distance_squared(m);
            angle(p(a)).total_cmp(&angle(p(b))).then(distance(a).total_cmp(&distance(b)))
        });
    in_the_way.unwrap_or_else(|| {
        // Of corners that earlier seams have doubled, the one whose inside holds the seam.
        (0..n).find(|&j| p(j) == p(end) && opens_towards(ring, j, m)).unwrap_or(end)
    })
}

/// Whether the inside of the ring at corner `j` has the direction towards `m` in it.
fn opens_towards(ring: &[Corner], j: usize, m: DVec2) -> bool {
    let n = ring.len();
    let (before, at, after) = (ring[(j + n - 1) % n].flat, ring[j].flat, ring[(j + 1) % n].flat);
    let left = |a: DVec2, b: DVec2| (b - a).perp_dot(m - a) >= 0.0;
    let convex = (at - before).perp_dot(after - at) > 0.0;
    if convex { left(before, at) && left(at, after) } else { left(before, at) || left(at, after) }
}

fn inside([a, b, c]: [DVec2; 3], q: DVec2) -> bool {
    let turns = [(a, b), (b, c), (c, a)].map(|(from, to)| (to - from).perp_dot(q - from));
    turns.iter().all(|&t| t >= 0.0) || turns.iter().all(|&t| t <= 0.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn square(x: f64, y: f64, size: f64) -> Vec<DVec3> {
        [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)]
            .map(|(u, v)| DVec3::new(x + u * size, y + v * size, 2.0))
            .into()
    }

    fn flat(corners: &[DVec3]) -> Vec<DVec2> {
        corners.iter().map(|p| DVec2::new(p.x, p.y)).collect()
    }

    /// Whether two segments cross inside both.
    fn crosses(a: [DVec2; 2], b: [DVec2; 2]) -> bool {
        let side = |s: [DVec2; 2], p: DVec2| (s[1] - s[0]).perp_dot(p - s[0]);
        side(a, b[0]) * side(a, b[1]) < -1e-12 && side(b, a[0]) * side(b, a[1]) < -1e-12
    }

    fn is_weakly_simple(corners: &[DVec3]) -> bool {
        let p = flat(corners);
        let sides: Vec<[DVec2; 2]> = (0..p.len()).map(|i| [p[i], p[(i + 1) % p.len()]]).collect();
        sides.iter().enumerate().all(|(i, &a)| sides[..i].iter().all(|&b| !crosses(a, b)))
    }

    #[test]
    fn holes_are_taken_from_the_area_whichever_way_they_run() {
        let (outline, mut hole) = (square(0.0, 0.0, 10.0), square(3.0, 4.0, 2.0));
        for _ in 0..2 {
            hole.reverse();
            let polygon = bridged(&[outline.clone(), hole.clone()]);
            assert_eq!(polygon.len(), 4 + 4 + 2);
            assert!((doubled_area(&polygon).z / 2.0 - 96.0).abs() < 1e-12);
            assert!(is_weakly_simple(&polygon));
        }
    }

    #[test]
    fn many_holes_in_any_order_and_direction() {
        let mut loops = vec![square(0.0, 0.0, 10.0)];
        for (i, j) in [(0, 0), (2, 1), (1, 1), (0, 2), (1, 0), (2, 2), (2, 0), (0, 1), (1, 2)] {
            loops.push(square(1.0 + 3.0 * f64::from(i), 1.0 + 3.0 * f64::from(j), 2.0));
        }
        for reversed in [false, true] {
            if reversed {
                loops[0].reverse();
            }
            let polygon = bridged(&loops);
            let sign = if reversed { -1.0 } else { 1.0 };
            assert_eq!(polygon.len(), 4 + 9 * 6);
            assert!((sign * doubled_area(&polygon).z / 2.0 - 64.0).abs() < 1e-9);
            assert!(is_weakly_simple(&polygon));
        }
    }

    #[test]
    fn a_corner_in_the_way_becomes_the_seam_s_end() {
        // A dent reaches from above to the right of the hole.
        let outline: Vec<DVec3> = [(0.0, 0.0), (9.0, 0.0), (9.0, 9.0), (6.0, 9.0), (5.0, 3.5), (4.0, 9.0), (0.0, 9.0)]
            .map(|(x, y)| DVec3::new(x, y, 0.0))
            .into();
        let polygon = bridged(&[outline, square(1.0, 2.0, 2.0)]);
        assert!(is_weakly_simple(&polygon), "{polygon:?}");
    }

    #[test]
    fn a_hole_outside_does_no_harm() {
        let polygon = bridged(&[square(0.0, 0.0, 1.0), square(5.0, 5.0, 1.0)]);
        assert_eq!(polygon.len(), 10);
        assert!(bridged(&[]).is_empty() && bridged(&[vec![DVec3::NAN; 3], vec![DVec3::ZERO; 3]]).len() == 8);
    }
}
