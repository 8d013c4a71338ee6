//! A baked file as tables for a graphics processor.
//!
//! Idea: a vertex carries both colours that can be asked for and its irradiance, so that changing what is shown changes
//! no table; triangles are sorted by texture alone. Triangles that get no light at any corner come last in each group:
//! where one thing stands on another, the covered area is black, and its border is as near as what covers it, so it is
//! drawn as if it were a little farther away.
//!
//! Holds: groups cover all indices, one after the other; positions are relative to the file's origin, with the bits of
//! the file; the same file gives the same tables.

use std::sync::Arc;

use glam::DVec3;
use umbrage_cli::shown::{Colors, Shown};
use umbrage_picture::color::luminance;
use umbrage_picture::{PictureMesh, Texture};

/// Position (3), base colour times light (3), light (3), irradiance, place in the texture (2), and the alpha of the
/// texture below which nothing is drawn.
pub(crate) type Vertex = [f32; 13];

/// Triangles with one texture, or none.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Group {
    /// Its number in [`Tables::textures`].
    pub(crate) texture: Option<usize>,
    /// The first of its indices.
    pub(crate) first: u32,
    /// How many belong to triangles with light.
    pub(crate) lit: u32,
    /// How many belong to triangles without, which come after.
    pub(crate) dark: u32,
}

/// What is drawn of a baked file.
#[derive(Clone, Debug)]
pub(crate) struct Tables {
    pub(crate) vertices: Vec<Vertex>,
    pub(crate) indices: Vec<u32>,
    pub(crate) groups: Vec<Group>,
    pub(crate) textures: Vec<Arc<Texture>>,
    /// What is added to a position to place it in the world, in metres.
    pub(crate) origin_m: DVec3,
    /// The box around all vertices, relative to the origin, in metres.
    pub(crate) bounds_m: [DVec3; 2],
}

/// Lays out a baked file.
pub(crate) fn lay_out(shown: &Shown) -> Tables {
    let file = &shown.file;
    let mut textures: Vec<Arc<Texture>> = Vec::new();
    let of_part: Vec<Option<usize>> = shown.textures().iter().map(|texture| number(texture, &mut textures)).collect();

    let (seen, light) = (shown.meshes(Colors::Seen, file.exposure_k), shown.meshes(Colors::Light, file.exposure_k));
    let mut vertices = Vec::with_capacity(file.vertex_count());
    for ((part, seen), light) in file.parts.iter().zip(&seen).zip(&light) {
        vertices.extend((0..part.positions_m.len()).map(|i| {
            let [x, y, z] = part.positions_m[i];
            let ([r, g, b], [lr, lg, lb]) = (seen.colors[i], light.colors[i]);
            let [u, v] = part.uvs.get(i).copied().unwrap_or_default();
            [x, y, z, r, g, b, lr, lg, lb, luminance(part.irradiance[i]), u, v, part.cutoff.unwrap_or(0.0)]
        }));
    }

    let (mut indices, mut groups) = (Vec::with_capacity(3 * file.triangle_count()), Vec::new());
    for texture in std::iter::once(None).chain((0..textures.len()).map(Some)) {
        let (mut lit, mut dark, mut first_vertex) = (Vec::new(), Vec::new(), 0);
        for (mesh, own) in light.iter().zip(&of_part) {
            if *own == texture {
                let is_dark = |vertex: u32| mesh.colors[vertex as usize] == [0.0; 3];
                for &triangle in &mesh.triangles {
                    let table = if triangle.into_iter().all(is_dark) { &mut dark } else { &mut lit };
                    table.extend(triangle.map(|vertex| first_vertex + vertex));
                }
            }
            first_vertex += mesh.positions_m.len() as u32;
        }
        let first = indices.len() as u32;
        if !(lit.is_empty() && dark.is_empty()) {
            groups.push(Group { texture, first, lit: lit.len() as u32, dark: dark.len() as u32 });
        }
        indices.extend(lit);
        indices.extend(dark);
    }
    Tables { vertices, indices, groups, textures, origin_m: file.origin_m, bounds_m: bounds_m(&seen, file.origin_m) }
}

