//! Links: which node of the hierarchy gathers light from which other, and by what factor.
//!
//! A link's form factor is the area mean, over its receiver, of the visible point-to-source factor: it holds the
//! occlusion, so that no separate visibility is needed. A pair of patches has a link each way, and both come from one
//! computation ([`super::exchange`]).
//!
//! Holds: links are in the order of their receivers, then of their sources; no factor is zero.

use serde::{Deserialize, Serialize};
use std::ops::Range;

use glam::Vec2;

use crate::id::PatchId;
use crate::mesh::Mesh;

/// A node of the hierarchy that links join: a patch.
pub type Node = PatchId;

/// Light travels from `source` to `receiver`.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Link {
    /// The node that gathers.
    pub receiver: Node,
    /// The node that it gathers from.
    pub source: Node,
    /// Share of the light that leaves the receiver, uniformly, and arrives at the source unhindered: the mean of the
    /// visible point factor over the receiver.
    pub form_factor: f64,
    /// How the point factor changes over the receiver, along the axes of its face's frame, per metre: the best linear
    /// fit.
    pub gradient: Vec2,
    /// How the mean irradiance on the receiver changes with the first moment of the source's radiosity, along the axes of
    /// the source's frame, per metre: the gradient of the link back, times the source's area over the receiver's.
    pub moment_factor: Vec2,
}

/// All links, by receiver.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Links {
    links: Vec<Link>,
    starts: Vec<u32>,
}

/// A broken promise of [`Links`]: always a defect of this library.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum LinkError {
    /// A factor is not above 0, or more than 1.
    #[error("{0:?} has a form factor outside of 0 to 1")]
    BadFactor(Link),
    /// A patch that holds a contact (D0) has a link.
    #[error("{0:?} ends at a patch that holds a D0 split-hint")]
    AcrossContact(Link),
}

impl Links {
    /// Orders links by their ends, and drops those of factor zero.
    pub fn new(mut links: Vec<Link>, node_count: usize) -> Self {
        links.retain(|link| link.form_factor > 0.0);
        links.sort_by_key(|link| (link.receiver, link.source));
        let mut starts = Vec::with_capacity(node_count + 1);
        let mut next = 0;
        for node in 0..=node_count {
            while next < links.len() && links[next].receiver.index() < node {
                next += 1;
            }
            starts.push(next as u32);
        }
        Self { links, starts }
    }

    /// All links, in order.
    pub fn as_slice(&self) -> &[Link] {
        &self.links
    }

    /// Number of links.
    pub fn len(&self) -> usize {
        self.links.len()
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.links.is_empty()
    }

    /// The links that `receiver` gathers over.
    pub fn of(&self, receiver: Node) -> &[Link] {
        &self.links[self.range(receiver)]
    }

    fn range(&self, receiver: Node) -> Range<usize> {
        let start = |node: usize| self.starts.get(node).map_or(self.links.len(), |&start| start as usize);
        start(receiver.index())..start(receiver.index() + 1)
    }

    /// Checks what can be checked of the promises above, and that no link ends at a patch that holds a D0 hint.
    ///
    /// # Errors
    /// The first broken promise.
    pub fn validate(&self, mesh: &Mesh) -> Result<(), LinkError> {
        for link in &self.links {
            if !(link.form_factor > 0.0 && link.form_factor <= 1.0 + FACTOR_SLACK) {
                return Err(LinkError::BadFactor(*link));
            }
            if mesh.has_d0_hint(link.receiver) || mesh.has_d0_hint(link.source) {
                return Err(LinkError::AcrossContact(*link));
            }
        }
        Ok(())
    }
}

/// Rounding of a sum of angles: by no more than this a factor may exceed 1.
const FACTOR_SLACK: f64 = 1e-9;
