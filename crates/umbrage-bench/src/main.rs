//! `umbrage-bench`: whole bakes, measured and stored, compared with earlier ones, and drawn as convergence plots.
//!
//! ```sh
//! cargo run --release -p umbrage-bench -- suite
//! cargo run --release -p umbrage-bench -- compare bench-runs/A.json bench-runs/B.json
//! cargo run --release -p umbrage-bench -- convergence
//! cargo run --release -p umbrage-bench -- weak
//! cargo run --release -p umbrage-bench -- random --scenes 1000 --seed 1
//! ```
//!
//! Each bake of the suite is a process of its own, since the most memory that a process held never falls again: the
//! program starts itself with the hidden command `one` (`random-one` for a random scene), which prints what it measured as JSON.

mod compare;
mod convergence;
mod machine;
mod measure;
mod page;
mod parts;
mod plot;
mod random;
mod random_file;
mod random_one;
mod record;
mod reference;
mod scenes;
mod suite;
mod table;
mod weak;

use std::io::{self, Write};

use clap::{Parser, Subcommand};
use umbrage_bench::usage;

/// Whole bakes of the light baker Umbrage, measured
#[derive(Debug, Parser)]
#[command(version)]
struct Arguments {
    #[command(subcommand)]
    command: Command,
}

#[derive(Debug, Subcommand)]
enum Command {
    Suite(suite::SuiteArgs),
    Compare(compare::CompareArgs),
    Convergence(convergence::ConvergenceArgs),
    Weak(weak::WeakArgs),
    Random(random::RandomArgs),
    #[command(hide = true)]
    One(measure::OneArgs),
    #[command(hide = true)]
    RandomOne(random_one::RandomOneArgs),
}

fn main() -> anyhow::Result<()> {
    match Arguments::parse().command {
        Command::Suite(args) => suite::run(&args),
        Command::Compare(args) => compare::run(&args),
        Command::Convergence(args) => convergence::run(&args),
        Command::Weak(args) => weak::run(&args),
        Command::Random(args) => random::run(&args),
        Command::RandomOne(args) => random_one::run(&args),
        Command::One(args) => measure::run(&args),
    }
}

/// Writes what was asked for, as whole lines.
fn say(text: &str) -> anyhow::Result<()> {
    let mut stream = io::stdout().lock();
    stream.write_all(text.as_bytes())?;
    if !text.ends_with('\n') {
        stream.write_all(b"\n")?;
    }
    Ok(stream.flush()?)
}

/// Tells how far the program is, on standard error.
fn tell(text: &str) {
    // Nobody has to listen.
    let _ = writeln!(io::stderr(), "{text}");
}

/// A number above 0.
fn positive(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(number) if number.is_finite() && number > 0.0 => Ok(number),
        _ => Err("must be a number above 0".into()),
    }
}
