//! A part of the receiver over which the visible factor is integrated, and how it is cut in two.

use glam::{DVec2, DVec3};
use smallvec::SmallVec;

use super::kink::Kink;
use crate::geometry::{Plane, PlaneFrame, clip, polygon};

/// Where the visible factor is not smooth.
#[derive(Clone, Debug)]
pub(super) struct Hints {
    /// The receiver's frame.
    pub(super) frame: PlaneFrame,
    /// Where it bends.
    pub(super) kinks: Vec<Kink>,
    /// Where each occluder takes something.
    pub(super) penumbrae: Vec<Vec<DVec2>>,
}

/// A convex part of the receiver.
#[derive(Clone, Debug)]
pub(super) struct Cell {
    pub(super) corners_m: Vec<DVec3>,
    /// The kinks that cross it.
    kinks: SmallVec<[u32; 8]>,
    /// The penumbrae that it has a part of.
    penumbrae: SmallVec<[u32; 8]>,
    /// How often the receiver was cut to get it.
    pub(super) cuts: u32,
}

/// A cut that leaves less than this share of the area on one side is left out.
const LEAST_SHARE: f64 = 1e-6;

impl Cell {
    /// The whole receiver.
    pub(super) fn whole(corners_m: Vec<DVec3>, hints: &Hints) -> Self {
        let all = |n: usize| (0..n as u32).collect();
        Self { corners_m, kinks: all(hints.kinks.len()), penumbrae: all(hints.penumbrae.len()), cuts: 0 }
    }

    /// Its corners in the frame of the hints.
    pub(super) fn flat(&self, hints: &Hints) -> Vec<DVec2> {
        self.corners_m.iter().map(|&p| hints.frame.to_2d(p)).collect()
    }

    /// Its parts in penumbrae.
    pub(super) fn in_penumbrae<'a>(&'a self, hints: &'a Hints) -> impl Iterator<Item = Vec<DVec2>> + 'a {
        let flat = self.flat(hints);
        let part = move |&number: &u32| clip::intersection(&hints.penumbrae[number as usize], &flat);
        self.penumbrae.iter().map(part).filter(|part| !part.is_empty())
    }

    /// Cuts the cell along the kink that does most in it, or across its longer extent where there is none.
    pub(super) fn cut(&self, hints: &Hints) -> Vec<Self> {
        let frame = &hints.frame;
        let area_m2 = polygon::area_m2(&self.corners_m);
        let mut best: Option<(f64, [Vec<DVec3>; 2])> = None;
        let mut crossing = SmallVec::new();
        for &number in &self.kinks {
            let kink = &hints.kinks[number as usize];
            let halves = self.halves(&plane_of(kink, frame));
            let least = halves.iter().map(|half| polygon::area_m2(half)).fold(f64::INFINITY, f64::min);
            if least < LEAST_SHARE * area_m2 {
                continue;
            }
            crossing.push(number);
            // The area that the kink cuts off stands for how much it spoils; many events on one line bend more.
            let gain = f64::from(kink.events) * least;
            if best.as_ref().is_none_or(|(most, _)| gain > *most) {
                best = Some((gain, halves));
            }
        }
        let halves = best.map_or_else(|| self.halves(&self.bisector(frame)), |(_, halves)| halves);
        let part = |corners_m| {
            let mut cell =
                Self { corners_m, kinks: crossing.clone(), penumbrae: self.penumbrae.clone(), cuts: self.cuts + 1 };
            let flat = cell.flat(hints);
            cell.penumbrae.retain(|number| !clip::intersection(&hints.penumbrae[*number as usize], &flat).is_empty());
            cell
        };
        halves.into_iter().filter(|corners_m| !corners_m.is_empty()).map(part).collect()
    }

    fn halves(&self, plane: &Plane) -> [Vec<DVec3>; 2] {
        [*plane, plane.flipped()].map(|side| clip::in_front_of(&self.corners_m, &side, 0.0))
    }

    /// The plane through the centroid across the longest extent.
    fn bisector(&self, frame: &PlaneFrame) -> Plane {
        let pairs = (0..self.corners_m.len()).flat_map(|i| (0..i).map(move |j| (i, j)));
        let longest = pairs
            .map(|(i, j)| self.corners_m[i] - self.corners_m[j])
            .fold(DVec3::ZERO, |most, d| if d.length_squared() > most.length_squared() { d } else { most });
        Plane::through(polygon::centroid(&self.corners_m), longest.try_normalize().unwrap_or(frame.u))
    }
}

/// The plane that stands on the receiver along a kink.
fn plane_of(kink: &Kink, frame: &PlaneFrame) -> Plane {
    let normal = kink.normal.x * frame.u + kink.normal.y * frame.v;
    Plane { normal, offset_m: normal.dot(frame.origin) + kink.offset_m }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn square() -> Vec<DVec3> {
        [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)].map(|(x, y)| DVec3::new(x, y, 0.0)).to_vec()
    }

    fn areas(cells: &[Cell]) -> Vec<f64> {
        cells.iter().map(|cell| polygon::area_m2(&cell.corners_m)).collect()
    }

    #[test]
    fn a_cell_is_cut_along_kinks_first_and_in_halves_then() {
        let frame =
            PlaneFrame { plane: Plane::through(DVec3::ZERO, DVec3::Z), origin: DVec3::ZERO, u: DVec3::X, v: DVec3::Y };
        let at = |x: f64| Kink { normal: DVec2::X, offset_m: x, events: 1 };
        let penumbra = [(0.5, 0.5), (2.0, 0.5), (2.0, 2.0)].map(DVec2::from).to_vec();
        let hints = Hints { frame, kinks: vec![at(0.25), at(7.0)], penumbrae: vec![penumbra] };
        let cells = Cell::whole(square(), &hints).cut(&hints);
        assert_eq!(areas(&cells), [0.75, 0.25]);
        assert_eq!([0, 1].map(|i| cells[i].in_penumbrae(&hints).count()), [1, 0]);
        let halves = cells[0].cut(&hints);
        assert_eq!(halves.len(), 2);
        assert!(areas(&halves).iter().all(|area| (area - 0.375).abs() < 1e-12), "{halves:?}");
    }
}
