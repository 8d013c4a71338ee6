//! `umbrage bake --report FILE.json`: all that a bake tells, for programs.
//!
//! The layout is a promise: `docs/report.md` has every key with its unit and meaning, and a test keeps the two together. Keys are only
//! ever added; where one changes its meaning or goes, [`VERSION`] rises.
//!
//! Holds: shares are 0 to 1, never percent; times are in seconds, lengths in metres, powers in watts at red, green and blue; a number
//! that is infinite or unknown is `null`. Files go by their names alone, without folders.

use std::path::Path;
use std::time::Duration;

use serde::Serialize;
use umbrage::bake::{BakeSettings, BakeWarning, Report};
use umbrage::scene::{Lamp, LampKind, Rgb, Scene};
use umbrage::shade::LampAccount;
use umbrage_formats::{Written, check_writable, write_atomically};

use crate::light::Fluxes;
use crate::{memory, output};

/// What the file is.
const FORMAT: &str = "umbrage-report";
/// Version of the layout.
const VERSION: u32 = 1;

/// What a report is about.
#[derive(Debug)]
pub(crate) struct Reported<'a> {
    pub(crate) input: &'a Path,
    pub(crate) output: &'a Path,
    pub(crate) scene: &'a Scene,
    pub(crate) report: &'a Report,
    pub(crate) settings: &'a BakeSettings,
    pub(crate) asked: &'a Asked,
    pub(crate) written: &'a Written,
    /// With reading and writing.
    pub(crate) elapsed: Duration,
    pub(crate) warnings: &'a [ReportedWarning],
}

/// What was asked for beside the settings of the bake.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Asked {
    pub(crate) tolerance: f64,
    pub(crate) exposure: Option<f64>,
    pub(crate) max_reflectance: f64,
}

/// A warning as the command printed it.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub(crate) struct ReportedWarning {
    /// `scene`: of what was read; `bake`: of the result; `limits`: of what was asked for and not reached.
    about: &'static str,
    /// A name that stays the same, of warnings of the result.
    name: Option<&'static str>,
    text: String,
}

impl ReportedWarning {
    /// About what was read, without the name of the file.
    pub(crate) fn of_scene(warning: &impl ToString) -> Self {
        Self { about: "scene", name: None, text: warning.to_string() }
    }

    /// About the result.
    pub(crate) fn of_bake(warning: &BakeWarning) -> Self {
        Self { about: "bake", name: Some(warning.name()), text: warning.to_string() }
    }

    /// About what was asked for and not reached.
    pub(crate) fn of_limits(text: String) -> Self {
        Self { about: "limits", name: None, text }
    }

    /// About a lamp whose light does not arrive.
    pub(crate) fn of_lamp(text: &str) -> Self {
        Self { about: "lamp", name: None, text: text.to_owned() }
    }

    /// Prints it; `file` is the one that it is about.
    pub(crate) fn told(self, file: &Path) -> Self {
        output::warning(&format!("{}: {}", file.display(), self.text));
        self
    }
}

/// Fails where a report cannot be written, or would replace a file that it is about.
///
/// # Errors
/// In words, with the name of the file.
pub(crate) fn check(report: &Path, others: &[&Path]) -> anyhow::Result<()> {
    let taken = others.iter().find(|other| is_same_file(report, other));
    if let Some(other) = taken {
        anyhow::bail!("--report {}: is the same file as {}: give it another name", report.display(), other.display());
    }
    Ok(check_writable(report)?)
}

/// Whether two paths lead to one file, which may not be there yet.
fn is_same_file(one: &Path, other: &Path) -> bool {
    let real = |path: &Path| {
        let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
        let beside = || Some(folder.canonicalize().ok()?.join(path.file_name()?));
        path.canonicalize().ok().or_else(beside)
    };
    one == other || real(one).is_some_and(|one| real(other) == Some(one))
}

/// Writes a report, all or nothing, and says how many bytes it has.
///
/// # Errors
/// Where the file cannot be written.
pub(crate) fn write(path: &Path, reported: &Reported<'_>) -> anyhow::Result<u64> {
    let mut text = serde_json::to_string_pretty(&File::new(reported))?;
    text.push('\n');
    write_atomically(path, text.as_bytes())?;
    Ok(text.len() as u64)
}

#[derive(Debug, Serialize)]
struct File<'a> {
    format: &'static str,
    version: u32,
    umbrage: &'static str,
    input: String,
    output: String,
    output_bytes: u64,
    settings: Settings,
    counts: Counts,
    compactness: Compactness,
    hidden_share: f64,
    photometric: bool,
    mended: Mended,
    error: ErrorEstimate,
    solution: Solved,
    energy: Energy,
    lamps: Vec<ReportedLamp<'a>>,
    exposure: Exposure,
    time: Time,
    memory_peak_bytes: Option<u64>,
    warnings: &'a [ReportedWarning],
}

