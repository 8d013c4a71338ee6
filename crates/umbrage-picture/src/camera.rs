//! A pinhole camera, and where it throws a point.
//!
//! Idea: the camera is what a user says (eye, target, up, field of view); [`Lens`] is the same for a picture of given
//! size: an orthonormal frame and a focal length in samples. View space is x to the right, y up, z ahead, in metres.
//!
//! Holds: the frame of a lens is orthonormal to rounding; the target lies in the middle of the picture.

use glam::{DVec2, DVec3};

/// A perspective camera.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Camera {
    /// Where it stands, in metres.
    pub eye_m: DVec3,
    /// The point in the middle of the picture, in metres.
    pub target_m: DVec3,
    /// What is up in the picture; need not be at a right angle to the view.
    pub up: DVec3,
    /// Field of view from the lower to the upper edge of the picture, in degrees.
    pub fov_y_deg: f64,
}

/// A camera that sees nothing.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum CameraError {
    /// Eye or target is not finite, or they are the same point.
    #[error("the camera at {eye_m} looks at {target_m}: eye and target must be two finite points")]
    NoDirection {
        /// The eye.
        eye_m: DVec3,
        /// The target.
        target_m: DVec3,
    },
    /// Up is along the view.
    #[error("up is {0}, along the view: choose another")]
    UpAlongView(DVec3),
    /// The field of view is not between 0 and 180 degrees.
    #[error("a field of view of {0} degrees is not between 0.1 and 179")]
    FieldOfView(f64),
}

impl Camera {
    /// Field of view of a camera about which nothing else is said: that of a normal lens.
    pub const DEFAULT_FOV_DEG: f64 = 40.0;

    /// A camera at `eye_m` that looks at `target_m`, +Y up; a view along Y has -Z up where it looks down, else +Z.
    pub fn looking(eye_m: DVec3, target_m: DVec3, fov_y_deg: f64) -> Self {
        let ahead = (target_m - eye_m).normalize_or_zero();
        let up = if ahead.x.hypot(ahead.z) > 1e-6 { DVec3::Y } else { DVec3::Z * ahead.y };
        Self { eye_m, target_m, up, fov_y_deg }
    }

    /// What is to the right, up and ahead in its picture: an orthonormal frame.
    ///
    /// # Errors
    /// [`CameraError`] where it sees nothing.
    pub fn frame(&self) -> Result<[DVec3; 3], CameraError> {
        let Self { eye_m, target_m, up, fov_y_deg } = *self;
        let ahead = (target_m - eye_m).normalize_or_zero();
        if !(eye_m.is_finite() && target_m.is_finite() && ahead != DVec3::ZERO) {
            return Err(CameraError::NoDirection { eye_m, target_m });
        }
        let right = ahead.cross(up.normalize_or_zero());
        if !(right.is_finite() && right.length() > 1e-9) {
            return Err(CameraError::UpAlongView(up));
        }
        if !(0.1..=179.0).contains(&fov_y_deg) {
            return Err(CameraError::FieldOfView(fov_y_deg));
        }
        let right = right.normalize();
        Ok([right, right.cross(ahead), ahead])
    }

    /// The camera for a picture of `width` times `height` samples.
    pub(crate) fn lens(&self, width: f64, height: f64) -> Result<Lens, CameraError> {
        let [right, up, ahead] = self.frame()?;
        let focal = 0.5 * height / (0.5 * self.fov_y_deg.to_radians()).tan();
        Ok(Lens { eye_m: self.eye_m, right, up, ahead, focal, centre: DVec2::new(width, height) / 2.0 })
    }
}

/// A camera's frame, and its scale for a picture.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Lens {
    /// Where it stands, in metres.
    pub(crate) eye_m: DVec3,
    right: DVec3,
    up: DVec3,
    ahead: DVec3,
    /// Distance of the image plane, in samples.
    pub(crate) focal: f64,
    /// Middle of the picture, in samples.
    pub(crate) centre: DVec2,
}

impl Lens {
    /// A point in view space, in metres.
    pub(crate) fn view_m(&self, point_m: DVec3) -> DVec3 {
        let p = point_m - self.eye_m;
        DVec3::new(p.dot(self.right), p.dot(self.up), p.dot(self.ahead))
    }

    /// Where a point of view space with z > 0 falls, in samples from the picture's upper left corner.
    pub(crate) fn project(&self, view_m: DVec3) -> DVec2 {
        let scale = self.focal / view_m.z;
        DVec2::new(self.centre.x + scale * view_m.x, self.centre.y - scale * view_m.y)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn right_is_right_and_up_is_up() {
        let camera = Camera::looking(DVec3::new(0.0, 0.0, 5.0), DVec3::ZERO, 90.0);
        let lens = camera.lens(200.0, 100.0).unwrap();
        assert_eq!(lens.project(lens.view_m(DVec3::ZERO)), DVec2::new(100.0, 50.0));
        // At 90 degrees the upper edge is as far up as ahead.
        assert!(lens.project(lens.view_m(DVec3::new(0.0, 5.0, 0.0))).abs_diff_eq(DVec2::new(100.0, 0.0), 1e-9));
        assert!(lens.project(lens.view_m(DVec3::new(10.0, 0.0, 0.0))).abs_diff_eq(DVec2::new(200.0, 50.0), 1e-9));
    }

    #[test]
    fn a_view_down_has_an_up() {
        let camera = Camera::looking(DVec3::new(0.0, 5.0, 0.0), DVec3::ZERO, 40.0);
        let lens = camera.lens(100.0, 100.0).unwrap();
        let north = lens.project(lens.view_m(DVec3::NEG_Z));
        assert!(north.y < 50.0 && (north.x - 50.0).abs() < 1e-9, "{north}");
        assert!(Camera { up: DVec3::Y, ..camera }.lens(100.0, 100.0).is_err());
    }

    #[test]
    fn blind_cameras_are_refused() {
        let camera = Camera::looking(DVec3::ZERO, DVec3::ZERO, 40.0);
        assert!(matches!(camera.lens(9.0, 9.0), Err(CameraError::NoDirection { .. })));
        let camera = Camera::looking(DVec3::ZERO, DVec3::X, 180.0);
        assert_eq!(camera.lens(9.0, 9.0).unwrap_err(), CameraError::FieldOfView(180.0));
        let camera = Camera::looking(DVec3::new(f64::NAN, 0.0, 0.0), DVec3::X, 40.0);
        assert!(camera.lens(9.0, 9.0).is_err());
    }
}
