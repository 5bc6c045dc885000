//! What came in and where it went, on the terminal and as JSON.

use std::fmt::Write as _;
use std::path::Path;

use fieldstone::fields::{
    CoarseGrainingLedger, CoarseGrainingOptions, ContactForm, FieldName, Fields, Function, Method,
};
use serde::Serialize;

use super::binned::Found;
use crate::cli::outputs;
use crate::cli::report::{ROUNDING, clipped, counted_twice, number, repeats};

/// Share of the mass by which samples of kernels may be off before it is worth a warning.
const MOST_OFF: f64 = 0.05;

/// What has been seen of the frames themselves.
#[derive(Debug, Default)]
pub(super) struct Seen {
    pub frames: usize,
    /// File and number of the last frame.
    pub last: String,
    /// Particles of the last frame.
    pub particles: usize,
    /// Contacts of the last frame.
    pub contacts: Option<usize>,
    /// What all frames' particles have in common.
    pub found: Found,
}

/// The account of a run: means over its results.
#[derive(Debug, Default)]
pub(super) struct Account {
    sum: CoarseGrainingLedger,
    results: usize,
    /// Σ of boundary forces over cells, and whether the field was there.
    boundary_force: Option<[f64; 3]>,
    /// Residual of the worst cell of the worst frame.
    balance: Option<f64>,
    pub seen: Seen,
    cells: usize,
    gravity: Option<[f64; 3]>,
    sign: &'static str,
    /// Whether cells see particles by kernels at points, which conserve nothing.
    sampled: bool,
    /// Whether cells are wider than a period, and see some particles more than once.
    repeats: bool,
    /// By how much of Σ |f| |l| the sum of the stresses may differ from Σ f ⊗ l where no mass is clipped; `None` where it is
    /// not promised at all.
    stress_tolerance: Option<f64>,
    /// Whether momenta and stresses are among the sums.
    has_momentum: bool,
    has_stress: bool,
}

/// Keys in the order in which they are written.
#[derive(Serialize)]
struct Json {
    mass_in: f64,
    mass_binned: f64,
    mass_clipped: f64,
    momentum_in: [f64; 3],
    /// Null where no field needs momenta.
    momentum_binned: Option<[f64; 3]>,
    stress_sum_contacts: [f64; 9],
    /// Null where no field needs stresses.
    stress_sum_fields: Option<[f64; 9]>,
    balance_residual: Option<f64>,
    frames: usize,
    seconds: f64,
    particles: usize,
    contacts: usize,
    cells: usize,
}

impl Account {
    /// The account of a run on so many cells; `sign` is which stresses are positive.
    pub fn new(
        options: &CoarseGrainingOptions,
        cells: usize,
        bounds: ([f64; 3], [f64; 3]),
        gravity: Option<[f64; 3]>,
        sign: &'static str,
    ) -> Self {
        let has = |needs: fn(FieldName) -> bool| options.fields.iter().any(|field| needs(*field));
        Self {
            cells,
            gravity,
            sign,
            sampled: matches!(options.function, Function::Kernel(_)) && !options.conserve,
            repeats: repeats(options.domain.as_ref(), bounds),
            stress_tolerance: stress_tolerance(options).filter(|_| has(needs_stress)),
            has_momentum: has(needs_momentum),
            has_stress: has(needs_stress),
            ..Self::default()
        }
    }

    /// Adds a residual of the balance of momentum.
    pub fn add_balance(&mut self, residual: Option<f64>) {
        self.balance = match (self.balance, residual) {
            (Some(a), Some(b)) => Some(a.max(b)),
            (a, b) => a.or(b),
        };
    }

