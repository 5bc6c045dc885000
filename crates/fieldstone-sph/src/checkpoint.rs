use std::path::Path;

use fieldstone_io::AtomicFile;

use crate::solver::Snapshot;
use crate::{Budget, Flow, MomentumBudget, Solver, SphError, State};

const NAME: &[u8; 7] = b"FSTNSPH";
pub(crate) const VERSION: u8 = 7;

/// Everything a run needs to go on with the same bits: state, order, lists' positions, regions, time, budget; a checksum of the
/// state that it began with; and what its gauges measure.
///
/// | bytes | what |
/// |---|---|
/// | 8 | `FSTNSPH`, version 7 |
/// | 4 | CRC-32 of the numbers that describe the flow: fluid, boundaries, options; not of the time step, k_CFL, end time and output |
/// | 4 | CRC-32 of the rest of the file |
/// | rest | little-endian numbers |
///
/// Neighbour lists are made again from the positions that they were made for, of particles and, by the time, of bodies; uncovered directions of the free
/// surface, which only save time, are found again.
impl Solver {
    /// Writes a checkpoint; the file appears whole or not at all.
    ///
    /// # Errors
    /// [`SphError::Io`].
    pub fn write_checkpoint(&self, path: &Path) -> Result<(), SphError> {
        self.write_checkpoint_with(path, "")
    }

    /// The same, with what the gauges of a run measure.
    pub(crate) fn write_checkpoint_with(&self, path: &Path, gauges: &str) -> Result<(), SphError> {
        let body = encoded(&self.snapshot(), gauges);
        AtomicFile::write(path, |out| {
            out.write_all(NAME)?;
            out.write_all(&[VERSION])?;
            out.write_all(&self.flow().identity().to_le_bytes())?;
            out.write_all(&crc32fast::hash(&body).to_le_bytes())?;
            out.write_all(&body)
        })?;
        Ok(())
    }

    /// Goes on from a checkpoint with the flow that it was written for.
    ///
    /// # Errors
    /// [`SphError::Checkpoint`]: no checkpoint, damaged, or of another flow; as [`Flow::validate`].
    pub fn read_checkpoint(path: &Path, flow: Flow) -> Result<Self, SphError> {
        flow.validate()?;
        Ok(Self::of_checkpoint(path, flow)?.0)
    }

    /// As [`read_checkpoint`](Self::read_checkpoint), with a flow that was validated; and what its gauges measure.
    pub(crate) fn of_checkpoint(path: &Path, flow: Flow) -> Result<(Self, String), SphError> {
        let fault = |message: &str| SphError::Checkpoint { file: path.display().to_string(), message: message.into() };
        let bytes =
            std::fs::read(path).map_err(|e| fault(&format!("cannot be read: {e}; run without --resume first")))?;
        let Some((head, body)) = bytes.split_at_checked(16) else {
            return Err(fault("this is no checkpoint: it ends within the head; remove it and start anew"));
        };
        if &head[..7] != NAME {
            return Err(fault("this is no checkpoint: it does not begin with FSTNSPH; remove it and start anew"));
        }
        if head[7] != VERSION {
            return Err(fault(&format!(
                "the checkpoint has format {}, this program reads {VERSION} only: go on with the program that wrote it, or \
                 remove it and start anew",
                head[7]
            )));
        }
        let word = |at: usize| u32::from_le_bytes([head[at], head[at + 1], head[at + 2], head[at + 3]]);
        if word(12) != crc32fast::hash(body) {
            return Err(fault("the checkpoint is damaged: its checksum differs; remove it and start anew"));
        }
        if word(8) != flow.identity() {
            return Err(fault(
                "the checkpoint belongs to another flow: fluid, boundaries or options differ; only [time], k_cfl \
                 and the output may change",
            ));
        }
        let (snapshot, gauges) =
            decoded(body).ok_or_else(|| fault("the checkpoint is too short or too long; start anew"))?;
        Ok((Self::restored(flow, snapshot)?, gauges))
    }
}

