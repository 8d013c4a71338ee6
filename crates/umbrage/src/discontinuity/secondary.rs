//! Secondary sources: faces and parts of faces that reflect so much light that the shadows in it can be seen.
//!
//! After a first solution, a face that reflects much more than others is a source like any other: its outline casts EV
//! and VE events past occluders, and where they fall indirect light bends. So does the outline of a part that is much
//! brighter than the rest of its surface (`bright_part`). Events of three edges are left out: they are the faintest. The
//! radiance of these sources is not quite even, so degree and strength are those of its mean; what is cut along them is
//! the mesh that indirect light is gathered on and the one that is shown, both of which find out by themselves what a
//! cut is worth.
//!
//! In a room that is lit evenly nothing is much brighter than the mean, and there are none.

use std::f64::consts::PI;

use super::bright_part::{self, BrightPart, PartlyBright, Reflecting};
use super::find::{Kinds, traced};
use super::{DSegment, Emitter, Features};
use crate::id::{DSegmentId, FaceId, Table};
use crate::prepare::Prepared;
use crate::progress::{Cancelled, Progress};
use crate::scene::{Rgb, Scene};
use crate::visibility::Visibility;

/// A face is a secondary source if its radiosity by reflection is at least so many times the mean of all, and so is a
/// part of a surface by what it reflects over the rest.
const BRIGHT: f64 = 4.0;
/// Of more sources the brightest are taken, by power.
const MOST_SOURCES: usize = 32;
/// And only the brightest that have no more than so many pairs of a corner and an edge of the scene: what they add goes with the
/// power of a source, and what it takes with the number of its pairs. With a million, a room of 103,960 polygons took 44 CPU s where it
/// takes 30, for one per cent of its triangles.
const MOST_PAIRS: usize = 250_000;

/// The d-segments of what reflects much, given all patches that are not split: those that change irradiance by at least
/// `least`, in W/m2, over the width of their face, and those of parts much more. Events of a part of a face name
/// vertices and edges that the prepared faces do not have.
///
/// # Errors
/// [`Cancelled`] where the progress callback asks to stop.
pub fn find_secondary(
    scene: &Scene,
    prepared: &Prepared,
    visibility: &Visibility,
    patches: &[Reflecting],
    least: f64,
    progress: Progress<'_>,
) -> Result<Table<DSegmentId, DSegment>, Cancelled> {
    let sources = secondary_sources(prepared, patches);
    if sources.is_empty() {
        return Ok(Table::new());
    }
    // The same faces, but that these alone give light; vertices and edges of parts come after theirs.
    let mut lit = prepared.clone();
    let mut radiance: Table<FaceId, Rgb> = prepared.faces.iter().map(|_| Rgb::ZERO).collect();
    let mut parts = Vec::new();
    for source in sources {
        match source.of {
            Of::Face(face) => radiance[face] = source.radiosity / PI,
            Of::Part(part) => {
                parts.push(Emitter::of_part(&mut lit, part.faces, &part.corners_m, source.radiosity / PI));
            }
        }
    }
    let whole = radiance.iter().filter(|radiance| **radiance != Rgb::ZERO).count();
    tracing::debug!(faces = whole, parts = parts.len(), "secondary sources");
    let features = Features::shining(scene, &lit, &radiance, parts);
    let (mut segments, _) = traced(&lit, visibility, &features, Kinds::OfTwoFeatures, least, progress)?;
    segments.sort_by(DSegment::by_face_and_event);
    Ok(segments.into())
}

/// What a source is.
enum Of {
    Face(FaceId),
    Part(BrightPart),
}

struct Source {
    of: Of,
    /// In W/m2: of a part, what it reflects over the rest.
    radiosity: Rgb,
    power_w: f64,
}

impl Source {
    fn corner_count(&self, prepared: &Prepared) -> usize {
        match &self.of {
            Of::Face(face) => prepared.boundary(*face).count(),
            Of::Part(part) => part.corners_m.len(),
        }
    }
}

