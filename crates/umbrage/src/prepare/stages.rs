//! The steps of `prepare` in order, and what one hands to the next.

use std::collections::BTreeSet;

use rayon::prelude::*;

use super::arrangement::{Arrangement, PlaneEdge};
use super::contact::{self, Contact};
use super::coplanar::{self, Planes};
use super::draft::{Draft, Fronts};
use super::entangled::Meetings;
use super::needed::{self, NeededEdge, Use};
use super::node::Segments;
use super::orient;
use super::pieces::convex_pieces;
use super::skin::Skins;
use super::soup::{self, Polygon};
use super::twins;
use super::weld::{Frame, Points};
use super::{PrepareError, PrepareReport, Prepared};
use crate::id::{PlaneId, SurfaceId, VertexId};
use crate::progress::{Cancelled, Progress, Stage};
use crate::scene::Scene;

/// Steps that progress is told in.
const STEPS: usize = 6;

/// How faces are made.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PrepareSettings {
    /// Whether surfaces are cut where others touch or cross them. Without, light leaks along these lines.
    pub cut_contacts: bool,
    /// Whether faces that stand for a smooth surface, by the normals of their corners, are shaded as one.
    pub smooth: bool,
    /// Whether sides that no light reaches and nobody can see become faces, too.
    pub keep_hidden: bool,
}

impl Default for PrepareSettings {
    fn default() -> Self {
        Self { cut_contacts: true, smooth: true, keep_hidden: false }
    }
}

/// Makes faces of a scene that is valid, with the default settings: see [`Prepared`] for what they promise.
///
/// # Errors
/// See [`prepare_with`].
pub fn prepare(scene: &Scene, progress: Progress<'_>) -> Result<Prepared, PrepareError> {
    prepare_with(scene, PrepareSettings::default(), progress)
}

/// Makes faces of a scene that is valid.
///
/// # Errors
/// [`PrepareError::Extent`] and [`PrepareError::NoArea`] for scenes that cannot be held or have nothing to light, and
/// [`PrepareError::Cancelled`]; [`PrepareError::Entangled`] where polygons meet each other too often.
pub fn prepare_with(
    scene: &Scene,
    settings: PrepareSettings,
    progress: Progress<'_>,
) -> Result<Prepared, PrepareError> {
    Ok(draft(scene, settings, progress)?.faces(scene).0)
}

/// Divides all planes of a scene that is valid into pieces, of which [`Draft::faces`] makes faces.
///
/// # Errors
/// As [`prepare_with`].
pub fn draft(scene: &Scene, settings: PrepareSettings, progress: Progress<'_>) -> Result<Draft, PrepareError> {
    let pulse = |step: usize| progress.report(Stage::Prepare, step, STEPS);
    pulse(0)?;
    let mut report = PrepareReport::default();
    if scene.polygon_count() == 0 {
        return Err(no_area(scene));
    }
    let frame = Frame::of_scene(scene)?;
    let tolerance = frame.tolerance;
    let mut points = Points::new(tolerance.weld_m());
    let mut soup =
        if tolerance.extent_m > 0.0 { soup::polygons(scene, &frame, &mut points, &mut report) } else { Vec::new() };
    if soup.is_empty() {
        return Err(no_area(scene));
    }
    report.turned_polygons = orient::turn(&mut soup);
    let corners = points.len();
    pulse(1)?;
    let planes = coplanar::planes(&soup, &points, &tolerance);
    let skins = Skins::new(scene, &soup, &planes, &points, settings.smooth);
    report.unusable_normals = skins.unusable_normals;
    pulse(2)?;
    let meetings = Meetings::of(soup.len());
    let contacts = if settings.cut_contacts {
        contact::contacts(&soup, &planes, &mut points, &tolerance, &mut report.dropped_cuts, &meetings, || pulse(2))?
    } else {
        Vec::new()
    };
    pulse(3)?;
    meetings.restart();
    let mut segments = Segments::default();
    for (polygon, &(plane, _)) in soup.iter().zip(&planes.of_polygon) {
        polygon.sides().for_each(|ends| segments.add(ends, &[plane]));
    }
    contacts.iter().for_each(|c| segments.add(c.ends, &c.planes));
    report.dropped_cuts += segments.cut(&planes, &mut points, &tolerance, &meetings, || pulse(3))?;
    pulse(4)?;
    let (by_plane, t_vertices) = edges_by_plane(&soup, &planes, &contacts, &segments, corners);
    report.t_vertices = t_vertices;
    let edges = needed_edges(&soup, &planes, &skins, &points, &by_plane, &mut report, || pulse(4))?;
    let edges = needed::straighten(&edges, &points, &tolerance);
    pulse(5)?;
    let mut pieces = convex_pieces(&edges, &planes, &points, &tolerance, &mut report, || pulse(5))?;
    let fronts = Fronts::new(&soup, &planes);
    report.overlaps += twins::take_away(&mut pieces, &planes, &fronts);
    pulse(STEPS)?;
    Ok(Draft { frame, planes, skins: skins.all, points, edges, pieces, fronts, report })
}

