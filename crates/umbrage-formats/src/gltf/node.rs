//! The node hierarchy: which nodes the scene shows, in what order, and where they stand in the world.
//!
//! glTF demands a forest: a node with two parents or among its own descendants is refused, so every node is met at
//! most once and the walk ends. Transforms multiply in `f64`.

use glam::{DAffine3, DMat3, DMat4, DQuat, DVec3};

use super::accessor::{Accessor, Component};
use super::document::{Document, List};
use super::item::Item;
use super::tally::Tally;
use crate::FormatError;

/// Deeper hierarchies are refused: nobody makes them, and what reads the result may recurse.
const MAX_DEPTH: usize = 512;

/// A node of the scene, in the world.
#[derive(Clone, Debug)]
pub(super) struct Placed<'a> {
    pub(super) item: Item<'a>,
    /// Position of its parent in the list of placed nodes, always before it.
    pub(super) parent: Option<usize>,
    /// From its own space to the world, metres.
    pub(super) world: DAffine3,
    /// The rotations alone, without any scale; unknown where a matrix has no axes.
    pub(super) turned: Option<DMat3>,
    /// Its number in the file.
    pub(super) number: usize,
    /// Whether it and all above it are visible (`KHR_node_visibility`).
    pub(super) visible: bool,
}

/// The nodes of the default scene, parents before children; of all roots if the file has no scene.
pub(super) fn hierarchy<'a>(document: &'a Document, tally: &mut Tally) -> Result<Vec<Placed<'a>>, FormatError> {
    let count = document.count(List::Nodes)?;
    let mut parents = vec![None; count];
    for node in 0..count {
        let item = document.item(List::Nodes, node, "the document")?;
        for child in item.wholes("children")? {
            let named = document.item(List::Nodes, child, &item.place)?;
            if let Some(other) = parents[child].replace(node) {
                let what = format!("is a child of both node {other} and node {node}");
                return Err(refused(&named, what));
            }
        }
    }

    let roots = roots(document, &parents)?;
    let mut seen = vec![false; count];
    let mut placed: Vec<Placed<'a>> = Vec::new();
    let mut stack: Vec<_> = roots.into_iter().rev().map(|root| (root, None, 0)).collect();
    while let Some((node, parent, depth)) = stack.pop() {
        let item = document.item(List::Nodes, node, "the scene")?;
        if std::mem::replace(&mut seen[node], true) {
            return Err(refused(&item, "occurs twice in the scene, or is its own ancestor"));
        }
        if depth >= MAX_DEPTH {
            return Err(refused(&item, format!("is more than {MAX_DEPTH} levels deep")));
        }
        let local = transform(&item)?;
        let above = parent.map(|parent: usize| &placed[parent]);
        let world = above.map_or(local, |above| above.world * local);
        let turned = axes(&item, &local)?;
        let turned = above.map_or(Some(DMat3::IDENTITY), |above| above.turned).and_then(|above| Some(above * turned?));
        let visible = above.is_none_or(|above| above.visible) && is_visible(&item)?;
        if !world.is_finite() {
            return Err(refused(&item, "its transform is not finite"));
        }
        let children = item.wholes("children")?;
        stack.extend(children.into_iter().rev().map(|child| (child, Some(placed.len()), depth + 1)));
        placed.push(Placed { item, parent, world, turned, number: node, visible });
    }
    // A cycle hangs from no root, so the walk from the roots does not meet it.
    if let Some(node) = cycle(&seen, &parents) {
        return Err(refused(&document.item(List::Nodes, node, "the document")?, "is its own ancestor"));
    }
    tally.nodes_outside = seen.iter().filter(|&&seen| !seen).count();
    Ok(placed)
}

/// The roots of the default scene; without any scene, all nodes without a parent.
fn roots(document: &Document, parents: &[Option<usize>]) -> Result<Vec<usize>, FormatError> {
    let scene = document.root()?.whole("scene")?;
    if scene.is_none() && document.count(List::Scenes)? == 0 {
        return Ok((0..parents.len()).filter(|&node| parents[node].is_none()).collect());
    }
    document.item(List::Scenes, scene.unwrap_or(0), "the document")?.wholes("nodes")
}

/// A node in a cycle among the nodes that the scene does not show.
fn cycle(seen: &[bool], parents: &[Option<usize>]) -> Option<usize> {
    let mut climbed_from = vec![None; parents.len()];
    for start in (0..parents.len()).filter(|&node| !seen[node]) {
        let mut at = Some(start);
        while let Some(node) = at {
            match climbed_from[node] {
                Some(other) if other == start => return Some(node),
                Some(_) => break,
                None => climbed_from[node] = Some(start),
            }
            at = parents[node];
        }
    }
    None
}

