//! What a bake tells at its end: how much of what, how long, and what was mended.

use std::fmt::Write;
use std::time::Duration;

use umbrage::bake::{MAX_ENERGY_ERROR, MAX_ERROR_ESTIMATE, Report};
use umbrage::prepare::PrepareReport;
use umbrage::scene::Rgb;
use umbrage::shade::{LampAccount, LampDefect};
use umbrage::solve::EnergyAccount;
use umbrage_formats::{Written, shortened};

use crate::light::{Fluxes, Units};
use crate::memory;

/// The summary of a bake that took `elapsed` with reading and writing; `coarser` says at which tolerance and why, where
/// that is not the one that was asked for.
pub(crate) fn summary(
    report: &Report,
    fluxes: &Fluxes,
    written: &Written,
    elapsed: Duration,
    coarser: Option<String>,
    warnings: usize,
) -> String {
    let mut text = format!("Baked in {}\n", seconds(elapsed.as_secs_f64()));
    let mut line = |name: &str, value: String| {
        // Writing to a string cannot fail.
        let _ = writeln!(text, "  {name:<12}  {value}");
    };
    line("light", format!("{} (red, green, blue)", fluxes.describe()));
    let units = fluxes.units();
    let [d0, d1, d2] = report.d_segments.map(grouped);
    line("polygons", grouped(report.prepare.polygons));
    line("faces", grouped(report.faces));
    if let Some(hidden) = hidden(&report.prepare) {
        line("hidden", hidden);
    }
    let reflected = match report.secondary {
        0 => String::new(),
        n => format!(", and {} of reflected light", grouped(n)),
    };
    line("d-segments", format!("{d0} of degree 0, {d1} of degree 1, {d2} of degree 2{reflected}"));
    line("patches", grouped(report.patches));
    let [median, low] = report.compactness;
    line("compactness", format!("{median:.2} median, {low:.2} at the 5th percentile (of a square: 0.79)"));
    // Links that were kept from a bake before take no time.
    let each = match 1e6 * report.seconds_a_link() {
        us if us > 0.0 => format!(", {us:.1} µs each"),
        _ => String::new(),
    };
    let a_leaf = report.links_a_leaf();
    line(
        "links",
        match report.samples {
            Some(samples) => format!("none: reflected light is fitted to {} samples", grouped(samples)),
            None => format!("{}: {a_leaf:.1} for each patch that is not split{each}", grouped(report.links)),
        },
    );
    line("vertices", grouped(report.vertices));
    line("triangles", grouped(report.triangles));
    if let Some(coarser) = coarser {
        line("tolerance", coarser);
    }
    line("error", error(report));
    let iterations = count(report.iterations, "iteration");
    line("residual", format!("{:.1e} of the light still changes after {iterations}", report.residual));
    line("energy", energy(&report.energy));
    if !report.lamps.is_empty() {
        line("lamps", lamps(&report.lamps, units));
        lamp_defects(report, units).into_iter().for_each(|defect| line("", defect));
    }
    let clipped = match written.clipped_vertices {
        0 => String::new(),
        n => format!(", which cuts off {} at white", count(n, "vertex|vertices")),
    };
    line("exposure", format!("{}{clipped}", exposure(written.exposure_k)));
    let stages: Vec<String> = report.seconds.iter().map(|(stage, s)| format!("{stage} {}", seconds(*s))).collect();
    line("time", stages.join(", "));
    if let Some(bytes) = memory::peak_bytes() {
        line("peak memory", self::bytes(bytes));
    }
    let mut mended = mended(&report.prepare);
    if report.flat_triangles > 0 {
        mended.push(count(
            report.flat_triangles,
            "triangle flat as a needle taken out|triangles flat as a needle taken out",
        ));
    }
    if !mended.is_empty() {
        line("mended", mended.join(", "));
    }
    if warnings > 0 {
        line("warnings", format!("{}: see above", grouped(warnings)));
    }
    text
}

/// An exposure as it can be given to `--exposure`: what was chosen has three digits, and what was asked for has its own.
pub(crate) fn exposure(k: f64) -> String {
    if (1e-4..1e6).contains(&k) { format!("{k}") } else { format!("{k:e}") }
}

/// The share of hidden sides, where there are any.
fn hidden(prepare: &PrepareReport) -> Option<String> {
    let percent = 100.0 * prepare.hidden_share;
    (percent > 0.0).then(|| {
        format!("{percent:.1} % of the area of all sides is hidden: no light reaches it; --keep-hidden keeps it")
    })
}

/// The estimate of the error. It is one of interpolation; what values at vertices err, nothing here knows.
fn error(report: &Report) -> String {
    if report.error > MAX_ERROR_ESTIMATE {
        return "unknown between vertices: the triangles do not resolve the light".into();
    }
    let of = match report.samples {
        Some(_) => "between vertices and by the fit of reflected light (estimate; `umbrage verify` measures it)",
        None => "between vertices (estimate; `umbrage verify` measures it there and at vertices)",
    };
    format!("{}, {of}", share_of_mean(report))
}

