//! What a graphics driver draws is what a picture of `umbrage-picture` shows.
//!
//! Skipped, with a line that says so, where there is no graphics driver at all; a driver without a graphics card
//! (Mesa's llvmpipe) is as good.

#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]
#![allow(clippy::print_stderr, reason = "a test that is skipped says so")]

use std::path::{Path, PathBuf};
use std::sync::OnceLock;

use clap::Parser;
use umbrage::bake::{BakeSettings, DrawnSegment, bake, d_segments};
use umbrage::progress::Progress;
use umbrage::scene::cornell::cornell_box;
use umbrage::shade::ShadeSettings;
use umbrage_cli::camera::{CameraArgs, SizeArgs};
use umbrage_cli::look::LookArgs;
use umbrage_cli::method::facts;
use umbrage_cli::scene_file::SceneArgs;
use umbrage_cli::shown::Shown;
use umbrage_formats::write_baked_glb;
use umbrage_picture::color::{DEGREES, linear_from_srgb8};
use umbrage_picture::{
    Line, LineColor, LineSet, Look, Picture, RenderSettings, SEGMENT_WIDTH_PX, WIRE_OPACITY, WIRE_WIDTH_PX, render,
    wireframe,
};
use umbrage_view::{Gpu, GpuError, Job, LineArgs, ViewOptions, screenshot};
use wgpu::Backends;

/// Codes that may differ between renderers of one picture.
const TOLERANCE: u8 = 2;
/// A pixel is on an edge if, in either picture, the codes of it and its neighbours spread further than this: there,
/// renderers average samples in their own ways, and a sample more or less is a quarter of the spread.
const EDGE: u8 = 6;
/// Share of the pixels that may differ all the same: single samples along contacts, too little to show as an edge.
const SHARE: f64 = 1e-4;
/// Lines are smoothed in their own ways: what is compared is the mean over squares of so many pixels, in codes. One
/// line through a square makes about 3.5 codes; where lines are nearer than a pixel, a picture unites what lies over
/// each other and the window mixes it, which may be two lines.
const SQUARE_PX: usize = 16;
const LINE_TOLERANCE: f64 = 7.0;

const SIZE: &str = "--width 640 --height 480";
/// From where the Cornell box is seen.
const CAMERA: &str = "--eye 0.28,0.3,-0.6 --target 0.28,0.25,0.3 --fov 45";

#[derive(Debug, Parser)]
struct Args {
    #[command(flatten)]
    size: SizeArgs,
    #[command(flatten)]
    camera: CameraArgs,
    #[command(flatten)]
    look: LookArgs,
    #[command(flatten)]
    lines: LineArgs,
}

impl Args {
    fn parsed(words: &str) -> Self {
        let camera = if words.contains("--eye") { "" } else { CAMERA };
        Self::parse_from(format!("view {SIZE} {camera} {words}").split_whitespace())
    }
}

fn coarse() -> BakeSettings {
    let shade = ShadeSettings { tolerance: f64::INFINITY, ..ShadeSettings::default() };
    BakeSettings { max_form_factor: Some(0.2), shade, ..BakeSettings::default() }
}

/// The Cornell box, baked coarsely, once for all tests.
fn cornell() -> &'static Path {
    static FILE: OnceLock<(tempfile::TempDir, PathBuf)> = OnceLock::new();
    let (_, path) = FILE.get_or_init(|| {
        let (scene, settings) = (cornell_box(), coarse());
        let baked = bake(&scene, &settings, Progress::silent()).unwrap();
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("cornell.glb");
        write_baked_glb(&scene, &baked.mesh, &facts(&settings, &baked.report, None), &path).unwrap();
        (folder, path)
    });
    path
}

/// Devices, by all ways to reach one; none where there is no graphics driver.
fn gpus() -> Vec<Gpu> {
    let mut gpus = Vec::new();
    for backends in [Backends::PRIMARY, Backends::GL] {
        match Gpu::reached_by(backends) {
            Ok(gpu) => {
                eprintln!("drawn by {}", gpu.name);
                gpus.push(gpu);
            }
            Err(error @ GpuError::NoAdapter(_)) => eprintln!("skipped: {error}"),
            Err(error) => panic!("{error}"),
        }
    }
    gpus
}

fn seen(path: &Path, words: &str, gpu: Gpu) -> Picture {
    let Args { size, camera, look, lines } = Args::parsed(words);
    let job = Job { path: path.into(), reading: SceneArgs::default(), settings: coarse(), tolerance_by_size: false };
    screenshot(&ViewOptions { job, size, camera, look, lines }, gpu).unwrap()
}

