//! Every break of the light has its d-segment, and every d-segment its break: along random lines on the receivers of
//! random scenes, where the light is calculated without the library.
//!
//! A few scenes in every run; `UMBRAGE_PROOF_SCENES=1000` looks at more, `UMBRAGE_PROOF_FIRST=7` begins at another.

use glam::DVec3;
use umbrage::bake::{Traced, trace};
use umbrage::discontinuity::{DSegment, Degree, Event, Features};
use umbrage::id::EdgeId;
use umbrage::progress::Progress;
use umbrage::visibility::Visibility;

use super::alone;
use super::breaks::{self, Break};
use super::random::{self, Random, Stage};
use super::two_sided_scenes;

/// Scenes of every run, and lines on each of their two receivers.
const SCENES: u64 = 30;
const LINES: usize = 2;
/// Pieces of buildings of every run.
const BUILDINGS: u64 = 10;
/// Two-sided scenes of every run.
const TWO_SIDED: u64 = 20;
/// Between where a break is found and where the d-segment is, in metres: rounding of vertices, magnified.
const PLACE_M: f64 = 3e-5;
/// Jumps are compared by what they do over this distance, in metres: slope and curvature then have one unit.
const REACH_M: f64 = 0.1;
/// A break this far from others, in metres, is alone enough for its jump to be measured.
const ALONE_M: f64 = 4e-3;
/// Jumps of degrees are told apart, and their strengths compared, within this share.
const STRENGTH: f64 = 0.02;
/// Lines that meet the end of a d-segment nearer than this, in metres, may or may not meet the segment.
const AT_END_M: f64 = 1e-4;

/// Corners are rounded to 2e-6 m, by which polygons are not plane: so faint are the kinks of their folds. In W/m2,
/// W/m3, W/m4.
const FAINT: [f64; 3] = [1e-9, 1e-5, 0.0];
/// Smooth places of a line at which the test for events of occluders alone is tested itself.
const ASKED: u32 = 8;

/// Places of a line at which it is asked on which side of a curve they are; the step of differences there, in metres.
const SAMPLES: u32 = 64;
const STEP_M: f64 = 1e-6;
/// A chord leaves its curve by at most this share of its length.
const MOST_SAG: f64 = 0.1;

/// A crossing of the line with a d-segment.
#[derive(Clone, Copy, Debug)]
struct Crossing {
    segment: DSegment,
    at: f64,
    /// What the line sees of its jump, in the jump's own unit along the line.
    along: f64,
    /// The line passes the segment's end.
    at_end: bool,
}

/// What was counted.
#[derive(Clone, Debug, Default)]
struct Tally {
    lines: usize,
    /// Breaks that have a d-segment; owed to occluders alone; with neither.
    explained: usize,
    owed: usize,
    missed: Vec<String>,
    /// Breaks where the eye passes the plane of two parallel edges of occluders.
    in_plane: usize,
    /// Breaks without d-segment across which nothing up to the curvature jumps above the noise: jumps of higher
    /// derivatives, where an emitter reaches through the receiver's plane, and rounding.
    faint: usize,
    /// Effects of the two first, and of those in a plane, in W/m2.
    explained_effect: f64,
    owed_effect: f64,
    in_plane_effect: f64,
    /// Smooth places at which the test for events of occluders alone was asked, and its false alarms.
    asked: usize,
    alarms: usize,
    /// d-segments above the threshold that have a break; that have none.
    shown: usize,
    /// Of those, of three edges.
    of_three: usize,
    invented: Vec<String>,
    /// Breaks of a single event whose measured degree and strength agree; that do not.
    measured: usize,
    wrong: Vec<String>,
}

/// A line on a receiver.
struct Line {
    from: DVec3,
    direction: DVec3,
    length: f64,
    normal: DVec3,
}

impl Line {
    fn point(&self, t: f64) -> DVec3 {
        self.from + self.direction * t
    }

    /// Where it crosses a segment of its plane, and the sine of the angle.
    fn crossing(&self, ends: [DVec3; 2]) -> Option<(f64, f64, bool)> {
        let along = ends[1] - ends[0];
        let across = along.cross(self.normal);
        let sine = self.direction.dot(across) / across.length();
        let t = (ends[0] - self.from).dot(across) / self.direction.dot(across);
        let length = along.length();
        let share_m = (self.point(t) - ends[0]).dot(along) / length;
        let slack = AT_END_M / sine.abs().max(0.01);
        let inside = (-slack..=length + slack).contains(&share_m) && (0.0..=self.length).contains(&t);
        let at_end = share_m < slack || share_m > length - slack;
        (t.is_finite() && inside).then_some((t, sine.abs(), at_end))
    }

