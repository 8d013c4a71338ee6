//! Receivers: the faces of one plane that look the same way, and the frame in which they are drawn.
//!
//! A receiver is drawn as it is seen from its front: walls stand upright, floors are seen from above with +X to the
//! right.

use std::collections::BTreeMap;

use glam::{DVec2, DVec3};
use umbrage::id::{FaceId, Table};
use umbrage::prepare::Prepared;
use umbrage::scene::Scene;

use crate::json::{self, Record, Rounding};

/// A normal this near to the vertical is that of a floor or a ceiling: the sine of a quarter of a degree.
const LEVEL_SINE: f64 = 4e-3;

/// Axes of a drawing.
#[derive(Clone, Copy, Debug)]
pub(crate) struct DrawingFrame {
    right: DVec3,
    up: DVec3,
}

impl DrawingFrame {
    /// The frame of a plane seen from its front.
    pub(crate) fn facing(normal: DVec3) -> Self {
        let upright = DVec3::Y - normal.y * normal;
        let up = if upright.length() > LEVEL_SINE {
            upright.normalize()
        } else {
            let level = -DVec3::Z * normal.y.signum();
            (level - level.dot(normal) * normal).normalize()
        };
        Self { right: up.cross(normal), up }
    }

    /// Coordinates of a point in the drawing, in metres.
    pub(crate) fn flat(&self, point_m: DVec3) -> DVec2 {
        DVec2::new(point_m.dot(self.right), point_m.dot(self.up))
    }
}

/// The faces of one plane that look the same way.
#[derive(Clone, Debug)]
pub(crate) struct Receiver {
    pub(crate) faces: Vec<FaceId>,
    pub(crate) normal: DVec3,
    /// Names of the materials of its faces.
    pub(crate) materials: Vec<String>,
    pub(crate) frame: DrawingFrame,
}

/// All receivers, in the order of their first faces, and the receiver of each face.
pub(crate) fn receivers(scene: &Scene, prepared: &Prepared) -> (Vec<Receiver>, Table<FaceId, usize>) {
    let mut numbers = BTreeMap::new();
    let mut receivers: Vec<Receiver> = Vec::new();
    let mut of_face = Table::new();
    for (id, face) in prepared.faces.iter_enumerated() {
        let number = *numbers.entry((face.plane, face.facing)).or_insert_with(|| {
            let normal = prepared.normal(id);
            let frame = DrawingFrame::facing(normal);
            receivers.push(Receiver { faces: Vec::new(), normal, materials: Vec::new(), frame });
            receivers.len() - 1
        });
        let receiver = &mut receivers[number];
        receiver.faces.push(id);
        let material = &scene.materials[face.material].name;
        if !receiver.materials.contains(material) {
            receiver.materials.push(material.clone());
        }
        of_face.push(number);
    }
    (receivers, of_face)
}

impl Receiver {
    /// What a drawing of it is called.
    pub(crate) fn title(&self, number: usize) -> String {
        let normal = self.normal.to_array().map(|x| format!("{:.2}", x + 0.0)).join(" ");
        format!("receiver {number}: {}, normal {normal}", self.materials.join(", "))
    }

    pub(crate) fn record(&self, number: usize) -> Record {
        Record::default()
            .with("id", number.to_string())
            .with("materials", json::list(self.materials.iter().map(|name| json::text(name))))
            .with("normal", json::list(self.normal.to_array().map(json::quantity)))
            .with("faces", json::ids(self.faces.iter().map(|face| face.index())))
    }
}

/// The faces: what the ids of other tables refer to.
pub(crate) fn face_records<'a>(
    prepared: &'a Prepared,
    of_face: &'a Table<FaceId, usize>,
    rounding: Rounding,
) -> impl Iterator<Item = Record> + 'a {
    prepared.faces.keys().map(move |face| {
        let corners_m = prepared.polygon_m(face).into_iter().map(|corner| prepared.origin_m + corner);
        Record::default()
            .with("id", face.index().to_string())
            .with("receiver", of_face[face].to_string())
            .with("corners_m", rounding.points(corners_m))
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn floors_are_seen_from_above_and_walls_stand_upright() {
        let flat = |normal: DVec3, p: DVec3| DrawingFrame::facing(normal).flat(p);
        assert_eq!(flat(DVec3::Y, DVec3::X), DVec2::X);
        assert_eq!(flat(DVec3::Y, -DVec3::Z), DVec2::Y);
        assert_eq!(flat(DVec3::Z, DVec3::new(1.0, 2.0, 0.0)), DVec2::new(1.0, 2.0));
        assert_eq!(flat(-DVec3::Y, DVec3::X), DVec2::X);
    }

    #[test]
    fn a_drawing_shows_the_front() {
        for normal in [DVec3::Y, -DVec3::Y, DVec3::X, DVec3::new(0.6, 0.0, -0.8), DVec3::new(0.48, 0.6, 0.64)] {
            let frame = DrawingFrame::facing(normal);
            assert!((frame.right.cross(frame.up) - normal).length() < 1e-12, "{normal}");
        }
    }
}
