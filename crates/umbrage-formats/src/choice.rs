//! Which nodes of a scene are baked; the others only take part in the light.
//!
//! A name means all nodes of that name, or that show a mesh of that name, with all that hangs below them. A name that the
//! scene has not is an error, which names the most similar one.

use umbrage::id::{NodeId, Table};
use umbrage::scene::Scene;

use crate::FormatError;
use crate::similar::alike;
use crate::text::shortened;

/// What a message calls the options of a command.
const OPTIONS: &str = "the options";

/// Leaves in what is baked the nodes called `only`, all if there is no such name, but for those called `skip`. The others block,
/// reflect and emit as before.
///
/// # Errors
/// [`FormatError::UnknownNode`] and [`FormatError::NothingChosen`]; the scene is then as it was.
pub fn choose_nodes(scene: &mut Scene, only: &[String], skip: &[String]) -> Result<(), FormatError> {
    let kept = if only.is_empty() { vec![true; scene.nodes.len()].into() } else { below(scene, only, OPTIONS)? };
    let skipped = below(scene, skip, OPTIONS)?;
    let is_baked = |node: NodeId| kept[node] && !skipped[node];
    if !scene.surfaces.iter().any(|surface| !surface.polygons.is_empty() && surface.baked && is_baked(surface.node)) {
        return Err(FormatError::NothingChosen { file: OPTIONS.to_owned() });
    }
    scene.surfaces.iter_mut().for_each(|surface| surface.baked &= is_baked(surface.node));
    scene.see_through.retain(|surface| is_baked(surface.node));
    Ok(())
}

/// Which nodes have one of these names, or hang below one that has; `from` names who says so, for the error.
pub(crate) fn below(scene: &Scene, names: &[String], from: &str) -> Result<Table<NodeId, bool>, FormatError> {
    let names_of = |node: NodeId| [&scene.nodes[node].name, &scene.nodes[node].mesh_name].into_iter().flatten();
    let mut found = vec![false; names.len()];
    let mut below: Table<NodeId, bool> = Table::with_capacity(scene.nodes.len());
    for (id, node) in scene.nodes.iter_enumerated() {
        let mut named = false;
        for (name, found) in names.iter().zip(&mut found) {
            let is_it = names_of(id).any(|own| own == name);
            *found |= is_it;
            named |= is_it;
        }
        below.push(named || node.parent.is_some_and(|parent| below[parent]));
    }
    let missing = names.iter().zip(found).find(|(_, found)| !found);
    missing.map_or(Ok(below), |(name, _)| {
        let (like, known) = alike(name, scene.nodes.keys().flat_map(names_of).map(String::as_str));
        Err(FormatError::UnknownNode { file: from.to_owned(), name: shortened(name), like, known })
    })
}

#[cfg(test)]
mod tests {
    use umbrage::id::SurfaceId;
    use umbrage::scene::cornell::cornell_box;
    use umbrage::scene::{Node, Surface};

    use super::*;

    /// The box, whose red wall hangs as `wall` below `house`, and the light as `bulb` below that.
    fn house() -> Scene {
        let mut scene = cornell_box();
        let named = |name: &str, parent: usize| Node {
            name: Some(name.into()),
            parent: Some(parent.into()),
            ..Node::default()
        };
        scene.nodes.extend([named("house", 0), named("wall", 1)]);
        scene.nodes.push(Node {
            name: None,
            mesh_name: Some("bulb".into()),
            parent: Some(2.into()),
            ..Node::default()
        });
        scene.surfaces[SurfaceId::from(1)].node = NodeId::from(2);
        scene.surfaces[SurfaceId::from(3)].node = NodeId::from(3);
        let glass = Surface { polygons: vec![vec![0, 1, 2]], ..scene.surfaces[SurfaceId::from(1)].clone() };
        scene.see_through.push(glass);
        scene
    }

    fn chosen(only: &[&str], skip: &[&str]) -> Result<(Vec<bool>, usize), FormatError> {
        let mut scene = house();
        let own = |names: &[&str]| names.iter().map(|&name| name.to_owned()).collect::<Vec<_>>();
        choose_nodes(&mut scene, &own(only), &own(skip))?;
        Ok((scene.surfaces.iter().map(|surface| surface.baked).collect(), scene.see_through.len()))
    }

    #[test]
    fn what_hangs_below_goes_along() {
        assert_eq!(chosen(&[], &[]).unwrap(), (vec![true; 4], 1));
        assert_eq!(chosen(&["house"], &[]).unwrap(), (vec![false, true, false, true], 1));
        assert_eq!(chosen(&["cornell"], &["wall"]).unwrap(), (vec![true, false, true, false], 0));
        assert_eq!(chosen(&["wall"], &["bulb"]).unwrap(), (vec![false, true, false, false], 1));
    }

    #[test]
    fn bad_names_and_empty_choices_are_refused() {
        let message = chosen(&[], &["hause"]).unwrap_err().to_string();
        for words in ["\"hause\"", "perhaps \"house\"", "\"bulb\""] {
            assert!(message.contains(words), "no {words} in: {message}");
        }
        assert!(matches!(chosen(&["wall"], &["house"]), Err(FormatError::NothingChosen { .. })));
    }
}
