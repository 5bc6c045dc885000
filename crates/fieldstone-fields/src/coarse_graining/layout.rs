//! Which sums are kept, and where: only what the fields asked for are made of.

use super::names::FieldName;
use super::options::{CoarseGrainingOptions, ContactForm, MeanVelocity, QuantityKind};

/// A linear sum over particles or contacts.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Column {
    Volume,
    Mass,
    Momentum,
    MomentumFlux,
    Size,
    ContactForce,
    Stress,
    BoundaryForce,
    ContactCount,
    Fabric,
    Couple,
    ContactEnergy,
    KineticEnergy,
    KineticEnergyFlux,
    AngularMomentum,
    Spin,
    Inertia,
    SpinMomentum,
    MassPosition,
    MassPosition2,
    MassDisplacement,
    MassDisplacementPosition,
    /// ρ u⊗u of each frame.
    MeanFlux,
    /// Columns of the user's quantity of this index.
    User(usize),
}

/// Sums with the same weights.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Group {
    /// Weights of particles.
    Particle,
    /// Weights of branches.
    Branch,
    /// Weights of contact points.
    Point,
    /// First moments of overlaps.
    Moment,
    /// Products of sums, frame by frame.
    Frame,
}

pub(super) const GROUPS: [Group; 5] = [Group::Particle, Group::Branch, Group::Point, Group::Moment, Group::Frame];

/// Where a sum is kept.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Slot {
    pub group: Group,
    pub start: usize,
    pub width: usize,
}

/// The sums that are kept.
#[derive(Debug, Clone)]
pub(super) struct Layout {
    slots: Vec<(Column, Slot)>,
    widths: [usize; GROUPS.len()],
}

impl Layout {
    pub fn new(options: &CoarseGrainingOptions) -> Self {
        let mut layout = Self { slots: Vec::new(), widths: [0; GROUPS.len()] };
        let form = options.form();
        // The ledger needs mass, and momentum where there is one.
        layout.keep(Column::Mass, 1, form);
        for &field in &options.fields {
            for &(column, width) in ingredients(field) {
                layout.keep(column, width, form);
            }
            let fluctuates = matches!(
                field,
                FieldName::KineticStress
                    | FieldName::GranularTemperature
                    | FieldName::TotalStress
                    | FieldName::Pressure
            );
            if fluctuates && options.mean_velocity == MeanVelocity::Frame {
                layout.keep(Column::MeanFlux, 6, form);
            }
        }
        for (index, quantity) in options.quantities.iter().enumerate() {
            if quantity.kind == QuantityKind::VolumeMean {
                layout.keep(Column::Volume, 1, form);
            }
            // Its width is known with the first frame only.
            layout.keep(Column::User(index), quantity.columns.len(), form);
        }
        layout
    }

    fn keep(&mut self, column: Column, width: usize, form: ContactForm) {
        if self.find(column).is_some() {
            return;
        }
        let group = match column {
            Column::Stress | Column::Fabric | Column::Couple | Column::ContactEnergy
                if form != ContactForm::ParticleCentred =>
            {
                Group::Branch
            }
            Column::BoundaryForce if form != ContactForm::ParticleCentred => Group::Point,
            Column::SpinMomentum => Group::Moment,
            Column::MeanFlux => Group::Frame,
            _ => Group::Particle,
        };
        let start = &mut self.widths[group as usize];
        self.slots.push((column, Slot { group, start: *start, width }));
        *start += width;
    }

    pub fn find(&self, column: Column) -> Option<Slot> {
        self.slots.iter().find(|(c, _)| *c == column).map(|&(_, slot)| slot)
    }

    /// Slot of a column within `group`; `None` where it is not kept there.
    pub fn within(&self, group: Group, column: Column) -> Option<Slot> {
        self.find(column).filter(|slot| slot.group == group)
    }

    pub fn width(&self, group: Group) -> usize {
        self.widths[group as usize]
    }

    /// Whether any of the columns is kept.
    pub fn any(&self, columns: &[Column]) -> bool {
        columns.iter().any(|&c| self.find(c).is_some())
    }
}

/// The sums that a field is made of, and their widths.
fn ingredients(field: FieldName) -> &'static [(Column, usize)] {
    use Column::*;
    match field {
        FieldName::VolumeFraction => &[(Volume, 1)],
        FieldName::Density => &[(Mass, 1)],
        FieldName::Momentum => &[(Momentum, 3)],
        FieldName::MomentumFlux => &[(MomentumFlux, 6)],
        FieldName::ContactStress => &[(Stress, 9)],
        FieldName::BoundaryForceDensity => &[(BoundaryForce, 3)],
        FieldName::ParticleSize | FieldName::MeanRadius => &[(Size, 6)],
        FieldName::ContactForceDensity => &[(ContactForce, 3)],
        FieldName::Velocity => &[(Mass, 1), (Momentum, 3)],
        FieldName::KineticStress | FieldName::GranularTemperature => &[(Mass, 1), (Momentum, 3), (MomentumFlux, 6)],
        FieldName::TotalStress | FieldName::Pressure => &[(Mass, 1), (Momentum, 3), (MomentumFlux, 6), (Stress, 9)],
        FieldName::KineticEnergyDensity => &[(KineticEnergy, 1)],
        FieldName::KineticEnergyFlux => &[(KineticEnergyFlux, 3)],
        FieldName::ContactEnergyFlux => &[(ContactEnergy, 3)],
        FieldName::AngularMomentum => &[(AngularMomentum, 3)],
        FieldName::SpinDensity => &[(Spin, 3)],
        FieldName::AngularVelocity => &[(Spin, 3), (Inertia, 1)],
        FieldName::MomentumWithSpin => &[(Momentum, 3), (SpinMomentum, 3)],
        FieldName::Fabric => &[(Fabric, 6)],
        FieldName::CoordinationNumber => &[(Size, 6), (ContactCount, 1)],
        FieldName::CoupleStress => &[(Couple, 9)],
        FieldName::Displacement => &[(Mass, 1), (MassDisplacement, 3)],
        FieldName::DisplacementGradient | FieldName::StrainIncrement => {
            &[(Mass, 1), (MassDisplacement, 3), (MassPosition, 3), (MassPosition2, 6), (MassDisplacementPosition, 9)]
        }
    }
}
