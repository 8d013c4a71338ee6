//! What was found at points of faces, noted so that a later bake of the same faces need not find it again.
//!
//! What a point sees of the faces is the same whatever these emit and reflect, and it is what a bake spends its time on. So a
//! stage that asks at points may have a [`Memory`]: none, one that notes what is found ([`Notes`], from many threads), or one that
//! knows what was noted ([`AtPoints`]).
//!
//! Holds: a point is known by the bits of its position; so a stage that reads from memory what it would find anew gives the same
//! bits. Notes are in the order of the points, however many threads wrote them.

use std::collections::BTreeMap;
use std::sync::{Mutex, PoisonError};

use serde::{Deserialize, Serialize};

use super::ReceiverPoint;
use crate::id::PlaneId;

/// Threads that note at the same time seldom wait for each other with so many parts.
const PARTS: usize = 64;

/// A point of a side of a plane.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
struct PointKey {
    position_bits: [u64; 3],
    plane: PlaneId,
    /// Whether the first coordinate of the normal that is not zero is negative: which side it is.
    is_reversed: bool,
}

impl PointKey {
    fn of(point: &ReceiverPoint) -> Self {
        let first = point.normal.to_array().into_iter().find(|&coordinate| coordinate != 0.0);
        Self {
            position_bits: point.position_m.to_array().map(f64::to_bits),
            plane: point.plane,
            is_reversed: first.is_some_and(|coordinate| coordinate < 0.0),
        }
    }

    /// The part of the notes that it belongs to.
    fn part(&self) -> usize {
        // The high bits of a product depend on all bits of its factors.
        let mixed =
            self.position_bits.iter().fold(0_u64, |mixed, bits| (mixed.rotate_left(21) ^ bits).wrapping_mul(ODD));
        (mixed >> 32) as usize % PARTS
    }
}

/// 2^64 over the golden ratio: its bits are without order.
const ODD: u64 = 0x9e37_79b9_7f4a_7c15;

/// Notes what is found at points.
#[derive(Debug)]
pub struct Notes<T> {
    parts: Vec<Mutex<BTreeMap<PointKey, T>>>,
}

impl<T> Default for Notes<T> {
    fn default() -> Self {
        Self { parts: (0..PARTS).map(|_| Mutex::default()).collect() }
    }
}

impl<T> Notes<T> {
    /// Notes what was found at a point.
    pub fn note(&self, point: &ReceiverPoint, found: T) {
        let key = PointKey::of(point);
        // What a thread noted before it broke off is whole all the same.
        self.parts[key.part()].lock().unwrap_or_else(PoisonError::into_inner).insert(key, found);
    }

    /// What was noted.
    pub fn finish(self) -> AtPoints<T> {
        let parts = self.parts.into_iter().flat_map(|part| part.into_inner().unwrap_or_else(PoisonError::into_inner));
        let mut noted: Vec<(PointKey, T)> = parts.collect();
        noted.sort_by_key(|&(key, _)| key);
        AtPoints { noted }
    }
}

/// What was found at points.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct AtPoints<T> {
    noted: Vec<(PointKey, T)>,
}

impl<T> AtPoints<T> {
    /// What was found at some points: of one that is named twice, the first.
    pub fn new(found: Vec<(ReceiverPoint, T)>) -> Self {
        let mut noted: Vec<_> = found.into_iter().map(|(point, found)| (PointKey::of(&point), found)).collect();
        noted.sort_by_key(|&(key, _)| key);
        noted.dedup_by_key(|&mut (key, _)| key);
        Self { noted }
    }

    /// What was found at a point.
    pub fn get(&self, point: &ReceiverPoint) -> Option<&T> {
        let number = self.noted.binary_search_by_key(&PointKey::of(point), |&(key, _)| key).ok()?;
        Some(&self.noted[number].1)
    }

    /// All that was found, in the order of the points.
    pub fn iter(&self) -> impl Iterator<Item = &T> {
        self.noted.iter().map(|(_, found)| found)
    }

    /// Number of points.
    pub fn len(&self) -> usize {
        self.noted.len()
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.noted.is_empty()
    }

    /// Whether points are in order, each once: where they come from a file, it must be checked.
    pub fn is_ordered(&self) -> bool {
        self.noted.is_sorted_by(|(before, _), (after, _)| before < after)
    }
}

/// What a stage knows beforehand of points, or where it notes what it finds.
#[derive(Debug)]
pub enum Memory<'a, T> {
    /// Neither.
    None,
    /// All that is found is noted.
    Noting(&'a Notes<T>),
    /// What is known is not looked for again.
    Known(&'a AtPoints<T>),
}

impl<T> Clone for Memory<'_, T> {
    fn clone(&self) -> Self {
        *self
    }
}

impl<T> Copy for Memory<'_, T> {}

impl<T> Memory<'_, T> {
    /// Reads what is known at a point, or what `find` finds there.
    pub fn read<R>(&self, point: &ReceiverPoint, find: impl FnOnce() -> T, read: impl FnOnce(&T) -> R) -> R {
        match self {
            Self::None => read(&find()),
            Self::Noting(notes) => {
                let found = find();
                let answer = read(&found);
                notes.note(point, found);
                answer
            }
            Self::Known(known) => match known.get(point) {
                Some(known) => read(known),
                None => read(&find()),
            },
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DVec3;
    use rayon::prelude::*;

    fn point(x: f64, normal: DVec3) -> ReceiverPoint {
        ReceiverPoint::on_plane(DVec3::new(x, -x, 0.5), normal, PlaneId::from(0))
    }

    #[test]
    fn what_was_noted_by_many_threads_is_known_at_its_points_and_nowhere_else() {
        let notes = Notes::default();
        let memory = Memory::Noting(&notes);
        (0..1000).into_par_iter().for_each(|i| {
            let there = point(f64::from(i), DVec3::Z);
            assert_eq!(memory.read(&there, || i, |&found| found), i);
        });
        let known = notes.finish();
        assert!(known.len() == 1000 && known.is_ordered());
        let memory = Memory::Known(&known);
        for i in 0..1000 {
            assert_eq!(memory.read(&point(f64::from(i), DVec3::Z), || -1, |&found| found), i);
        }
        let unknown = [point(0.1, DVec3::Z), point(1.0, DVec3::NEG_Z), point(f64::from_bits(1), DVec3::Z)];
        for there in unknown {
            assert_eq!(memory.read(&there, || -1, |&found| found), -1);
        }
    }
}
