//! The baked mesh from the triangulated patches: one value of irradiance for each group of corners.
//!
//! Before: every leaf of the mesh is a triangle. After: a [`BakedMesh`] in the order of patches; vertices are shared
//! within a part by corners of one group.

use rayon::prelude::*;

use super::corner_group::{self, CornerGroup, Triangle};
use super::field::{Field, Places, Values};
use super::{BakedMesh, BakedPart};
use crate::id::{SurfaceId, Table};
use crate::mesh::Mesh;
use crate::prepare::Prepared;
use crate::progress::{Cancelled, Progress, Stage};
use crate::scene::{Rgb, Scene};
use crate::visibility::ReceiverPoint;

/// Groups evaluated between two reports of progress.
const GROUPS_A_REPORT: usize = 256;

/// Assembles the triangles. Each group of corners has the value that refinement left at its vertex; where a contact passes
/// through it, or nothing is known, the irradiance is evaluated.
///
/// # Errors
/// [`Cancelled`] where the progress callback asks to stop.
pub(super) fn assemble(
    scene: &Scene,
    prepared: &Prepared,
    mesh: &Mesh,
    places: &Places<'_>,
    known: &Values,
    irradiance: &impl Field,
    progress: Progress<'_>,
) -> Result<BakedMesh, Cancelled> {
    let triangles = corner_group::triangles(mesh);
    let (groups, group_of) = corner_group::corner_groups(prepared, mesh, &triangles);
    let values = groups
        .par_iter()
        .enumerate()
        .map(|(number, group)| {
            if number.is_multiple_of(GROUPS_A_REPORT) {
                progress.report(Stage::Shade, number, groups.len())?;
            }
            let patch = triangles[group.first_triangle].patch;
            let place = places.vertex(mesh, patch, group.vertex);
            if let Some(value) = known.get(&place.key).filter(|_| place.key.is_of_plane()) {
                return Ok(value);
            }
            let point = ReceiverPoint {
                position_m: group.at_m,
                normal: prepared.normal(group.face),
                plane: prepared.faces[group.face].plane,
            };
            Ok(irradiance.at(mesh, &point, patch))
        })
        .collect::<Result<Vec<Rgb>, Cancelled>>()?;
    Ok(parts(scene, prepared, mesh, &triangles, &groups, &group_of, &values))
}

fn parts(
    scene: &Scene,
    prepared: &Prepared,
    mesh: &Mesh,
    triangles: &[Triangle],
    groups: &[CornerGroup],
    group_of: &[[usize; 3]],
    values: &[Rgb],
) -> BakedMesh {
    let mut parts: Table<SurfaceId, BakedPart> = scene
        .surfaces
        .keys()
        .map(|surface| BakedPart {
            surface,
            positions_m: Vec::new(),
            normals: Vec::new(),
            irradiance: Vec::new(),
            triangles: Vec::new(),
        })
        .collect();
    // Number of each group's vertex in the part that used it last.
    let mut placed: Vec<Option<(SurfaceId, u32)>> = vec![None; groups.len()];
    let mut by_surface: Vec<usize> = (0..triangles.len()).collect();
    by_surface.sort_by_key(|&number| (prepared.faces[triangles[number].face].surface, number));
    for number in by_surface {
        let surface = prepared.faces[triangles[number].face].surface;
        let part = &mut parts[surface];
        let corners = group_of[number].map(|group| match placed[group] {
            Some((owner, vertex)) if owner == surface => vertex,
            _ => {
                let vertex = part.positions_m.len() as u32;
                part.positions_m.push(mesh.vertex_m(groups[group].vertex).as_vec3().to_array());
                part.normals.push(prepared.normal(groups[group].face).as_vec3().normalize().to_array());
                part.irradiance.push(values[group].max(Rgb::ZERO).as_vec3().to_array());
                placed[group] = Some((surface, vertex));
                vertex
            }
        });
        part.triangles.push(corners);
    }
    BakedMesh { origin_m: prepared.origin_m, parts: parts.into() }
}
