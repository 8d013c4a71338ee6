//! From where the scene is seen, and how hands move that.
//!
//! Idea: an eye, the direction in which it looks (yaw about +Y, pitch up), and the distance of the point around which
//! it turns. Its right hand depends on yaw alone, so looking straight down or up is nothing special.
//!
//! Holds: pitch stays within a right angle, the distance within reach of the scene; the page of `umbrage page` moves in
//! the same way.

use std::f64::consts::{FRAC_PI_2, TAU};

use glam::DVec3;
use umbrage_picture::{Camera, fit};

/// How near and how far the point around which the view turns may be, as shares of the scene's size.
const NEAREST: f64 = 1e-4;
const FARTHEST: f64 = 100.0;

/// A direction is level with less than this share of it along the ground.
const LEVEL: f64 = 1e-6;

/// Where the eye is and where it looks.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Viewpoint {
    /// Where it stands, in metres.
    pub(crate) eye_m: DVec3,
    yaw_rad: f64,
    pitch_rad: f64,
    distance_m: f64,
    /// Field of view from the lower to the upper edge, in degrees.
    pub(crate) fov_y_deg: f64,
}

impl Viewpoint {
    /// As a camera sees it; what it turns around is where the camera's target is.
    pub(crate) fn new(camera: &Camera) -> Self {
        let mut view =
            Self { eye_m: camera.eye_m, yaw_rad: 0.0, pitch_rad: 0.0, distance_m: 1.0, fov_y_deg: camera.fov_y_deg };
        view.look_at(camera.target_m, camera.up);
        view
    }

    /// Turns to a point; `up` tells where a view straight down or up has its upper edge. A point in the eye itself
    /// changes nothing.
    pub(crate) fn look_at(&mut self, target_m: DVec3, up: DVec3) {
        let ahead = target_m - self.eye_m;
        let distance_m = ahead.length();
        if !(distance_m.is_finite() && distance_m > 0.0) {
            return;
        }
        let level = ahead.x.hypot(ahead.z);
        let heading = if level > LEVEL * distance_m { ahead } else { -ahead.y.signum() * up };
        self.yaw_rad = heading.x.atan2(-heading.z);
        self.pitch_rad = ahead.y.atan2(level);
        self.distance_m = distance_m;
    }

    /// Turns from now on around what is so far ahead, unless what it turns around is `known`.
    pub(crate) fn turn_around(&mut self, distance_m: f64, known: bool) {
        if !known && distance_m > 0.0 {
            self.distance_m = distance_m;
        }
    }

    fn right(&self) -> DVec3 {
        DVec3::new(self.yaw_rad.cos(), 0.0, self.yaw_rad.sin())
    }

    /// Where it looks: a unit vector.
    pub(crate) fn ahead(&self) -> DVec3 {
        let (sine, cosine) = self.yaw_rad.sin_cos();
        DVec3::new(sine * self.pitch_rad.cos(), self.pitch_rad.sin(), -cosine * self.pitch_rad.cos())
    }

    /// The point around which it turns, in metres.
    pub(crate) fn target_m(&self) -> DVec3 {
        self.eye_m + self.distance_m * self.ahead()
    }

    /// How far away that point is, in metres.
    pub(crate) fn distance_m(&self) -> f64 {
        self.distance_m
    }

    /// The camera.
    pub(crate) fn camera(&self) -> Camera {
        let up = self.right().cross(self.ahead());
        Camera { eye_m: self.eye_m, target_m: self.target_m(), up, fov_y_deg: self.fov_y_deg }
    }

    /// Turns on the spot.
    pub(crate) fn turn(&mut self, yaw_rad: f64, pitch_rad: f64) {
        self.yaw_rad = (self.yaw_rad + yaw_rad).rem_euclid(TAU);
        self.pitch_rad = (self.pitch_rad + pitch_rad).clamp(-FRAC_PI_2, FRAC_PI_2);
    }

    /// Turns around its point, which stays in the middle.
    pub(crate) fn orbit(&mut self, yaw_rad: f64, pitch_rad: f64) {
        let kept_m = self.target_m();
        self.turn(yaw_rad, pitch_rad);
        self.eye_m = kept_m - self.distance_m * self.ahead();
    }

    /// Moves by so many metres to the right, up and ahead.
    pub(crate) fn walk(&mut self, by_m: DVec3) {
        let (right, ahead) = (self.right(), self.ahead());
        self.eye_m += by_m.x * right + by_m.y * right.cross(ahead) + by_m.z * ahead;
    }

    /// Comes nearer to its point, by a factor below 1, or goes farther away from it, in a scene of `size_m`.
    pub(crate) fn approach(&mut self, factor: f64, size_m: f64) {
        let kept_m = self.target_m();
        self.distance_m = (self.distance_m * factor).clamp(NEAREST * size_m, FARTHEST * size_m);
        self.eye_m = kept_m - self.distance_m * self.ahead();
    }

