//! The stages that have no benchmark of their own: `cargo bench -p umbrage-bench --bench stages`.
//!
//! Each one gets what the stages before it made of the Cornell box and of a field of 100 faces. A stage that cuts the
//! mesh gets a new one every time; making it is not in the time.
#![allow(clippy::unwrap_used, reason = "a benchmark fails by panicking")]

use std::hint::black_box;

use divan::Bencher;
use umbrage::discontinuity::{self, Discontinuities};
use umbrage::id::Table;
use umbrage::mesh::{Mesh, MeshSettings};
use umbrage::prepare::{self, Prepared};
use umbrage::progress::Progress;
use umbrage::scene::{Scene, cornell::cornell_box};
use umbrage::shade::{self, IndirectLight, Irradiance, LocalLight, ShadeLight, ShadeMeshes, ShadeSettings};
use umbrage::solve::{self, Solution, SolveSettings, Surfaces};
use umbrage::transport::{self, DirectLight, FormFactorOracle, Links};
use umbrage::visibility::{AtPoints, Visibility};
use umbrage_bench::box_field;

/// Fmax, and the least area of a patch in square metres: coarser than a bake at the default tolerance, so that a round
/// is short.
const FMAX: f64 = 0.1;
const MIN_AREA_SHARE: f64 = 1e-3;
/// What shading is asked for, as a share of the mean light.
const TOLERANCE: f64 = 0.05;

/// A scene with all that its stages made, up to links.
struct Stages {
    scene: Scene,
    prepared: Prepared,
    visibility: Visibility,
    discontinuities: Discontinuities,
    mesh: Mesh,
    links: Links,
}

const SCENES: [&str; 2] = ["cornell", "field-100"];

fn scene(name: &str) -> Scene {
    if name == "cornell" { cornell_box() } else { box_field(100, 3) }
}

impl Stages {
    fn new(name: &str) -> Self {
        let scene = scene(name);
        let prepared = prepare::prepare(&scene, Progress::silent()).unwrap();
        let visibility = Visibility::new(&prepared);
        let discontinuities =
            discontinuity::find(&scene, &prepared, &visibility, TOLERANCE, Progress::silent()).unwrap();
        let mut mesh = Mesh::new(&prepared, &discontinuities.segments, MeshSettings::default());
        let oracle = oracle(&prepared, &mesh);
        let links = transport::link_all(&prepared, &visibility, &mut mesh, &oracle, Progress::silent()).unwrap();
        Self { scene, prepared, visibility, discontinuities, mesh, links }
    }

    /// The mesh as it is before anything is cut for light.
    fn uncut(&self) -> Mesh {
        Mesh::new(&self.prepared, &self.discontinuities.segments, MeshSettings::default())
    }

    fn solve(&self, direct: &DirectLight<'_>) -> Solution {
        let surfaces = Surfaces::new(&self.scene, &self.prepared, &self.mesh, direct);
        solve::solve(&self.mesh, &surfaces, &self.links, SolveSettings::default(), Progress::silent()).unwrap()
    }
}

fn oracle(prepared: &Prepared, mesh: &Mesh) -> FormFactorOracle {
    let area_m2: f64 = prepared.faces.keys().map(|face| mesh.patch(mesh.root(face)).area_m2).sum();
    FormFactorOracle {
        max_form_factor: FMAX,
        min_area_m2: MIN_AREA_SHARE * area_m2,
        coplanar_m: prepared.tolerance.coplanar_m(),
    }
}

fn main() {
    divan::main();
}

#[divan::bench(args = SCENES, sample_count = 20)]
fn prepare(bencher: Bencher<'_, '_>, name: &str) {
    let scene = scene(name);
    bencher.bench(|| prepare::prepare(&scene, Progress::silent()).unwrap());
}

#[divan::bench(args = SCENES, sample_count = 5, sample_size = 1)]
fn transport(bencher: Bencher<'_, '_>, name: &str) {
    let stages = Stages::new(name);
    let Stages { prepared, visibility, .. } = &stages;
    bencher.with_inputs(|| stages.uncut()).bench_local_refs(|mesh| {
        let oracle = oracle(prepared, mesh);
        transport::link_all(prepared, visibility, mesh, &oracle, Progress::silent()).unwrap()
    });
}

/// The solution over links, and before it the direct light of the patches; without the exact bounces of a bake, which
/// are gathered as `shade` does it.
#[divan::bench(args = SCENES, sample_count = 5, sample_size = 1)]
fn solve(bencher: Bencher<'_, '_>, name: &str) {
    let stages = Stages::new(name);
    let direct = DirectLight::new(&stages.scene, &stages.prepared, &stages.visibility);
    bencher.bench_local(|| stages.solve(black_box(&direct)));
}

#[divan::bench(args = SCENES, sample_count = 3, sample_size = 1)]
fn shade(bencher: Bencher<'_, '_>, name: &str) {
    let stages = Stages::new(name);
    let Stages { scene, prepared, visibility, mesh, .. } = &stages;
    let direct = DirectLight::new(scene, prepared, visibility);
    let solution = stages.solve(&direct);
    let mean = solution.mean_irradiance(mesh, |face| prepared.shows_light(scene, face));
    let gathered = Irradiance::new(prepared, visibility, mesh, &solution.reflected, mean);
    // No bounces went before: all is gathered.
    let bounced = AtPoints::new(Vec::new());
    let indirect = IndirectLight::Gathered { irradiance: &gathered, bright: &[], bounced: &bounced };
    let mean = mean.element_sum() / 3.0;
    let local = LocalLight::new(scene, (prepared, visibility), mesh, &solution.irradiance, mean);
    let light = ShadeLight { direct: &direct, indirect, local: &local };
    let settings = ShadeSettings { tolerance: TOLERANCE, ..ShadeSettings::default() };
    bencher
        .with_inputs(|| ShadeMeshes {
            shown: stages.uncut(),
            gathering: Mesh::new(prepared, &Table::new(), MeshSettings::default()),
        })
        .bench_local_refs(|meshes| shade::shade(scene, prepared, meshes, light, settings, Progress::silent()).unwrap());
}
