//! Jobs handed out by a session, and runs on several threads by means of them.

#[cfg(not(target_arch = "wasm32"))]
use crate::Error;
#[cfg(not(target_arch = "wasm32"))]
use crate::flow::FlowScratch;
#[cfg(not(target_arch = "wasm32"))]
use crate::session::base::{Progress, Step};
use crate::session::jobs::{Job, JobId, JobInput, JobKind, JobResult};
use crate::session::run::{Phase, Session};
#[cfg(not(target_arch = "wasm32"))]
use std::sync::{Mutex, PoisonError, mpsc};

impl Session {
    /// Hands out an unassigned job; `None` if there is none at present. Flow is handed out for at most `ahead` pairs from
    /// the next one on, since its result takes 14 bytes a pixel until it is used.
    pub(crate) fn take_job(&mut self, ahead: usize) -> Option<Job> {
        let clip = self.phase.clip_mut()?;
        let pairs = clip.flows.len()..clip.frames.len().saturating_sub(1).min(clip.flows.len() + ahead);
        // In the order in which steps need the results.
        if let Some(id) = clip.pending_jobs.assign(JobKind::PairFlow, pairs) {
            let t = id.index as usize;
            return Some(Job { id, input: JobInput::PairFlow(clip.frames[t].clone(), clip.frames[t + 1].clone()) });
        }
        if let Phase::Running(run) = &mut self.phase
            && let Some(job) = run.take_job()
        {
            return Some(job);
        }
        self.phase.clip_mut()?.take_superpixel_job()
    }

    /// Stores the result of a job, `None` if it was lost and the session has to do it itself. Results that are no longer
    /// needed, because the session was cleared or went on without them, are dropped.
    pub(crate) fn store_result(&mut self, id: JobId, result: Option<JobResult>) {
        if let Some(clip) = self.phase.clip_mut() {
            clip.pending_jobs.store_result(id, result);
        }
    }

    /// Takes a job and runs it at once; false if there is none.
    pub(crate) fn run_one_job(&mut self, ahead: usize) -> bool {
        let Some(job) = self.take_job(ahead) else { return false };
        let Self { params, phase, .. } = self;
        let Some(clip) = phase.clip_mut() else { return false };
        let result = job.run(params, &mut clip.scratch);
        clip.pending_jobs.store_result(job.id, Some(result));
        true
    }

    /// Returns whether the next step needs the result of a pending job. The step can be taken all the same, and then does the job
    /// itself.
    pub(crate) fn is_waiting(&self) -> bool {
        matches!(&self.phase, Phase::Running(run) if run.is_waiting())
    }
}

/// Jobs that each worker thread has at a time: the present one and two more, as this thread hands out jobs only between its own.
#[cfg(not(target_arch = "wasm32"))]
const JOBS_PER_WORKER: usize = 3;
/// Frame pairs for each worker thread whose flow may be computed before it is used, which takes memory.
#[cfg(not(target_arch = "wasm32"))]
const PAIRS_PER_WORKER: usize = 2;

#[cfg(not(target_arch = "wasm32"))]
impl Session {
    /// Runs to the end on `threads` threads, this one included, and calls `report` after each step. Results are the same
    /// bits for any number of threads.
    ///
    /// All threads do jobs; work on the whole clip is done by this one, while the others go on with superpixels. Memory
    /// grows by about 200 bytes a pixel of a frame for each further thread.
    ///
    /// # Errors
    /// As [`Session::step`].
    pub fn run_on(&mut self, threads: usize, mut report: impl FnMut(Progress)) -> Result<(), Error> {
        let always = |progress| {
            report(progress);
            true
        };
        self.run_while(threads, always).map(|_is_done| ())
    }

