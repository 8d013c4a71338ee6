//! Wedges: the plane pencils of rays that an event sends out (paper, Fig. 2), and what faces are in them.
//!
//! A point of the wedge is `apex + a * rays[0] + b * rays[1]` with `a, b >= 0`. Its *direction* is `s = b / (a + b)`, 0
//! to 1 from the first border ray to the second; its *nearness* is `n = 1 / (a + b)`, 1 on the line between the ray
//! ends, infinite at the apex, 0 far away. A straight piece of a face is linear in `(s, n)`: the projective map makes
//! visibility in the wedge a matter of intervals and straight lines.
//!
//! ```text
//!   VE                                 EV
//!   apex = source vertex               apex = occluder vertex
//!     \     n > 1: hides the edge        source edge at n = 1 of the opposite wedge
//!   ===+=== occluder edge, n = 1              \ | /
//!     / \   n < 1: may receive                 apex
//!                                             / | \   may receive
//! ```

use glam::{DVec2, DVec3};
use smallvec::SmallVec;

use crate::geometry::Plane;
use crate::id::FaceId;
use crate::visibility::Visibility;

/// A piece of a face narrower than this in direction is a point or radial: it hides nothing and receives nothing.
const LEAST_WIDTH: f64 = 1e-9;
/// A piece nearer to the apex than this share of the ray ends is cut off there: nearness stays finite.
const NEAREST: f64 = 1e-7;

/// A plane pencil of rays from `apex`, between two border rays.
#[derive(Clone, Copy, Debug)]
pub(super) struct Wedge {
    pub(super) apex: DVec3,
    /// From the apex to the ends of the line where the nearness is 1.
    pub(super) rays: [DVec3; 2],
    /// The plane of the wedge.
    pub(super) plane: Plane,
}

/// Which side of the wedge's plane a face lies on that only touches the plane, if so.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Crossing {
    /// The face lies on both sides.
    Through,
    /// The face touches the plane from its front.
    Front,
    /// The face touches the plane from its back.
    Back,
}

/// A straight piece of a face in a wedge.
#[derive(Clone, Copy, Debug)]
pub(super) struct Piece {
    pub(super) face: FaceId,
    pub(super) crossing: Crossing,
    /// Directions of its ends, ascending.
    pub(super) s: [f64; 2],
    /// Nearness at its ends.
    pub(super) nearness: [f64; 2],
}

impl Piece {
    /// Nearness in direction `s`.
    pub(super) fn nearness_at(&self, s: f64) -> f64 {
        let t = (s - self.s[0]) / (self.s[1] - self.s[0]);
        self.nearness[0] + t * (self.nearness[1] - self.nearness[0])
    }

    /// The same where the piece has a point inside in that direction.
    pub(super) fn nearness_in(&self, s: f64) -> Option<f64> {
        (self.s[0] < s && s < self.s[1]).then(|| self.nearness_at(s))
    }
}

impl Wedge {
    /// The wedge from `apex` through the line between `ends`; `None` where they are in line.
    pub(super) fn new(apex: DVec3, ends: [DVec3; 2], least_m: f64) -> Option<Self> {
        let rays = ends.map(|end| end - apex);
        let normal = rays[0].cross(rays[1]);
        let height_m = normal.length() / rays[0].length().max(rays[1].length()).max(f64::MIN_POSITIVE);
        if height_m <= least_m {
            return None;
        }
        Some(Self { apex, rays, plane: Plane::through(apex, normal.normalize()) })
    }

    /// The wedge on the other side of the apex.
    pub(super) fn opposite(&self) -> Self {
        Self { rays: self.rays.map(|ray| -ray), ..*self }
    }

    /// The point in direction `s` with nearness `n`.
    pub(super) fn point(&self, s: f64, n: f64) -> DVec3 {
        self.apex + self.rays[0].lerp(self.rays[1], s) / n
    }

    /// Nearness of a point of the wedge's plane; negative on the other side of the apex.
    pub(super) fn nearness(&self, point: DVec3) -> f64 {
        let coefficients = self.coefficients(point);
        1.0 / (coefficients.x + coefficients.y)
    }