/// The secondary sources, the brightest first.
fn secondary_sources(prepared: &Prepared, patches: &[Reflecting]) -> Vec<Source> {
    let mut faces: Table<FaceId, (Rgb, f64)> = prepared.faces.iter().map(|_| (Rgb::ZERO, 0.0)).collect();
    for patch in patches {
        let (power_w, area_m2) = &mut faces[patch.face];
        *power_w += patch.area_m2() * patch.reflected;
        *area_m2 += patch.area_m2();
    }
    let (power_w, area_m2) =
        faces.iter().fold((0.0, 0.0), |(power_w, area_m2), face| (power_w + face.0.element_sum(), area_m2 + face.1));
    if power_w <= 0.0 {
        return Vec::new();
    }
    let least = BRIGHT * power_w / area_m2;
    let mut sources: Vec<Source> = Vec::new();
    // A surface casts from its parts or as a whole, so that no shadow is traced twice: whichever sends more.
    let mut as_parts: Vec<PartlyBright> = bright_part::partly_bright(prepared, patches, least);
    as_parts.retain(|surface| surface.parts.iter().map(BrightPart::power_w).sum::<f64>() > surface.rest_w);
    let mut is_whole: Table<FaceId, bool> = prepared.faces.iter().map(|_| true).collect();
    as_parts.iter().flat_map(|surface| &surface.faces).for_each(|&face| is_whole[face] = false);
    for (face, &(power, area_m2)) in faces.iter_enumerated() {
        if is_whole[face] && power.element_sum() >= least * area_m2 {
            sources.push(Source { of: Of::Face(face), radiosity: power / area_m2, power_w: power.element_sum() });
        }
    }
    for part in as_parts.into_iter().flat_map(|surface| surface.parts) {
        sources.push(Source { radiosity: part.excess, power_w: part.power_w(), of: Of::Part(part) });
    }
    sources.sort_by(|p, q| q.power_w.total_cmp(&p.power_w));
    sources.truncate(MOST_SOURCES);
    let mut left = MOST_PAIRS;
    let is_affordable = |source: &&Source| {
        left = left.saturating_sub(source.corner_count(prepared) * prepared.edges.len());
        left > 0
    };
    let affordable = sources.iter().take_while(is_affordable).count();
    sources.truncate(affordable);
    sources
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::discontinuity::{Degree, Event};
    use crate::id::VertexId;
    use crate::scene::Material;
    use crate::visibility::fixture::{self, square};
    use glam::DVec3;

    /// Half a side of the bright square above the plate.
    const BRIGHT_M: f64 = 0.5;

    /// A floor, a plate above it, and one panel above that or several side by side, which all look down.
    fn stage(panels: &[[[f64; 2]; 2]]) -> Prepared {
        let mut faces = vec![square(DVec3::ZERO, 3.0, true), square(DVec3::Z, 0.5, true)];
        faces.extend(panels.iter().map(|&panel| rectangle(panel)));
        fixture::prepared(&faces)
    }

    /// The same as sheets that show both of their sides: the other sides come after all fronts, which keep their numbers.
    fn stage_of_sheets(panels: &[[[f64; 2]; 2]]) -> Prepared {
        let mut faces = vec![square(DVec3::ZERO, 3.0, true), square(DVec3::Z, 0.5, true)];
        faces.extend(panels.iter().map(|&panel| rectangle(panel)));
        let backs: Vec<Vec<DVec3>> = faces.iter().map(|face| face.iter().rev().copied().collect()).collect();
        faces.extend(backs);
        fixture::prepared(&faces)
    }

    /// A rectangle at height 2 that looks down, by its low and high corners.
    fn rectangle([low, high]: [[f64; 2]; 2]) -> Vec<DVec3> {
        [(0, 0), (0, 1), (1, 1), (1, 0)].map(|(i, j)| DVec3::new([low, high][i][0], [low, high][j][1], 2.0)).to_vec()
    }

    /// A face as patches of its own grid, by what they reflect; points of a grid have the same numbers on all faces.
    fn gridded(face: usize, at: [[f64; 2]; 2], cells: usize, reflected: impl Fn(DVec3) -> f64) -> Vec<Reflecting> {
        let place = |t: usize, axis: usize| at[0][axis] + (at[1][axis] - at[0][axis]) * t as f64 / cells as f64;
        let number = |x: f64, y: f64| VertexId::from(((x + 4.0) * 1e3) as usize * 10_000 + ((y + 4.0) * 1e3) as usize);
        let patch = |i: usize, j: usize| {
            let cell = [[place(i, 0), place(j, 1)], [place(i + 1, 0), place(j + 1, 1)]];
            let boundary: Vec<_> = rectangle(cell).into_iter().map(|p| (number(p.x, p.y), p)).collect();
            let middle = boundary.iter().map(|point| point.1).sum::<DVec3>() / 4.0;
            Reflecting { face: FaceId::from(face), boundary, reflected: Rgb::splat(reflected(middle)) }
        };
        (0..cells * cells).map(|k| patch(k % cells, k / cells)).collect()
    }

    /// A face as one patch.
    fn whole(prepared: &Prepared, face: usize, reflected: f64) -> Reflecting {
        let boundary = prepared.boundary(FaceId::from(face)).map(|v| (v, prepared.vertices_m[v])).collect();
        Reflecting { face: FaceId::from(face), boundary, reflected: Rgb::splat(reflected) }
    }

    fn cast(prepared: &Prepared, patches: &[Reflecting], least: f64) -> Vec<DSegment> {
        let scene = fixture::scene(vec![Material::diffuse("grey", Rgb::splat(0.5))]);
        find_secondary(&scene, prepared, &Visibility::new(prepared), patches, least, Progress::silent()).unwrap().raw
    }

    /// Offsets of the lines on the floor from the middle, where all are parallel to the plate.
    fn offsets_m(segments: &[DSegment]) -> Vec<f64> {
        let on_floor = segments.iter().filter(|segment| segment.face == FaceId::from(0));
        let mut lines: Vec<f64> = on_floor
            .map(|segment| {
                assert_eq!(segment.degree, Degree::D1);
                let middle = segment.ends_m[0].midpoint(segment.ends_m[1]);
                (middle.truncate().abs().max_element() * 1e4).round() / 1e4
            })
            .collect();
        lines.sort_by(f64::total_cmp);
        lines
    }

    /// As a lamp like the plate above it, half way to the floor: four lines at 0.5 and four at 1.5 from the middle.
    const LINES_M: [f64; 8] = [0.5, 0.5, 0.5, 0.5, 1.5, 1.5, 1.5, 1.5];

    fn in_the_square(p: DVec3) -> f64 {
        if p.truncate().abs().max_element() < BRIGHT_M { 1.0 } else { 0.02 }
    }

    #[test]
    fn a_bright_panel_casts_as_a_lamp_does() {
        let prepared = stage(&[[[-0.5; 2], [0.5; 2]]]);
        let patches = |of: [f64; 3]| [0, 1, 2].map(|face| whole(&prepared, face, of[face]));
        assert_eq!(offsets_m(&cast(&prepared, &patches([0.01, 0.0, 1.0]), 0.0)), LINES_M);
        assert!(cast(&prepared, &patches([1.0, 1.0, 1.0]), 0.0).is_empty());
        assert!(cast(&prepared, &patches([0.0, 0.0, 0.0]), 0.0).is_empty());
    }

    #[test]
    fn a_bright_part_of_a_panel_casts_as_a_panel_of_its_own_does() {
        let at = [[-2.0; 2], [2.0; 2]];
        let prepared = stage(&[at]);
        let others = [whole(&prepared, 0, 0.01), whole(&prepared, 1, 0.0)];
        let panel = |of: &dyn Fn(DVec3) -> f64| [&others[..], &gridded(2, at, 8, of)].concat();
        let segments = cast(&prepared, &panel(&in_the_square), 0.0);
        assert_eq!(offsets_m(&segments), LINES_M);
        // What the part casts is the strength of what it reflects over the rest: half of it, half of the strength.
        let brighter = cast(&prepared, &panel(&|p| 0.02 + 2.0 * (in_the_square(p) - 0.02)), 0.0);
        assert_eq!(segments.len(), brighter.len());
        for (one, other) in segments.iter().zip(&brighter) {
            assert!(one.strength > 0.0 && (other.strength / one.strength - 2.0).abs() < 1e-9, "{one:?} {other:?}");
        }
        let strongest = segments.iter().map(|segment| segment.strength).fold(0.0, f64::max);
        // An effect is less than strength times width.
        assert!(cast(&prepared, &panel(&in_the_square), 6.0 * strongest).is_empty());
        assert!(cast(&prepared, &panel(&|_| 1.0), 0.0).iter().all(|segment| {
            // All of it is bright: its own corners cast, as they did before.
            !matches!(segment.event, Event::EdgeEdge { source, .. } if source.index() >= prepared.edges.len())
        }));
    }

    #[test]
    fn a_bright_side_of_a_sheet_or_a_part_of_it_casts_as_a_lamp_does() {
        let whole_panel = stage_of_sheets(&[[[-0.5; 2], [0.5; 2]]]);
        let patches = [0.01, 0.0, 1.0, 0.0, 0.0, 0.0].iter().enumerate();
        let patches: Vec<_> = patches.map(|(face, &reflected)| whole(&whole_panel, face, reflected)).collect();
        assert_eq!(offsets_m(&cast(&whole_panel, &patches, 0.0)), LINES_M);
        let at = [[-2.0; 2], [2.0; 2]];
        let prepared = stage_of_sheets(&[at]);
        let dark = [0, 1, 3, 4, 5].map(|face| whole(&prepared, face, if face == 0 { 0.01 } else { 0.0 }));
        let patches = [&dark[..], &gridded(2, at, 8, in_the_square)].concat();
        assert_eq!(offsets_m(&cast(&prepared, &patches, 0.0)), LINES_M);
    }

    #[test]
    fn a_bright_part_across_two_faces_is_one_source() {
        let halves = [[[-2.0, -2.0], [0.0, 2.0]], [[0.0, -2.0], [2.0, 2.0]]];
        let prepared = stage(&halves);
        let mut patches = vec![whole(&prepared, 0, 0.01), whole(&prepared, 1, 0.0)];
        patches.extend((0..2).flat_map(|half| gridded(2 + half, halves[half], 8, in_the_square)));
        assert_eq!(offsets_m(&cast(&prepared, &patches, 0.0)), LINES_M);
    }

    #[test]
    fn dim_and_scattered_light_casts_nothing() {
        let at = [[-2.0; 2], [2.0; 2]];
        let prepared = stage(&[at]);
        let lit = |floor: f64, of: &dyn Fn(DVec3) -> f64| {
            let others = [whole(&prepared, 0, floor), whole(&prepared, 1, 0.0)];
            cast(&prepared, &[&others[..], &gridded(2, at, 8, of)].concat(), 0.0)
        };
        // No brighter than the floor; a ring, of which the hull has another shadow; a spot that fades.
        assert!(lit(1.0, &in_the_square).is_empty());
        assert!(lit(0.0, &|p| if p.truncate().abs().max_element() > 1.5 { 1.0 } else { 0.0 }).is_empty());
        assert!(lit(0.01, &|p| (1.0 - p.truncate().abs().max_element()).max(0.0)).is_empty());
        assert!(!lit(0.01, &in_the_square).is_empty());
    }
}
