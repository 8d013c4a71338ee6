//! The scene: nodes, materials, and the surfaces that join them.

use glam::{DVec2, DVec3};

use super::bounds::{MAX_BRIGHTNESS, MAX_COORDINATE_M};
use super::{Camera, Image, Lamp, Material, Rgb};
use crate::id::{ImageId, LampId, MaterialId, NodeId, SurfaceId, Table};

/// Characters of a name that a message shows.
const SHOWN_CHARACTERS: usize = 80;

/// A name as messages have it.
fn shown(name: &str) -> String {
    match name.char_indices().nth(SHOWN_CHARACTERS) {
        Some((end, _)) => format!("{}...", &name[..end]),
        None => name.to_owned(),
    }
}

/// A node of the scene's hierarchy. Surfaces are already in world space, so a node holds no transform.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Node {
    /// Name, as in the file.
    pub name: Option<String>,
    /// The node that it hangs from; a parent comes before its children.
    pub parent: Option<NodeId>,
    /// Name of its mesh, as in the file.
    pub mesh_name: Option<String>,
    /// What an application has put beside it, as JSON.
    pub extras: Option<String>,
    /// What an application has put beside its mesh, as JSON.
    pub mesh_extras: Option<String>,
}

/// Polygons of one material under one node.
#[derive(Clone, Debug, PartialEq)]
pub struct Surface {
    /// The node that it belongs to.
    pub node: NodeId,
    /// Its material.
    pub material: MaterialId,
    /// Corners in world space, in metres.
    pub positions_m: Vec<DVec3>,
    /// Texture coordinates of each corner, (0, 0) being the upper left of the image; empty without.
    pub uvs: Vec<DVec2>,
    /// Unit normal of each corner, of the smooth surface that the polygons stand for, or zero where there is none;
    /// empty without any.
    pub normals: Vec<DVec3>,
    /// Simple plane polygons: indices into `positions_m`, counter-clockwise seen from the front.
    pub polygons: Vec<Vec<u32>>,
    /// Whether it is in what is baked. If not, it blocks, reflects and emits all the same.
    pub baked: bool,
}

impl Surface {
    /// A surface without polygons.
    pub fn new(node: NodeId, material: MaterialId) -> Self {
        Self {
            node,
            material,
            positions_m: Vec::new(),
            uvs: Vec::new(),
            normals: Vec::new(),
            polygons: Vec::new(),
            baked: true,
        }
    }

    /// Adds a polygon with corners of its own.
    pub fn push_polygon(&mut self, corners_m: impl IntoIterator<Item = DVec3>) {
        let first = self.positions_m.len() as u32;
        self.positions_m.extend(corners_m);
        self.polygons.push((first..self.positions_m.len() as u32).collect());
    }

    /// What of its tables does not fit together.
    fn defect(&self) -> Option<&'static str> {
        let n = self.positions_m.len();
        let fits = |count: usize| count == 0 || count == n;
        if !fits(self.uvs.len()) || !fits(self.normals.len()) {
            Some("has not as many texture coordinates or normals as corners")
        } else if !(self.uvs.iter().all(|uv| uv.is_finite()) && self.normals.iter().all(|n| n.is_finite())) {
            Some("has a texture coordinate or a normal that is not finite")
        } else {
            None
        }
    }
}

/// A polygonal scene.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Scene {
    /// Name, as in the file, or the file's.
    pub name: String,
    /// The hierarchy, parents before children.
    pub nodes: Table<NodeId, Node>,
    /// The materials.
    pub materials: Table<MaterialId, Material>,
    /// The surfaces.
    pub surfaces: Table<SurfaceId, Surface>,
    /// Surfaces that light passes through unchanged (`alphaMode` BLEND): they take no part, and are passed on.
    pub see_through: Vec<Surface>,
    /// Images on the materials.
    pub images: Table<ImageId, Image>,
    /// Cameras.
    pub cameras: Vec<Camera>,
    /// Lamps without extent; surfaces that emit are light sources too.
    pub lamps: Table<LampId, Lamp>,
    /// Whether light is photometric: lumens, lux and cd/m2 stand where watts are said elsewhere.
    pub photometric: bool,
    /// Whose work it is, as in the file.
    pub copyright: Option<String>,
    /// What an application has put beside the scene, as JSON.
    pub extras: Option<String>,
    /// What an application has put beside the file as a whole, as JSON.
    pub asset_extras: Option<String>,
}

