//! A camera as the shaders take it: the matrix from the scene to clip space, and the ray through a pixel.
//!
//! Idea: depth is reversed (1 at the near plane, 0 at the far one), so that a float's small numbers lie where depth is
//! crowded. Both planes come from the scene: the far one holds its whole box, the near one is as far away as the box
//! allows, and where the eye is in the box a small share of the far one.
//!
//! Holds: positions are relative to the scene's origin, and the eye is subtracted in `f64`, so that a scene far from
//! the world's origin does not tremble.

use glam::{DMat4, DVec3, DVec4};
use umbrage_picture::{Camera, CameraError};

/// The near plane is at least this share of the far one's distance away: 1 cm in a room of 10 m.
const NEAREST: f64 = 1e-3;
/// The near plane is this share of the distance to the scene's box away, where the eye is outside.
const BEFORE_BOX: f64 = 0.5;
/// The far plane is this much behind the farthest corner.
const BEHIND_BOX: f64 = 1.001;

/// A camera for a picture of given proportions.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Lens {
    /// Where it stands, relative to the scene's origin, in metres.
    pub(crate) eye_m: DVec3,
    /// To the right edge of the picture at distance 1 along the view.
    right: DVec3,
    /// To its upper edge.
    up: DVec3,
    ahead: DVec3,
    near_m: f64,
    far_m: f64,
}

impl Lens {
    /// The lens of `camera` for a picture `aspect` times as wide as high, of a scene with an origin, and a box relative
    /// to it.
    ///
    /// # Errors
    /// Where the camera sees nothing.
    pub(crate) fn new(
        camera: &Camera,
        aspect: f64,
        origin_m: DVec3,
        bounds_m: [DVec3; 2],
    ) -> Result<Self, CameraError> {
        let [right, up, ahead] = camera.frame()?;
        let slope = (0.5 * camera.fov_y_deg.to_radians()).tan();
        let eye_m = camera.eye_m - origin_m;
        let [near_m, far_m] = depths(eye_m, bounds_m);
        Ok(Self { eye_m, right: right * slope * aspect, up: up * slope, ahead, near_m, far_m })
    }

    /// The direction from the eye through a place of the picture: (-1, -1) is its lower left corner, (1, 1) the upper
    /// right one. Its length along the view is 1.
    pub(crate) fn ray(&self, x: f64, y: f64) -> DVec3 {
        self.ahead + x * self.right + y * self.up
    }

    /// Clip z is `scale` times the distance along the view plus `step`.
    fn depth(&self) -> [f64; 2] {
        let between = self.far_m - self.near_m;
        [-self.near_m / between, self.far_m * self.near_m / between]
    }

    /// From positions relative to the origin to clip space.
    fn clip_from_scene(&self) -> DMat4 {
        let [scale, step] = self.depth();
        let rows = [
            (self.right / self.right.length_squared(), 0.0),
            (self.up / self.up.length_squared(), 0.0),
            (self.ahead * scale, step),
            (self.ahead, 0.0),
        ];
        let rows = rows.map(|(row, step)| DVec4::from((row, step - row.dot(self.eye_m))));
        DMat4::from_cols_array_2d(&rows.map(|row| row.to_array())).transpose()
    }

    /// The fields of `view.wgsl`, as far as they are about the camera: all up to `ahead`.
    pub(crate) fn uniforms(&self) -> Vec<f32> {
        let [scale, step] = self.depth();
        let mut words: Vec<f64> = self.clip_from_scene().to_cols_array().into();
        for (vector, word) in
            [(self.eye_m, scale), (self.right, step), (self.up, self.near_m)].map(|(v, w)| (v.to_array(), w))
        {
            words.extend(vector);
            words.push(word);
        }
        words.extend(self.ahead.to_array());
        words.into_iter().map(|word| word as f32).collect()
    }
}

