//! Finding d-segments in fields of boxes: `cargo bench -p umbrage-bench --bench discontinuity`.
//!
//! `brute_force` asks every face about every wedge. The greatest field takes long: `UMBRAGE_BENCH_FACES=100000` adds
//! it. Before the benchmark each field is searched once and counted: d-segments, wedges, and the time and memory of
//! each.
#![allow(clippy::unwrap_used, clippy::print_stdout, reason = "a benchmark fails by panicking and says what it counted")]

use std::time::Instant;

use divan::Bencher;
use umbrage::discontinuity::{self, DSegment, Discontinuities};
use umbrage::prepare::{self, Prepared};
use umbrage::progress::Progress;
use umbrage::scene::Scene;
use umbrage::visibility::Visibility;
use umbrage_bench::{box_field, usage};

const LAMPS: usize = 3;
/// d-segments that are weaker than this share of the mean are left out: a tenth of what a bake at a tolerance of 1 %
/// leaves out.
const LEAST_SHARE: f64 = 1e-3;

struct Field {
    scene: Scene,
    prepared: Prepared,
    visibility: Visibility,
}

impl Field {
    fn new(faces: usize) -> Self {
        let scene = box_field(faces, LAMPS);
        let prepared = prepare::prepare(&scene, Progress::silent()).unwrap();
        let visibility = Visibility::new(&prepared);
        Self { scene, prepared, visibility }
    }

    fn find(&self) -> Discontinuities {
        let Self { scene, prepared, visibility } = self;
        discontinuity::find(scene, prepared, visibility, LEAST_SHARE, Progress::silent()).unwrap()
    }
}

fn sizes() -> Vec<usize> {
    let most = std::env::var("UMBRAGE_BENCH_FACES").ok().and_then(|text| text.parse().ok()).unwrap_or(10_000);
    [1_000, 10_000, 100_000].into_iter().filter(|&faces| faces <= most).collect()
}

fn main() {
    for faces in sizes() {
        let field = Field::new(faces);
        let (begin, cpu_before, peak_before) = (Instant::now(), usage::cpu_seconds(), usage::peak_bytes());
        let Discontinuities { segments, wedges, .. } = field.find();
        let seconds = begin.elapsed().as_secs_f64();
        let each = 1.0 / segments.len().max(1) as f64;
        let cpu = cpu_before.zip(usage::cpu_seconds()).map_or(f64::NAN, |(before, after)| after - before);
        let bytes = peak_before.zip(usage::peak_bytes()).map_or(f64::NAN, |(before, after)| (after - before) as f64);
        println!(
            "{faces} faces: {} d-segments from {wedges} wedges in {seconds:.2} s, {cpu:.2} s of processors, {:.0} wedges/s; each \
             d-segment {:.1} us of processors, {} bytes to keep, {:.0} at the most while it is searched",
            segments.len(),
            wedges as f64 / seconds,
            1e6 * cpu * each,
            size_of::<DSegment>(),
            bytes * each,
        );
    }
    divan::main();
}

#[divan::bench(args = sizes(), sample_count = 3, sample_size = 1)]
fn find(bencher: Bencher<'_, '_>, faces: usize) {
    let field = Field::new(faces);
    bencher.bench(|| field.find());
}

#[divan::bench(args = [1_000], sample_count = 1, sample_size = 1)]
fn brute_force(bencher: Bencher<'_, '_>, faces: usize) {
    let field = Field::new(faces);
    let field = Field { visibility: Visibility::without_tree(&field.prepared), ..field };
    bencher.bench(|| field.find());
}
