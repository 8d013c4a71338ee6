//! Which light sources a point sees, and how much of them: what direct light is made of, however bright they are.

use serde::{Deserialize, Serialize};

use crate::id::{FaceId, LampId, Table};
use crate::scene::Lamp;
use crate::visibility::{AtPoints, Memory, Notes, ReceiverPoint};

/// No factor is more than 1, but for the rounding of a sum of angles.
const MOST_FACTOR: f64 = 1.0 + 1e-6;

/// The light sources that a point sees.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct SourcesSeen {
    /// The emitting faces, and the factor of the part of each that is seen, in the order of faces.
    pub(super) emitters: Vec<(FaceId, f64)>,
    /// The lamps without extent, in order.
    pub(super) lamps: Vec<LampId>,
}

impl SourcesSeen {
    /// Whether all that is named is there, and factors can be what they say: where it comes from a file, it must be checked.
    pub fn fits(&self, faces: usize, lamps: usize) -> bool {
        let possible = |factor: f64| factor.abs() <= MOST_FACTOR;
        self.emitters.iter().all(|&(face, factor)| face.index() < faces && possible(factor))
            && self.lamps.iter().all(|lamp| lamp.index() < lamps)
    }
}

/// The factors and shadows of light sources that are where they were when they were found.
#[derive(Clone, Debug)]
pub struct KnownSources<'a> {
    seen: &'a AtPoints<SourcesSeen>,
    /// The faces that emitted then, ascending.
    emitters: &'a [FaceId],
    /// For each lamp, which one it was then.
    lamps: Table<LampId, Option<LampId>>,
}

impl<'a> KnownSources<'a> {
    /// What was `seen` of emitting faces, ascending, and lamps, for a scene that has these `lamps` now.
    pub fn new(
        seen: &'a AtPoints<SourcesSeen>,
        emitters: &'a [FaceId],
        before: &Table<LampId, Lamp>,
        lamps: &Table<LampId, Lamp>,
    ) -> Self {
        let was = |lamp: &Lamp| {
            before.iter_enumerated().find(|(_, old)| old.emits() && old.shines_where(lamp)).map(|(id, _)| id)
        };
        Self { seen, emitters, lamps: lamps.iter().map(was).collect() }
    }
}

/// What direct light knows beforehand of points, or where it notes what it finds.
#[derive(Clone, Debug, Default)]
pub enum SourceMemory<'a> {
    /// Neither.
    #[default]
    None,
    /// All that is found is noted.
    Noting(&'a Notes<SourcesSeen>),
    /// What is known is not looked for again.
    Known(KnownSources<'a>),
}

/// What is known of one point.
#[derive(Clone, Copy, Debug)]
pub(super) struct KnownHere<'a> {
    sources: &'a KnownSources<'a>,
    here: &'a SourcesSeen,
}

impl KnownHere<'_> {
    /// The factor of the part of a face that is seen, if it is known.
    pub(super) fn factor(&self, face: FaceId) -> Option<f64> {
        self.sources.emitters.binary_search(&face).ok()?;
        let seen = self.here.emitters.iter().find(|(seen, _)| *seen == face);
        Some(seen.map_or(0.0, |&(_, factor)| factor))
    }

    /// Whether a lamp is seen, if it is known.
    pub(super) fn sees(&self, lamp: LampId) -> Option<bool> {
        self.sources.lamps[lamp].map(|was| self.here.lamps.contains(&was))
    }
}

impl SourceMemory<'_> {
    /// What is known of a point.
    pub(super) fn at(&self, receiver: &ReceiverPoint) -> Option<KnownHere<'_>> {
        match self {
            Self::Known(sources) => sources.seen.get(receiver).map(|here| KnownHere { sources, here }),
            Self::None | Self::Noting(_) => None,
        }
    }

    /// Notes what was found, where that is wanted.
    pub(super) fn note(&self, receiver: &ReceiverPoint, seen: impl FnOnce() -> SourcesSeen) {
        if let Self::Noting(notes) = self {
            Memory::Noting(notes).read(receiver, seen, |_| ());
        }
    }
}
