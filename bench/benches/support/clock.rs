//! Time for the benchmarks.

use std::sync::OnceLock;
use std::time::{Duration, Instant};

/// Processor time of this process where the system tells it (Linux), else elapsed time.
pub(crate) fn seconds() -> f64 {
    static START: OnceLock<Instant> = OnceLock::new();
    // The system brings its account up to date when a process gives way.
    std::thread::sleep(Duration::from_millis(1));
    let elapsed = START.get_or_init(Instant::now).elapsed().as_secs_f64();
    let schedule = std::fs::read_to_string("/proc/self/schedstat").unwrap_or_default();
    schedule.split(' ').next().and_then(|ns| ns.parse::<f64>().ok()).map_or(elapsed, |ns| 1e-9 * ns)
}
