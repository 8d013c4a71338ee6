//! A baked file as it is drawn: meshes with the colours that were asked for, its textures, and its camera.

use std::path::Path;
use std::sync::Arc;

use anyhow::{Context, anyhow};
use glam::DVec3;
use umbrage_formats::{BakedCamera, BakedFile, BakedFilePart, picture_wrap, read_baked};
use umbrage_picture::{Camera, PictureMesh, Texture};

/// What the colours of a picture are.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Colors {
    /// Base colour times light, as any viewer shows it, but not cut off at white.
    Seen,
    /// The light alone, as if all surfaces were white.
    Light,
    /// Irradiance, in the file's unit.
    Irradiance,
}

/// A baked file that is ready to be drawn.
pub struct Shown {
    /// What was read.
    pub file: BakedFile,
    /// The texture of each part that has one.
    textures: Vec<Option<Arc<Texture>>>,
}

impl Shown {
    /// Reads a baked file and decodes its textures.
    ///
    /// # Errors
    /// Where it cannot be read, or a texture cannot be decoded.
    pub fn read(path: &Path) -> anyhow::Result<Self> {
        Self::new(read_baked(path)?, path)
    }

    /// A baked file with its textures decoded, each image once for each way to wrap it. `path` is for messages.
    ///
    /// # Errors
    /// Where a texture cannot be decoded.
    pub fn new(file: BakedFile, path: &Path) -> anyhow::Result<Self> {
        let mut decoded: Vec<(_, Arc<Texture>)> = Vec::new();
        let mut textures = Vec::new();
        for part in &file.parts {
            let Some(key) = part.texture else {
                textures.push(None);
                continue;
            };
            if let Some((_, texture)) = decoded.iter().find(|(known, _)| *known == key) {
                textures.push(Some(Arc::clone(texture)));
                continue;
            }
            let texture = Texture::decode(&file.images[key.image], key.wrap.map(picture_wrap)).with_context(|| {
                format!("{}: cannot use image {}, the texture of {:?}", path.display(), key.image, part.material_name)
            })?;
            let texture = Arc::new(texture);
            decoded.push((key, Arc::clone(&texture)));
            textures.push(Some(texture));
        }
        Ok(Self { file, textures })
    }

    /// The texture of each part that has one.
    pub fn textures(&self) -> &[Option<Arc<Texture>>] {
        &self.textures
    }

    /// Its parts, exposed with `k` per W/(m2 sr), which is the file's own unless two files are compared.
    pub fn meshes(&self, colors: Colors, k: f64) -> Vec<PictureMesh> {
        let parts = self.file.parts.iter().zip(&self.textures);
        parts.map(|(part, texture)| self.mesh(part, texture.as_ref(), colors, k)).collect()
    }

    fn mesh(&self, part: &BakedFilePart, texture: Option<&Arc<Texture>>, colors: Colors, k: f64) -> PictureMesh {
        let file_k = self.file.exposure_k;
        let brighter = (k / file_k) as f32;
        let times = |factor: [f32; 3]| {
            let light = part.light(file_k);
            light.into_iter().map(|l| std::array::from_fn(|i| factor[i] * l[i])).collect()
        };
        let [red, green, blue, _] = part.base_color;
        let origin_m = self.file.origin_m;
        PictureMesh {
            positions_m: part
                .positions_m
                .iter()
                .map(|p| (origin_m + DVec3::from(p.map(f64::from))).to_array())
                .collect(),
            colors: match colors {
                Colors::Seen => times([red, green, blue].map(|base| base * brighter)),
                Colors::Light => times([brighter; 3]),
                Colors::Irradiance => part.irradiance.clone(),
            },
            uvs: part.uvs.clone(),
            texture: texture.filter(|_| colors == Colors::Seen).cloned(),
            mask: texture.cloned().zip(part.cutoff),
            triangles: part.triangles.clone(),
        }
    }

    /// The camera of the file that is called `name`, or its first one.
    ///
    /// # Errors
    /// Where the file has none of that name.
    pub fn camera(&self, name: Option<&str>) -> anyhow::Result<Option<Camera>> {
        let cameras = &self.file.cameras;
        let Some(name) = name else { return Ok(cameras.first().map(from_file)) };
        let found = cameras.iter().find(|camera| camera.name == name).map(from_file);
        found.map(Some).ok_or_else(|| match cameras.as_slice() {
            [] => anyhow!("there is no camera {name:?}: the file has none"),
            _ => {
                let names: Vec<_> = cameras.iter().map(|camera| format!("{:?}", camera.name)).collect();
                anyhow!("there is no camera {name:?}: the file has {}", names.join(", "))
            }
        })
    }
}

/// A camera of a file: what it turns around is not said there, and is a metre ahead.
pub fn from_file(camera: &BakedCamera) -> Camera {
    let &BakedCamera { eye_m, ahead, up, fov_y_deg, .. } = camera;
    Camera { eye_m, target_m: eye_m + ahead, up, fov_y_deg }
}

/// The camera where none is asked for and the file has none.
///
/// # Errors
/// Where there is nothing to look at.
pub fn default_camera(meshes: &[PictureMesh], width: usize, height: usize, fov_deg: f64) -> anyhow::Result<Camera> {
    umbrage_picture::default_camera(meshes, width, height, fov_deg)?
        .ok_or_else(|| anyhow!("there are no triangles: bake a scene that has surfaces"))
}
