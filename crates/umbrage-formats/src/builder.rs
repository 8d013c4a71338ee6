//! A scene under construction, for formats that list polygons one after the other.
//!
//! Polygons of one node and one material become one surface. What is built is charged to a budget that grows with the
//! bytes of the input: a small file with repetitions cannot unfold into a scene that fills the memory.

use std::collections::{BTreeMap, BTreeSet};

use glam::{DVec2, DVec3};
use umbrage::id::{ImageId, MaterialId, NodeId, SurfaceId};
use umbrage::scene::{Image, Material, Node, Rgb, Scene, Surface};

use crate::warning::Unknown;
use crate::{FormatError, ReadOptions, Warning};

/// Reflectance of what has no material, or one that does not say: the grey of an average room.
pub(crate) const DEFAULT_REFLECTANCE: f64 = 0.5;

/// Corners that any file may unfold into: some 250 MB of memory at most.
pub(crate) const FREE_CORNERS: u64 = 4 << 20;

/// Corners that a file may unfold into for each of its bytes. A plain file needs at most one; only what is shown many
/// times, or stands for many polygons, needs more. The limit keeps memory proportional to the input.
pub(crate) const CORNERS_PER_BYTE: u64 = 16;

/// What a node or a surface takes in memory beside its name, in corners.
const OBJECT_COST: u64 = 16;

/// What has been unfolded, in corners or whatever else takes as much memory or time.
#[derive(Debug, Default)]
pub(crate) struct Budget {
    spent: u64,
    input_bytes: u64,
}

impl Budget {
    /// Says that `bytes` more have been read.
    pub(crate) fn grow(&mut self, bytes: usize) {
        self.input_bytes = self.input_bytes.saturating_add(bytes as u64);
    }

    /// Spends `corners`; an error if the input has not that many in it.
    pub(crate) fn spend(&mut self, corners: u64, file: &str, place: impl Fn() -> String) -> Result<(), FormatError> {
        self.spent = self.spent.saturating_add(corners);
        let limit = FREE_CORNERS.saturating_add(CORNERS_PER_BYTE.saturating_mul(self.input_bytes));
        if self.spent <= limit {
            return Ok(());
        }
        Err(FormatError::TooLarge { file: file.to_owned(), place: place(), wanted: self.spent, limit })
    }
}

/// A scene under construction.
#[derive(Debug)]
pub(crate) struct SceneBuilder {
    scene: Scene,
    surfaces: BTreeMap<(NodeId, MaterialId), SurfaceId>,
    max_reflectance: f64,
    capped_materials: usize,
    crossed: usize,
    dark: Vec<String>,
    /// Materials that light passes through.
    see_through: BTreeSet<MaterialId>,
    /// What may still be built.
    pub(crate) budget: Budget,
}

impl SceneBuilder {
    /// An empty scene, from a file of so many bytes.
    pub(crate) fn new(name: String, bytes: usize, options: &ReadOptions) -> Self {
        let mut budget = Budget::default();
        budget.grow(bytes);
        Self {
            scene: Scene { name, ..Scene::default() },
            surfaces: BTreeMap::new(),
            max_reflectance: options.max_reflectance.clamp(0.0, 1.0),
            capped_materials: 0,
            crossed: 0,
            dark: options.dark.clone(),
            see_through: BTreeSet::new(),
            budget,
        }
    }

    /// The scene's name.
    pub(crate) fn name(&self) -> &str {
        &self.scene.name
    }

    /// Adds a node, which is named like the mesh that it shows; `place` is told if there are too many.
    pub(crate) fn node(
        &mut self,
        name: &str,
        parent: Option<NodeId>,
        file: &str,
        place: impl Fn() -> String,
    ) -> Result<NodeId, FormatError> {
        self.budget.spend(OBJECT_COST + name.len() as u64 / 8, file, place)?;
        let name = Some(name.to_owned());
        Ok(self.scene.nodes.push_and_get_key(Node { name: name.clone(), parent, mesh_name: name, ..Node::default() }))
    }

    /// Adds a material, its reflectance capped.
    pub(crate) fn material(&mut self, material: Material) -> MaterialId {
        let cap = Rgb::splat(self.max_reflectance);
        self.capped_materials += usize::from(material.reflectance.cmpgt(cap).any());
        let reflectance = material.reflectance.min(cap);
        self.scene.materials.push_and_get_key(Material { reflectance, ..material })
    }

    /// Says what a material reflects, once it is known; capped.
    pub(crate) fn set_reflectance(&mut self, material: MaterialId, reflectance: Rgb) {
        let cap = Rgb::splat(self.max_reflectance);
        self.capped_materials += usize::from(reflectance.cmpgt(cap).any());
        self.scene.materials[material].reflectance = reflectance.min(cap);
    }

