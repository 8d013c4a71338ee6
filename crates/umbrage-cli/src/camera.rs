//! The options that say from where a picture is taken.

use anyhow::Context;
use clap::Args;
use glam::DVec3;
use umbrage_picture::{Camera, MAX_SIZE_PX};

use crate::method::number;
use crate::shown::{Colors, Shown, default_camera};

/// Size of a picture.
#[derive(Clone, Copy, Debug, Args)]
pub struct SizeArgs {
    /// Width in pixels, of each picture where there are several
    #[arg(long, value_name = "PX", value_parser = size, default_value_t = 1024)]
    pub width: usize,
    /// Height in pixels
    #[arg(long, value_name = "PX", value_parser = size, default_value_t = 1024)]
    pub height: usize,
}

/// Where the picture is taken from.
#[derive(Clone, Debug, Args)]
#[command(next_help_heading = "Camera")]
pub struct CameraArgs {
    /// Where the camera stands, in metres: x,y,z
    #[arg(long, value_name = "X,Y,Z", value_parser = point, allow_hyphen_values = true, requires = "target")]
    eye: Option<DVec3>,
    /// The point that it looks at, in metres: x,y,z
    #[arg(long, value_name = "X,Y,Z", value_parser = point, allow_hyphen_values = true, requires = "eye")]
    target: Option<DVec3>,
    /// What is up in the picture: x,y,z [default: 0,1,0]
    #[arg(long, value_name = "X,Y,Z", value_parser = point, allow_hyphen_values = true, requires = "eye")]
    up: Option<DVec3>,
    /// Field of view from the lower to the upper edge, in degrees [default: the camera's, or 40]
    #[arg(long, value_name = "DEG", value_parser = angle)]
    fov: Option<f64>,
    /// The camera of the file that has this name [default: its first one]
    #[arg(long, value_name = "NAME", conflicts_with = "eye")]
    camera: Option<String>,
}

impl CameraArgs {
    /// Whether they say what the camera looks at.
    pub fn gives_target(&self) -> bool {
        self.target.is_some()
    }

    /// The camera that was asked for, of the file, or outside of it.
    ///
    /// # Errors
    /// Where the file has no camera of the name, or nothing to look at.
    pub fn choose(&self, file: &Shown, size: SizeArgs) -> anyhow::Result<Camera> {
        let camera = match (self.eye, self.target) {
            (Some(eye), Some(target)) => {
                let camera = Camera::looking(eye, target, Camera::DEFAULT_FOV_DEG);
                Some(Camera { up: self.up.unwrap_or(camera.up), ..camera })
            }
            _ => file.camera(self.camera.as_deref())?,
        };
        match camera {
            Some(camera) => Ok(Camera { fov_y_deg: self.fov.unwrap_or(camera.fov_y_deg), ..camera }),
            None => {
                let meshes = file.meshes(Colors::Seen, file.file.exposure_k);
                let fov_deg = self.fov.unwrap_or(Camera::DEFAULT_FOV_DEG);
                default_camera(&meshes, size.width, size.height, fov_deg).context("no view can be chosen")
            }
        }
    }
}

/// Three numbers with commas between.
fn point(text: &str) -> Result<DVec3, String> {
    let numbers = text.split(',').map(number).collect::<Result<Vec<_>, _>>();
    match numbers.as_deref() {
        Ok(&[x, y, z]) => Ok(DVec3::new(x, y, z)),
        _ => Err("must be three numbers with commas between, as in 1,0.5,-2".into()),
    }
}

fn angle(text: &str) -> Result<f64, String> {
    number(text).and_then(
        |x| {
            if (0.1..=179.0).contains(&x) { Ok(x) } else { Err("must be between 0.1 and 179".into()) }
        },
    )
}

fn size(text: &str) -> Result<usize, String> {
    match text.parse() {
        Ok(n) if (1..=MAX_SIZE_PX).contains(&n) => Ok(n),
        _ => Err(format!("must be a whole number between 1 and {MAX_SIZE_PX}")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_point_is_three_numbers() {
        assert_eq!(point("1, 0.5,-2"), Ok(DVec3::new(1.0, 0.5, -2.0)));
        assert!(point("1,2").is_err() && point("1,2,x").is_err() && point("1,2,inf").is_err());
    }

    #[test]
    fn sizes_and_angles_are_bounded() {
        assert!(size("0").is_err() && size("99999").is_err() && size("640") == Ok(640));
        assert!(angle("0").is_err() && angle("180").is_err() && angle("40") == Ok(40.0));
    }
}
