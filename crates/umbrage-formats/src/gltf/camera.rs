//! Cameras of a baked file: the perspective ones, where they stand in the world.

use glam::{DMat3, DVec3};

use super::document::{Document, List};
use super::node::Placed;
use crate::{BakedCamera, FormatError};

/// The perspective cameras among the nodes of a scene, in the order of the nodes; others are no use for a picture.
pub(super) fn cameras(document: &Document, placed: &[Placed<'_>]) -> Result<Vec<BakedCamera>, FormatError> {
    let mut cameras = Vec::new();
    for node in placed {
        let Some(index) = node.item.whole("camera")? else { continue };
        let camera = document.item(List::Cameras, index, &node.item.place)?;
        let Some(perspective) = camera.child("perspective")? else { continue };
        let fov_y = perspective.number("yfov")?.ok_or_else(|| perspective.bad("yfov", "is missing"))?;
        if !(fov_y > 0.0 && fov_y < std::f64::consts::PI) {
            return Err(perspective.bad("yfov", format!("{fov_y} is not between 0 and pi")));
        }
        // A camera looks along its own -Z, with its own +Y up.
        let DMat3 { y_axis, z_axis, .. } = node.world.matrix3;
        let (ahead, up) = (-z_axis.normalize_or_zero(), y_axis.normalize_or_zero());
        if ahead == DVec3::ZERO || up == DVec3::ZERO {
            return Err(node.item.bad("scale", "of a camera is 0"));
        }
        let name = node.item.name().or(camera.name()).unwrap_or_default().to_owned();
        cameras.push(BakedCamera { name, eye_m: node.world.translation, ahead, up, fov_y_deg: fov_y.to_degrees() });
    }
    Ok(cameras)
}
