//! What to compute, and how.

use fieldstone_particles::{Domain, Particles};

use super::names::FieldName;
use crate::{FieldsError, Kernel, Method, ParcelWeight};

/// How cells see particles.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Function {
    /// By the volume of the particle in the cell, exactly or by one of the approximations ([`Method`]).
    Overlap(Method),
    /// By a kernel at the cell's centre.
    Kernel(Kernel),
}

/// How contacts are spread over cells.
///
/// All three have the same sum over cells that hold the contacts: $\sum_c \sigma_c V_c = \sum f \otimes l$ (exactly but
/// for [`ContactForm::LineIntegral`], which is sampled).
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ContactForm {
    /// With the weights of the particles that touch: $\sum_i \varphi_i \sum_j f_{ij} \otimes l_{ij}$.
    ParticleCentred,
    /// With the kernel averaged along the branch: $\sum f \otimes b \, \psi$ (`goldhirsch2010`). Kernels only.
    LineIntegral,
    /// With the fraction of the branch's length that lies in the cell: the exact cell average of the line integral of a
    /// point kernel.
    BranchInCell,
}

/// Sign of stresses.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum SignConvention {
    /// Compression is positive: $\sigma = -\sum f_{ij} \otimes l_{ij} \dots$, as MercuryCG writes.
    #[default]
    CompressionPositive,
    /// Tension is positive: $\sigma = +\sum f_{ij} \otimes l_{ij} \dots$, the formula of MercuryCG's page on exact overlap.
    /// Kinetic stress changes its sign as well, so that the total stress is their sum in either.
    TensionPositive,
}

impl SignConvention {
    /// What a stress $\sum f_{ij} \otimes l_{ij}$ is multiplied by.
    pub(crate) fn of_force_times_branch(self) -> f64 {
        match self {
            Self::CompressionPositive => -1.0,
            Self::TensionPositive => 1.0,
        }
    }
}

/// The mean velocity that fluctuations are measured from, where several frames are averaged.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum MeanVelocity {
    /// That of the whole window: what is derived from the averaged sums.
    #[default]
    Window,
    /// That of each frame: slow motion of the mean does not count as temperature.
    Frame,
}

/// Which particles count. The others act like walls: their forces on those selected are boundary forces.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Selection {
    /// Types (species); all where `None`.
    pub types: Option<Vec<i64>>,
    /// Least and largest radius, both included.
    pub radii: Option<[f64; 2]>,
    /// Box that holds the centre, both corners included.
    pub region: Option<[[f64; 3]; 2]>,
}

impl Selection {
    /// Refuses ranges that nothing can lie in.
    ///
    /// # Errors
    /// [`FieldsError::Reversed`] where a lower bound is above the upper one or either is NaN.
    pub fn check(&self) -> Result<(), FieldsError> {
        let radii = self.radii.map(|[least, most]| ("radii", least, most));
        let region = self.region.iter().flat_map(|[low, high]| {
            ["x of the region", "y of the region", "z of the region"]
                .into_iter()
                .enumerate()
                .map(|(k, name)| (name, low[k], high[k]))
        });
        match radii.into_iter().chain(region).find(|(_, low, high)| *low > *high || low.is_nan() || high.is_nan()) {
            Some((name, low, high)) => Err(FieldsError::Reversed { name, low, high }),
            None => Ok(()),
        }
    }
}

/// What a quantity of the user's becomes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum QuantityKind {
    /// Density of the sum: $\sum_i \varphi_i q_i$.
    Sum,
    /// Mean by mass: $\sum m \varphi q / \sum m \varphi$.
    MassMean,
    /// Mean by volume: $\sum V \varphi q / \sum V \varphi$.
    VolumeMean,
}

/// A field of any columns that the particles have.
#[derive(Debug, Clone, PartialEq)]
pub struct UserQuantity {
    /// Name of the field.
    pub name: String,
    /// Columns of one number per particle, side by side, by any name that [`Particles::column`] takes: `name` of a scalar, or
    /// `name[k]` for component k of a vector, from 1 as in dumps.
    pub columns: Vec<String>,
    /// What becomes of them.
    pub kind: QuantityKind,
}

