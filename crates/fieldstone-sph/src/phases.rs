use std::time::{Duration, Instant};

/// What a step spends its time on.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Phase {
    /// Images, sorting, neighbour lists.
    Neighbours,
    /// Columns of points from the state, bodies' ghosts.
    Columns,
    /// ⟨∇ρ⟩, Eq. 6.
    Gradient,
    /// Eq. 4, 5, 7.
    Rates,
    /// Free-surface detection.
    Detection,
    /// Eq. 11.
    Shifting,
    /// Everything else: time step, updates, checks.
    Rest,
}

impl Phase {
    /// All of them.
    pub const ALL: [Self; 7] =
        [Self::Neighbours, Self::Columns, Self::Gradient, Self::Rates, Self::Detection, Self::Shifting, Self::Rest];

    /// Name in tables.
    pub fn name(self) -> &'static str {
        match self {
            Self::Neighbours => "neighbours",
            Self::Columns => "columns",
            Self::Gradient => "gradient",
            Self::Rates => "rates",
            Self::Detection => "detection",
            Self::Shifting => "shifting",
            Self::Rest => "rest",
        }
    }
}

/// Wall-clock time per phase, and how often lists were built.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Phases {
    times: [Duration; 7],
    /// Times that the neighbour lists were built.
    pub lists_built: u64,
    /// Steps made.
    pub steps: u64,
}

impl Phases {
    /// Time of one phase.
    pub fn time(&self, phase: Phase) -> Duration {
        self.times[phase as usize]
    }

    /// Time of all phases.
    pub fn total(&self) -> Duration {
        self.times.iter().sum()
    }

    pub(crate) fn add(&mut self, phase: Phase, since: &mut Instant) {
        let now = Instant::now();
        self.times[phase as usize] += now - *since;
        *since = now;
    }
}
