//! Small polygon soups for the tests of single steps.

use super::coplanar::{self, Planes};
use super::soup::Polygon;
use super::weld::Points;
use crate::geometry::{Tolerance, polygon};
use crate::id::{SurfaceId, VertexId};
use glam::DVec3;

/// Tolerances of a scene ten metres large.
pub(super) const TOLERANCE: Tolerance = Tolerance { extent_m: 10.0 };

/// Polygons with their points and planes; polygon `i` belongs to surface `i`.
pub(super) struct Small {
    pub(super) points: Points,
    pub(super) soup: Vec<Polygon>,
    pub(super) planes: Planes,
}

impl Small {
    pub(super) fn new(polygons: &[&[[f64; 3]]]) -> Self {
        let mut points = Points::new(TOLERANCE.weld_m());
        let soup: Vec<Polygon> = polygons
            .iter()
            .enumerate()
            .map(|(i, corners)| Polygon {
                surface: SurfaceId::from(i),
                number: 0,
                area_m2: polygon::area_m2(&corners.iter().map(|&c| DVec3::from(c)).collect::<Vec<_>>()),
                corners: corners.iter().map(|&c| points.weld(DVec3::from(c))).collect(),
                sources: Vec::new(),
                double_sided: false,
                emits: false,
            })
            .collect();
        let planes = coplanar::planes(&soup, &points, &TOLERANCE);
        Self { points, soup, planes }
    }

    /// Positions of a segment's ends, the lesser first, rounded to whole micrometres.
    pub(super) fn micrometres(&self, ends: [VertexId; 2]) -> [[i64; 3]; 2] {
        let mut ends = ends.map(|v| (self.points[v] * 1e6).round().as_i64vec3().to_array());
        ends.sort_unstable();
        ends
    }
}
