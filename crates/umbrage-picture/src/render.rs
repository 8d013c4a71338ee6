//! The rasteriser from end to end: meshes, lines and a camera in, a picture out.
//!
//! Idea: project everything once, sort it into bands of pixel rows, make the bands in parallel, put them together in
//! order.
//!
//! Holds: the same picture, to the bit, with any number of threads; triangles are drawn in the order given, and of two
//! at the same depth the first one stays.

use glam::DVec3;
use rayon::prelude::*;

use crate::band::{Band, Paint, SUPERSAMPLING, ScreenLines};
use crate::camera::{Camera, CameraError};
use crate::color::{BACKGROUND, LinearRgb, SEQUENTIAL, Tone, displayed, luminance, on_scale};
use crate::line::LineSet;
use crate::mesh::{MeshError, PictureMesh, bounds_m};
use crate::picture::Picture;
use crate::project::{Frustum, SNAP, ScreenTriangle};

/// Largest width and height of a picture, in pixels.
pub const MAX_SIZE_PX: usize = 16384;
/// Pixel rows of a band.
const BAND_ROWS: usize = 32;
/// Distance of the near plane, as a share of the distance of the farthest point.
const NEAR: f64 = 1e-5;

/// What becomes of the colour of a surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Look {
    /// It is displayed.
    Display {
        /// What it is multiplied with first.
        exposure: f32,
        /// The curve that it then goes through.
        tone: Tone,
    },
    /// It is a quantity, whose luminance is shown on a scale of false colours.
    FalseColor {
        /// The quantity at the end of the scale; it begins at 0.
        end: f32,
    },
    /// It stays what it is, also above 1: for files of light, and for pictures to compute with.
    Raw {
        /// What it is multiplied with.
        exposure: f32,
    },
}

impl Look {
    /// A colour as it looks.
    pub(crate) fn of(self, color: LinearRgb) -> LinearRgb {
        match self {
            Self::Display { exposure, tone } => displayed(color, exposure, tone),
            Self::FalseColor { end } => on_scale(&SEQUENTIAL, luminance(color) / end),
            Self::Raw { exposure } => color.map(|c| c * exposure),
        }
    }
}

/// What a picture is made like.
#[derive(Clone, Debug, PartialEq)]
pub struct RenderSettings {
    /// Width in pixels.
    pub width: usize,
    /// Height in pixels.
    pub height: usize,
    /// What becomes of the meshes' colours.
    pub look: Look,
    /// Colour where nothing is seen, linear; the look leaves it alone.
    pub background: LinearRgb,
}

impl Default for RenderSettings {
    fn default() -> Self {
        let look = Look::Display { exposure: 1.0, tone: Tone::Off };
        Self { width: 1024, height: 1024, look, background: BACKGROUND }
    }
}

/// Why no picture can be made.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum RenderError {
    /// The size is none.
    #[error("a picture of {width} x {height} pixels: each side must be between 1 and {MAX_SIZE_PX}")]
    BadSize {
        /// Asked width, in pixels.
        width: usize,
        /// Asked height, in pixels.
        height: usize,
    },
    /// The exposure is negative or not a number.
    #[error("an exposure of {0}: it must be a finite number that is not negative")]
    BadExposure(f32),
    /// The scale of false colours has no end.
    #[error("a scale of false colours that ends at {0}: it must end at a finite number above 0")]
    BadScale(f32),
    /// The camera sees nothing.
    #[error(transparent)]
    Camera(#[from] CameraError),
    /// A mesh cannot be drawn.
    #[error("mesh {index} cannot be drawn")]
    Mesh {
        /// Number of the mesh.
        index: usize,
        /// What is wrong with it.
        source: MeshError,
    },
    /// There are more sets of lines than can be told apart.
    #[error("{0} sets of lines, and at most 255 can be drawn")]
    TooManyLineSets(usize),
}

/// What becomes of a triangle that shows its back.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Backs {
    /// It cannot be seen, as in every renderer of single-sided materials.
    Hidden,
    /// It is black, and hides what is behind it.
    Black,
}

