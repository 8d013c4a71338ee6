//! Obstacles: what may stand between the points of a patch and each emitting face.
//!
//! Where light is evaluated at many points of a patch, most of the faces that one of them would look at stand in the way of none.
//! So they are found once for the patch, in the shaft to each emitter, and for its subpatches among those of the patch.
//!
//! Holds: no face is missing that throws a shadow of an emitter on a point of the patch.

use smallvec::SmallVec;

use crate::id::FaceId;

/// With more emitters than this, lists for each of them are more than what they spare.
pub(super) const MOST_EMITTERS: usize = 64;

/// The obstacles of a patch.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Obstacles {
    faces: Box<[FaceId]>,
    /// Where those of each emitter end.
    ends: SmallVec<[u32; 4]>,
}

impl Obstacles {
    /// By the faces before each emitter.
    pub(super) fn new(of_emitters: impl Iterator<Item = Vec<FaceId>>) -> Self {
        let (mut faces, mut ends) = (Vec::new(), SmallVec::new());
        for before in of_emitters {
            faces.extend(before);
            ends.push(faces.len() as u32);
        }
        Self { faces: faces.into_boxed_slice(), ends }
    }

    /// The faces before an emitter, by its number; `None` where they were not looked for.
    pub(crate) fn before(&self, emitter: usize) -> Option<&[FaceId]> {
        let end = *self.ends.get(emitter)? as usize;
        let start = emitter.checked_sub(1).map_or(0, |before| self.ends[before] as usize);
        Some(&self.faces[start..end])
    }
}
