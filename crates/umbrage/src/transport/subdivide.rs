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
//! under walls; with [`super::PaperOracle`] it is done so.) Links stay at their nodes when another pair splits these further.
//!
//! All pairs of faces that could exchange much ([`super::pairs`]) are subdivided first, one after the other, since that changes the mesh; then the links' form factors
//! are computed in parallel, each written at its own index.
//!
//! Before: no patch that held a D0 hint has been split yet.

use std::sync::atomic::{AtomicUsize, Ordering};

use rayon::prelude::*;

use super::exchange::link_both_ways;
use super::link::{Links, Node};
use super::oracle::{Decision, Oracle};
use super::pairs::pairs;
use crate::mesh::Mesh;
use crate::prepare::Prepared;
use crate::progress::{Cancelled, Progress, Stage};
use crate::visibility::Visibility;

/// So many pairs of faces are subdivided between two reports of progress.
const PAIRS_PER_REPORT: usize = 64;
/// With more pairs than this, a pair that the oracle would link as it is takes no link where a patch of it holds a D0 hint: the parts of a
/// jagged shadow of a thousand edges, times as many slim faces, are a million faint links. The exact bounce gathers what they miss
/// (`shade::bounce`). Rooms and buildings have some ten thousand pairs.
const MOST_PAIRS: usize = 100_000;
/// So many links are computed between two reports of progress.
const LINKS_PER_REPORT: usize = 256;

/// Splits the mesh until the oracle lets all pairs of patches that could exchange much be linked: these are returned.
///
/// # Errors
/// [`Cancelled`] where `progress` asks to stop; the mesh is then split in part.
pub fn subdivide_all(
    prepared: &Prepared,
    visibility: &Visibility,
    mesh: &mut Mesh,
    oracle: &impl Oracle,
    progress: Progress<'_>,
) -> Result<Vec<[Node; 2]>, Cancelled> {
    let mut subdivision = Subdivision { mesh, oracle, divided_by_d0: Vec::new(), pairs: Vec::new() };
    let of_faces = pairs(prepared, visibility);
    for (number, &[p, q]) in of_faces.iter().enumerate() {
        if number.is_multiple_of(PAIRS_PER_REPORT) {
            progress.report(Stage::Transport, number, of_faces.len())?;
        }
        subdivision.subdivide(subdivision.mesh.root(p), subdivision.mesh.root(q));
    }
    let pairs = subdivision.pairs;
    tracing::debug!(pairs = pairs.len(), patches = mesh.patch_count(), "subdivided");
    Ok(pairs)
}

