//! Scenes for both routes: polygons for the library, the same in convex pieces for the light of the tests.

use std::f64::consts::TAU;

use glam::{DQuat, DVec3};
use umbrage::id::{MaterialId, NodeId};
use umbrage::scene::{Material, Node, Rgb, Scene, Surface};

use super::light::{Convex, World};

/// Coordinates are multiples of this, in metres: they stay what they are when the library makes `f32` of them.
const STEP_M: f64 = 1.0 / 524_288.0;

/// A scene twice: for the library, and for the light of the tests.
#[derive(Debug, Default)]
pub struct Stage {
    pub scene: Scene,
    pub world: World,
    /// Whether what is added shows both of its sides, and gives light from both.
    pub double_sided: bool,
    /// Where the middle of the floor is.
    pub origin: DVec3,
}

impl Stage {
    /// Adds a polygon that gives off `radiance`, in W/(m2 sr); one that is not convex as pieces, too.
    pub fn add_in_pieces(&mut self, polygon: &[DVec3], pieces: &[Vec<DVec3>], radiance: f64) {
        if self.scene.nodes.is_empty() {
            self.scene.nodes.push(Node::default());
        }
        let of_one_side = if radiance > 0.0 {
            Material::emitting(format!("light of {radiance}"), Rgb::splat(radiance))
        } else {
            Material::diffuse("grey", Rgb::splat(0.5))
        };
        let material = Material { double_sided: self.double_sided, ..of_one_side };
        let known = self.scene.materials.iter().position(|known| *known == material).map(MaterialId::from);
        let material = known.unwrap_or_else(|| self.scene.materials.push_and_get_key(material));
        let round = |p: &DVec3| (*p / STEP_M).round() * STEP_M;
        self.scene.surfaces.push(Surface {
            positions_m: polygon.iter().map(round).collect(),
            polygons: vec![(0..polygon.len() as u32).collect()],
            ..Surface::new(NodeId::from(0), material)
        });
        let piece = |piece: &Vec<DVec3>| Convex { corners: piece.iter().map(round).collect(), radiance };
        self.world.pieces.extend(pieces.iter().map(piece));
        if self.double_sided && radiance > 0.0 {
            let turned = |corners: &Vec<DVec3>| piece(&corners.iter().rev().copied().collect());
            self.world.pieces.extend(pieces.iter().map(turned));
        }
    }

    /// Adds a convex polygon.
    pub fn add(&mut self, polygon: &[DVec3], radiance: f64) {
        self.add_in_pieces(polygon, &[polygon.to_vec()], radiance);
    }

    /// Moves all that was added by a multiple of the step that coordinates are rounded to.
    pub fn move_to(&mut self, origin: DVec3) {
        let origin = (origin / STEP_M).round() * STEP_M;
        let surfaces = self.scene.surfaces.iter_mut().flat_map(|surface| &mut surface.positions_m);
        let pieces = self.world.pieces.iter_mut().flat_map(|piece| &mut piece.corners);
        surfaces.chain(pieces).for_each(|corner| *corner += origin);
        self.origin += origin;
    }

    pub fn add_all(&mut self, polygons: &[Vec<DVec3>], radiance: f64) {
        polygons.iter().for_each(|polygon| self.add(polygon, radiance));
    }
}

/// A rectangle in the plane z = 0 around the origin, looking up.
pub fn rectangle(x: f64, y: f64) -> Vec<DVec3> {
    [(-x, -y), (x, -y), (x, y), (-x, y)].map(|(x, y)| DVec3::new(x, y, 0.0)).to_vec()
}

/// The faces of a box around the origin, looking outward.
pub fn block(half: DVec3) -> Vec<Vec<DVec3>> {
    let corner = |i: usize| half * DVec3::new([-1.0, 1.0][i & 1], [-1.0, 1.0][i >> 1 & 1], [-1.0, 1.0][i >> 2 & 1]);
    [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]]
        .map(|face| face.map(corner).to_vec())
        .to_vec()
}

/// The faces of a pyramid with a square base on z = 0, looking outward, without the base.
pub fn pyramid(half: f64, height: f64) -> Vec<Vec<DVec3>> {
    let base = rectangle(half, half);
    (0..4).map(|i| vec![base[i], base[(i + 1) % 4], DVec3::Z * height]).collect()
}

