//! What is seen of the frames as they go by.

use std::cell::RefCell;
use std::time::Duration;

use fieldstone::particles::{Contacts, Domain};
use indicatif::{ProgressBar, ProgressStyle};

use super::account::Seen;
use super::clock::TimeOrder;
use super::frames::Frame;
use crate::cli::arguments::unused_parcels;

/// Watches frames while others compute with them.
pub(super) struct Watch {
    state: RefCell<State>,
    bar: ProgressBar,
    first_box: Option<Domain>,
    /// Whether parcels have their weights.
    weighted: bool,
}

#[derive(Default)]
struct State {
    seen: Seen,
    order: TimeOrder,
    box_changed: bool,
    /// What to say of the first frame with parcels that count as one particle each.
    parcels: Option<String>,
}

impl Watch {
    /// `refused` is what cannot be computed of frames whose times do not rise, `weighted` whether parcels have weights.
    pub fn new(refused: Option<&'static str>, first: &Frame, weighted: bool) -> anyhow::Result<Self> {
        let style = ProgressStyle::with_template("{spinner} {pos} frames, {elapsed}")?;
        let bar = ProgressBar::new_spinner().with_style(style);
        bar.enable_steady_tick(Duration::from_millis(200));
        let state = RefCell::new(State { order: TimeOrder::new(refused), ..State::default() });
        Ok(Self { state, bar, first_box: first.particles.domain().copied(), weighted })
    }

    /// Takes note of the next frame.
    pub fn see(&self, frame: &Frame) -> anyhow::Result<()> {
        let State { seen, order, box_changed, parcels } = &mut *self.state.borrow_mut();
        order.add(frame.time, &frame.name)?;
        *box_changed |= frame.particles.domain().copied() != self.first_box;
        if parcels.is_none() && !self.weighted {
            *parcels = unused_parcels(&frame.particles).map(|warning| format!("{}: {warning}", frame.name));
        }
        seen.frames += 1;
        seen.particles = frame.particles.len();
        seen.contacts = frame.contacts.as_ref().map(Contacts::len);
        seen.found.add(&frame.particles);
        seen.last = frame.name.clone();
        self.bar.inc(1);
        Ok(())
    }

    /// What has been seen, and what the user should know; `periodic` where the first frame's box has images.
    pub fn finish(self, periodic: bool) -> (Seen, Vec<String>) {
        self.bar.finish_and_clear();
        let State { seen, order, box_changed, parcels } = self.state.into_inner();
        let mut warnings = Vec::from_iter(order.warning());
        if box_changed && periodic {
            warnings.push("the box changes between frames: periodic images are those of the first frame's box".into());
        }
        warnings.extend(parcels);
        (seen, warnings)
    }
}
