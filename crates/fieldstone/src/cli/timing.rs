//! Where the time went.

use std::fmt::Write;
use std::time::{Duration, Instant};

/// Phases in the order in which they were first entered.
#[derive(Debug, Default)]
pub(crate) struct Timing {
    phases: Vec<(&'static str, Duration)>,
}

impl Timing {
    /// Runs `work` and adds its time to `phase`.
    pub fn measure<T>(&mut self, phase: &'static str, work: impl FnOnce() -> T) -> T {
        let start = Instant::now();
        let result = work();
        let time = start.elapsed();
        match self.phases.iter_mut().find(|p| p.0 == phase) {
            Some(entry) => entry.1 += time,
            None => self.phases.push((phase, time)),
        }
        result
    }

    /// Seconds spent in `phase`.
    pub fn seconds(&self, phase: &str) -> f64 {
        self.phases.iter().find(|p| p.0 == phase).map_or(0.0, |p| p.1.as_secs_f64())
    }

    /// A table of phases, seconds and shares.
    pub fn table(&self) -> String {
        let total: f64 = self.phases.iter().map(|p| p.1.as_secs_f64()).sum();
        let mut text = String::from("phase            seconds   share\n");
        for (phase, time) in &self.phases {
            let seconds = time.as_secs_f64();
            let _ =
                writeln!(text, "{phase:<14} {seconds:>9.4} {:>6.1} %", 100.0 * seconds / total.max(f64::MIN_POSITIVE));
        }
        let _ = writeln!(text, "{:<14} {total:>9.4}", "total");
        text
    }
}