fn encoded(snapshot: &Snapshot, gauges: &str) -> Vec<u8> {
    let mut out = Vec::new();
    let Snapshot {
        state,
        regions,
        built_at,
        listed_at,
        time,
        steps,
        last_step,
        fastest,
        lists_due,
        order_due,
        budget,
        began,
    } = snapshot;
    let mut word = |x: u64| out.extend_from_slice(&x.to_le_bytes());
    word(state.len() as u64);
    word(built_at.len() as u64);
    word(gauges.len() as u64);
    word(*steps);
    word(u64::from(*lists_due));
    word(*order_due);
    word(u64::from(*began));
    word(budget.removed);
    word(budget.reflections);
    word(budget.in_bodies);
    word(budget.singular);
    let Budget {
        start,
        viscous,
        diffusive,
        boundaries,
        shifting,
        surface_tension,
        wrapping,
        removed_energy,
        removed_mass,
        momentum,
        ..
    } = *budget;
    for x in [
        *time,
        *listed_at,
        *last_step,
        *fastest,
        start,
        viscous,
        diffusive,
        boundaries,
        shifting,
        surface_tension,
        wrapping,
        removed_energy,
        removed_mass,
    ] {
        word(x.to_bits());
    }
    let MomentumBudget { start, walls, bodies, weight, surface_tension, removed } = momentum;
    for x in [start, walls, bodies, weight, surface_tension, removed].as_flattened() {
        word(x.to_bits());
    }
    for x in state.x.iter().chain(&state.u).chain(built_at).flatten().chain(&state.density) {
        word(x.to_bits());
    }
    for id in &state.id {
        out.extend_from_slice(&id.to_le_bytes());
    }
    out.extend_from_slice(regions);
    out.extend_from_slice(gauges.as_bytes());
    out
}

fn decoded(bytes: &[u8]) -> Option<(Snapshot, String)> {
    let mut rest = bytes;
    let mut word = || {
        let (head, tail) = rest.split_first_chunk::<8>()?;
        rest = tail;
        Some(u64::from_le_bytes(*head))
    };
    let count = usize::try_from(word()?).ok()?;
    let built = usize::try_from(word()?).ok()?;
    let said = usize::try_from(word()?).ok()?;
    // Before anything is allocated for numbers that are not there.
    let expected = (11u128 + 13 + 18) * 8 + count as u128 * (7 * 8 + 4 + 1) + built as u128 * 24 + said as u128;
    if bytes.len() as u128 != expected {
        return None;
    }
    let (steps, lists_due, order_due) = (word()?, word()? != 0, word()?);
    let began = u32::try_from(word()?).ok()?;
    let (removed, reflections, in_bodies, singular) = (word()?, word()?, word()?, word()?);
    let mut budget = Budget { removed, reflections, in_bodies, singular, ..Budget::default() };
    let mut number = || Some(f64::from_bits(word()?));
    let (time, listed_at, last_step, fastest) = (number()?, number()?, number()?, number()?);
    budget.start = number()?;
    budget.viscous = number()?;
    budget.diffusive = number()?;
    budget.boundaries = number()?;
    budget.shifting = number()?;
    budget.surface_tension = number()?;
    budget.wrapping = number()?;
    budget.removed_energy = number()?;
    budget.removed_mass = number()?;
    let mut vectors = |n: usize| (0..n).map(|_| Some([number()?, number()?, number()?])).collect::<Option<Vec<_>>>();
    let impulses = vectors(6)?;
    let [start, walls, bodies, weight, surface_tension, removed] = impulses[..] else { return None };
    budget.momentum = MomentumBudget { start, walls, bodies, weight, surface_tension, removed };
    let (x, u, built_at) = (vectors(count)?, vectors(count)?, vectors(built)?);
    let density = (0..count).map(|_| number()).collect::<Option<Vec<_>>>()?;
    let (ids, regions) = rest.split_at_checked(4 * count)?;
    let id = ids.chunks_exact(4).map(|c| u32::from_le_bytes([c[0], c[1], c[2], c[3]])).collect();
    let state = State { x, u, density, id };
    let (regions, gauges) = regions.split_at_checked(count)?;
    let regions = regions.to_vec();
    let gauges = String::from_utf8(gauges.to_vec()).ok()?;
    let snapshot = Snapshot {
        state,
        regions,
        built_at,
        listed_at,
        time,
        steps,
        last_step,
        fastest,
        lists_due,
        order_due,
        budget,
        began,
    };
    Some((snapshot, gauges))
}
