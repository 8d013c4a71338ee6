//! A sheet of drawings, as SVG: a title, a legend, and a drawing of each receiver with a scale bar of its own.
//!
//! Drawings stand in rows of cells of one width; each is as large as its cell allows. Styles are classes of one style
//! sheet, so that a sheet is small and its look can be changed in one place.

use std::fmt::Write;

use glam::DVec2;

/// Width of a cell and the most that a drawing in it is high, in pixels of the drawing.
const CELL: DVec2 = DVec2::new(420.0, 420.0);
/// Between cells, and around the sheet.
const GAP: f64 = 28.0;
/// The legend needs so much.
const LEAST_WIDTH: f64 = 600.0;
/// Height of a line of text.
const LINE: f64 = 18.0;
const COLUMNS: usize = 3;
/// A sheet with more drawings than this is not looked at; the JSON has them all.
const MOST_DRAWINGS: usize = 60;

const STYLE: &str = "\
text{font:13px sans-serif;fill:#222}.title{font-size:16px;font-weight:bold}.small{font-size:11px;fill:#555}\
line,polygon,path{vector-effect:non-scaling-stroke}\
.face{fill:#fafafa;stroke:#999;stroke-width:0.8}.lit{stroke:#f08a00;stroke-opacity:.6;stroke-width:.5}\
.d0{stroke:#d81e1e}.d1{stroke:#f08a00}.d2{stroke:#2869e6}.points{stroke:#8a8a8a}.triangle{stroke:#c8c8c8}\
.d0,.d1,.d2,.points,.triangle{fill:none;stroke-linecap:round}.bar{stroke:#222;stroke-width:2}";

/// A line of a drawing.
#[derive(Clone, Debug)]
pub(crate) struct Line {
    pub(crate) ends_m: [DVec2; 2],
    pub(crate) class: &'static str,
    /// In pixels.
    pub(crate) width: f64,
}

/// A polygon of a drawing.
#[derive(Clone, Debug)]
pub(crate) struct Polygon {
    pub(crate) corners_m: Vec<DVec2>,
    pub(crate) class: &'static str,
    /// Grey level of its inside, 0 to 1; `None` as the class says.
    pub(crate) grey: Option<f64>,
}

/// A drawing of a receiver.
#[derive(Clone, Debug, Default)]
pub(crate) struct Drawing {
    pub(crate) title: String,
    pub(crate) polygons: Vec<Polygon>,
    /// Drawn in order, over the polygons.
    pub(crate) lines: Vec<Line>,
}

impl Drawing {
    fn bounds_m(&self) -> (DVec2, DVec2) {
        let corners = || self.polygons.iter().flat_map(|polygon| polygon.corners_m.iter().copied());
        (corners().fold(DVec2::INFINITY, DVec2::min), corners().fold(DVec2::NEG_INFINITY, DVec2::max))
    }

    /// Area of the polygons, in square metres: the largest receivers come first.
    fn area_m2(&self) -> f64 {
        let area = |corners: &[DVec2]| {
            (0..corners.len()).map(|i| corners[i].perp_dot(corners[(i + 1) % corners.len()])).sum::<f64>().abs()
        };
        0.5 * self.polygons.iter().map(|polygon| area(&polygon.corners_m)).sum::<f64>()
    }
}

