//! What an eye in a plane sees of all that lies in the plane, or touches it: how the slope jumps there (degree 1).
//!
//! All of it is seen upon one line, a line of a source in the plane. When the eye leaves the plane by `e`, what is at
//! nearness `n` moves against the source's line, at nearness 1, by `-e (n - 1)`, in proportion. So for each direction
//! in the plane the image beside the line is a matter of intervals of `n`:
//! - a face that touches the plane from its front hides, for `e > 0`, all with `n` below its own, since that is where
//!   its inside is seen, and for `e < 0` all above; one that touches from the back the reverse. Of several the farthest
//!   counts;
//! - a face in the plane hides its own interval, on both sides.
//!
//! ```text
//!   e > 0     1 ====front====| P      visible      M |====back==== infinity
//! ```
//!
//! What is seen of both sides more or less than from the plane itself is by how much the slope jumps. Where boards of a
//! shelf have their fronts in one plane, this is more than the sum of what each would do alone: between them, too, one
//! moves against the other.

use glam::DVec3;
use smallvec::SmallVec;

use super::features::Surroundings;
use super::strength::{Receiver, View};
use super::trace;
use super::wedge::{Crossing, Piece, Wedge};
use crate::geometry::Plane;
use crate::scene::Rgb;

/// What the eye sees in a plane.
pub(super) struct PlaneImage {
    /// To the line on the source; what crosses the plane hides it.
    view: View,
    /// What touches the plane before the line, from its front and from its back.
    touching: [Vec<Piece>; 2],
    /// The sides of each face that lies in the plane.
    plates: Vec<SmallVec<[Piece; 8]>>,
}

impl Surroundings<'_> {
    /// What a receiver point sees before a line on a source, in a plane through both.
    pub(super) fn plane_image(&self, receiver: &Receiver, source: [DVec3; 2], plane: Plane) -> Option<PlaneImage> {
        let wedge = Wedge { plane, ..Wedge::new(receiver.at, source, self.weld_m())? };
        let own = self.prepared.faces[receiver.face].plane;
        let mut faces = wedge.faces(self.visibility, 1.0);
        faces.retain(|&face| self.visibility.plane(face) != own);
        let before = trace::part_at(&wedge.pieces_of(self.visibility, &faces), 1.0, true);
        let of = |crossing: Crossing| before.iter().copied().filter(|piece| piece.crossing == crossing).collect();
        let view = View { wedge, hiding: of(Crossing::Through) };
        let is_flat = |&p: &DVec3| plane.signed_distance_m(p).abs() <= self.coplanar_m();
        let plates = faces.iter().map(|&face| self.visibility.boundary_m(face)).filter(|face| face.iter().all(is_flat));
        let sides = |face: &[DVec3]| view.lines((0..face.len()).map(|i| [face[i], face[(i + 1) % face.len()]]));
        Some(PlaneImage {
            plates: plates.map(sides).collect(),
            touching: [of(Crossing::Front), of(Crossing::Back)],
            view,
        })
    }
}

impl PlaneImage {
    /// The point of the source's line behind the middle of a line in the plane.
    pub(super) fn place_of(&self, ends: [DVec3; 2]) -> Option<DVec3> {
        let line = self.view.lines(std::iter::once(ends)).first().copied()?;
        Some(self.view.wedge.point(0.5 * (line.s[0] + line.s[1]), 1.0))
    }

    /// By how much the slope jumps, where the source's line has these radiances behind the plane and in front of it.
    pub(super) fn jump(&self, receiver: &Receiver, radiance: [Rgb; 2]) -> Rgb {
        let pieces = self.touching.iter().flatten().chain(self.plates.iter().flatten());
        let ends: SmallVec<[f64; 16]> = pieces.flat_map(|piece| piece.s).collect();
        // An eye in front of the plane sees what is behind it change, and the reverse.
        let [front, back] = [0, 1].map(|side| self.view.sum(receiver, |s| self.gain(s, side), &ends));
        radiance[0] * front + radiance[1] * back
    }

    /// How much more is seen in direction `s` when the eye leaves the plane to its front (0) or its back (1), of the
    /// part beside the line that nearer things move over.
    fn gain(&self, s: f64, side: usize) -> f64 {
        let nearness = |pieces: &[Piece]| -> Option<[f64; 2]> {
            let here = pieces.iter().filter_map(|piece| piece.nearness_in(s));
            here.fold(None, |range, n| {
                let [lo, hi] = range.unwrap_or([n, n]);
                Some([lo.min(n), hi.max(n)])
            })
        };
        // From 1 to `below` and from `above` on all is hidden.
        let below = nearness(&self.touching[side]).map_or(1.0, |range| range[1].max(1.0));
        let above = nearness(&self.touching[1 - side]).map(|range| range[0].max(1.0));
        let mut plates: SmallVec<[[f64; 2]; 4]> = self.plates.iter().filter_map(|plate| nearness(plate)).collect();
        plates.sort_by(|p, q| p[0].total_cmp(&q[0]));
        // How far it is hidden without a gap, and the gaps before that.
        let (mut hidden_to, mut seen) = (below, 0.0);
        let end = above.unwrap_or(f64::INFINITY);
        for [from, to] in plates {
            seen += (from.min(end) - hidden_to).max(0.0);
            hidden_to = hidden_to.max(to);
        }
        match above {
            Some(above) => seen + (above - hidden_to).max(0.0),
            None => seen - (hidden_to - 1.0),
        }
    }
}