    /// The same for a chord of a curve from which three lines are seen to meet: where it crosses the curve itself.
    fn crossings_of_curve(&self, ends: [DVec3; 2], lines: [[DVec3; 2]; 3]) -> Vec<(f64, f64, bool)> {
        let along = (ends[1] - ends[0]).normalize();
        let (length, middle) = (ends[0].distance(ends[1]), self.direction.dot(ends[0].midpoint(ends[1]) - self.from));
        let off = |t: f64| apart(self.point(t), lines);
        let at = |i: u32| middle + length * (2.0 * f64::from(i) / f64::from(SAMPLES) - 1.0);
        let changes = (0..SAMPLES).map(|i| (at(i), at(i + 1))).filter(|&(from, to)| off(from) * off(to) < 0.0);
        let root = |(mut from, mut to): (f64, f64)| {
            for _ in 0..50 {
                let middle = 0.5 * (from + to);
                if off(from) * off(middle) <= 0.0 { to = middle } else { from = middle }
            }
            from
        };
        let crossing = |t: f64| {
            let d = self.point(t) - ends[0];
            let share_m = d.dot(along);
            let beside_m = (d - share_m * along).length();
            let across = self.normal.cross(self.direction);
            let slope = |v: DVec3| apart(self.point(t) + STEP_M * v, lines) - apart(self.point(t) - STEP_M * v, lines);
            let (forward, sideways) = (slope(self.direction), slope(across));
            let inside = (-AT_END_M..=length + AT_END_M).contains(&share_m) && beside_m <= MOST_SAG * length;
            let at_end = share_m < AT_END_M || share_m > length - AT_END_M;
            let sine = forward.abs() / forward.hypot(sideways);
            (inside && (0.0..=self.length).contains(&t)).then_some((t, sine, at_end))
        };
        changes.map(root).filter_map(crossing).collect()
    }
}

/// Six times the volume that the directions of the planes through an eye and three lines span: zero where a ray from
/// the eye passes all three.
fn apart(eye: DVec3, lines: [[DVec3; 2]; 3]) -> f64 {
    let [a, b, c] = lines.map(|[p, q]| (p - eye).cross(q - eye).normalize());
    a.cross(b).dot(c)
}

/// A receiver, in the coordinates of `random::scene`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Side {
    Floor,
    Wall,
    UnderFloor,
}

/// A line on a receiver of a stage that stands at `origin`.
fn random_line(random: &mut Random, side: Side, origin: DVec3) -> Line {
    let point = |x: f64, y: f64| {
        origin + if side == Side::Wall { DVec3::new(x, 2.0, 0.5 * y + 1.0) } else { DVec3::new(x, y, 0.0) }
    };
    loop {
        let mut end = || point(random.between(-1.99, 1.99), random.between(-1.99, 1.99));
        let (from, to) = (end(), end());
        let length = from.distance(to);
        if length > 0.5 {
            let normal = match side {
                Side::Floor => DVec3::Z,
                Side::Wall => -DVec3::Y,
                Side::UnderFloor => -DVec3::Z,
            };
            return Line { from, direction: (to - from) / length, length, normal };
        }
    }
}

