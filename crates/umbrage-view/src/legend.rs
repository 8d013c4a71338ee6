//! The legend of false colours, in the lower left corner of the view.

use eframe::egui::{Align2, Color32, FontId, Painter, Pos2, Rect, pos2, vec2};
use umbrage_cli::look::Unit;
use umbrage_picture::Scale;
use umbrage_picture::color::{on_scale, srgb8_from_linear};

use crate::facts::unit_name;

/// Sizes in points.
const MARGIN: f32 = 10.0;
const PADDING: f32 = 12.0;
const BAR: [f32; 2] = [240.0, 12.0];
const ROOM_FOR_NUMBERS: f32 = 18.0;
const ROOM_FOR_UNIT: f32 = 48.0;
/// Strips that the bar is made of.
const STRIPS: usize = 120;

const PAPER: Color32 = Color32::from_black_alpha(190);
const INK: Color32 = Color32::from_gray(225);

/// Draws the legend of `scale`, which is in `unit`, within `view`, narrower where there is little room.
pub(crate) fn draw(painter: &Painter, view: Rect, unit: Unit, scale: &Scale) {
    let bar_width = BAR[0].min(view.width() - 2.0 * (MARGIN + PADDING) - ROOM_FOR_UNIT);
    if bar_width < BAR[1] {
        return;
    }
    let size = vec2(bar_width + 2.0 * PADDING + ROOM_FOR_UNIT, BAR[1] + 2.0 * PADDING + ROOM_FOR_NUMBERS);
    let paper = Rect::from_min_size(view.left_bottom() + vec2(MARGIN, -MARGIN - size.y), size);
    painter.rect_filled(paper, 6.0, PAPER);
    let bar = Rect::from_min_size(paper.min + vec2(PADDING, PADDING), vec2(bar_width, BAR[1]));
    for strip in 0..STRIPS {
        let [from, to] = [strip, strip + 1].map(|i| i as f32 / STRIPS as f32);
        let [r, g, b] = on_scale(scale.stops, 0.5 * (from + to)).map(srgb8_from_linear);
        let x = |share| bar.left() + share * bar.width();
        // Half a point more, so that no gap is seen between strips.
        let right = (x(to) + 0.5).min(bar.right());
        painter.rect_filled(Rect::from_x_y_ranges(x(from)..=right, bar.y_range()), 0.0, Color32::from_rgb(r, g, b));
    }
    let labels = scale.labels();
    // Every other number where they would touch.
    let step = if bar_width < 170.0 { labels.len() - 1 } else { 1 };
    for (share, text) in labels.iter().step_by(step) {
        let x = bar.left() + *share as f32 * bar.width();
        painter.line_segment([pos2(x, bar.bottom()), pos2(x, bar.bottom() + 4.0)], (1.0, INK));
        write(painter, pos2(x, bar.bottom() + 5.0), Align2::CENTER_TOP, text);
    }
    write(painter, pos2(bar.right() + 8.0, bar.center().y), Align2::LEFT_CENTER, unit_name(unit));
}

fn write(painter: &Painter, at: Pos2, align: Align2, text: &str) {
    painter.text(at, align, text, FontId::proportional(12.0), INK);
}