impl UserQuantity {
    /// A quantity of whole columns: vectors and tensors become one entry per component.
    ///
    /// # Errors
    /// A column that the particles do not have; a component in brackets of an empty set is left to the frames after it.
    ///
    /// ```
    /// use fieldstone_fields::{QuantityKind, UserQuantity};
    /// use fieldstone_particles::{Particles, Quantity};
    /// let one = Particles::new(vec![[0.0; 3]])?
    ///     .with_quantity(Quantity { name: "force".into(), components: 3, data: vec![0.0; 3] })?;
    /// let quantity = UserQuantity::of_columns("force", &["force"], QuantityKind::Sum, &one)?;
    /// assert_eq!(quantity.columns, ["force[1]", "force[2]", "force[3]"]);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn of_columns(
        name: &str,
        columns: &[&str],
        kind: QuantityKind,
        particles: &Particles,
    ) -> Result<Self, FieldsError> {
        let mut all = Vec::new();
        for &column in columns {
            match particles.column(column) {
                Ok(found) if found.components > 1 => {
                    all.extend((1..=found.components).map(|k| format!("{}[{k}]", found.name)));
                }
                Ok(_) => all.push(column.into()),
                // Not every format has columns where there is no row.
                Err(_) if particles.is_empty() && column.ends_with(']') => all.push(column.into()),
                Err(reason) => return Err(reason.into()),
            }
        }
        Ok(Self { name: name.into(), columns: all, kind })
    }
}

/// Options of [`super::CoarseGraining`]; the default is the 29 standard fields by exact overlap.
#[derive(Debug, Clone, PartialEq)]
pub struct CoarseGrainingOptions {
    /// How cells see particles.
    pub function: Function,
    /// How contacts are spread; `None` is the function's own: particle-centred for overlap, line integral for kernels.
    pub contact_form: Option<ContactForm>,
    /// Fields to compute.
    pub fields: Vec<FieldName>,
    /// Fields of any columns.
    pub quantities: Vec<UserQuantity>,
    /// Sign of stresses.
    pub sign: SignConvention,
    /// Velocity that fluctuations are measured from.
    pub mean_velocity: MeanVelocity,
    /// Whether the contact force density counts forces of walls; the page's sum is over particles.
    pub walls_in_contact_force: bool,
    /// Scale each particle's kernel values so that they sum to its mass, volume, … exactly. Contacts are not scaled.
    pub conserve: bool,
    /// Which particles count.
    pub selection: Selection,
    /// Box whose periodic directions are honoured.
    pub domain: Option<Domain>,
    /// Density of all particles, in place of their own columns `mass` and `density`.
    pub particle_density: Option<f64>,
    /// How many particles each one stands for: every sum over particles, and the ledger, count it as so many, with the
    /// same radius, mass and velocity each. Without contacts only: what one between parcels stands for is not known.
    pub parcel_weight: Option<ParcelWeight>,
}

impl Default for CoarseGrainingOptions {
    fn default() -> Self {
        Self {
            function: Function::Overlap(Method::Kernel),
            contact_form: None,
            fields: FieldName::standard(),
            quantities: Vec::new(),
            sign: SignConvention::default(),
            mean_velocity: MeanVelocity::default(),
            walls_in_contact_force: true,
            conserve: false,
            selection: Selection::default(),
            domain: None,
            particle_density: None,
            parcel_weight: None,
        }
    }
}

impl CoarseGrainingOptions {
    /// The form in which contacts are spread.
    pub fn form(&self) -> ContactForm {
        self.contact_form.unwrap_or(match self.function {
            Function::Overlap(_) => ContactForm::ParticleCentred,
            Function::Kernel(_) => ContactForm::LineIntegral,
        })
    }

    pub(crate) fn validate(&self) -> Result<(), FieldsError> {
        if self.form() == ContactForm::LineIntegral && matches!(self.function, Function::Overlap(_)) {
            return Err(FieldsError::Combination {
                what: "line integrals along branches need a kernel; with overlaps choose the particle-centred form or the branch in the cell",
            });
        }
        if self.fields.contains(&FieldName::MomentumWithSpin)
            && !matches!(self.function, Function::Overlap(m) if m.is_exact())
        {
            return Err(FieldsError::Combination {
                what: "the momentum of spinning spheres needs exact overlaps (function exact)",
            });
        }
        if let Some(value) = self.particle_density
            && !(value > 0.0 && value.is_finite())
        {
            return Err(FieldsError::Option { name: "the particle density", value, allowed: "positive and finite" });
        }
        self.selection.check()?;
        let mut names: Vec<&str> = self.fields.iter().map(|f| f.name()).collect();
        for quantity in &self.quantities {
            if quantity.columns.is_empty() {
                return Err(FieldsError::Combination { what: "a quantity needs at least one column" });
            }
            if names.contains(&quantity.name.as_str()) || quantity.name.is_empty() {
                return Err(FieldsError::DuplicateField(quantity.name.clone()));
            }
            names.push(&quantity.name);
        }
        Ok(())
    }
}