impl Tally {
    fn examine(&mut self, stage: &Stage, traced: &Traced, line: &Line, name: &str) {
        let Traced { prepared, discontinuities } = traced;
        let light = |t: f64| stage.world.irradiance(line.point(t), line.normal);
        let (found, sure) = breaks::breaks(&light, line.length);
        let crossings = crossings_of(stage, traced, line);
        self.lines += 1;
        let near = |at: &Break, t: f64| (at.from - PLACE_M..=at.to + PLACE_M).contains(&t);
        for (i, at) in found.iter().enumerate() {
            let before = if i == 0 { 0.0 } else { found[i - 1].to };
            let after = found.get(i + 1).map_or(line.length, |next| next.from);
            let jumps = breaks::jumps(&light, at, before, after);
            let alone = (at.from - before).min(after - at.to) > ALONE_M;
            // Where breaks crowd, polynomials tell little of what jumps; there its place is what counts.
            let effect = if alone { jumps[1].abs() * REACH_M + 0.5 * jumps[2].abs() * REACH_M.powi(2) } else { 0.0 };
            let causes: Vec<&Crossing> = crossings.iter().filter(|crossing| near(at, crossing.at)).collect();
            let place = || format!("{name} at {}: jumps {jumps:?}, alone {alone}, {causes:?}", line.point(at.middle()));
            if causes.is_empty() {
                let [from, to] = [line.point(at.from - PLACE_M), line.point(at.to + PLACE_M)];
                if alone::is_owed_to_two_edges_in_a_plane(&stage.world, from, to) {
                    self.in_plane += 1;
                    self.in_plane_effect += effect;
                } else if alone::is_owed_to_occluders(&stage.world, from, to) {
                    self.owed += 1;
                    self.owed_effect += effect;
                } else if (0..3).all(|degree| jumps[degree].abs() < sure[degree].max(FAINT[degree])) {
                    self.faint += 1;
                } else if at.from > 1e-3 && at.to < line.length - 1e-3 {
                    let nearest = crossings.iter().map(|crossing| (crossing.at - at.middle()).abs());
                    let nearest_m = nearest.fold(f64::INFINITY, f64::min);
                    self.missed.push(format!("{}, the next d-segment is {nearest_m} m away", place()));
                }
                continue;
            }
            self.explained += 1;
            self.explained_effect += effect;
            if let ([cause], true) = (causes.as_slice(), alone) {
                // What is owed to occluders alone may happen so near that both make one break.
                let [from, to] = [line.point(at.from - PLACE_M), line.point(at.to + PLACE_M)];
                if cause.at_end || alone::is_owed_to_occluders(&stage.world, from, to) {
                    continue;
                }
                let degree = cause.segment.degree.number();
                let agrees = match cause.segment.degree {
                    Degree::D0 => jumps[0].abs() <= 2.0 * cause.along,
                    _ => {
                        let small = sure[degree] + if degree == 2 { 10.0 * sure[1] } else { 0.0 };
                        (jumps[degree].abs() - cause.along).abs() <= STRENGTH * cause.along + small
                            && jumps[..degree].iter().zip(sure).all(|(jump, noise)| {
                                jump.abs() <= 10.0 * noise + cause.along * breaks::RESOLUTION_M * 2.0
                            })
                    }
                };
                if agrees {
                    self.measured += 1;
                } else {
                    self.wrong.push(place());
                }
            }
        }
        for i in 0..ASKED {
            let t = line.length * (f64::from(i) + 0.5) / f64::from(ASKED);
            if !found.iter().any(|at| (at.from - 1e-3..=at.to + 1e-3).contains(&t)) {
                let half = 0.5 * breaks::RESOLUTION_M + PLACE_M;
                self.asked += 1;
                let alarm = alone::is_owed_to_occluders(&stage.world, line.point(t - half), line.point(t + half));
                self.alarms += usize::from(alarm);
            }
        }
        for crossing in crossings.iter().filter(|crossing| !crossing.at_end) {
            let degree = crossing.segment.degree.number();
            let inside = AT_END_M..line.length - AT_END_M;
            if degree == 0 || crossing.along < sure[degree] || !inside.contains(&crossing.at) {
                continue;
            }
            if found.iter().any(|at| near(at, crossing.at)) {
                self.shown += 1;
                self.of_three += usize::from(matches!(crossing.segment.event, Event::ThreeEdges { .. }));
            } else {
                let at = line.point(crossing.at);
                let face = prepared.faces[crossing.segment.face].plane;
                let of = discontinuities.segments.len();
                let near: Vec<&Crossing> = crossings.iter().filter(|c| (c.at - crossing.at).abs() < 1e-3).collect();
                self.invented.push(format!("{name} at {at} in {face:?}: of {of}, sure {sure:?}: {near:?}"));
            }
        }
    }

    fn add(&mut self, other: Self) {
        self.lines += other.lines;
        self.explained += other.explained;
        self.owed += other.owed;
        self.missed.extend(other.missed);
        self.faint += other.faint;
        self.explained_effect += other.explained_effect;
        self.owed_effect += other.owed_effect;
        self.in_plane += other.in_plane;
        self.in_plane_effect += other.in_plane_effect;
        self.asked += other.asked;
        self.alarms += other.alarms;
        self.shown += other.shown;
        self.of_three += other.of_three;
        self.invented.extend(other.invented);
        self.measured += other.measured;
        self.wrong.extend(other.wrong);
    }

    fn report(&self) {
        let share = |good: usize, bad: usize| 100.0 * good as f64 / ((good + bad) as f64).max(1.0);
        println!("{} lines", self.lines);
        println!(
            "breaks: {} have a d-segment, {} are owed to occluders alone, {} are faint, {} are missed: {:.3} %",
            self.explained,
            self.owed,
            self.faint,
            self.missed.len(),
            share(self.explained + self.owed, self.missed.len())
        );
        println!(
            "d-segments: {} have a break, {} of them of three edges, {} have none: {:.3} %",
            self.shown,
            self.of_three,
            self.invented.len(),
            share(self.shown, self.invented.len())
        );
        println!(
            "degree and strength: {} agree, {} do not: {:.3} %",
            self.measured,
            self.wrong.len(),
            share(self.measured, self.wrong.len())
        );
        let of_all = |effect: f64| 100.0 * effect / (self.owed_effect + self.in_plane_effect + self.explained_effect);
        println!("occluders alone have {:.2} % of the strength", of_all(self.owed_effect));
        println!(
            "two parallel edges of occluders: {} breaks, {:.2} % of the strength",
            self.in_plane,
            of_all(self.in_plane_effect)
        );
        println!("their test says so at {} of {} smooth places", self.alarms, self.asked);
        for (what, places) in [("missed", &self.missed), ("invented", &self.invented), ("wrong", &self.wrong)] {
            places.iter().take(12).for_each(|place| println!("{what}: {place}"));
        }
    }
}

