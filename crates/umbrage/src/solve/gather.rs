//! `gather`: the irradiance that each node receives over its own links, `E_p = sum of F_pq B_q`, and how it changes over
//! the node.
//!
//! Links carry the gradient of their factor over the receiver, and, since light travels both ways alike, what the first
//! moment of the source's radiosity adds. Constants instead would be wrong in the same direction for all sources on one
//! side of a large receiver: near an edge of a room the sum would err by a tenth, and light would get lost.
//!
//! Nodes are gathered in parallel, each at its own index and over its links in their order, so that the result does not
//! depend on threads.

use rayon::prelude::*;

use crate::id::{PatchId, Table};
use crate::scene::Rgb;
use crate::transport::Links;

/// Irradiance on a node, as a linear function.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct LinearIrradiance {
    /// At the centroid, which is the mean, in W/m2.
    pub mean: Rgb,
    /// Change along the axes of the face's frame, in W/m3.
    pub gradient: [Rgb; 2],
}

/// Radiosity of a node, up to its first moment.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct RadiosityMoments {
    /// Area mean, in W/m2.
    pub mean: Rgb,
    /// Area mean of radiosity times the offset from the centroid, along the axes of the face's frame, in W/m.
    pub first: [Rgb; 2],
}

/// Irradiance over each node's own links; what its ancestors and parts gather is not in it.
pub fn gather(links: &Links, radiosity: &Table<PatchId, RadiosityMoments>) -> Table<PatchId, LinearIrradiance> {
    let of = |node: usize| {
        let mut sum = LinearIrradiance::default();
        for link in links.of(PatchId::from(node)) {
            let source = &radiosity[link.source];
            let (gradient, moment_factor) = (link.gradient.as_dvec2(), link.moment_factor.as_dvec2());
            sum.mean +=
                link.form_factor * source.mean + moment_factor.x * source.first[0] + moment_factor.y * source.first[1];
            sum.gradient[0] += gradient.x * source.mean;
            sum.gradient[1] += gradient.y * source.mean;
        }
        sum
    };
    Table::from((0..radiosity.len()).into_par_iter().map(of).collect::<Vec<_>>())
}