fn expected(path: &Path, words: &str, lines: impl FnOnce(&Shown, &umbrage_picture::Camera) -> Vec<LineSet>) -> Picture {
    let Args { size, camera, look, .. } = Args::parsed(words);
    let shown = Shown::read(path).unwrap();
    let camera = camera.choose(&shown, size).unwrap();
    let scale = look.false_color.map(|unit| (unit, look.scale_end.unwrap_or_else(|| unit.scale_end(&shown.file))));
    let settings = RenderSettings {
        width: size.width,
        height: size.height,
        look: match scale {
            Some((unit, end)) => Look::FalseColor { end: (end / unit.per_file_unit()) as f32 },
            None => Look::Display { exposure: look.brighter(&shown.file) as f32, tone: look.tone() },
        },
        ..RenderSettings::default()
    };
    let meshes = shown.meshes(look.colors(), shown.file.exposure_k);
    let mut picture = render(&meshes, &lines(&shown, &camera), &camera, &settings).unwrap();
    if let Some((unit, end)) = scale {
        unit.scale(end).draw(&mut picture);
    }
    picture
}

/// The pixels of a picture, as codes.
fn codes(picture: &Picture) -> Vec<[u8; 3]> {
    picture.srgb8().chunks_exact(3).map(|code| [code[0], code[1], code[2]]).collect()
}

fn spread(codes: &[[u8; 3]], width: usize, at: usize) -> u8 {
    let around = [at - width, at, at + width].into_iter().flat_map(|row| row - 1..=row + 1);
    let range = |channel: usize| {
        let values = around.clone().map(|pixel| codes[pixel][channel]);
        values.clone().max().unwrap() - values.min().unwrap()
    };
    (0..3).map(range).max().unwrap()
}

#[test]
fn the_window_shows_the_picture_but_for_pixels_on_edges() {
    let gpus = gpus();
    let all = |words| gpus.iter().map(move |gpu| (words, gpu));
    let looks = [
        "",
        "--brighter 2.5",
        "--brighter 3 --tone filmic",
        "--light-only",
        "--false-color lx --scale-end 2000",
        "--false-color",
    ];
    for (words, gpu) in looks.into_iter().flat_map(all) {
        check_same(words, [&expected(cornell(), words, |_, _| Vec::new()), &seen(cornell(), words, gpu.clone())]);
    }
}

/// That two pictures are the same but for pixels on edges.
fn check_same(words: &str, pictures: [&Picture; 2]) {
    let [expected, seen] = pictures.map(codes);
    assert_eq!(expected.len(), seen.len());
    let (width, height) = (pictures[0].width(), pictures[0].height());
    let (mut compared, mut edges, mut different) = (0, 0, Vec::new());
    for y in 1..height - 1 {
        for at in y * width + 1..(y + 1) * width - 1 {
            if spread(&expected, width, at).max(spread(&seen, width, at)) > EDGE {
                edges += 1;
                continue;
            }
            compared += 1;
            if (0..3).any(|channel| expected[at][channel].abs_diff(seen[at][channel]) > TOLERANCE) {
                different.push((at % width, y, expected[at], seen[at]));
            }
        }
    }
    assert!(compared > 2 * edges, "{words}: {edges} of {compared} pixels are on edges");
    let first = &different[..different.len().min(9)];
    assert!(
        different.len() as f64 <= SHARE * f64::from(compared),
        "{words}: {} of {compared} pixels differ: {first:?}",
        different.len()
    );
}

/// Four bright walls that end at a black one, which hides them from an eye that looks along it.
#[test]
fn what_stands_behind_a_black_wall_is_hidden() {
    let quad = |corners: [[f64; 3]; 4]| corners.map(|[x, y, z]| format!("v {x} {y} {z}\n")).concat();
    let bright = [2.0, 4.0, 6.0, 8.0].map(|x| quad([[x, 0., 0.], [x, 0., -4.], [x, 3., -4.], [x, 3., 0.]]));
    let black = quad([[0., 0., 0.], [10., 0., 0.], [10., 3., 0.], [0., 3., 0.]]);
    let lamp = quad([[0., 3., -4.], [10., 3., -4.], [10., 3., -1.], [0., 3., -1.]]);
    let faces = "usemtl wall\nf -4 -3 -2 -1\nf -8 -7 -6 -5\nf -12 -11 -10 -9\nf -16 -15 -14 -13\nf -20 -19 -18 -17\n\
        usemtl lamp\nf -24 -23 -22 -21\n";
    let folder = tempfile::tempdir().unwrap();
    let [scene, baked] = ["walls.obj", "walls.glb"].map(|name| folder.path().join(name));
    std::fs::write(folder.path().join("walls.mtl"), "newmtl wall\nKd 0.5 0.5 0.5\nnewmtl lamp\nKe 1 1 1\n").unwrap();
    std::fs::write(&scene, format!("mtllib walls.mtl\n{lamp}{black}{}{faces}", bright.concat())).unwrap();
    let (read, _) = umbrage_formats::read_scene(&scene).unwrap();
    let bake = bake(&read, &coarse(), Progress::silent()).unwrap();
    write_baked_glb(&read, &bake.mesh, &facts(&coarse(), &bake.report, None), &baked).unwrap();
    // Bright, so that a sample that comes through is an edge, and a strip is not.
    let words = "--brighter 8 --eye 14,1.5,2 --target 5,1.5,0 --fov 30";
    let picture = expected(&baked, words, |_, _| Vec::new());
    assert!(codes(&picture).contains(&[0; 3]), "the black wall is in sight");
    for gpu in gpus() {
        check_same(words, [&picture, &seen(&baked, words, gpu)]);
    }
}

