//! The cells that all edges of a plane divide it into, and the surface and skin that each cell shows on each of its two
//! sides.
//!
//! Which polygons cover a cell follows from winding numbers, carried from the outside inwards across one edge after the
//! other: that is exact whatever rounding did to the edges, as long as they do not cross. Where several polygons cover
//! a cell and look the same way, the one whose patch has the least area wins: a picture over the wall that it hangs on.
//! A polygon's patch is what it forms together with neighbours of its surface that share edges with it, so that it does
//! not matter how finely the wall was divided.

use std::collections::BTreeMap;

use glam::DVec2;
use smallvec::SmallVec;

use super::Facing;
use super::soup::Polygon;
use super::triangulation::Triangulation;
use crate::geometry::DisjointSets;
use crate::id::{SkinId, SurfaceId, VertexId};

/// What is seen of a cell from one side: polygons of one surface with one skin are one.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct Shown {
    /// The surface.
    pub(super) surface: SurfaceId,
    /// What is laid over it.
    pub(super) skin: Option<SkinId>,
}

/// What a cell shows along the plane's normal and against it.
pub(super) type Label = [Option<Shown>; 2];

/// The place of a facing in a [`Label`].
pub(super) fn side_of(facing: Facing) -> usize {
    match facing {
        Facing::Along => 0,
        Facing::Against => 1,
    }
}

/// An edge of a plane, not cut by any other.
#[derive(Clone, Debug)]
pub(super) struct PlaneEdge {
    /// Its ends, ascending.
    pub(super) ends: [VertexId; 2],
    /// The polygons whose boundary passes along it, and how: 1 from the first end to the second, -1 back.
    pub(super) passes: SmallVec<[(u32, i32); 2]>,
}

/// What lies beside the edges of one plane.
#[derive(Debug)]
pub(super) struct Arrangement {
    /// What each edge has to its left and to its right, looking from its first end to its second in the plane's frame.
    pub(super) beside: Vec<[Label; 2]>,
    /// Cells where polygons that look the same way overlapped.
    pub(super) overlaps: usize,
    /// Edges that could not be drawn.
    pub(super) missing_edges: usize,
}

/// Polygons that cover a cell, and how often.
type Cover = SmallVec<[(u32, i32); 2]>;

impl Arrangement {
    /// Divides a plane by its edges; `facing` says how each polygon looks in this plane.
    pub(super) fn new(
        edges: &[PlaneEdge],
        soup: &[Polygon],
        skins: &[Option<SkinId>],
        facing: impl Fn(u32) -> Facing,
        position: impl Fn(VertexId) -> DVec2,
    ) -> Self {
        let (vertices, numbered) = number(edges.iter().map(|e| e.ends));
        let flat: Vec<DVec2> = vertices.iter().map(|&v| position(v)).collect();
        let triangulation = Triangulation::new(&flat, &numbered);
        let patch_area_m2 = patch_areas(edges, soup);
        let covers = covers(&triangulation, edges);
        let mut overlaps = 0;
        let labels: Vec<Label> = covers
            .cells
            .iter()
            .map(|cover| {
                let mut overlapped = false;
                let label = [Facing::Along, Facing::Against].map(|way| {
                    let shown = cover.iter().map(|&(p, _)| p);
                    let shown = shown.filter(|&p| soup[p as usize].double_sided || facing(p) == way);
                    overlapped |= shown.clone().count() > 1;
                    let order = |p: u32| (patch_area_m2[&p], soup[p as usize].area_m2, !soup[p as usize].emits, p);
                    let least = |p: &u32, q: &u32| {
                        let (p, q) = (order(*p), order(*q));
                        p.0.total_cmp(&q.0).then(p.1.total_cmp(&q.1)).then((p.2, p.3).cmp(&(q.2, q.3)))
                    };
                    let shows = |p: u32| Shown { surface: soup[p as usize].surface, skin: skins[p as usize] };
                    shown.min_by(least).map(shows)
                });
                overlaps += usize::from(overlapped);
                label
            })
            .collect();
        let mut beside = vec![[[None; 2]; 2]; edges.len()];
        for (t, triangle) in triangulation.triangles.iter().enumerate() {
            for i in 0..3 {
                if let Some(edge) = triangle.edges[i] {
                    let [from, to] = triangle.side(i);
                    beside[edge as usize][usize::from(from > to)] = labels[covers.cell_of[t] as usize];
                }
            }
        }
        Self { beside, overlaps, missing_edges: triangulation.missing_edges }
    }
}

