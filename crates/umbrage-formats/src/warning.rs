//! What a reader did not take over as it stood: one warning per kind, each with its count.
//!
//! A warning never stops a bake; it is for the report. Nothing is dropped without one.

use std::fmt;

/// Something in a scene file that was ignored or altered.
#[derive(Clone, Debug, PartialEq)]
pub enum Warning {
    /// Primitives of points or lines, which have no area: left out.
    PointsAndLines {
        /// How many primitives.
        primitives: usize,
    },
    /// Primitives with corners left over that make no triangle: the corners were left out.
    LeftOverCorners {
        /// How many primitives.
        primitives: usize,
    },
    /// Primitives without positions: left out.
    NoPositions {
        /// How many primitives.
        primitives: usize,
    },
    /// Materials that reflect more than the cap in some channel: capped there.
    ReflectanceCapped {
        /// How many materials.
        materials: usize,
        /// The cap.
        max_reflectance: f64,
    },
    /// Textures that cannot be used: the plain colours were taken.
    TexturesIgnored {
        /// How many uses of a texture.
        uses: usize,
        /// What is wrong with the first.
        first: String,
    },
    /// Vertex colours that vary over a primitive: their average was taken.
    VertexColoursAveraged {
        /// How many primitives.
        primitives: usize,
    },
    /// Materials that are cut out by a texture (`alphaMode` MASK) or half transparent (OBJ `d`): they block light as a whole.
    AlphaIgnored {
        /// How many materials.
        materials: usize,
    },
    /// Skinned meshes: taken in rest pose.
    SkinsAtRest {
        /// How many nodes.
        nodes: usize,
    },
    /// Primitives with morph targets: taken at the weights that the file states.
    MorphTargetsAtRest {
        /// How many primitives.
        primitives: usize,
    },
    /// Lamps (`KHR_lights_punctual`) in a file by Blender, which multiplies them by 683 lm/W and does not multiply surfaces that
    /// emit: taken as they stand.
    LampsFromBlender {
        /// How many lamps.
        lamps: usize,
    },
    /// Cameras that are broken or see nothing: left out.
    CamerasLeftOut {
        /// How many cameras.
        cameras: usize,
    },
    /// Animations: the scene was taken as the nodes stand.
    AnimationsIgnored {
        /// How many animations.
        animations: usize,
    },
    /// Nodes that are in other scenes of the file only: left out.
    NodesOutsideScene {
        /// How many nodes.
        nodes: usize,
    },
    /// Polygons of materials that are blended (`alphaMode` BLEND): light passes through them, and they are passed on.
    BlendedPassedOn {
        /// How many polygons.
        polygons: usize,
    },
    /// Polygons of materials that transmit at least half of the light (`KHR_materials_transmission`): light passes through
    /// them unchanged, and they are passed on as if they were blended.
    GlassPassedOn {
        /// How many polygons.
        polygons: usize,
    },
    /// Polygons of materials that are fully transparent, which block nothing: left out.
    TransparentLeftOut {
        /// How many polygons.
        polygons: usize,
    },
    /// Nodes that are hidden (`KHR_node_visibility`), with all below them: they neither block light nor give any.
    HiddenLeftOut {
        /// How many nodes.
        nodes: usize,
    },
    /// Lamps with values that no lamp can have: mended as viewers do.
    LampsMended {
        /// How many values.
        lamps: usize,
        /// The first lamp, and what was done.
        first: String,
    },
    /// Polygons with fewer than three corners: left out.
    TooFewCorners {
        /// How many polygons.
        polygons: usize,
    },
    /// Polygons without a material: taken as grey, reflectance 0.5, under the name `default`.
    WithoutMaterial {
        /// How many polygons.
        polygons: usize,
    },
    /// Materials that are used and nowhere defined: taken as grey, reflectance 0.5, under their names.
    MaterialsMissing {
        /// How many materials.
        materials: usize,
        /// The first of them.
        first: String,
    },
    /// A material library that could not be read.
    MaterialLibraryMissing {
        /// The library, as the scene names it.
        library: String,
        /// Why it could not be read.
        why: String,
        /// The library that was read instead: the one that is named like the scene.
        replaced_by: Option<String>,
    },
    /// Further material libraries that could not be read.
    MoreLibrariesMissing {
        /// How many.
        libraries: usize,
    },
    /// Polygons with colours at their corners and an image on them: the image says their colour.
    ColoursUnderImages {
        /// How many polygons.
        polygons: usize,
    },
    /// Normals that are no three finite numbers: ignored.
    BadNormals {
        /// How many normals.
        normals: usize,
    },
    /// Polygons whose outline crosses itself so that its parts cancel out: left out.
    CrossedLeftOut {
        /// How many polygons.
        polygons: usize,
    },
    /// Statements of a text, or elements of a mesh, that are not known: ignored.
    UnknownStatements {
        /// How many statements.
        statements: usize,
        /// Their kinds in the order in which they first came, the first few only.
        kinds: Vec<String>,
    },
    /// Materials with gloss (MGF `rs`), which takes no part: the diffuse part was taken.
    GlossIgnored {
        /// How many materials.
        materials: usize,
    },
    /// Materials that let light through (MGF `td`, `ts`; glTF `KHR_materials_transmission`, less than half of it): taken as
    /// opaque.
    TransmissionIgnored {
        /// How many materials.
        materials: usize,
    },
    /// Colours that no mixture of red, green and blue gives: taken as the nearest, equally bright.
    ColoursOutOfGamut {
        /// How many materials.
        materials: usize,
    },
    /// Colours that are none (MGF `cxy` beyond 0 to 1, spectra without brightness): taken as the nearest, or as neutral.
    OddColours {
        /// How many.
        colours: usize,
    },
    /// Lamps that are farther away than ten times the scene's extent: they were meant in another unit.
    LampsFarAway {
        /// How many lamps.
        lamps: usize,
        /// The first of them.
        first: String,
        /// How far it is from the middle of the scene, in metres.
        distance_m: f64,
        /// The scene's extent, in metres.
        size_m: f64,
    },
    /// Polygons that cast no shadow, as was said: they are passed on in mean light, and neither block nor light anything.
    NoShadow {
        /// How many polygons.
        polygons: usize,
    },
    /// Materials that emit too little to light anything: their light is shown, and not cast.
    FaintNotCast {
        /// How many materials.
        materials: usize,
        /// All of their flux, as a share of the scene's.
        share_of_flux: f64,
    },
    /// Measured luminaires (MGF `ies`): left out; only surfaces give light.
    LuminairesIgnored {
        /// How many luminaires.
        luminaires: usize,
    },
    /// Spheres, cylinders, cones, rings and tori: cut into plane polygons.
    CurvesTessellated {
        /// How many shapes.
        shapes: usize,
        /// Into how many polygons.
        polygons: usize,
        /// Chords of a full circle.
        circle_segments: usize,
    },
    /// Contexts (MGF `xf`, `o`) that are never closed: taken to end with their file.
    UnclosedContexts {
        /// How many contexts.
        contexts: usize,
    },
    /// An extension that is not known: what it says was ignored.
    UnknownExtension {
        /// Its name.
        name: String,
        /// Whether the file says that it cannot be read rightly without it.
        required: bool,
    },
    /// Further unknown extensions.
    MoreUnknownExtensions {
        /// How many.
        more: usize,
    },
}