/// Draws `meshes`, and over them `line_sets`, as `camera` sees them.
///
/// # Errors
/// [`RenderError`] where settings, camera or meshes make no picture.
pub fn render(
    meshes: &[PictureMesh],
    line_sets: &[LineSet],
    camera: &Camera,
    settings: &RenderSettings,
) -> Result<Picture, RenderError> {
    render_with_backs(meshes, line_sets, camera, settings, Backs::Hidden)
}

pub(crate) fn render_with_backs(
    meshes: &[PictureMesh],
    line_sets: &[LineSet],
    camera: &Camera,
    settings: &RenderSettings,
    backs: Backs,
) -> Result<Picture, RenderError> {
    let &RenderSettings { width, height, look, background } = settings;
    check(meshes, line_sets, settings)?;
    let samples = SUPERSAMPLING as f64;
    let lens = camera.lens(width as f64 * samples, height as f64 * samples)?;
    let frustum = Frustum::new(lens, near_m(meshes, camera.eye_m));
    let triangles = screen_triangles(meshes, &frustum, backs);
    let paint = |mesh: u32| -> Paint<'_> {
        let mesh = &meshes[mesh as usize];
        Paint {
            texture: mesh.texture.as_deref(),
            mask: mesh.mask.as_ref().map(|(texture, cutoff)| (&**texture, *cutoff)),
        }
    };
    let lines = screen_lines(line_sets, &frustum, camera.eye_m);

    // A line looks at depths up to its radius and one sample beside its samples.
    let radius = lines.iter().map(|set| set.radius).fold(0.0, f64::max);
    let margin = radius.ceil() as i64 + 2;
    let height_samples = (height * SUPERSAMPLING) as i64;
    let bands: Vec<(usize, [i64; 2])> = (0..height)
        .step_by(BAND_ROWS)
        .map(|top| {
            let end = (top + BAND_ROWS).min(height);
            let [first, last] = [top, end].map(|row| (row * SUPERSAMPLING) as i64);
            (top, [(first - margin).max(0), (last + margin).min(height_samples)])
        })
        .collect();
    let triangles_of_band = sort_into_bands(&triangles, &bands);

    let pixels = bands
        .par_iter()
        .zip(&triangles_of_band)
        .flat_map_iter(|(&(top, rows), own)| {
            let mut band = Band::new(width * SUPERSAMPLING, rows);
            for &number in own {
                let (mesh, triangle) = &triangles[number as usize];
                band.draw_triangle(triangle, paint(*mesh));
            }
            // `check` lets at most 255 sets pass.
            lines.iter().enumerate().for_each(|(set, lines)| band.draw_lines(set as u8, lines));
            let end = (top + BAND_ROWS).min(height);
            let mut pixels = Vec::with_capacity((end - top) * width);
            for row in top..end {
                pixels.extend((0..width).map(|column| band.pixel(column, row, look, background, &lines)));
            }
            pixels
        })
        .collect();
    Ok(Picture { width, height, pixels })
}

fn check(meshes: &[PictureMesh], line_sets: &[LineSet], settings: &RenderSettings) -> Result<(), RenderError> {
    let &RenderSettings { width, height, look, .. } = settings;
    let fits = |side: usize| (1..=MAX_SIZE_PX).contains(&side);
    if !(fits(width) && fits(height)) {
        return Err(RenderError::BadSize { width, height });
    }
    match look {
        Look::Display { exposure, .. } | Look::Raw { exposure } if !(exposure.is_finite() && exposure >= 0.0) => {
            return Err(RenderError::BadExposure(exposure));
        }
        Look::FalseColor { end } if !(end.is_finite() && end > 0.0) => return Err(RenderError::BadScale(end)),
        _ => {}
    }
    if line_sets.len() > usize::from(u8::MAX) {
        return Err(RenderError::TooManyLineSets(line_sets.len()));
    }
    for (index, mesh) in meshes.iter().enumerate() {
        mesh.validate().map_err(|source| RenderError::Mesh { index, source })?;
    }
    Ok(())
}

/// Distance of the near plane from an eye, in metres.
fn near_m(meshes: &[PictureMesh], eye_m: DVec3) -> f64 {
    let farthest_m = bounds_m(meshes).map_or(0.0, |[low, high]| (low - eye_m).abs().max((high - eye_m).abs()).length());
    if farthest_m > 0.0 { NEAR * farthest_m } else { 1.0 }
}

