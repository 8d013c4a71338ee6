//! The camera where none is asked for.
//!
//! Idea: stand outside the scene where most of its light can be seen. Candidates are the six views along the axes and
//! the four from above a corner; each is moved back until the scene's box just fits, and drawn small. What counts is
//! the mean luminance of the small picture, with triangles seen from behind drawn black: a box that is open on one side
//! then is seen through that side, while looking in through a wall that is only invisible from behind counts for
//! nothing. A room that is closed all around shows nothing in this way; it is then looked into through such a wall.
//!
//! Holds: the whole box is in the picture; the choice depends on the meshes and the proportions of the picture only,
//! and of equally good candidates the first is taken.

use glam::DVec3;

use crate::camera::Camera;
use crate::color::luminance;
use crate::mesh::{PictureMesh, bounds_m};
use crate::render::{Backs, RenderError, RenderSettings, render_with_backs};

/// Rows of the small pictures.
const TRIAL_ROWS: usize = 48;
/// How much farther back than needed the camera stands.
const MARGIN: f64 = 1.03;
/// Where the eye may stand, as seen from the middle of the scene, and how much a view from there is worth: plans show
/// much light, but are seldom what one wants to see.
const CANDIDATES: [([f64; 3], f32); 10] = [
    ([0.0, 0.0, 1.0], 1.0),
    ([0.0, 0.0, -1.0], 1.0),
    ([1.0, 0.0, 0.0], 1.0),
    ([-1.0, 0.0, 0.0], 1.0),
    ([1.0, 0.9, 1.2], 1.0),
    ([-1.0, 0.9, 1.2], 1.0),
    ([1.0, 0.9, -1.2], 1.0),
    ([-1.0, 0.9, -1.2], 1.0),
    ([0.0, 1.0, 0.0], 0.4),
    ([0.0, -1.0, 0.0], 0.4),
];

/// A camera that shows `meshes` well in a picture of `width` times `height` pixels; nothing where there is no triangle.
///
/// # Errors
/// [`RenderError`] where the meshes cannot be drawn.
pub fn default_camera(
    meshes: &[PictureMesh],
    width: usize,
    height: usize,
    fov_y_deg: f64,
) -> Result<Option<Camera>, RenderError> {
    let Some(bounds) = bounds_m(meshes) else { return Ok(None) };
    let aspect = width as f64 / height as f64;
    let trial_columns = ((TRIAL_ROWS as f64 * aspect).round() as usize).clamp(1, 16 * TRIAL_ROWS);
    let settings =
        RenderSettings { width: trial_columns, height: TRIAL_ROWS, background: [0.0; 3], ..RenderSettings::default() };
    let cameras: Vec<Camera> =
        CANDIDATES.iter().map(|(from, _)| fit(bounds, DVec3::from(*from), aspect, fov_y_deg)).collect();
    let mut best = cameras[0];
    for backs in [Backs::Black, Backs::Hidden] {
        let mut most = 0.0;
        for (camera, (_, worth)) in cameras.iter().zip(CANDIDATES) {
            let picture = render_with_backs(meshes, &[], camera, &settings, backs)?;
            let seen = picture.pixels().iter().map(|&c| luminance(c)).sum::<f32>() / picture.pixels().len() as f32;
            // A hair more than the best so far: a symmetric scene does not turn with rounding.
            if worth * seen > most * 1.001 + 1e-6 {
                (most, best) = (worth * seen, *camera);
            }
        }
        if most > 0.0 {
            break;
        }
    }
    Ok(Some(best))
}

