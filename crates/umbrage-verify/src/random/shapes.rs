//! Things of a few polygons: boxes, sheets, discs, needles, and round bodies with smooth normals.

use std::f64::consts::{PI, TAU};

use glam::{BVec3, DQuat, DVec3};
use umbrage::scene::{Material, Rgb};

/// Polygons of one material that move together.
#[derive(Clone, Debug)]
pub(super) struct Thing {
    pub(super) name: &'static str,
    pub(super) material: Material,
    pub(super) positions_m: Vec<DVec3>,
    /// Of each corner, or none.
    pub(super) normals: Vec<DVec3>,
    /// Indices of corners.
    pub(super) polygons: Vec<Vec<u32>>,
}

impl Thing {
    fn new(name: &'static str, positions_m: Vec<DVec3>, polygons: Vec<Vec<u32>>) -> Self {
        Self { name, material: Material::diffuse(name, Rgb::splat(0.5)), positions_m, normals: Vec::new(), polygons }
    }

    pub(super) fn of(self, material: Material) -> Self {
        Self { material, ..self }
    }

    pub(super) fn named(self, name: &'static str) -> Self {
        Self { name, ..self }
    }

    pub(super) fn moved(mut self, turn: DQuat, to: DVec3) -> Self {
        self.positions_m.iter_mut().for_each(|p| *p = turn * *p + to);
        self.normals.iter_mut().for_each(|n| *n = turn * *n);
        self
    }

    /// The same polygons from their other side.
    pub(super) fn turned_inside_out(mut self) -> Self {
        self.polygons.iter_mut().for_each(|polygon| polygon.reverse());
        self.normals.iter_mut().for_each(|n| *n = -*n);
        self
    }

    pub(super) fn corners_m(&self, polygon: usize) -> Vec<DVec3> {
        self.polygons[polygon].iter().map(|&i| self.positions_m[i as usize]).collect()
    }

    /// The lowest corner, in metres.
    pub(super) fn low_m(&self) -> f64 {
        self.positions_m.iter().map(|p| p.y).fold(f64::INFINITY, f64::min)
    }

    pub(super) fn middle_m(&self) -> DVec3 {
        self.positions_m.iter().sum::<DVec3>() / self.positions_m.len() as f64
    }
}

/// A rectangle in the plane y = 0, looking up.
pub(super) fn rectangle(half_x: f64, half_z: f64) -> Thing {
    let corners = [(-1.0, 1.0), (1.0, 1.0), (1.0, -1.0), (-1.0, -1.0)];
    let positions = corners.map(|(x, z)| DVec3::new(half_x * x, 0.0, half_z * z)).to_vec();
    Thing::new("sheet", positions, vec![vec![0, 1, 2, 3]])
}

/// A box around the origin, looking outward.
pub(super) fn block(half: DVec3) -> Thing {
    let at = |i: u32| DVec3::select(BVec3::new(i & 1 > 0, i & 2 > 0, i & 4 > 0), half, -half);
    let faces = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    Thing::new("box", (0..8).map(at).collect(), faces.map(|face| face.to_vec()).to_vec())
}

/// A disc in the plane y = 0 looking up, whose corners are `radii` away by turns.
pub(super) fn disc(corners: usize, radii: [f64; 2]) -> Thing {
    let at = |i: usize| {
        let angle = TAU * i as f64 / corners as f64;
        radii[i % 2] * DVec3::new(angle.cos(), 0.0, -angle.sin())
    };
    Thing::new("disc", (0..corners).map(at).collect(), vec![(0..corners as u32).collect()])
}

/// A triangle in the plane y = 0, as long and wide as said.
pub(super) fn needle(length: f64, width: f64) -> Thing {
    let positions = vec![DVec3::ZERO, DVec3::new(length, 0.0, 0.5 * width), DVec3::new(length, 0.0, -0.5 * width)];
    Thing::new("needle", positions, vec![vec![0, 1, 2]])
}

