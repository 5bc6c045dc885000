//! The page that says what agrees and what is better.

use std::fmt;

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

/// What the paper's text says of an error.
#[derive(Debug, Clone, Copy)]
pub(super) enum Paper {
    /// "a plateau determined by the machine precision (≈ 10⁻¹⁶ for values near unity)", without a number for it.
    MachinePrecision,
    /// "of the order of".
    OfTheOrder(f64),
    /// "well below": an upper bound, so a smaller error is no better than the paper's.
    WellBelow(f64),
}

impl fmt::Display for Paper {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::MachinePrecision => f.write_str("machine precision"),
            Self::OfTheOrder(error) => write!(f, "≈ {error:.0e}"),
            Self::WellBelow(error) => write!(f, "< {error:.0e}"),
        }
    }
}

impl Paper {
    /// How an error of this run stands to it.
    pub fn against(self, ours: f64) -> String {
        let place = match self {
            Self::MachinePrecision => {
                return format!(
                    "{}; the paper's is determined by the machine precision, ≈ 1e-16 for values near unity",
                    exponent(ours)
                );
            }
            // Half an order to either side is of it.
            Self::OfTheOrder(error) if ours * 10f64.sqrt() < error => "below the paper's order of",
            Self::OfTheOrder(error) if ours > error * 10f64.sqrt() => "above the paper's order of",
            Self::OfTheOrder(_) => "of the paper's order,",
            Self::WellBelow(error) if ours < error => "below the paper's bound of",
            Self::WellBelow(_) => "above the paper's bound of",
        };
        let (Self::OfTheOrder(error) | Self::WellBelow(error)) = self else { return exponent(ours) };
        format!("{}, {place} {error:.0e}", exponent(ours))
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn errors_are_set_against_no_more_than_the_paper_says() {
        let bound = Paper::WellBelow(1e-11);
        assert_eq!(format!("{bound}; {}", bound.against(0.0)), "< 1e-11; 0, below the paper's bound of 1e-11");
        assert_eq!(bound.against(2e-11), "2.0e-11, above the paper's bound of 1e-11");
        let order = Paper::OfTheOrder(1e-14);
        assert_eq!(format!("{order}; {}", order.against(1.6e-14)), "≈ 1e-14; 1.6e-14, of the paper's order, 1e-14");
        assert_eq!(order.against(1.3e-15), "1.3e-15, below the paper's order of 1e-14");
        assert_eq!(order.against(4e-14), "4.0e-14, above the paper's order of 1e-14");
        assert!(Paper::MachinePrecision.against(2e-15).starts_with("2.0e-15; the paper's is determined by"));
    }
}