/// An L of two squares' width in the plane z = 0, and its two convex pieces, which
/// have no vertices but its own: rounding would bend a side at another.
pub fn l_shape(size: f64) -> (Vec<DVec3>, [Vec<DVec3>; 2]) {
    let p = |x: f64, y: f64| DVec3::new(size * x, size * y, 0.0);
    let outline = vec![p(0.0, 0.0), p(2.0, 0.0), p(2.0, 1.0), p(1.0, 1.0), p(1.0, 2.0), p(0.0, 2.0)];
    let pieces = [
        vec![p(0.0, 0.0), p(2.0, 0.0), p(2.0, 1.0), p(1.0, 1.0)],
        vec![p(0.0, 0.0), p(1.0, 1.0), p(1.0, 2.0), p(0.0, 2.0)],
    ];
    (outline, pieces)
}

pub fn moved(polygon: &[DVec3], turn: DQuat, to: DVec3) -> Vec<DVec3> {
    polygon.iter().map(|&p| turn * p + to).collect()
}

pub fn all_moved(polygons: &[Vec<DVec3>], turn: DQuat, to: DVec3) -> Vec<Vec<DVec3>> {
    polygons.iter().map(|polygon| moved(polygon, turn, to)).collect()
}

/// Numbers that look random (Vigna's splitmix64).
pub struct Random(pub u64);

impl Random {
    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        z ^ (z >> 31)
    }

    pub fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * (self.next() >> 11) as f64 / (1u64 << 53) as f64
    }

    pub fn below(&mut self, count: usize) -> usize {
        (self.next() % count as u64) as usize
    }

    pub fn point(&mut self, low: DVec3, high: DVec3) -> DVec3 {
        DVec3::from([0, 1, 2].map(|i| self.between(low[i], high[i])))
    }

    /// Any rotation.
    pub fn turn(&mut self) -> DQuat {
        let axis = self.point(DVec3::NEG_ONE, DVec3::ONE).normalize_or(DVec3::X);
        DQuat::from_axis_angle(axis, self.between(0.0, TAU))
    }

    /// Upside down, and leaning by at most half a radian.
    pub fn downward(&mut self) -> DQuat {
        let lean = DQuat::from_rotation_x(self.between(-0.5, 0.5)) * DQuat::from_rotation_y(self.between(-0.5, 0.5));
        lean * DQuat::from_rotation_x(TAU / 2.0) * DQuat::from_rotation_z(self.between(0.0, TAU))
    }
}

/// A floor and a wall on it; one or two lights above; one to three occluders between, of which some stand on the floor,
/// some pierce it, some one another, some the planes of lights.
pub fn scene(random: &mut Random) -> Stage {
    scene_of(random, |_| false)
}