    /// Says what a material emits, once it is known, in W/(m2 sr).
    pub(crate) fn set_radiance(&mut self, material: MaterialId, radiance: Rgb) {
        self.scene.materials[material].radiance = radiance;
    }

    /// Adds an image.
    pub(crate) fn image(&mut self, image: Image) -> ImageId {
        self.scene.images.push_and_get_key(image)
    }

    /// All surfaces so far, to be completed.
    pub(crate) fn surfaces_mut(&mut self) -> impl Iterator<Item = (SurfaceId, &mut Surface)> {
        self.scene.surfaces.iter_mut_enumerated()
    }

    /// Adds the grey that stands for a missing material.
    pub(crate) fn grey(&mut self, name: &str) -> MaterialId {
        self.material(Material::diffuse(name, Rgb::splat(DEFAULT_REFLECTANCE)))
    }

    /// Adds a material that no surface has as it is.
    pub(crate) fn uncapped(&mut self, material: Material) -> MaterialId {
        self.scene.materials.push_and_get_key(material)
    }

    /// Adds a material that reflects `tint` times as much as another, and is like it otherwise.
    pub(crate) fn tinted(&mut self, material: MaterialId, tint: Rgb) -> MaterialId {
        let Material { reflectance, .. } = self.scene.materials[material];
        let is_glass = self.see_through.contains(&material);
        let id = self.material(Material { reflectance: reflectance * tint, ..self.scene.materials[material].clone() });
        if is_glass {
            self.see_through(id);
        }
        id
    }

    /// Whether a material of this name is to give no light.
    pub(crate) fn is_dark(&self, name: &str) -> bool {
        self.dark.iter().any(|dark| dark == name)
    }

    /// Lets light pass through all surfaces of a material, which are passed on.
    pub(crate) fn see_through(&mut self, material: MaterialId) {
        self.see_through.insert(material);
    }

    /// The surface of a material under a node.
    pub(crate) fn surface(&mut self, node: NodeId, material: MaterialId) -> SurfaceId {
        let surfaces = &mut self.scene.surfaces;
        *self
            .surfaces
            .entry((node, material))
            .or_insert_with(|| surfaces.push_and_get_key(Surface::new(node, material)))
    }

    /// Adds a position to a surface; its number there.
    pub(crate) fn position(&mut self, surface: SurfaceId, position_m: DVec3) -> u32 {
        let positions = &mut self.scene.surfaces[surface].positions_m;
        positions.push(position_m);
        // The budget is spent long before: positions are of corners, and 2^32 corners take 256 MiB of input.
        u32::try_from(positions.len() - 1).unwrap_or(u32::MAX)
    }

    /// Adds a position of one surface, with its normal, to another; its number there.
    pub(crate) fn copy_position(&mut self, from: SurfaceId, position: u32, to: SurfaceId) -> u32 {
        let (position, normal) = {
            let from = &self.scene.surfaces[from];
            (from.positions_m[position as usize], from.normals.get(position as usize).copied())
        };
        let number = self.position(to, position);
        if let Some(normal) = normal {
            self.corner(to, normal, None);
        }
        number
    }

    /// Says the normal (zero for none) and the place in its image, if there is one, of the position that was added last.
    pub(crate) fn corner(&mut self, surface: SurfaceId, normal: DVec3, uv: Option<DVec2>) {
        let surface = &mut self.scene.surfaces[surface];
        surface.normals.push(normal);
        surface.uvs.extend(uv);
    }

    /// Adds a polygon to a surface, unless its outline crosses itself so that nothing of it remains, which is counted.
    pub(crate) fn polygon(&mut self, surface: SurfaceId, corners: Vec<u32>) {
        if cancels_out(&self.scene.surfaces[surface].positions_m, &corners) {
            self.crossed += 1;
            return;
        }
        self.scene.surfaces[surface].polygons.push(corners);
    }

    /// The scene, and the warnings of capped materials and crossed polygons if there are any.
    pub(crate) fn finish(mut self) -> (Scene, Vec<Warning>) {
        if !self.see_through.is_empty() {
            let surfaces = std::mem::take(&mut self.scene.surfaces);
            let passes = |surface: &Surface| self.see_through.contains(&surface.material);
            let (see_through, solid): (Vec<_>, Vec<_>) = surfaces.into_iter().partition(passes);
            (self.scene.see_through, self.scene.surfaces) = (see_through, solid.into_iter().collect());
        }
        let capped = (self.capped_materials > 0).then_some(Warning::ReflectanceCapped {
            materials: self.capped_materials,
            max_reflectance: self.max_reflectance,
        });
        let crossed = (self.crossed > 0).then_some(Warning::CrossedLeftOut { polygons: self.crossed });
        (self.scene, capped.into_iter().chain(crossed).collect())
    }

