//! Coarse graining: fields from particles and contacts, by any weights, on any cells.

mod derive;
mod fields;
mod frame;
mod layout;
mod names;
mod options;
mod particle_sums;
mod places;
mod segments;
mod strain;
mod weigh;

use std::sync::atomic::{AtomicU64, Ordering};

use fieldstone_geometry::{ElementKind, Polyhedron};
use fieldstone_mesh::Cells;
use fieldstone_particles::{Contact, Contacts, Particles, Partner};
use rayon::prelude::*;

use crate::binning::Binning;
use crate::scatter::{Order, Pair, Sums};
use crate::{FieldsError, NeumaierSum};

use crate::periodic::{Periods, longest_branch};
use derive::Densities;
pub use fields::{CoarseGrainingLedger, Field, Fields, component_names};
use frame::Frame;
use layout::{Column, GROUPS, Group, Layout};
pub use names::FieldName;
pub use options::{
    CoarseGrainingOptions, ContactForm, Function, MeanVelocity, QuantityKind, Selection, SignConvention, UserQuantity,
};
use particle_sums::{branch_quantities, contact_sums, cross, outer, particle_quantities};
use segments::Segments;
pub use strain::displacements;
use weigh::{ContactWeights, ParticleWeights, Sampling, Scratch, Weigher};

/// Fields of particles and their contacts: frames go in one by one, fields come out at the end.
///
/// $$ F_c = \frac{1}{\sum_t w_t} \sum_t w_t \sum_i \varphi_{ci}\, q_i $$
///
/// | symbol | meaning |
/// |---|---|
/// | φ | weight of a particle in a cell: $V_{c \cap i}/(V_c V_i)$, or a kernel at the cell's centre |
/// | q | a quantity of the particle: volume, mass, momentum, the sum of f ⊗ l over its contacts, … |
/// | w_t | weight of a frame |
///
/// Only such linear sums are accumulated; velocity, kinetic stress, temperature and pressure are derived once, by
/// [`CoarseGraining::finish`]. [`FieldName`] has the formulas.
///
/// Positions and radii come from the particles; their columns `mass` (else `density`), `velocity`, `angular_velocity` and
/// `displacement` are needed where a field asks for them. [`CoarseGrainingOptions::particle_density`] stands in place of
/// the particles' own masses.
///
/// Exact weights conserve: Σ ρ V_c is the mass inside the cells to rounding. Kernels are values at points and do not,
/// unless [`CoarseGrainingOptions::conserve`] scales them to.
///
/// Same input, same bits, for any number of threads. Cost: linear in particles, contacts, pairs of particle and cell
/// touched, and cells; memory: one number per cell and component, and the pairs of a few thousand particles at a time.
///
/// ```
/// use fieldstone_fields::{CoarseGraining, CoarseGrainingOptions};
/// use fieldstone_mesh::Grid;
/// use fieldstone_particles::{Contact, Contacts, Particles, Partner, Quantity};
/// // Two balls pressed against each other with a force of 2.
/// let two = Particles::new(vec![[0.5, 0.5, 0.5], [1.5, 0.5, 0.5]])?
///     .with_uniform_radius(0.5)?
///     .with_quantity(Quantity { name: "velocity".into(), components: 3, data: vec![0.0; 6] })?;
/// let mut contacts = Contacts::new();
/// let (arm, branch) = ([0.5, 0.0, 0.0], [1.0, 0.0, 0.0]);
/// contacts.push(2, Contact { particle: 0, partner: Partner::Particle(1), force: [-2.0, 0.0, 0.0], arm, branch })?;
///
/// let grid = Grid::new([0.0; 3], [2.0, 1.0, 1.0], [2, 1, 1])?;
/// let options = CoarseGrainingOptions { particle_density: Some(3.0), ..CoarseGrainingOptions::default() };
/// let mut grains = CoarseGraining::new(&grid, options)?;
/// grains.accumulate(&two, Some(&contacts), 1.0)?;
/// let fields = grains.finish()?;
/// // Half of f ⊗ b in each unit cell, compression positive.
/// let stress = fields.get("contact_stress").ok_or("missing")?;
/// assert_eq!(stress.cell(0)[0], 1.0);
/// assert!((fields.ledger.mass_binned - fields.ledger.mass_in).abs() < 1e-15);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// Source: `weinhart2012`, `goldhirsch2010`; for exact overlaps MercuryCG's page and `strobl2016`.
#[derive(Debug)]
pub struct CoarseGraining<'a, C: Cells> {
    cells: &'a C,
    options: CoarseGrainingOptions,
    layout: Layout,
    sums: [Sums; GROUPS.len()],
    time: f64,
    ledger: CoarseGrainingLedger,
    totals: Totals,
}

