//! Points of the unit square that are spread more evenly than chance does: each in a cell of its own.

use fastrand::Rng;

/// `side` times `side` points, one in each cell, in random order.
pub(crate) fn square(side: usize, rng: &mut Rng) -> Vec<[f64; 2]> {
    let cell = 1.0 / side as f64;
    let mut points: Vec<[f64; 2]> =
        (0..side * side).map(|i| [i % side, i / side].map(|at| cell * (at as f64 + rng.f64()))).collect();
    rng.shuffle(&mut points);
    points
}

/// `n` points, one in each part of the unit interval, in random order.
pub(crate) fn interval(n: usize, rng: &mut Rng) -> Vec<f64> {
    let mut points: Vec<f64> = (0..n).map(|i| (i as f64 + rng.f64()) / n as f64).collect();
    rng.shuffle(&mut points);
    points
}
