//! The oracle: whether two nodes may be linked as they are, or one must be split first (paper, sections 2 and 6).
//!
//! The paper's oracle compares `formfactor_estimate(p, q)` with a threshold `Fmax`; it ignores brightness, reflectance and
//! occluders. Here the estimate is taken both ways and the larger counts, and each patch is clipped to the front of the
//! other's plane first: only that part of it takes part. Between patches that touch, discs see far too little of each
//! other; so the exact factor from the middle of the smaller patch to the larger counts too.

use std::fmt;
use std::str::FromStr;

use glam::DVec3;

use super::Node;
use super::form_factor::{Disc, disc_estimate, point_to_polygon};
use crate::geometry::{Plane, clip, polygon};
use crate::mesh::Mesh;

/// What to do with a pair of nodes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Decision {
    /// They cannot see each other: no link.
    Unseen,
    /// Link them.
    Link,
    /// Split this one first.
    Split(Node),
}

/// Decides about pairs of nodes.
pub trait Oracle {
    /// What to do with `pair`.
    fn decide(&self, mesh: &Mesh, pair: [Node; 2]) -> Decision;

    /// Whether a node that holds a D0 split-hint is split before it is linked.
    fn splits_d0_first(&self) -> bool {
        true
    }
}

/// Which oracle decides.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum OracleKind {
    /// The paper's: the form factor estimate alone ([`FormFactorOracle`]).
    FormFactor,
    /// The estimate, weighed by the light that a link carries ([`super::BrightnessOracle`]).
    #[default]
    Brightness,
}

impl fmt::Display for OracleKind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::FormFactor => "form-factor",
            Self::Brightness => "brightness",
        })
    }
}

/// The name is that of no oracle.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("there is no oracle {0:?}: use brightness or form-factor")]
pub struct ParseOracleError(String);

impl FromStr for OracleKind {
    type Err = ParseOracleError;

    fn from_str(name: &str) -> Result<Self, Self::Err> {
        [Self::FormFactor, Self::Brightness]
            .into_iter()
            .find(|kind| kind.to_string() == name)
            .ok_or_else(|| ParseOracleError(name.to_owned()))
    }
}

/// The paper's oracle: split the larger until the form factor estimate is at most `Fmax`, or the patch is too small.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FormFactorOracle {
    /// `Fmax`: linked nodes have at most this estimated form factor, unless they are too small to be split.
    pub max_form_factor: f64,
    /// Patches of at most this area, in square metres, are too small to be split.
    pub min_area_m2: f64,
    /// Corners nearer to a plane than this, in metres, do not rise over it.
    pub coplanar_m: f64,
}

impl Oracle for FormFactorOracle {
    fn decide(&self, mesh: &Mesh, pair: [Node; 2]) -> Decision {
        self.estimate(mesh, pair).map_or(Decision::Unseen, |estimate| self.decide_by(mesh, pair, estimate))
    }
}

impl FormFactorOracle {
    /// The greater of the form factors between two nodes, as it is estimated; `None` where they cannot see each other.
    pub(super) fn estimate(&self, mesh: &Mesh, pair: [Node; 2]) -> Option<f64> {
        let planes = pair.map(|node| mesh.frame(mesh.patch(node).face).plane);
        let first = front_part(mesh, pair[0], &planes[1], self.coplanar_m)?;
        let second = front_part(mesh, pair[1], &planes[0], self.coplanar_m)?;
        let discs = [disc(&first, planes[0].normal), disc(&second, planes[1].normal)];
        let by_discs = disc_estimate(&discs[0], &discs[1]).max(disc_estimate(&discs[1], &discs[0]));
        let from_middle = if discs[0].area_m2 <= discs[1].area_m2 {
            point_to_polygon(discs[0].centre_m, discs[0].normal, &second)
        } else {
            point_to_polygon(discs[1].centre_m, discs[1].normal, &first)
        };
        Some(by_discs.max(from_middle))
    }

    /// What to do with a pair whose form factor counts for so much: its larger node is split where it can be and must.
    pub(super) fn decide_by(&self, mesh: &Mesh, pair: [Node; 2], estimate: f64) -> Decision {
        let areas_m2 = pair.map(|node| mesh.patch(node).area_m2);
        let larger = usize::from(areas_m2[1] > areas_m2[0]);
        if estimate > self.max_form_factor && areas_m2[larger] > self.min_area_m2 {
            Decision::Split(pair[larger])
        } else {
            Decision::Link
        }
    }
}

/// The paper's oracle, and nothing else: D0 hints are left for the end (paper, section 4).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PaperOracle(pub FormFactorOracle);

impl Oracle for PaperOracle {
    fn decide(&self, mesh: &Mesh, pair: [Node; 2]) -> Decision {
        self.0.decide(mesh, pair)
    }

    fn splits_d0_first(&self) -> bool {
        false
    }
}

/// The part of a patch in front of a plane; `None` where it nowhere rises over it.
fn front_part(mesh: &Mesh, node: Node, plane: &Plane, coplanar_m: f64) -> Option<Vec<DVec3>> {
    let corners_m = mesh.polygon_m(node);
    let rises = corners_m.iter().any(|&corner| plane.signed_distance_m(corner) > coplanar_m);
    rises.then(|| clip::in_front_of(&corners_m, plane, coplanar_m))
}

fn disc(corners_m: &[DVec3], normal: DVec3) -> Disc {
    Disc { centre_m: polygon::centroid(corners_m), normal, area_m2: polygon::area_m2(corners_m) }
}
