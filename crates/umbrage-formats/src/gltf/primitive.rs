//! Primitives: triangles, strips and fans, indexed or not, in world space.
//!
//! Only the vertices that are referred to are taken, in the order of their numbers: exporters often let a hundred
//! primitives share one table. Triangles without area are left for `prepare`, which counts them.

use glam::{DVec2, DVec3, DVec4};
use umbrage::scene::Rgb;

use super::accessor::{Accessor, Component};
use super::base_texture::BaseTexture;
use super::document::Document;
use super::item::Item;
use super::morph::Displacements;
use super::node;
use super::skin::{Placing, Pose};
use super::tally::{PRIMITIVE_COST, Tally};
use crate::FormatError;

/// The modes of triangles, in glTF's numbers; those below are points and lines.
const TRIANGLES: usize = 4;
const STRIP: usize = 5;
const FAN: usize = 6;
/// Types of positions and texture coordinates, with `KHR_mesh_quantization`.
const POSITIONS: [Component; 5] = [Component::F32, Component::I8, Component::U8, Component::I16, Component::U16];
/// Types of normals, with `KHR_mesh_quantization`.
const NORMALS: [Component; 3] = [Component::F32, Component::I8, Component::I16];
/// Types of colours.
const COLOURS: [Component; 3] = [Component::F32, Component::U8, Component::U16];
/// Types of indices.
const INDICES: [Component; 3] = [Component::U8, Component::U16, Component::U32];

/// The polygons of a primitive.
#[derive(Debug)]
pub(super) struct Polygons {
    /// World space, metres.
    pub(super) positions_m: Vec<DVec3>,
    /// Unit normals as the file has them, of each position; empty where it has none.
    pub(super) normals: Vec<DVec3>,
    /// The numbers that the positions have in the file.
    pub(super) used: Vec<u32>,
    /// Indices into the positions, counter-clockwise seen from the front.
    pub(super) triangles: Vec<[u32; 3]>,
    /// What the colours of the vertices multiply the reflectance with.
    pub(super) colour: Rgb,
    /// What they multiply alpha with.
    pub(super) alpha: VertexAlpha,
}

/// Alpha of the colours of vertices, 0 to 1.
#[derive(Clone, Copy, Debug)]
pub(super) struct VertexAlpha {
    pub(super) least: f64,
    pub(super) most: f64,
    /// Over the area.
    pub(super) mean: f64,
}

impl VertexAlpha {
    /// Where vertices have none.
    const OPAQUE: Self = Self { least: 1.0, most: 1.0, mean: 1.0 };
}

/// A primitive's polygons in the world, or nothing if it has none. `place` names node, mesh and primitive; `weights` are those of
/// its morph targets.
pub(super) fn polygons(
    document: &Document,
    primitive: &Item<'_>,
    place: &str,
    (pose, weights): (&Pose, &[f64]),
    tally: &mut Tally,
) -> Result<Option<Polygons>, FormatError> {
    tally.unfold(PRIMITIVE_COST, document, place)?;
    let attributes = primitive.child("attributes")?;
    let Some(position) = attributes.as_ref().map(|a| a.whole("POSITION")).transpose()?.flatten() else {
        tally.no_positions += 1;
        return Ok(None);
    };
    let positions = Accessor::open(document, position, &format!("{place}, POSITION"), &[3], &POSITIONS)?;
    tally.unfold(positions.sparse_count(), document, place)?;
    let placing = pose.of_primitive(document, attributes.as_ref(), place, tally)?;
    let mirrored = placing.is_mirrored();
    let triangles = triangles(document, primitive, place, positions.count, mirrored, tally)?;
    if triangles.is_empty() {
        return Ok(None);
    }
    let mut used: Vec<u32> = triangles.as_flattened().to_vec();
    used.sort_unstable();
    used.dedup();
    tally.morphed_primitives += usize::from(primitive.get("targets").is_some());
    let colours = attributes.as_ref().map(|a| a.whole("COLOR_0")).transpose()?.flatten();
    let colours = match colours {
        Some(colour) => {
            let colours = Accessor::open(document, colour, &format!("{place}, COLOR_0"), &[3, 4], &COLOURS)?;
            tally.unfold(colours.sparse_count(), document, place)?;
            Some(colours)
        }
        None => None,
    };
    let moved = Displacements::of(document, primitive, (place, "POSITION"), weights, tally)?;
    let mut polygons = place_in_world(document, (&positions, &moved), &used, triangles, &placing)?;
    if let Some(colours) = colours {
        (polygons.colour, polygons.alpha) = average_colour(&colours, &used, &polygons, tally);
    }
    let turned = Displacements::of(document, primitive, (place, "NORMAL"), weights, tally)?;
    polygons.normals = normals(document, (attributes.as_ref(), &turned), place, &used, &placing, tally)?;
    polygons.used = used;
    Ok(Some(polygons))
}