impl fmt::Display for Warning {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::PointsAndLines { primitives } => {
                write!(f, "{} of points or lines left out: they have no area", count(*primitives, "primitive"))
            }
            Self::LeftOverCorners { primitives } => {
                write!(f, "corners left over in {}: left out", count(*primitives, "primitive"))
            }
            Self::NoPositions { primitives } => {
                write!(f, "{} without positions left out", count(*primitives, "primitive"))
            }
            Self::ReflectanceCapped { materials, max_reflectance } => {
                write!(f, "reflectance capped at {max_reflectance} in {}", count(*materials, "material"))
            }
            Self::TexturesIgnored { uses, first } => {
                write!(f, "{} not used, the plain colours were taken: {first}", count(*uses, "texture"))
            }
            Self::VertexColoursAveraged { primitives } => {
                write!(f, "varying vertex colours averaged in {}", count(*primitives, "primitive"))
            }
            Self::AlphaIgnored { materials } => {
                write!(f, "{} cut out or half transparent: light is blocked as a whole", count(*materials, "material"))
            }
            Self::SkinsAtRest { nodes } => write!(f, "{} with a skin taken in rest pose", count(*nodes, "node")),
            Self::MorphTargetsAtRest { primitives } => {
                write!(f, "morph targets of {} taken as the file's weights state", count(*primitives, "primitive"))
            }
            Self::LampsFromBlender { lamps } => write!(
                f,
                "{} perhaps 683 times too bright beside the surfaces that emit: Blender multiplies lamps alone by 683 lm/W; \
                 --lamp-units lumens takes that off",
                count(*lamps, "lamp")
            ),
            Self::CamerasLeftOut { cameras } => {
                write!(f, "{} left out: broken, or without size", count(*cameras, "camera"))
            }
            Self::BlendedPassedOn { polygons } => write!(
                f,
                "light passes through {} with alphaMode BLEND; they are shown in mean light",
                count(*polygons, "polygon")
            ),
            Self::GlassPassedOn { polygons } => write!(
                f,
                "light passes unchanged through {} of glass (KHR_materials_transmission, or d of a half and less); they are shown in mean light",
                count(*polygons, "polygon")
            ),
            Self::AnimationsIgnored { animations } => {
                write!(f, "{} ignored: nodes taken as they stand", count(*animations, "animation"))
            }
            Self::NodesOutsideScene { nodes } => {
                write!(f, "{} outside the default scene left out", count(*nodes, "node"))
            }
            Self::TransparentLeftOut { polygons } => {
                write!(f, "{} left out: transparent, blocking nothing", count(*polygons, "polygon"))
            }
            Self::HiddenLeftOut { nodes } => {
                write!(f, "{} hidden by KHR_node_visibility left out, lamps on them included", count(*nodes, "node"))
            }
            Self::LampsMended { lamps, first } => {
                write!(f, "{} that no lamp can have mended; the first lamp is {first}", count(*lamps, "value"))
            }
            Self::MoreUnknownExtensions { more } => {
                write!(f, "{} more are not known and ignored", count(*more, "extension"))
            }
            Self::TooFewCorners { polygons } => {
                write!(f, "{} with fewer than three corners left out", count(*polygons, "polygon"))
            }
            Self::WithoutMaterial { polygons } => {
                write!(f, "{} without a material: taken as grey, by the name default", count(*polygons, "polygon"))
            }
            Self::MaterialsMissing { materials, first } => {
                let first = crate::text::shortened(first);
                write!(f, "{} defined nowhere, the first {first:?}: taken as grey", count(*materials, "material"))
            }
            Self::MaterialLibraryMissing { library, why, replaced_by } => {
                write!(f, "material library {library:?} {why}: ")?;
                match replaced_by {
                    Some(other) => write!(f, "{other:?} was read instead"),
                    None => write!(f, "put it beside the scene"),
                }
            }
            Self::MoreLibrariesMissing { libraries } => {
                let libraries = count(*libraries, "more material library|more material libraries");
                write!(f, "{libraries} could not be read either")
            }
            Self::ColoursUnderImages { polygons } => {
                write!(f, "colours of the corners of {} not used: an image is on them", count(*polygons, "polygon"))
            }
            Self::BadNormals { normals } => {
                write!(f, "{} ignored: not three finite numbers", count(*normals, "normal"))
            }
            Self::CrossedLeftOut { polygons } => write!(
                f,
                "{} left out: their outlines cross themselves, as in a bow-tie (exchange two neighbouring corners)",
                count(*polygons, "polygon")
            ),
            Self::UnknownStatements { statements, kinds } => {
                write!(f, "{} ignored: {}", count(*statements, "unknown statement"), kinds.join(", "))
            }
            Self::GlossIgnored { materials } => {
                write!(f, "gloss ignored in {}: the diffuse part was taken", count(*materials, "material"))
            }
            Self::TransmissionIgnored { materials } => {
                write!(f, "light passes through {}: taken as opaque", count(*materials, "material"))
            }
            Self::ColoursOutOfGamut { materials } => {
                write!(f, "colours of {} cannot be had from red, green and blue: taken as the nearest", {
                    count(*materials, "material")
                })
            }
            Self::OddColours { colours } => {
                write!(f, "{} that no light can have: taken as the nearest, or as neutral", count(*colours, "colour"))
            }
            Self::LampsFarAway { lamps, first, distance_m, size_m } => write!(
                f,
                "{} far away from the scene, which is {size_m:.3} m across; the first is {first:?}, {distance_m:.3} m from its middle. \
                 Positions of lamps are in metres, unless the TOML says lamp_unit = \"file\"",
                count(*lamps, "lamp")
            ),
            Self::NoShadow { polygons } => write!(
                f,
                "{} cast no shadow, as was asked for: light passes through, they are shown in mean light and light nothing",
                count(*polygons, "polygon")
            ),
            Self::FaintNotCast { materials, share_of_flux } => write!(
                f,
                "the faint light of {}, {:.2} % of all, is shown and not cast; --emit or the TOML says which are to cast theirs",
                count(*materials, "material"),
                100.0 * share_of_flux
            ),
            Self::LuminairesIgnored { luminaires } => {
                write!(f, "{} left out: only surfaces give light", count(*luminaires, "measured luminaire"))
            }
            Self::CurvesTessellated { shapes, polygons, circle_segments } => write!(
                f,
                "{} cut into {}, {circle_segments} to a circle",
                count(*shapes, "curved shape"),
                count(*polygons, "plane polygon")
            ),
            Self::UnclosedContexts { contexts } => {
                write!(f, "{} never closed: taken to end with the file", count(*contexts, "context"))
            }
            Self::UnknownExtension { name, required: true } => {
                write!(f, "extension {name} is not known and ignored, though the file requires it: check the result")
            }
            Self::UnknownExtension { name, required: false } => write!(f, "extension {name} is not known and ignored"),
        }
    }
}

