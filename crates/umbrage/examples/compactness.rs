//! How well shaped the patches are that carry transport, `4 pi A / P^2`, by score and with and without point hints for
//! badly shaped patches: the table of `docs/well-shaped.md`.

use glam::DVec3;
use umbrage::bake::{BakeSettings, bake};
use umbrage::id::{MaterialId, NodeId};
use umbrage::mesh::SplitScore;
use umbrage::progress::Progress;
use umbrage::scene::{Material, Node, Rgb, Scene, Surface, cornell};
use umbrage::shade::ShadeSettings;

/// A corridor of 20 x 1 x 2.5 m with a light in the middle of its ceiling: its floor is a 20 : 1 rectangle.
fn corridor() -> Scene {
    let mut scene = Scene { name: "corridor".into(), ..Scene::default() };
    scene.nodes.push(Node::default());
    let at = |x: usize, y: usize, z: usize| DVec3::new([0.0, 20.0][x], [0.0, 2.5][y], [0.0, 1.0][z]);
    let walls = [
        [at(0, 0, 0), at(0, 0, 1), at(1, 0, 1), at(1, 0, 0)],
        [at(0, 1, 0), at(1, 1, 0), at(1, 1, 1), at(0, 1, 1)],
        [at(0, 0, 0), at(1, 0, 0), at(1, 1, 0), at(0, 1, 0)],
        [at(0, 0, 1), at(0, 1, 1), at(1, 1, 1), at(1, 0, 1)],
        [at(0, 0, 0), at(0, 1, 0), at(0, 1, 1), at(0, 0, 1)],
        [at(1, 0, 0), at(1, 0, 1), at(1, 1, 1), at(1, 1, 0)],
    ];
    let light = [(9.5, 0.25), (10.5, 0.25), (10.5, 0.75), (9.5, 0.75)].map(|(x, z)| DVec3::new(x, 2.4, z));
    let parts = [
        (Material::diffuse("wall", Rgb::splat(0.7)), walls.to_vec()),
        (Material::emitting("light", Rgb::splat(10.0)), vec![light]),
    ];
    for (material, polygons) in parts {
        let material: MaterialId = scene.materials.push_and_get_key(material);
        let positions_m: Vec<DVec3> = polygons.iter().flatten().copied().collect();
        let polygons = (0..positions_m.len() as u32 / 4).map(|i| (4 * i..4 * i + 4).collect()).collect();
        scene.surfaces.push(Surface { positions_m, polygons, ..Surface::new(NodeId::from(0), material) });
    }
    scene
}

#[expect(clippy::print_stdout, reason = "an example prints")]
fn main() -> Result<(), umbrage::bake::BakeError> {
    println!("| scene | score | point hints | patches | median | 5th percentile |");
    println!("|---|---|---|---|---|---|");
    for scene in [cornell::cornell_box(), corridor()] {
        for score in [SplitScore::Eq1, SplitScore::WellShaped] {
            for mend_bad_shapes in [false, true] {
                let shade = ShadeSettings { tolerance: 0.1, ..ShadeSettings::default() };
                let settings = BakeSettings { score, mend_bad_shapes, shade, ..BakeSettings::default() };
                let report = bake(&scene, &settings, Progress::silent())?.report;
                let [median, low] = report.compactness;
                let hints = if mend_bad_shapes { "yes" } else { "no" };
                let name = &scene.name;
                println!("| {name} | {score} | {hints} | {} | {median:.2} | {low:.2} |", report.patches);
            }
        }
    }
    Ok(())
}
