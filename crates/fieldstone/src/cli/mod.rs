//! Subcommands, one file each.

mod arguments;
mod demo;
mod detect;
mod fields;
mod fluid;
mod fraction;
mod grid;
mod info;
mod manual;
mod outputs;
mod overlap;
mod picture;
mod plot;
mod publish;
mod report;
mod reproduce;
mod sph;
mod sph_checks;
mod sph_frames;
mod sph_warnings;
mod surface;
mod timing;

use std::ffi::OsStr;
use std::path::Path;
use std::process::ExitCode;

use anyhow::{Context, anyhow};
use clap::error::ErrorKind;
use clap::{Parser, Subcommand};

/// Turns particles into fields, exactly.
///
/// Solid fractions and continuum fields from DEM packings, with volume, mass and momentum accounted for; free surfaces
/// of SPH flows, and a solver for such flows; exact overlaps of spheres with mesh elements. All lengths are in the unit
/// of the input; particles and mesh must use the same one.
#[derive(Debug, Parser)]
#[command(
    name = "fieldstone",
    version,
    after_help = "Exit codes: 0 success; 1 the input or the task failed (the message says where and why); \
                  2 wrong usage."
)]
pub(crate) struct Cli {
    #[command(subcommand)]
    command: Command,
    /// Number of threads, 1 to 1024 [default: all cores]; results are the same for any number
    #[arg(
        long,
        global = true,
        value_name = "N",
        // Last in every list; else its place depends on how many subcommands there are.
        display_order = 900,
        allow_negative_numbers = true,
        value_parser = clap::value_parser!(u16).range(1..=1024)
    )]
    threads: Option<u16>,
}

#[derive(Debug, Subcommand)]
enum Command {
    Fraction(Box<fraction::Fraction>),
    Fields(Box<fields::FieldsCommand>),
    Plot(plot::Plot),
    Overlap(overlap::OverlapCases),
    Detect(Box<detect::Detect>),
    Grid(Box<grid::GridFields>),
    Surface(Box<surface::Surface>),
    Info(info::Info),
    Demo(demo::Demo),
    Reproduce(reproduce::Reproduce),
    Sph(sph::Sph),
    Completions(manual::Completions),
    Manual(manual::Manual),
}

pub(crate) fn run() -> ExitCode {
    let cli = match Cli::try_parse() {
        Ok(cli) => cli,
        Err(error) => {
            // What is no option may be the name of a file.
            let taken = std::env::args_os().skip(1).find(|word| begins_as_an_option(word) && Path::new(word).is_file());
            match taken.filter(|_| error.kind() == ErrorKind::UnknownArgument) {
                Some(file) => {
                    let name = file.display();
                    report::fail(&anyhow!("{name} is taken for an option; for the file of this name write ./{name}"));
                }
                None => error.exit(),
            }
            return ExitCode::from(2);
        }
    };
    match execute(cli) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            report::fail(&error);
            ExitCode::FAILURE
        }
    }
}

fn begins_as_an_option(word: &OsStr) -> bool {
    word.as_encoded_bytes().starts_with(b"-")
}

fn execute(cli: Cli) -> anyhow::Result<()> {
    if let Some(threads) = cli.threads {
        rayon::ThreadPoolBuilder::new().num_threads(threads.into()).build_global().context("--threads")?;
    }
    match cli.command {
        Command::Fraction(command) => command.run(),
        Command::Fields(command) => command.run(),
        Command::Plot(command) => command.run(),
        Command::Overlap(command) => command.run(),
        Command::Detect(command) => command.run(),
        Command::Grid(command) => command.run(),
        Command::Surface(command) => command.run(),
        Command::Info(command) => command.run(),
        Command::Demo(command) => command.run(),
        Command::Reproduce(command) => command.run(),
        Command::Sph(command) => command.run(),
        Command::Completions(command) => command.run(),
        Command::Manual(command) => command.run(),
    }
}
