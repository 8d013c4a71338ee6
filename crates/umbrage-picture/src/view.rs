//! The camera where none is asked for.
//!
//! Idea: of some candidates, the one that shows most of the scene's light. From outside these are four views from three quarters above, four
//! along the horizontal axes and the plan; each is moved back until all vertices just fit, and drawn small. What counts is
//! the mean luminance of what is drawn in the small picture, with triangles seen from behind drawn black: a box that is open on one side
//! then is seen through that side, while looking in through a wall that is only invisible from behind counts for
//! nothing. Three quarters above wins where others are not much better.
//!
//! A scene is an interior where a picture from inside shows several times the light of the best one from outside, and no more than a little of
//! what is around: it is then seen from inside. Where that fails too, it is looked into through a wall.
//!
//! Holds: from outside all vertices are in the picture; the choice depends on the meshes and the proportions of the picture only,
//! and of equally good candidates the first is taken.

use glam::{DVec2, DVec3};

use crate::camera::Camera;
use crate::color::luminance;
use crate::mesh::{PictureMesh, bounds_m};
use crate::render::{Backs, Look, RenderError, RenderSettings, render_with_backs};

/// Rows of the small pictures.
const TRIAL_ROWS: usize = 48;
/// How much farther back than needed the camera stands.
const MARGIN: f64 = 1.03;
/// Where the eye may stand outside, as seen from the middle of the scene, and how much a view from there is worth: plans and elevations
/// show much light, but are seldom what one wants to see.
const OUTSIDE: [([f64; 3], f32); 9] = [
    ([1.0, 1.0, 1.2], 1.0),
    ([-1.0, 1.0, 1.2], 1.0),
    ([1.0, 1.0, -1.2], 1.0),
    ([-1.0, 1.0, -1.2], 1.0),
    ([0.0, 0.0, 1.0], 0.8),
    ([0.0, 0.0, -1.0], 0.8),
    ([1.0, 0.0, 0.0], 0.8),
    ([-1.0, 0.0, 0.0], 0.8),
    ([0.0, 1.0, 0.0], 0.4),
];
/// Where the eye may stand inside, as shares of the extent in plan; it looks at the middle, from the middle along the axes.
const INSIDE: [f64; 3] = [0.15, 0.5, 0.85];
/// What a view from a corner, from beside a wall and from the middle is worth: the first shows most of a room, the last a wall.
const INSIDE_WORTH: [f32; 3] = [1.0, 0.6, 0.35];
/// How high the eye is inside and where it looks, as shares of the height: as a person in a room looks at what stands in it.
const EYE_HEIGHT: f64 = 0.6;
const LOOK_HEIGHT: f64 = 0.42;
/// A scene whose least extent is less than this share of its greatest has no inside.
const FLAT: f64 = 0.01;
/// Light that is brighter than this is a window or a lamp, and counts no more: white is 1.
const MOST_LIGHT: f32 = 0.5;
/// The field of view inside is at least this, in degrees: rooms are close.
const INSIDE_FOV_DEG: f64 = 60.0;
/// An interior shows from inside at least so many times the light that is seen from outside.
const INTERIOR: f32 = 2.5;
/// And leaves at most this share of the picture to what is around the scene.
const MOST_AROUND: f32 = 0.15;

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
    let outside: Vec<(Camera, f32)> = OUTSIDE
        .iter()
        .map(|(from, worth)| (fit_vertices(meshes, bounds, DVec3::from(*from), aspect, fov_y_deg), *worth))
        .collect();
    let trial = Trial::new(meshes, aspect);
    let from_outside = trial.best(&outside, Backs::Black, 1.0)?;
    let seen_outside = from_outside.map_or(0.0, |(seen, _)| seen);
    let from_inside = trial.best(&inside(bounds, fov_y_deg), Backs::Black, MOST_AROUND)?;
    let from_inside = from_inside.filter(|(seen, _)| *seen > INTERIOR * seen_outside);
    let found = match from_inside.or(from_outside) {
        None => trial.best(&outside, Backs::Hidden, 1.0)?,
        found => found,
    };
    Ok(found.map(|(_, camera)| camera).or(outside.first().map(|(camera, _)| *camera)))
}