/// A camera in direction `from` of a box, just as far away as the box needs to be seen as a whole in a picture that is
/// `aspect` times as wide as high.
pub fn fit([low, high]: [DVec3; 2], from: DVec3, aspect: f64, fov_y_deg: f64) -> Camera {
    let (middle, from) = ((low + high) / 2.0, from.normalize());
    let frame = Camera::looking(middle + from, middle, fov_y_deg);
    let right = (-from).cross(frame.up).normalize();
    let up = right.cross(-from);
    let slope_y = (0.5 * fov_y_deg.to_radians()).tan();
    let slope_x = slope_y * aspect;
    let mut distance_m: f64 = 1e-3 * (high - low).length();
    for i in 0..8 {
        let pick = |bit: usize, low: f64, high: f64| if i >> bit & 1 == 0 { low } else { high };
        let corner = DVec3::new(pick(0, low.x, high.x), pick(1, low.y, high.y), pick(2, low.z, high.z)) - middle;
        let nearer = corner.dot(from);
        distance_m = distance_m
            .max(nearer + MARGIN * corner.dot(right).abs() / slope_x)
            .max(nearer + MARGIN * corner.dot(up).abs() / slope_y);
    }
    Camera { eye_m: middle + distance_m * from, ..frame }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::render::render;

    /// A box of 2 m whose sides look inwards, without the side in direction `open`.
    fn open_box(open: DVec3) -> PictureMesh {
        let mut mesh = PictureMesh::default();
        for side in [DVec3::X, DVec3::Y, DVec3::Z, DVec3::NEG_X, DVec3::NEG_Y, DVec3::NEG_Z] {
            if side == open {
                continue;
            }
            let u = side.any_orthonormal_vector();
            let v = u.cross(side);
            let first = mesh.positions_m.len() as u32;
            for (a, b) in [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)] {
                mesh.positions_m.push((side + a * u + b * v).to_array());
                mesh.colors.push([0.5; 3]);
            }
            mesh.triangles.extend([[first, first + 1, first + 2], [first, first + 2, first + 3]]);
        }
        mesh
    }

    #[test]
    fn a_box_is_seen_through_its_open_side() {
        for open in [DVec3::X, DVec3::Z, DVec3::NEG_X, DVec3::NEG_Z, DVec3::Y] {
            let camera = default_camera(&[open_box(open)], 100, 100, 40.0).unwrap().unwrap();
            assert!((camera.eye_m - camera.target_m).normalize().dot(open) > 0.5, "{open}: {camera:?}");
        }
    }

    #[test]
    fn a_closed_room_is_seen_through_a_wall() {
        let mesh = open_box(DVec3::ZERO);
        let camera = default_camera(std::slice::from_ref(&mesh), 100, 100, 40.0).unwrap().unwrap();
        let picture = render(&[mesh], &[], &camera, &RenderSettings::default()).unwrap();
        assert_eq!(picture.pixel(512, 512), [0.5; 3]);
    }

    #[test]
    fn the_box_fits_any_proportions() {
        let bounds = [DVec3::new(-1.0, 0.0, 2.0), DVec3::new(5.0, 1.0, 3.0)];
        for (from, _) in CANDIDATES {
            for (width, height) in [(100.0, 100.0), (300.0, 80.0), (70.0, 240.0)] {
                let lens = fit(bounds, from.into(), width / height, 40.0).lens(width, height).unwrap();
                let (mut low, mut high) = (glam::DVec2::MAX, glam::DVec2::MIN);
                for i in 0..8 {
                    let [x, y, z] = [0, 1, 2].map(|bit| bounds[i >> bit & 1][bit]);
                    let p = lens.project(lens.view_m(DVec3::new(x, y, z)));
                    (low, high) = (low.min(p), high.max(p));
                }
                assert!(low.min_element() > 0.0 && high.x < width && high.y < height, "{from:?} {low} {high}");
                let filled = (high - low) / glam::DVec2::new(width, height);
                assert!(filled.max_element() > 0.75, "{from:?} {filled}");
            }
        }
    }

    #[test]
    fn no_triangle_no_camera() {
        assert_eq!(default_camera(&[], 9, 9, 40.0), Ok(None));
    }

    #[test]
    fn a_black_scene_still_has_a_camera() {
        let mut mesh = open_box(DVec3::ZERO);
        mesh.colors.fill([0.0; 3]);
        assert!(default_camera(&[mesh], 9, 9, 40.0).unwrap().is_some());
    }
}
