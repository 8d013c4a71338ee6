//! Bright parts of surfaces: the spot of a lamp on a ceiling, a patch of sun on a floor.
//!
//! A bright part is bounded by shadows, not by edges of faces, and may lie on several faces of one surface. Once the
//! light is solved, the patches that are not split tell where it lies: those which reflect at least half of what they
//! reflect where a watt of the surface comes from on the mean. Touching ones of them are one part. It counts if it is
//! even, fills most of its convex hull and leaves a good deal of the surface dark; the hull is then a source of what
//! the part reflects over the rest of the surface.

use std::collections::BTreeMap;

use glam::{DVec2, DVec3};

use super::emitter;
use crate::geometry::{convex, polygon};
use crate::id::{FaceId, Table, VertexId};
use crate::prepare::Prepared;
use crate::scene::Rgb;

/// Of what the surface's light is reflected with on the mean, by power, a bright patch reflects at least this share:
/// where the border of a part fades, half is where it fades fastest.
const BRIGHT_SHARE: f64 = 0.5;
/// A part that covers more than this share of its surface ends where the surface ends: nothing is told apart.
const NEARLY_WHOLE: f64 = 0.75;
/// A part that fills less than this share of its convex hull, a ring or a thin angle, has other shadows than the hull.
const LEAST_FILLED: f64 = 0.5;
/// A part whose radiosity departs from its mean by more than this share, as root mean square, fades towards its border,
/// which is then none: cuts along shadows in the light of a spot with a soft cone (0.25) cost triangles and save none,
/// a hard one (0.15) is even enough.
const MOST_UNEVEN: f64 = 0.2;
/// The outline of a part has at most so many corners: each casts lines of its own, and light that fades has none.
const MOST_CORNERS: usize = 8;
/// A corner of the outline that cuts off less than this share of its area is one of patches, not of the light.
const LEAST_CORNER: f64 = 0.01;

/// A patch that is not split, and what it reflects.
#[derive(Clone, Debug, PartialEq)]
pub struct Reflecting {
    /// The face that it is a part of.
    pub face: FaceId,
    /// Its boundary points, those that neighbours made included, counter-clockwise: vertices of the mesh and where they
    /// are, in metres.
    pub boundary: Vec<(VertexId, DVec3)>,
    /// Mean radiosity by reflection, in W/m2.
    pub reflected: Rgb,
}

impl Reflecting {
    /// Area, in square metres.
    pub(super) fn area_m2(&self) -> f64 {
        let corners_m: Vec<DVec3> = self.boundary.iter().map(|point| point.1).collect();
        polygon::area_m2(&corners_m)
    }
}

/// A convex part of a surface that reflects more than the rest.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct BrightPart {
    /// The faces of the surface that it lies on, ascending.
    pub(super) faces: Vec<FaceId>,
    /// Its corners, counter-clockwise seen from the front, in metres.
    pub(super) corners_m: Vec<DVec3>,
    /// Area, in square metres.
    pub(super) area_m2: f64,
    /// Mean radiosity over that of the rest of the surface, in W/m2.
    pub(super) excess: Rgb,
}

impl BrightPart {
    /// What it reflects over the rest of the surface, in W over the three colours.
    pub(super) fn power_w(&self) -> f64 {
        self.area_m2 * self.excess.element_sum()
    }
}

/// A surface with bright parts.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct PartlyBright {
    /// Its faces, ascending: they touch, lie in one plane and look the same way.
    pub(super) faces: Vec<FaceId>,
    /// The parts, by their least faces and vertices.
    pub(super) parts: Vec<BrightPart>,
    /// What the rest would reflect if it were all of the surface, in W over the three colours.
    pub(super) rest_w: f64,
}

/// The surfaces on which parts reflect at least `least` more than the rest, in W/m2 over the three colours, in the
/// order of their first faces.
pub(super) fn partly_bright(prepared: &Prepared, patches: &[Reflecting], least: f64) -> Vec<PartlyBright> {
    let mut on_face: Table<FaceId, Vec<Lit<'_>>> = prepared.faces.iter().map(|_| Vec::new()).collect();
    for patch in patches {
        on_face[patch.face].push(Lit { patch, area_m2: patch.area_m2(), radiosity: patch.reflected.element_sum() });
    }
    let surfaces = emitter::groups(prepared, |_, _| true);
    surfaces.into_iter().filter_map(|faces| of_surface(prepared, faces, &on_face, least)).collect()
}

/// A patch of a surface.
#[derive(Clone, Copy)]
struct Lit<'a> {
    patch: &'a Reflecting,
    area_m2: f64,
    /// Over the three colours, in W/m2.
    radiosity: f64,
}