/// A sphere around the origin of so many sides around and from pole to pole, with smooth normals.
pub(super) fn sphere(radius: f64, around: usize, rings: usize) -> Thing {
    let at = |ring: usize, i: usize| {
        let (polar, angle) = (PI * ring as f64 / rings as f64, TAU * i as f64 / around as f64);
        DVec3::new(polar.sin() * angle.cos(), polar.cos(), -polar.sin() * angle.sin())
    };
    let mut normals = vec![DVec3::Y, -DVec3::Y];
    normals.extend((1..rings).flat_map(|ring| (0..around).map(move |i| at(ring, i))));
    let index = |ring: usize, i: usize| match ring {
        0 => 0,
        ring if ring == rings => 1,
        ring => 2 + ((ring - 1) * around + i % around) as u32,
    };
    let mut polygons = Vec::new();
    for (ring, i) in (0..rings).flat_map(|ring| (0..around).map(move |i| (ring, i))) {
        let [a, b, c, d] = [(ring, i), (ring + 1, i), (ring + 1, i + 1), (ring, i + 1)].map(|(r, i)| index(r, i));
        match () {
            () if ring == 0 => polygons.push(vec![a, b, c]),
            () if ring + 1 == rings => polygons.push(vec![a, b, d]),
            () => polygons.push(vec![a, b, c, d]),
        }
    }
    let positions_m = normals.iter().map(|n| radius * *n).collect();
    Thing { normals, ..Thing::new("sphere", positions_m, polygons) }
}

/// The side of an upright cylinder around the origin, with smooth normals.
pub(super) fn cylinder(radius: f64, half_height: f64, around: usize) -> Thing {
    let out = |i: usize| {
        let angle = TAU * (i / 2) as f64 / around as f64;
        DVec3::new(angle.cos(), 0.0, -angle.sin())
    };
    let height = |i: usize| half_height * if i.is_multiple_of(2) { -1.0 } else { 1.0 };
    let positions = (0..2 * around).map(|i| radius * out(i) + height(i) * DVec3::Y).collect();
    let side = |i: usize| [2 * i, 2 * i + 2, 2 * i + 3, 2 * i + 1].map(|k| (k % (2 * around)) as u32).to_vec();
    let thing = Thing::new("cylinder", positions, (0..around).map(side).collect());
    Thing { normals: (0..2 * around).map(out).collect(), ..thing }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bodies_are_closed_or_look_outward() {
        let outward = |thing: &Thing| {
            (0..thing.polygons.len()).all(|polygon| {
                let corners = thing.corners_m(polygon);
                let across = (corners[1] - corners[0]).cross(corners[2] - corners[0]);
                across.dot(corners.iter().sum::<DVec3>()) > 0.0
            })
        };
        for thing in [block(DVec3::new(1.0, 2.0, 3.0)), sphere(2.0, 7, 5), cylinder(1.0, 2.0, 9)] {
            assert!(outward(&thing), "{}", thing.name);
            assert!(!outward(&thing.turned_inside_out()));
        }
        let up = |thing: Thing| {
            let corners = thing.corners_m(0);
            corners.windows(2).map(|p| p[0].cross(p[1])).sum::<DVec3>().y > 0.0
        };
        assert!(up(rectangle(1.0, 2.0)) && up(disc(9, [1.0, 1.0])) && up(disc(10, [1.0, 0.3])) && up(needle(1.0, 0.1)));
    }

    #[test]
    fn polygons_are_plane() {
        for thing in [sphere(2.0, 7, 5), cylinder(1.0, 2.0, 9), disc(200, [1.0, 0.4])] {
            for polygon in 0..thing.polygons.len() {
                let corners = thing.corners_m(polygon);
                let normal = (corners[1] - corners[0]).cross(corners[2] - corners[0]).normalize();
                assert!(corners.iter().all(|p| (p - corners[0]).dot(normal).abs() < 1e-12), "{}", thing.name);
            }
        }
    }
}
