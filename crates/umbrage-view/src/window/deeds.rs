//! What hands on the view and clicks in the panel ask for, done.

use anyhow::Context as _;
use eframe::egui::{Context, Pos2, Rect};
use glam::DVec3;
use umbrage_cli::shown::from_file;
use umbrage_formats::write_atomically;

use super::Window;
use crate::draw::Show;
use crate::facts::picked;
use crate::lens::Lens;
use crate::navigate::Asked;
use crate::panel::Wish;
use crate::pick::{Hit, nearest};
use crate::save::free_name;
use crate::screen::Lines;
use crate::viewpoint::Viewpoint;

impl Window {
    pub(super) fn answer(&mut self, asked: Asked, lens: &Lens, rect: Rect, aspect: f64) {
        match asked {
            Asked::Pick(place) => {
                self.hit = self.under(place, lens, rect);
                self.tell();
            }
            Asked::Centre(place) => {
                if let (Some(hit), Some(view)) = (self.under(place, lens, rect), &mut self.view) {
                    view.look_at(hit.point_m, DVec3::NEG_Z);
                }
            }
            Asked::Fit => self.fit(aspect),
            Asked::Begin => self.view = self.begin,
            Asked::Panel => self.controls.open = !self.controls.open,
        }
    }

    fn fit(&mut self, aspect: f64) {
        if let (Some(view), Some(loaded)) = (&mut self.view, &self.session.loaded) {
            view.fit(loaded.tables.world_bounds_m(), aspect);
        }
    }

    fn under(&self, place: Pos2, lens: &Lens, rect: Rect) -> Option<Hit> {
        let file = &self.session.loaded.as_ref()?.shown.file;
        let at = (place - rect.min) / rect.size();
        nearest(file, lens.eye_m, lens.ray(f64::from(2.0 * at.x - 1.0), f64::from(1.0 - 2.0 * at.y)))
    }

    /// Tells of the point that was hit, and marks its patch.
    pub(super) fn tell(&mut self) {
        let Some(loaded) = &self.session.loaded else { return };
        self.picked = self.hit.as_ref().map(|hit| picked(loaded, hit, self.controls.unit));
        let marks = self.picked.as_ref().map_or(&[][..], |picked| &picked.marks);
        self.screen.set_lines(Lines::Picked, marks);
    }

    pub(super) fn grant(&mut self, wish: Wish, ctx: &Context, aspect: f64) {
        match wish {
            Wish::Fit => self.fit(aspect),
            Wish::Begin => self.view = self.begin,
            Wish::Camera(number) => {
                let camera = self.session.loaded.as_ref().and_then(|loaded| {
                    let camera = loaded.shown.file.cameras.get(number).map(from_file)?;
                    let mut view = Viewpoint::new(&camera);
                    view.turn_around(0.5 * loaded.tables.size_m(), false);
                    Some(view)
                });
                self.view = camera.or(self.view);
            }
            Wish::Bake(settings) => self.session.bake(settings, ctx),
            Wish::Cancel => self.session.cancel(),
            Wish::Hide => self.controls.open = false,
            Wish::SaveView => self.status = told(self.save_view()),
            Wish::SaveBaked => self.status = told(self.save_baked()),
        }
    }

    fn save_view(&mut self) -> anyhow::Result<String> {
        let loaded = self.session.loaded.as_ref().context("nothing is shown yet")?;
        let scale = self.controls.unit.scale(self.controls.scale_end(&loaded.shown.file));
        let scale = (self.controls.look.show == Show::Irradiance).then_some(scale);
        let picture = self.screen.picture(&loaded.tables, scale.as_ref()).context("nothing is drawn yet")??;
        let path = free_name(&self.session.job.path, "view", "png");
        write_atomically(&path, &picture.png()?)?;
        Ok(path.display().to_string())
    }

    fn save_baked(&self) -> anyhow::Result<String> {
        let baked = self.session.loaded.as_ref().and_then(|loaded| loaded.baked.as_ref());
        let path = free_name(&self.session.job.path, "baked", "glb");
        write_atomically(&path, &baked.context("nothing is baked yet")?.glb)?;
        Ok(path.display().to_string())
    }
}

/// What became of a save.
fn told(saved: anyhow::Result<String>) -> String {
    match saved {
        Ok(path) => format!("Saved {path}"),
        Err(error) => format!("Not saved: {error:#}"),
    }
}
