//! What is printed: errors, ledgers, warnings.

use std::fmt::Write;
use std::io::{ErrorKind, Write as _, stderr, stdout};

use anyhow::Context;
use fieldstone::fields::SolidFraction;
use fieldstone::particles::Domain;

/// Writes to standard output; the macros of the standard library would panic where that is closed or full.
///
/// A reader that has seen enough and gone (`head`) is no failure.
pub(crate) fn print(text: &str) -> anyhow::Result<()> {
    let mut out = stdout().lock();
    match out.write_all(text.as_bytes()).and_then(|()| out.flush()) {
        Err(error) if error.kind() == ErrorKind::BrokenPipe => Ok(()),
        result => result.context("standard output: cannot write"),
    }
}

/// Reports a failure on standard error.
pub(crate) fn fail(error: &anyhow::Error) {
    // Where standard error is closed there is nobody left to tell; the exit code still does.
    let _ = writeln!(stderr(), "error: {}", chain(error));
}

/// An error with its causes, each once.
fn chain(error: &anyhow::Error) -> String {
    let mut text = error.to_string();
    for cause in error.chain().skip(1) {
        let cause = cause.to_string();
        // Messages of wrapped errors already quote their source.
        if !text.contains(&cause) {
            let _ = write!(text, "\n  because: {cause}");
        }
    }
    text
}

/// Prints a warning on standard error.
pub(crate) fn warn(message: &str) {
    let _ = writeln!(stderr(), "warning: {message}");
}

/// Prints to standard error what standard output has no place for.
pub(crate) fn note(text: &str) {
    let _ = stderr().write_all(text.as_bytes());
}

/// The ledger as the lines that every run prints.
pub(crate) fn ledger(fields: &SolidFraction, inverted_cells: usize) -> String {
    let ledger = &fields.ledger;
    let share = |part: f64| if ledger.particle_volume > 0.0 { 100.0 * part / ledger.particle_volume } else { 0.0 };
    let mut text = String::new();
    let mut line = |name: &str, value: String| {
        let _ = writeln!(text, "{name:<20} {value}");
    };
    line("particles", ledger.particles.to_string());
    line("cells", ledger.cells.to_string());
    line("mesh volume", number(ledger.mesh_volume));
    line("particle volume", number(ledger.particle_volume));
    line("binned volume", format!("{}  ({:.4} %)", number(ledger.binned_volume), share(ledger.binned_volume)));
    let (name, value) =
        clipped("clipped volume", ledger.clipped_volume, ledger.particle_volume, "outside the mesh", number);
    line(name, value);
    line("max solid fraction", number(ledger.max_solid_fraction));
    let changed = match (&fields.unsmoothed, &fields.uncapped) {
        (Some(_), Some(_)) => Some("smoothed and capped"),
        (Some(_), None) => Some("smoothed"),
        (None, Some(_)) => Some("capped"),
        (None, None) => None,
    };
    if let Some(how) = changed {
        line(&format!("  {how}"), number(fields.max_written()));
    }
    line("cells above one", ledger.cells_above_one.to_string());
    line("inverted cells", inverted_cells.to_string());
    if ledger.overlaps > 0 {
        line("beyond 64 bits", format!("{} of {} overlaps", ledger.beyond_f64, ledger.overlaps));
    }
    text
}

/// The line for what of a total lies in no cell, or where that is below 0, for what lies in several.
pub(crate) fn clipped(
    name: &'static str,
    clipped: f64,
    total: f64,
    why: &str,
    number: impl Fn(f64) -> String,
) -> (&'static str, String) {
    let share = if total > 0.0 { clipped / total } else { 0.0 };
    if share < -ROUNDING {
        let twice = "in cells that overlap each other or repeat the periodic box";
        return ("counted twice", format!("{}  ({:.4} %, {twice})", number(-clipped), -100.0 * share));
    }
    (name, format!("{}  ({:.4} %, {why})", number(clipped.max(0.0)), 100.0 * share.max(0.0)))
}

/// Whether cells within these bounds are wider than a period, and see some of what is in the box more than once.
pub(crate) fn repeats(domain: Option<&Domain>, (low, high): ([f64; 3], [f64; 3])) -> bool {
    let wide = |d: &Domain, k: usize| high[k] - low[k] > d.cell_vectors()[k][k] * (1.0 + ROUNDING);
    domain.is_some_and(|d| (0..3).any(|k| d.periodic()[k] && wide(d, k)))
}

/// What to say where cells that see everything once hold more than there is: `clipped` is what of a total lies in none.
pub(crate) fn counted_twice(what: &str, clipped: f64, total: f64) -> Option<String> {
    (clipped < -ROUNDING * total).then(|| {
        format!(
            "the cells hold {:.4} % of the particles' {what}, and none of them repeats the periodic box: they overlap \
             each other, and what lies in two is counted twice; mend the mesh",
            100.0 * (1.0 - clipped / total)
        )
    })
}

/// A number with the digits that a message needs.
pub(crate) fn short(x: f64) -> f64 {
    format!("{x:.6e}").parse().unwrap_or(x)
}

/// Share of the particles' volume up to which the sum of what lies outside may differ from 0 by rounding.
pub(crate) const ROUNDING: f64 = 1e-9;

/// A number with its shortest exact digits, in scientific notation where that is shorter to read.
pub(crate) fn number(x: f64) -> String {
    if x == 0.0 || (1e-3..1e6).contains(&x.abs()) { x.to_string() } else { format!("{x:e}") }
}
