//! Which bright places lie in which leaf, handed down as leaves are split.

use super::bright_places::BrightPlace;
use crate::id::PatchId;
use crate::mesh::Mesh;

/// The bright places of each leaf.
#[derive(Clone, Debug)]
pub struct PlacesOfLeaves<'a> {
    places: &'a [BrightPlace],
    /// Their numbers, by the number of the patch.
    numbers: Vec<Vec<u32>>,
}

impl<'a> PlacesOfLeaves<'a> {
    /// Finds the leaf of each place.
    pub fn new(mesh: &Mesh, places: &'a [BrightPlace]) -> Self {
        let mut numbers = vec![Vec::new(); mesh.patch_count()];
        for (number, place) in places.iter().enumerate() {
            numbers[mesh.leaf_at(place.face, place.point_m).index()].push(number as u32);
        }
        Self { places, numbers }
    }

    /// The places in a leaf.
    pub fn of(&self, leaf: PatchId) -> Vec<&'a BrightPlace> {
        let numbers = self.numbers.get(leaf.index()).map_or(&[][..], Vec::as_slice);
        numbers.iter().map(|&number| &self.places[number as usize]).collect()
    }

    /// Hands the places of patches that were split since down to their leaves.
    pub fn hand_down(&mut self, mesh: &Mesh) {
        let known = self.numbers.len();
        self.numbers.resize(mesh.patch_count(), Vec::new());
        for patch in (0..known).map(PatchId::from) {
            if !self.numbers[patch.index()].is_empty() && mesh.patch(patch).subpatches.is_some() {
                for number in std::mem::take(&mut self.numbers[patch.index()]) {
                    let place = &self.places[number as usize];
                    self.numbers[mesh.leaf_below(patch, place.point_m).index()].push(number);
                }
            }
        }
    }
}