/// The triangles on the grid, each with the number of its mesh.
fn screen_triangles(meshes: &[PictureMesh], frustum: &Frustum, backs: Backs) -> Vec<(u32, ScreenTriangle)> {
    meshes
        .par_iter()
        .enumerate()
        .flat_map(|(number, mesh)| {
            mesh.triangles.par_iter().flat_map_iter(move |&[a, b, c]| {
                let corners = |t: [u32; 3]| t.map(|i| DVec3::from(mesh.positions_m[i as usize]));
                let colors = [a, b, c].map(|i| mesh.colors[i as usize]);
                let uvs = [a, b, c].map(|i| {
                    if mesh.texture.is_some() || mesh.mask.is_some() { mesh.uvs[i as usize] } else { [0.0; 2] }
                });
                let mut parts = frustum.triangle(corners([a, b, c]), colors, uvs);
                if backs == Backs::Black {
                    parts.extend(frustum.triangle(corners([a, c, b]), [[0.0; 3]; 3], uvs));
                }
                parts.into_iter().map(move |part| (number as u32, part))
            })
        })
        .collect()
}

fn screen_lines(line_sets: &[LineSet], frustum: &Frustum, eye_m: DVec3) -> Vec<ScreenLines> {
    line_sets
        .iter()
        .map(|set| {
            let seen = set.lines.iter().filter(|line| line.faces(eye_m));
            ScreenLines {
                radius: 0.5 * set.width_px * SUPERSAMPLING as f64,
                color: set.color,
                opacity: set.opacity,
                lines: seen.filter_map(|line| frustum.line(line.ends_m.map(DVec3::from))).collect(),
            }
        })
        .collect()
}

