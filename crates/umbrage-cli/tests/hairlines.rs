//! No black hairlines: our pictures show the edges of rooms and of what stands in them without dark dots along them.
//!
//! A pixel is in a hairline if it is darker than what lies on both of its sides, and darker than anything that a finer
//! picture shows about there: thin things and gaps, which are dark in earnest, are in that one. `ci/browser` does the same
//! with more scenes, in three.js.

#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

mod common;

use std::path::Path;

use common::{err, folder, scene, umbrage};
use umbrage_cli::shown::{Colors, Shown};
use umbrage_picture::{Camera, Look, RenderSettings, render};

/// Size of the pictures, in pixels.
const SIZE: [usize; 2] = [320, 240];
/// The reference is this many times finer.
const FINER: usize = 3;
/// Darker: less than this share. One black sample of sixteen makes a pixel that much darker.
const DARKER: f32 = 0.95;
/// Less light than this is too near to black for shares of it.
const MIN_LIGHT: f32 = 0.0025;

/// From where a scene is seen: eye, target, field of view in degrees; lengths in metres.
type View = ([f64; 3], [f64; 3], f64);

/// Linear luminance, by rows.
struct Light {
    width: usize,
    height: usize,
    light: Vec<f32>,
}

impl Light {
    fn of(baked: &Path, (eye_m, target_m, fov_deg): View, times: usize) -> Self {
        let [width, height] = SIZE.map(|pixels| times * pixels);
        let shown = Shown::read(baked).unwrap();
        let meshes = shown.meshes(Colors::Seen, shown.file.exposure_k);
        let camera = Camera::looking(eye_m.into(), target_m.into(), fov_deg);
        let settings = RenderSettings { width, height, look: Look::Raw { exposure: 1.0 }, ..RenderSettings::default() };
        let picture = render(&meshes, &[], &camera, &settings).unwrap();
        let light = picture.pixels().iter().map(|[r, g, b]| 0.2126 * r + 0.7152 * g + 0.0722 * b).collect();
        Self { width, height, light }
    }

    /// The light of the pixel so many steps away.
    fn at(&self, [x, y]: [usize; 2], [dx, dy]: [isize; 2], steps: isize) -> f32 {
        let [x, y] = [x.wrapping_add_signed(steps * dx), y.wrapping_add_signed(steps * dy)];
        self.light[y * self.width + x]
    }

    /// The least light in and around a pixel of a picture that is coarser: of 3 x 3 of its pixels.
    fn least(&self, [x, y]: [usize; 2]) -> f32 {
        let around = |at: usize| (at - 1) * FINER..(at + 2) * FINER;
        around(y).flat_map(|y| &self.light[y * self.width..][around(x)]).copied().fold(f32::INFINITY, f32::min)
    }

    /// How many pixels are in hairlines.
    fn hairlines(&self, fine: &Self) -> usize {
        let pixels = (2..self.height - 2).flat_map(|y| (2..self.width - 2).map(move |x| [x, y]));
        let is_dark = |&pixel: &[usize; 2]| {
            let here = self.at(pixel, [0, 0], 0);
            let is_between = |way: [isize; 2]| {
                let [one, other] = [1, -1].map(|sign| self.at(pixel, way, sign).max(self.at(pixel, way, 2 * sign)));
                one.min(other) > MIN_LIGHT && here < DARKER * one.min(other)
            };
            [[1, 0], [0, 1], [1, 1], [1, -1]].into_iter().any(is_between) && here < DARKER * fine.least(pixel)
        };
        pixels.filter(is_dark).count()
    }
}

/// How many pixels of all views are in hairlines.
fn hairlines(name: &str, file: &str, views: &[View]) -> usize {
    let baked = folder(name).join("baked.glb");
    let scene = scene(file);
    let bake = umbrage(&["bake", &scene, "-o", baked.to_str().unwrap(), "--tolerance", "0.02", "--exposure", "0.5"]);
    assert!(bake.status.success(), "{}", err(&bake));
    views.iter().map(|&view| Light::of(&baked, view, 1).hairlines(&Light::of(&baked, view, FINER))).sum()
}

#[test]
fn a_dark_pixel_is_found_unless_the_finer_picture_has_it() {
    let even = |times: usize| Light { width: 10 * times, height: 8 * times, light: vec![1.0; 80 * times * times] };
    let (mut coarse, mut fine) = (even(1), even(FINER));
    assert_eq!(coarse.hairlines(&fine), 0);
    coarse.light[4 * coarse.width + 5] = 0.9;
    assert_eq!(coarse.hairlines(&fine), 1);
    let at = 4 * FINER * fine.width + 5 * FINER;
    fine.light[at] = 0.0;
    assert_eq!(coarse.hairlines(&fine), 0);
}

#[test]
fn closed_blocks_on_a_floor_have_no_hairlines_around_them() {
    let views = [([0.0, 1.0, 3.0], [0.0, 1.0, 0.0], 45.0), ([-0.9, 0.1, 0.9], [0.8, 0.2, -0.9], 60.0)];
    assert_eq!(hairlines("closed", "../others/mcguire_cornell.obj", &views), 0);
}

#[test]
fn blocks_without_bottoms_have_no_hairlines_around_them() {
    let views = [([0.28, 0.3, -0.6], [0.28, 0.25, 0.3], 45.0), ([0.5, 0.1, 0.05], [0.1, 0.05, 0.5], 60.0)];
    assert_eq!(hairlines("open", "cornell.obj", &views), 0);
}