/// Splits the mesh and links its patches.
///
/// # Errors
/// As [`subdivide_all`].
pub fn link_all(
    prepared: &Prepared,
    visibility: &Visibility,
    mesh: &mut Mesh,
    oracle: &impl Oracle,
    progress: Progress<'_>,
) -> Result<Links, Cancelled> {
    let [subdividing, linking] = [[0.0, 0.5], [0.5, 1.0]].map(|part| progress.part(Stage::Transport, part));
    let pairs = subdivide_all(prepared, visibility, mesh, oracle, subdividing)?;
    let mesh = &*mesh;
    let done = AtomicUsize::new(0);
    let links: Vec<_> = pairs
        .par_iter()
        .map(|&pair| {
            let number = done.fetch_add(1, Ordering::Relaxed);
            if number.is_multiple_of(LINKS_PER_REPORT) {
                linking.report(Stage::Transport, number, pairs.len())?;
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
                let is_much = self.pairs.len() > MOST_PAIRS;
                if is_much && decision == Decision::Link && [p, q].iter().any(|&patch| self.is_divided_by_d0(patch)) {
                    return;
                }
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

    /// Whether a patch holds a D0 hint, or did when it was split.
    fn is_divided_by_d0(&self, patch: Node) -> bool {
        self.oracle.splits_d0_first()
            && (self.mesh.has_d0_hint(patch) || self.divided_by_d0.get(patch.index()).copied().unwrap_or(false))
    }

    /// Splits a patch that holds a D0 hint; true where it holds or held one and has parts.
    fn split_by_d0(&mut self, patch: Node) -> bool {
        if self.divided_by_d0.len() < self.mesh.patch_count() {
            self.divided_by_d0.resize(self.mesh.patch_count(), false);
        }
        let holds = self.oracle.splits_d0_first() && self.mesh.has_d0_hint(patch);
        if holds && self.mesh.split(patch) {
            self.divided_by_d0[patch.index()] = true;
        }
        self.divided_by_d0[patch.index()]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::discontinuity::{DSegment, Degree, Event};
    use crate::id::{EdgeId, FaceId, Table};
    use crate::mesh::MeshSettings;
    use crate::transport::{FormFactorOracle, Link, PaperOracle};
    use crate::visibility::fixture;
    use glam::DVec3;
    use std::ops::ControlFlow;

    fn oracle(prepared: &Prepared, max_form_factor: f64, min_area_m2: f64) -> FormFactorOracle {
        FormFactorOracle { max_form_factor, min_area_m2, coplanar_m: prepared.tolerance.coplanar_m() }
    }

    fn linked(prepared: &Prepared, d_segments: &Table<crate::id::DSegmentId, DSegment>, f_max: f64) -> (Mesh, Links) {
        let mut mesh = Mesh::new(prepared, d_segments, MeshSettings::default());
        let index = Visibility::new(prepared);
        let oracle = oracle(prepared, f_max, 0.01);
        let links = link_all(prepared, &index, &mut mesh, &oracle, Progress::silent()).unwrap();
        mesh.validate().unwrap();
        links.validate(&mesh).unwrap();
        (mesh, links)
    }

    /// A room with a box in it that stands on the floor.
    fn furnished_room() -> Prepared {
        let mut polygons = fixture::inward_box(DVec3::ZERO, DVec3::new(2.0, 1.5, 1.0));
        polygons.extend(fixture::outward_box(DVec3::new(0.5, 0.5, 0.25), DVec3::new(1.0, 1.0, 0.75)));
        fixture::prepared(&polygons)
    }

    /// What a leaf sees of everything: the factors of its own links and of those of the patches that it is part of, these
    /// taken at its centroid.
    fn row_sum(mesh: &Mesh, links: &Links, leaf: Node) -> f64 {
        let frame = mesh.frame(mesh.patch(leaf).face);
        let centroid = |node: Node| frame.to_2d(mesh.patch(node).centroid_m);
        let at_leaf =
            |link: &Link| link.form_factor + link.gradient.as_dvec2().dot(centroid(leaf) - centroid(link.receiver));
        let chain = std::iter::successors(Some(leaf), |&node| mesh.patch(node).parent);
        chain.flat_map(|node| links.of(node)).map(at_leaf).sum()
    }

    #[test]
    fn smaller_thresholds_split_more_and_larger_patches_are_split_first() {
        let prepared = furnished_room();
        let [coarse, fine] = [0.3, 0.05].map(|f_max| linked(&prepared, &Table::new(), f_max));
        assert!(fine.0.patch_count() > 4 * coarse.0.patch_count());
        let split = fine.0.patches().filter(|(_, patch)| patch.subpatches.is_some());
        assert!(split.into_iter().all(|(_, patch)| patch.area_m2 > 0.01));
    }

    /// `subdivide` as the paper prints it, over the same pairs of faces.
    fn printed(mesh: &mut Mesh, oracle: &FormFactorOracle, [p, q]: [Node; 2]) {
        let Some(estimate) = oracle.estimate(mesh, [p, q]) else { return };
        let [small, large] = if mesh.patch(q).area_m2 > mesh.patch(p).area_m2 { [p, q] } else { [q, p] };
        if estimate <= oracle.max_form_factor || mesh.patch(large).area_m2 <= oracle.min_area_m2 || !mesh.split(large) {
            return;
        }
        for part in mesh.patch(large).subpatches.unwrap() {
            printed(mesh, oracle, [part, small]);
        }
    }

    #[test]
    fn as_in_the_paper_leaves_are_exactly_those_that_fmax_asks_for() {
        let (prepared, contacts) = two_rooms();
        let visibility = Visibility::new(&prepared);
        for f_max in [10.0, 0.3, 0.1, 0.05] {
            let oracle = oracle(&prepared, f_max, 0.01);
            let settings =
                MeshSettings { score: crate::mesh::SplitScore::Eq1, mend_bad_shapes: false, ..MeshSettings::default() };
            let [mut made, mut reference] = [0, 1].map(|_| Mesh::new(&prepared, &contacts, settings));
            let paper = PaperOracle(oracle);
            let linked = subdivide_all(&prepared, &visibility, &mut made, &paper, Progress::silent()).unwrap();
            for [p, q] in pairs(&prepared, &visibility) {
                let pair = [reference.root(p), reference.root(q)];
                printed(&mut reference, &oracle, pair);
            }
            let cuts =
                |mesh: &Mesh| mesh.patches().map(|(id, patch)| (id, patch.subpatches, patch.cut)).collect::<Vec<_>>();
            assert_eq!(cuts(&made), cuts(&reference));
            assert_eq!(
                made.patch_count() == prepared.faces.len(),
                f_max == 10.0,
                "not even the D0 hint is cut for its own sake"
            );
            for pair in linked {
                let larger_m2 = pair.map(|node| made.patch(node).area_m2).into_iter().fold(0.0, f64::max);
                let estimate = oracle.estimate(&made, pair).unwrap();
                assert!(estimate <= f_max || larger_m2 <= oracle.min_area_m2, "{pair:?}: {estimate} of {f_max}");
            }
        }
    }

    #[test]
    fn rows_of_a_closed_room_sum_to_one() {
        let prepared = furnished_room();
        let (mesh, links) = linked(&prepared, &Table::new(), 0.05);
        let (mut mean, mut square, mut area_m2) = (0.0, 0.0, 0.0);
        for leaf in mesh.leaves() {
            let sum = row_sum(&mesh, &links, leaf);
            mean += mesh.patch(leaf).area_m2 * sum;
            square += mesh.patch(leaf).area_m2 * (sum - 1.0).powi(2);
            area_m2 += mesh.patch(leaf).area_m2;
        }
        // Rays tell what the box hides; what they miss is found by the exact bounce of `shade::add_missed_by_links`.
        assert!((mean / area_m2 - 1.0).abs() < 3e-3, "{}", mean / area_m2);
        assert!((square / area_m2).sqrt() < 0.06, "{}", (square / area_m2).sqrt());
    }

    #[test]
    fn factors_are_reciprocal() {
        let prepared = furnished_room();
        let (mesh, links) = linked(&prepared, &Table::new(), 0.05);
        for link in links.as_slice() {
            let back = links.of(link.source).iter().find(|back| back.source == link.receiver);
            let [there, here] = [link.receiver, link.source].map(|node| mesh.patch(node).area_m2);
            let flows = [there * link.form_factor, here * back.map_or(0.0, |back| back.form_factor)];
            assert!((flows[0] - flows[1]).abs() < 0.02 * there.min(here), "{link:?} {back:?}");
        }
    }

    /// Two rooms over one floor, with a thin wall between, at `x = 1`; the wall's contact is a D0 d-segment.
    fn two_rooms() -> (Prepared, Table<crate::id::DSegmentId, DSegment>) {
        let corner = |x: f64, y: f64, z: f64| DVec3::new(x, y, z);
        let floor = vec![corner(0.0, 0.0, 0.0), corner(2.0, 0.0, 0.0), corner(2.0, 1.0, 0.0), corner(0.0, 1.0, 0.0)];
        let mut polygons = vec![floor];
        for x in [0.0, 1.0] {
            polygons.extend(fixture::inward_box(corner(x, 0.0, 0.0), corner(x + 1.0, 1.0, 1.0)).into_iter().skip(1));
        }
        let prepared = fixture::prepared(&polygons);
        let contact = DSegment {
            face: FaceId::from(0),
            ends_m: [corner(1.0, 0.0, 0.0), corner(1.0, 1.0, 0.0)],
            degree: Degree::D0,
            strength: 1.0,
            event: Event::Contact { edge: EdgeId::from(0) },
        };
        (prepared, Table::from(vec![contact]))
    }

    #[test]
    fn a_patch_with_a_contact_takes_no_link_and_is_split_whatever_the_threshold() {
        let (prepared, contacts) = two_rooms();
        let (mesh, links) = linked(&prepared, &contacts, 10.0);
        let floor = mesh.root(FaceId::from(0));
        assert!(links.of(floor).is_empty() && links.as_slice().iter().all(|link| link.source != floor));
        for part in mesh.patch(floor).subpatches.unwrap() {
            assert!(!links.of(part).is_empty());
        }
    }

    #[test]
    fn no_link_passes_a_partition() {
        let (prepared, contacts) = two_rooms();
        for f_max in [10.0, 0.1] {
            let (mesh, links) = linked(&prepared, &contacts, f_max);
            for link in links.as_slice() {
                let sides = [link.receiver, link.source].map(|node| mesh.patch(node).centroid_m.x);
                let rooms = sides.map(|x| if x == 1.0 { None } else { Some(x > 1.0) });
                assert!(rooms[0].is_none() || rooms[1].is_none() || rooms[0] == rooms[1], "{link:?}");
            }
        }
    }

    #[test]
    fn the_number_of_threads_does_not_matter() {
        let prepared = furnished_room();
        let of_threads = |threads: usize| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            pool.install(|| linked(&prepared, &Table::new(), 0.1).1)
        };
        assert_eq!(of_threads(1), of_threads(2));
    }

    #[test]
    fn a_callback_cancels_splitting_and_linking() {
        let prepared = furnished_room();
        for linking in [false, true] {
            let stop = move |update: crate::progress::Update| {
                // Patches are split in the first half of the stage, and linked in the second.
                let is_linking = 2 * update.done >= update.total;
                if is_linking == linking { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
            };
            let mut mesh = Mesh::new(&prepared, &Table::new(), MeshSettings::default());
            let oracle = oracle(&prepared, 0.1, 0.01);
            let result = link_all(&prepared, &Visibility::new(&prepared), &mut mesh, &oracle, Progress::new(&stop));
            assert_eq!(result, Err(Cancelled));
        }
    }
}