/// The numbers of the triangles that can touch each band, in their order.
fn sort_into_bands(triangles: &[(u32, ScreenTriangle)], bands: &[(usize, [i64; 2])]) -> Vec<Vec<u32>> {
    let mut of_band = vec![Vec::new(); bands.len()];
    for (number, (_, triangle)) in triangles.iter().enumerate() {
        let ys = triangle.map(|corner| corner.y.div_euclid(SNAP));
        let (low, high) = (ys[0].min(ys[1]).min(ys[2]), ys[0].max(ys[1]).max(ys[2]));
        let first = bands.partition_point(|(_, rows)| rows[1] <= low);
        for (own, (_, rows)) in of_band.iter_mut().zip(bands).skip(first) {
            if rows[0] > high {
                break;
            }
            own.push(number as u32);
        }
    }
    of_band
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use super::*;
    use crate::color::linear_from_srgb;
    use crate::line::{Line, LineColor, wireframe};
    use crate::texture::{Texture, Wrap};

    fn plain(width: usize, height: usize) -> RenderSettings {
        RenderSettings { width, height, background: [0.0; 3], ..RenderSettings::default() }
    }

    fn display(exposure: f32) -> Look {
        Look::Display { exposure, tone: Tone::Off }
    }

    fn square(z: f64, half: f64, color: LinearRgb) -> PictureMesh {
        PictureMesh {
            positions_m: vec![[-half, -half, z], [half, -half, z], [half, half, z], [-half, half, z]],
            colors: vec![color; 4],
            triangles: vec![[0, 1, 2], [0, 2, 3]],
            ..PictureMesh::default()
        }
    }

    fn camera() -> Camera {
        Camera::looking(DVec3::ZERO, DVec3::NEG_Z, 90.0)
    }

    #[test]
    fn the_middle_of_a_triangle_has_the_mean_of_its_colors() {
        let mesh = PictureMesh {
            positions_m: vec![[-1.0, -1.0, -1.0], [2.0, -1.0, -1.0], [-1.0, 2.0, -1.0]],
            colors: vec![[0.9, 0.0, 0.0], [0.0, 0.6, 0.0], [0.0, 0.0, 0.3]],
            triangles: vec![[0, 1, 2]],
            ..PictureMesh::default()
        };
        // An odd size: the middle pixel is centred on the view's axis, where the centroid is.
        let picture = render(&[mesh], &[], &camera(), &plain(101, 101)).unwrap();
        for (seen, expected) in picture.pixel(50, 50).iter().zip([0.3, 0.2, 0.1]) {
            assert!((seen - expected).abs() < 1e-4, "{seen} {expected}");
        }
    }

    #[test]
    fn interpolation_is_right_in_perspective() {
        // A wall that leads away to the right: x from -1 to 3, z from -2 to -6; its colour is linear along it.
        let mesh = PictureMesh {
            positions_m: vec![[-1.0, -9.0, -2.0], [3.0, -9.0, -6.0], [3.0, 9.0, -6.0], [-1.0, 9.0, -2.0]],
            colors: vec![[0.0; 3], [1.0; 3], [1.0; 3], [0.0; 3]],
            triangles: vec![[0, 1, 2], [0, 2, 3]],
            ..PictureMesh::default()
        };
        let size = 201;
        let picture = render(&[mesh], &[], &camera(), &plain(size, size)).unwrap();
        for column in [60, 80, 100, 120, 140] {
            // The ray (s, 0, -1) meets x = -1 + 4t, z = -2 - 4t at t = (2s + 1) / (4 (1 - s)).
            let s = (column as f64 + 0.5) / (size as f64 / 2.0) - 1.0;
            let t = (2.0 * s + 1.0) / (4.0 * (1.0 - s));
            let seen = f64::from(picture.pixel(column, 100)[0]);
            assert!((seen - t).abs() < 2e-4, "column {column}: {seen}, expected {t}");
        }
    }

    #[test]
    fn through_a_mask_one_sees_what_is_behind() {
        let mut file = Vec::new();
        let mut encoder = png::Encoder::new(&mut file, 2, 1);
        encoder.set_color(png::ColorType::Rgba);
        encoder.write_header().unwrap().write_image_data(&[[255; 4], [255, 255, 255, 100]].concat()).unwrap();
        let mask = Arc::new(Texture::decode(&file, [Wrap::Clamp; 2]).unwrap());
        let uvs = vec![[0.0, 1.0], [1.0, 1.0], [1.0, 0.0], [0.0, 0.0]];
        let seen = |cutoff| {
            let leaf = PictureMesh {
                uvs: uvs.clone(),
                mask: Some((mask.clone(), cutoff)),
                ..square(-1.0, 1.0, [0.0, 1.0, 0.0])
            };
            let picture = render(&[leaf, square(-2.0, 2.0, [1.0, 0.0, 0.0])], &[], &camera(), &plain(40, 40)).unwrap();
            [5, 35].map(|column| picture.pixel(column, 20))
        };
        assert_eq!(seen(0.5), [[0.0, 1.0, 0.0], [1.0, 0.0, 0.0]]);
        assert_eq!(seen(0.3), [[0.0, 1.0, 0.0]; 2]);
    }

    #[test]
    fn a_texture_is_right_in_perspective_and_upright() {
        // The wall of the test above, with a texture that grows brighter from left to right and is black in its lower
        // half.
        let mut codes: Vec<u8> = (0..=255).collect::<Vec<u8>>().repeat(32);
        codes.resize(256 * 64, 0);
        let mut file = Vec::new();
        let mut writer = png::Encoder::new(&mut file, 256, 64).write_header().unwrap();
        writer.write_image_data(&codes).unwrap();
        writer.finish().unwrap();
        let mesh = PictureMesh {
            positions_m: vec![[-1.0, -9.0, -2.0], [3.0, -9.0, -6.0], [3.0, 9.0, -6.0], [-1.0, 9.0, -2.0]],
            colors: vec![[0.5; 3]; 4],
            uvs: vec![[0.0, 1.0], [1.0, 1.0], [1.0, 0.0], [0.0, 0.0]],
            texture: Some(Arc::new(Texture::decode(&file, [Wrap::Clamp; 2]).unwrap())),
            triangles: vec![[0, 1, 2], [0, 2, 3]],
            ..PictureMesh::default()
        };
        let size = 201;
        let picture = render(std::slice::from_ref(&mesh), &[], &camera(), &plain(size, size)).unwrap();
        for column in [60, 80, 100, 120, 140] {
            let s = (column as f64 + 0.5) / (size as f64 / 2.0) - 1.0;
            let t = (2.0 * s + 1.0) / (4.0 * (1.0 - s));
            let expected = 0.5 * linear_from_srgb(t * 256.0 / 255.0 - 0.5 / 255.0);
            let seen = f64::from(picture.pixel(column, 40)[0]);
            assert!((seen - expected).abs() < 2e-3, "column {column}: {seen}, expected {expected}");
            assert_eq!(picture.pixel(column, 160), [0.0; 3]);
        }
        let unplaced = PictureMesh { uvs: Vec::new(), ..mesh };
        assert!(matches!(
            render(&[unplaced], &[], &camera(), &plain(9, 9)),
            Err(RenderError::Mesh { index: 0, source: MeshError::UvCount { positions: 4, uvs: 0 } })
        ));
    }

    #[test]
    fn false_colours_show_the_luminance_and_raw_pictures_keep_it() {
        let meshes = [square(-2.0, 9.0, [6.0, 2.0, 4.0])];
        let seen = |look| render(&meshes, &[], &camera(), &RenderSettings { look, ..plain(9, 9) }).unwrap().pixel(4, 4);
        let expected = on_scale(&SEQUENTIAL, (0.2126 * 6.0 + 0.7152 * 2.0 + 0.0722 * 4.0) / 8.0);
        for (seen, expected) in seen(Look::FalseColor { end: 8.0 }).iter().zip(expected) {
            assert!((seen - expected).abs() < 1e-5, "{seen} {expected}");
        }
        assert_eq!(seen(Look::Raw { exposure: 2.0 }), [12.0, 4.0, 8.0]);
        assert_eq!(seen(display(0.125)), [0.75, 0.25, 0.5]);
    }

    #[test]
    fn the_nearest_wins_in_any_order() {
        let (near, far) = (square(-2.0, 1.0, [1.0, 0.0, 0.0]), square(-3.0, 9.0, [0.0, 1.0, 0.0]));
        for meshes in [[near.clone(), far.clone()], [far, near]] {
            let picture = render(&meshes, &[], &camera(), &plain(64, 64)).unwrap();
            assert_eq!(picture.pixel(32, 32), [1.0, 0.0, 0.0]);
            assert_eq!(picture.pixel(2, 2), [0.0, 1.0, 0.0]);
            // The edge of the near one is at 16, between two pixels.
            assert_eq!((picture.pixel(15, 32), picture.pixel(16, 32)), ([0.0, 1.0, 0.0], [1.0, 0.0, 0.0]));
        }
    }

    #[test]
    fn an_edge_through_a_pixel_is_smoothed_and_clipped_before() {
        // The edge runs through the middle of column 8; a colour of 5 counts as 1.
        let mut mesh = square(-1.0, 1.0, [5.0; 3]);
        mesh.positions_m[1][0] = 1.0 / 16.0;
        mesh.positions_m[2][0] = 1.0 / 16.0;
        let picture = render(&[mesh], &[], &camera(), &plain(16, 16)).unwrap();
        assert_eq!([7, 8, 9].map(|column| picture.pixel(column, 8)[0]), [1.0, 0.5, 0.0]);
    }

    #[test]
    fn backs_are_hidden_or_black() {
        let mut back = square(-1.0, 0.5, [1.0, 0.0, 0.0]);
        back.triangles.iter_mut().for_each(|t| t.reverse());
        let meshes = [back, square(-2.0, 9.0, [0.0, 1.0, 0.0])];
        let seen = |backs| render_with_backs(&meshes, &[], &camera(), &plain(9, 9), backs).unwrap().pixel(4, 4);
        assert_eq!((seen(Backs::Hidden), seen(Backs::Black)), ([0.0, 1.0, 0.0], [0.0; 3]));
    }

    #[test]
    fn a_floor_that_passes_under_the_eye_fills_the_lower_half() {
        let floor = PictureMesh {
            positions_m: vec![[-50.0, -1.0, 50.0], [50.0, -1.0, 50.0], [50.0, -1.0, -5e4], [-50.0, -1.0, -5e4]],
            colors: vec![[1.0; 3]; 4],
            triangles: vec![[0, 1, 2], [0, 2, 3]],
            ..PictureMesh::default()
        };
        let picture = render(&[floor], &[], &camera(), &plain(64, 64)).unwrap();
        for row in 0..64 {
            assert_eq!(picture.pixel(32, row)[0], if row < 32 { 0.0 } else { 1.0 }, "row {row}");
        }
    }

    #[test]
    fn lines_are_seen_on_their_surface_and_not_behind_another() {
        let line = |z: f64| Line { ends_m: [[-0.9, 0.0, z], [0.9, 0.0, z]], normal: None };
        let set =
            |z| LineSet { color: LineColor::Plain([1.0, 0.0, 0.0]), opacity: 1.0, width_px: 1.0, lines: vec![line(z)] };
        let meshes = [square(-2.0, 1.0, [0.0, 0.0, 1.0]), square(-3.0, 9.0, [0.0, 0.0, 1.0])];
        let seen = |z| render(&meshes, &[set(z)], &camera(), &plain(65, 65)).unwrap().pixel(32, 32);
        assert_eq!(seen(-2.0), [1.0, 0.0, 0.0]);
        assert_eq!(seen(-3.0), [0.0, 0.0, 1.0]);
    }

    #[test]
    fn a_line_on_a_grazing_surface_is_whole() {
        // A floor seen at less than two degrees, with a line across it.
        let floor = PictureMesh {
            positions_m: vec![[-9.0, -0.1, -1.0], [9.0, -0.1, -1.0], [9.0, -0.1, -9.0], [-9.0, -0.1, -9.0]],
            colors: vec![[0.0, 0.0, 1.0]; 4],
            triangles: vec![[0, 1, 2], [0, 2, 3]],
            ..PictureMesh::default()
        };
        let line = Line { ends_m: [[-9.0, -0.1, -4.0], [9.0, -0.1, -4.0]], normal: Some([0.0, 1.0, 0.0]) };
        let set = LineSet { color: LineColor::Plain([1.0, 0.0, 0.0]), opacity: 1.0, width_px: 1.0, lines: vec![line] };
        let picture = render(&[floor], &[set], &camera(), &plain(200, 200)).unwrap();
        for column in 0..200 {
            let red: f32 = (95..110).map(|row| picture.pixel(column, row)[0]).sum();
            assert!((red - 1.0).abs() < 1e-6, "column {column}: {red} pixels of line");
        }
    }

    #[test]
    fn one_thread_and_two_give_the_same_bytes() {
        let meshes: Vec<_> =
            (0..40).map(|i| square(-2.0 - 0.1 * f64::from(i), 0.3 * f64::from(i), [0.02 * i as f32; 3])).collect();
        let wires = LineSet {
            color: LineColor::Plain([1.0; 3]),
            opacity: 0.5,
            width_px: 1.5,
            lines: wireframe(&meshes, DVec3::ZERO),
        };
        let bytes = |threads| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            pool.install(|| render(&meshes, std::slice::from_ref(&wires), &camera(), &plain(120, 150)).unwrap().srgb8())
        };
        assert_eq!(bytes(1), bytes(2));
    }

    #[test]
    fn impossible_pictures_are_refused() {
        let refused = |settings: &RenderSettings| render(&[], &[], &camera(), settings).unwrap_err();
        assert_eq!(refused(&plain(0, 9)), RenderError::BadSize { width: 0, height: 9 });
        assert!(matches!(
            refused(&RenderSettings { look: display(f32::NAN), ..plain(9, 9) }),
            RenderError::BadExposure(_)
        ));
        let scale = RenderSettings { look: Look::FalseColor { end: 0.0 }, ..plain(9, 9) };
        assert_eq!(refused(&scale), RenderError::BadScale(0.0));
        let mut mesh = square(-1.0, 1.0, [0.0; 3]);
        mesh.colors.pop();
        assert!(matches!(render(&[mesh], &[], &camera(), &plain(9, 9)), Err(RenderError::Mesh { index: 0, .. })));
        assert_eq!(render(&[], &[], &camera(), &plain(1, 1)).unwrap().pixel(0, 0), [0.0; 3]);
    }
}
