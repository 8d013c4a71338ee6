//! Random points on the sides that receive and do not emit, evenly by area; where all emit, on all.

use fastrand::Rng;
use umbrage::scene::Scene;

use crate::path::Place;
use crate::tracer::Tracer;

/// `n` points: each is alone in one of `n` equal shares of the area.
pub(crate) fn points(scene: &Scene, tracer: &Tracer, n: usize, rng: &mut Rng) -> Vec<Place> {
    let all_emit = tracer.triangles.iter().all(|triangle| scene.materials[triangle.material].emits());
    let mut total_m2 = 0.0;
    let mut sides = Vec::new();
    for (number, triangle) in tracer.triangles.iter().enumerate() {
        let material = &scene.materials[triangle.material];
        let on_fronts = [Some(true), material.double_sided.then_some(false)];
        for on_front in on_fronts.into_iter().flatten().filter(|_| all_emit || !material.emits()) {
            total_m2 += triangle.area_m2;
            sides.push((number, on_front, total_m2));
        }
    }
    if sides.is_empty() {
        return Vec::new();
    }
    (0..n)
        .map(|i| {
            let target_m2 = total_m2 * (i as f64 + rng.f64()) / n as f64;
            let place = sides.partition_point(|(.., sum)| *sum <= target_m2).min(sides.len() - 1);
            let (number, on_front, _) = sides[place];
            tracer.place(number, tracer.triangles[number].point_m([rng.f64(), rng.f64()]), on_front)
        })
        .collect()
}
