//! Convergence plots: one row per scene; on the left error against triangles, on the right against time, both axes
//! logarithmic.

use std::path::Path;

use anyhow::Context;
use plotters::coord::Shift;
use plotters::element::DashedPathElement;
use plotters::prelude::*;
use plotters::style::RGBColor;

use crate::convergence::{Curves, Sample};

/// Width of the drawing and height of a row, in pixels.
const SIZE: (u32, u32) = (1080, 360);
const HEAD: u32 = 56;
const FONT: &str = "sans-serif";
const TEXT: RGBColor = RGBColor(40, 40, 40);
const GRID: RGBColor = RGBColor(225, 225, 225);
const NOISE: RGBColor = RGBColor(120, 120, 120);
/// Dashes of the line of noise and the gaps between them, in pixels.
const DASH: (u32, u32) = (6, 4);
/// With discontinuities, and without: two colours that colour-blind eyes tell apart (Okabe and Ito).
const SERIES: [(&str, RGBColor); 2] =
    [("with discontinuities", RGBColor(0, 114, 178)), ("without, as many triangles", RGBColor(213, 94, 0))];
/// Space around what is drawn, as a factor.
const MARGIN: f64 = 1.25;

type Area<'a> = DrawingArea<SVGBackend<'a>, Shift>;

/// Draws the curves into an SVG file.
pub(crate) fn write(curves: &[Curves], path: &Path) -> anyhow::Result<()> {
    let size = (SIZE.0, HEAD + SIZE.1 * curves.len() as u32);
    let mut text = String::new();
    draw(curves, &SVGBackend::with_string(&mut text, size).into_drawing_area())?;
    std::fs::write(path, text).with_context(|| format!("cannot write {}", path.display()))
}

fn draw(curves: &[Curves], area: &Area<'_>) -> anyhow::Result<()> {
    area.fill(&WHITE)?;
    let (head, rows) = area.split_vertically(HEAD);
    legend(&head)?;
    for (curves, row) in curves.iter().zip(rows.split_evenly((curves.len(), 1))) {
        let (left, right) = row.split_horizontally(SIZE.0 / 2);
        chart(curves, &left, "triangles", |sample| sample.triangles as f64)?;
        chart(curves, &right, "processor time, seconds", |sample| sample.seconds)?;
    }
    Ok(area.present()?)
}

fn legend(area: &Area<'_>) -> anyhow::Result<()> {
    let font = (FONT, 17).into_font().color(&TEXT);
    let middle = HEAD as i32 / 2;
    let mut x = 60;
    for (name, color) in SERIES.into_iter().chain([("noise of the reference", NOISE)]) {
        let line = [(x, middle), (x + 40, middle)];
        if color == NOISE {
            area.draw(&DashedPathElement::new(line, DASH.0, DASH.1, color.stroke_width(2)))?;
        } else {
            area.draw(&PathElement::new(line, color.stroke_width(2)))?;
            area.draw(&Circle::new((x + 20, middle), 4, color.filled()))?;
        }
        area.draw(&Text::new(name, (x + 50, middle - 9), font.clone()))?;
        x += 340;
    }
    Ok(())
}