/// Where a line crosses the d-segments of its plane.
fn crossings_of(stage: &Stage, traced: &Traced, line: &Line) -> Vec<Crossing> {
    let Traced { prepared, discontinuities } = traced;
    let features = Features::new(&stage.scene, prepared);
    let visibility = Visibility::new(prepared);
    let mut crossings: Vec<Crossing> = Vec::new();
    for segment in &discontinuities.segments {
        let normal = prepared.normal(segment.face);
        let ends = segment.ends_m.map(|end| prepared.origin_m + end);
        let flat = (ends[0] - line.from).dot(line.normal).abs().max((ends[1] - line.from).dot(line.normal).abs());
        if normal.dot(line.normal) < 0.999_999 || flat > 1e-5 {
            continue;
        }
        let found = match segment.event {
            Event::ThreeEdges { source, occluders: [nearer, last], .. } => {
                let edge = |id: EdgeId| prepared.edges[id].ends.map(|v| prepared.origin_m + prepared.vertices_m[v]);
                line.crossings_of_curve(ends, [source, nearer, last].map(edge))
            }
            _ => line.crossing(ends).into_iter().collect(),
        };
        for (at, sine, at_end) in found {
            let jump = features.jump(prepared, &visibility, segment, line.point(at) - prepared.origin_m);
            let degree = segment.degree.number() as i32;
            crossings.push(Crossing { segment: *segment, at, along: jump * sine.powi(degree), at_end });
        }
    }
    crossings.sort_by(|p, q| p.at.total_cmp(&q.at));
    crossings
}

fn number(name: &str, default: u64) -> u64 {
    std::env::var(name).ok().and_then(|text| text.parse().ok()).unwrap_or(default)
}

/// Looks at these receivers of random scenes of a kind.
fn examined(scenes: u64, sides: &[Side], kind: impl Fn(&mut Random) -> Stage) -> Tally {
    let first = number("UMBRAGE_PROOF_FIRST", 0);
    let mut tally = Tally::default();
    for seed in first..first + number("UMBRAGE_PROOF_SCENES", scenes) {
        let mut random = Random(seed.wrapping_mul(0x5851_F42D_4C95_7F2D));
        let stage = kind(&mut random);
        let traced = trace(&stage.scene, crate::all_sides(), 0.0, Progress::silent()).unwrap();
        let mut of_scene = Tally::default();
        for &side in sides {
            for number in 0..LINES {
                let line = random_line(&mut random, side, stage.origin);
                of_scene.examine(&stage, &traced, &line, &format!("scene {seed} line {number} on {side:?}"));
            }
        }
        tally.add(of_scene);
    }
    tally.report();
    tally
}

/// What holds for scenes of any kind.
fn holds(tally: &Tally) {
    let rare = |bad: &[String], all: usize| 1000 * bad.len() <= bad.len() + all;
    assert!(tally.explained > 0 && tally.shown > 0);
    assert!(rare(&tally.missed, tally.explained + tally.owed), "breaks without d-segments");
    assert!(rare(&tally.invented, tally.shown), "d-segments without breaks");
    assert!(rare(&tally.wrong, tally.measured), "wrong degrees or strengths");
    let (alone, all) = (tally.owed_effect + tally.in_plane_effect, tally.explained_effect);
    assert!(20.0 * alone < alone + all, "occluders alone matter: {alone} beside {all}");
    assert!(20 * tally.alarms < tally.asked, "the test for occluders alone tells nothing");
}

#[test]
fn every_break_has_its_d_segment_and_every_d_segment_its_break() {
    let tally = examined(SCENES, &[Side::Floor, Side::Wall], random::scene);
    holds(&tally);
    assert!(tally.of_three > 0, "no line crosses an event of three edges");
}

#[test]
fn in_buildings_too_every_break_has_its_d_segment() {
    let tally = examined(BUILDINGS, &[Side::Floor, Side::Wall], random::building);
    holds(&tally);
    assert!(tally.in_plane > 0 && tally.of_three > 0);
}

#[test]
fn of_two_sided_sheets_shells_and_lights_too() {
    let tally = examined(TWO_SIDED, &[Side::Floor, Side::Wall, Side::UnderFloor], two_sided_scenes::stage);
    holds(&tally);
    assert!(tally.of_three > 0);
}
