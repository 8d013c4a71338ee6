//! Hostile geometry, as OBJ: polygons that nearly lie in one plane, overlap, cross, share an edge, are needles, or there many times.

use fastrand::Rng;

use crate::{Hostile, Kind};

pub(crate) const KINDS: &[(&str, Kind)] = &[
    ("near-coplanar", near_coplanar),
    ("overlapping", overlapping),
    ("crossing", crossing),
    ("fan", fan),
    ("needles", needles),
    ("twice", twice),
    ("huge", huge),
    ("emitters", emitters),
];

type Point = [f64; 3];

fn point(rng: &mut Rng) -> Point {
    std::array::from_fn(|_| rng.f64())
}

/// Polygons in grey, below a lamp.
fn scene(polygons: &[Vec<Point>]) -> Hostile {
    let mut text = "v 0 9 0\nv 1 9 0\nv 0 9 1\nusemtl lamp\nf 1 2 3\nusemtl w\n".to_owned();
    let mut next = 4;
    for polygon in polygons {
        polygon.iter().for_each(|[x, y, z]| text += &format!("v {x} {y} {z}\n"));
        let corners: Vec<String> = (next..next + polygon.len()).map(|i| i.to_string()).collect();
        text += &format!("f {}\n", corners.join(" "));
        next += polygon.len();
    }
    let toml = "[materials.lamp]\nemission = 10\n";
    let beside = vec![("a.umbrage.toml".to_owned(), toml.into())];
    Hostile { beside, ..Hostile::new("a.obj", text) }
}

fn square([x, y, z]: Point, size: f64) -> Vec<Point> {
    vec![[x, y, z], [x, y, z + size], [x + size, y, z + size], [x + size, y, z]]
}

fn near_coplanar(rng: &mut Rng) -> Hostile {
    let off = [0.0, 1e-9, 1e-7, 1e-6][rng.usize(..4)];
    let one = |_| square([rng.f64(), rng.f64() * off, rng.f64()], 0.5);
    scene(&(0..1_000).map(one).collect::<Vec<_>>())
}

fn overlapping(rng: &mut Rng) -> Hostile {
    let count = [30, 300, 3_000][rng.usize(..3)];
    let one = |_| square([3.0 * rng.f64(), 0.0, 3.0 * rng.f64()], 0.5);
    scene(&(0..count).map(one).collect::<Vec<_>>())
}

fn crossing(rng: &mut Rng) -> Hostile {
    let count = [30, 300, 3_000][rng.usize(..3)];
    let one = |_| (0..3).map(|_| point(rng)).collect();
    scene(&(0..count).map(one).collect::<Vec<_>>())
}

fn fan(rng: &mut Rng) -> Hostile {
    let on_edge = rng.bool();
    let at = |i: usize| {
        let angle = i as f64 * 0.002_09;
        [angle.cos(), if on_edge { 0.5 } else { 0.1 * (i as f64).sin() }, angle.sin()]
    };
    let one = |i| vec![[0.0; 3], if on_edge { [0.0, 1.0, 0.0] } else { at(i + 1) }, at(i)];
    scene(&(0..3_000).map(one).collect::<Vec<_>>())
}

fn needles(rng: &mut Rng) -> Hostile {
    let thin = [0.0, 1e-9, 1e-6, 1e-4][rng.usize(..4)];
    let one = |_| {
        let (a, b) = (point(rng), point(rng));
        vec![a, b, std::array::from_fn(|k| 0.5 * (a[k] + b[k]) + thin * rng.f64())]
    };
    scene(&(0..2_000).map(one).collect::<Vec<_>>())
}

fn twice(rng: &mut Rng) -> Hostile {
    let one = square(point(rng), 1.0);
    scene(&vec![one; rng.usize(2..20_000)])
}

fn huge(rng: &mut Rng) -> Hostile {
    let by = [1e100, 1e308, 1e20, 1e-30, 1e-300][rng.usize(..5)];
    let one = |_| (0..3).map(|_| point(rng).map(|x| x * by)).collect();
    Hostile { baked: true, ..scene(&(0..20).map(one).collect::<Vec<_>>()) }
}

fn emitters(rng: &mut Rng) -> Hostile {
    let one = |_| {
        let at = point(rng);
        vec![at, [at[0] + 0.02, at[1], at[2]], [at[0], at[1], at[2] + 0.02]]
    };
    let polygons: Vec<Vec<Point>> = (0..3_000).map(one).collect();
    let mut file = scene(&polygons);
    file.beside[0].1 = b"[materials.lamp]\nemission = 10\n[materials.w]\nemission = 1\n".to_vec();
    file
}