    /// Adds a result.
    pub fn add(&mut self, fields: &Fields, volume: impl Fn(usize) -> f64) {
        let l = &fields.ledger;
        let sum = &mut self.sum;
        sum.mass_in += l.mass_in;
        sum.mass_binned += l.mass_binned;
        sum.mass_clipped += l.mass_clipped;
        let add = |sum: &mut [f64], x: &[f64]| sum.iter_mut().zip(x).for_each(|(s, x)| *s += x);
        add(&mut sum.momentum_in, &l.momentum_in);
        add(&mut sum.momentum_binned, &l.momentum_binned);
        add(&mut sum.stress_sum_contacts, &l.stress_sum_contacts);
        add(&mut sum.stress_sum_fields, &l.stress_sum_fields);
        sum.stress_scale += l.stress_scale;
        if let Some(field) = fields.get("boundary_force_density") {
            let force = self.boundary_force.get_or_insert_default();
            for (cell, density) in field.data.as_chunks::<3>().0.iter().enumerate() {
                (0..3).for_each(|k| force[k] += density[k] * volume(cell));
            }
        }
        self.results += 1;
    }

    /// Whether there is a result, and none has mass in its cells.
    pub fn is_bare(&self) -> bool {
        self.results > 0 && self.sum.mass_binned <= 0.0
    }

    /// Whether any result has a particle that counts.
    pub fn has_particles(&self) -> bool {
        self.sum.mass_in > 0.0
    }

    fn mean(&self) -> CoarseGrainingLedger {
        let n = self.results.max(1) as f64;
        let l = &self.sum;
        CoarseGrainingLedger {
            mass_in: l.mass_in / n,
            mass_binned: l.mass_binned / n,
            mass_clipped: l.mass_clipped / n,
            momentum_in: l.momentum_in.map(|x| x / n),
            momentum_binned: l.momentum_binned.map(|x| x / n),
            stress_sum_contacts: l.stress_sum_contacts.map(|x| x / n),
            stress_sum_fields: l.stress_sum_fields.map(|x| x / n),
            stress_scale: l.stress_scale / n,
            ..*l
        }
    }

    /// Writes the account as JSON.
    pub fn write(&self, path: &Path, seconds: f64) -> anyhow::Result<()> {
        let l = self.mean();
        let json = Json {
            mass_in: l.mass_in,
            mass_binned: l.mass_binned,
            mass_clipped: l.mass_clipped,
            momentum_in: l.momentum_in,
            momentum_binned: self.has_momentum.then_some(l.momentum_binned),
            stress_sum_contacts: l.stress_sum_contacts,
            stress_sum_fields: self.has_stress.then_some(l.stress_sum_fields),
            balance_residual: self.balance,
            frames: self.seen.frames,
            seconds,
            particles: self.seen.particles,
            contacts: self.seen.contacts.unwrap_or(0),
            cells: self.cells,
        };
        outputs::write_json(path, &json)
    }

    /// What the user should know of sums that are not what they should be.
    pub fn warning(&self) -> Option<String> {
        let l = self.mean();
        if self.repeats {
            return None;
        }
        if self.sampled {
            let share = if l.mass_in > 0.0 { 1.0 - l.mass_clipped / l.mass_in } else { 1.0 };
            return ((share - 1.0).abs() > MOST_OFF).then(|| {
                let more = if share > 1.0 { "" } else { ", or the kernel reaches beyond the outer cells" };
                format!(
                    "the sampled kernel gives the cells {:.1} % of the mass: their centres are too far apart for its width{more}; \
                     give --conserve, finer cells or a larger --width",
                    100.0 * share
                )
            });
        }
        let twice = counted_twice("mass", l.mass_clipped, l.mass_in);
        if twice.is_some() || l.mass_clipped > ROUNDING * l.mass_in {
            return twice;
        }
        let pairs = || l.stress_sum_fields.iter().zip(&l.stress_sum_contacts);
        let off = pairs().map(|(fields, contacts)| (fields - contacts).abs()).fold(0.0, f64::max);
        self.stress_tolerance.filter(|tolerance| off > tolerance * l.stress_scale).map(|_| {
            format!(
                "Σ σ V over the cells differs from Σ f ⊗ l over the contacts by {:.1} % of Σ |f| |l|, though all particles \
                 are in the cells: branches leave the cells, or cells overlap each other; check the contacts' vectors and \
                 the mesh",
                100.0 * off / l.stress_scale
            )
        })
    }