#[derive(Debug, Serialize)]
struct Settings {
    tolerance: Option<f64>,
    asked_tolerance: Option<f64>,
    max_triangles: Option<usize>,
    max_form_factor: f64,
    min_area_m2: Option<f64>,
    max_reflectance: f64,
    oracle: String,
    score: String,
    mend_bad_shapes: bool,
    discontinuities: bool,
    cut_contacts: bool,
    smooth: bool,
    keep_hidden: bool,
    exposure: Option<f64>,
}

#[derive(Debug, Serialize)]
struct Counts {
    polygons: usize,
    faces: usize,
    d_segments: [usize; 3],
    secondary_d_segments: usize,
    patches: usize,
    leaves: usize,
    links: usize,
    samples: Option<usize>,
    vertices: usize,
    triangles: usize,
}

#[derive(Debug, Serialize)]
struct Compactness {
    median: f64,
    percentile_5: f64,
}

#[derive(Debug, Serialize)]
struct Mended {
    welded_corners: usize,
    degenerate_polygons: usize,
    duplicate_polygons: usize,
    nonplanar_polygons: usize,
    turned_polygons: usize,
    t_vertices: usize,
    contact_edges: usize,
    overlaps: usize,
    dropped_cuts: usize,
    sliver_triangles: usize,
}

#[derive(Debug, Serialize)]
struct ErrorEstimate {
    between_vertices: Option<f64>,
}

#[derive(Debug, Serialize)]
struct Solved {
    iterations: usize,
    residual: Option<f64>,
}

#[derive(Debug, Serialize)]
struct Energy {
    surfaces_w: [f64; 3],
    lamps_w: [f64; 3],
    arriving_w: [f64; 3],
    absorbed_w: [f64; 3],
    on_backs_w: [f64; 3],
    leaving_w: [f64; 3],
    error: Option<f64>,
}

#[derive(Debug, Serialize)]
struct ReportedLamp<'a> {
    name: &'a str,
    kind: &'static str,
    emitted_w: Option<[f64; 3]>,
    sent_w: Option<[f64; 3]>,
    expected_w: Option<[f64; 3]>,
    received_w: Option<[f64; 3]>,
    on_backs_w: Option<[f64; 3]>,
    leaving_w: Option<[f64; 3]>,
    fading_w: Option<[f64; 3]>,
    received_share: Option<f64>,
}

#[derive(Debug, Serialize)]
struct Exposure {
    k: f64,
    clipped_vertices: usize,
}

#[derive(Debug, Serialize)]
struct Time {
    total_s: f64,
    linking_s: f64,
    stages: Vec<StageTime>,
}

#[derive(Debug, Serialize)]
struct StageTime {
    stage: String,
    seconds: f64,
}

impl<'a> File<'a> {
    fn new(reported: &Reported<'a>) -> Self {
        let Reported { report, written, warnings, .. } = *reported;
        let prepare = &report.prepare;
        let [median, percentile_5] = report.compactness;
        Self {
            format: FORMAT,
            version: VERSION,
            umbrage: env!("CARGO_PKG_VERSION"),
            input: name_of(reported.input),
            output: name_of(reported.output),
            output_bytes: written.bytes,
            settings: Settings::new(reported.settings, reported.asked),
            counts: Counts {
                polygons: prepare.polygons,
                faces: report.faces,
                d_segments: report.d_segments,
                secondary_d_segments: report.secondary,
                patches: report.patches,
                leaves: report.leaves,
                links: report.links,
                samples: report.samples,
                vertices: written.vertices,
                triangles: written.triangles,
            },
            compactness: Compactness { median, percentile_5 },
            hidden_share: prepare.hidden_share,
            photometric: reported.scene.photometric,
            mended: Mended {
                welded_corners: prepare.welded_corners,
                degenerate_polygons: prepare.degenerate_polygons,
                duplicate_polygons: prepare.duplicate_polygons,
                nonplanar_polygons: prepare.nonplanar_polygons,
                turned_polygons: prepare.turned_polygons,
                t_vertices: prepare.t_vertices,
                contact_edges: prepare.contact_edges,
                overlaps: prepare.overlaps,
                dropped_cuts: prepare.dropped_cuts,
                sliver_triangles: report.flat_triangles,
            },
            error: ErrorEstimate { between_vertices: finite(report.error) },
            solution: Solved { iterations: report.iterations, residual: finite(report.residual) },
            energy: Energy::new(report, &Fluxes::new(reported.scene)),
            lamps: reported_lamps(reported.scene, &report.lamps),
            exposure: Exposure { k: written.exposure_k, clipped_vertices: written.clipped_vertices },
            time: Time {
                total_s: reported.elapsed.as_secs_f64(),
                linking_s: report.linking_s,
                stages: report
                    .seconds
                    .iter()
                    .map(|(stage, seconds)| StageTime { stage: stage.to_string(), seconds: *seconds })
                    .collect(),
            },
            memory_peak_bytes: memory::peak_bytes(),
            warnings,
        }
    }
}

