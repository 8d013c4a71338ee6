//! Typed ids of everything that is numbered, and the table that they index.
//!
//! An id is a `u32` newtype: it cannot be mistaken for another kind's, and it is half the size of a pointer. Results of
//! a stage are tables ([`Table`]) keyed by the ids of what they describe.

use serde::{Deserialize, Serialize};

/// A vector whose index is a typed id.
pub type Table<Id, T> = typed_index_collections::TiVec<Id, T>;

macro_rules! typed_id {
    ($($(#[$doc:meta])* $name:ident),* $(,)?) => {$(
        $(#[$doc])*
        #[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
        pub struct $name(u32);

        impl From<usize> for $name {
            fn from(index: usize) -> Self {
                assert!(index < u32::MAX as usize, "more than 2^32 - 1 of {}", stringify!($name));
                Self(index as u32)
            }
        }

        impl From<$name> for usize {
            fn from(id: $name) -> usize {
                id.0 as usize
            }
        }

        impl $name {
            /// The id as an index.
            pub fn index(self) -> usize {
                self.0 as usize
            }
        }
    )*};
}

typed_id! {
    /// A material of the scene.
    MaterialId,
    /// An image of the scene.
    ImageId,
    /// A lamp of the scene.
    LampId,
    /// A node of the scene's hierarchy.
    NodeId,
    /// A surface of the scene: the polygons of one material under one node.
    SurfaceId,
    /// What is laid over faces: texture coordinates and smooth normals as functions of the position.
    SkinId,
    /// A vertex, of the prepared faces and of the mesh that grows from them.
    VertexId,
    /// A (possibly split) edge: a node of an edge tree.
    EdgeId,
    /// A geometric plane; coplanar faces share it, whichever way they look.
    PlaneId,
    /// A prepared face: convex, plane, one-sided, of one material.
    FaceId,
    /// A crowd of faces: a node of the spatial index.
    ClusterId,
    /// A polygonal emitter: touching coplanar faces of one radiance.
    EmitterId,
    /// A discontinuity segment on a face.
    DSegmentId,
    /// A patch: a face or part of one, a node of the patch tree.
    PatchId,
    /// A link that carries light from one node of the hierarchy to another.
    LinkId,
}