/// The normals of the vertices that are used, in the world; none where the file has not one for each.
fn normals(
    document: &Document,
    (attributes, turned): (Option<&Item<'_>>, &Displacements<'_>),
    place: &str,
    used: &[u32],
    placing: &Placing<'_>,
    tally: &mut Tally,
) -> Result<Vec<DVec3>, FormatError> {
    let Some(normal) = attributes.map(|a| a.whole("NORMAL")).transpose()?.flatten() else { return Ok(Vec::new()) };
    let normals = Accessor::open(document, normal, &format!("{place}, NORMAL"), &[3], &NORMALS)?;
    tally.unfold(normals.sparse_count(), document, place)?;
    let of_all = match placing {
        Placing::Rigid(world) => Some(node::normal_matrix(world)),
        Placing::Skinned { .. } => None,
    };
    let turn = |vertex: usize| of_all.unwrap_or_else(|| node::normal_matrix(&placing.at(vertex)));
    let one = |&vertex: &u32| {
        let vertex = vertex as usize;
        let normal = (vertex < normals.count)
            .then(|| turn(vertex) * (DVec3::from(normals.element::<3>(vertex, 0.0)) + turned.at(vertex)));
        normal.and_then(DVec3::try_normalize)
    };
    Ok(used.iter().map(one).collect::<Option<_>>().unwrap_or_default())
}

/// The places in a texture's image of the vertices that are used; nothing where the primitive has not one for each.
pub(super) fn places_in_texture(
    document: &Document,
    primitive: &Item<'_>,
    place: &str,
    texture: &BaseTexture,
    used: &[u32],
    tally: &mut Tally,
) -> Result<Option<Vec<DVec2>>, FormatError> {
    let key = format!("TEXCOORD_{}", texture.set);
    let index = primitive.child("attributes")?.map(|a| a.whole(&key)).transpose()?.flatten();
    let Some(index) = index else { return Ok(None) };
    let coordinates = Accessor::open(document, index, &format!("{place}, {key}"), &[2], &POSITIONS)?;
    tally.unfold(coordinates.sparse_count(), document, place)?;
    let one = |&vertex: &u32| {
        let vertex = vertex as usize;
        (vertex < coordinates.count)
            .then(|| texture.place(coordinates.element::<2>(vertex, 0.0)))
            .filter(|place| place.as_vec2().is_finite())
    };
    Ok(used.iter().map(one).collect())
}

/// The colour of a primitive's vertices, averaged over its area where it varies, and their alpha. Channels are cut to 0 to 1.
fn average_colour(colours: &Accessor<'_>, used: &[u32], polygons: &Polygons, tally: &mut Tally) -> (Rgb, VertexAlpha) {
    let of_vertex = |vertex: u32| {
        let vertex = vertex as usize;
        // The element of a colour without alpha is filled up with what stands behind.
        let colour = if vertex < colours.count { colours.element::<4>(vertex, 1.0) } else { [1.0; 4] };
        DVec4::from(colour.map(|channel| if channel.is_nan() { 0.0 } else { channel.clamp(0.0, 1.0) }))
    };
    let all: Vec<DVec4> = used.iter().map(|&vertex| of_vertex(vertex)).collect();
    let Some(&first) = all.first() else { return (Rgb::ONE, VertexAlpha::OPAQUE) };
    let (least, most) = all.iter().fold((1.0, 0.0), |(least, most): (f64, f64), c| (least.min(c.w), most.max(c.w)));
    let with = |mean: DVec4| (mean.truncate(), VertexAlpha { least, most, mean: mean.w });
    if all.iter().all(|&colour| colour == first) {
        return with(first);
    }
    tally.varying_colours += usize::from(all.iter().any(|colour| colour.truncate() != first.truncate()));
    let (mut sum, mut total) = (DVec4::ZERO, 0.0);
    for triangle in &polygons.triangles {
        let [a, b, c] = triangle.map(|i| polygons.positions_m[i as usize]);
        let area = (b - a).cross(c - a).length();
        let colour: DVec4 = triangle.iter().map(|&i| all[i as usize]).sum();
        sum += area * colour / 3.0;
        total += area;
    }
    with(if total > 0.0 && sum.is_finite() { (sum / total).min(DVec4::ONE) } else { first })
}

