//! How far the opening of a file is: the stage that runs, what is done of it, and a way to stop it.

use eframe::egui::{Align, Layout, ProgressBar, Ui};
use umbrage::progress::Stage;

use crate::load::Loading;

/// The stages of a bake, in order.
const STAGES: [Stage; 5] = [Stage::Prepare, Stage::Discontinuity, Stage::Transport, Stage::Solve, Stage::Shade];

/// How far it is, and a button to stop it; tells whether that was clicked.
pub(crate) fn progress(ui: &mut Ui, loading: &Loading) -> bool {
    let (text, share) = match loading.update() {
        None => ("reading".to_owned(), None),
        Some(update) => {
            let number = STAGES.iter().position(|stage| *stage == update.stage).map_or(0, |i| i + 1);
            let counted = if update.total > 0 { format!(" {}/{}", update.done, update.total) } else { String::new() };
            let share = (update.total > 0).then(|| update.done as f32 / update.total as f32);
            (format!("{number} of {}: {}{counted}", STAGES.len(), update.stage), share)
        }
    };
    let bar = ProgressBar::new(share.unwrap_or(0.0)).animate(true);
    ui.add(bar);
    let mut cancels = false;
    ui.horizontal(|ui| {
        ui.label(format!("{text}, {:.0} s", loading.elapsed().as_secs_f64()));
        ui.with_layout(Layout::right_to_left(Align::Center), |ui| {
            if ui.button("Cancel").clicked() {
                cancels = true;
            }
        });
    });
    cancels
}
