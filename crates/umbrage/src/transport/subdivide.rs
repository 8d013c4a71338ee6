//! `subdivide` (paper, section 6): splits pairs of patches until the oracle lets them be linked, and links them.
//!
//! ```text
//! subdivide(patch p, patch q) {
//!     if (formfactor_estimate(p,q) > Fmax) {
//!         r=max(p, q);                     s=min(p, q);
//!         if (r too small)                 return;        // link
//!         else { split(r); subdivide(r.subpatch1, s); subdivide(r.subpatch2, s); }
//!     }                                                   // else link
//! }
//! ```
//!
//! A patch that holds a D0 split-hint is split first, whatever the oracle says, and takes no link ever after either: it
//! has a lit and a dark side, and a link would average them. (The paper removes D0 hints after linking; then light leaks
//! under walls.) Links stay at their nodes when another pair splits these further.
//!
//! All pairs of faces are subdivided first, one after the other, since that changes the mesh; then the links' form factors
//! are computed in parallel, each written at its own index.
//!
//! Before: no patch that held a D0 hint has been split yet.

use std::sync::atomic::{AtomicUsize, Ordering};

use rayon::prelude::*;

use super::link::{Links, Node, link_both_ways};
use super::oracle::{Decision, Oracle};
use crate::id::FaceId;
use crate::mesh::Mesh;
use crate::prepare::Prepared;
use crate::progress::{Cancelled, Progress, Stage};
use crate::visibility::Visibility;

/// So many links are computed between two reports of progress.
const LINKS_PER_REPORT: usize = 256;

/// Splits the mesh and links its patches.
///
/// # Errors
/// [`Cancelled`] where `progress` asks to stop; the mesh is then split in part.
pub fn link_all(
    prepared: &Prepared,
    visibility: &Visibility,
    mesh: &mut Mesh,
    oracle: &impl Oracle,
    progress: Progress<'_>,
) -> Result<Links, Cancelled> {
    let mut subdivision = Subdivision { mesh, oracle, divided_by_d0: Vec::new(), pairs: Vec::new() };
    let faces = prepared.faces.len();
    for p in 0..faces {
        progress.report(Stage::Transport, subdivision.pairs.len(), 0)?;
        for q in p + 1..faces {
            let [p, q] = [p, q].map(FaceId::from);
            if prepared.faces[p].plane != prepared.faces[q].plane {
                subdivision.subdivide(subdivision.mesh.root(p), subdivision.mesh.root(q));
            }
        }
    }
    let (pairs, mesh) = (subdivision.pairs, &*mesh);
    let done = AtomicUsize::new(0);
    let links: Vec<_> = pairs
        .par_iter()
        .map(|&pair| {
            let number = done.fetch_add(1, Ordering::Relaxed);
            if number.is_multiple_of(LINKS_PER_REPORT) {
                progress.report(Stage::Transport, number, pairs.len())?;
            }
            Ok(link_both_ways(prepared, visibility, mesh, pair))
        })
        .collect::<Result<_, Cancelled>>()?;
    let links = Links::new(links.into_iter().flatten().collect(), mesh.patch_count());
    tracing::debug!(pairs = pairs.len(), links = links.len(), patches = mesh.patch_count(), "linked");
    Ok(links)
}

struct Subdivision<'a, O> {
    mesh: &'a mut Mesh,
    oracle: &'a O,
    /// Whether a patch held a D0 hint when it was split.
    divided_by_d0: Vec<bool>,
    /// Pairs to be linked.
    pairs: Vec<[Node; 2]>,
}

impl<O: Oracle> Subdivision<'_, O> {
    fn subdivide(&mut self, p: Node, q: Node) {
        match self.oracle.decide(self.mesh, [p, q]) {
            Decision::Unseen => {}
            decision => {
                if self.split_by_d0(p) {
                    self.subdivide_parts(p, q);
                } else if self.split_by_d0(q) {
                    self.subdivide_parts(q, p);
                } else {
                    match decision {
                        Decision::Split(r) if self.mesh.split(r) => self.subdivide_parts(r, if r == p { q } else { p }),
                        _ => self.pairs.push([p, q]),
                    }
                }
            }
        }
    }

    fn subdivide_parts(&mut self, r: Node, s: Node) {
        for part in self.mesh.patch(r).subpatches.into_iter().flatten() {
            self.subdivide(part, s);
        }
    }

    /// Splits a patch that holds a D0 hint; true where it holds or held one and has parts.
    fn split_by_d0(&mut self, patch: Node) -> bool {
        if self.divided_by_d0.len() < self.mesh.patch_count() {
            self.divided_by_d0.resize(self.mesh.patch_count(), false);
        }
        let holds = self.mesh.has_d0_hint(patch);
        if holds && self.mesh.split(patch) {
            self.divided_by_d0[patch.index()] = true;
        }
        self.divided_by_d0[patch.index()]
    }
}