    /// Runs as [`Session::run_on`] as long as `report` returns true. Returns whether the run is done; otherwise another
    /// call goes on with it, and ends in the same result.
    ///
    /// # Errors
    /// As [`Session::step`].
    #[doc(hidden)] // For the Python package, whose callbacks may raise.
    pub fn run_while(&mut self, threads: usize, mut report: impl FnMut(Progress) -> bool) -> Result<bool, Error> {
        let params = self.params().clone();
        let (job_sender, job_receiver) = mpsc::channel::<Job>();
        let (result_sender, results) = mpsc::channel::<(JobId, JobResult)>();
        let job_receiver = Mutex::new(job_receiver);
        std::thread::scope(|scope| {
            for _ in 1..threads {
                let (jobs, params, result_sender) = (&job_receiver, &params, result_sender.clone());
                scope.spawn(move || {
                    let mut scratch = FlowScratch::default();
                    loop {
                        // One worker waits for the channel and holds the lock; the others wait for the lock.
                        let next = jobs.lock().unwrap_or_else(PoisonError::into_inner).recv();
                        let Ok(job) = next else { break };
                        if result_sender.send((job.id, job.run(params, &mut scratch))).is_err() {
                            break;
                        }
                    }
                });
            }
            let workers = threads.saturating_sub(1);
            let (max_pending, ahead) = (JOBS_PER_WORKER * workers, PAIRS_PER_WORKER * workers + 2);
            let mut num_pending = 0;
            // Dropped at the end of this closure, however it ends, which stops the workers. Without the other sender,
            // receiving fails once all workers have panicked, which the scope reports.
            let (job_sender, results) = (job_sender, results);
            drop(result_sender);
            loop {
                while num_pending < max_pending {
                    let Some(job) = self.take_job(ahead) else { break };
                    num_pending += usize::from(job_sender.send(job).is_ok());
                }
                while let Ok((id, result)) = results.try_recv() {
                    num_pending -= 1;
                    self.store_result(id, Some(result));
                }
                if num_pending > 0 && self.is_waiting() {
                    if self.run_one_job(ahead) {
                        continue;
                    }
                    if let Ok((id, result)) = results.recv() {
                        num_pending -= 1;
                        self.store_result(id, Some(result));
                        continue;
                    }
                }
                match self.step()? {
                    Step::Working(progress) if report(progress) => {}
                    Step::Working(_) => return Ok(false),
                    Step::Done => return Ok(true),
                }
            }
        })
    }
}

#[cfg(test)]
mod tests {
    use crate::flow::FlowScratch;
    use crate::image::Plane;
    use crate::rng::Rng;
    use crate::session::jobs::{Job, JobId, JobKind, JobResult};
    use crate::synth::Scene;
    use crate::{Params, Session, Step};

    const FRAMES: usize = 9;

    fn session() -> Session {
        let mut session = Session::new(Params::default()).unwrap();
        push(&mut session);
        session
    }

    fn push(session: &mut Session) {
        let scene = Scene::sample((96, 64), FRAMES, 3);
        (0..FRAMES).for_each(|t| session.push_frame(scene.frame(t)).unwrap());
    }

    type Outcome = (crate::trajectory::Trajectories, Vec<u32>, Vec<Plane<u8>>);

    fn outcome(session: &Session) -> Outcome {
        let masks = (0..FRAMES).map(|t| session.labels(t).unwrap()).collect();
        (session.trajectories().unwrap().clone(), session.clusters().unwrap().label.clone(), masks)
    }

    fn alone() -> Outcome {
        let mut session = session();
        session.run().unwrap();
        outcome(&session)
    }

    /// As another worker does it: everything goes over the wire.
    fn elsewhere(piece: &Job) -> Vec<u32> {
        let words = piece.encode();
        let there = Job::decode(&words).unwrap();
        assert!(&there == piece);
        there.run(&Params::default(), &mut FlowScratch::default()).encode(there.id)
    }

    fn give_back(session: &mut Session, words: &[u32]) {
        let (id, made) = JobResult::decode(words).unwrap();
        session.store_result(id, Some(made));
    }

    #[test]
    fn any_number_of_threads_gives_the_same_bits() {
        let expected = alone();
        for threads in [0, 1, 2, 3, 6] {
            let mut session = session();
            let mut steps = 0;
            session.run_on(threads, |_| steps += 1).unwrap();
            assert_eq!(outcome(&session), expected, "{threads} threads");
            assert!(steps > 3 * FRAMES);
        }
    }