/// Sums over frames for the ledger.
#[derive(Debug, Default)]
struct Totals {
    mass: NeumaierSum,
    clipped: NeumaierSum,
    momentum: [NeumaierSum; 3],
    stress: [NeumaierSum; 9],
    stress_scale: NeumaierSum,
}

impl<'a, C: Cells> CoarseGraining<'a, C> {
    /// Nothing accumulated yet.
    ///
    /// # Errors
    /// Options out of range or that do not go together.
    pub fn new(cells: &'a C, options: CoarseGrainingOptions) -> Result<Self, FieldsError> {
        options.validate()?;
        if let Function::Overlap(method) = options.function {
            Binning::check(cells, method)?;
        }
        if options.fields.contains(&FieldName::MomentumWithSpin) && !cells.is_polyhedral() {
            return Err(FieldsError::Combination {
                what: "the momentum of spinning spheres needs cells with planar faces; leave it out on round ones",
            });
        }
        let layout = Layout::new(&options);
        let sums = GROUPS.map(|group| Sums::new(cells.cell_count(), layout.width(group)));
        Ok(Self {
            cells,
            options,
            layout,
            sums,
            time: 0.0,
            ledger: CoarseGrainingLedger::default(),
            totals: Totals::default(),
        })
    }

    /// Adds a frame: its particles, its contacts where fields need them, and its weight in time.
    ///
    /// # Errors
    /// Columns that are missing or not finite; contacts missing where a field needs them, and contacts of particles with
    /// parcel weights; a weight that is negative or
    /// not finite; particles, branches or a kernel that reach so far that more than 10⁵ copies of the periodic box would
    /// have to be gone through.
    pub fn accumulate(
        &mut self,
        particles: &Particles,
        contacts: Option<&Contacts>,
        weight: f64,
    ) -> Result<(), FieldsError> {
        if !(weight >= 0.0 && weight.is_finite()) {
            return Err(FieldsError::Option {
                name: "the weight of a frame",
                value: weight,
                allowed: "0 or more, and finite",
            });
        }
        if contacts.is_some() && self.options.parcel_weight.is_some() {
            return Err(FieldsError::Combination {
                what: "how many contacts one between parcels stands for is not known: leave out the contacts, or the parcel weights",
            });
        }
        let frame = Frame::new(particles, &self.options, &self.layout)?;
        let empty = Contacts::new();
        let contacts = match contacts {
            Some(contacts) => contacts,
            None => match self.options.fields.iter().find(|f| f.needs_contacts()) {
                Some(field) => return Err(FieldsError::NoContacts(field.name())),
                None => &empty,
            },
        };
        let sides = frame.sides(contacts)?;
        // Kernels are integrated over averaged directions: there, everything counts once.
        let (cells, domain) = (self.cells, self.options.domain);
        let periods = |once: bool| {
            Periods::new(domain.as_ref(), cells.averaged().map(|averaged| averaged && once), cells.bounds())
        };
        match self.options.function {
            Function::Overlap(_) => periods(false).check_balls(frame.radii)?,
            Function::Kernel(kernel) => periods(true).check(kernel.reach())?,
        }
        let form = self.options.form();
        let sampled_contacts = form == ContactForm::LineIntegral;
        if form != ContactForm::ParticleCentred {
            let half = 0.5 * longest_branch(sides.iter().copied());
            let around = match self.options.function {
                Function::Kernel(kernel) if sampled_contacts => kernel.reach(),
                _ => 0.0,
            };
            periods(sampled_contacts).check(half + around)?;
        }
        // A frame of weight 0 has been checked, and adds nothing.
        if weight > 0.0 {
            let by_frame = self.layout.width(Group::Frame) > 0;
            let mut own = None;
            if by_frame {
                own = Some(std::mem::replace(
                    &mut self.sums,
                    GROUPS.map(|group| Sums::new(self.cells.cell_count(), self.layout.width(group))),
                ));
            }
            let sampled = matches!(self.options.function, Function::Kernel(_));
            self.add_particles(&frame, &sides, weight, periods(sampled))?;
            self.add_contacts(&frame, &sides, weight, &periods(sampled_contacts))?;
            self.add_moments(&frame, weight, periods(false))?;
            if let Some(before) = own {
                self.merge_frame(before);
            }
            self.time += weight;
        }
        self.ledger.frames += 1;
        self.ledger.particles = frame.selected.iter().filter(|s| **s).count();
        self.ledger.contacts = sides.len();
        self.account(&frame, &sides, weight);
        Ok(())
    }

