//! Command line of Umbrage.
fn main() {}
