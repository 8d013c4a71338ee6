//! Opening a file: a baked one is read, a scene is baked first, in a thread of its own.
//!
//! Idea: a scene becomes the same bytes as `umbrage bake` writes, and these are read back, so that there is one way
//! from a file to the screen, and what is shown is what would be saved.
//!
//! Holds: nothing waits for a thread that was told to stop: its result is dropped; a cancelled bake leaves nothing.

use std::ops::ControlFlow;
use std::path::PathBuf;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Receiver, TryRecvError, channel};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant};
use std::{fs, thread};

use anyhow::{Context, anyhow};
use umbrage::bake::{BakeSettings, Meshed, Report, bake_and_keep};
use umbrage::progress::{Progress, Update};
use umbrage::scene::Scene;
use umbrage::shade::ShadeSettings;
use umbrage_cli::method::facts;
use umbrage_cli::scene_file::SceneArgs;
use umbrage_cli::shown::Shown;
use umbrage_formats::{FormatError, ReadOptions, baked_glb_bytes, read_baked_bytes};

use crate::layout::{Tables, lay_out};
use crate::watch::Stamps;

/// What to open, and how to bake it if it is a scene.
#[derive(Clone, Debug)]
pub struct Job {
    /// The file.
    pub path: PathBuf,
    /// How a scene is read.
    pub reading: SceneArgs,
    /// How it is baked.
    pub settings: BakeSettings,
    /// Whether the tolerance is not theirs but the one that suits the scene's size, whenever it is read.
    pub tolerance_by_size: bool,
}

impl Job {
    /// The settings for a scene of so many polygons.
    fn settings_for(&self, polygons: usize) -> BakeSettings {
        let mut settings = self.settings;
        if self.tolerance_by_size {
            settings.shade.tolerance = ShadeSettings::default_tolerance(polygons);
        }
        settings
    }
}

/// A file that is ready to be drawn.
pub(crate) struct Loaded {
    pub(crate) shown: Shown,
    pub(crate) tables: Tables,
    /// What the bake kept, if it was baked here.
    pub(crate) baked: Option<BakedHere>,
    /// What was not taken over from the scene.
    pub(crate) warnings: Vec<String>,
    pub(crate) took: Duration,
}

/// What a bake kept.
pub(crate) struct BakedHere {
    pub(crate) scene: Scene,
    /// What it was baked with.
    pub(crate) settings: BakeSettings,
    pub(crate) meshed: Meshed,
    pub(crate) report: Report,
    /// The baked file.
    pub(crate) glb: Vec<u8>,
}

/// Opens a file; waits until it is done. `tell_files` is told what files a scene is made of, before it is baked.
///
/// # Errors
/// Where the file cannot be read or baked, or the callback cancels.
pub(crate) fn load(job: &Job, progress: Progress<'_>, tell_files: &dyn Fn(Vec<PathBuf>)) -> anyhow::Result<Loaded> {
    let begin = Instant::now();
    let Job { path, .. } = job;
    let bytes = fs::read(path).with_context(|| format!("cannot read {}", path.display()))?;
    let (file, baked, warnings) = match read_baked_bytes(path, bytes) {
        Ok(file) => (file, None, Vec::new()),
        Err(FormatError::NotBaked { .. }) => {
            let (baked, warnings) = bake_here(job, progress, tell_files)?;
            (read_baked_bytes(path, baked.glb.clone())?, Some(baked), warnings)
        }
        Err(error) => return Err(error.into()),
    };
    let shown = Shown::new(file, path)?;
    anyhow::ensure!(shown.file.triangle_count() > 0, "{}: there are no triangles to show", path.display());
    let tables = lay_out(&shown);
    Ok(Loaded { shown, tables, baked, warnings, took: begin.elapsed() })
}

fn bake_here(
    job: &Job,
    progress: Progress<'_>,
    tell_files: &dyn Fn(Vec<PathBuf>),
) -> anyhow::Result<(BakedHere, Vec<String>)> {
    let Job { path, reading, .. } = job;
    let (files, read) = reading.read_silently(path, ReadOptions::default().max_reflectance);
    tell_files(files);
    let (scene, warnings) = read?;
    let settings = job.settings_for(scene.polygon_count());
    let (bake, meshed) =
        bake_and_keep(&scene, &settings, progress).with_context(|| format!("cannot bake {}", path.display()))?;
    let glb = baked_glb_bytes(&scene, &bake.mesh, &facts(&settings, &bake.report, None))?;
    let warnings = warnings.iter().map(ToString::to_string).collect();
    Ok((BakedHere { scene, settings, meshed, report: bake.report, glb }, warnings))
}

/// A file that is being opened.
pub(crate) struct Loading {
    result: Receiver<anyhow::Result<Loaded>>,
    update: Arc<Mutex<Option<Update>>>,
    files: Arc<Mutex<Option<Stamps>>>,
    cancelled: Arc<AtomicBool>,
    begin: Instant,
}