/// Why a scene cannot be baked. Places are named by the node's and the material's names and the polygon's number.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum SceneError {
    /// There is no polygon at all.
    #[error("the scene has no polygons: nothing can be baked")]
    Empty,
    /// No polygon emits light, and there is no lamp.
    #[error(
        "nothing emits light: give a material an emissive colour in the file (glTF: emissiveFactor, OBJ: Ke, MGF: ed), \
         with --emit MATERIAL=r,g,b, or with a TOML beside the scene (SCENE.umbrage.toml or --materials FILE), which may also have lamps. Blender \
         exports its lamps only with Data > Lighting > Punctual Lights ticked; area lamps and the world are not in a glTF at all: give a \
         surface emission instead. Materials of the scene are {known}"
    )]
    Lightless {
        /// The names of its materials, the first few.
        known: String,
    },
    /// A coordinate is NaN or infinite, or farther away than anything can be.
    #[error(
        "{place}: corner {corner} is at {:?}, which is not a finite point within {MAX_COORDINATE_M:e} m: mend the mesh, or say its \
         unit with --unit",
        .position.to_array()
    )]
    NotFinite {
        /// Surface and polygon.
        place: String,
        /// Number of the corner in the polygon.
        corner: usize,
        /// Its coordinates.
        position: DVec3,
    },
    /// A polygon refers to a corner that does not exist.
    #[error("{place}: refers to corner {index}, but the surface has only {count}: export the mesh again")]
    BadIndex {
        /// Surface and polygon.
        place: String,
        /// The index that is too large.
        index: u32,
        /// How many corners there are.
        count: usize,
    },
    /// The tables of a surface do not fit together.
    #[error("{place}: {what}: export the mesh again")]
    BadAttributes {
        /// Surface.
        place: String,
        /// What is wrong.
        what: &'static str,
    },
    /// A polygon has fewer than three corners.
    #[error("{place}: has {count} corners, and a polygon needs three")]
    TooFewCorners {
        /// Surface and polygon.
        place: String,
        /// How many it has.
        count: usize,
    },
    /// A material's colour is negative, NaN or infinite, or its reflectance above 1.
    #[error("material {name:?}: {what} is {:?}, and must be {bound}", .value.to_array())]
    BadMaterial {
        /// The material's name.
        name: String,
        /// `reflectance` or `radiance`.
        what: &'static str,
        /// The colour.
        value: Rgb,
        /// What it must be.
        bound: &'static str,
    },
    /// A lamp has no place, no direction or no brightness.
    #[error("lamp {name:?}: {bound}")]
    BadLamp {
        /// The lamp's name.
        name: String,
        /// What is wrong with it.
        bound: &'static str,
    },
}

impl Scene {
    /// How a message names polygon `polygon` of a surface.
    pub fn place(&self, surface: SurfaceId, polygon: usize) -> String {
        format!("{}, polygon {polygon}", self.surface_place(&self.surfaces[surface]))
    }

    fn surface_place(&self, surface: &Surface) -> String {
        let node = &self.nodes[surface.node];
        let node_name = node.name.as_deref().or(node.mesh_name.as_deref()).unwrap_or("unnamed");
        format!("node {:?}, material {:?}", shown(node_name), shown(&self.materials[surface.material].name))
    }

    /// Number of polygons of all surfaces.
    pub fn polygon_count(&self) -> usize {
        self.surfaces.iter().map(|s| s.polygons.len()).sum()
    }

    /// The corners of a polygon.
    pub fn corners_m(&self, surface: SurfaceId, polygon: usize) -> impl ExactSizeIterator<Item = DVec3> + '_ {
        let s = &self.surfaces[surface];
        s.polygons[polygon].iter().map(|&i| s.positions_m[i as usize])
    }

    /// Checks everything that later stages rely on.
    ///
    /// # Errors
    /// A [`SceneError`] that names the first offender and how to mend it.
    pub fn validate(&self) -> Result<(), SceneError> {
        if self.polygon_count() == 0 {
            return Err(SceneError::Empty);
        }
        for m in &self.materials {
            let bad = |what, value, bound| Err(SceneError::BadMaterial { name: shown(&m.name), what, value, bound });
            if !(m.reflectance.is_finite() && m.reflectance.min_element() >= 0.0 && m.reflectance.max_element() <= 1.0)
            {
                return bad("reflectance", m.reflectance, "between 0 and 1");
            }
            if !(m.radiance.is_finite() && m.radiance.min_element() >= 0.0) {
                return bad("radiance", m.radiance, "finite and not negative");
            }
            if m.radiance.max_element() > MAX_BRIGHTNESS {
                return bad(
                    "radiance",
                    m.radiance,
                    "at most 1e15 W/(m2 sr): mend it in the file, or give another with --emit",
                );
            }
        }
        for lamp in &self.lamps {
            if let Some(bound) = lamp.defect() {
                return Err(SceneError::BadLamp { name: shown(&lamp.name), bound });
            }
        }
        for surface in self.surfaces.iter().chain(&self.see_through) {
            if let Some(what) = surface.defect() {
                return Err(SceneError::BadAttributes { place: self.surface_place(surface), what });
            }
            for (number, polygon) in surface.polygons.iter().enumerate() {
                let place = || format!("{}, polygon {number}", self.surface_place(surface));
                if polygon.len() < 3 {
                    return Err(SceneError::TooFewCorners { place: place(), count: polygon.len() });
                }
                for (corner, &index) in polygon.iter().enumerate() {
                    let Some(&position) = surface.positions_m.get(index as usize) else {
                        return Err(SceneError::BadIndex { place: place(), index, count: surface.positions_m.len() });
                    };
                    if !(position.is_finite() && position.abs().max_element() <= MAX_COORDINATE_M) {
                        return Err(SceneError::NotFinite { place: place(), corner, position });
                    }
                }
            }
        }
        let lit = self.surfaces.iter().any(|s| !s.polygons.is_empty() && self.materials[s.material].emits())
            || self.lamps.iter().any(Lamp::emits);
        if lit { Ok(()) } else { Err(SceneError::Lightless { known: self.material_names() }) }
    }

    /// The names of the first few materials, for messages.
    fn material_names(&self) -> String {
        const LISTED: usize = 12;
        let names: Vec<String> = self.materials.iter().take(LISTED).map(|m| format!("{:?}", shown(&m.name))).collect();
        let more = if self.materials.len() > LISTED { ", ..." } else { "" };
        names.join(", ") + more
    }
}

