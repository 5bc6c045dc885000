//! The page that says what agrees and what is better.

use super::Settings;
use super::samples::{PAPER_SAMPLES, Schedule};
use crate::cli::reproduce::sections::{Section, took};

/// What stands above the figures: what was computed, with how many spheres, in what time.
pub(super) fn head(settings: &Settings, sections: &[Section]) -> String {
    let mut text = String::from(
        "# Overlap of spheres and mesh elements\n\nThe figures of S. Strobl, A. Formella, T. Pöschel, “Exact calculation \
         of the overlap volume of spheres and mesh elements”, J. Comput. Phys. 311 (2016) 158–172, computed anew. All \
         numbers below come from one run of `fieldstone reproduce overlap`; the paper's are quoted from its text.\n\n",
    );
    let samples = match settings.schedule {
        Schedule::Full => format!("{PAPER_SAMPLES} at every radius, as in the paper"),
        Schedule::Thinned(_) => {
            let at = |radius| settings.schedule.at(radius);
            format!("{} up to 1, {} up to 4, {} above (paper: {PAPER_SAMPLES})", at(1.0), at(4.0), at(20.0))
        }
    };
    let radii = if settings.paper_radii { "41 radii from 0.05 to 20, as in the paper" } else { "chosen radii" };
    text.push_str(&format!("* radii: {radii}\n* spheres per radius: {samples}\n"));
    let (seconds, processor) = took(sections);
    text.push_str(&format!(
        "* threads: {}; the run took {seconds:.0} s, {processor:.0} s of processor time\n\n",
        rayon::current_num_threads()
    ));
    text
}

/// A number with two digits.
pub(super) fn exponent(x: f64) -> String {
    if x == 0.0 { "0".into() } else { format!("{x:.1e}") }
}

/// How a number of this run stands to one of the paper's.
pub(super) fn against(ours: f64, paper: f64) -> String {
    // Half a unit of the last digit: what an error of 0 stands for.
    let ours = ours.max(0.5 * f64::EPSILON);
    let ratio = paper / ours;
    if ratio >= 1.5 {
        format!("{ours:.1e}, {ratio:.0} times below the paper's {paper:.0e}")
    } else if ratio > 1.0 / 1.5 {
        format!("{ours:.1e}, the paper's {paper:.0e}")
    } else {
        format!("{ours:.1e}, above the paper's {paper:.0e}")
    }
}

/// Errors at some of the radii: a row per radius, a column per curve.
pub(super) fn error_table(title: &str, radii: &[f64], columns: &[String], curves: &[Vec<f64>]) -> String {
    let mut text = format!("{title}:\n\n| r |");
    columns.iter().for_each(|name| text.push_str(&format!(" {name} |")));
    text.push_str(&format!("\n|---|{}\n", "---|".repeat(columns.len())));
    // Every fifth of the paper's 41: from end to end.
    let step = (radii.len() - 1).div_ceil(8).max(1);
    for index in (0..radii.len()).step_by(step) {
        text.push_str(&format!("| {:.3} |", radii[index]));
        curves.iter().for_each(|curve| text.push_str(&format!(" {} |", exponent(curve[index]))));
        text.push('\n');
    }
    text.push('\n');
    text
}