/// Cameras inside of a box; none in one that is flat.
fn inside([low, high]: [DVec3; 2], fov_y_deg: f64) -> Vec<(Camera, f32)> {
    let size = high - low;
    if size.min_element() < FLAT * size.max_element() {
        return Vec::new();
    }
    let at = |x: f64, height: f64, z: f64| low + DVec3::new(x, height, z) * (high - low);
    let fov_y_deg = fov_y_deg.max(INSIDE_FOV_DEG);
    let mut all = Vec::new();
    for x in INSIDE {
        for z in INSIDE {
            let is_middle = DVec2::new(x, z) == DVec2::splat(0.5);
            let ahead: &[[f64; 2]] =
                if is_middle { &[[0.5, 0.0], [0.5, 1.0], [0.0, 0.5], [1.0, 0.5]] } else { &[[0.5, 0.5]] };
            let worth = INSIDE_WORTH[usize::from(x == 0.5) + usize::from(z == 0.5)];
            let look = |&[to_x, to_z]: &[f64; 2]| {
                Camera::looking(at(x, EYE_HEIGHT, z), at(to_x, LOOK_HEIGHT, to_z), fov_y_deg)
            };
            all.extend(ahead.iter().map(|to| (look(to), worth)));
        }
    }
    all
}

/// Small pictures of meshes.
struct Trial<'a> {
    meshes: &'a [PictureMesh],
    settings: RenderSettings,
}

impl<'a> Trial<'a> {
    fn new(meshes: &'a [PictureMesh], aspect: f64) -> Self {
        let width = ((TRIAL_ROWS as f64 * aspect).round() as usize).clamp(1, 16 * TRIAL_ROWS);
        // What shows no surface is no number.
        let settings =
            RenderSettings { width, height: TRIAL_ROWS, background: [f32::NAN; 3], look: Look::Raw { exposure: 1.0 } };
        Self { meshes, settings }
    }

    /// The camera that shows most light, and how much, of those that leave at most a share of the picture to what is around.
    fn best(
        &self,
        cameras: &[(Camera, f32)],
        backs: Backs,
        most_around: f32,
    ) -> Result<Option<(f32, Camera)>, RenderError> {
        let mut best: Option<(f32, Camera)> = None;
        for (camera, worth) in cameras {
            let picture = render_with_backs(self.meshes, &[], camera, &self.settings, backs)?;
            let count = picture.pixels().len() as f32;
            let all = picture.pixels().iter().map(|&c| luminance(c));
            let (mut sum, mut around) = (0.0, 0.0);
            all.for_each(|seen| if seen.is_nan() { around += 1.0 } else { sum += seen.min(MOST_LIGHT) });
            let seen = worth * sum / f32::max(count - around, 1.0);
            // A hair more than the best so far: a symmetric scene does not turn with rounding.
            let most = best.map_or(0.0, |(most, _)| most);
            if seen > most * 1.001 + 1e-6 && around <= most_around * count {
                best = Some((seen, *camera));
            }
        }
        Ok(best)
    }
}

/// A camera in direction `from` of a box, just as far away as the box needs to be seen as a whole in a picture that is
/// `aspect` times as wide as high.
pub fn fit([low, high]: [DVec3; 2], from: DVec3, aspect: f64, fov_y_deg: f64) -> Camera {
    let pick = |i: usize, bit: usize, low: f64, high: f64| if i >> bit & 1 == 0 { low } else { high };
    let corner = |i| DVec3::new(pick(i, 0, low.x, high.x), pick(i, 1, low.y, high.y), pick(i, 2, low.z, high.z));
    fit_points((0..8).map(corner), [low, high], from, aspect, fov_y_deg)
}