#[cfg(test)]
mod tests {
    use super::super::{LampKind, cornell};
    use super::*;

    #[test]
    fn the_cornell_box_is_valid() {
        assert_eq!(cornell::cornell_box().validate(), Ok(()));
    }

    #[test]
    fn an_empty_scene_is_refused() {
        assert_eq!(Scene::default().validate(), Err(SceneError::Empty));
    }

    #[test]
    fn a_lightless_scene_is_refused() {
        let mut scene = cornell::cornell_box();
        scene.materials.iter_mut().for_each(|m| m.radiance = Rgb::ZERO);
        let message = scene.validate().unwrap_err().to_string();
        assert!(message.contains("--emit MATERIAL=r,g,b") && message.contains("\"red\", \"green\""), "{message}");
    }

    #[test]
    fn a_nan_is_named_by_place_and_corner() {
        let mut scene = cornell::cornell_box();
        let first = SurfaceId::from(0);
        let index = scene.surfaces[first].polygons[1][2] as usize;
        scene.surfaces[first].positions_m[index].y = f64::NAN;
        let message = scene.validate().unwrap_err().to_string();
        assert!(message.contains("polygon 1") && message.contains("corner 2"), "{message}");
    }

    #[test]
    fn what_is_beyond_all_bounds_is_refused_with_its_place() {
        let first = SurfaceId::from(0);
        for huge in [1e100, 1e308] {
            let mut scene = cornell::cornell_box();
            scene.surfaces[first].positions_m[0].y = huge;
            let message = scene.validate().unwrap_err().to_string();
            assert!(message.contains("polygon 0") && message.contains("--unit") && message.len() < 300, "{message}");
            let mut scene = cornell::cornell_box();
            scene.materials[MaterialId::from(3)].radiance.x = huge;
            let message = scene.validate().unwrap_err().to_string();
            assert!(
                message.contains("\"light\": radiance") && message.contains("--emit") && message.len() < 300,
                "{message}"
            );
            let mut scene = cornell::cornell_box();
            let kind = LampKind::Point { position_m: DVec3::ONE, intensity: Rgb::splat(huge), range_m: None };
            scene.lamps.push(Lamp { name: "b".repeat(100_000), kind });
            let message = scene.validate().unwrap_err().to_string();
            assert!(message.contains("brightness") && message.len() < 300, "{message}");
        }
    }

    #[test]
    fn a_dangling_index_is_named() {
        let mut scene = cornell::cornell_box();
        scene.surfaces[SurfaceId::from(0)].polygons[0][0] = 4_000_000;
        assert!(matches!(scene.validate(), Err(SceneError::BadIndex { index: 4_000_000, .. })));
    }

    #[test]
    fn a_line_is_no_polygon() {
        let mut scene = cornell::cornell_box();
        scene.surfaces[SurfaceId::from(0)].polygons[0].truncate(2);
        assert!(matches!(scene.validate(), Err(SceneError::TooFewCorners { count: 2, .. })));
    }

    #[test]
    fn reflectance_above_one_is_refused() {
        let mut scene = cornell::cornell_box();
        scene.materials[MaterialId::from(0)].reflectance = Rgb::splat(1.5);
        assert!(matches!(scene.validate(), Err(SceneError::BadMaterial { what: "reflectance", .. })));
    }
}
