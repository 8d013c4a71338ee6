//! The file that is open in a window: it is opened, baked if it is a scene, and opened again when it changes, or what
//! it is made of: buffers, images, material libraries, includes, the TOML beside it.
//!
//! Holds: what is shown stays until something newer is there, whatever fails or is cancelled meanwhile.

use std::time::{Duration, Instant};

use eframe::egui::Context;
use umbrage::bake::BakeSettings;

use crate::load::{Job, Loaded, Loading};
use crate::watch::Watch;

/// Time between looks at whether the file has changed.
pub(crate) const WATCH_EVERY: Duration = Duration::from_millis(500);

/// What is open.
pub(crate) struct Session {
    pub(crate) job: Job,
    pub(crate) loading: Option<Loading>,
    pub(crate) loaded: Option<Loaded>,
    /// Why the last attempt gave nothing.
    pub(crate) failure: Option<String>,
    watch: Watch,
    looked: Instant,
}

impl Session {
    /// Begins to open a file.
    pub(crate) fn new(job: Job, ctx: &Context) -> Self {
        let watch = Watch::new(job.path.clone(), [job.reading.materials_path(&job.path)]);
        let mut session = Self { job, loading: None, loaded: None, failure: None, watch, looked: Instant::now() };
        session.open(ctx);
        session
    }

    /// Opens the file, again; an attempt that is still going on is given up.
    pub(crate) fn open(&mut self, ctx: &Context) {
        let ctx = ctx.clone();
        self.failure = None;
        self.loading = Some(Loading::begin(self.job.clone(), move || ctx.request_repaint()));
    }

    /// Bakes the scene with other settings. A tolerance that is not that of the bake before was asked for.
    pub(crate) fn bake(&mut self, settings: BakeSettings, ctx: &Context) {
        let before = self.loaded.as_ref().and_then(|loaded| loaded.baked.as_ref()).map(|baked| &baked.settings);
        self.job.tolerance_by_size &= before.is_some_and(|before| before.shade.tolerance == settings.shade.tolerance);
        self.job.settings = settings;
        self.open(ctx);
    }

    /// Gives up what is going on.
    pub(crate) fn cancel(&mut self) {
        self.loading = None;
        self.failure = Some("cancelled".into());
    }

    /// Looks at what has happened; tells whether there is something new to be shown.
    pub(crate) fn look(&mut self, ctx: &Context) -> bool {
        if self.looked.elapsed() >= WATCH_EVERY {
            self.looked = Instant::now();
            if self.watch.has_changed() {
                self.open(ctx);
            }
        }
        let Some(loading) = &self.loading else { return false };
        // In this order: what tells the files comes before the result.
        let result = loading.result();
        if let Some(files) = loading.take_files() {
            self.watch.follow(files);
        }
        let Some(result) = result else { return false };
        self.loading = None;
        match result {
            Ok(loaded) => {
                self.loaded = Some(loaded);
                true
            }
            Err(error) => {
                self.failure = Some(format!("{error:#}"));
                false
            }
        }
    }

    /// The file's name.
    pub(crate) fn name(&self) -> String {
        let path = &self.job.path;
        path.file_name().map_or_else(|| path.display().to_string(), |name| name.to_string_lossy().into_owned())
    }
}

#[cfg(test)]
mod tests {
    use std::path::{Path, PathBuf};
    use std::{fs, thread};

    use umbrage::shade::ShadeSettings;
    use umbrage_cli::scene_file::SceneArgs;

    use super::*;

    /// A coarse bake of a scene.
    fn job(path: &Path) -> Job {
        let coarse = ShadeSettings { tolerance: f64::INFINITY, ..ShadeSettings::default() };
        let settings = BakeSettings { max_form_factor: Some(0.5), shade: coarse, ..BakeSettings::default() };
        Job { path: path.to_path_buf(), reading: SceneArgs::default(), settings, tolerance_by_size: false }
    }

    /// Looks until something new is there.
    fn wait(session: &mut Session, ctx: &Context) {
        let begin = Instant::now();
        while !session.look(ctx) {
            assert!(begin.elapsed() < Duration::from_secs(120), "{:?}", session.failure);
            thread::sleep(Duration::from_millis(20));
        }
    }

    #[test]
    fn a_scene_is_baked_again_when_it_changes_and_stays_when_it_breaks() {
        let scenes = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../../testdata/scenes");
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("scene.glb");
        fs::copy(scenes.join("occluder.glb"), &path).unwrap();
        let ctx = Context::default();
        let mut session = Session::new(job(&path), &ctx);
        wait(&mut session, &ctx);
        assert!(session.loaded.as_ref().unwrap().baked.is_some());
        let before = session.loaded.as_ref().unwrap().tables.vertices.clone();

        fs::copy(scenes.join("furnace.glb"), &path).unwrap();
        wait(&mut session, &ctx);
        let after = session.loaded.as_ref().unwrap().tables.vertices.clone();
        assert_ne!(before, after);

        fs::write(&path, "broken").unwrap();
        while session.failure.is_none() {
            assert!(!session.look(&ctx));
            thread::sleep(Duration::from_millis(20));
        }
        assert_eq!(session.loaded.as_ref().unwrap().tables.vertices, after);
    }

    /// The green that the first material that is no lamp reflects.
    fn green(session: &Session) -> f64 {
        let scene = &session.loaded.as_ref().unwrap().baked.as_ref().unwrap().scene;
        scene.materials.iter().find(|material| !material.emits()).unwrap().reflectance.y
    }

    #[test]
    fn a_scene_is_baked_again_when_what_it_refers_to_changes() {
        let folder = tempfile::tempdir().unwrap();
        let file = |name: &str| folder.path().join(name);
        let square = |y: f64| format!("v 0 {y} 0\nv 0 {y} 1\nv 1 {y} 1\nv 1 {y} 0\n");
        let room = "usemtl paint\nf 1 2 3 4\nusemtl lamp\nf 8 7 6 5\n";
        fs::create_dir(file("lib")).unwrap();
        fs::write(file("room.obj"), format!("mtllib lib/a.mtl\n{}{}{room}", square(0.0), square(1.0))).unwrap();
        let paint = |green: f64| format!("newmtl paint\nKd 0.1 {green} 0.1\nnewmtl lamp\nKe 1 1 1\n");
        let ctx = Context::default();

        // Without its library nothing gives light: that is told, and the library is waited for.
        let mut session = Session::new(job(&file("room.obj")), &ctx);
        while session.failure.is_none() {
            assert!(!session.look(&ctx));
            thread::sleep(Duration::from_millis(20));
        }
        fs::write(file("lib/a.mtl"), paint(0.25)).unwrap();
        wait(&mut session, &ctx);
        assert_eq!((green(&session), &session.failure), (0.25, &None));
        fs::write(file("lib/a.mtl"), paint(0.125)).unwrap();
        wait(&mut session, &ctx);
        assert_eq!(green(&session), 0.125);
        fs::write(file("room.umbrage.toml"), "[materials.paint]\nreflectance = 0.5\n").unwrap();
        wait(&mut session, &ctx);
        assert_eq!(green(&session), 0.5);
    }
}