impl Settings {
    fn new(settings: &BakeSettings, asked: &Asked) -> Self {
        let max_triangles = settings.shade.max_triangles;
        Self {
            tolerance: finite(settings.shade.tolerance),
            asked_tolerance: finite(asked.tolerance),
            max_triangles: (max_triangles != usize::MAX).then_some(max_triangles),
            max_form_factor: settings.fmax(),
            min_area_m2: settings.min_area_m2,
            max_reflectance: asked.max_reflectance,
            oracle: settings.oracle.to_string(),
            score: settings.score.to_string(),
            mend_bad_shapes: settings.mend_bad_shapes,
            discontinuities: settings.discontinuities,
            cut_contacts: settings.prepare.cut_contacts,
            smooth: settings.prepare.smooth,
            keep_hidden: settings.prepare.keep_hidden,
            exposure: asked.exposure,
        }
    }
}

impl Energy {
    fn new(report: &Report, fluxes: &Fluxes) -> Self {
        let account = &report.energy;
        let watts = |power: Rgb| power.to_array();
        Self {
            surfaces_w: watts(fluxes.surfaces_w),
            lamps_w: watts(fluxes.lamps_w),
            arriving_w: watts(account.emitted_w),
            absorbed_w: watts(account.absorbed_w),
            on_backs_w: watts(account.on_backs_w),
            leaving_w: watts(account.leaving_w),
            error: finite(account.error()),
        }
    }
}

/// All lamps of a scene with the accounts of those that shine, which stand in the same order.
fn reported_lamps<'a>(scene: &'a Scene, accounts: &[LampAccount]) -> Vec<ReportedLamp<'a>> {
    let mut accounts = accounts.iter();
    scene.lamps.iter().map(|lamp| reported_lamp(lamp, if lamp.emits() { accounts.next() } else { None })).collect()
}

fn reported_lamp<'a>(lamp: &'a Lamp, account: Option<&LampAccount>) -> ReportedLamp<'a> {
    let kind = match lamp.kind {
        LampKind::Point { .. } => "point",
        LampKind::Spot { .. } => "spot",
        LampKind::Directional { .. } => "directional",
    };
    let flux = |of: fn(&LampAccount) -> Rgb| account.map(|account| of(account).to_array());
    ReportedLamp {
        name: &lamp.name,
        kind,
        emitted_w: lamp.flux_w().map(|flux| flux.to_array()),
        sent_w: flux(|account| account.sent_w),
        expected_w: flux(|account| account.expected_w),
        received_w: flux(|account| account.received_w),
        on_backs_w: flux(|account| account.on_backs_w),
        leaving_w: flux(|account| account.escaped_w),
        fading_w: flux(|account| account.faded_w),
        received_share: account
            .and_then(|account| finite(account.received_w.element_sum() / account.expected_w.element_sum())),
    }
}

/// A file's name without its folder: a report can be shown to others.
pub(crate) fn name_of(path: &Path) -> String {
    path.file_name().unwrap_or(path.as_os_str()).to_string_lossy().into_owned()
}

/// JSON has neither infinity nor what is no number.
fn finite(number: f64) -> Option<f64> {
    Some(number).filter(|number| number.is_finite())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_report_never_takes_the_place_of_another_file() {
        let same = |report: &str, other: &str| is_same_file(Path::new(report), Path::new(other));
        assert!(same("out.glb", "./out.glb") && same("src/main.rs", "src/../src/main.rs"));
        assert!(!same("out.json", "out.glb") && !same("src/out.glb", "out.glb"));
        let refused = check(Path::new("src/main.rs"), &[Path::new("a.glb"), Path::new("./src/main.rs")]).unwrap_err();
        assert!(refused.to_string().contains("is the same file as ./src/main.rs"), "{refused}");
    }

    #[test]
    fn files_go_by_their_names() {
        assert_eq!(name_of(Path::new("/home/me/secret/room.glb")), "room.glb");
        assert_eq!([f64::INFINITY, f64::NAN, 0.5].map(finite), [None, None, Some(0.5)]);
    }
}
