//! The rays that pass three straight edges in general position: one line of a source and two of occluders.
//!
//! From each point of the source line goes one line that meets both others; together they rule a quadric. With `t` from
//! 0 to 1 along the source line, the planes through its point and the two occluder lines turn linearly in their
//! normals, so that the direction of the ray is a polynomial of degree 2, and where the ray meets another edge is a
//! root of one of degree 3. Between such roots nothing changes but by straight motion: visibility is again a matter of
//! intervals.
//!
//! ```text
//!   s(0) ----- s(t) ------ s(1)   source line
//!                 \
//!          nearer  x              the line that is passed first
//!                   \
//!            last ---x---         the line that is passed last
//!                     \
//!                      receiver: a piece of a conic, as t moves
//! ```

use glam::DVec3;
use smallvec::SmallVec;

use super::polynomial;
use crate::geometry::Plane;

/// Six times the volume between a point and a triangle.
fn volume(point: DVec3, [p, q, r]: [DVec3; 3]) -> f64 {
    (p - point).cross(q - point).dot(r - point)
}

/// A source line and the occluder lines that its rays pass first and last.
pub(super) struct Ruled {
    pub(super) source: [DVec3; 2],
    pub(super) nearer: [DVec3; 2],
    pub(super) last: [DVec3; 2],
}

/// A ray: where it leaves the source line, and where it passes the last line.
#[derive(Clone, Copy, Debug)]
pub(super) struct Ray {
    pub(super) from: DVec3,
    pub(super) last: DVec3,
}

impl Ray {
    /// To where it passes the last line.
    pub(super) fn direction(&self) -> DVec3 {
        self.last - self.from
    }
}

impl Ruled {
    fn start(&self, t: f64) -> DVec3 {
        self.source[0].lerp(self.source[1], t)
    }

    /// The ray from `t`, if it passes both occluder lines between their ends, in this order.
    pub(super) fn ray(&self, t: f64) -> Option<Ray> {
        let from = self.start(t);
        let on = |line: [DVec3; 2], other: [DVec3; 2]| {
            let [here, there] = line.map(|end| volume(from, [other[0], other[1], end]));
            let share = here / (here - there);
            (0.0..=1.0).contains(&share).then(|| line[0].lerp(line[1], share))
        };
        let (nearer, last) = (on(self.nearer, self.last)?, on(self.last, self.nearer)?);
        let (to_nearer, to_last) = (nearer - from, last - from);
        let along = to_nearer.dot(to_last);
        (along > 0.0 && along < to_last.length_squared()).then_some(Ray { from, last })
    }

    /// Whether no ray from the source line passes both occluder lines between their ends: a quick look at the signs.
    pub(super) fn is_empty(&self) -> bool {
        let apart = |line: [DVec3; 2], other: [DVec3; 2]| {
            let signs = self.source.map(|from| line.map(|end| volume(from, [other[0], other[1], end]) > 0.0));
            signs.as_flattened().iter().all(|&sign| sign == signs[0][0])
        };
        apart(self.nearer, self.last) || apart(self.last, self.nearer)
    }

    /// Where the ray passes an end of an occluder line.
    pub(super) fn passes_ends(&self) -> SmallVec<[f64; 4]> {
        let [p, q] = [self.nearer, self.last];
        let triangles = [[q[0], q[1], p[0]], [q[0], q[1], p[1]], [p[0], p[1], q[0]], [p[0], p[1], q[1]]];
        triangles
            .into_iter()
            .flat_map(|triangle| {
                let [from, to] = self.source.map(|point| volume(point, triangle));
                polynomial::roots(&[from, to - from])
            })
            .collect()
    }

    /// The direction of the ray as a polynomial in `t`, of no particular sense: the common line of both planes.
    pub(super) fn direction(&self) -> [DVec3; 3] {
        let along = self.source[1] - self.source[0];
        let normal = |[p, q]: [DVec3; 2]| ((p - self.source[0]).cross(q - self.source[0]), (q - p).cross(along));
        let ((n0, n1), (m0, m1)) = (normal(self.nearer), normal(self.last));
        [n0.cross(m0), n0.cross(m1) + n1.cross(m0), n1.cross(m1)]
    }

    /// Where the ray meets the line between two points.
    pub(super) fn meets(&self, direction: &[DVec3; 3], [p, q]: [DVec3; 2]) -> SmallVec<[f64; 4]> {
        let along = self.source[1] - self.source[0];
        let (w0, w1) = ((p - self.source[0]).cross(q - p), (q - p).cross(along));
        let [d0, d1, d2] = *direction;
        polynomial::roots(&[w0.dot(d0), w0.dot(d1) + w1.dot(d0), w0.dot(d2) + w1.dot(d1), w1.dot(d2)])
    }
}

