//! A point that receives light, and from where it sees what is around it.
//!
//! **Flat faces.** Irradiance is the integral of the radiance of all that is visible, times the cosine to the normal of the face.
//!
//! **Smooth faces.** Here facets stand for a curved surface, whose normals they carry. Irradiance is the integral of the radiance of
//! all that is visible, times `max(0, n . w)` with the interpolated normal `n`: what stands behind its horizon is dark. Visibility
//! is that of the true faces, from the true point, but for the facet itself and the faces around it ([`super::around`]):
//!
//! ```text
//!          n   . w  to the lamp
//!          | .            The facet is turned away from the lamp, the curved surface is not. From the point x all is dark,
//!      __ o'___           facet by facet, as far as they are turned away: a saw-tooth. So the faces around are seen from o,
//!     /   x    \          over x on the planes that touch the curved surface at the corners of the facet
//!    /          \         ([`Prepared::offset_to_curved_m`]), and a hair beyond that: they let pass what passes the curved surface.
//! ```
//!
//! Only neighbours are told from o: what else throws a shadow on a facet throws it where it truly falls, and the
//! d-segments are where the light changes. On a surface with facets of about one size a ray that leaves the curved surface and enters
//! the facet's body leaves that through a neighbour again. From behind nothing shines through: the facet itself and its neighbours
//! are in the way of all that o does not see over their edges.
//!
//! Holds: where smooth edges join two facets, normal and o are the same from both sides; so light is continuous over a smooth surface.
//! A concave facet that is closed in sees itself in at most `(1 - cos t) / 2` of its view, where `t` is the angle between its
//! own normal and the interpolated one, and receives so much less: 0.4 % for 15 degrees between neighbours, nothing in its middle.

use glam::DVec3;

use crate::id::{FaceId, PlaneId};
use crate::prepare::Prepared;

/// The faces around a point of a smooth surface are seen from a point that is higher by this share of the extent: beyond rounding, and
/// nearer than faces that are welded.
const HAIR_OF_EXTENT: f64 = 2e-6;

/// A point that receives light.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ReceiverPoint {
    /// Where it is, in its plane, in metres.
    pub position_m: DVec3,
    /// Unit normal of the side that is lit: that of the smooth surface where it has one.
    pub normal: DVec3,
    /// The plane that it lies in: the plane's faces do not shade it.
    pub plane: PlaneId,
    /// The face that it lies on, where it lies on one: what is nearer to it than rounding is on the side of it that the face is on.
    pub face: Option<FaceId>,
    /// From where the faces around it are seen, on a smooth surface; there they may shade it.
    pub near: Option<NearView>,
    /// From where lamps are looked for, if not from here.
    pub beside_jump: Option<BesideJump>,
}

/// A point at the edge of a hard shadow has the light of one side. A cut may lie beside the true edge, by up to the length of the
/// shortest edge of the mesh, and so may a point that belongs to one side of the cut. So whether a lamp is seen is asked for farther
/// inside of that side; how much light it brings, at the point itself.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BesideJump {
    /// A point on the same side that no cut's displacement reaches, in metres.
    pub position_m: DVec3,
    /// From where the faces around it are seen, on a smooth surface.
    pub near: Option<NearView>,
}

/// From where a point of a smooth surface sees the faces around it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NearView {
    /// The face that it lies on.
    pub face: FaceId,
    /// A point over it, in metres.
    pub from_m: DVec3,
}

impl ReceiverPoint {
    /// The point of `face` at the foot of `near_m`.
    pub fn on_face(prepared: &Prepared, face: FaceId, near_m: DVec3) -> Self {
        let plane = prepared.oriented_plane(face);
        let position_m = plane.project(near_m);
        let flat = Self { face: Some(face), ..Self::on_plane(position_m, plane.normal, prepared.faces[face].plane) };
        if !prepared.is_smooth(face) {
            return flat;
        }
        let normal = prepared.smooth_normal(face, position_m);
        let hair_m = HAIR_OF_EXTENT * prepared.tolerance.extent_m * normal;
        let from_m = position_m + prepared.offset_to_curved_m(face, position_m) + hair_m;
        Self { normal, near: Some(NearView { face, from_m }), ..flat }
    }

    /// A point that lies on a flat face, within rounding.
    pub fn on_flat_face(prepared: &Prepared, face: FaceId, position_m: DVec3) -> Self {
        let flat = Self::on_plane(position_m, prepared.normal(face), prepared.faces[face].plane);
        Self { face: Some(face), ..flat }
    }

    /// A point of a plane that is what it looks like.
    pub fn on_plane(position_m: DVec3, normal: DVec3, plane: PlaneId) -> Self {
        Self { position_m, normal, plane, face: None, near: None, beside_jump: None }
    }

    /// The same point, which looks for lamps from `inside`, a point of the same side of a jump.
    pub fn beside_jump(self, inside: &Self) -> Self {
        Self { beside_jump: Some(BesideJump { position_m: inside.position_m, near: inside.near }), ..self }
    }

    /// The point that tells which lamps this one sees.
    pub fn looking_for_lamps(&self) -> Self {
        self.beside_jump.map_or(*self, |BesideJump { position_m, near }| Self {
            position_m,
            near,
            beside_jump: None,
            ..*self
        })
    }
}