/// The same, as near as all vertices of meshes allow, whose box it is.
fn fit_vertices(meshes: &[PictureMesh], bounds: [DVec3; 2], from: DVec3, aspect: f64, fov_y_deg: f64) -> Camera {
    let shown = meshes.iter().flat_map(|mesh| {
        let corners = mesh.triangles.iter().flatten();
        corners.filter_map(|&vertex| mesh.positions_m.get(vertex as usize)).map(|&p| DVec3::from(p))
    });
    fit_points(shown, bounds, from, aspect, fov_y_deg)
}

fn fit_points(
    points: impl Iterator<Item = DVec3>,
    [low, high]: [DVec3; 2],
    from: DVec3,
    aspect: f64,
    fov_y_deg: f64,
) -> Camera {
    let (middle, from) = ((low + high) / 2.0, from.normalize());
    let frame = Camera::looking(middle + from, middle, fov_y_deg);
    let right = (-from).cross(frame.up).normalize();
    let up = right.cross(-from);
    let slope_y = (0.5 * fov_y_deg.to_radians()).tan();
    let slope_x = slope_y * aspect;
    let mut distance_m: f64 = 1e-3 * (high - low).length();
    for point in points {
        let corner = point - middle;
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
    fn a_closed_room_is_seen_from_inside() {
        let mesh = open_box(DVec3::ZERO);
        let camera = default_camera(std::slice::from_ref(&mesh), 100, 100, 40.0).unwrap().unwrap();
        assert!(camera.eye_m.abs().max_element() < 1.0, "{camera:?}");
        let picture = render(&[mesh], &[], &camera, &RenderSettings::default()).unwrap();
        assert!(picture.pixels().iter().all(|&pixel| pixel == [0.5; 3]), "the walls fill the picture");
    }

    #[test]
    fn a_thing_is_seen_from_three_quarters_above_and_fills_the_picture() {
        // A box of 2 m that looks outwards.
        let mut mesh = open_box(DVec3::ZERO);
        mesh.triangles.iter_mut().for_each(|triangle| triangle.swap(0, 1));
        let camera = default_camera(std::slice::from_ref(&mesh), 100, 100, 40.0).unwrap().unwrap();
        let from = (camera.eye_m - camera.target_m).normalize();
        assert!((0.3..0.8).contains(&from.y) && from.abs().min_element() > 0.3, "{from}");
        let lens = camera.lens(100.0, 100.0).unwrap();
        let places = mesh.positions_m.iter().map(|&p| lens.project(lens.view_m(DVec3::from(p))));
        let (low, high) = places.fold((DVec2::MAX, DVec2::MIN), |(low, high), p| (low.min(p), high.max(p)));
        assert!(
            low.min_element() >= 0.0 && high.max_element() <= 100.0 && (high - low).max_element() > 80.0,
            "{low} {high}"
        );
    }

    #[test]
    fn the_box_fits_any_proportions() {
        let bounds = [DVec3::new(-1.0, 0.0, 2.0), DVec3::new(5.0, 1.0, 3.0)];
        for (from, _) in OUTSIDE {
            for (width, height) in [(100.0, 100.0), (300.0, 80.0), (70.0, 240.0)] {
                let lens = fit(bounds, from.into(), width / height, 40.0).lens(width, height).unwrap();
                let (mut low, mut high) = (DVec2::MAX, DVec2::MIN);
                for i in 0..8 {
                    let [x, y, z] = [0, 1, 2].map(|bit| bounds[i >> bit & 1][bit]);
                    let p = lens.project(lens.view_m(DVec3::new(x, y, z)));
                    (low, high) = (low.min(p), high.max(p));
                }
                assert!(low.min_element() > 0.0 && high.x < width && high.y < height, "{from:?} {low} {high}");
                let filled = (high - low) / DVec2::new(width, height);
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
