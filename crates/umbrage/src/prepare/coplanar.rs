//! Which polygons lie in one plane, said once as an id.
//!
//! Polygons come by falling area: one whose corners all lie within the coplanar tolerance of a known plane joins it
//! (the nearest, where there are several), else its own plane becomes a new one. A known plane never moves, so that no
//! chain of nearly coplanar polygons drifts away from it. Known planes lie in an R-tree over normal and offset; how far
//! to look follows from how far a polygon of this width can be tilted within the tolerance.

use glam::DVec3;
use rstar::primitives::GeomWithData;
use rstar::{AABB, RTree};

use super::Facing;
use super::soup::Polygon;
use super::weld::Points;
use crate::geometry::{Plane, PlaneFrame, Tolerance, polygon};
use crate::id::{PlaneId, Table};

/// A polygon hardly wider than its tolerance allows any tilt; none is taken for coplanar that is tilted more than this
/// (radians), which keeps the search small.
const MOST_TILT: f64 = 0.1;

/// The planes of a scene.
#[derive(Debug)]
pub(super) struct Planes {
    /// The planes, each with a frame near the largest of its polygons.
    pub(super) frames: Table<PlaneId, PlaneFrame>,
    /// The plane of each polygon, and which way it looks.
    pub(super) of_polygon: Vec<(PlaneId, Facing)>,
}

/// A plane in the tree: normal, and offset as a share of the extent.
type Known = GeomWithData<[f64; 4], PlaneId>;

fn coordinates(plane: &Plane, extent_m: f64) -> [f64; 4] {
    [plane.normal.x, plane.normal.y, plane.normal.z, plane.offset_m / extent_m]
}

/// Gives every polygon its plane.
pub(super) fn planes(soup: &[Polygon], points: &Points, tolerance: &Tolerance) -> Planes {
    let mut by_area: Vec<usize> = (0..soup.len()).collect();
    by_area.sort_by(|&i, &j| soup[j].area_m2.total_cmp(&soup[i].area_m2).then(i.cmp(&j)));
    let mut frames: Table<PlaneId, PlaneFrame> = Table::new();
    let mut known: RTree<Known> = RTree::new();
    let mut of_polygon = vec![(PlaneId::from(0), Facing::Along); soup.len()];
    for i in by_area {
        let corners = soup[i].corners_m(points);
        let Some(own) = Plane::of_polygon(&corners) else { continue };
        let id = nearest(&own, &corners, soup[i].area_m2, &frames, &known, tolerance).unwrap_or_else(|| {
            let id = frames.push_and_get_key(PlaneFrame::new(own, polygon::centroid(&corners)));
            known.insert(Known::new(coordinates(&own, tolerance.extent_m), id));
            id
        });
        let along = frames[id].plane.normal.dot(own.normal) > 0.0;
        of_polygon[i] = (id, if along { Facing::Along } else { Facing::Against });
    }
    Planes { frames, of_polygon }
}

/// The known plane that all corners lie in, the nearest of several.
fn nearest(
    own: &Plane,
    corners: &[DVec3],
    area_m2: f64,
    frames: &Table<PlaneId, PlaneFrame>,
    known: &RTree<Known>,
    tolerance: &Tolerance,
) -> Option<PlaneId> {
    // Both planes pass within the tolerance of all corners, so they differ by at most four tolerances over the width.
    let width_m = area_m2 / polygon::perimeter_m(corners);
    let tilt = (4.0 * tolerance.coplanar_m() / width_m).min(MOST_TILT);
    let reach = corners.iter().map(|c| c.length()).fold(0.0, f64::max) / tolerance.extent_m;
    let slack = [tilt, tilt, tilt, tilt * reach + 2.0 * tolerance.coplanar_m() / tolerance.extent_m];
    let distance_m =
        |id: PlaneId| corners.iter().map(|&c| frames[id].plane.signed_distance_m(c).abs()).fold(0.0, f64::max);
    let mut best: Option<(f64, PlaneId)> = None;
    for way in [*own, own.flipped()] {
        let at = coordinates(&way, tolerance.extent_m);
        let range =
            AABB::from_corners(std::array::from_fn(|i| at[i] - slack[i]), std::array::from_fn(|i| at[i] + slack[i]));
        for candidate in known.locate_in_envelope(range) {
            let found = (distance_m(candidate.data), candidate.data);
            if found.0 <= tolerance.coplanar_m() && best.is_none_or(|b| found < b) {
                best = Some(found);
            }
        }
    }
    best.map(|(_, id)| id)
}