    /// The scene of a format that has no materials, and all warnings.
    pub(crate) fn finish_without_materials(self, too_few_corners: usize, unknown: Unknown) -> (Scene, Vec<Warning>) {
        let (scene, capped) = self.finish();
        let mut warnings = Vec::new();
        let mut warn = |count: usize, warning: fn(usize) -> Warning| {
            if count > 0 {
                warnings.push(warning(count));
            }
        };
        warn(too_few_corners, |polygons| Warning::TooFewCorners { polygons });
        let grey =
            |surface: &&Surface| scene.materials[surface.material].reflectance == Rgb::splat(DEFAULT_REFLECTANCE);
        let polygons = scene.surfaces.iter().filter(grey).map(|surface| surface.polygons.len()).sum();
        warn(polygons, |polygons| Warning::WithoutMaterial { polygons });
        warnings.extend(capped);
        warnings.extend(unknown.warning());
        (scene, warnings)
    }
}

/// Whether a polygon has no area on the whole, though its corners span a plane: its outline crosses itself, as that of a bow-tie.
fn cancels_out(positions_m: &[DVec3], corners: &[u32]) -> bool {
    /// Of the square of its extent, an area below this is rounding.
    const NEGLIGIBLE: f64 = 1e-9;
    let [first, _, _, _, ..] = corners else { return false };
    let position = |corner: &u32| positions_m.get(*corner as usize).copied().unwrap_or_default();
    let origin = position(first);
    let arms = corners.iter().map(|corner| position(corner) - origin);
    let (mut area, mut spanned, mut extent) = (DVec3::ZERO, 0.0_f64, 0.0_f64);
    let mut before = DVec3::ZERO;
    for arm in arms {
        let cross = before.cross(arm);
        area += cross;
        spanned = spanned.max(cross.length());
        extent = extent.max(arm.length_squared());
        before = arm;
    }
    spanned > 1e3 * NEGLIGIBLE * extent && area.length() < NEGLIGIBLE * extent
}

/// The name of a scene whose format has none: the file's without its ending.
pub(crate) fn stem(path: &std::path::Path) -> String {
    path.file_stem().map(|stem| stem.to_string_lossy().into_owned()).unwrap_or_default()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn polygons_of_a_node_and_a_material_are_one_surface() {
        let mut builder = SceneBuilder::new("room".into(), 0, &ReadOptions::default());
        let node = builder.node("chair", None, "a.obj", String::new).unwrap();
        let (wood, white) = (builder.grey("wood"), builder.material(Material::diffuse("white", Rgb::ONE)));
        let first = builder.surface(node, wood);
        assert_eq!(builder.surface(node, wood), first);
        assert_ne!(builder.surface(node, white), first);
        let (scene, capped) = builder.finish();
        assert_eq!((scene.surfaces.len(), scene.name.as_str()), (2, "room"));
        assert_eq!(capped, [Warning::ReflectanceCapped { materials: 1, max_reflectance: 0.9 }]);
    }

    #[test]
    fn a_bow_tie_cancels_out() {
        let at = |corners: &[[f64; 2]]| -> Vec<DVec3> { corners.iter().map(|&[x, z]| DVec3::new(x, 0.0, z)).collect() };
        let cancels = |corners: &[[f64; 2]]| cancels_out(&at(corners), &(0..corners.len() as u32).collect::<Vec<_>>());
        assert!(cancels(&[[0.0, 0.0], [0.0, 4.0], [4.0, 0.0], [4.0, 4.0]]));
        assert!(!cancels(&[[0.0, 0.0], [0.0, 4.0], [4.0, 4.0], [4.0, 0.0]]));
        assert!(!cancels(&[[0.0, 0.0], [1.0, 0.0], [2.0, 0.0], [3.0, 0.0]]), "a line is something else");
        assert!(!cancels(&[[0.0, 0.0], [0.0, 4.0], [4.0, 0.0]]));
    }

    #[test]
    fn a_budget_ends() {
        let mut budget = Budget::default();
        assert!(budget.spend(FREE_CORNERS, "a", String::new).is_ok());
        assert!(matches!(budget.spend(1, "a", String::new), Err(FormatError::TooLarge { .. })));
        budget.grow(1);
        assert!(budget.spend(CORNERS_PER_BYTE - 1, "a", String::new).is_ok());
        assert!(budget.spend(u64::MAX, "a", String::new).is_err());
    }
}
