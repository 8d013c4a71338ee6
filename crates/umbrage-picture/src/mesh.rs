//! What is drawn: triangles with a colour at each vertex, in plain types.
//!
//! The crate knows neither scenes nor files. Whoever has a baked mesh multiplies its base colour with its light
//! (`COLOR_0`) into [`PictureMesh::colors`]; a texture multiplies them once more, at each sample.

use std::sync::Arc;

use glam::DVec3;

use crate::color::LinearRgb;
use crate::texture::Texture;

/// A triangle mesh with linear colours at its vertices.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct PictureMesh {
    /// Vertices in world space, in metres.
    pub positions_m: Vec<[f64; 3]>,
    /// Colour of each vertex; may exceed 1.
    pub colors: Vec<LinearRgb>,
    /// Where each vertex lies in the texture, (0, 0) being its upper left corner; empty without texture.
    pub uvs: Vec<[f32; 2]>,
    /// What the colours are multiplied with; several meshes may share it.
    pub texture: Option<Arc<Texture>>,
    /// A texture of the same places: where its alpha is less than the number, nothing is drawn.
    pub mask: Option<(Arc<Texture>, f32)>,
    /// Triangles, counter-clockwise seen from the front; from behind they cannot be seen.
    pub triangles: Vec<[u32; 3]>,
}

/// A mesh that cannot be drawn.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum MeshError {
    /// Not one colour per vertex.
    #[error("{positions} vertices, but {colors} colours")]
    ColorCount {
        /// Number of vertices.
        positions: usize,
        /// Number of colours.
        colors: usize,
    },
    /// There is a texture or a mask, but not one place in it per vertex.
    #[error("{positions} vertices, but {uvs} places in the texture")]
    UvCount {
        /// Number of vertices.
        positions: usize,
        /// Number of places.
        uvs: usize,
    },
    /// A triangle refers to a vertex that does not exist.
    #[error("triangle {triangle} refers to vertex {vertex}, but there are only {positions}")]
    BadIndex {
        /// Number of the triangle.
        triangle: usize,
        /// The index that is too large.
        vertex: u32,
        /// Number of vertices.
        positions: usize,
    },
    /// A vertex has a coordinate that is NaN or infinite.
    #[error("vertex {0} is not a finite point")]
    NotFinite(usize),
}

impl PictureMesh {
    /// Checks that the tables fit together and all vertices are finite.
    ///
    /// # Errors
    /// The first thing that is wrong.
    pub fn validate(&self) -> Result<(), MeshError> {
        let positions = self.positions_m.len();
        if self.colors.len() != positions {
            return Err(MeshError::ColorCount { positions, colors: self.colors.len() });
        }
        if (self.texture.is_some() || self.mask.is_some()) && self.uvs.len() != positions {
            return Err(MeshError::UvCount { positions, uvs: self.uvs.len() });
        }
        if let Some(vertex) = self.positions_m.iter().position(|p| p.iter().any(|x| !x.is_finite())) {
            return Err(MeshError::NotFinite(vertex));
        }
        for (triangle, corners) in self.triangles.iter().enumerate() {
            if let Some(&vertex) = corners.iter().find(|&&i| i as usize >= positions) {
                return Err(MeshError::BadIndex { triangle, vertex, positions });
            }
        }
        Ok(())
    }

    /// The corners of each triangle, in metres.
    pub(crate) fn corners_m(&self) -> impl Iterator<Item = [DVec3; 3]> + '_ {
        self.triangles.iter().map(|t| t.map(|i| DVec3::from(self.positions_m[i as usize])))
    }
}

/// The box around all triangles: its least and greatest corner in metres, or nothing where there is no triangle.
pub fn bounds_m(meshes: &[PictureMesh]) -> Option<[DVec3; 2]> {
    let mut corners = meshes.iter().flat_map(PictureMesh::corners_m).flatten();
    let first = corners.next()?;
    Some(corners.fold([first, first], |[low, high], p| [low.min(p), high.max(p)]))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn triangle() -> PictureMesh {
        PictureMesh {
            positions_m: vec![[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 2.0, 0.0], [9.0, 9.0, 9.0]],
            colors: vec![[1.0; 3]; 4],
            triangles: vec![[0, 1, 2]],
            ..PictureMesh::default()
        }
    }

    #[test]
    fn a_vertex_without_triangle_does_not_widen_the_bounds() {
        assert_eq!(bounds_m(&[triangle()]), Some([DVec3::ZERO, DVec3::new(1.0, 2.0, 0.0)]));
        assert_eq!(bounds_m(&[PictureMesh::default()]), None);
    }

    #[test]
    fn broken_meshes_are_named() {
        assert_eq!(triangle().validate(), Ok(()));
        let mut mesh = triangle();
        mesh.colors.pop();
        assert_eq!(mesh.validate(), Err(MeshError::ColorCount { positions: 4, colors: 3 }));
        let mut mesh = triangle();
        mesh.triangles.push([0, 1, 4]);
        assert_eq!(mesh.validate(), Err(MeshError::BadIndex { triangle: 1, vertex: 4, positions: 4 }));
        let mut mesh = triangle();
        mesh.positions_m[3][1] = f64::NAN;
        assert_eq!(mesh.validate(), Err(MeshError::NotFinite(3)));
    }
}