/// The vertices of edges, ascending, and the edges by the numbers of their ends among these.
pub(super) fn number(edges: impl Iterator<Item = [VertexId; 2]> + Clone) -> (Vec<VertexId>, Vec<[u32; 2]>) {
    let mut vertices: Vec<VertexId> = edges.clone().flatten().collect();
    vertices.sort_unstable();
    vertices.dedup();
    let place = |v: VertexId| vertices.partition_point(|&other| other < v) as u32;
    let numbered = edges.map(|ends| ends.map(place)).collect();
    (vertices, numbered)
}

struct Covers {
    cell_of: Vec<u32>,
    cells: Vec<Cover>,
}

/// The polygons that cover each cell, from the outside inwards.
fn covers(triangulation: &Triangulation, edges: &[PlaneEdge]) -> Covers {
    let cells = triangulation.cells();
    let mut members: Vec<Vec<u32>> = vec![Vec::new(); cells.count];
    for (t, &cell) in cells.cell_of.iter().enumerate() {
        members[cell as usize].push(t as u32);
    }
    let mut cover_of: Vec<Option<Cover>> = vec![None; cells.count];
    let mut open: Vec<(u32, Cover)> = Vec::new();
    for (triangle, t) in triangulation.triangles.iter().zip(0..) {
        for i in (0..3).filter(|&i| triangle.neighbours[i].is_none()) {
            let [to, from] = triangle.side(i);
            open.push((t, crossed(&Cover::new(), triangle.edges[i].map(|e| &edges[e as usize]), from < to)));
        }
    }
    open.reverse();
    while let Some((t, cover)) = open.pop() {
        let cell = cells.cell_of[t as usize] as usize;
        if cover_of[cell].is_some() {
            continue;
        }
        for &member in &members[cell] {
            let triangle = &triangulation.triangles[member as usize];
            for i in 0..3 {
                if let (Some(next), Some(edge)) = (triangle.neighbours[i], triangle.edges[i])
                    && cover_of[cells.cell_of[next as usize] as usize].is_none()
                {
                    let [from, to] = triangle.side(i);
                    open.push((next, crossed(&cover, Some(&edges[edge as usize]), from < to)));
                }
            }
        }
        cover_of[cell] = Some(cover);
    }
    Covers { cell_of: cells.cell_of, cells: cover_of.into_iter().map(Option::unwrap_or_default).collect() }
}

/// The cover beyond an edge; `rightwards` where the edge, as its ends ascend, is crossed from its left to its right.
fn crossed(cover: &Cover, edge: Option<&PlaneEdge>, rightwards: bool) -> Cover {
    let mut beyond = cover.clone();
    for &(polygon, pass) in edge.into_iter().flat_map(|e| &e.passes) {
        // A boundary has its winding number one higher on its left.
        let change = if rightwards { -pass } else { pass };
        match beyond.iter_mut().find(|(p, _)| *p == polygon) {
            Some((_, winding)) => *winding += change,
            None => beyond.push((polygon, change)),
        }
    }
    beyond.retain(|(_, winding)| *winding != 0);
    beyond
}