/// The estimated error as a share of the mean irradiance, with the sides that the mean is over.
pub(crate) fn share_of_mean(report: &Report) -> String {
    let sides = if report.prepare.hidden_share > 0.0 { "the sides that are not hidden" } else { "all sides" };
    format!("{:.2} % of the mean irradiance of {sides}", 100.0 * report.error)
}

/// Where the light goes, as shares of what is emitted.
fn energy(account: &EnergyAccount) -> String {
    let emitted = account.emitted_w.element_sum();
    if emitted <= 0.0 {
        return "none is emitted".into();
    }
    let percent = |part: Rgb| 100.0 * part.element_sum() / emitted;
    let on_backs = match percent(account.on_backs_w) {
        none if none < 0.005 => String::new(),
        some => format!(", {some:.2} % falls on the backs of surfaces"),
    };
    let fates = format!(
        "{:.2} % is absorbed, {:.2} % leaves the scene{on_backs}",
        percent(account.absorbed_w),
        percent(account.leaving_w)
    );
    let error = 100.0 * account.error();
    if error.abs() <= 100.0 * MAX_ENERGY_ERROR {
        return format!("{fates}: {}", balance(error));
    }
    format!("cannot be true: of what is emitted {fates}; {}", balance(error))
}

/// How far an account is from 100 %, in words.
fn balance(error_percent: f64) -> String {
    match format!("{:.2}", error_percent.abs()) {
        zero if zero == "0.00" => "it balances".into(),
        lost if error_percent < 0.0 => format!("{lost} % is missing"),
        made => format!("{made} % is too much"),
    }
}

/// How much of the light of all lamps falls where, in watts that are means of the three colours.
fn lamps(accounts: &[LampAccount], Units { flux, .. }: Units) -> String {
    let sum = |part: fn(&LampAccount) -> Rgb| rounded(accounts.iter().map(part).sum::<Rgb>().element_sum() / 3.0);
    format!(
        "{} {flux} sent; {} {flux} fall on surfaces, which show {} {flux}; {} {flux} on backs, {} {flux} leave the scene, {} {flux} fade",
        sum(|lamp| lamp.sent_w),
        sum(|lamp| lamp.expected_w),
        sum(|lamp| lamp.received_w),
        sum(|lamp| lamp.on_backs_w),
        sum(|lamp| lamp.escaped_w),
        sum(|lamp| lamp.faded_w)
    )
}

/// What `prepare` had to guess.
pub(crate) fn guessed(prepare: &PrepareReport) -> Option<String> {
    let n = prepare.turned_polygons;
    (n > 0).then(|| turned(n))
}

/// The lamps whose light is not shown as it falls.
pub(crate) fn lamp_defects(report: &Report, Units { flux, .. }: Units) -> Vec<String> {
    let described = |lamp: &LampAccount| {
        let watts = |flux_w: Rgb| rounded(flux_w.element_sum() / 3.0);
        let (sent, expected, received) = (watts(lamp.sent_w), watts(lamp.expected_w), watts(lamp.received_w));
        let text = match lamp.defect()? {
            LampDefect::LightsNothing => format!(
                "lamp {:?} lights nothing: of the {sent} {flux} that it gives none falls on the front of a surface",
                shortened(&lamp.name)
            ),
            LampDefect::OffBy(share) => format!(
                "lamp {:?} is in error by {:+.0} %: {expected} {flux} of its light fall on surfaces, which show {received} {flux}",
                shortened(&lamp.name),
                100.0 * share
            ),
        };
        Some(text)
    };
    report.lamps.iter().filter_map(described).collect()
}

/// That polygons were turned over.
pub(crate) fn turned(n: usize) -> String {
    let polygons = count(n, "polygon of closed shells looks|polygons of closed shells look");
    format!(
        "{polygons} another way than most of their shells, and were turned over. That is a guess: where it is wrong, turn \
         them in the file or make their material double-sided"
    )
}

/// What `prepare` mended, where it mended anything.
pub(crate) fn mended(prepare: &PrepareReport) -> Vec<String> {
    [
        (prepare.welded_corners, "welded corner"),
        (prepare.degenerate_polygons, "polygon without area left out|polygons without area left out"),
        (prepare.duplicate_polygons, "polygon that was there twice|polygons that were there twice"),
        (prepare.nonplanar_polygons, "polygon that was not plane|polygons that were not plane"),
        (prepare.unusable_normals, "normal turned away from its polygon|normals turned away from their polygons"),
        (prepare.turned_polygons, "polygon turned over|polygons turned over"),
        (prepare.t_vertices, "T-vertex of the input|T-vertices of the input"),
        (prepare.contact_edges, "contact edge"),
        (prepare.overlaps, "overlap"),
        (prepare.dropped_cuts, "cut too small to be made|cuts too small to be made"),
    ]
    .into_iter()
    .filter(|(n, _)| *n > 0)
    .map(|(n, nouns)| count(n, nouns))
    .collect()
}

