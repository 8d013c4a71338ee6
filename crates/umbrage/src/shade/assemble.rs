//! The baked mesh from the triangulated patches: one value of irradiance for each group of corners.
//!
//! Before: every leaf of the mesh is a triangle. After: a [`BakedMesh`] in the order of patches; vertices are shared
//! within a part by corners that have the same in all that a vertex has. No triangle is flat as a needle.

use glam::DVec3;
use rayon::prelude::*;
use rustc_hash::FxHashMap;

use super::corner_group;
use super::field::{Field, Places, Values};
use super::flat::{self, Limit, LitTriangle};
use super::rim;
use super::straight_joint;
use super::{BakedMesh, BakedPart};
use crate::id::{FaceId, SurfaceId, Table, VertexId};
use crate::mesh::Mesh;
use crate::prepare::Prepared;
use crate::progress::{Cancelled, Progress, Stage};
use crate::scene::{Rgb, Scene};
use crate::visibility::ReceiverPoint;

/// Groups evaluated between two reports of progress.
const GROUPS_A_REPORT: usize = 16;

/// Where the light of corners is known from.
pub(super) struct Lighting<'a, F> {
    /// What refinement left.
    pub(super) known: &'a Values,
    /// All light, anywhere.
    pub(super) irradiance: &'a F,
}

/// Assembles the triangles. Each group of corners has the value that refinement left at its vertex; where a contact passes
/// through it, or nothing is known, the irradiance is evaluated. Also returned is how many flat triangles were taken out; what
/// is written are no more than `most_triangles`, if the leaves are not: rims are added where that leaves room for them.
///
/// # Errors
/// [`Cancelled`] where the progress callback asks to stop.
pub(super) fn assemble(
    scene: &Scene,
    prepared: &Prepared,
    mesh: &Mesh,
    places: &Places<'_>,
    Lighting { known, irradiance }: Lighting<'_, impl Field>,
    most_triangles: usize,
    progress: Progress<'_>,
) -> Result<(BakedMesh, usize), Cancelled> {
    let triangles = corner_group::triangles(mesh);
    let (groups, group_of) = corner_group::corner_groups(prepared, mesh, places, &triangles);
    let mut values = groups
        .par_iter()
        .enumerate()
        .map(|(number, group)| {
            if number.is_multiple_of(GROUPS_A_REPORT) {
                progress.report(Stage::Shade, number, groups.len())?;
            }
            let patch = triangles[group.first_triangle].patch;
            let place = places.vertex(mesh, patch, group.vertex);
            if let Some(value) = known.get(&place.key).filter(|_| place.key.is_shared()) {
                return Ok(value);
            }
            let flat = || ReceiverPoint::on_flat_face(prepared, group.face, group.at_m);
            let point = if prepared.is_smooth(group.face) { place.point } else { flat() };
            if !mesh.is_jump_vertex(group.vertex) {
                return Ok(irradiance.at(mesh, &point, patch));
            }
            let largest = &triangles[group.largest_triangle];
            let corners_m = largest.vertices.map(|vertex| mesh.vertex_m(vertex));
            Ok(irradiance.at(mesh, &places.beside_jump(mesh, largest.patch, point, &corners_m), patch))
        })
        .collect::<Result<Vec<Rgb>, Cancelled>>()?;
    let lit = triangles.iter().zip(group_of);
    let mut lit: Vec<LitTriangle> =
        lit.map(|(t, values)| LitTriangle { face: t.face, vertices: t.vertices, values }).collect();
    let is_written = |face: FaceId| scene.surfaces[prepared.faces[face].surface].baked;
    let limit = Limit { most: most_triangles, is_written: &is_written };
    let side = |face: FaceId| (prepared.faces[face].plane, prepared.faces[face].facing);
    let joined = straight_joint::join(&mut lit, |v| mesh.vertex_m(v), side, prepared.tolerance.weld_m());
    let flat =
        joined + flat::take_out(&mut lit, &mut values, |v| mesh.vertex_m(v), prepared.tolerance.weld_m(), &limit);
    let mut strips = rim::strips(prepared, mesh, &lit, &values);
    if lit.iter().chain(&strips.triangles).filter(|triangle| is_written(triangle.face)).count() <= most_triangles {
        lit.append(&mut strips.triangles);
    }
    let vertex_m = |v: VertexId| match v.index().checked_sub(mesh.vertex_count()) {
        Some(number) => strips.vertices_m[number],
        None => mesh.vertex_m(v),
    };
    Ok((parts(scene, prepared, vertex_m, &lit, &values), flat))
}

/// A vertex of a part: position, normal, irradiance and texture coordinates.
type Vertex = ([f32; 3], [f32; 3], [f32; 3], Option<[f32; 2]>);

/// The parts of all surfaces that are baked. Corners with the same bits of all that a vertex has are one vertex.
fn parts(
    scene: &Scene,
    prepared: &Prepared,
    vertex_m: impl Fn(VertexId) -> DVec3,
    triangles: &[LitTriangle],
    values: &[Rgb],
) -> BakedMesh {
    let mut parts: Table<SurfaceId, BakedPart> = scene.surfaces.keys().map(BakedPart::new).collect();
    let mut by_surface: Vec<usize> = (0..triangles.len()).collect();
    by_surface.retain(|&number| scene.surfaces[prepared.faces[triangles[number].face].surface].baked);
    by_surface.sort_by_key(|&number| (prepared.faces[triangles[number].face].surface, number));
    let vertex = |face: FaceId, vertex: VertexId, value: usize| -> Vertex {
        let at_m = vertex_m(vertex);
        let uv = prepared.faces[face].skin.and_then(|skin| prepared.skins[skin].uv(at_m));
        let irradiance = values[value].max(Rgb::ZERO).as_vec3().to_array();
        (
            at_m.as_vec3().to_array(),
            prepared.smooth_normal(face, at_m).as_vec3().normalize().to_array(),
            irradiance,
            uv.map(|uv| uv.as_vec2().to_array()),
        )
    };
    let surface_of = |number: usize| prepared.faces[triangles[number].face].surface;
    for of_surface in by_surface.chunk_by(|&p, &q| surface_of(p) == surface_of(q)) {
        let part = &mut parts[surface_of(of_surface[0])];
        let mut known: FxHashMap<[u32; 11], u32> = FxHashMap::default();
        for &number in of_surface {
            let LitTriangle { face, vertices, values } = triangles[number];
            let corners = [0, 1, 2].map(|k| {
                let vertex = vertex(face, vertices[k], values[k]);
                *known.entry(bits(&vertex)).or_insert_with(|| {
                    let (position_m, normal, irradiance, uv) = vertex;
                    part.positions_m.push(position_m);
                    part.normals.push(normal);
                    part.irradiance.push(irradiance);
                    part.uvs.extend(uv);
                    part.positions_m.len() as u32 - 1
                })
            });
            part.triangles.push(corners);
        }
    }
    BakedMesh { origin_m: prepared.origin_m, parts: parts.into() }
}

/// The bits of all that a vertex has.
fn bits((position_m, normal, irradiance, uv): &Vertex) -> [u32; 11] {
    let mut bits = [0; 11];
    let numbers = position_m.iter().chain(normal).chain(irradiance).chain(uv.iter().flatten());
    bits.iter_mut().zip(numbers).for_each(|(bits, number)| *bits = number.to_bits());
    bits
}