/// Such a scene, where it is asked of everything whether it is double-sided.
pub fn scene_of(random: &mut Random, mut double_sided: impl FnMut(&mut Random) -> bool) -> Stage {
    let mut stage = Stage { double_sided: double_sided(random), ..Stage::default() };
    stage.add(&rectangle(2.0, 2.0), 0.0);
    let wall = moved(&rectangle(2.0, 1.0), DQuat::from_rotation_x(TAU / 4.0), DVec3::new(0.0, 2.0, 1.0));
    stage.add(&wall, 0.0);
    for _ in 0..1 + random.below(2) {
        stage.double_sided = double_sided(random);
        let at = random.point(DVec3::new(-1.2, -1.5, 1.8), DVec3::new(1.2, 1.0, 2.8));
        let turn = random.downward();
        let radiance = random.between(1.0, 4.0);
        let (x, y) = (random.between(0.15, 0.5), random.between(0.15, 0.5));
        match random.below(5) {
            0 => stage.add(&moved(&rectangle(x, y)[..3], turn, at), radiance),
            1 => stage.add_all(&all_moved(&block(DVec3::new(x, y, 0.1)), turn, at), radiance),
            2 => {
                // Two lights of different radiance that share an edge.
                stage.add(&moved(&rectangle(x, y), turn, at), radiance);
                let beside = rectangle(x, y).iter().map(|&p| p + DVec3::X * (2.0 * x)).collect::<Vec<_>>();
                stage.add(&moved(&beside, turn, at), 0.4 * radiance);
            }
            _ => stage.add(&moved(&rectangle(x, y), turn, at), radiance),
        }
    }
    for _ in 0..1 + random.below(3) {
        stage.double_sided = double_sided(random);
        let at = random.point(DVec3::new(-1.2, -1.2, 0.3), DVec3::new(1.2, 1.5, 1.6));
        let turn = random.turn();
        let half = random.point(DVec3::splat(0.08), DVec3::splat(0.45));
        match random.below(7) {
            0 => stage.add(&moved(&rectangle(half.x, half.y), turn, at), 0.0),
            1 => stage.add(&moved(&rectangle(half.x, half.y)[..3], turn, at), 0.0),
            2 => {
                let (outline, pieces) = l_shape(half.x);
                let pieces = pieces.map(|piece| moved(&piece, turn, at));
                stage.add_in_pieces(&moved(&outline, turn, at), &pieces, 0.0);
            }
            3 => {
                // On the floor.
                let turn = DQuat::from_rotation_z(random.between(0.0, TAU));
                let standing = all_moved(&block(half), turn, DVec3::new(at.x, at.y, half.z));
                stage.add_all(&standing[1..], 0.0);
            }
            4 => stage.add_all(&all_moved(&block(half), turn, DVec3::new(at.x, at.y, 0.5 * half.z)), 0.0),
            5 => {
                let turn = DQuat::from_rotation_z(random.between(0.0, TAU));
                stage.add_all(&all_moved(&pyramid(half.x, 2.0 * half.z), turn, DVec3::new(at.x, at.y, 0.0)), 0.0);
            }
            _ => stage.add_all(&all_moved(&block(half), turn, at), 0.0),
        }
    }
    stage
}

/// A piece of a building: a floor and a wall, a lamp of which half the time the edges are parallel to theirs, a shelf
/// of boards, and a table. All edges of these are parallel to the axes.
pub fn building(random: &mut Random) -> Stage {
    let mut stage = Stage::default();
    stage.add(&rectangle(2.0, 2.0), 0.0);
    let wall = moved(&rectangle(2.0, 1.0), DQuat::from_rotation_x(TAU / 4.0), DVec3::new(0.0, 2.0, 1.0));
    stage.add(&wall, 0.0);
    let at = random.point(DVec3::new(-1.2, -1.5, 1.8), DVec3::new(1.2, 1.0, 2.8));
    let angle = if random.below(2) == 0 { 0.0 } else { random.between(0.0, TAU) };
    let turn = DQuat::from_rotation_x(TAU / 2.0) * DQuat::from_rotation_z(angle);
    let lamp = rectangle(random.between(0.15, 0.5), random.between(0.15, 0.5));
    stage.add(&moved(&lamp, turn, at), random.between(1.0, 4.0));
    let mut put = |half: DVec3, at: DVec3| stage.add_all(&all_moved(&block(half), DQuat::IDENTITY, at), 0.0);
    let shelf = random.point(DVec3::new(-1.2, 0.2, 0.2), DVec3::new(-0.2, 1.6, 0.4));
    let board = random.point(DVec3::new(0.2, 0.1, 0.01), DVec3::new(0.6, 0.2, 0.02));
    let step_m = random.between(0.2, 0.4);
    for i in 0..3 {
        put(board, shelf + f64::from(i) * step_m * DVec3::Z);
    }
    let table = random.point(DVec3::new(0.3, -1.2, 0.5), DVec3::new(1.2, 0.2, 0.8));
    let top = random.point(DVec3::new(0.3, 0.25, 0.01), DVec3::new(0.6, 0.4, 0.02));
    put(top, table);
    let foot = DVec3::new(0.03, 0.03, 0.5 * (table.z - top.z) - 0.01);
    for (x, y) in [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)] {
        let inset = top.truncate() - foot.truncate() - 0.01;
        put(foot, DVec3::new(table.x + x * inset.x, table.y + y * inset.y, foot.z + 0.01));
    }
    stage
}