/// The area of each polygon together with those of its surface that share edges with it, directly or by others.
fn patch_areas(edges: &[PlaneEdge], soup: &[Polygon]) -> BTreeMap<u32, f64> {
    let mut polygons: Vec<u32> = edges.iter().flat_map(|e| e.passes.iter().map(|p| p.0)).collect();
    polygons.sort_unstable();
    polygons.dedup();
    let place = |p: u32| polygons.partition_point(|&other| other < p);
    let mut sets = DisjointSets::new(polygons.len());
    for edge in edges {
        for (i, &(p, p_pass)) in edge.passes.iter().enumerate() {
            for &(q, q_pass) in &edge.passes[i + 1..] {
                // Neighbours pass their common edge in opposite directions; polygons on top of each other do not.
                if p_pass == -q_pass && soup[p as usize].surface == soup[q as usize].surface {
                    sets.join(place(p), place(q));
                }
            }
        }
    }
    let mut area_m2 = vec![0.0; polygons.len()];
    for i in 0..polygons.len() {
        area_m2[sets.first_of(i)] += soup[polygons[i] as usize].area_m2;
    }
    polygons.iter().enumerate().map(|(i, &p)| (p, area_m2[sets.first_of(i)])).collect()
}

#[cfg(test)]
mod tests {
    use super::super::testing::Small;
    use super::*;

    /// The arrangement of polygons in one plane whose sides meet in corners only, and its edges.
    fn arranged(small: &Small) -> (Vec<PlaneEdge>, Arrangement) {
        let mut edges: Vec<PlaneEdge> = Vec::new();
        for (polygon, number) in small.soup.iter().zip(0..) {
            for [a, b] in polygon.sides() {
                let (ends, pass) = ([a.min(b), a.max(b)], if a < b { 1 } else { -1 });
                match edges.iter_mut().find(|e| e.ends == ends) {
                    Some(edge) => edge.passes.push((number, pass)),
                    None => edges.push(PlaneEdge { ends, passes: [(number, pass)].into_iter().collect() }),
                }
            }
        }
        let facing = |p: u32| small.planes.of_polygon[p as usize].1;
        let frame = small.planes.frames[small.planes.of_polygon[0].0];
        let skins = vec![None; small.soup.len()];
        let arrangement = Arrangement::new(&edges, &small.soup, &skins, facing, |v| frame.to_2d(small.points[v]));
        (edges, arrangement)
    }

    const WALL: &[[f64; 3]] = &[[0.0, 0.0, 0.0], [4.0, 0.0, 0.0], [4.0, 4.0, 0.0], [0.0, 4.0, 0.0]];
    const PICTURE: &[[f64; 3]] = &[[1.0, 1.0, 0.0], [2.0, 1.0, 0.0], [2.0, 2.0, 0.0], [1.0, 2.0, 0.0]];

    #[test]
    fn the_smaller_of_two_polygons_wins() {
        let (edges, arrangement) = arranged(&Small::new(&[PICTURE, WALL]));
        assert_eq!((arrangement.overlaps, arrangement.missing_edges), (1, 0));
        for (edge, beside) in edges.iter().zip(&arrangement.beside) {
            let mut shown: Vec<_> = beside.iter().flatten().flatten().map(|s| s.surface.index()).collect();
            shown.sort_unstable();
            assert_eq!(shown, if edge.passes[0].0 == 0 { vec![0, 1] } else { vec![1] });
        }
    }

    #[test]
    fn polygons_back_to_back_show_each_on_its_side() {
        let back: Vec<[f64; 3]> = PICTURE.iter().rev().copied().collect();
        let (edges, arrangement) = arranged(&Small::new(&[&back, WALL]));
        assert_eq!(arrangement.overlaps, 0);
        for (edge, beside) in edges.iter().zip(&arrangement.beside) {
            let inner = edge.passes[0].0 == 0;
            assert_eq!(beside.iter().flatten().flatten().count(), if inner { 3 } else { 1 });
        }
    }

    #[test]
    fn a_hole_shows_nothing() {
        let ring = [WALL, &[WALL[0]], &[PICTURE[0], PICTURE[3], PICTURE[2], PICTURE[1], PICTURE[0]]].concat();
        let (_, arrangement) = arranged(&Small::new(&[&ring]));
        let nothing = arrangement.beside.iter().flatten().filter(|label| **label == [None; 2]).count();
        // The four sides of the wall and of the hole each have it on one side; the bridge has it on none.
        assert_eq!(nothing, 8);
    }
}
