//! Jobs: units of work that any thread or worker can do.

mod job;
mod pending;
#[cfg(any(feature = "wasm", test))]
mod wire;

pub(crate) use job::{DescribedSuperpixels, Job, JobId, JobInput, JobKind, JobResult};
pub(crate) use job::{FlowFrame, ForwardFlow, PairFlow};
pub(crate) use pending::PendingJobs;
