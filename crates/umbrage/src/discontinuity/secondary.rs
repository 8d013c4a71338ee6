//! Secondary sources: faces that reflect so much light that the shadows in it can be seen.
//!
//! After a first solution, a face that reflects much more than others is a source like any other: its outline casts EV and VE
//! events past occluders, and where they fall indirect light bends. Its radiance is not even, so degree and strength are those
//! of its mean; what is cut along them is the mesh that indirect light is gathered on and the one that is shown, both of which
//! find out by themselves what a cut is worth.
//!
//! In a room that is lit evenly no face is much brighter than the mean, and there are none.

use super::find::traced;
use super::{DSegment, Features};
use crate::geometry::polygon;
use crate::id::{DSegmentId, FaceId, Table};
use crate::prepare::Prepared;
use crate::progress::{Cancelled, Progress};
use crate::scene::{Material, Rgb, Scene};
use crate::visibility::Visibility;

/// A face is a secondary source if its radiosity by reflection is at least so many times the mean of all.
const BRIGHT: f64 = 4.0;
/// Of more faces the brightest are taken, by power.
const MOST_SOURCES: usize = 32;

/// The d-segments of faces that reflect much, given the mean radiosity by reflection of every face in W/m2: those that change
/// irradiance by at least `least`, in W/m2, over the width of their face.
///
/// # Errors
/// [`Cancelled`] where the progress callback asks to stop.
pub fn find_secondary(
    scene: &Scene,
    prepared: &Prepared,
    visibility: &Visibility,
    reflected: &Table<FaceId, Rgb>,
    least: f64,
    progress: Progress<'_>,
) -> Result<Table<DSegmentId, DSegment>, Cancelled> {
    let bright = bright_faces(prepared, reflected);
    if bright.is_empty() {
        return Ok(Table::new());
    }
    // The same faces, but that these alone give light.
    let mut materials = scene.materials.clone();
    materials.iter_mut().for_each(|material| material.radiance = Rgb::ZERO);
    let mut lit = prepared.clone();
    for face in bright {
        let radiance = reflected[face] / std::f64::consts::PI;
        lit.faces[face].material = materials.push_and_get_key(Material::emitting("secondary source", radiance));
    }
    let features = Features::new(&Scene { materials, ..Scene::default() }, &lit);
    let (mut segments, _) = traced(&lit, visibility, &features, least, progress)?;
    segments.sort_by(DSegment::by_face_and_event);
    Ok(segments.into())
}

/// The faces that are secondary sources, ascending.
fn bright_faces(prepared: &Prepared, reflected: &Table<FaceId, Rgb>) -> Vec<FaceId> {
    let area_m2 = |face: FaceId| polygon::area_m2(&prepared.polygon_m(face));
    let power = |face: FaceId| area_m2(face) * reflected[face].element_sum();
    let (whole, whole_m2) =
        prepared.faces.keys().fold((0.0, 0.0), |(sum, sum_m2), face| (sum + power(face), sum_m2 + area_m2(face)));
    let least = BRIGHT * whole / whole_m2;
    let mut bright: Vec<FaceId> =
        prepared.faces.keys().filter(|&face| whole > 0.0 && reflected[face].element_sum() >= least).collect();
    bright.sort_by(|&p, &q| power(q).total_cmp(&power(p)).then(p.cmp(&q)));
    bright.truncate(MOST_SOURCES);
    bright.sort_unstable();
    bright
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::discontinuity::Degree;
    use crate::visibility::fixture::{self, square};
    use glam::DVec3;

    /// A floor, a plate above it, and a panel above that, of which one reflects.
    fn cast(reflected: [f64; 3]) -> Vec<DSegment> {
        let prepared = fixture::prepared(&[
            square(DVec3::ZERO, 3.0, true),
            square(DVec3::Z, 0.5, true),
            square(2.0 * DVec3::Z, 0.5, false),
        ]);
        let scene = fixture::scene(vec![Material::diffuse("grey", Rgb::splat(0.5))]);
        let reflected = reflected.into_iter().map(Rgb::splat).collect();
        let visibility = Visibility::new(&prepared);
        find_secondary(&scene, &prepared, &visibility, &reflected, 0.0, Progress::silent()).unwrap().raw
    }

    #[test]
    fn a_bright_panel_casts_as_a_lamp_does() {
        // The panel is parallel to the plate half way to the floor: four lines at 0.5 and four at 1.5 from the middle.
        let mut lines: Vec<f64> = cast([0.01, 0.0, 1.0])
            .iter()
            .filter(|segment| segment.face == FaceId::from(0))
            .map(|segment| {
                assert_eq!(segment.degree, Degree::D1);
                let middle = segment.ends_m[0].midpoint(segment.ends_m[1]);
                (middle.truncate().abs().max_element() * 1e6).round() / 1e6
            })
            .collect();
        lines.sort_by(f64::total_cmp);
        assert_eq!(lines, [0.5, 0.5, 0.5, 0.5, 1.5, 1.5, 1.5, 1.5]);
    }

    #[test]
    fn what_is_no_brighter_than_the_rest_casts_nothing() {
        assert!(cast([1.0, 1.0, 1.0]).is_empty());
        assert!(cast([0.0, 0.0, 0.0]).is_empty());
    }
}
