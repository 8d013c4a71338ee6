//! `gather`: the irradiance that each node receives over its own links, `E_p = sum of F_pq B_q`.
//!
//! Nodes are gathered in parallel, each at its own index and over its links in their order, so that the result does not
//! depend on threads.

use rayon::prelude::*;

use crate::id::{PatchId, Table};
use crate::scene::Rgb;
use crate::transport::Links;

/// Irradiance over each node's own links, in W/m2; what its ancestors and parts gather is not in it.
pub fn gather(links: &Links, radiosity: &Table<PatchId, Rgb>) -> Table<PatchId, Rgb> {
    let of =
        |node: usize| links.of(PatchId::from(node)).iter().map(|link| link.form_factor * radiosity[link.source]).sum();
    Table::from((0..radiosity.len()).into_par_iter().map(of).collect::<Vec<Rgb>>())
}