impl Loading {
    /// Begins; `wake` is called when it is done.
    pub(crate) fn begin(job: Job, wake: impl FnOnce() + Send + 'static) -> Self {
        let (sender, result) = channel();
        let update = Arc::new(Mutex::new(None));
        let cancelled = Arc::new(AtomicBool::new(false));
        let (told, stop) = (Arc::clone(&update), Arc::clone(&cancelled));
        let files = Arc::new(Mutex::new(None));
        let told_files = Arc::clone(&files);
        thread::spawn(move || {
            let callback = |update| {
                if stop.load(Ordering::Relaxed) {
                    return ControlFlow::Break(());
                }
                // Where another thread is telling, this update may be lost: the next one comes soon.
                if let Ok(mut told) = told.try_lock() {
                    *told = Some(update);
                }
                ControlFlow::Continue(())
            };
            let tell_files = |files: Vec<PathBuf>| {
                let stamps = Stamps::now(files);
                *told_files.lock().unwrap_or_else(PoisonError::into_inner) = Some(stamps);
            };
            let loaded = load(&job, Progress::new(&callback), &tell_files);
            // Nobody may be waiting any more.
            let _ = sender.send(loaded);
            wake();
        });
        Self { result, update, files, cancelled, begin: Instant::now() }
    }

    /// How far it is; nothing while the file is being read.
    pub(crate) fn update(&self) -> Option<Update> {
        self.update.lock().map_or(None, |update| *update)
    }

    /// What files the scene is made of, as they were when it had been read; told once.
    pub(crate) fn take_files(&self) -> Option<Stamps> {
        self.files.lock().unwrap_or_else(PoisonError::into_inner).take()
    }

    /// How long it has been running.
    pub(crate) fn elapsed(&self) -> Duration {
        self.begin.elapsed()
    }

    /// The result, once it is there.
    pub(crate) fn result(&self) -> Option<anyhow::Result<Loaded>> {
        match self.result.try_recv() {
            Ok(result) => Some(result),
            Err(TryRecvError::Empty) => None,
            Err(TryRecvError::Disconnected) => Some(Err(anyhow!("the bake ended without a result: a defect"))),
        }
    }
}

impl Drop for Loading {
    fn drop(&mut self) {
        self.cancelled.store(true, Ordering::Relaxed);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn job(path: &str) -> Job {
        let coarse = ShadeSettings { tolerance: f64::INFINITY, ..ShadeSettings::default() };
        let settings = BakeSettings { max_form_factor: Some(0.5), shade: coarse, ..BakeSettings::default() };
        let path = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../../testdata/scenes").join(path);
        Job { path, reading: SceneArgs::default(), settings, tolerance_by_size: false }
    }

    fn wait(loading: &Loading) -> anyhow::Result<Loaded> {
        loop {
            if let Some(result) = loading.result() {
                return result;
            }
            thread::sleep(Duration::from_millis(5));
        }
    }

    #[test]
    fn a_scene_is_baked_in_a_thread_and_its_bake_opens_as_the_same() {
        let (sender, woken) = channel();
        let loading = Loading::begin(job("occluder.glb"), move || sender.send(()).unwrap());
        let loaded = wait(&loading).unwrap();
        woken.recv().unwrap();
        assert!(loading.update().is_some());
        let baked = loaded.baked.unwrap();
        assert_eq!(baked.report.triangles, loaded.shown.file.triangle_count());

        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("baked.glb");
        fs::write(&path, &baked.glb).unwrap();
        let again = load(&Job { path, ..job("") }, Progress::silent(), &|_| {}).unwrap();
        assert!(again.baked.is_none());
        assert_eq!(again.tables.vertices, loaded.tables.vertices);
    }

    #[test]
    fn the_tolerance_is_that_of_the_size_unless_one_was_asked_for() {
        let asked = job("occluder.glb");
        let by_size = Job { tolerance_by_size: true, ..asked.clone() };
        let tolerances = |job: &Job| [1, 10_497, 99_407].map(|polygons| job.settings_for(polygons).shade.tolerance);
        assert_eq!(tolerances(&asked), [f64::INFINITY; 3]);
        assert_eq!(tolerances(&by_size), [0.01, 0.021, 0.05]);
        let baked = load(&by_size, Progress::silent(), &|_| {}).unwrap().baked.unwrap();
        assert_eq!(baked.settings.shade.tolerance, 0.01);
    }

    #[test]
    fn a_bake_that_nobody_waits_for_stops() {
        let (sender, done) = channel();
        let fine = BakeSettings { max_form_factor: Some(1e-4), ..BakeSettings::default() };
        drop(Loading::begin(Job { settings: fine, ..job("touching.glb") }, move || sender.send(()).unwrap()));
        done.recv_timeout(Duration::from_secs(60)).expect("it was told to stop");
    }

    #[test]
    fn what_cannot_be_read_is_told() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("broken.glb");
        let told = |job: &Job| format!("{:#}", load(job, Progress::silent(), &|_| {}).err().unwrap());
        assert!(told(&Job { path: path.clone(), ..job("") }).contains("broken.glb"));
        fs::write(&path, "no glb").unwrap();
        assert!(told(&Job { path, ..job("") }).contains("broken.glb"));
    }
}
