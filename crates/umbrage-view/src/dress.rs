//! The colours of the window.

use eframe::egui::{Color32, Context, Theme};
use umbrage_picture::color::{BACKGROUND, srgb8_from_linear};

/// Colours of text, of text that says less, and of what a bar runs in.
const TEXT: Color32 = Color32::from_gray(205);
const WEAK_TEXT: Color32 = Color32::from_gray(150);
const TRACK: Color32 = Color32::from_gray(12);

/// What is behind the scene, and is seen before it.
pub(crate) fn background() -> Color32 {
    let [r, g, b] = BACKGROUND.map(srgb8_from_linear);
    Color32::from_rgb(r, g, b)
}

/// Dark, so that it does not outshine the scene; text is bright enough to be read beside it.
pub(crate) fn dress(ctx: &Context) {
    ctx.set_theme(Theme::Dark);
    ctx.style_mut_of(Theme::Dark, |style| {
        let visuals = &mut style.visuals;
        visuals.widgets.noninteractive.fg_stroke.color = TEXT;
        visuals.weak_text_color = Some(WEAK_TEXT);
        visuals.extreme_bg_color = TRACK;
    });
}