/// The number of a part's texture.
fn number(texture: &Option<Arc<Texture>>, known: &mut Vec<Arc<Texture>>) -> Option<usize> {
    let texture = texture.as_ref()?;
    let number = known.iter().position(|other| Arc::ptr_eq(other, texture));
    Some(number.unwrap_or_else(|| {
        known.push(Arc::clone(texture));
        known.len() - 1
    }))
}

fn bounds_m(meshes: &[PictureMesh], origin_m: DVec3) -> [DVec3; 2] {
    umbrage_picture::bounds_m(meshes).map_or([DVec3::ZERO; 2], |bounds| bounds.map(|corner| corner - origin_m))
}

impl Tables {
    /// The vertices of all triangles, each triangle with its own three.
    pub(crate) fn unshared(&self) -> Vec<Vertex> {
        self.indices.iter().map(|&index| self.vertices[index as usize]).collect()
    }

    /// Length of the box's diagonal, in metres; 1 where there is none.
    pub(crate) fn size_m(&self) -> f64 {
        let size_m = self.bounds_m[0].distance(self.bounds_m[1]);
        if size_m > 0.0 { size_m } else { 1.0 }
    }

    /// The box in the world, in metres.
    pub(crate) fn world_bounds_m(&self) -> [DVec3; 2] {
        self.bounds_m.map(|corner| self.origin_m + corner)
    }
}

#[cfg(test)]
pub(crate) mod tests {
    use std::path::Path;

    use serde_json::Map;
    use umbrage_formats::{BakedFile, BakedFilePart};

    use super::*;

    /// A square of two triangles that looks along +Z, the second without light, `at` metres to the right.
    pub(crate) fn square(at: f32, irradiance: f32) -> BakedFilePart {
        BakedFilePart {
            node_name: "stand".into(),
            name: "table".into(),
            material_name: "wood".into(),
            positions_m: [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]].map(|[x, y]| [at + x, y, 0.0]).into(),
            normals: vec![[0.0, 0.0, 1.0]; 4],
            color: vec![[0.0, 0.0, 0.0, 1.0], [0.5, 0.5, 0.5, 1.0], [0.0, 0.0, 0.0, 1.0], [0.0, 0.0, 0.0, 1.0]],
            base_color: [0.5, 0.25, 1.0, 1.0],
            texture: None,
            uvs: Vec::new(),
            cutoff: None,
            emission: None,
            irradiance: vec![[irradiance; 3]; 4],
            triangles: vec![[0, 1, 2], [0, 2, 3]],
        }
    }

    pub(crate) fn shown(parts: Vec<BakedFilePart>) -> Shown {
        let file = BakedFile {
            name: String::new(),
            origin_m: DVec3::new(10.0, 0.0, 0.0),
            parts,
            cameras: Vec::new(),
            images: Vec::new(),
            exposure_k: 1.0,
            photometric: false,
            extras: Map::new(),
        };
        Shown::new(file, Path::new("test.glb")).unwrap()
    }

    #[test]
    fn triangles_without_light_come_last() {
        let tables = lay_out(&shown(vec![square(0.0, 1.0), square(2.0, 3.0)]));
        assert_eq!(tables.indices, [0, 1, 2, 4, 5, 6, 0, 2, 3, 4, 6, 7]);
        assert_eq!(tables.groups, [Group { texture: None, first: 0, lit: 6, dark: 6 }]);
        assert_eq!(tables.unshared().len(), 12);
    }

    #[test]
    fn a_vertex_has_both_colours_and_its_irradiance() {
        let tables = lay_out(&shown(vec![square(2.0, 3.0)]));
        let vertex = tables.vertices[1];
        assert_eq!(vertex[..9], [3.0, 0.0, 0.0, 0.25, 0.125, 0.5, 0.5, 0.5, 0.5]);
        assert!((vertex[9] - 3.0).abs() < 1e-6);
    }

    #[test]
    fn the_box_is_relative_to_the_origin() {
        let tables = lay_out(&shown(vec![square(-1.0, 1.0)]));
        assert_eq!(tables.bounds_m, [DVec3::new(-1.0, 0.0, 0.0), DVec3::new(0.0, 1.0, 0.0)]);
        assert_eq!(tables.world_bounds_m()[0], DVec3::new(9.0, 0.0, 0.0));
        assert!((tables.size_m() - 2f64.sqrt()).abs() < 1e-12);
        assert_eq!(lay_out(&shown(Vec::new())).size_m(), 1.0);
    }
}