/// `1 node`, `2 nodes`; a plural that is more than an `s` stands after a bar.
fn count(n: usize, noun: &str) -> String {
    match (n, noun.split_once('|')) {
        (1, Some((one, _))) => format!("1 {one}"),
        (1, None) => format!("1 {noun}"),
        (_, Some((_, many))) => format!("{n} {many}"),
        (_, None) => format!("{n} {noun}s"),
    }
}

/// Kinds of unknown statements that a warning names.
const NAMED_KINDS: usize = 8;

/// Counts unknown statements.
#[derive(Debug, Default)]
pub(crate) struct Unknown {
    statements: usize,
    kinds: Vec<String>,
}

impl Unknown {
    /// One more of a kind.
    pub(crate) fn add(&mut self, kind: &str) {
        self.statements += 1;
        if self.kinds.len() < NAMED_KINDS {
            let kind = crate::text::shortened(kind);
            if !self.kinds.contains(&kind) {
                self.kinds.push(kind);
            }
        }
    }

    /// The warning, if there were any.
    pub(crate) fn warning(self) -> Option<Warning> {
        let Self { statements, kinds } = self;
        (statements > 0).then_some(Warning::UnknownStatements { statements, kinds })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_message_names_the_extension() {
        let glass = Warning::GlassPassedOn { polygons: 2 }.to_string();
        assert!(glass.contains("2 polygons of glass (KHR_materials_transmission"), "{glass}");
    }

    #[test]
    fn a_message_counts() {
        assert_eq!(Warning::SkinsAtRest { nodes: 1 }.to_string(), "1 node with a skin taken in rest pose");
        let textures = Warning::TexturesIgnored { uses: 3, first: "image 2: broken".into() }.to_string();
        assert!(textures.starts_with("3 textures not used") && textures.ends_with("image 2: broken"), "{textures}");
    }
}
