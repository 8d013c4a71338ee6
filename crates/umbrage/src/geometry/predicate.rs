//! Exact orientation tests (Shewchuk, 1997), by the crate `robust`.

use glam::{DVec2, DVec3};
use robust::{Coord, Coord3D};

/// Positive where `c` lies to the left of the line from `a` to `b`, negative to the right, exactly zero on it.
pub fn orient_2d(a: DVec2, b: DVec2, c: DVec2) -> f64 {
    let coord = |p: DVec2| Coord { x: p.x, y: p.y };
    robust::orient2d(coord(a), coord(b), coord(c))
}

/// Positive where `d` lies in front of the plane through `a`, `b`, `c` (counter-clockwise seen from the front),
/// negative behind, exactly zero in it.
pub fn orient_3d(a: DVec3, b: DVec3, c: DVec3, d: DVec3) -> f64 {
    let coord = |p: DVec3| Coord3D { x: p.x, y: p.y, z: p.z };
    -robust::orient3d(coord(a), coord(b), coord(c), coord(d))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn signs_are_exact_beside_a_line() {
        let (a, b) = (DVec2::new(0.1, 0.1), DVec2::new(0.7, 0.7));
        assert_eq!(orient_2d(a, b, DVec2::splat(0.3)), 0.0);
        assert!(orient_2d(a, b, DVec2::new(0.3, 0.3_f64.next_up())) > 0.0);
        assert!(orient_2d(a, b, DVec2::new(0.3, 0.3_f64.next_down())) < 0.0);
    }

    #[test]
    fn the_front_is_where_corners_run_counter_clockwise() {
        assert!(orient_3d(DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::Z) > 0.0);
        assert!(orient_3d(DVec3::ZERO, DVec3::X, DVec3::Y, -DVec3::Z) < 0.0);
        assert_eq!(orient_3d(DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::X + DVec3::Y), 0.0);
    }
}
