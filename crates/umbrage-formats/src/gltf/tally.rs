//! What is counted while a glTF is read: the warnings, and the geometry that it unfolds into.

use super::document::Document;
use crate::builder::{CORNERS_PER_BYTE, FREE_CORNERS};
use crate::{FormatError, Warning};

/// What a primitive takes in memory and time beside its corners, in corners.
pub(super) const PRIMITIVE_COST: usize = 32;

/// Unknown extensions that have a warning of their own.
const NAMED_EXTENSIONS: usize = 12;

/// Counts for warnings, and of what has been unfolded.
#[derive(Debug, Default)]
pub(super) struct Tally {
    pub(super) points_and_lines: usize,
    pub(super) left_over_corners: usize,
    pub(super) no_positions: usize,
    pub(super) capped_materials: usize,
    /// Uses of a texture that were left out, and why the first one was.
    textures: (usize, String),
    pub(super) varying_colours: usize,
    /// Materials with `alphaMode` MASK.
    pub(super) masked_materials: usize,
    /// Polygons of materials with `alphaMode` BLEND, which are passed on as they are.
    pub(super) blended_polygons: usize,
    /// Polygons of materials that transmit most of the light, which are passed on as if they were blended.
    pub(super) glass_polygons: usize,
    /// Polygons of which alpha leaves nothing.
    pub(super) invisible_polygons: usize,
    /// Nodes that are hidden (`KHR_node_visibility`).
    pub(super) hidden_nodes: usize,
    /// Lamps that no lamp can be like, and what was done to the first.
    mended_lamps: (usize, String),
    /// Materials that transmit light, and are opaque here.
    pub(super) opaque_glass: usize,
    pub(super) skinned_nodes: usize,
    pub(super) morphed_primitives: usize,
    /// Lamps whose unit is doubtful beside surfaces that emit.
    pub(super) blender_lamps: usize,
    /// Cameras that see nothing.
    pub(super) bad_cameras: usize,
    pub(super) animations: usize,
    pub(super) nodes_outside: usize,
    /// Name, and whether it is required.
    pub(super) unknown_extensions: Vec<(String, bool)>,
    corners: u64,
}

impl Tally {
    /// Counts a use of a texture that is left out, and says why.
    pub(super) fn texture_ignored(&mut self, why: String) {
        if self.textures.0 == 0 {
            self.textures.1 = why;
        }
        self.textures.0 += 1;
    }

    /// Counts a lamp that had to be mended, and says how the first one was.
    pub(super) fn lamp_mended(&mut self, name: &str, what: String) {
        if self.mended_lamps.0 == 0 {
            self.mended_lamps.1 = format!("{:?}: {what}", crate::text::shortened(name));
        }
        self.mended_lamps.0 += 1;
    }

    /// Counts `corners` more, or whatever else takes memory or time as a corner does.
    pub(super) fn unfold(&mut self, corners: usize, document: &Document, place: &str) -> Result<(), FormatError> {
        self.corners = self.corners.saturating_add(corners as u64);
        let limit = FREE_CORNERS + CORNERS_PER_BYTE.saturating_mul(document.input_bytes());
        if self.corners <= limit {
            return Ok(());
        }
        let (file, place) = (document.file.clone(), place.to_owned());
        Err(FormatError::TooLarge { file, place, wanted: self.corners, limit })
    }

    /// The warnings, one per kind that occurred.
    pub(super) fn warnings(self, max_reflectance: f64) -> Vec<Warning> {
        let mut warnings = Vec::new();
        let mut warn = |count: usize, warning: fn(usize) -> Warning| {
            if count > 0 {
                warnings.push(warning(count));
            }
        };
        warn(self.points_and_lines, |primitives| Warning::PointsAndLines { primitives });
        warn(self.left_over_corners, |primitives| Warning::LeftOverCorners { primitives });
        warn(self.no_positions, |primitives| Warning::NoPositions { primitives });
        warn(self.varying_colours, |primitives| Warning::VertexColoursAveraged { primitives });
        warn(self.masked_materials, |materials| Warning::AlphaIgnored { materials });
        warn(self.blended_polygons, |polygons| Warning::BlendedPassedOn { polygons });
        warn(self.glass_polygons, |polygons| Warning::GlassPassedOn { polygons });
        warn(self.invisible_polygons, |polygons| Warning::TransparentLeftOut { polygons });
        warn(self.hidden_nodes, |nodes| Warning::HiddenLeftOut { nodes });
        warn(self.opaque_glass, |materials| Warning::TransmissionIgnored { materials });
        warn(self.skinned_nodes, |nodes| Warning::SkinsAtRest { nodes });
        warn(self.morphed_primitives, |primitives| Warning::MorphTargetsAtRest { primitives });
        warn(self.blender_lamps, |lamps| Warning::LampsFromBlender { lamps });
        warn(self.bad_cameras, |cameras| Warning::CamerasLeftOut { cameras });
        warn(self.animations, |animations| Warning::AnimationsIgnored { animations });
        warn(self.nodes_outside, |nodes| Warning::NodesOutsideScene { nodes });
        let (lamps, first) = self.mended_lamps;
        if lamps > 0 {
            warnings.push(Warning::LampsMended { lamps, first });
        }
        let (uses, first) = self.textures;
        if uses > 0 {
            warnings.push(Warning::TexturesIgnored { uses, first });
        }
        if self.capped_materials > 0 {
            warnings.push(Warning::ReflectanceCapped { materials: self.capped_materials, max_reflectance });
        }
        let mut unknown = self.unknown_extensions.into_iter();
        let named = unknown.by_ref().take(NAMED_EXTENSIONS);
        warnings.extend(named.map(|(name, required)| Warning::UnknownExtension { name, required }));
        let more = unknown.count();
        if more > 0 {
            warnings.push(Warning::MoreUnknownExtensions { more });
        }
        warnings
    }
}
