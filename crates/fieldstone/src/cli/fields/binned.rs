//! Refuses results that hold nothing at all, with what may have led to them.

use std::collections::BTreeSet;

use anyhow::bail;
use fieldstone::fields::{FieldsError, Function};
use fieldstone::mesh::Cells;
use fieldstone::particles::Particles;

use super::account::Account;
use super::request::Run;
use crate::cli::report;

/// Types that are kept apart: more of them are no species, but numbers of particles.
pub(super) const MOST_TYPES: usize = 64;

/// What the particles of all frames are like, for messages.
#[derive(Debug)]
pub(super) struct Found {
    particles: usize,
    low: [f64; 3],
    high: [f64; 3],
    radii: [f64; 2],
    types: BTreeSet<i64>,
}

impl Default for Found {
    fn default() -> Self {
        let none = [f64::INFINITY, f64::NEG_INFINITY];
        Self { particles: 0, low: [none[0]; 3], high: [none[1]; 3], radii: none, types: BTreeSet::new() }
    }
}

impl Found {
    pub fn add(&mut self, particles: &Particles) {
        self.particles = self.particles.max(particles.len());
        for p in particles.positions() {
            self.low = std::array::from_fn(|k| self.low[k].min(p[k]));
            self.high = std::array::from_fn(|k| self.high[k].max(p[k]));
        }
        for &r in particles.radii().unwrap_or_default() {
            self.radii = [self.radii[0].min(r), self.radii[1].max(r)];
        }
        for kind in particles.types().unwrap_or_default() {
            if self.types.len() < MOST_TYPES {
                self.types.insert(*kind);
            }
        }
    }

    fn has_type(&self, kind: i64) -> bool {
        self.types.len() >= MOST_TYPES || self.types.contains(&kind)
    }

    fn listed_types(&self) -> String {
        self.types.iter().map(i64::to_string).collect::<Vec<_>>().join(", ")
    }
}

impl Run<'_> {
    /// Refuses fields that are 0 everywhere because no particle counts or none reaches a cell.
    pub(super) fn check_binned<C: Cells>(&self, cells: &C, account: &Account) -> anyhow::Result<()> {
        let found = &account.seen.found;
        // Frames without particles are told of one by one.
        if found.particles == 0 {
            return Ok(());
        }
        let wanted = self.options.selection.types.as_deref().unwrap_or_default();
        let missing: Vec<i64> = wanted.iter().copied().filter(|kind| !found.has_type(*kind)).collect();
        if let Some(kind) = missing.first() {
            let message = format!("no particle is of type {kind}; the types are {}", found.listed_types());
            if missing.len() == wanted.len() {
                bail!("--species: {}: {message}", self.files[0].display());
            }
            report::warn(&format!("--species: {message}"));
        }
        if !account.is_bare() {
            return Ok(());
        }
        let file = self.files[0].display();
        let (low, high) = (found.low, found.high);
        if !account.has_particles() {
            let [least, most] = found.radii;
            bail!(
                "{file}: none of the {} particles is left by --species, --radii and --region: their radii are {least} to \
                 {most}, their centres span ({}, {}, {}) to ({}, {}, {})",
                found.particles,
                low[0],
                low[1],
                low[2],
                high[0],
                high[1],
                high[2]
            );
        }
        let (mesh_low, mesh_high) = cells.bounds();
        let among = (0..3).all(|k| low[k] <= mesh_high[k] && high[k] >= mesh_low[k]);
        if let (Function::Kernel(kernel), true) = (self.options.function, among) {
            bail!(
                "{file}: no cell's centre lies within {} of a particle, where the kernel ends; give a larger --width or \
                 --cutoff, or smaller cells, or --conserve",
                kernel.reach()
            );
        }
        let nothing = FieldsError::NothingInside {
            particles: found.particles,
            particle_low: low,
            particle_high: high,
            mesh_low,
            mesh_high,
        };
        bail!(
            "{file} in {}: {nothing}",
            self.settings.mesh.as_ref().map_or("the grid".into(), |m| m.display().to_string())
        )
    }
}