/// `1 noun`, `2,000 nouns`; the plural stands after a bar where it is more than an `s`.
pub(crate) fn count(n: usize, nouns: &str) -> String {
    match (n, nouns.split_once('|')) {
        (1, Some((one, _))) => format!("1 {one}"),
        (1, None) => format!("1 {nouns}"),
        (_, Some((_, many))) => format!("{} {many}", grouped(n)),
        (_, None) => format!("{} {nouns}s", grouped(n)),
    }
}

/// A number with its thousands apart: `1,234,567`.
pub(crate) fn grouped(n: usize) -> String {
    let digits = n.to_string();
    let mut text = String::new();
    for (i, digit) in digits.chars().enumerate() {
        if i > 0 && (digits.len() - i).is_multiple_of(3) {
            text.push(',');
        }
        text.push(digit);
    }
    text
}

/// A time: `0.12 s`, `12.3 s`, `2 min 5 s`.
pub(crate) fn seconds(s: f64) -> String {
    match s {
        _ if s < 10.0 => format!("{s:.2} s"),
        _ if s < 60.0 => format!("{s:.1} s"),
        _ => format!("{} min {} s", (s.round() / 60.0).floor(), s.round() % 60.0),
    }
}

/// A size: `512 B`, `1.5 MiB`.
pub(crate) fn bytes(n: u64) -> String {
    let (mut size, mut unit) = (n as f64, "B");
    for larger in ["KiB", "MiB", "GiB", "TiB"] {
        if size < 1024.0 {
            break;
        }
        (size, unit) = (size / 1024.0, larger);
    }
    if unit == "B" || size >= 100.0 { format!("{size:.0} {unit}") } else { format!("{size:.1} {unit}") }
}

/// A colour, or a quantity at red, green and blue.
pub(crate) fn rgb(color: Rgb) -> String {
    color.to_array().map(rounded).join(" ")
}

/// A number with four digits that count.
pub(crate) fn rounded(x: f64) -> String {
    // The sum of nothing is -0.
    let x = x + 0.0;
    let decimals = if x == 0.0 || !x.is_finite() { 0 } else { (3 - x.abs().log10().floor() as i32).clamp(0, 9) };
    let text = format!("{x:.*}", decimals as usize);
    if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.').into() } else { text }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_short() {
        assert_eq!(
            [-0.0, 0.5, 123_456.0, 1.234_56, -0.000_123_45].map(rounded),
            ["0", "0.5", "123456", "1.235", "-0.0001234"]
        );
    }

    #[test]
    fn what_cannot_be_true_is_no_fact() {
        let account = |absorbed: f64, leaving: f64| EnergyAccount {
            emitted_w: Rgb::ONE,
            absorbed_w: Rgb::splat(absorbed),
            leaving_w: Rgb::splat(leaving),
            ..EnergyAccount::default()
        };
        assert_eq!(energy(&account(0.75, 0.25)), "75.00 % is absorbed, 25.00 % leaves the scene: it balances");
        assert_eq!(energy(&account(0.74, 0.25)), "74.00 % is absorbed, 25.00 % leaves the scene: 1.00 % is missing");
        let false_one = energy(&account(6.0, 0.0));
        assert!(false_one.starts_with("cannot be true") && false_one.ends_with("500.00 % is too much"), "{false_one}");
        let mut report = Report { error: 0.0042, ..Report::default() };
        assert!(error(&report).starts_with("0.42 % of the mean irradiance of all sides, between vertices"));
        assert_eq!(hidden(&report.prepare), None);
        report.prepare.hidden_share = 0.25;
        assert!(error(&report).contains("of the sides that are not hidden, between"), "{}", error(&report));
        assert!(
            hidden(&report.prepare).is_some_and(|text| text.starts_with("25.0 % of the area of all sides is hidden"))
        );
        report.error = 329_749.27;
        assert!(error(&report).starts_with("unknown"), "{}", error(&report));
    }

    #[test]
    fn numbers_are_told_readably() {
        assert_eq!([0, 999, 1000, 1234567].map(grouped), ["0", "999", "1,000", "1,234,567"]);
        assert_eq!([0.123, 12.34, 59.94, 125.2].map(seconds), ["0.12 s", "12.3 s", "59.9 s", "2 min 5 s"]);
        assert_eq!([512, 1536, 300 << 20].map(bytes), ["512 B", "1.5 KiB", "300 MiB"]);
        assert_eq!(count(1, "node") + " " + &count(2, "T-vertex|T-vertices"), "1 node 2 T-vertices");
    }
}