    fn account(&mut self, frame: &Frame<'_>, sides: &[Contact], weight: f64) {
        for particle in (0..frame.len()).filter(|&i| frame.selected[i]) {
            let mass = weight * frame.parcel(particle) * frame.masses[particle];
            self.totals.mass.add(mass);
            let v = frame.velocity(particle);
            (0..3).for_each(|k| self.totals.momentum[k].add(mass * v[k]));
        }
        let sign = self.options.sign.of_force_times_branch() * weight;
        for contact in sides {
            let s = outer(contact.force, contact.branch);
            (0..9).for_each(|k| self.totals.stress[k].add(sign * s[k]));
            // |f ⊗ l| is |f| |l|.
            self.totals.stress_scale.add(weight * s.iter().map(|x| x * x).sum::<f64>().sqrt());
        }
    }

    fn add_particles(
        &mut self,
        frame: &Frame<'_>,
        sides: &[Contact],
        weight: f64,
        periods: Periods,
    ) -> Result<(), FieldsError> {
        let weights = match self.options.function {
            Function::Overlap(method) => ParticleWeights::Overlap(Binning::new(self.cells, method)?),
            Function::Kernel(kernel) => ParticleWeights::Sampled {
                sampling: Sampling::new(self.cells, kernel)?,
                conserve: self.options.conserve,
            },
        };
        let placed: Vec<AtomicU64> = (0..frame.len()).map(|_| AtomicU64::new(0)).collect();
        let mut weigher = Weigher { cells: self.cells, weights, periods, first_image: None, placed: &placed };
        let by_image =
            [Column::AngularMomentum, Column::MassPosition, Column::MassPosition2, Column::MassDisplacementPosition];
        let mut carriers = None;
        let mut first = Vec::new();
        if weigher.periods.any() && self.layout.any(&by_image) {
            // Images differ in position: each is a carrier of its own.
            let mut list = Vec::new();
            for particle in 0..frame.len() {
                first.push(list.len() as u32);
                weigher.images(frame, particle, |image| list.push((particle as u32, image.centre)));
            }
            carriers = Some(list);
            weigher.first_image = Some(&first);
        }
        let (low, high) = self.cells.bounds();
        let origin = std::array::from_fn(|k| 0.5 * (low[k] + high[k]));
        let mut quantities = particle_quantities(frame, &self.layout, carriers.as_deref(), origin, weight);
        let width = self.layout.width(Group::Particle);
        let carrier_count = carriers.as_ref().map_or(frame.len(), Vec::len);
        let images = |particle: usize| match &weigher.first_image {
            None => particle..particle + 1,
            Some(first) => {
                let end = first.get(particle + 1).map_or(carrier_count, |&e| e as usize);
                first[particle] as usize..end
            }
        };
        contact_sums(
            frame,
            &self.layout,
            sides,
            self.options.walls_in_contact_force,
            self.options.sign.of_force_times_branch(),
            weight,
            |particle, start, values| {
                for carrier in images(particle) {
                    let at = carrier * width + start;
                    quantities[at..at + values.len()].iter_mut().zip(values).for_each(|(q, v)| *q += v);
                }
            },
        );
        let curve;
        let order = if C::PLACES_IN_MEMORY {
            curve = crate::curve::along_a_curve(frame.positions);
            Order::Listed(&curve)
        } else {
            Order::Numbered(frame.len())
        };
        self.sums[Group::Particle as usize].add(
            &order,
            &quantities,
            || Scratch::new(scratch_of(self.cells, &weigher.weights)),
            |particle, scratch, out| weigher.particle(frame, particle, scratch, out),
        )?;
        for (particle, placed) in placed.iter().enumerate().filter(|&(i, _)| frame.selected[i]) {
            let outside = 1.0 - f64::from_bits(placed.load(Ordering::Relaxed));
            // What rounding leaves of a ball that is all inside is nothing.
            let outside = if outside.abs() < 1e-13 { 0.0 } else { outside };
            self.totals.clipped.add(weight * frame.parcel(particle) * frame.masses[particle] * outside);
        }
        Ok(())
    }