/// A node's own transform: a matrix, or scale, then rotation, then translation.
fn transform(node: &Item<'_>) -> Result<DAffine3, FormatError> {
    if let Some(columns) = node.numbers::<16>("matrix")? {
        let matrix = DMat4::from_cols_array(&columns);
        return Ok(DAffine3::from_mat3_translation(DMat3::from_mat4(matrix), matrix.w_axis.truncate()));
    }
    let vector = |key| Ok(node.numbers::<3>(key)?.map(DVec3::from));
    let rotation = match node.numbers::<4>("rotation")? {
        Some(rotation) => turn(rotation).ok_or_else(|| node.bad("rotation", "is no quaternion: it has no length"))?,
        None => DQuat::IDENTITY,
    };
    Ok(DAffine3::from_scale_rotation_translation(
        vector("scale")?.unwrap_or(DVec3::ONE),
        rotation,
        vector("translation")?.unwrap_or(DVec3::ZERO),
    ))
}

/// A node's own rotation: its quaternion, or the directions of its matrix' axes, if these have any.
fn axes(node: &Item<'_>, local: &DAffine3) -> Result<Option<DMat3>, FormatError> {
    if node.get("matrix").is_none() {
        let rotation = node.numbers::<4>("rotation")?;
        return Ok(rotation.map_or(Some(DQuat::IDENTITY), turn).map(DMat3::from_quat));
    }
    let DMat3 { x_axis, y_axis, z_axis } = local.matrix3;
    let axes = [x_axis, y_axis, z_axis].map(DVec3::try_normalize);
    Ok(match axes {
        [Some(x), Some(y), Some(z)] => Some(DMat3::from_cols(x, y, z)),
        _ => None,
    })
}

/// Whether a node shows itself and what hangs below it, by `KHR_node_visibility`.
fn is_visible(node: &Item<'_>) -> Result<bool, FormatError> {
    let Some(extension) = node.extension("KHR_node_visibility")? else { return Ok(true) };
    Ok(extension.get("visible").is_none() || extension.flag("visible")?)
}

/// A unit quaternion from one that rounding or a careless exporter left unnormalized.
fn turn(rotation: [f64; 4]) -> Option<DQuat> {
    let quaternion = DQuat::from_array(rotation);
    let length = quaternion.length();
    (length.is_finite() && length > 0.0).then(|| quaternion / length)
}

/// The transforms of `EXT_mesh_gpu_instancing`, each to be applied before the node's own; `None` without it.
pub(super) fn instances(
    document: &Document,
    node: &Item<'_>,
    tally: &mut Tally,
) -> Result<Option<Vec<DAffine3>>, FormatError> {
    let Some(extension) = node.extension("EXT_mesh_gpu_instancing")? else { return Ok(None) };
    let Some(attributes) = extension.child("attributes")? else { return Ok(None) };
    let open = |key: &str, width: usize| -> Result<Option<Accessor<'_>>, FormatError> {
        let Some(index) = attributes.whole(key)? else { return Ok(None) };
        let user = format!("{}, {key}", node.place);
        let types = [Component::F32, Component::I8, Component::I16];
        Accessor::open(document, index, &user, &[width], &types).map(Some)
    };
    let (shift, turned, scale) = (open("TRANSLATION", 3)?, open("ROTATION", 4)?, open("SCALE", 3)?);
    let given = || [&shift, &turned, &scale].into_iter().flatten();
    let Some(count) = given().map(|a| a.count).min() else { return Ok(None) };
    tally.unfold(given().map(Accessor::sparse_count).fold(count, usize::saturating_add), document, &node.place)?;
    let one = |i: usize| {
        let vector = |a: &Option<Accessor<'_>>, default| a.as_ref().map_or(default, |a| a.element::<3>(i, 0.0).into());
        let rotation = turned.as_ref().map_or(Some(DQuat::IDENTITY), |a| turn(a.element::<4>(i, 0.0)));
        let rotation = rotation.ok_or_else(|| extension.bad("ROTATION", format!("of instance {i} has no length")))?;
        let transform = DAffine3::from_scale_rotation_translation(
            vector(&scale, DVec3::ONE),
            rotation,
            vector(&shift, DVec3::ZERO),
        );
        if !transform.is_finite() {
            return Err(refused(node, format!("the transform of instance {i} is not finite")));
        }
        Ok(transform)
    };
    (0..count).map(one).collect::<Result<_, _>>().map(Some)
}

/// What turns normals with a surface: the inverse transpose, up to a positive factor.
pub(super) fn normal_matrix(world: &DAffine3) -> DMat3 {
    let m = world.matrix3;
    let cofactors = DMat3::from_cols(m.y_axis.cross(m.z_axis), m.z_axis.cross(m.x_axis), m.x_axis.cross(m.y_axis));
    if m.determinant() < 0.0 { cofactors * -1.0 } else { cofactors }
}

fn refused(node: &Item<'_>, what: impl Into<String>) -> FormatError {
    FormatError::BadHierarchy { file: node.file.to_owned(), place: node.place.clone(), what: what.into() }
}