/// A primitive's triangles as numbers of its vertices, turned over if `mirrored`. Points and lines have none.
pub(super) fn triangles(
    document: &Document,
    primitive: &Item<'_>,
    place: &str,
    vertex_count: usize,
    mirrored: bool,
    tally: &mut Tally,
) -> Result<Vec<[u32; 3]>, FormatError> {
    let mode = primitive.whole("mode")?.unwrap_or(TRIANGLES);
    match mode {
        TRIANGLES | STRIP | FAN => {}
        0..TRIANGLES => {
            tally.points_and_lines += 1;
            return Ok(Vec::new());
        }
        _ => return Err(primitive.bad("mode", format!("{mode} is not a mode"))),
    }
    let indices = match primitive.whole("indices")? {
        Some(index) => Some(Accessor::open(document, index, &format!("{place}, indices"), &[1], &INDICES)?),
        None => None,
    };
    let corner_count = indices.as_ref().map_or(vertex_count, |indices| indices.count);
    tally.unfold(corner_count, document, place)?;

    let triangle_count = if mode == TRIANGLES { corner_count / 3 } else { corner_count.saturating_sub(2) };
    tally.left_over_corners += usize::from(corners_of(mode, triangle_count) != corner_count);
    let mut triangles = Vec::with_capacity(triangle_count);
    for triangle in 0..triangle_count {
        let mut vertices = [0; 3];
        for (vertex, corner) in vertices.iter_mut().zip(corners(mode, triangle)) {
            let index = indices.as_ref().map_or(corner, |indices| indices.index(corner));
            let fits = u32::try_from(index).ok().filter(|_| index < vertex_count);
            *vertex = fits.ok_or_else(|| FormatError::BadIndex {
                file: document.file.clone(),
                place: format!("{place}, triangle {triangle}"),
                index: index as u64,
                count: vertex_count,
            })?;
        }
        let [a, b, c] = vertices;
        triangles.push(if mirrored { [a, c, b] } else { vertices });
    }
    Ok(triangles)
}

/// The corners that so many triangles use up.
fn corners_of(mode: usize, triangles: usize) -> usize {
    match (mode, triangles) {
        (_, 0) => 0,
        (TRIANGLES, n) => 3 * n,
        (_, n) => n + 2,
    }
}

/// The corners of a triangle, glTF 2.0, section 3.7.2.1.
fn corners(mode: usize, triangle: usize) -> [usize; 3] {
    match mode {
        TRIANGLES => [3 * triangle, 3 * triangle + 1, 3 * triangle + 2],
        STRIP => [triangle, triangle + 1 + triangle % 2, triangle + 2 - triangle % 2],
        _ => [triangle + 1, triangle + 2, 0],
    }
}

/// Takes the vertices that the triangles use, in ascending order, to the world.
fn place_in_world(
    document: &Document,
    (positions, moved): (&Accessor<'_>, &Displacements<'_>),
    used: &[u32],
    mut triangles: Vec<[u32; 3]>,
    placing: &Placing<'_>,
) -> Result<Polygons, FormatError> {
    let mut positions_m = Vec::with_capacity(used.len());
    for &vertex in used {
        let local = DVec3::from(positions.element::<3>(vertex as usize, 0.0)) + moved.at(vertex as usize);
        let position = placing.point(vertex as usize, local);
        if !position.is_finite() {
            return Err(FormatError::NotFinite {
                file: document.file.clone(),
                place: format!("{}, vertex {vertex}", positions.place),
                value: if local.is_finite() { format!("{position} in the world") } else { local.to_string() },
            });
        }
        positions_m.push(position);
    }
    for vertex in triangles.as_flattened_mut() {
        // Every vertex is in the list, which is no longer than the vertices, whose numbers fit.
        *vertex = used.partition_point(|other| other < vertex) as u32;
    }
    Ok(Polygons {
        positions_m,
        normals: Vec::new(),
        used: Vec::new(),
        triangles,
        colour: Rgb::ONE,
        alpha: VertexAlpha::OPAQUE,
    })
}