fn chart(curves: &Curves, area: &Area<'_>, x_axis: &str, of: impl Fn(&Sample) -> f64) -> anyhow::Result<()> {
    let percent = |sample: &Sample| 100.0 * sample.error;
    let samples = || curves.samples.iter().flatten();
    let noise = (curves.noise > 0.0).then_some(100.0 * curves.noise);
    let x = range(samples().map(&of)).context("no samples")?;
    let y = range(samples().map(percent).chain(noise)).context("no samples")?;
    let font = |size: i32| (FONT, size).into_font().color(&TEXT);
    let mut chart = ChartBuilder::on(area)
        .caption(&curves.scene, font(18))
        .margin(12)
        .x_label_area_size(48)
        .y_label_area_size(64)
        .build_cartesian_2d(
            (x[0]..x[1]).log_scale().with_key_points(ticks(x)),
            (y[0]..y[1]).log_scale().with_key_points(ticks(y)),
        )?;
    chart
        .configure_mesh()
        .bold_line_style(GRID)
        .axis_style(TEXT)
        .label_style(font(14))
        .axis_desc_style(font(15))
        .x_desc(x_axis)
        .y_desc("relative RMSE, %")
        .x_label_formatter(&|&x| label(x))
        .y_label_formatter(&|&y| label(y))
        .draw()?;
    if let Some(noise) = noise {
        chart.draw_series(DashedLineSeries::new(
            [(x[0], noise), (x[1], noise)],
            DASH.0,
            DASH.1,
            NOISE.stroke_width(2),
        ))?;
    }
    for (series, (_, color)) in SERIES.into_iter().enumerate() {
        let points = || curves.samples.iter().map(|pair| (of(&pair[series]), percent(&pair[series])));
        chart.draw_series(LineSeries::new(points(), color.stroke_width(2)))?;
        chart.draw_series(points().map(|at| Circle::new(at, 4, color.filled())))?;
    }
    Ok(())
}

/// The least and the greatest value with some space around them; `None` without values above 0.
fn range(values: impl Iterator<Item = f64>) -> Option<[f64; 2]> {
    let [least, most] = values
        .filter(|value| *value > 0.0)
        .fold([f64::INFINITY, 0.0], |[least, most], value| [least.min(value), f64::max(most, value)]);
    (least <= most).then(|| [least / MARGIN, most * MARGIN])
}

/// 1, 2 and 5 times powers of ten that lie in a range.
fn ticks([least, most]: [f64; 2]) -> Vec<f64> {
    let decades = least.log10().floor() as i32..=most.log10().ceil() as i32;
    // A division by an exact power of ten gives the number that is written shortest.
    let scaled =
        |digit: f64, decade: i32| if decade < 0 { digit / 10_f64.powi(-decade) } else { digit * 10_f64.powi(decade) };
    let all = decades.flat_map(|decade| [1.0, 2.0, 5.0].map(|digit| scaled(digit, decade)));
    all.filter(|tick| (least..=most).contains(tick)).collect()
}

/// A number as short as it can be written.
fn label(number: f64) -> String {
    if number >= 1000.0 { crate::table::grouped(number.round() as usize) } else { number.to_string() }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ticks_are_round_numbers_within_the_range() {
        assert_eq!(ticks([0.3, 7.0]), [0.5, 1.0, 2.0, 5.0]);
        assert_eq!(
            ticks([90.0, 2100.0]).iter().map(|&tick| label(tick)).collect::<Vec<_>>(),
            ["100", "200", "500", "1,000", "2,000"]
        );
        assert_eq!(label(0.05), "0.05");
    }

    #[test]
    fn a_drawing_names_its_scenes_axes_and_series() {
        let sample = |triangles: usize, error: f64| Sample { triangles, seconds: 1e-3 * triangles as f64, error };
        let samples = vec![[sample(100, 0.1), sample(110, 0.2)], [sample(1000, 0.01), sample(990, 0.05)]];
        let curves = |scene: &str, noise: f64| Curves { scene: scene.into(), noise, samples: samples.clone() };
        let mut text = String::new();
        draw(
            &[curves("first", 0.003), curves("second", 0.0)],
            &SVGBackend::with_string(&mut text, (1080, 776)).into_drawing_area(),
        )
        .unwrap();
        for word in
            ["first", "second", "triangles", "processor time, seconds", "relative RMSE, %", SERIES[0].0, SERIES[1].0]
        {
            assert!(text.contains(word), "{word}");
        }
        // Two curves of two dots on each of four charts, and a dot in the legend for each.
        assert_eq!(text.matches("<circle").count(), 18);
    }

    #[test]
    fn what_has_no_values_has_no_range() {
        assert_eq!(range([].into_iter()), None);
        assert_eq!(range([0.0].into_iter()), None);
        assert_eq!(range([2.0, 0.0].into_iter()), Some([1.6, 2.5]));
    }
}
