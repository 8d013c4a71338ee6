//! Texels: the cells of a grid over each face, of about one size in the whole scene.
//!
//! A grid lies along the longest side of its face, so that a needle has few cells. A cell at a border is the part of it that lies in the
//! face; cells that lie outside, which rounding may lead to, are those beside them. In each texel one point stands for it, at a
//! random place: so a texel that a shadow boundary crosses is dark or lit in proportion, and no pattern meets the grid.
//!
//! Holds after: areas of the texels of a face add up to its area; each face has a texel; their number is at most a few times
//! [`TEXELS`], and two for each face.

use glam::{DVec2, DVec3, Vec3};
use rayon::prelude::*;

use super::sequence::{Sequence, key_of};
use crate::geometry::clip;
use crate::geometry::convex::Convex;
use crate::geometry::polygon;
use crate::id::{FaceId, Table};
use crate::prepare::Prepared;

/// Texels of the whole scene, about. With 30,000 reflected light errs no more, with 120,000 no less: they are gathered from again.
const TEXELS: f64 = 60_000.0;
/// The grids have no more cells than this many times [`TEXELS`], and some for each face: else texels are larger.
const MAX_CELLS_OF_TEXELS: f64 = 4.0;
const MAX_CELLS_A_FACE: f64 = 4.0;
/// Texels grow by this until cells are few enough.
const GROWTH: f64 = 1.3;
/// A cell of which a smaller share lies in the face is no texel.
const MIN_SHARE_OF_CELL: f64 = 1e-6;
/// A point lies so far inside its texel, as a share of the way to the middle, that no ray starts on an edge.
const INSIDE: f64 = 0.01;

/// A cell of a face.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Texel {
    /// The face that it is part of.
    pub(crate) face: FaceId,
    /// A random point of it, in metres.
    pub(crate) point_m: DVec3,
    /// Its area, in square metres.
    pub(crate) area_m2: f64,
    /// The number of its cell in the grid of the face.
    cell: u32,
}

/// The grid over a face.
#[derive(Clone, Copy, Debug)]
struct FaceGrid {
    /// Where its first cell begins, in metres.
    corner: Vec3,
    /// Unit vectors along its rows and columns.
    axes: [Vec3; 2],
    /// Cells a metre.
    per_m: [f32; 2],
    count: [u32; 2],
    /// Number of its first cell.
    first: u32,
}

/// The texels of all faces.
#[derive(Clone, Debug)]
pub(crate) struct TexelGrid {
    faces: Table<FaceId, FaceGrid>,
    /// The texel of each cell.
    cells: Vec<u32>,
    texels: Vec<Texel>,
    side_m: f64,
}

/// A face in the frame of its grid.
struct Layout {
    corner_m: DVec3,
    axes: [DVec3; 2],
    outline_m: Vec<DVec2>,
    size_m: DVec2,
}

impl Layout {
    fn new(prepared: &Prepared, face: FaceId) -> Self {
        let corners = prepared.polygon_m(face);
        let sides = (0..corners.len()).map(|i| corners[(i + 1) % corners.len()] - corners[i]);
        let longest = sides.max_by(|p, q| p.length_squared().total_cmp(&q.length_squared())).unwrap_or_default();
        let along = longest.normalize_or_zero();
        let axes = [along, prepared.normal(face).cross(along)];
        let flat = |p: &DVec3| DVec2::new(axes[0].dot(*p), axes[1].dot(*p));
        let low = corners.iter().map(flat).fold(DVec2::INFINITY, DVec2::min);
        let high = corners.iter().map(flat).fold(DVec2::NEG_INFINITY, DVec2::max);
        let outline_m: Vec<DVec2> = corners.iter().map(|p| flat(p) - low).collect();
        let normal = prepared.normal(face);
        let corner_m = low.x * axes[0] + low.y * axes[1] + normal.dot(corners[0]) * normal;
        Self { corner_m, axes, outline_m, size_m: high - low }
    }

    fn counts(&self, side_m: f64) -> [u32; 2] {
        (self.size_m / side_m).ceil().max(DVec2::ONE).to_array().map(|count| count as u32)
    }

    /// A point of the frame in space, in metres.
    fn to_3d(&self, at: DVec2) -> DVec3 {
        self.corner_m + at.x * self.axes[0] + at.y * self.axes[1]
    }

    /// The size of a cell, in metres.
    fn cell_m(&self, count: [u32; 2]) -> DVec2 {
        self.size_m / DVec2::new(f64::from(count[0]), f64::from(count[1]))
    }

