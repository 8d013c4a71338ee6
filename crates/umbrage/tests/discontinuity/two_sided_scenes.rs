//! Scenes of double-sided polygons: sheets and closed shells, lights that shine both ways, one-sided ones among them,
//! touching one another, lit from above and from below, near the origin and far from it.

use std::f64::consts::TAU;

use glam::{DQuat, DVec3};

use super::random::{Random, Stage, all_moved, block, moved, rectangle, scene_of};

/// As far as `f32` still holds the step of a stage's coordinates.
const FAR_M: f64 = 24.0;

/// A scene of which most is double-sided: that of `random::scene`, sheets that stand on the floor, hang from boxes or
/// lean on the wall, and half of the time a light and an occluder below the floor.
pub fn stage(random: &mut Random) -> Stage {
    let mostly = |random: &mut Random| random.below(4) > 0;
    let mut stage = scene_of(random, mostly);
    for _ in 0..1 + random.below(2) {
        stage.double_sided = mostly(random);
        let half = random.point(DVec3::splat(0.1), DVec3::splat(0.5));
        let turn = DQuat::from_rotation_z(random.between(0.0, TAU));
        let at = random.point(DVec3::new(-1.2, -1.2, 0.0), DVec3::new(1.2, 1.0, 0.0));
        match random.below(3) {
            // On the floor, upright or leaning.
            0 => {
                let lean = DQuat::from_rotation_x(TAU / 4.0 + random.between(-0.6, 0.6));
                let standing = moved(&rectangle(half.x, half.y), DQuat::IDENTITY, DVec3::Y * half.y);
                stage.add(&moved(&standing, turn * lean, at), 0.0);
            }
            // A tent: two sheets with a common edge.
            1 => {
                let ridge = DVec3::new(0.0, 0.0, half.z + 0.1);
                for side in [1.0, -1.0] {
                    let foot = DVec3::new(side * half.x, 0.0, 0.05);
                    let along = DVec3::Y * half.y;
                    stage.add(&moved(&[foot - along, foot + along, ridge + along, ridge - along], turn, at), 0.0);
                }
            }
            // A box with a sheet that goes on where its top ends.
            _ => {
                let to = at + DVec3::Z * (half.z + 0.2);
                stage.add_all(&all_moved(&block(half), turn, to), 0.0);
                let (from, over) = (DVec3::new(half.x, 0.0, half.z), DVec3::X * random.between(0.1, 0.4));
                let along = DVec3::Y * half.y;
                let awning = [from - along, from - along + over, from + along + over, from + along];
                stage.add(&moved(&awning, turn, to), 0.0);
            }
        }
    }
    if random.below(2) == 0 {
        stage.double_sided = mostly(random);
        let at = random.point(DVec3::new(-1.0, -1.0, -2.5), DVec3::new(1.0, 1.0, -1.8));
        let upward = DQuat::from_rotation_x(TAU / 2.0) * random.downward();
        let light = rectangle(random.between(0.15, 0.5), random.between(0.15, 0.5));
        stage.add(&moved(&light, upward, at), random.between(1.0, 4.0));
        stage.double_sided = mostly(random);
        let at = random.point(DVec3::new(-1.0, -1.0, -1.4), DVec3::new(1.0, 1.0, -0.5));
        let (x, y) = (random.between(0.1, 0.4), random.between(0.1, 0.4));
        stage.add(&moved(&rectangle(x, y), random.turn(), at), 0.0);
    }
    if random.below(2) == 0 {
        stage.move_to(random.point(DVec3::splat(-FAR_M), DVec3::splat(FAR_M)));
    }
    stage
}
