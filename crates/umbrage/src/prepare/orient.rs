//! Closed shells of which some polygons look out and others in: all are made to look one way.
//!
//! Programs that draw both sides of everything leave such shells behind: a cupboard whose door is black, a room of which one wall
//! takes no light. Of a shell that is closed, and whose polygons all meet side by side, one polygon tells which way every
//! other looks; which of the two ways is meant is a guess: that of most of the area. Shells whose polygons agree stay as they
//! are, rooms that look in as well as boxes that look out.
//!
//! Left as they are: shells with a gap, with a side at which more or fewer than two polygons meet, with a double-sided
//! polygon (its other side looks the other way anyway), and what has no two sides at all, as a Moebius strip has none.
//!
//! Holds after: the polygons of a closed, two-sided shell pass each of its sides once in either direction.

use smallvec::SmallVec;

use super::soup::{self, Polygon};
use super::weld::{Frame, Points};
use super::{PrepareError, PrepareReport};
use crate::id::VertexId;
use crate::scene::Scene;

/// Turns polygons of a scene over as `prepare` does, and tells how many: for those who look at the same scene with other means.
///
/// # Errors
/// [`PrepareError::Extent`] for scenes that cannot be held.
pub fn orient(scene: &mut Scene) -> Result<usize, PrepareError> {
    if scene.polygon_count() == 0 {
        return Ok(0);
    }
    let frame = Frame::of_scene(scene)?;
    let mut points = Points::new(frame.tolerance.weld_m());
    if frame.tolerance.extent_m <= 0.0 {
        return Ok(0);
    }
    let soup = soup::polygons(scene, &frame, &mut points, &mut PrepareReport::default());
    // The triangles of a polygon that is not plane are turned over together, as they hang together.
    let mut turned: Vec<_> =
        turned(&soup).into_iter().map(|number| (soup[number].surface, soup[number].number)).collect();
    turned.dedup();
    for &(surface, number) in &turned {
        scene.surfaces[surface].polygons[number].reverse();
    }
    Ok(turned.len())
}

/// Turns polygons over, and tells how many polygons of the input they are.
pub(super) fn turn(soup: &mut [Polygon]) -> usize {
    let mut polygons = Vec::new();
    for number in turned(soup) {
        let polygon = &mut soup[number];
        polygon.corners.reverse();
        polygon.sources.reverse();
        polygons.push((polygon.surface, polygon.number));
    }
    polygons.dedup();
    polygons.len()
}

/// A polygon beside a side, and whether it passes the side from its lower end to its higher one.
type Passage = ([VertexId; 2], usize, bool);

