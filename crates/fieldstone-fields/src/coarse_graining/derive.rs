//! Fields from the sums: linear ones by a division, the others derived once, at the end.

use fieldstone_mesh::Cells;
use rayon::prelude::*;

use super::fields::Field;
use super::layout::{Column, GROUPS, Group, Layout, Slot};
use super::names::FieldName;
use super::options::{QuantityKind, SignConvention, UserQuantity};
use super::strain::displacement_gradient;
use crate::scatter::Sums;

/// Cells handled by one task.
const CHUNK: usize = 4096;

/// The sums of all cells, and what turns them into densities.
pub(super) struct Densities<'a, C: Cells> {
    pub cells: &'a C,
    pub layout: &'a Layout,
    pub sums: &'a [Sums; GROUPS.len()],
    /// Whether the sums of a group are of the cell, or already densities.
    pub per_cell: [bool; GROUPS.len()],
    /// Σ of the weights of the frames.
    pub time: f64,
    pub sign: SignConvention,
}

impl<C: Cells> Densities<'_, C> {
    /// Densities of one cell: the sum over its volume and the time.
    fn get<const N: usize>(&self, cell: usize, slot: Slot) -> [f64; N] {
        let sums = self.sums[slot.group as usize].cell(cell);
        let scale = if self.per_cell[slot.group as usize] {
            1.0 / (self.cells.cell_volume(cell) * self.time)
        } else {
            1.0 / self.time
        };
        std::array::from_fn(|k| sums[slot.start + k] * scale)
    }

    fn slot(&self, column: Column) -> Slot {
        // Every ingredient of a field is laid out with it; an empty slot gives zeros for what never was asked for.
        self.layout.find(column).unwrap_or(Slot { group: Group::Particle, start: 0, width: 0 })
    }

    fn each<const N: usize>(&self, value: impl Fn(usize) -> [f64; N] + Sync) -> Vec<f64> {
        let mut data = vec![0.0; N * self.cells.cell_count()];
        data.par_chunks_mut(N * CHUNK).enumerate().for_each(|(chunk, part)| {
            for (k, out) in part.chunks_exact_mut(N).enumerate() {
                out.copy_from_slice(&value(chunk * CHUNK + k));
            }
        });
        data
    }

    fn linear<const N: usize>(&self, column: Column) -> Vec<f64> {
        let slot = self.slot(column);
        self.each::<N>(|cell| self.get(cell, slot))
    }

    /// Σ over cells of density × cell volume.
    pub fn total<const N: usize>(&self, column: Column) -> [f64; N] {
        let Some(slot) = self.layout.find(column) else { return [0.0; N] };
        let mut totals = [crate::NeumaierSum::default(); N];
        for cell in 0..self.cells.cell_count() {
            let sums = &self.sums[slot.group as usize].cell(cell)[slot.start..];
            let scale = if self.per_cell[slot.group as usize] { 1.0 } else { self.cells.cell_volume(cell) };
            (0..N).for_each(|k| totals[k].add(sums[k] * scale));
        }
        totals.map(|t| t.value() / self.time)
    }

    /// u = j/ρ; nothing moves where there is no mass.
    fn ratio<const N: usize>(&self, numerator: Column, denominator: Column) -> Vec<f64> {
        let (a, b) = (self.slot(numerator), self.slot(denominator));
        self.each::<N>(|cell| over(self.get(cell, a), self.get::<1>(cell, b)[0]))
    }

    /// Compression-positive kinetic stress k − ρ u⊗u of one cell.
    fn kinetic_stress(&self) -> impl Fn(usize) -> [f64; 6] + Sync + '_ {
        let [flux, mass, momentum] = [Column::MomentumFlux, Column::Mass, Column::Momentum].map(|c| self.slot(c));
        let mean = self.layout.find(Column::MeanFlux);
        move |cell| {
            let k: [f64; 6] = self.get(cell, flux);
            let mean: [f64; 6] = match mean {
                Some(slot) => self.get(cell, slot),
                None => {
                    let j: [f64; 3] = self.get(cell, momentum);
                    mean_flux(self.get::<1>(cell, mass)[0], j)
                }
            };
            // What rounding leaves of the difference on the diagonal is nothing.
            std::array::from_fn(|n| {
                let d = k[n] - mean[n];
                if matches!(n, 0 | 3 | 5) { d.max(0.0) } else { d }
            })
        }
    }

    fn total_stress(&self) -> impl Fn(usize) -> [f64; 9] + Sync + '_ {
        let contact = self.slot(Column::Stress);
        let kinetic = self.kinetic_stress();
        let sign = -self.sign.of_force_times_branch();
        move |cell| {
            let c: [f64; 9] = self.get(cell, contact);
            let k = full(kinetic(cell));
            std::array::from_fn(|n| c[n] + sign * k[n])
        }
    }

    fn data(&self, field: FieldName) -> Vec<f64> {
        let compression = -self.sign.of_force_times_branch();
        match field {
            FieldName::VolumeFraction => self.linear::<1>(Column::Volume),
            FieldName::Density => self.linear::<1>(Column::Mass),
            FieldName::Momentum => self.linear::<3>(Column::Momentum),
            FieldName::MomentumFlux => self.linear::<6>(Column::MomentumFlux),
            FieldName::ContactStress => self.linear::<9>(Column::Stress),
            FieldName::BoundaryForceDensity => self.linear::<3>(Column::BoundaryForce),
            FieldName::ParticleSize => self.linear::<6>(Column::Size),
            FieldName::ContactForceDensity => self.linear::<3>(Column::ContactForce),
            FieldName::Velocity => self.ratio::<3>(Column::Momentum, Column::Mass),
            FieldName::KineticStress => {
                let stress = self.kinetic_stress();
                self.each(|cell| stress(cell).map(|s| compression * s))
            }
            FieldName::GranularTemperature => {
                let (stress, mass) = (self.kinetic_stress(), self.slot(Column::Mass));
                self.each(|cell| {
                    let s = stress(cell);
                    over([s[0] + s[3] + s[5]], 3.0 * self.get::<1>(cell, mass)[0])
                })
            }
            FieldName::TotalStress => {
                let stress = self.total_stress();
                self.each(stress)
            }
            FieldName::Pressure => {
                let stress = self.total_stress();
                self.each(|cell| {
                    let s = stress(cell);
                    [(s[0] + s[4] + s[8]) / 3.0]
                })
            }
            FieldName::KineticEnergyDensity => self.linear::<1>(Column::KineticEnergy),
            FieldName::KineticEnergyFlux => self.linear::<3>(Column::KineticEnergyFlux),
            FieldName::ContactEnergyFlux => self.linear::<3>(Column::ContactEnergy),
            FieldName::AngularMomentum => self.linear::<3>(Column::AngularMomentum),
            FieldName::SpinDensity => self.linear::<3>(Column::Spin),
            FieldName::AngularVelocity => self.ratio::<3>(Column::Spin, Column::Inertia),
            FieldName::MomentumWithSpin => {
                let (centre, spin) = (self.slot(Column::Momentum), self.slot(Column::SpinMomentum));
                self.each::<3>(|cell| {
                    let (a, b): ([f64; 3], [f64; 3]) = (self.get(cell, centre), self.get(cell, spin));
                    std::array::from_fn(|k| a[k] + b[k])
                })
            }
            FieldName::Fabric => self.linear::<6>(Column::Fabric),
            FieldName::CoordinationNumber => self.ratio::<1>(Column::ContactCount, Column::Size),
            FieldName::CoupleStress => self.linear::<9>(Column::Couple),
            FieldName::MeanRadius => {
                let size = self.slot(Column::Size);
                self.each(|cell| {
                    let [number, radius]: [f64; 2] = self.get(cell, size);
                    over([radius], number)
                })
            }
            FieldName::Displacement => self.ratio::<3>(Column::MassDisplacement, Column::Mass),
            FieldName::DisplacementGradient => {
                let gradient = self.gradient();
                self.each(gradient)
            }
            FieldName::StrainIncrement => {
                let gradient = self.gradient();
                self.each(|cell| {
                    let g = gradient(cell);
                    let s = |a: usize, b: usize| 0.5 * (g[3 * a + b] + g[3 * b + a]);
                    [s(0, 0), s(0, 1), s(0, 2), s(1, 1), s(1, 2), s(2, 2)]
                })
            }
        }
    }

    fn gradient(&self) -> impl Fn(usize) -> [f64; 9] + Sync + '_ {
        use Column::*;
        let slots = [Mass, MassPosition, MassPosition2, MassDisplacement, MassDisplacementPosition]
            .map(|column| self.slot(column));
        move |cell| {
            displacement_gradient(
                self.get::<1>(cell, slots[0])[0],
                self.get(cell, slots[1]),
                self.get(cell, slots[2]),
                self.get(cell, slots[3]),
                self.get(cell, slots[4]),
            )
        }
    }

    /// A field by name.
    pub fn field(&self, field: FieldName) -> Field {
        Field {
            name: field.name().into(),
            components: field.components().iter().map(|c| (*c).into()).collect(),
            unit: field.unit().into(),
            data: self.data(field),
        }
    }

    /// A field of the user's columns.
    pub fn user_field(&self, index: usize, quantity: &UserQuantity) -> Field {
        let width = quantity.columns.len();
        let slot = self.slot(Column::User(index));
        let by = match quantity.kind {
            QuantityKind::Sum => None,
            QuantityKind::MassMean => Some(self.slot(Column::Mass)),
            QuantityKind::VolumeMean => Some(self.slot(Column::Volume)),
        };
        let mut data = vec![0.0; width * self.cells.cell_count()];
        data.par_chunks_mut(width.max(1)).enumerate().for_each(|(cell, out)| {
            for (k, out) in out.iter_mut().enumerate() {
                let [value] = self.get::<1>(cell, Slot { start: slot.start + k, ..slot });
                *out = match by {
                    None => value,
                    Some(by) => over([value], self.get::<1>(cell, by)[0])[0],
                };
            }
        });
        Field {
            name: quantity.name.clone(),
            components: if width == 1 { vec![String::new()] } else { quantity.columns.clone() },
            unit: match quantity.kind {
                QuantityKind::Sum => "quantity/length³".into(),
                _ => "quantity".into(),
            },
            data,
        }
    }
}

/// ρ u⊗u from density and momentum.
pub(super) fn mean_flux(mass: f64, j: [f64; 3]) -> [f64; 6] {
    let u = over(j, mass);
    [j[0] * u[0], j[0] * u[1], j[0] * u[2], j[1] * u[1], j[1] * u[2], j[2] * u[2]]
}

/// Quotient; zero where there is nothing to divide by.
fn over<const N: usize>(values: [f64; N], by: f64) -> [f64; N] {
    if by > 0.0 { values.map(|v| v / by) } else { [0.0; N] }
}

/// All nine components of a symmetric tensor.
fn full(s: [f64; 6]) -> [f64; 9] {
    [s[0], s[1], s[2], s[1], s[3], s[4], s[2], s[4], s[5]]
}