    /// The part of a cell that lies in the face.
    fn part_of_cell(&self, number: u32, count: [u32; 2]) -> Convex {
        let cell_m = self.cell_m(count);
        let low = DVec2::new((number % count[0]).into(), (number / count[0]).into()) * cell_m;
        let corners = [low, low + cell_m.with_y(0.0), low + cell_m, low + cell_m.with_x(0.0)];
        clip::intersection(&corners, &self.outline_m).into()
    }

    /// The points and areas of the texels, and the number of each cell's texel among them.
    fn texels(&self, face: FaceId, count: [u32; 2]) -> (Vec<Texel>, Vec<u32>) {
        let cell_m = self.cell_m(count);
        let sequence = Sequence::new(key_of(face.index(), Self::POINTS));
        let (mut texels, mut cells) = (Vec::new(), vec![u32::MAX; (count[0] * count[1]) as usize]);
        for (number, cell) in cells.iter_mut().enumerate() {
            let part = self.part_of_cell(number as u32, count);
            let area_m2 = if part.len() < 3 { 0.0 } else { polygon::signed_area_2d_m2(&part) };
            if area_m2 <= MIN_SHARE_OF_CELL * cell_m.element_product() {
                continue;
            }
            let [s, t, ..] = sequence.at(number).map(f64::from);
            let middle = part.iter().sum::<DVec2>() / part.len() as f64;
            let point_m = self.to_3d(polygon::point_of_2d(&part, s, t).lerp(middle, INSIDE));
            *cell = texels.len() as u32;
            texels.push(Texel { face, point_m, area_m2, cell: number as u32 });
        }
        if texels.is_empty() {
            let middle = self.outline_m.iter().sum::<DVec2>() / self.outline_m.len() as f64;
            let area_m2 = polygon::signed_area_2d_m2(&self.outline_m).max(0.0);
            texels.push(Texel { face, point_m: self.to_3d(middle), area_m2, cell: 0 });
        }
        let known = cells.clone();
        for (number, cell) in cells.iter_mut().enumerate().filter(|(_, cell)| **cell == u32::MAX) {
            *cell = beside(&known, count, number as u32).unwrap_or(0);
        }
        (texels, cells)
    }

    /// The dimension of random numbers that places points.
    const POINTS: u64 = 1;
}

/// The texel of a cell next to one that has none, those in its row and column first.
fn beside(cells: &[u32], [columns, rows]: [u32; 2], number: u32) -> Option<u32> {
    let (x, y) = (i64::from(number % columns), i64::from(number / columns));
    let at = |dx: i64, dy: i64| {
        let (x, y) = (x + dx, y + dy);
        let inside = (0..i64::from(columns)).contains(&x) && (0..i64::from(rows)).contains(&y);
        inside.then(|| cells[(y * i64::from(columns) + x) as usize]).filter(|&texel| texel != u32::MAX)
    };
    const AROUND: [(i64, i64); 8] = [(-1, 0), (1, 0), (0, -1), (0, 1), (-1, -1), (1, -1), (-1, 1), (1, 1)];
    AROUND.iter().find_map(|&(dx, dy)| at(dx, dy))
}

impl TexelGrid {
    /// Lays the grids.
    pub(crate) fn new(prepared: &Prepared) -> Self {
        let layouts: Vec<Layout> =
            (0..prepared.faces.len()).into_par_iter().map(|face| Layout::new(prepared, face.into())).collect();
        let area_m2: f64 = layouts.iter().map(|layout| polygon::signed_area_2d_m2(&layout.outline_m).max(0.0)).sum();
        let most = MAX_CELLS_OF_TEXELS * TEXELS + MAX_CELLS_A_FACE * layouts.len() as f64;
        let cells = |side_m: f64| -> f64 {
            layouts.iter().map(|layout| layout.counts(side_m).map(f64::from).iter().product::<f64>()).sum()
        };
        let mut side_m = (area_m2 / TEXELS).sqrt().max(f64::MIN_POSITIVE);
        while cells(side_m) > most {
            side_m *= GROWTH;
        }
        let of_faces: Vec<([u32; 2], Vec<Texel>, Vec<u32>)> = layouts
            .par_iter()
            .enumerate()
            .map(|(face, layout)| {
                let count = layout.counts(side_m);
                let (texels, cells) = layout.texels(face.into(), count);
                (count, texels, cells)
            })
            .collect();
        let mut grid = Self { faces: Table::new(), cells: Vec::new(), texels: Vec::new(), side_m };
        for (layout, (count, texels, cells)) in layouts.iter().zip(of_faces) {
            let per_m =
                DVec2::new(count[0].into(), count[1].into()) / layout.size_m.max(DVec2::splat(f64::MIN_POSITIVE));
            grid.faces.push(FaceGrid {
                corner: layout.corner_m.as_vec3(),
                axes: layout.axes.map(|axis| axis.as_vec3()),
                per_m: per_m.as_vec2().to_array(),
                count,
                first: grid.cells.len() as u32,
            });
            let first = grid.texels.len() as u32;
            grid.cells.extend(cells.iter().map(|texel| first + texel));
            grid.texels.extend(texels);
        }
        grid
    }

