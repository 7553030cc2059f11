//! Time and memory as counted by the operating system.

use serde::{Deserialize, Serialize};
use std::time::Instant;

/// Wall time and, on Linux, the processor time of this thread (which does not depend on other programs).
#[derive(Debug, Clone, Copy, Default, Serialize, Deserialize)]
pub struct Seconds {
    #[serde(rename = "seconds")]
    pub wall: f64,
    #[serde(rename = "cpuSeconds")]
    pub cpu: Option<f64>,
}

impl Seconds {
    pub fn add(&mut self, other: Self) {
        self.wall += other.wall;
        self.cpu = match (self.cpu, other.cpu) {
            (Some(a), Some(b)) => Some(a + b),
            (a, b) => a.or(b),
        };
    }

    /// Subtracts the time of a part.
    pub(crate) fn without(self, part: Self) -> Self {
        let cpu = self.cpu.map(|cpu| (cpu - part.cpu.unwrap_or(0.0)).max(0.0));
        Self { wall: (self.wall - part.wall).max(0.0), cpu }
    }

    /// Returns processor seconds if known, otherwise wall seconds.
    pub fn best(self) -> f64 {
        self.cpu.unwrap_or(self.wall)
    }
}

/// A stopwatch.
#[derive(Debug)]
pub struct Clock {
    wall: Instant,
    cpu: Option<f64>,
}

impl Clock {
    pub fn start() -> Self {
        Self { wall: Instant::now(), cpu: thread_seconds() }
    }

    pub fn seconds(&self) -> Seconds {
        // A new thread has no count yet.
        let cpu = thread_seconds().map(|now| now - self.cpu.unwrap_or(0.0));
        Seconds { wall: self.wall.elapsed().as_secs_f64(), cpu }
    }

    /// Returns the seconds since the start or the last lap, and starts another lap.
    pub fn lap(&mut self) -> Seconds {
        let seconds = self.seconds();
        *self = Self::start();
        seconds
    }
}

fn thread_seconds() -> Option<f64> {
    let text = std::fs::read_to_string("/proc/thread-self/schedstat").ok()?;
    let nanoseconds: f64 = text.split_whitespace().next()?.parse().ok()?;
    // Some sandboxes offer the file and fill it with zeros.
    (nanoseconds > 0.0).then_some(nanoseconds * 1e-9)
}

/// Returns the peak memory of this process in bytes; `None` if the system does not report it (Linux does).
pub(crate) fn peak_memory_bytes() -> Option<u64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find_map(|l| l.strip_prefix("VmHWM:"))?;
    line.trim().strip_suffix("kB")?.trim().parse::<u64>().ok().map(|k| k * 1024)
}
