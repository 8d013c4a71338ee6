//! `weak`: what is lost when weak d-segments are left out.
//!
//! A scene is baked again and again, each time without the d-segments that change irradiance by less than a larger
//! share of the tolerance. Those of contacts always stay.

use clap::Args;
use umbrage::bake::{BakeSettings, bake};
use umbrage::progress::Progress;
use umbrage::shade::ShadeSettings;

use crate::reference::Reference;
use crate::table::{Table, grouped, percent};
use crate::{measure, say, scenes, tell};

/// What is left out, in shares of the tolerance; a bake leaves out what is below 1.
const WEAK: [f64; 7] = [0.0, 0.1, 1.0, 10.0, 30.0, 100.0, 1000.0];

/// Count d-segments, triangles and error when weak d-segments are left out
#[derive(Debug, Args)]
pub(crate) struct WeakArgs {
    /// Scenes that have reference points, with commas between them
    #[arg(long, value_delimiter = ',', value_name = "SCENES", default_values = ["cornell", "touching"])]
    scenes: Vec<String>,
    /// Error allowed, as a share of the mean light [default: that of a bake]
    #[arg(long)]
    tolerance: Option<f64>,
}

pub(crate) fn run(args: &WeakArgs) -> anyhow::Result<()> {
    let default = BakeSettings::default();
    let tolerance = args.tolerance.unwrap_or(default.shade.tolerance);
    let mut table = Table::new(&["scene", "left out below", "d-segments left out", "of", "triangles", "error"]);
    for name in &args.scenes {
        let (reference, scene) = (Reference::read(name)?, scenes::scene(name)?);
        let mut all = None;
        for weak_of_tolerance in WEAK {
            tell(&format!("{name} without what is below {weak_of_tolerance} of the tolerance ..."));
            let shade = ShadeSettings { tolerance, ..default.shade };
            let baked = bake(&scene, &BakeSettings { weak_of_tolerance, shade, ..default }, Progress::silent())?;
            let [_, slope, curvature] = baked.report.d_segments;
            let found = slope + curvature + baked.report.secondary;
            let all = *all.get_or_insert(found);
            table.row(vec![
                name.clone(),
                format!("{} %", 100.0 * weak_of_tolerance * tolerance),
                grouped(all - found),
                grouped(all),
                grouped(baked.report.triangles),
                percent(reference.error(&measure::triangles(&baked.mesh))?, 2),
            ]);
        }
    }
    say(&table.text())
}