    /// All texels, those of one face in a row.
    pub(crate) fn texels(&self) -> &[Texel] {
        &self.texels
    }

    /// The corners of the part of its cell that is a texel, in metres.
    pub(crate) fn outline_m(&self, prepared: &Prepared, texel: &Texel) -> Vec<DVec3> {
        let layout = Layout::new(prepared, texel.face);
        let part = layout.part_of_cell(texel.cell, self.faces[texel.face].count);
        part.into_iter().map(|at| layout.to_3d(at)).collect()
    }

    /// About how wide texels of large faces are, in metres.
    pub(crate) fn side_m(&self) -> f64 {
        self.side_m
    }

    /// The texel at a point of a face.
    pub(crate) fn texel_at(&self, face: FaceId, point: Vec3) -> usize {
        let grid = &self.faces[face];
        let offset = point - grid.corner;
        let place = |k: usize| ((offset.dot(grid.axes[k]) * grid.per_m[k]).max(0.0) as u32).min(grid.count[k] - 1);
        self.cells[(grid.first + place(1) * grid.count[0] + place(0)) as usize] as usize
    }

    /// Columns and rows of cells over a face.
    pub(crate) fn count(&self, face: FaceId) -> [u32; 2] {
        self.faces[face].count
    }

    /// The texels of the cells around each cell of a face, itself among them, for each cell that has a texel of its own.
    pub(crate) fn neighbourhoods(&self, face: FaceId) -> impl Iterator<Item = (usize, [usize; 9])> + '_ {
        let FaceGrid { count: [columns, rows], first, .. } = self.faces[face];
        let at = move |x: u32, y: u32| self.cells[(first + y * columns + x) as usize] as usize;
        (0..columns * rows).map(move |number| {
            let (x, y) = (number % columns, number / columns);
            let around = |k: usize| {
                let (dx, dy) = (k as u32 % 3, k as u32 / 3);
                at((x + dx).saturating_sub(1).min(columns - 1), (y + dy).saturating_sub(1).min(rows - 1))
            };
            (at(x, y), std::array::from_fn(around))
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::visibility::fixture;
    use proptest::prelude::*;

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(16))]
        #[test]
        fn texels_of_a_face_are_all_of_it(corners in prop::collection::vec((-2.0..2.0, -2.0..2.0, -2.0..2.0), 3..4), thin in 1e-4..1.0) {
            let corners: Vec<DVec3> = corners.into_iter().map(|p| DVec3::from(p) * DVec3::new(1.0, 1.0, thin)).map(fixture::f32_point).collect();
            prop_assume!(polygon::area_m2(&corners) > 1e-2);
            let prepared = fixture::prepared(&[corners, fixture::square(DVec3::new(0.0, 0.0, 9.0), 1.0, true)]);
            let grid = TexelGrid::new(&prepared);
            for face in prepared.faces.keys() {
                let whole = polygon::area_m2(&prepared.polygon_m(face));
                let texels = grid.texels().iter().enumerate().filter(|(_, texel)| texel.face == face);
                let mut sum = 0.0;
                for (number, texel) in texels {
                    sum += texel.area_m2;
                    prop_assert!(prepared.oriented_plane(face).signed_distance_m(texel.point_m).abs() < 1e-6);
                    // Its point leads back to it, but for rounding at its border.
                    let found = grid.texel_at(face, texel.point_m.as_vec3());
                    let beside = grid.texels()[found].point_m.distance(texel.point_m) < 3.0 * grid.side_m();
                    prop_assert!(found == number || beside, "{found} is not {number}");
                }
                prop_assert!((sum / whole - 1.0).abs() < 1e-3, "{sum} of {whole}");
            }
        }
    }

    #[test]
    fn needles_do_not_make_more_cells_than_there_may_be() {
        let needle = |i: u32| {
            let at = DVec3::new(0.0, 0.01 * f64::from(i), 0.0);
            [at, at + DVec3::new(10.0, 10.0, 0.0), at + DVec3::new(10.0, 10.001, 0.0)].map(fixture::f32_point).to_vec()
        };
        let prepared = fixture::prepared(&(0..500).map(needle).collect::<Vec<_>>());
        let grid = TexelGrid::new(&prepared);
        assert!((grid.cells.len() as f64) < MAX_CELLS_OF_TEXELS * TEXELS + MAX_CELLS_A_FACE * 500.0);
    }
}
