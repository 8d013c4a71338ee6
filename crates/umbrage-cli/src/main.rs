//! The command `umbrage`: bakes light into the vertices of a scene, draws the result, tells what is in a scene.
//!
//! One file per command. What the command was asked for goes to standard output (a summary, a list); how it is going
//! goes to standard error: progress on a terminal only, warnings, errors, logs.
//!
//! Holds: exit codes are those of [`exit_code::ExitCode`]; an error is told with its causes and a way out; a command
//! that fails or is interrupted leaves no half-written file.

mod bake;
mod demo;
mod exit_code;
mod form_factor;
mod info;
mod inspect;
mod interrupt;
mod light;
mod limits;
mod memory;
mod pace;
mod page;
mod plan;
mod progress;
mod render;
mod replace;
mod report;
mod reuse;
mod steps;
mod summary;
mod verify;
mod view;

use std::process;

use anyhow::Context;
use clap::{ArgAction, Parser, Subcommand};
use tracing_subscriber::filter::LevelFilter;
use tracing_subscriber::fmt::time;
use umbrage_cli::{camera, look, method, output, scene_file, shown};

use crate::exit_code::ExitCode;
use crate::output::Output;

/// So many threads are started where they are asked for, even if there are fewer processors.
const MAX_IDLE_THREADS: usize = 64;

const ABOUT: &str = "Bakes light and shadow into the vertices of a 3D scene";

const LONG_ABOUT: &str = "\
Bakes light and shadow into the vertices of a 3D scene.

Umbrage reads a scene of flat surfaces, some of which give light, and writes a GLB file whose triangles follow the edges \
of the shadows and whose vertices carry the light. Any glTF viewer shows it: no lightmap, no second UV set, no noise.";

const EXAMPLES: &str = "\
Examples:
  umbrage demo                           bake the built-in Cornell box: cornell.glb and cornell.png
  umbrage info room.glb                  what is in a scene, and what gives light in it
  umbrage bake room.glb -o baked.glb     bake a scene of your own
  umbrage render baked.glb -o baked.png  a picture of the result
  umbrage page baked.glb -o room.html    the result as a web page in one file
  umbrage view baked.glb                 the result in a window
  umbrage inspect room.glb --stage d-segments -o shadows.svg
                                         a drawing of the edges of its shadows

Exit codes: 0 done, 1 failed (the message says why), 2 wrong usage, 3 not as good as asked \
(verify, bake --strict), 130 interrupted (Ctrl-C, or a signal to end).
`umbrage help COMMAND` tells more about a command.";

#[derive(Debug, Parser)]
#[command(name = "umbrage", version, about = ABOUT, long_about = LONG_ABOUT, after_help = EXAMPLES)]
#[command(subcommand_required = true, arg_required_else_help = true)]
struct Cli {
    #[command(subcommand)]
    command: Command,
    #[command(flatten)]
    global: Global,
}

/// Options of every command.
#[derive(Debug, clap::Args)]
#[command(next_help_heading = "General")]
struct Global {
    /// How many processor threads to use, no more than help [default: as many as there are]; the result does not depend on it
    #[arg(long, global = true, value_name = "N", value_parser = clap::value_parser!(u16).range(1..))]
    threads: Option<u16>,
    /// Replace files that are there already, whatever they are
    #[arg(long, global = true)]
    force: bool,
    /// Say nothing but warnings and errors
    #[arg(short, long, global = true, conflicts_with = "verbose")]
    quiet: bool,
    /// Log what happens inside; twice or three times for more
    #[arg(short, long, global = true, action = ArgAction::Count)]
    verbose: u8,
}

#[derive(Debug, Subcommand)]
enum Command {
    Bake(bake::BakeArgs),
    Demo(demo::DemoArgs),
    Render(render::RenderArgs),
    Page(page::PageArgs),
    Info(info::InfoArgs),
    FormFactor(form_factor::FormFactorArgs),
    Verify(verify::VerifyArgs),
    Inspect(inspect::InspectArgs),
    View(view::ViewArgs),
}

fn main() {
    // Wrong usage ends here, with code 2; `--help` and `--version` with 0.
    let cli = Cli::parse();
    let code = match run(&cli) {
        Ok(()) => ExitCode::Success,
        Err(error) if interrupt::was_interrupted() => {
            match error.downcast_ref::<interrupt::Kept>() {
                Some(kept) => output::error(&kept.to_string()),
                None => output::error(&interrupt::Interrupted.to_string()),
            }
            ExitCode::Interrupted
        }
        // Whoever read our output has read enough: `umbrage info room.glb | head -3`.
        Err(error) if output::is_closed_pipe(&error) => ExitCode::Success,
        Err(error) => {
            output::error_chain(&error);
            if error.is::<verify::NotGoodEnough>() || error.is::<bake::NotTrue>() {
                ExitCode::NotGoodEnough
            } else {
                ExitCode::Failed
            }
        }
    };
    process::exit(code.into());
}

fn run(cli: &Cli) -> anyhow::Result<()> {
    start_log(cli.global.verbose);
    if let Some(threads) = cli.global.threads {
        // More than there are processors help nothing, and each takes memory and time.
        let most = std::thread::available_parallelism().map_or(1, usize::from).max(MAX_IDLE_THREADS);
        rayon::ThreadPoolBuilder::new()
            .num_threads(usize::from(threads).min(most))
            .build_global()
            .with_context(|| format!("cannot start {threads} threads: ask for fewer with --threads"))?;
    }
    let output = Output { quiet: cli.global.quiet, logging: cli.global.verbose > 0, force: cli.global.force };
    match &cli.command {
        Command::Bake(args) => bake::run(args, output),
        Command::Demo(args) => demo::run(args, output),
        Command::Render(args) => render::run(args, output),
        Command::Page(args) => page::run(args, output),
        Command::Info(args) => info::run(args, output),
        Command::FormFactor(args) => form_factor::run(args, output),
        Command::Verify(args) => verify::run(args, output),
        Command::Inspect(args) => inspect::run(args, output),
        Command::View(args) => view::run(args),
    }
}

/// Logs to standard error: warnings, and with `-v` more.
fn start_log(verbose: u8) {
    let level = match verbose {
        0 => LevelFilter::WARN,
        1 => LevelFilter::INFO,
        2 => LevelFilter::DEBUG,
        _ => LevelFilter::TRACE,
    };
    tracing_subscriber::fmt()
        .with_max_level(level)
        .with_writer(std::io::stderr)
        .with_ansi(false)
        .with_timer(time::uptime())
        .init();
}

#[cfg(test)]
mod tests {
    use clap::CommandFactory;

    #[test]
    fn the_command_line_is_sound() {
        super::Cli::command().debug_assert();
    }
}
