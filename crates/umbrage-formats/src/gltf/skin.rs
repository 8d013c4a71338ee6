//! Skinned meshes, in the pose that their joints have in the file.
//!
//! The transform of a node that shows a skinned mesh is ignored: each vertex goes where its joints take it, `sum of w_i (world of
//! joint_i) (inverse bind matrix_i)`. A skin whose joints are not in the scene stays in rest pose, under its node.
//!
//! Source: glTF 2.0, section 3.7.3.

use glam::{DAffine3, DMat3, DMat4, DVec3};

use super::accessor::{Accessor, Component};
use super::document::Document;
use super::item::Item;
use super::node::Placed;
use super::tally::Tally;
use crate::FormatError;

/// Types of joints, and of weights.
const JOINTS: [Component; 2] = [Component::U8, Component::U16];
const WEIGHTS: [Component; 3] = [Component::F32, Component::U8, Component::U16];
/// Joints of a set of a vertex.
const JOINTS_PER_SET: usize = 4;

/// Where the nodes of the scene are, by their numbers in the file.
pub(super) fn worlds(placed: &[Placed<'_>], nodes: usize) -> Vec<Option<DAffine3>> {
    let mut worlds = vec![None; nodes];
    for node in placed {
        worlds[node.number] = Some(node.world);
    }
    worlds
}

/// What takes vertices to the world.
#[derive(Clone, Debug)]
pub(super) enum Pose {
    /// The transform of the node.
    Rigid(DAffine3),
    /// From bind pose to the world, for each joint.
    Skinned(Vec<DAffine3>),
}

impl Pose {
    /// That of a node's mesh; counts skins that stay at rest.
    pub(super) fn of_node(
        document: &Document,
        placed: &Placed<'_>,
        worlds: &[Option<DAffine3>],
        tally: &mut Tally,
    ) -> Result<Self, FormatError> {
        let Some(skin) = placed.item.whole("skin")? else { return Ok(Self::Rigid(placed.world)) };
        let skins = document.root()?.list("skins")?;
        let Some(skin) = skins.get(skin) else {
            tally.skinned_nodes += 1;
            return Ok(Self::Rigid(placed.world));
        };
        let skin = Item::named(&document.file, format!("{}, skin", placed.item.place), skin)?;
        let joints = skin.wholes("joints")?;
        tally.unfold(joints.len(), document, &skin.place)?;
        let binds = match skin.whole("inverseBindMatrices")? {
            Some(index) => {
                let user = format!("{}, inverseBindMatrices", skin.place);
                Some(Accessor::open(document, index, &user, &[16], &[Component::F32])?)
            }
            None => None,
        };
        let joint = |(number, joint): (usize, &usize)| {
            let world = (*worlds.get(*joint)?)?;
            let bind = binds.as_ref().filter(|binds| number < binds.count);
            let bind = bind.map(|binds| DMat4::from_cols_array(&binds.element::<16>(number, 0.0)));
            let bind = bind.map_or(DAffine3::IDENTITY, |m| {
                DAffine3::from_mat3_translation(DMat3::from_mat4(m), m.w_axis.truncate())
            });
            Some(world * bind).filter(|moved| moved.is_finite())
        };
        let posed: Option<Vec<DAffine3>> = joints.iter().enumerate().map(joint).collect();
        match posed.filter(|posed| !posed.is_empty()) {
            Some(posed) => Ok(Self::Skinned(posed)),
            None => {
                tally.skinned_nodes += 1;
                Ok(Self::Rigid(placed.world))
            }
        }
    }

    /// What takes the vertices of one primitive to the world.
    pub(super) fn of_primitive<'a>(
        &'a self,
        document: &'a Document,
        attributes: Option<&Item<'_>>,
        place: &str,
        tally: &mut Tally,
    ) -> Result<Placing<'a>, FormatError> {
        let joints = match self {
            Self::Rigid(world) => return Ok(Placing::Rigid(world)),
            Self::Skinned(joints) => joints,
        };
        let mut sets = Vec::new();
        while let Some(attributes) = attributes {
            let index = |kind: &str| attributes.whole(&format!("{kind}_{}", sets.len()));
            let (Some(joint), Some(weight)) = (index("JOINTS")?, index("WEIGHTS")?) else { break };
            let open = |index, kind: &str, types: &[Component]| {
                Accessor::open(document, index, &format!("{place}, {kind}_{}", sets.len()), &[JOINTS_PER_SET], types)
            };
            let set = (open(joint, "JOINTS", &JOINTS)?, open(weight, "WEIGHTS", &WEIGHTS)?);
            tally.unfold(set.0.count + set.1.count, document, place)?;
            sets.push(set);
        }
        Ok(Placing::Skinned { joints, sets })
    }
}

/// What takes the vertices of a primitive to the world.
#[derive(Debug)]
pub(super) enum Placing<'a> {
    /// All alike.
    Rigid(&'a DAffine3),
    /// Each by its joints.
    Skinned {
        /// From bind pose to the world.
        joints: &'a [DAffine3],
        /// Joints and weights of each vertex.
        sets: Vec<(Accessor<'a>, Accessor<'a>)>,
    },
}

impl Placing<'_> {
    /// What takes a vertex to the world: of a skin, the mean of its joints by weight, or the first joint where it has none.
    pub(super) fn at(&self, vertex: usize) -> DAffine3 {
        let (joints, sets) = match self {
            Self::Rigid(world) => return **world,
            Self::Skinned { joints, sets } => (joints, sets),
        };
        let (mut sum, mut total) = (DAffine3::ZERO, 0.0);
        for (numbers, weights) in sets.iter().filter(|set| vertex < set.0.count.min(set.1.count)) {
            let (numbers, weights) =
                (numbers.element::<JOINTS_PER_SET>(vertex, 0.0), weights.element::<JOINTS_PER_SET>(vertex, 0.0));
            for (number, weight) in numbers.into_iter().zip(weights) {
                // Numbers are small and whole.
                let joint = joints.get(number as usize).filter(|_| weight.is_finite() && weight > 0.0);
                if let Some(joint) = joint {
                    sum.matrix3 += weight * joint.matrix3;
                    sum.translation += weight * joint.translation;
                    total += weight;
                }
            }
        }
        if total > 0.0 {
            return DAffine3::from_mat3_translation(sum.matrix3 * (1.0 / total), sum.translation / total);
        }
        joints.first().copied().unwrap_or(DAffine3::IDENTITY)
    }

    /// Whether it turns fronts to backs; a skin does as its first joint does.
    pub(super) fn is_mirrored(&self) -> bool {
        let matrix = match self {
            Self::Rigid(world) => world.matrix3,
            Self::Skinned { joints, .. } => joints.first().map_or(DMat3::IDENTITY, |joint| joint.matrix3),
        };
        matrix.determinant() < 0.0
    }

    /// A point of a vertex, in the world.
    pub(super) fn point(&self, vertex: usize, local: DVec3) -> DVec3 {
        self.at(vertex).transform_point3(local)
    }
}
