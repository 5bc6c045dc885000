//! Fields from the sums: linear ones by a division, the others derived once, at the end.

use fieldstone_mesh::Cells;
use rayon::prelude::*;

use super::fields::{Field, component_names};
use super::layout::{Column, GROUPS, Group, Layout, Slot};
use super::names::FieldName;
use super::options::{QuantityKind, SignConvention, UserQuantity};
use super::strain::displacement_gradient;
use crate::NeumaierSum;
use crate::scatter::Sums;

/// Cells handled by one task: their sums fit a cache.
const CHUNK: usize = 1024;

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

/// Some cells in a row: the first, and for each one over volume and time.
struct Part<'a> {
    first: usize,
    scales: &'a [f64],
}

impl<C: Cells> Densities<'_, C> {
    /// Densities of a cell of a part: the sum over its volume and the time.
    #[inline]
    fn get<const N: usize>(&self, part: &Part<'_>, cell: usize, slot: Slot) -> [f64; N] {
        let sums = &self.sums[slot.group as usize].cell(part.first + cell)[slot.start..slot.start + N];
        let scale = if self.per_cell[slot.group as usize] { part.scales[cell] } else { 1.0 / self.time };
        std::array::from_fn(|k| sums[k] * scale)
    }

    fn slot(&self, column: Column) -> Slot {
        // Every ingredient of a field is laid out with it.
        self.layout.find(column).unwrap_or(Slot { group: Group::Particle, start: 0, width: 0 })
    }

    fn linear<const N: usize>(&self, part: &Part<'_>, out: &mut [f64], column: Column) {
        let slot = self.slot(column);
        each::<N>(out, |cell| self.get(part, cell, slot));
    }

    /// Adds density × cell volume × time of some cells to totals; nothing where the sum is not kept.
    fn add_totals(&self, column: Column, part: &Part<'_>, totals: &mut [NeumaierSum]) {
        let Some(slot) = self.layout.find(column) else { return };
        let sums = &self.sums[slot.group as usize];
        let per_cell = self.per_cell[slot.group as usize];
        for (k, scale) in part.scales.iter().enumerate() {
            let volume = if per_cell { 1.0 } else { 1.0 / (scale * self.time) };
            let sums = &sums.cell(part.first + k)[slot.start..];
            totals.iter_mut().zip(sums).for_each(|(total, sum)| total.add(sum * volume));
        }
    }

    /// u = j/ρ; nothing moves where there is no mass.
    fn ratio<const N: usize>(&self, part: &Part<'_>, out: &mut [f64], numerator: Column, denominator: Column) {
        let (a, b) = (self.slot(numerator), self.slot(denominator));
        each::<N>(out, |cell| over(self.get(part, cell, a), self.get::<1>(part, cell, b)[0]));
    }

    /// Compression-positive kinetic stress k − ρ u⊗u of one cell.
    fn kinetic_stress<'a>(&'a self, part: &'a Part<'_>) -> impl Fn(usize) -> [f64; 6] + 'a {
        let [flux, mass, momentum] = [Column::MomentumFlux, Column::Mass, Column::Momentum].map(|c| self.slot(c));
        let mean = self.layout.find(Column::MeanFlux);
        move |cell| {
            let k: [f64; 6] = self.get(part, cell, flux);
            let mean: [f64; 6] = match mean {
                Some(slot) => self.get(part, cell, slot),
                None => {
                    let j: [f64; 3] = self.get(part, cell, momentum);
                    mean_flux(self.get::<1>(part, cell, mass)[0], j)
                }
            };
            // What rounding leaves of the difference on the diagonal is nothing.
            std::array::from_fn(|n| {
                let d = k[n] - mean[n];
                if matches!(n, 0 | 3 | 5) { d.max(0.0) } else { d }
            })
        }
    }

    fn total_stress<'a>(&'a self, part: &'a Part<'_>) -> impl Fn(usize) -> [f64; 9] + 'a {
        let contact = self.slot(Column::Stress);
        let kinetic = self.kinetic_stress(part);
        let sign = -self.sign.of_force_times_branch();
        move |cell| {
            let c: [f64; 9] = self.get(part, cell, contact);
            let k = full(kinetic(cell));
            std::array::from_fn(|n| c[n] + sign * k[n])
        }
    }

    /// A field by name, in some cells.
    fn fill(&self, field: FieldName, part: &Part<'_>, out: &mut [f64]) {
        let compression = -self.sign.of_force_times_branch();
        match field {
            FieldName::VolumeFraction => self.linear::<1>(part, out, Column::Volume),
            FieldName::Density => self.linear::<1>(part, out, Column::Mass),
            FieldName::Momentum => self.linear::<3>(part, out, Column::Momentum),
            FieldName::MomentumFlux => self.linear::<6>(part, out, Column::MomentumFlux),
            FieldName::ContactStress => self.linear::<9>(part, out, Column::Stress),
            FieldName::BoundaryForceDensity => self.linear::<3>(part, out, Column::BoundaryForce),
            FieldName::ParticleSize => self.linear::<6>(part, out, Column::Size),
            FieldName::ContactForceDensity => self.linear::<3>(part, out, Column::ContactForce),
            FieldName::Velocity => self.ratio::<3>(part, out, Column::Momentum, Column::Mass),
            FieldName::KineticStress => {
                let stress = self.kinetic_stress(part);
                each(out, |cell| stress(cell).map(|s| compression * s))
            }
            FieldName::GranularTemperature => {
                let (stress, mass) = (self.kinetic_stress(part), self.slot(Column::Mass));
                each(out, |cell| {
                    let s = stress(cell);
                    over([s[0] + s[3] + s[5]], 3.0 * self.get::<1>(part, cell, mass)[0])
                })
            }
            FieldName::TotalStress => {
                let stress = self.total_stress(part);
                each(out, stress)
            }
            FieldName::Pressure => {
                let stress = self.total_stress(part);
                each(out, |cell| {
                    let s = stress(cell);
                    [(s[0] + s[4] + s[8]) / 3.0]
                })
            }
            FieldName::KineticEnergyDensity => self.linear::<1>(part, out, Column::KineticEnergy),
            FieldName::KineticEnergyFlux => self.linear::<3>(part, out, Column::KineticEnergyFlux),
            FieldName::ContactEnergyFlux => self.linear::<3>(part, out, Column::ContactEnergy),
            FieldName::AngularMomentum => self.linear::<3>(part, out, Column::AngularMomentum),
            FieldName::SpinDensity => self.linear::<3>(part, out, Column::Spin),
            FieldName::AngularVelocity => self.ratio::<3>(part, out, Column::Spin, Column::Inertia),
            FieldName::MomentumWithSpin => {
                let (centre, spin) = (self.slot(Column::Momentum), self.slot(Column::SpinMomentum));
                each::<3>(out, |cell| {
                    let (a, b): ([f64; 3], [f64; 3]) = (self.get(part, cell, centre), self.get(part, cell, spin));
                    std::array::from_fn(|k| a[k] + b[k])
                })
            }
            FieldName::Fabric => self.linear::<6>(part, out, Column::Fabric),
            FieldName::CoordinationNumber => self.ratio::<1>(part, out, Column::ContactCount, Column::Size),
            FieldName::CoupleStress => self.linear::<9>(part, out, Column::Couple),
            FieldName::MeanRadius => {
                let size = self.slot(Column::Size);
                each(out, |cell| {
                    let [number, radius]: [f64; 2] = self.get(part, cell, size);
                    over([radius], number)
                })
            }
            FieldName::Displacement => self.ratio::<3>(part, out, Column::MassDisplacement, Column::Mass),
            FieldName::DisplacementGradient => {
                let gradient = self.gradient(part);
                each(out, gradient)
            }
            FieldName::StrainIncrement => {
                let gradient = self.gradient(part);
                each(out, |cell| {
                    let g = gradient(cell);
                    let s = |a: usize, b: usize| 0.5 * (g[3 * a + b] + g[3 * b + a]);
                    [s(0, 0), s(0, 1), s(0, 2), s(1, 1), s(1, 2), s(2, 2)]
                })
            }
        }
    }

    fn gradient<'a>(&'a self, part: &'a Part<'_>) -> impl Fn(usize) -> [f64; 9] + 'a {
        use Column::*;
        let slots = [Mass, MassPosition, MassPosition2, MassDisplacement, MassDisplacementPosition]
            .map(|column| self.slot(column));
        move |cell| {
            displacement_gradient(
                self.get::<1>(part, cell, slots[0])[0],
                self.get(part, cell, slots[1]),
                self.get(part, cell, slots[2]),
                self.get(part, cell, slots[3]),
                self.get(part, cell, slots[4]),
            )
        }
    }

    /// A field of the user's columns, in some cells.
    fn fill_user(&self, index: usize, quantity: &UserQuantity, part: &Part<'_>, out: &mut [f64]) {
        let slot = self.slot(Column::User(index));
        let by = match quantity.kind {
            QuantityKind::Sum => None,
            QuantityKind::MassMean => Some(self.slot(Column::Mass)),
            QuantityKind::VolumeMean => Some(self.slot(Column::Volume)),
        };
        for (cell, out) in out.chunks_exact_mut(slot.width.max(1)).enumerate() {
            for (k, out) in out.iter_mut().enumerate() {
                let value = self.get::<1>(part, cell, Slot { start: slot.start + k, ..slot });
                [*out] = match by {
                    None => value,
                    Some(by) => over(value, self.get::<1>(part, cell, by)[0]),
                };
            }
        }
    }

    /// All fields and what the ledger states of them, in one pass over the sums.
    pub fn fields(&self, names: &[FieldName], quantities: &[UserQuantity]) -> (Vec<Field>, Totals) {
        let count = self.cells.cell_count();
        let named = names.iter().map(|field| Field {
            name: field.name().into(),
            components: field.components().iter().map(|c| (*c).into()).collect(),
            unit: field.unit().into(),
            data: vec![0.0; count * field.components().len()],
        });
        let users = quantities.iter().map(|quantity| {
            let width = quantity.columns.len();
            Field {
                name: quantity.name.clone(),
                components: component_names(quantity.columns.len()),
                unit: if quantity.kind == QuantityKind::Sum { "quantity/length³" } else { "quantity" }.into(),
                data: vec![0.0; count * width],
            }
        });
        let mut fields: Vec<Field> = named.chain(users).collect();
        // For each chunk of cells its part of every field.
        let mut parts: Vec<Vec<&mut [f64]>> = (0..count.div_ceil(CHUNK)).map(|_| Vec::new()).collect();
        for field in &mut fields {
            let width = field.components.len().max(1);
            parts.iter_mut().zip(field.data.chunks_mut(width * CHUNK)).for_each(|(part, data)| part.push(data));
        }
        let totals: Vec<[NeumaierSum; 13]> = parts
            .into_par_iter()
            .enumerate()
            .map(|(chunk, outputs)| {
                let first = chunk * CHUNK;
                let scales: Vec<f64> = (first..(first + CHUNK).min(count))
                    .map(|cell| 1.0 / (self.cells.cell_volume(cell) * self.time))
                    .collect();
                let part = Part { first, scales: &scales };
                for (k, out) in outputs.into_iter().enumerate() {
                    match names.get(k) {
                        Some(&field) => self.fill(field, &part, out),
                        None => self.fill_user(k - names.len(), &quantities[k - names.len()], &part, out),
                    }
                }
                let mut totals = [NeumaierSum::default(); 13];
                self.add_totals(Column::Mass, &part, &mut totals[..1]);
                self.add_totals(Column::Momentum, &part, &mut totals[1..4]);
                self.add_totals(Column::Stress, &part, &mut totals[4..]);
                totals
            })
            .collect();
        // Chunk by chunk, so that the sums do not depend on the number of threads.
        let total = |k: usize| totals.iter().map(|t| t[k].value()).collect::<NeumaierSum>().value() / self.time;
        let totals = Totals {
            mass: total(0),
            momentum: std::array::from_fn(|k| total(1 + k)),
            stress: std::array::from_fn(|k| total(4 + k)),
        };
        (fields, totals)
    }
}

/// Sums over all cells of density × cell volume.
pub(super) struct Totals {
    pub mass: f64,
    pub momentum: [f64; 3],
    pub stress: [f64; 9],
}

#[inline]
fn each<const N: usize>(out: &mut [f64], value: impl Fn(usize) -> [f64; N]) {
    for (cell, out) in out.chunks_exact_mut(N).enumerate() {
        out.copy_from_slice(&value(cell));
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