    /// Coefficients of `point` along the border rays.
    fn coefficients(&self, point: DVec3) -> DVec2 {
        let (d, [u, v]) = (point - self.apex, self.rays);
        let (uu, uv, vv) = (u.dot(u), u.dot(v), v.dot(v));
        let (du, dv) = (d.dot(u), d.dot(v));
        DVec2::new(du * vv - dv * uv, dv * uu - du * uv) / (uu * vv - uv * uv)
    }

    /// The faces whose boxes meet this wedge, as far as nearness `least_nearness`; ids ascend.
    pub(super) fn faces(&self, visibility: &Visibility, least_nearness: f64) -> Vec<FaceId> {
        let slack_m = visibility.tolerance().coplanar_m();
        let [u, v] = self.rays;
        // Half-spaces that bound the wedge in its plane: beyond each border ray, and beyond the farthest line.
        let inward = [v - u * (u.dot(v) / u.dot(u)), u - v * (u.dot(v) / v.dot(v))];
        let outward = u + v;
        let reach =
            if least_nearness > 0.0 { u.dot(outward).max(v.dot(outward)) / least_nearness } else { f64::INFINITY };
        let keep = |lo: DVec3, hi: DVec3| {
            let (centre, half) = (0.5 * (lo + hi) - self.apex, 0.5 * (hi - lo));
            let most = |n: DVec3| n.dot(centre) + n.abs().dot(half) + n.length() * slack_m;
            inward.iter().all(|&n| most(n) >= 0.0) && most(-outward) >= -reach
        };
        visibility.faces_meeting_plane(&self.plane, keep)
    }

    /// The pieces of some faces in this wedge.
    pub(super) fn pieces_of(&self, visibility: &Visibility, faces: &[FaceId]) -> Vec<Piece> {
        let piece = |&face: &FaceId| {
            let (crossing, ends) = chord(visibility, face, &self.plane)?;
            self.piece(face, crossing, ends)
        };
        faces.iter().filter_map(piece).collect()
    }

    /// The pieces of all faces in this wedge, as far as nearness `least_nearness`, without the faces `but`.
    pub(super) fn pieces(
        &self,
        visibility: &Visibility,
        least_nearness: f64,
        but: impl Fn(FaceId) -> bool,
    ) -> Vec<Piece> {
        let mut faces = self.faces(visibility, least_nearness);
        faces.retain(|&face| !but(face));
        self.pieces_of(visibility, &faces)
    }

    /// The part in this wedge of a line in its plane, a piece of `face`.
    pub(super) fn piece(&self, face: FaceId, crossing: Crossing, ends: [DVec3; 2]) -> Option<Piece> {
        let mut ends = ends.map(|end| self.coefficients(end));
        if direction_order(ends[0]) > direction_order(ends[1]) {
            ends.reverse();
        }
        clip_to_wedge(ends).map(|(s, nearness)| Piece { face, crossing, s, nearness })
    }
}

/// How a face meets a plane, and its two ends there; `None` where it does not, or lies in it: rays in the plane only
/// graze along such a face.
pub(super) fn chord(visibility: &Visibility, face: FaceId, plane: &Plane) -> Option<(Crossing, [DVec3; 2])> {
    let slack_m = visibility.tolerance().coplanar_m();
    let boundary = visibility.boundary_m(face);
    let snapped = |corner: DVec3| {
        let height_m = plane.signed_distance_m(corner);
        if height_m.abs() <= slack_m { 0.0 } else { height_m }
    };
    let (mut above, mut below) = (false, false);
    let mut ends: SmallVec<[DVec3; 4]> = SmallVec::new();
    let (mut from, mut from_m) = (*boundary.last()?, snapped(*boundary.last()?));
    for &to in boundary {
        let to_m = snapped(to);
        if to_m == 0.0 {
            ends.push(to);
        } else if from_m * to_m < 0.0 {
            ends.push(from.lerp(to, from_m / (from_m - to_m)));
        }
        above |= to_m > 0.0;
        below |= to_m < 0.0;
        (from, from_m) = (to, to_m);
    }
    let crossing = match (above, below) {
        (true, true) => Crossing::Through,
        (true, false) => Crossing::Front,
        (false, true) => Crossing::Back,
        (false, false) => return None,
    };
    let farthest = |from: DVec3| {
        let away = |p: &&DVec3, q: &&DVec3| p.distance_squared(from).total_cmp(&q.distance_squared(from));
        ends.iter().max_by(away).copied()
    };
    let first = farthest(*ends.first()?)?;
    Some((crossing, [first, farthest(first)?]))
}