    /// Goes back, or nearer, until a box just fits into a picture `aspect` times as wide as high.
    pub(crate) fn fit(&mut self, bounds_m: [DVec3; 2], aspect: f64) {
        let camera = fit(bounds_m, -self.ahead(), aspect, self.fov_y_deg);
        self.distance_m = camera.eye_m.distance(camera.target_m);
        self.eye_m = camera.target_m - self.distance_m * self.ahead();
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn near(p: DVec3, q: DVec3) -> bool {
        p.distance(q) < 1e-9 * (1.0 + q.length())
    }

    fn point(reach: f64) -> impl Strategy<Value = DVec3> {
        [-reach..reach, -reach..reach, -reach..reach].prop_map(DVec3::from_array)
    }

    #[test]
    fn north_is_ahead_and_east_to_the_right() {
        let mut view = Viewpoint::new(&Camera::looking(DVec3::ZERO, DVec3::NEG_Z, 40.0));
        view.turn(FRAC_PI_2, 0.0);
        assert!(near(view.ahead(), DVec3::X));
        view.walk(DVec3::new(1.0, 2.0, 3.0));
        assert!(near(view.eye_m, DVec3::new(3.0, 2.0, 1.0)), "{}", view.eye_m);
    }

    #[test]
    fn nobody_looks_over_his_head() {
        let mut view = Viewpoint::new(&Camera::looking(DVec3::ZERO, DVec3::NEG_Z, 40.0));
        view.turn(0.0, 9.0);
        assert!(near(view.ahead(), DVec3::Y));
        assert!(view.camera().frame().is_ok());
        assert!(near(view.camera().up, DVec3::Z));
    }

    #[test]
    fn a_view_straight_down_keeps_its_upper_edge() {
        let camera = Camera { up: DVec3::X, ..Camera::looking(DVec3::Y, DVec3::ZERO, 40.0) };
        let seen = Viewpoint::new(&camera).camera();
        assert!(near(seen.up, DVec3::X) && near(seen.target_m, DVec3::ZERO), "{seen:?}");
    }

    #[test]
    fn a_point_in_the_eye_changes_nothing() {
        let mut view = Viewpoint::new(&Camera::looking(DVec3::ONE, DVec3::ZERO, 40.0));
        let before = view;
        view.look_at(DVec3::ONE, DVec3::Y);
        view.look_at(DVec3::NAN, DVec3::Y);
        assert_eq!(view, before);
    }

    proptest! {
        #[test]
        fn an_upright_camera_is_seen_as_it_is(eye in point(9.0), target in point(9.0)) {
            prop_assume!((target - eye).truncate().length() > 1e-3 && (target - eye).x.hypot((target - eye).z) > 1e-3);
            let camera = Camera::looking(eye, target, 50.0);
            let seen = Viewpoint::new(&camera).camera();
            prop_assert!(near(seen.eye_m, eye) && near(seen.target_m, target), "{seen:?}");
            let [expected, got] = [camera, seen].map(|camera| camera.frame().unwrap());
            prop_assert!((0..3).all(|i| expected[i].distance(got[i]) < 1e-6), "{expected:?} {got:?}");
        }

        #[test]
        fn what_it_turns_around_stays(eye in point(9.0), turns in proptest::collection::vec((-3.0..3.0, -3.0..3.0, 0.5..2.0), 1..9)) {
            prop_assume!(eye.length() > 0.1);
            let mut view = Viewpoint::new(&Camera::looking(eye, DVec3::ZERO, 50.0));
            for (yaw, pitch, factor) in turns {
                view.orbit(yaw, pitch);
                view.approach(factor, 10.0);
                prop_assert!(view.target_m().length() < 1e-9 * 1e4, "{view:?}");
            }
        }

        #[test]
        fn what_is_fitted_is_seen_whole(eye in point(9.0), aspect in 0.3..3.0) {
            prop_assume!(eye.x.hypot(eye.z) > 0.1);
            let bounds = [DVec3::new(-1.0, 0.0, -2.0), DVec3::new(3.0, 2.0, 2.0)];
            let mut view = Viewpoint::new(&Camera::looking(eye, DVec3::ZERO, 50.0));
            view.fit(bounds, aspect);
            let [right, up, ahead] = view.camera().frame().unwrap();
            let slope = 25f64.to_radians().tan();
            for i in 0..8 {
                let [x, y, z] = [0, 1, 2].map(|bit| bounds[i >> bit & 1][bit]);
                let p = DVec3::new(x, y, z) - view.eye_m;
                prop_assert!(p.dot(right).abs() < slope * aspect * p.dot(ahead));
                prop_assert!(p.dot(up).abs() < slope * p.dot(ahead));
            }
        }
    }
}
