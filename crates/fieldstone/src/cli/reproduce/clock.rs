//! Processor time: what other programs on the machine disturb less than they do the time of day.

/// Processor time of this thread, in seconds; the time of day where there is no such clock.
pub(super) fn thread_seconds() -> f64 {
    imp::thread_seconds()
}

/// Processor time of all threads, in seconds; the time of day likewise.
pub(super) fn process_seconds() -> f64 {
    imp::process_seconds()
}

#[cfg(unix)]
mod imp {
    use rustix::time::{ClockId, clock_gettime};

    fn seconds(clock: ClockId) -> f64 {
        let now = clock_gettime(clock);
        now.tv_sec as f64 + 1e-9 * now.tv_nsec as f64
    }

    pub(super) fn thread_seconds() -> f64 {
        seconds(ClockId::ThreadCPUTime)
    }

    pub(super) fn process_seconds() -> f64 {
        seconds(ClockId::ProcessCPUTime)
    }
}

#[cfg(not(unix))]
mod imp {
    use std::sync::LazyLock;
    use std::time::Instant;

    static START: LazyLock<Instant> = LazyLock::new(Instant::now);

    pub(super) fn thread_seconds() -> f64 {
        START.elapsed().as_secs_f64()
    }

    pub(super) fn process_seconds() -> f64 {
        thread_seconds()
    }
}