fn no_area(scene: &Scene) -> PrepareError {
    let first = scene.surfaces.iter_enumerated().find(|(_, s)| !s.polygons.is_empty()).map(|(id, _)| id);
    let place = first.map_or_else(|| "the scene".to_owned(), |id: SurfaceId| scene.place(id, 0));
    PrepareError::NoArea { place, others: scene.polygon_count().saturating_sub(1) }
}

/// One passage of a polygon along a piece of its boundary, or of a contact.
type Passage = (PlaneId, [VertexId; 2], Option<(u32, i32)>);

/// The edges of each plane, and the number of the input's corners (the first `corners` points) inside sides.
fn edges_by_plane(
    soup: &[Polygon],
    planes: &Planes,
    contacts: &[Contact],
    segments: &Segments,
    corners: usize,
) -> (Vec<(PlaneId, Vec<PlaneEdge>)>, usize) {
    let mut t_vertices = BTreeSet::new();
    let mut passages: Vec<Passage> = Vec::new();
    let mut pieces = Vec::new();
    for (number, (polygon, &(plane, _))) in (0..).zip(soup.iter().zip(&planes.of_polygon)) {
        for side in polygon.sides() {
            pieces.clear();
            segments.pieces(side, &mut pieces);
            t_vertices.extend(pieces.iter().skip(1).map(|piece| piece[0]).filter(|v| v.index() < corners));
            passages.extend(pieces.iter().map(|&[a, b]| {
                let pass = if a < b { 1 } else { -1 };
                (plane, [a.min(b), a.max(b)], Some((number, pass)))
            }));
        }
    }
    for contact in contacts {
        pieces.clear();
        segments.pieces(contact.ends, &mut pieces);
        for plane in contact.planes {
            passages.extend(pieces.iter().map(|&[a, b]| (plane, [a.min(b), a.max(b)], None)));
        }
    }
    passages.par_sort_unstable();
    let edge = |run: &[Passage]| PlaneEdge { ends: run[0].1, passes: run.iter().filter_map(|p| p.2).collect() };
    let by_plane = passages
        .chunk_by(|a, b| a.0 == b.0)
        .map(|plane| (plane[0].0, plane.chunk_by(|a, b| a.1 == b.1).map(edge).collect()))
        .collect();
    (by_plane, t_vertices.len())
}

/// Divides every plane into cells and gathers the edges that are needed.
fn needed_edges(
    soup: &[Polygon],
    planes: &Planes,
    skins: &Skins,
    points: &Points,
    by_plane: &[(PlaneId, Vec<PlaneEdge>)],
    report: &mut PrepareReport,
    pulse: impl Fn() -> Result<(), Cancelled> + Sync,
) -> Result<Vec<NeededEdge>, Cancelled> {
    let arrange = |(plane, edges): &(PlaneId, Vec<PlaneEdge>)| {
        pulse()?;
        let frame = &planes.frames[*plane];
        let facing = |polygon: u32| planes.of_polygon[polygon as usize].1;
        Ok(Arrangement::new(edges, soup, &skins.of_polygon, facing, |v| frame.to_2d(points[v])))
    };
    let arrangements: Vec<Arrangement> = by_plane.par_iter().map(arrange).collect::<Result<_, _>>()?;
    let mut uses: Vec<([VertexId; 2], Use)> = Vec::new();
    for ((plane, edges), arrangement) in by_plane.iter().zip(&arrangements) {
        report.overlaps += arrangement.overlaps;
        report.dropped_cuts += arrangement.missing_edges;
        for (edge, &beside) in edges.iter().zip(&arrangement.beside) {
            if beside != [[None; 2]; 2] {
                uses.push((edge.ends, Use::new(*plane, beside)));
            }
        }
    }
    uses.par_sort_unstable_by_key(|(ends, u)| (*ends, u.plane));
    let edge = |run: &[([VertexId; 2], Use)]| NeededEdge { ends: run[0].0, uses: run.iter().map(|r| r.1).collect() };
    Ok(uses.chunk_by(|a, b| a.0 == b.0).map(edge).filter(NeededEdge::is_needed).collect())
}
