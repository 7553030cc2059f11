//! The state of every job of a window: unassigned, pending at a worker, finished or closed.

use super::job::{JobId, JobKind, JobResult};
use std::ops::Range;

/// The jobs of the present window, by kind and index.
#[derive(Debug, Clone, Default)]
pub(crate) struct PendingJobs {
    epoch: u32,
    states: [Vec<JobState>; JobKind::ALL.len()],
}

#[derive(Debug, Clone, Default)]
enum JobState {
    #[default]
    Unassigned,
    /// A worker has it.
    Pending,
    Finished(JobResult),
    /// The result was used, or the session computes it itself.
    Closed,
}

impl PendingJobs {
    /// Creates a list without assigned jobs. Results of jobs from another `epoch` will be ignored.
    pub(crate) fn new(epoch: u32) -> Self {
        Self { epoch, ..Self::default() }
    }

    fn states(&mut self, kind: JobKind, count: usize) -> &mut [JobState] {
        let states = &mut self.states[kind as usize];
        states.resize_with(states.len().max(count), JobState::default);
        states
    }

    /// Assigns the first unassigned job of a range.
    pub(crate) fn assign(&mut self, kind: JobKind, mut range: Range<usize>) -> Option<JobId> {
        let states = self.states(kind, range.end);
        let index = range.find(|&index| matches!(states[index], JobState::Unassigned))?;
        states[index] = JobState::Pending;
        Some(JobId { epoch: self.epoch, kind, index: index as u32 })
    }

    /// Stores the result of a pending job (`None` if it was lost). Results of jobs that are not pending are ignored.
    pub(crate) fn store_result(&mut self, id: JobId, result: Option<JobResult>) {
        let state = self.states[id.kind as usize].get_mut(id.index as usize).filter(|_| id.epoch == self.epoch);
        if let Some(state @ JobState::Pending) = state {
            *state = result.map_or(JobState::Closed, JobState::Finished);
        }
    }

    pub(crate) fn is_pending(&self, kind: JobKind, index: usize) -> bool {
        matches!(self.states[kind as usize].get(index), Some(JobState::Pending))
    }

    /// Returns the worker's result if it arrived, and closes the job.
    pub(crate) fn take_result(&mut self, kind: JobKind, index: usize) -> Option<JobResult> {
        match std::mem::replace(&mut self.states(kind, index + 1)[index], JobState::Closed) {
            JobState::Finished(result) => Some(result),
            _ => None,
        }
    }

    /// Lets the jobs of these kinds be assigned again; none of them may be pending.
    pub(crate) fn forget(&mut self, kinds: &[JobKind]) {
        kinds.iter().for_each(|&kind| self.states[kind as usize].clear());
    }
}