/// A sheet of drawings.
#[derive(Clone, Debug, Default)]
pub(crate) struct Sheet {
    pub(crate) title: String,
    /// Class, width in pixels and meaning of each kind of line.
    pub(crate) legend: Vec<(&'static str, f64, String)>,
    /// Remarks under the legend.
    pub(crate) notes: Vec<String>,
    pub(crate) drawings: Vec<Drawing>,
}

impl Sheet {
    /// The sheet as SVG, largest receivers first.
    pub(crate) fn svg(mut self) -> String {
        self.drawings.sort_by(|p, q| q.area_m2().total_cmp(&p.area_m2()));
        if self.drawings.len() > MOST_DRAWINGS {
            let more = self.drawings.len() - MOST_DRAWINGS;
            self.notes.push(format!("{more} smaller receivers are not drawn; the JSON has them"));
            self.drawings.truncate(MOST_DRAWINGS);
        }
        let columns = self.drawings.len().clamp(1, COLUMNS);
        let width = (GAP + columns as f64 * (CELL.x + GAP)).max(LEAST_WIDTH);
        let mut body = String::new();
        let mut y = GAP;
        text(&mut body, DVec2::new(GAP, y), "title", &self.title);
        for (class, stroke, meaning) in &self.legend {
            y += LINE;
            let ends = [DVec2::new(GAP, y - 4.0), DVec2::new(GAP + 40.0, y - 4.0)];
            line(&mut body, ends, class, *stroke);
            text(&mut body, DVec2::new(GAP + 50.0, y), "", meaning);
        }
        for note in &self.notes {
            y += LINE;
            text(&mut body, DVec2::new(GAP, y), "small", note);
        }
        y += GAP;
        for row in self.drawings.chunks(columns) {
            let mut height = 0.0_f64;
            for (i, drawing) in row.iter().enumerate() {
                let at = DVec2::new(GAP + i as f64 * (CELL.x + GAP), y);
                height = height.max(draw(&mut body, drawing, at));
            }
            y += height + GAP;
        }
        format!(
            "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{width}\" height=\"{y}\" viewBox=\"0 0 {width} {y}\">\n\
             <style>{STYLE}</style>\n<rect width=\"100%\" height=\"100%\" fill=\"#fff\"/>\n{body}</svg>\n",
        )
    }
}

/// Draws into a cell whose upper left corner is `at`; the height that it takes.
fn draw(body: &mut String, drawing: &Drawing, at: DVec2) -> f64 {
    let (lo, hi) = drawing.bounds_m();
    let size = (hi - lo).max(DVec2::splat(f64::MIN_POSITIVE));
    let scale = (CELL / size).min_element();
    let place = |p: DVec2| at + DVec2::new((p.x - lo.x) * scale, LINE + (hi.y - p.y) * scale);
    text(body, at + DVec2::Y * 0.7 * LINE, "small", &drawing.title);
    for shape in &drawing.polygons {
        polygon(body, shape.corners_m.iter().map(|&p| place(p)), shape.class, shape.grey);
    }
    for stroke in &drawing.lines {
        line(body, stroke.ends_m.map(place), stroke.class, stroke.width);
    }
    let bar_m = bar_length_m(0.4 * size.x.max(0.25 * size.y));
    let below = at + DVec2::Y * (LINE + size.y * scale + 0.7 * LINE);
    line(body, [below, below + DVec2::X * (bar_m * scale)], "bar", 2.0);
    text(body, below + DVec2::new(bar_m * scale + 8.0, 4.0), "small", &length(bar_m));
    2.0 * LINE + size.y * scale
}

/// The greatest of 1, 2, 5 times a power of ten that is at most `most_m`.
fn bar_length_m(most_m: f64) -> f64 {
    let power = 10.0_f64.powf(most_m.log10().floor());
    [5.0, 2.0].into_iter().map(|step| step * power).find(|&step_m| step_m <= most_m).unwrap_or(power)
}

/// A round length with its unit.
fn length(metres: f64) -> String {
    let (value, unit) = match metres {
        1.0.. => (metres, "m"),
        0.01.. => (metres * 100.0, "cm"),
        _ => (metres * 1000.0, "mm"),
    };
    format!("{} {unit}", (value * 1e6).round() / 1e6)
}

// Writing to a string cannot fail: the results of `write!` below are of no interest.

fn text(body: &mut String, at: DVec2, class: &str, text: &str) {
    let escaped = text.replace('&', "&amp;").replace('<', "&lt;");
    let _ = writeln!(body, "<text x=\"{:.1}\" y=\"{:.1}\" class=\"{class}\">{escaped}</text>", at.x, at.y);
}

fn line(body: &mut String, [from, to]: [DVec2; 2], class: &str, width: f64) {
    let _ = writeln!(
        body,
        "<line x1=\"{:.2}\" y1=\"{:.2}\" x2=\"{:.2}\" y2=\"{:.2}\" class=\"{class}\" stroke-width=\"{width:.2}\"/>",
        from.x, from.y, to.x, to.y
    );
}

fn polygon(body: &mut String, corners: impl Iterator<Item = DVec2>, class: &str, grey: Option<f64>) {
    let points: Vec<String> = corners.map(|p| format!("{:.2},{:.2}", p.x, p.y)).collect();
    let fill = grey.map_or(String::new(), |level| {
        let level = (255.0 * level.clamp(0.0, 1.0)).round();
        format!(" fill=\"rgb({level},{level},{level})\"")
    });
    let _ = writeln!(body, "<polygon points=\"{}\" class=\"{class}\"{fill}/>", points.join(" "));
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn scale_bars_are_round() {
        assert_eq!([0.7, 3.0, 0.019, 10.0].map(bar_length_m).map(length), ["50 cm", "2 m", "1 cm", "10 m"]);
        assert_eq!(length(bar_length_m(0.0031)), "2 mm");
    }

    #[test]
    fn a_sheet_has_every_line_once_and_text_is_escaped() {
        let square = [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)].map(DVec2::from).to_vec();
        let drawing = Drawing {
            title: "a < b & c".into(),
            polygons: vec![Polygon { corners_m: square, class: "face", grey: None }],
            lines: vec![Line { ends_m: [DVec2::ZERO, DVec2::ONE], class: "d1", width: 1.0 }],
        };
        let sheet = Sheet { drawings: vec![drawing; 2], ..Sheet::default() };
        let svg = sheet.svg();
        assert_eq!(svg.matches("class=\"d1\"").count(), 2);
        assert_eq!(svg.matches("a &lt; b &amp; c").count(), 2);
        assert_eq!(svg.matches("class=\"bar\"").count(), 2);
    }
}