/// Where the rays between two lines, and their continuation beyond the second, can be: half-spaces that hold both.
pub(super) struct Reach {
    /// Planes with the first line in front or on them, and in front of which lies what is between.
    planes: SmallVec<[Plane; 4]>,
    /// How many of them, from the first, have behind them what is beyond the second line; it is in front of the others.
    turned: usize,
}

impl Reach {
    /// The reach of the rays from a part of the source line through a part of the last line.
    pub(super) fn new(source: [DVec3; 2], last: [DVec3; 2]) -> Self {
        let side = |line: [DVec3; 2], through: DVec3, other: DVec3| {
            let normal = (line[1] - line[0]).cross(through - line[0]).try_normalize()?;
            let normal = if normal.dot(other - line[0]) < 0.0 { -normal } else { normal };
            Some(Plane::through(line[0], normal))
        };
        let mut planes: SmallVec<[Plane; 4]> = SmallVec::new();
        planes.extend(side(last, source[0], source[1]));
        planes.extend(side(last, source[1], source[0]));
        let turned = planes.len();
        planes.extend(side(source, last[0], last[1]));
        planes.extend(side(source, last[1], last[0]));
        Self { planes, turned }
    }

    /// Whether something may be in reach whose greatest and least height over a plane, in metres, are told.
    pub(super) fn may_meet(&self, heights_m: impl Fn(&Plane) -> [f64; 2], slack_m: f64) -> bool {
        let (mut between, mut beyond) = (true, true);
        for (i, plane) in self.planes.iter().enumerate() {
            let [least, most] = heights_m(plane);
            between &= most >= -slack_m;
            beyond &= if i < self.turned { least <= slack_m } else { most >= -slack_m };
        }
        between || beyond
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn three() -> Ruled {
        Ruled {
            source: [DVec3::new(-1.0, 0.3, 3.0), DVec3::new(1.0, -0.2, 3.1)],
            nearer: [DVec3::new(0.2, -2.0, 2.0), DVec3::new(-0.1, 2.0, 2.2)],
            last: [DVec3::new(-1.5, -1.0, 0.9), DVec3::new(1.5, 1.2, 1.1)],
        }
    }

    #[test]
    fn the_polynomial_has_the_direction_of_the_ray() {
        let ruled = three();
        assert!(!ruled.is_empty());
        let [d0, d1, d2] = ruled.direction();
        for t in [0.1, 0.4, 0.7] {
            let Some(ray) = ruled.ray(t) else { continue };
            let line = ray.direction().normalize();
            let [p, q] = ruled.nearer;
            let apart_m = (p - ray.from).dot(line.cross(q - p).normalize());
            assert!(apart_m.abs() < 1e-12, "the ray passes the nearer line, too");
            assert!((d0 + t * d1 + t * t * d2).normalize().cross(line).length() < 1e-12);
        }
        assert!(ruled.ray(0.4).is_some());
    }

    #[test]
    fn the_ray_meets_an_edge_where_the_root_says() {
        let ruled = three();
        let ray = ruled.ray(0.4).unwrap();
        let on = ray.from + 1.5 * ray.direction();
        let across = DVec3::new(0.3, -1.0, 0.2);
        let found = ruled.meets(&ruled.direction(), [on - across, on + across]);
        assert!(found.iter().any(|t| (t - 0.4).abs() < 1e-12), "{found:?}");
    }

    #[test]
    fn rays_pass_only_what_is_in_reach() {
        let ruled = three();
        let [from, to] = [0.35, 0.45].map(|t| ruled.ray(t).unwrap());
        let reach = Reach::new([from.from, to.from], [from.last, to.last]);
        let may_meet = |p: DVec3| reach.may_meet(|plane| [plane.signed_distance_m(p); 2], 1e-9);
        for t in [0.36, 0.4, 0.44] {
            let ray = ruled.ray(t).unwrap();
            for along in [0.1, 0.9, 1.1, 4.0] {
                assert!(may_meet(ray.from + along * ray.direction()));
            }
        }
        let ray = ruled.ray(0.4).unwrap();
        assert!(!may_meet(ray.from + 0.5 * ray.direction() + DVec3::new(0.5, 0.5, 0.0)));
        assert!(!may_meet(ray.from - 0.5 * ray.direction()));
    }
}
