//! How long a frame of a million triangles takes: `cargo test -p umbrage-view million -- --ignored --nocapture`.
//!
//! Idea: what is seen is one surface of one colour in waves, just larger than the picture, in a million triangles; so
//! that nearly all of them are in sight, none hides another, and every pixel has to show that colour: a triangle that
//! is lost, or a crack, shows as well.

#![allow(clippy::print_stderr, reason = "it is a measurement")]

use std::time::{Duration, Instant};

use glam::DVec3;
use umbrage_formats::BakedFilePart;
use umbrage_picture::color::srgb8_from_linear;
use umbrage_picture::{Camera, Tone};
use wgpu::PollType;

use crate::draw::{Frame, FrameLook, Renderer, Show};
use crate::gpu::{Gpu, GpuError};
use crate::layout::lay_out;
use crate::layout::tests::{shown, square};
use crate::lens::Lens;
use crate::targets::Targets;

/// Squares along and across.
const SQUARES: [usize; 2] = [1000, 500];
/// The surface, which is 1 m away.
const SIZE_M: [f32; 2] = [1.6, 1.0];
const WAVE_M: f32 = 0.005;
/// What is seen across: less than the surface is wide, and so is what is seen along.
const SEEN_M: f64 = 0.97;
/// The picture.
const PICTURE_PX: [u32; 2] = [1280, 800];
/// Frames of which the median is told.
const FRAMES: usize = 9;
/// A white surface in this light shows this, at exposure 1.
const LIGHT: f32 = 0.5;

/// The surface, all in one light.
fn waves() -> BakedFilePart {
    let [along, across] = SQUARES;
    let mut part = BakedFilePart { base_color: [1.0; 4], ..square(0.0, LIGHT * std::f32::consts::PI) };
    let place = |i: usize, count: usize, size_m: f32| size_m * (i as f32 / count as f32 - 0.5);
    part.positions_m = (0..=across)
        .flat_map(|j| (0..=along).map(move |i| (i, j)))
        .map(|(i, j)| {
            let [x, y] = [place(i, along, SIZE_M[0]), place(j, across, SIZE_M[1])];
            [x, y, WAVE_M * (20.0 * x).sin() * (20.0 * y).cos()]
        })
        .collect();
    let count = part.positions_m.len();
    (part.normals, part.color) = (vec![[0.0, 0.0, 1.0]; count], vec![[LIGHT, LIGHT, LIGHT, 1.0]; count]);
    part.irradiance = vec![[LIGHT * std::f32::consts::PI; 3]; count];
    part.triangles.clear();
    for corner in (0..across).flat_map(|j| (0..along).map(move |i| (j * (along + 1) + i) as u32)) {
        let above = corner + along as u32 + 1;
        part.triangles.extend([[corner, corner + 1, above + 1], [corner, above + 1, above]]);
    }
    part
}

#[test]
#[ignore = "it measures: it takes a second on a graphics card, and many without one"]
fn a_million_triangles_are_drawn_whole() {
    let gpu = match Gpu::headless() {
        Err(GpuError::NoAdapter(error)) => {
            eprintln!("skipped: no graphics driver: {error}");
            return;
        }
        gpu => gpu.unwrap(),
    };
    let driver = gpu.name.clone();
    let tables = lay_out(&shown(vec![waves()]));
    let renderer = Renderer::new(gpu.device, gpu.queue, gpu.kind);
    let targets = Targets::new(&renderer, PICTURE_PX);
    let scene = renderer.upload(&tables).unwrap();
    let fov_deg = 2.0 * (0.5 * SEEN_M).atan().to_degrees();
    let camera = Camera::looking(tables.origin_m + DVec3::Z, tables.origin_m, fov_deg);
    let lens = Lens::new(&camera, targets.aspect(), tables.origin_m, tables.bounds_m).unwrap();
    for wire in [false, true] {
        let look = FrameLook { show: Show::Surfaces, exposure: 1.0, tone: Tone::Off, scale_end: 1.0, wire };
        let mut took: Vec<Duration> = (0..=FRAMES)
            .map(|_| {
                let begin = Instant::now();
                renderer.draw(&Frame { lens, look, dither: false }, &targets, &tables, &scene, &[]);
                renderer.device.poll(PollType::wait_indefinitely()).unwrap();
                begin.elapsed()
            })
            // The first frame makes what the others use.
            .skip(1)
            .collect();
        took.sort();
        let [width, height] = PICTURE_PX;
        let (what, count) = (if wire { "triangles" } else { "surfaces" }, tables.indices.len() / 3);
        eprintln!("{driver}: {count} triangles, {width} x {height}, {what}: {:.1?} a frame", took[FRAMES / 2]);
        if !wire {
            let code = srgb8_from_linear(LIGHT);
            let picture = targets.picture(&renderer).unwrap();
            let wrong = picture.srgb8().into_iter().filter(|shown| shown.abs_diff(code) > 1).count();
            assert_eq!(wrong, 0, "codes of pixels that do not show the surface");
        }
    }
}