/// The polygons that look another way than most of their closed shells, ascending.
fn turned(soup: &[Polygon]) -> Vec<usize> {
    let mut passages: Vec<Passage> = Vec::new();
    for (number, polygon) in soup.iter().enumerate() {
        passages.extend(polygon.sides().map(|[a, b]| ([a.min(b), a.max(b)], number, a < b)));
    }
    passages.sort_unstable();
    // Beside each polygon: its neighbours, and whether they look the same way.
    let mut neighbours: Vec<SmallVec<[(usize, bool); 4]>> = vec![SmallVec::new(); soup.len()];
    let mut is_broken: Vec<bool> = soup.iter().map(|polygon| polygon.double_sided).collect();
    for side in passages.chunk_by(|a, b| a.0 == b.0) {
        match *side {
            // The bridge from a polygon's border to its hole is no side of the shell.
            [(_, one, along), (_, other, other_along)] if one == other && along != other_along => {}
            [(_, one, along), (_, other, other_along)] if one != other => {
                neighbours[one].push((other, along != other_along));
                neighbours[other].push((one, along != other_along));
            }
            _ => side.iter().for_each(|passage| is_broken[passage.1] = true),
        }
    }
    // `None`: not met yet.
    let mut is_other_way: Vec<Option<bool>> = vec![None; soup.len()];
    let mut turned = Vec::new();
    for seed in 0..soup.len() {
        if is_other_way[seed].is_some() {
            continue;
        }
        is_other_way[seed] = Some(false);
        let (mut shell, mut next, mut is_whole) = (vec![seed], 0, true);
        while let Some(&number) = shell.get(next) {
            next += 1;
            is_whole &= !is_broken[number];
            let other_way = is_other_way[number] == Some(true);
            for &(neighbour, same_way) in &neighbours[number] {
                let expected = other_way == same_way;
                match is_other_way[neighbour] {
                    None => {
                        is_other_way[neighbour] = Some(expected);
                        shell.push(neighbour);
                    }
                    Some(found) => is_whole &= found == expected,
                }
            }
        }
        if is_whole {
            let area_m2 = |other_way: bool| -> f64 {
                let of_way = shell.iter().filter(|&&number| is_other_way[number] == Some(other_way));
                of_way.map(|&number| soup[number].area_m2).sum()
            };
            let fewer = area_m2(true) <= area_m2(false);
            turned.extend(shell.into_iter().filter(|&number| is_other_way[number] == Some(fewer)));
        }
    }
    turned.sort_unstable();
    turned
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::*;
    use crate::id::{MaterialId, SurfaceId};
    use crate::scene::Surface;
    use crate::scene::cornell::cornell_box;

    /// A box of 1 x 1 x 2 m that looks out, each side a polygon: the small ones are the first two.
    fn block() -> Scene {
        let mut scene = cornell_box();
        scene.surfaces.truncate(1);
        let (node, material) = (scene.surfaces.raw[0].node, MaterialId::from(0));
        scene.surfaces.raw[0] = Surface::new(node, material);
        let sides = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
        let corner = |i: usize| DVec3::new((i & 1) as f64, (i >> 1 & 1) as f64, 2.0 * (i >> 2) as f64);
        for side in sides {
            scene.surfaces.raw[0].push_polygon(side.map(corner));
        }
        scene
    }

    fn turn_over(scene: &mut Scene, polygon: usize) {
        scene.surfaces[SurfaceId::from(0)].polygons[polygon].reverse();
    }

    #[test]
    fn the_polygons_of_a_closed_shell_come_to_look_where_most_of_it_looks() {
        for over in [vec![0], vec![3], vec![0, 1], vec![0, 4]] {
            let sound = block();
            let mut scene = block();
            over.iter().for_each(|&polygon| turn_over(&mut scene, polygon));
            assert_eq!(orient(&mut scene), Ok(over.len()));
            assert_eq!(scene, sound);
            assert_eq!(orient(&mut scene), Ok(0));
        }
    }

    #[test]
    fn a_shell_that_agrees_stays_whichever_way_it_looks() {
        let mut room = block();
        (0..6).for_each(|polygon| turn_over(&mut room, polygon));
        let before = room.clone();
        assert_eq!(orient(&mut room), Ok(0));
        assert_eq!(room, before);
    }

    #[test]
    fn what_is_open_or_shared_or_double_sided_is_left() {
        let spoilt: [fn(&mut Scene); 3] = [
            |scene| scene.surfaces.raw[0].polygons.truncate(5),
            // A partition: three polygons meet at its sides.
            |scene| scene.surfaces.raw[0].push_polygon([[0, 0, 0], [1, 1, 0], [1, 1, 2], [0, 0, 2]].map(point)),
            |scene| scene.materials.raw[0].double_sided = true,
        ];
        for spoil in spoilt {
            let mut scene = block();
            turn_over(&mut scene, 2);
            spoil(&mut scene);
            let before = scene.clone();
            assert_eq!(orient(&mut scene), Ok(0));
            assert_eq!(scene, before);
        }
    }

    fn point(xyz: [i32; 3]) -> DVec3 {
        DVec3::from(xyz.map(f64::from))
    }

    #[test]
    fn a_shell_of_triangles_with_a_bent_polygon_is_turned_as_a_whole() {
        // The top is not plane, and becomes two triangles.
        let mut scene = block();
        let raised = DVec3::new(1.0, 1.0, 2.0);
        scene.surfaces.raw[0].positions_m.iter_mut().filter(|p| **p == raised).for_each(|p| p.z += 0.3);
        let sound = scene.clone();
        turn_over(&mut scene, 1);
        assert_eq!(orient(&mut scene), Ok(1));
        assert_eq!(scene, sound);
    }
}