    /// The lines that every run prints.
    pub fn text(&self) -> String {
        let l = self.mean();
        let mut text = String::new();
        let mut line = |name: &str, value: String| {
            let _ = writeln!(text, "{name:<20} {value}");
        };
        let share = |part: f64| if l.mass_in > 0.0 { 100.0 * part / l.mass_in } else { 0.0 };
        line("frames", self.seen.frames.to_string());
        line("particles", self.seen.particles.to_string());
        if let Some(contacts) = self.seen.contacts {
            line("contacts", contacts.to_string());
        }
        line("cells", self.cells.to_string());
        line("mass", short(l.mass_in));
        line("mass binned", format!("{}  ({:.4} %)", short(l.mass_binned), share(l.mass_binned)));
        if self.sampled {
            // Below 0 where the samples happen to be near the particles.
            let (name, off, how) = if l.mass_clipped < 0.0 {
                ("mass in surplus", -l.mass_clipped, "added")
            } else {
                ("mass clipped", l.mass_clipped, "missed")
            };
            line(name, format!("{}  ({:.4} %, {how} by the sampled kernel)", short(off), share(off)));
        } else {
            let (name, value) = clipped("mass clipped", l.mass_clipped, l.mass_in, "outside the cells", short);
            line(name, value);
        }
        line("momentum", vector(&l.momentum_in));
        if self.has_momentum {
            line("momentum binned", vector(&l.momentum_binned));
        }
        if self.seen.contacts.is_some() {
            let rows = |s: &[f64; 9]| format!("{}  {}  {}", vector(&s[..3]), vector(&s[3..6]), vector(&s[6..]));
            line("Σ f ⊗ l, contacts", rows(&l.stress_sum_contacts));
            if self.has_stress {
                line("Σ σ V, cells", rows(&l.stress_sum_fields));
            }
            line("sign of stresses", format!("{} positive", self.sign));
        }
        if let Some(force) = &self.boundary_force {
            let n = self.results.max(1) as f64;
            line("boundary force", vector(&force.map(|f| f / n)));
        }
        if let Some(g) = self.gravity {
            line("weight", vector(&g.map(|g| g * l.mass_in)));
        }
        if let Some(balance) = self.balance {
            line("balance residual", format!("{balance:.1e}  (worst cell, over the largest contact force)"));
        }
        text
    }
}

/// By how much of Σ |f| |l| the cells' stresses may miss Σ f ⊗ l where all particles are in the cells.
fn stress_tolerance(options: &CoarseGrainingOptions) -> Option<f64> {
    match (options.function, options.form()) {
        (Function::Kernel(_), _) | (Function::Overlap(Method::CentreSmoothed), _) | (_, ContactForm::LineIntegral) => {
            None
        }
        (_, ContactForm::ParticleCentred) => Some(1e-6),
        // Branches to points of contact that lie in a wall end beyond the cells.
        (_, ContactForm::BranchInCell) => Some(0.05),
    }
}

/// Whether a field needs the sum of the contact stresses.
fn needs_stress(field: FieldName) -> bool {
    matches!(field, FieldName::ContactStress | FieldName::TotalStress | FieldName::Pressure)
}

/// Whether a field needs the sum of the momenta.
fn needs_momentum(field: FieldName) -> bool {
    use FieldName::*;
    matches!(
        field,
        Momentum | Velocity | KineticStress | GranularTemperature | TotalStress | Pressure | MomentumWithSpin
    )
}

/// Seven digits: what was lost shows in the percentages, and all digits are in the JSON.
fn short(x: f64) -> String {
    let rounded: f64 = format!("{x:.6e}").parse().unwrap_or(x);
    number(rounded)
}

fn vector(v: &[f64]) -> String {
    format!("({})", v.iter().map(|x| short(*x)).collect::<Vec<_>>().join(", "))
}
