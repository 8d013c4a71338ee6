//! What leaves err, told anew from round to round where it changed.
//!
//! Shown values are shifted by the mean bulge of the elements around them ([`super::element`]). So what a leaf errs changes a little
//! with its neighbours' elements, too: between two rounds that tell all, only what changed itself is told.

use rayon::prelude::*;

use super::element::Element;
use super::field::Values;
use super::refine::Interpolation;
use crate::id::PatchId;
use crate::scene::Rgb;

/// Light brighter than so many times the mean errs relative to itself: where it is so bright, it is white in any picture.
const GLARING_OF_MEAN: f64 = 100.0;

/// What leaves err.
#[derive(Debug)]
pub(super) struct Errors {
    interpolation: Interpolation,
    /// Light brighter than this errs relative to itself, in W/m2.
    glaring: f64,
    /// Integral of the squared error over each patch that was looked at, by its number, in W2/m2.
    squared: Vec<f64>,
    /// Around each value, the bulges of elements times their area, and their area.
    bulges: Vec<(Rgb, f64)>,
    shifts: Vec<Rgb>,
    /// Values around which elements changed.
    changed: Vec<u32>,
    triangles: usize,
}

impl Errors {
    /// Of nothing yet.
    pub(super) fn new(interpolation: Interpolation, mean: f64) -> Self {
        let glaring = GLARING_OF_MEAN * mean;
        let (squared, bulges, shifts, changed) = (Vec::new(), Vec::new(), Vec::new(), Vec::new());
        Self { interpolation, glaring, squared, bulges, shifts, changed, triangles: 0 }
    }

    /// Takes elements in the place of others.
    pub(super) fn replace(&mut self, before: &[Element], elements: &[Element]) {
        self.triangles = self.triangles + elements.len() - before.len();
        self.add(before, -1.0);
        self.add(elements, 1.0);
    }

    fn add(&mut self, elements: &[Element], sign: f64) {
        if self.interpolation == Interpolation::Quadratic {
            return;
        }
        for element in elements {
            let (bulge, area_m2) = (element.bulge(), sign * element.area_m2);
            for corner in element.corners() {
                if self.bulges.len() <= corner as usize {
                    self.bulges.resize(corner as usize + 1, (Rgb::ZERO, 0.0));
                }
                let (sum, around_m2) = &mut self.bulges[corner as usize];
                (*sum, *around_m2) = (*sum + area_m2 * bulge, *around_m2 + area_m2);
                self.changed.push(corner);
            }
        }
    }

    /// Tells what all leaves err.
    pub(super) fn tell_all(&mut self, leaves: &[PatchId], elements: &[Vec<Element>], values: &Values) {
        // From the beginning, so that no rounding is left of what was taken away.
        self.bulges.clear();
        leaves.iter().for_each(|leaf| self.add(&elements[leaf.index()], 1.0));
        self.tell(leaves, elements, values);
    }

    /// Tells what some leaves err: those whose elements changed.
    pub(super) fn tell(&mut self, leaves: &[PatchId], elements: &[Vec<Element>], values: &Values) {
        self.squared.resize(elements.len(), 0.0);
        if self.interpolation == Interpolation::Linear {
            let count = values.as_slice().len();
            self.bulges.resize(count, (Rgb::ZERO, 0.0));
            self.shifts.resize(count, Rgb::ZERO);
            for &number in &self.changed {
                let ((sum, area_m2), value) = (self.bulges[number as usize], values.as_slice()[number as usize]);
                let mean = if area_m2 > 0.0 { sum / area_m2 } else { Rgb::ZERO };
                // At most the value itself: what is dark stays dark, and nothing next to darkness is raised.
                self.shifts[number as usize] = mean.clamp(-value, value);
            }
            self.changed.clear();
        }
        let integral = |leaf: &PatchId| {
            let of = |element: &Element| {
                // Next to a lamp light grows without bound: what it errs there in W/m2 would be all that counts.
                let own = element.corners().iter().map(|&corner| values.as_slice()[corner as usize]).sum::<Rgb>();
                let counts =
                    if self.glaring > 0.0 { self.glaring / (own.element_sum() / 9.0).max(self.glaring) } else { 1.0 };
                counts * counts * element.area_m2 * self.of(element).element_sum() / 3.0
            };
            elements[leaf.index()].iter().map(of).sum::<f64>()
        };
        let told: Vec<f64> = leaves.par_iter().map(integral).collect();
        for (leaf, squared) in leaves.iter().zip(told) {
            self.squared[leaf.index()] = squared;
        }
    }

    /// Mean square of what interpolation errs over an element, per colour.
    pub(super) fn of(&self, element: &Element) -> Rgb {
        match self.interpolation {
            Interpolation::Linear => element.linear_error_squared(&self.shifts),
            Interpolation::Quadratic => element.quadratic_error_squared(),
        }
    }

    /// The leaves, and what each errs.
    pub(super) fn of_leaves(&self, leaves: &[PatchId]) -> Vec<(PatchId, f64)> {
        leaves.iter().map(|&leaf| (leaf, self.squared[leaf.index()])).collect()
    }

    /// What they err together.
    pub(super) fn total(&self, leaves: &[PatchId]) -> f64 {
        leaves.iter().map(|leaf| self.squared[leaf.index()]).sum()
    }

    /// Number of elements.
    pub(super) fn triangles(&self) -> usize {
        self.triangles
    }

    /// What each value is shifted by to be shown, for linear interpolation.
    pub(super) fn into_shifts(self) -> Vec<Rgb> {
        self.shifts
    }
}