    fn add_contacts(
        &mut self,
        frame: &Frame<'_>,
        sides: &[Contact],
        weight: f64,
        periods: &Periods,
    ) -> Result<(), FieldsError> {
        let weights: ContactWeights<'_, C> = match (self.options.form(), self.options.function) {
            (ContactForm::ParticleCentred, _) => return Ok(()),
            (ContactForm::LineIntegral, Function::Kernel(kernel)) => {
                ContactWeights::Sampled(Sampling::new(self.cells, kernel)?)
            }
            _ => ContactWeights::Segments(Segments::new(self.cells)),
        };
        let sign = self.options.sign.of_force_times_branch();
        let branches = branch_quantities(frame, &self.layout, sides, sign, weight);
        self.sums[Group::Branch as usize].add(
            &Order::Numbered(sides.len()),
            &branches,
            || Scratch::new(self.cells.scratch()),
            |index, scratch, out| {
                let contact = &sides[index];
                let start = frame.positions[contact.particle as usize];
                weights.branch(periods, start, contact.branch, scratch, |cell, weight| {
                    out.push(Pair { cell, carrier: index as u32, weight });
                });
                Ok(())
            },
        )?;
        if self.layout.width(Group::Point) == 0 {
            return Ok(());
        }
        let walls: Vec<&Contact> = sides.iter().filter(|c| matches!(c.partner, Partner::Wall(_))).collect();
        let forces: Vec<f64> = walls.iter().flat_map(|c| c.force.map(|f| weight * f)).collect();
        self.sums[Group::Point as usize].add(
            &Order::Numbered(walls.len()),
            &forces,
            || Scratch::new(self.cells.scratch()),
            |index, scratch, out| {
                let contact = walls[index];
                let centre = frame.positions[contact.particle as usize];
                let at = std::array::from_fn(|k| centre[k] + contact.arm[k]);
                weights.point(periods, at, scratch, |cell, weight| {
                    out.push(Pair { cell, carrier: index as u32, weight });
                });
                Ok(())
            },
        )
    }

    /// m/V ω × ∫ (x − r) dx.
    fn add_moments(&mut self, frame: &Frame<'_>, weight: f64, periods: Periods) -> Result<(), FieldsError> {
        if self.layout.width(Group::Moment) == 0 {
            return Ok(());
        }
        let elements: Vec<Vec<(f64, Polyhedron)>> =
            (0..self.cells.cell_count()).into_par_iter().map(|cell| parts_of(self.cells, cell)).collect();
        let mut quantities = Vec::with_capacity(9 * frame.len());
        for particle in 0..frame.len() {
            let mass = weight * frame.parcel(particle) * frame.masses[particle];
            for k in 0..3 {
                let axis = std::array::from_fn(|a| f64::from(u8::from(a == k)));
                quantities.extend(cross(frame.spin(particle), axis).map(|v| mass * v));
            }
        }
        let Function::Overlap(method) = self.options.function else { return Ok(()) };
        let weigher = Weigher {
            cells: self.cells,
            weights: ParticleWeights::Overlap(Binning::new(self.cells, method)?),
            periods,
            first_image: None,
            placed: &[],
        };
        self.sums[Group::Moment as usize].add(
            &Order::Numbered(frame.len()),
            &quantities,
            || (),
            |particle, (), out| weigher.moments(frame, particle, &elements, out),
        )
    }

    /// Adds what the sums before the frame were, and the product of sums that only the frame's own can give.
    fn merge_frame(&mut self, before: [Sums; GROUPS.len()]) {
        let [mass, momentum, mean] =
            [Column::Mass, Column::Momentum, Column::MeanFlux].map(|column| self.layout.find(column));
        if let (Some(mass), Some(momentum), Some(mean)) = (mass, momentum, mean) {
            for cell in 0..self.cells.cell_count() {
                let sums = self.sums[mass.group as usize].cell(cell);
                let j = std::array::from_fn(|k| sums[momentum.start + k]);
                let flux = derive::mean_flux(sums[mass.start], j);
                let frame = &mut self.sums[Group::Frame as usize];
                let at = cell * frame.columns + mean.start;
                frame.values[at..at + 6].copy_from_slice(&flux);
            }
        }
        for (sums, before) in self.sums.iter_mut().zip(before) {
            sums.values.par_iter_mut().zip(before.values).for_each(|(s, b)| *s += b);
        }
    }

    /// The fields of what has been accumulated.
    ///
    /// # Errors
    /// [`FieldsError::NoFrames`] where nothing with a weight has been.
    pub fn finish(self) -> Result<Fields, FieldsError> {
        if self.time <= 0.0 {
            return Err(FieldsError::NoFrames);
        }
        let overlap = matches!(self.options.function, Function::Overlap(_));
        let form = self.options.form();
        let per_cell = GROUPS.map(|group| match group {
            Group::Particle | Group::Moment | Group::Frame => overlap,
            Group::Branch | Group::Point => form == ContactForm::BranchInCell,
        });
        let densities = Densities {
            cells: self.cells,
            layout: &self.layout,
            sums: &self.sums,
            per_cell,
            time: self.time,
            sign: self.options.sign,
        };
        let (fields, binned) = densities.fields(&self.options.fields, &self.options.quantities);
        let mean = |sum: &NeumaierSum| sum.value() / self.time;
        let ledger = CoarseGrainingLedger {
            mass_in: mean(&self.totals.mass),
            mass_binned: binned.mass,
            mass_clipped: mean(&self.totals.clipped),
            momentum_in: std::array::from_fn(|k| mean(&self.totals.momentum[k])),
            momentum_binned: binned.momentum,
            stress_sum_contacts: std::array::from_fn(|k| mean(&self.totals.stress[k])),
            stress_sum_fields: binned.stress,
            stress_scale: mean(&self.totals.stress_scale),
            ..self.ledger
        };
        Ok(Fields { fields, sign: self.options.sign, function: self.options.function, contact_form: form, ledger })
    }
}

fn scratch_of<C: Cells>(cells: &C, weights: &ParticleWeights<'_, C>) -> C::Scratch {
    match weights {
        ParticleWeights::Overlap(binning) => binning.scratch(),
        ParticleWeights::Sampled { .. } => cells.scratch(),
    }
}

/// A cell as signed polyhedra.
fn parts_of<C: Cells>(cells: &C, cell: usize) -> Vec<(f64, Polyhedron)> {
    let mut parts = Vec::new();
    cells.for_each_element(cell, &mut |sign, kind, corners| {
        let element = match kind {
            ElementKind::Tetrahedron => corners.try_into().ok().map(|c: [[f64; 3]; 4]| Polyhedron::tetrahedron(c)),
            ElementKind::Wedge => corners.try_into().ok().map(|c: [[f64; 3]; 6]| Polyhedron::wedge(c)),
            _ => corners.try_into().ok().map(|c: [[f64; 3]; 8]| Polyhedron::hexahedron(c)),
        };
        // A part that rounding has made flat holds nothing that would be missed.
        if let Some(Ok(element)) = element {
            parts.push((sign, element));
        }
    });
    parts
}
