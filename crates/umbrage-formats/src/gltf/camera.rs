//! Cameras, where they stand in the world.

use glam::DMat3;
use umbrage::id::NodeId;
use umbrage::scene::{Camera, Lens};

use super::document::{Document, List};
use super::item::Item;
use super::node::Placed;
use crate::FormatError;

/// The camera of a node, if it has one.
pub(super) fn of_node(document: &Document, placed: &Placed<'_>, node: NodeId) -> Result<Option<Camera>, FormatError> {
    let item = &placed.item;
    let Some(index) = item.whole("camera")? else { return Ok(None) };
    let camera = document.item(List::Cameras, index, &item.place)?;
    let Some(lens) = lens(&camera)? else { return Ok(None) };
    // A camera looks along its own -Z, with its own +Y up.
    let DMat3 { y_axis, z_axis, .. } = placed.world.matrix3;
    if z_axis.try_normalize().is_none() || y_axis.try_normalize().is_none() {
        return Err(item.bad("scale", "of a camera is 0"));
    }
    let name = camera.name().map(str::to_owned);
    Ok(Some(Camera { node, name, to_world: placed.world, lens }))
}

fn lens(camera: &Item<'_>) -> Result<Option<Lens>, FormatError> {
    let required = |of: &Item<'_>, key: &str| of.number(key)?.ok_or_else(|| of.bad(key, "is missing"));
    if let Some(perspective) = camera.child("perspective")? {
        let fov_y_rad = required(&perspective, "yfov")?;
        if !(fov_y_rad > 0.0 && fov_y_rad < std::f64::consts::PI) {
            return Err(perspective.bad("yfov", format!("{fov_y_rad} is not between 0 and pi")));
        }
        let (aspect, far_m) = (perspective.number("aspectRatio")?, perspective.number("zfar")?);
        let near_m = required(&perspective, "znear")?;
        return Ok(Some(Lens::Perspective { fov_y_rad, aspect, near_m, far_m }));
    }
    let Some(orthographic) = camera.child("orthographic")? else { return Ok(None) };
    let half_size_m = [required(&orthographic, "xmag")?, required(&orthographic, "ymag")?];
    let (near_m, far_m) = (required(&orthographic, "znear")?, required(&orthographic, "zfar")?);
    Ok(Some(Lens::Orthographic { half_size_m, near_m, far_m }))
}
