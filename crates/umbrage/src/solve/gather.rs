//! `gather`: the irradiance that each node receives over its own links, `E_p = sum of F_pq B_q`, and how it changes over
//! the node. `B` here is what sources reflect: what they emit arrives as direct light.
//!
//! Links carry the gradient of their factor over the receiver, and, since light travels both ways alike, what the first
//! moment of the source's radiosity adds ([`Linear`] says why).
//!
//! Nodes are gathered in parallel, each at its own index and over its links in their order, so that the result does not
//! depend on threads.

use rayon::prelude::*;

use crate::id::{PatchId, Table};
use crate::scene::Rgb;
use crate::transport::{Linear, Links};

/// Reflected radiosity of a node, up to its first moment.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct RadiosityMoments {
    /// Area mean, in W/m2.
    pub mean: Rgb,
    /// Area mean of radiosity times the offset from the centroid, along the axes of the face's frame, in W/m.
    pub first: [Rgb; 2],
}

/// Irradiance over each node's own links; what its ancestors and parts gather is not in it.
pub fn gather(links: &Links, reflected: &Table<PatchId, RadiosityMoments>) -> Table<PatchId, Linear<Rgb>> {
    let of = |node: usize| {
        let mut sum = Linear::default();
        for link in links.of(PatchId::from(node)) {
            let source = &reflected[link.source];
            let (gradient, moment_factor) = (link.gradient.as_dvec2(), link.moment_factor.as_dvec2());
            sum.mean +=
                link.form_factor * source.mean + moment_factor.x * source.first[0] + moment_factor.y * source.first[1];
            sum.gradient[0] += gradient.x * source.mean;
            sum.gradient[1] += gradient.y * source.mean;
        }
        sum
    };
    Table::from((0..reflected.len()).into_par_iter().map(of).collect::<Vec<_>>())
}
