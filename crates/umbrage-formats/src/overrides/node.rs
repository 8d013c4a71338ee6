//! What is said of nodes, and which surfaces cast no shadow.
//!
//! A name means all nodes of that name, or that show a mesh of that name, with all that hangs below them. A surface that casts no shadow
//! takes no part in the light, as glass: it is passed on, and shown in mean light, or as it shines where it emits.

use std::collections::BTreeMap;

use toml::Value;
use umbrage::id::{MaterialId, NodeId, Table};
use umbrage::scene::{Material, Rgb, Scene, Surface};

use super::{Change, Override, bad, check, colour, unknown_key};
use crate::choice::below;
use crate::{FormatError, Warning};

/// A change to what hangs below the nodes of one name.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum NodeChange {
    Emission(Rgb),
    CastsShadow(bool),
}

/// Changes to nodes, in the order in which they are made: who says it, of which name, and what.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct NodeChanges(Vec<(String, String, NodeChange)>);

impl NodeChanges {
    pub(super) fn push(&mut self, from: &str, node: String, change: NodeChange) {
        self.0.push((from.to_owned(), node, change));
    }

    pub(super) fn extend(&mut self, later: Self) {
        self.0.extend(later.0);
    }

    pub(super) fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    /// Adds what a table of the TOML says of a node.
    pub(super) fn read(&mut self, file: &str, node: &str, value: &Value) -> Result<(), FormatError> {
        let place = format!("nodes.{node}");
        let Value::Table(properties) = value else { return Err(bad(file, place, "is not a table".into())) };
        for (key, value) in properties {
            let refuse = |what: String| bad(file, format!("{place}.{key}"), what);
            let change = match (key.as_str(), value) {
                ("emission", value) => {
                    let what = "is neither a number nor a list of three";
                    let emission = colour(value).ok_or_else(|| refuse(what.into()))?;
                    check(emission).map_err(refuse)?;
                    NodeChange::Emission(emission)
                }
                ("casts_shadow", Value::Boolean(casts_shadow)) => NodeChange::CastsShadow(*casts_shadow),
                ("casts_shadow", _) => return Err(refuse("is neither true nor false".into())),
                _ => return Err(refuse(unknown_key(key, &["emission", "casts_shadow"]))),
            };
            self.push(file, node.to_owned(), change);
        }
        Ok(())
    }

    /// Changes what the nodes show, and takes what casts no shadow, by `materials` or by node, out of the light.
    ///
    /// # Errors
    /// [`FormatError::UnknownNode`].
    pub(super) fn change(&self, scene: &mut Scene, materials: &[Override]) -> Result<Option<Warning>, FormatError> {
        let mut casts: BTreeMap<&str, bool> = BTreeMap::new();
        for change in materials {
            if let Change::CastsShadow(casts_shadow) = change.change {
                casts.insert(&change.material, casts_shadow);
            }
        }
        let mut by_node: Table<NodeId, Option<bool>> = scene.nodes.iter().map(|_| None).collect();
        for (from, name, change) in &self.0 {
            let found = below(scene, std::slice::from_ref(name), from)?;
            match *change {
                NodeChange::Emission(radiance) => emit(scene, radiance, |surface| found[surface.node]),
                NodeChange::CastsShadow(casts_shadow) => {
                    let nodes = by_node.iter_mut().zip(&found).filter(|(_, found)| **found);
                    nodes.for_each(|(by_node, _)| *by_node = Some(casts_shadow));
                }
            }
        }
        let casts_shadow = |surface: &Surface| {
            let by_material = casts.get(scene.materials[surface.material].name.as_str()).copied();
            by_node[surface.node].or(by_material).unwrap_or(true)
        };
        if casts.values().all(|casts| *casts) && by_node.iter().all(|casts| casts.unwrap_or(true)) {
            return Ok(None);
        }
        let surfaces = std::mem::take(&mut scene.surfaces);
        let (solid, passing): (Vec<_>, Vec<_>) = surfaces.into_iter().partition(|surface| casts_shadow(surface));
        let polygons = passing.iter().map(|surface| surface.polygons.len()).sum();
        scene.surfaces = solid.into_iter().collect();
        scene.see_through.extend(passing);
        Ok((polygons > 0).then_some(Warning::NoShadow { polygons }))
    }
}

/// Lets surfaces emit a radiance: their materials become others of the same name.
fn emit(scene: &mut Scene, radiance: Rgb, chosen: impl Fn(&Surface) -> bool) {
    let mut emitting: BTreeMap<MaterialId, MaterialId> = BTreeMap::new();
    for surface in scene.surfaces.iter_mut().filter(|surface| chosen(surface)) {
        let materials = &mut scene.materials;
        surface.material = *emitting.entry(surface.material).or_insert_with(|| {
            materials.push_and_get_key(Material { radiance, ..materials[surface.material].clone() })
        });
    }
}

#[cfg(test)]
mod tests {
    use umbrage::scene::cornell::cornell_box;

    use super::super::Overrides;
    use super::*;

    #[test]
    fn nodes_are_lit_and_taken_out_of_the_light_by_name() {
        let mut scene = cornell_box();
        let node = |name: &str| umbrage::scene::Node { name: Some(name.into()), ..Default::default() };
        let wall = scene.nodes.push_and_get_key(node("wall"));
        let red = scene.surfaces.raw[1].material;
        scene.surfaces.raw[1].node = wall;
        let before = scene.clone();
        let text = "[nodes.wall]\nemission = 3\n[materials.green]\ncasts_shadow = false\n";
        let warnings = Overrides::parse("a.toml", text).unwrap().apply(&mut scene, 0.9).unwrap();
        let green = &before.surfaces.raw[2];
        assert_eq!(warnings, [Warning::NoShadow { polygons: green.polygons.len() }]);
        assert_eq!((scene.see_through.len(), scene.surfaces.len()), (1, before.surfaces.len() - 1));
        let lit = &scene.materials[scene.surfaces.raw[1].material];
        assert_eq!((lit.radiance, &lit.name), (Rgb::splat(3.0), &before.materials[red].name));
        assert_eq!(scene.materials[red].radiance, Rgb::ZERO);

        let mut scene = before.clone();
        let mut overrides = Overrides::default();
        overrides.cast_no_shadow("wall".into());
        assert!(matches!(overrides.apply(&mut scene, 0.9).unwrap()[..], [Warning::NoShadow { .. }]));
        assert_eq!(scene.see_through[0].node, wall);
        let mut overrides = Overrides::default();
        overrides.cast_no_shadow("wal".into());
        let message = overrides.apply(&mut before.clone(), 0.9).unwrap_err().to_string();
        assert!(message.contains("perhaps \"wall\" is meant"), "{message}");
    }
}
