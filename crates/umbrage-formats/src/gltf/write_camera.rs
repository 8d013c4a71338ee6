//! Cameras of an output file, where they stood.

use glam::{DMat3, DQuat, DVec3};
use serde_json::{Value, json};
use umbrage::scene::{Camera, Lens};

use super::write::put_name;

/// What a camera is, without its place.
pub(super) fn lens(camera: &Camera) -> Value {
    let mut out = match camera.lens {
        Lens::Perspective { fov_y_rad, aspect, near_m, far_m } => {
            let mut perspective = json!({"yfov": fov_y_rad, "znear": near_m});
            for (key, value) in [("aspectRatio", aspect), ("zfar", far_m)] {
                if let Some(value) = value {
                    perspective[key] = json!(value);
                }
            }
            json!({"type": "perspective", "perspective": perspective})
        }
        Lens::Orthographic { half_size_m: [x_m, y_m], near_m, far_m } => json!({
            "type": "orthographic",
            "orthographic": {"xmag": x_m, "ymag": y_m, "znear": near_m, "zfar": far_m},
        }),
    };
    put_name(&mut out, camera.name.as_deref());
    out
}

/// Hangs camera `number` into the nodes of the file, of which the first is the root at `origin_m`: on its own node where nothing
/// else would be moved, else on a new one below it.
pub(super) fn place(camera: &Camera, number: usize, origin_m: DVec3, nodes: &mut Vec<Value>) {
    // The scene's node i is the file's node i + 1.
    let own = camera.node.index() + 1;
    let alone = ["mesh", "children", "camera"].iter().all(|key| nodes[own].get(key).is_none());
    let at = if alone {
        own
    } else {
        let mut below = json!({});
        put_name(&mut below, camera.name.as_deref());
        nodes.push(below);
        let at = nodes.len() - 1;
        match nodes[own]["children"].as_array_mut() {
            Some(children) => children.push(json!(at)),
            None => nodes[own]["children"] = json!([at]),
        }
        at
    };
    let node = &mut nodes[at];
    node["camera"] = json!(number);
    node["translation"] = json!((camera.to_world.translation - origin_m).to_array());
    node["rotation"] = json!(turned(camera.to_world.matrix3).to_array());
}

/// The rotation of a camera's axes, without scale and shear: it goes on looking along -Z.
fn turned(axes: DMat3) -> DQuat {
    let z = axes.z_axis.normalize_or(DVec3::Z);
    let x = axes.y_axis.cross(z).try_normalize().unwrap_or_else(|| z.any_orthonormal_vector());
    DQuat::from_mat3(&DMat3::from_cols(x, z.cross(x), z)).normalize()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_scaled_and_mirrored_camera_keeps_its_view() {
        let axes = DMat3::from_cols(DVec3::Z * 2.0, DVec3::Y * 3.0, DVec3::X * 0.5);
        let turned = DMat3::from_quat(turned(axes));
        assert!(turned.z_axis.distance(DVec3::X) < 1e-12 && turned.y_axis.distance(DVec3::Y) < 1e-12);
    }
}