/// Distances of the near and the far plane from an eye, in metres.
fn depths(eye_m: DVec3, [low_m, high_m]: [DVec3; 2]) -> [f64; 2] {
    let farthest = (low_m - eye_m).abs().max((high_m - eye_m).abs()).length();
    let nearest = (low_m - eye_m).max(eye_m - high_m).max(DVec3::ZERO).length();
    let far = if farthest > 0.0 { BEHIND_BOX * farthest } else { 1.0 };
    [(BEFORE_BOX * nearest).max(NEAREST * far), far]
}

#[cfg(test)]
mod tests {
    use super::*;

    const BOX: [DVec3; 2] = [DVec3::new(-2.0, 0.0, -3.0), DVec3::new(2.0, 3.0, 3.0)];

    fn lens(eye: DVec3, target: DVec3) -> Lens {
        Lens::new(&Camera::looking(eye, target, 90.0), 2.0, DVec3::ZERO, BOX).unwrap()
    }

    fn clip(lens: &Lens, p: DVec3) -> DVec3 {
        lens.clip_from_scene().project_point3(p)
    }

    #[test]
    fn the_target_is_in_the_middle_and_edges_are_at_one() {
        let lens = lens(DVec3::new(0.0, 1.0, 8.0), DVec3::new(0.0, 1.0, 0.0));
        assert!(clip(&lens, DVec3::new(0.0, 1.0, 0.0)).truncate().length() < 1e-12);
        // At 90 degrees the upper edge is as far up as ahead, and the right one twice as far.
        let corner = clip(&lens, DVec3::new(16.0, 9.0, 0.0));
        assert!(corner.truncate().abs_diff_eq(glam::DVec2::ONE, 1e-12), "{corner}");
    }

    #[test]
    fn the_whole_box_is_between_the_planes_and_nearer_is_greater() {
        for eye in [DVec3::new(0.5, 1.0, 0.0), DVec3::new(9.0, 40.0, 8.0), DVec3::new(0.0, 1.0, 3.0)] {
            let lens = lens(eye, DVec3::new(0.0, 1.2, -1.0));
            let mut seen = Vec::new();
            for i in 0..8 {
                let [x, y, z] = [0, 1, 2].map(|bit| BOX[i >> bit & 1][bit]);
                let p = DVec3::new(x, y, z);
                let ahead = (p - eye).dot(lens.ahead);
                if ahead > lens.near_m {
                    seen.push((ahead, clip(&lens, p).z));
                }
            }
            seen.sort_by(|x, y| x.0.total_cmp(&y.0));
            assert!(seen.iter().all(|&(_, z)| (0.0..=1.0).contains(&z)), "{seen:?}");
            assert!(seen.windows(2).all(|pair| pair[0].1 >= pair[1].1 - 1e-12), "{seen:?}");
        }
    }

    #[test]
    fn the_ray_through_a_place_leads_to_what_is_there() {
        let lens = lens(DVec3::new(5.0, 4.0, 6.0), DVec3::new(0.0, 1.0, 0.0));
        for p in [DVec3::new(1.0, 2.0, -1.0), DVec3::new(-2.0, 0.0, 2.0)] {
            let at = clip(&lens, p);
            let ray = lens.ray(at.x, at.y);
            assert!((p - lens.eye_m).cross(ray).length() < 1e-9, "{p}");
            assert!((ray.dot(lens.ahead) - 1.0).abs() < 1e-12);
        }
    }

    #[test]
    fn depth_is_the_line_that_the_shader_continues() {
        let lens = lens(DVec3::new(5.0, 4.0, 6.0), DVec3::new(0.0, 1.0, 0.0));
        let [scale, step] = lens.depth();
        let p = DVec3::new(1.0, 2.0, -1.0);
        let w = (p - lens.eye_m).dot(lens.ahead);
        assert!((clip(&lens, p).z - (scale * w + step) / w).abs() < 1e-12);
        assert_eq!(lens.uniforms().len(), 31);
    }
}