fn of_surface(
    prepared: &Prepared,
    faces: Vec<FaceId>,
    on_face: &Table<FaceId, Vec<Lit<'_>>>,
    least: f64,
) -> Option<PartlyBright> {
    let lit = || faces.iter().flat_map(|&face| &on_face[face]);
    let sum = |of: &dyn Fn(&Lit<'_>) -> f64| lit().map(of).sum::<f64>();
    let (area_m2, power_w) = (sum(&|lit| lit.area_m2), sum(&|lit| lit.area_m2 * lit.radiosity));
    let typical = sum(&|lit| lit.area_m2 * lit.radiosity * lit.radiosity) / power_w;
    // Not a number where nothing is reflected.
    if typical.is_nan() || typical < least {
        return None;
    }
    let (bright, dark): (Vec<Lit<'_>>, Vec<Lit<'_>>) = lit().partition(|lit| lit.radiosity >= BRIGHT_SHARE * typical);
    let dark_m2: f64 = dark.iter().map(|lit| lit.area_m2).sum();
    if dark_m2 <= (1.0 - NEARLY_WHOLE) * area_m2 {
        return None;
    }
    let rest = dark.iter().map(|lit| lit.area_m2 * lit.patch.reflected).sum::<Rgb>() / dark_m2;
    let most_m2 = NEARLY_WHOLE * area_m2;
    let parts: Vec<BrightPart> = touching(&bright)
        .iter()
        .filter_map(|part| hull_of(prepared, part, rest))
        .filter(|part| part.area_m2 <= most_m2 && part.excess.element_sum() >= least)
        .collect();
    (!parts.is_empty()).then(|| PartlyBright { faces, parts, rest_w: area_m2 * rest.element_sum() })
}

/// The convex hull of patches, as a source of what they reflect over the rest.
fn hull_of(prepared: &Prepared, patches: &[Lit<'_>], rest: Rgb) -> Option<BrightPart> {
    let mut faces: Vec<FaceId> = patches.iter().map(|lit| lit.patch.face).collect();
    faces.sort_unstable();
    faces.dedup();
    let frame = prepared.face_frame(*faces.first()?);
    let points: Vec<DVec2> =
        patches.iter().flat_map(|lit| &lit.patch.boundary).map(|&(_, at_m)| frame.to_2d(at_m)).collect();
    let corners = convex::with_few_corners(convex::hull(points), MOST_CORNERS, LEAST_CORNER);
    let area_m2 = polygon::signed_area_2d_m2(&corners);
    let bright_m2: f64 = patches.iter().map(|lit| lit.area_m2).sum();
    let mean = patches.iter().map(|lit| lit.area_m2 * lit.radiosity).sum::<f64>() / bright_m2;
    let variance = patches.iter().map(|lit| lit.area_m2 * (lit.radiosity - mean).powi(2)).sum::<f64>() / bright_m2;
    if bright_m2 < LEAST_FILLED * area_m2 || variance > (MOST_UNEVEN * mean).powi(2) {
        return None;
    }
    let excess_w: Rgb = patches.iter().map(|lit| lit.area_m2 * (lit.patch.reflected - rest)).sum();
    let excess = (excess_w / area_m2).max(Rgb::ZERO);
    Some(BrightPart { faces, corners_m: corners.iter().map(|&p| frame.to_3d(p)).collect(), area_m2, excess })
}

/// Groups of patches that share boundary points, each in the order given, by their first members.
fn touching<'a>(patches: &[Lit<'a>]) -> Vec<Vec<Lit<'a>>> {
    fn root(leader: &mut [usize], mut i: usize) -> usize {
        while leader[i] != i {
            leader[i] = leader[leader[i]];
            i = leader[i];
        }
        i
    }
    // Of a group, each patch leads to one before it, but for the first.
    let mut leader: Vec<usize> = (0..patches.len()).collect();
    let mut at_vertex: BTreeMap<VertexId, usize> = BTreeMap::new();
    for (i, lit) in patches.iter().enumerate() {
        for &(vertex, _) in &lit.patch.boundary {
            let other = *at_vertex.entry(vertex).or_insert(i);
            let (one, other) = (root(&mut leader, i), root(&mut leader, other));
            leader[one.max(other)] = one.min(other);
        }
    }
    let mut groups: BTreeMap<usize, Vec<Lit<'a>>> = BTreeMap::new();
    for (i, &lit) in patches.iter().enumerate() {
        groups.entry(root(&mut leader, i)).or_default().push(lit);
    }
    groups.into_values().collect()
}