/// The mean code of each square of a picture.
fn squares(picture: &Picture) -> Vec<f64> {
    let (width, codes) = (picture.width(), codes(picture));
    let square = |left: usize, top: usize| {
        let pixels = (top..top + SQUARE_PX).flat_map(|y| (left..left + SQUARE_PX).map(move |x| y * width + x));
        let sum: f64 = pixels.map(|at| codes[at].iter().map(|&code| f64::from(code)).sum::<f64>()).sum();
        sum / (3 * SQUARE_PX * SQUARE_PX) as f64
    };
    let tops = (0..picture.height() / SQUARE_PX).map(|row| row * SQUARE_PX);
    tops.flat_map(|top| (0..width / SQUARE_PX).map(move |column| (column * SQUARE_PX, top)))
        .map(|(left, top)| square(left, top))
        .collect()
}

fn check_lines(words: &str, [plain, expected, seen]: [&Picture; 3]) {
    let [plain, expected, seen] = [plain, expected, seen].map(squares);
    let apart =
        |one: &[f64], other: &[f64]| -> Vec<f64> { one.iter().zip(other).map(|(a, b)| (a - b).abs()).collect() };
    let worst = |values: &[f64]| values.iter().copied().fold(0.0, f64::max);
    let (drawn, off) = (apart(&plain, &expected), apart(&expected, &seen));
    assert!(worst(&drawn) > 3.0 * LINE_TOLERANCE, "{words}: the lines are too few to be compared");
    assert!(worst(&off) < LINE_TOLERANCE, "{words}: a square is off by {:.1} codes", worst(&off));
    let sum = |values: &[f64]| values.iter().sum::<f64>();
    assert!(sum(&off) < 0.2 * sum(&drawn), "{words}: off by {:.0} of {:.0} codes", sum(&off), sum(&drawn));
}

#[test]
fn triangles_are_drawn_as_a_picture_draws_them() {
    let plain = expected(cornell(), "", |_, _| Vec::new());
    let wired = expected(cornell(), "", |shown, camera| {
        let meshes = shown.meshes(umbrage_cli::shown::Colors::Seen, shown.file.exposure_k);
        let lines = wireframe(&meshes, camera.eye_m);
        vec![LineSet { color: LineColor::Contrast, opacity: WIRE_OPACITY, width_px: WIRE_WIDTH_PX, lines }]
    });
    for gpu in gpus() {
        check_lines("triangles", [&plain, &wired, &seen(cornell(), "--wireframe", gpu)]);
    }
}

#[test]
fn shadow_edges_of_a_scene_are_drawn_as_a_picture_draws_them() {
    let scene = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../../testdata/scenes/cornell.glb");
    // The same bake as a file, and the d-segments of the same scene.
    let (read, _) = umbrage_formats::read_scene(&scene).unwrap();
    let baked = bake(&read, &coarse(), Progress::silent()).unwrap();
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("cornell.glb");
    write_baked_glb(&read, &baked.mesh, &facts(&coarse(), &baked.report, None), &path).unwrap();
    let segments = d_segments(&read, Progress::silent()).unwrap();
    let plain = expected(&path, "", |_, _| Vec::new());
    let lined = expected(&path, "", |_, _| [2, 1, 0].map(|degree| set(&segments, degree)).into());
    for gpu in gpus() {
        check_lines("d-segments", [&plain, &lined, &seen(&scene, "--segments", gpu)]);
    }
}

fn set(segments: &[DrawnSegment], degree: u8) -> LineSet {
    let line = |segment: &DrawnSegment| Line {
        ends_m: segment.ends_m.map(|end| end.to_array()),
        normal: Some(segment.normal.to_array()),
    };
    LineSet {
        color: LineColor::Plain(linear_from_srgb8(DEGREES[usize::from(degree)])),
        opacity: 1.0,
        width_px: SEGMENT_WIDTH_PX,
        lines: segments.iter().filter(|segment| segment.degree == degree).map(line).collect(),
    }
}

#[test]
fn a_baked_file_says_that_it_has_no_shadow_edges() {
    let Some(gpu) = gpus().pop() else { return };
    let Args { size, camera, look, lines } = Args::parsed("--segments");
    let job =
        Job { path: cornell().into(), reading: SceneArgs::default(), settings: coarse(), tolerance_by_size: false };
    let error = screenshot(&ViewOptions { job, size, camera, look, lines }, gpu).unwrap_err();
    assert!(error.to_string().contains("does not hold shadow edges"), "{error}");
}
