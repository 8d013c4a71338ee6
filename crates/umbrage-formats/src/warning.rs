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
    /// Textures that are not used yet: the plain factors were taken.
    TexturesIgnored {
        /// How many uses of a texture in materials.
        uses: usize,
    },
    /// Vertex colours other than white, which are not used yet.
    VertexColoursIgnored {
        /// How many primitives.
        primitives: usize,
    },
    /// Materials with `alphaMode` MASK or BLEND: taken as opaque.
    AlphaIgnored {
        /// How many materials.
        materials: usize,
    },
    /// Skinned meshes: taken in rest pose.
    SkinsAtRest {
        /// How many nodes.
        nodes: usize,
    },
    /// Primitives with morph targets: taken without them.
    MorphTargetsIgnored {
        /// How many primitives.
        primitives: usize,
    },
    /// Punctual lights (`KHR_lights_punctual`): left out; only surfaces give light.
    PunctualLightsIgnored {
        /// How many nodes.
        nodes: usize,
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
    /// An extension that is not known: what it says was ignored.
    UnknownExtension {
        /// Its name.
        name: String,
        /// Whether the file says that it cannot be read rightly without it.
        required: bool,
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
            Self::TexturesIgnored { uses } => {
                write!(f, "{} not used yet: the plain factors were taken", count(*uses, "texture"))
            }
            Self::VertexColoursIgnored { primitives } => {
                write!(f, "vertex colours not used yet in {}", count(*primitives, "primitive"))
            }
            Self::AlphaIgnored { materials } => {
                write!(f, "transparency ignored in {}: taken as opaque", count(*materials, "material"))
            }
            Self::SkinsAtRest { nodes } => write!(f, "{} with a skin taken in rest pose", count(*nodes, "node")),
            Self::MorphTargetsIgnored { primitives } => {
                write!(f, "morph targets ignored in {}", count(*primitives, "primitive"))
            }
            Self::PunctualLightsIgnored { nodes } => {
                write!(f, "{} ignored: only surfaces give light", count(*nodes, "punctual light"))
            }
            Self::AnimationsIgnored { animations } => {
                write!(f, "{} ignored: nodes taken as they stand", count(*animations, "animation"))
            }
            Self::NodesOutsideScene { nodes } => {
                write!(f, "{} outside the default scene left out", count(*nodes, "node"))
            }
            Self::UnknownExtension { name, required: true } => {
                write!(f, "extension {name} is not known and ignored, though the file requires it: check the result")
            }
            Self::UnknownExtension { name, required: false } => write!(f, "extension {name} is not known and ignored"),
        }
    }
}

/// `1 node`, `2 nodes`.
fn count(n: usize, noun: &str) -> String {
    if n == 1 { format!("1 {noun}") } else { format!("{n} {noun}s") }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_message_counts() {
        assert_eq!(Warning::SkinsAtRest { nodes: 1 }.to_string(), "1 node with a skin taken in rest pose");
        assert!(Warning::TexturesIgnored { uses: 3 }.to_string().starts_with("3 textures not used"));
    }
}