/// The part of a straight piece, given by direction and nearness of its ends, in ascending order, with directions
/// between 0 and 1: directions and nearness of the ends.
pub(super) fn clip_directions([first, last]: [(f64, f64); 2]) -> Option<([f64; 2], [f64; 2])> {
    let s = [first.0.max(0.0), last.0.min(1.0)];
    let nearness = |s: f64| first.1 + (last.1 - first.1) * (s - first.0) / (last.0 - first.0);
    (s[1] - s[0] > LEAST_WIDTH).then(|| (s, s.map(nearness)))
}

/// Orders the ends of a straight piece from the first border ray to the second.
fn direction_order(coefficients: DVec2) -> f64 {
    coefficients.y - coefficients.x
}

/// The part of a straight piece, given by the coefficients of its ends, inside the wedge: directions ascending, and
/// nearness, of its two ends.
fn clip_to_wedge(ends: [DVec2; 2]) -> Option<([f64; 2], [f64; 2])> {
    let (mut t0, mut t1) = (0.0_f64, 1.0_f64);
    let bounds: [&dyn Fn(DVec2) -> f64; 3] = [&|p| p.x, &|p| p.y, &|p| p.x + p.y - NEAREST];
    for bound in bounds {
        let [from, to] = ends.map(bound);
        if from < 0.0 && to < 0.0 {
            return None;
        }
        if from < 0.0 {
            t0 = t0.max(from / (from - to));
        } else if to < 0.0 {
            t1 = t1.min(from / (from - to));
        }
    }
    if t0 >= t1 {
        return None;
    }
    let cut = [t0, t1].map(|t| ends[0].lerp(ends[1], t));
    let s = cut.map(|p| (p.y / (p.x + p.y)).clamp(0.0, 1.0));
    let nearness = cut.map(|p| 1.0 / (p.x + p.y));
    if (s[1] - s[0]).abs() <= LEAST_WIDTH {
        None
    } else if s[0] < s[1] {
        Some((s, nearness))
    } else {
        Some(([s[1], s[0]], [nearness[1], nearness[0]]))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn direction_and_nearness_of_a_point_round_trip() {
        let wedge = Wedge::new(DVec3::ZERO, [DVec3::new(1.0, 2.0, 0.0), DVec3::new(-1.0, 2.0, 0.0)], 1e-9).unwrap();
        let point = wedge.point(0.25, 0.5);
        assert_eq!(point, DVec3::new(1.0, 4.0, 0.0));
        let c = wedge.coefficients(point);
        assert!((c.y / (c.x + c.y) - 0.25).abs() < 1e-15 && (1.0 / (c.x + c.y) - 0.5).abs() < 1e-15);
    }

    #[test]
    fn a_wedge_in_line_is_none() {
        assert!(Wedge::new(DVec3::ZERO, [DVec3::X, DVec3::X * 2.0], 1e-9).is_none());
    }

    #[test]
    fn a_straight_piece_is_linear_in_direction_and_nearness() {
        let (s, n) = clip_to_wedge([DVec2::new(3.0, 1.0), DVec2::new(1.0, 2.0)]).unwrap();
        let middle = DVec2::new(2.0, 1.5);
        let piece = Piece { face: FaceId::from(0), crossing: Crossing::Through, s, nearness: n };
        let direction = middle.y / (middle.x + middle.y);
        assert!((piece.nearness_at(direction) - 1.0 / 3.5).abs() < 1e-15);
    }

    #[test]
    fn pieces_are_cut_at_the_border_rays_and_radial_ones_vanish() {
        let (s, _) = clip_to_wedge([DVec2::new(3.0, -1.0), DVec2::new(-1.0, 3.0)]).unwrap();
        assert_eq!(s, [0.0, 1.0]);
        assert!(clip_to_wedge([DVec2::new(1.0, 1.0), DVec2::new(2.0, 2.0)]).is_none());
        assert!(clip_to_wedge([DVec2::new(-1.0, 1.0), DVec2::new(-2.0, 2.0)]).is_none());
    }
}