    #[test]
    fn pieces_in_any_order_late_lost_or_twice_give_the_same_bits() {
        let expected = alone();
        let mut kinds = std::collections::BTreeSet::new();
        for seed in 0..4 {
            let mut rng = Rng::for_stage(seed, "pieces");
            let (mut session, mut back): (_, Vec<Vec<u32>>) = (session(), Vec::new());
            loop {
                for _ in 0..rng.below(12) {
                    if let Some(piece) = session.take_job(4) {
                        kinds.insert(piece.id.kind as u32);
                        match rng.below(4) {
                            0 => session.store_result(piece.id, None),
                            1 => {}
                            _ => back.push(elsewhere(&piece)),
                        }
                    }
                }
                if !back.is_empty() && rng.below(2) == 0 {
                    let words = back.swap_remove(rng.below(back.len()));
                    give_back(&mut session, &words);
                    give_back(&mut session, &words);
                }
                if session.step().unwrap() == Step::Done {
                    break;
                }
            }
            assert_eq!(outcome(&session), expected, "seed {seed}");
        }
        assert_eq!(kinds.len(), JobKind::ALL.len(), "pieces of all kinds were given away: {kinds:?}");
    }

    #[test]
    fn steps_wait_for_what_is_out_until_it_is_back() {
        let mut session = session();
        let piece = session.take_job(4).unwrap();
        session.step().unwrap();
        let mut session = self::session();
        assert!(!session.is_waiting(), "a run that has not begun waits for nothing");
        let first = session.take_job(1).unwrap();
        assert!(first == piece);
        // Nothing but superpixels is left so near, and after these nothing.
        let rest: Vec<Job> = std::iter::from_fn(|| session.take_job(1)).collect();
        assert_eq!(rest.len(), FRAMES);
        session.step().unwrap();
        assert!(!session.is_waiting(), "what was taken is being made");
        session.store_result(first.id, Some(first.run(&Params::default(), &mut FlowScratch::default())));
        let second = session.take_job(2).unwrap();
        while !session.is_waiting() {
            session.step().unwrap();
        }
        session.store_result(second.id, None);
        assert!(!session.is_waiting(), "what is lost is made here");
        assert!(std::iter::from_fn(|| session.take_job(2)).all(|piece| piece.id != second.id));
    }

    #[test]
    fn what_was_taken_before_a_clear_is_dropped() {
        let mut session = session();
        let piece = session.take_job(4).unwrap();
        session.clear();
        push(&mut session);
        let still = JobResult::decode(&elsewhere(&piece)).unwrap();
        let again = session.take_job(4).unwrap();
        assert_ne!(again.id, piece.id);
        session.store_result(still.0, Some(still.1));
        session.run().unwrap();
        assert_eq!(outcome(&session), alone());
    }

    #[test]
    fn words_that_are_cut_short_are_nothing() {
        let mut session = session();
        let pieces: Vec<Job> = std::iter::from_fn(|| session.take_job(1)).take(2).collect();
        for piece in pieces {
            let (sent, made) = (piece.encode(), elsewhere(&piece));
            for length in [0, 2, 4, 5, 6, sent.len() / 2, sent.len() - 1] {
                assert!(Job::decode(&sent[..length]).is_none(), "{length}");
            }
            for length in [0, 4, 5, made.len() / 4] {
                assert!(JobResult::decode(&made[..length]).is_none(), "{length}");
            }
            assert_eq!(JobId::decode(&[0, 9, 0]), None);
        }
    }

    #[test]
    fn a_run_that_is_stopped_goes_on_and_ends_the_same() {
        let expected = alone();
        for (threads, stop) in [(1, 3), (2, 1), (3, 7), (2, 40)] {
            let mut session = session();
            let mut steps = 0;
            let early = |_| {
                steps += 1;
                steps < stop
            };
            assert_eq!(session.run_while(threads, early), Ok(false), "{threads} threads, stopped at {stop}");
            assert_eq!(steps, stop);
            assert_eq!(session.run_while(threads, |_| true), Ok(true));
            assert_eq!(outcome(&session), expected, "{threads} threads, stopped at {stop}");
        }
    }
}
