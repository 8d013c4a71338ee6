//! Morph targets at rest: meshes as they stand at the weights that the file states, which is how every viewer shows them before
//! an animation begins.
//!
//! Source: glTF 2.0, section 3.7.2.2. Of the targets, the positions and the normals count.

use glam::DVec3;

use super::accessor::{Accessor, Component};
use super::document::Document;
use super::item::Item;
use super::tally::Tally;
use crate::FormatError;

/// Types of displacements, with `KHR_mesh_quantization`.
const DISPLACEMENTS: [Component; 3] = [Component::F32, Component::I8, Component::I16];

/// The weights of a mesh's targets where a node shows it: the node's, else the mesh's.
pub(super) fn weights(node: &Item<'_>, mesh: &Item<'_>) -> Result<Vec<f64>, FormatError> {
    let holder = if node.get("weights").is_some() { node } else { mesh };
    let finite = |weight: &serde_json::Value| weight.as_f64().filter(|weight| weight.is_finite());
    let weights = holder.list("weights")?.iter().map(finite).collect::<Option<_>>();
    weights.ok_or_else(|| holder.bad("weights", "should be finite numbers"))
}

/// What targets of one weight each add to the vertices of a primitive.
#[derive(Debug, Default)]
pub(super) struct Displacements<'a>(Vec<(f64, Accessor<'a>)>);

impl<'a> Displacements<'a> {
    /// Those of an attribute; targets of weight 0, or without it, add nothing.
    pub(super) fn of(
        document: &'a Document,
        primitive: &Item<'_>,
        (place, attribute): (&str, &str),
        weights: &[f64],
        tally: &mut Tally,
    ) -> Result<Self, FormatError> {
        let mut all = Vec::new();
        if weights.iter().all(|&weight| weight == 0.0) || primitive.get("targets").is_none() {
            return Ok(Self(all));
        }
        for (target, &weight) in primitive.children("targets", "target")?.zip(weights) {
            let Some(index) = target?.whole(attribute)?.filter(|_| weight != 0.0) else { continue };
            let user = format!("{place}, {attribute} of a target");
            let accessor = Accessor::open(document, index, &user, &[3], &DISPLACEMENTS)?;
            // Each is looked at for every vertex.
            tally.unfold(accessor.count + accessor.sparse_count(), document, place)?;
            all.push((weight, accessor));
        }
        Ok(Self(all))
    }

    /// What they add to a vertex.
    pub(super) fn at(&self, vertex: usize) -> DVec3 {
        let known = self.0.iter().filter(|(_, accessor)| vertex < accessor.count);
        known.map(|(weight, accessor)| *weight * DVec3::from(accessor.element::<3>(vertex, 0.0))).sum()
    }
}
