//! Screens: faces that hide whole boxes of others from a point.
//!
//! From inside a room nothing of the next one is seen, and a few faces tell it for all that is behind them: a box that lies wholly
//! in the pyramid from the point over a convex face, and behind its plane, is hidden (Coorg and Teller, *Real-time occlusion culling
//! for models with large occluders*, 1997). Which faces are worth a look is found on the way: those that stopped a ray.
//!
//! Holds: what is hidden is hidden from rays and beams, too; so what is asked for does not depend on the screens that are known.

use std::f64::consts::PI;

use glam::DVec3;
use smallvec::SmallVec;

use super::{ReceiverPoint, Visibility};
use crate::id::FaceId;

/// Of more screens the ones that hid something last are kept.
const MOST_SCREENS: usize = 8;
/// A face that fills less than this share of the view hides little.
const LEAST_OF_VIEW: f64 = 0.01;
/// A box lies inside a pyramid by this share of its distance at least: far above rounding.
const INSIDE: f64 = 1e-9;

/// The faces that are known to hide something from a point, the one that did last first.
#[derive(Debug)]
pub struct Screens<'a> {
    visibility: &'a Visibility,
    receiver: &'a ReceiverPoint,
    screens: SmallVec<[Screen; MOST_SCREENS]>,
}

/// A face as seen from a point.
#[derive(Clone, Debug)]
struct Screen {
    face: FaceId,
    /// Inward normals of the pyramid's sides, which pass through the point, and that of the face, away from it, all of unit length.
    sides: SmallVec<[DVec3; 5]>,
    /// Distance of the point from the face's plane, in metres.
    distance_m: f64,
}

impl Screen {
    /// `None` where the face fills little of the view.
    fn new(boundary_m: &[DVec3], face: FaceId, from_m: DVec3) -> Option<Self> {
        let count = boundary_m.len();
        let to = |i: usize| boundary_m[i % count] - from_m;
        let doubled_m2: DVec3 = (1..count - 1).map(|i| (to(i) - to(0)).cross(to(i + 1) - to(0))).sum();
        let turn = doubled_m2.dot(to(0)).signum();
        let away = turn * doubled_m2.try_normalize()?;
        let distance_m = away.dot(to(0));
        let middle_m: DVec3 = (0..count).map(to).sum::<DVec3>() / count as f64;
        let of_view = 0.5 * doubled_m2.length() * distance_m / middle_m.length().powi(3) / (2.0 * PI);
        if of_view < LEAST_OF_VIEW {
            return None;
        }
        let mut sides: SmallVec<[DVec3; 5]> = SmallVec::new();
        sides.push(away);
        for i in 0..count {
            sides.push((turn * to(i).cross(to(i + 1))).try_normalize()?);
        }
        Some(Self { face, sides, distance_m })
    }

    /// Whether a box, given by its middle as seen from the point and half its size, is hidden.
    fn hides(&self, along_m: DVec3, half_m: DVec3) -> bool {
        let slack_m = INSIDE * (along_m.abs() + half_m).max_element();
        let over = |side: &DVec3| side.dot(along_m) - side.abs().dot(half_m) - slack_m;
        over(&self.sides[0]) > self.distance_m && self.sides[1..].iter().all(|side| over(side) > 0.0)
    }
}

impl<'a> Screens<'a> {
    /// No screens are known of a point yet.
    pub fn new(visibility: &'a Visibility, receiver: &'a ReceiverPoint) -> Self {
        Self { visibility, receiver, screens: SmallVec::new() }
    }

    /// Whether a box is hidden by one that is known.
    pub fn hide(&mut self, middle_m: DVec3, half_m: DVec3) -> bool {
        let along_m = middle_m - self.receiver.position_m;
        let found = self.screens.iter().position(|screen| screen.hides(along_m, half_m));
        if let Some(number) = found {
            self.screens[..=number].rotate_right(1);
        }
        found.is_some()
    }

    /// Notes a face that stopped a ray.
    pub fn note(&mut self, face: FaceId) {
        // What a point of a smooth surface sees from another place hides other things.
        if self.screens.iter().any(|screen| screen.face == face) || self.visibility.is_near(self.receiver, face) {
            return;
        }
        let screen = Screen::new(self.visibility.boundary_m(face), face, self.receiver.position_m);
        let Some(screen) = screen.filter(|_| self.visibility.plane(face) != self.receiver.plane) else { return };
        if self.screens.len() == MOST_SCREENS {
            self.screens.pop();
        }
        self.screens.insert(0, screen);
    }
}

#[cfg(test)]
mod tests {
    use super::super::fixture;
    use super::*;
    use proptest::prelude::*;
    use std::f64::consts::TAU;

    proptest! {
        #[test]
        fn what_is_hidden_is_what_no_ray_reaches(
            from in (-1.0..1.0, -1.0..1.0), middle in (-2.0..2.0, -2.0..2.0, 0.3..4.0),
            half in (0.01..0.5, 0.01..0.5, 0.01..0.5), turn in 0.0..6.3_f64, corners in 3..7_usize,
        ) {
            let corner = |i: usize| {
                let (sine, cosine) = (turn + TAU * i as f64 / corners as f64).sin_cos();
                fixture::f32_point(DVec3::new(cosine, sine, 1.0))
            };
            let plate: Vec<DVec3> = (0..corners).map(corner).collect();
            let prepared = fixture::prepared(&[fixture::square(DVec3::ZERO, 1.0, true), plate]);
            let index = Visibility::new(&prepared);
            let receiver = ReceiverPoint::on_face(&prepared, FaceId::from(0), DVec3::new(from.0, from.1, 0.0));
            let (middle, half) = (DVec3::from(middle), DVec3::from(half));
            let mut screens = Screens::new(&index, &receiver);
            prop_assert!(!screens.hide(middle, half), "nothing is known yet");
            screens.note(FaceId::from(1));
            // No ray reaches a corner of the box, a little smaller or larger.
            let is_dark = |grown: f64| {
                [-1.0, 1.0].iter().all(|x| [-1.0, 1.0].iter().all(|y| [-1.0, 1.0].iter().all(|z| {
                    let to_m = middle + grown * half * DVec3::new(*x, *y, *z);
                    index.blocker(None, receiver.position_m, to_m, [receiver.plane; 2]).is_some()
                })))
            };
            let hides = screens.hide(middle, half);
            prop_assert!(!hides || is_dark(1.0 - 1e-6));
            prop_assert!(hides || screens.screens.is_empty() || !is_dark(1.0 + 1e-6));
        }
    }

    #[test]
    fn of_many_screens_those_of_use_are_kept() {
        let plates = (0..20).map(|i| fixture::square(DVec3::new(3.0 * f64::from(i), 0.0, 1.0), 1.0, false));
        let floor = fixture::square(DVec3::ZERO, 100.0, true);
        let prepared = fixture::prepared(&std::iter::once(floor).chain(plates).collect::<Vec<_>>());
        let index = Visibility::new(&prepared);
        let receiver = ReceiverPoint::on_face(&prepared, FaceId::from(0), DVec3::ZERO);
        let mut screens = Screens::new(&index, &receiver);
        let above = DVec3::new(0.0, 0.0, 2.0);
        for plate in 1..=20 {
            screens.note(FaceId::from(plate));
            assert!(screens.hide(above, DVec3::splat(0.1)), "{plate}");
        }
        assert!(!screens.hide(above, DVec3::splat(3.0)) && !screens.hide(above.with_z(0.5), DVec3::splat(0.1)));
    }
}
