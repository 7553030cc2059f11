// Simulates the cost of a run on any number of cores: every step, job and transfer is run and timed here, one after the
// other, and scheduled as the engine and its helpers would.

/** Time of a Node message from one thread to another, in seconds. */
const LATENCY = 0.00005;
/** As in the engine: maximum steps, and maximum seconds, between two checks for results of helpers. */
const [SLICE_STEPS, SLICE_SECONDS] = [16, 0.03];
/** As in its pool: number of jobs that a helper has at a time, and of frame pairs that may be ahead for each. */
const [IN_HAND, PAIRS_AHEAD] = [3, 2];

/** Returns the result of `work` and its processor seconds. */
function timed(work) {
  const before = process.cpuUsage();
  const result = work();
  const { user, system } = process.cpuUsage(before);
  return [result, (user + system) / 1e6];
}

/**
 * Measures the serial seconds of the session, stage by stage, and the seconds of all jobs. Each job is back before the step
 * that needs it.
 */
export function shares(glue, clip, width, height) {
  const [session, helper] = [new glue.Session({}), new glue.Session({})];
  const found = { stages: {}, transfers: 0, pieces: 0 };
  const push = ({ data }) => session.pushRgba(data, width, height);
  [, found.stages.frames] = timed(() => clip.forEach(push));
  for (let stage; ;) {
    for (;;) {
      const [piece, given] = timed(() => session.takePiece(clip.length));
      if (!piece) break;
      const [made, seconds] = timed(() => helper.workOn(piece));
      const [, taken] = timed(() => session.accept(made));
      found.pieces += seconds;
      found.transfers += given + taken;
    }
    const [progress, seconds] = timed(() => session.step());
    // Time after the last step of a stage belongs to the stage.
    stage = progress?.stage ?? stage;
    found.stages[stage] = (found.stages[stage] ?? 0) + seconds;
    if (progress) continue;
    [, found.stages.results] = timed(() => read(session, clip.length));
    for (const each of [session, helper]) each.free();
    return found;
  }
}

/** Reads what the package reads from a session at the end of a run. */
function read(session, frames) {
  const names = ['trajectories', 'clusters', 'thresholdClusters', 'embedding', 'edges', 'saliency', 'components'];
  for (const name of names) session[name]();
  const labels = [];
  for (let t = 0; t < frames; t += 1) labels.push(session.labels(t).slice());
}

/** Returns the wall seconds from the first frame to the result on a number of cores. */
export function wall(glue, clip, width, height, cores) {
  const [session, worker] = [new glue.Session({}), new glue.Session({})];
  const helpers = Array.from({ length: cores - 1 }, () => ({ free: 0, hands: [] }));
  const ahead = PAIRS_AHEAD * helpers.length + 2;
  let now = 0;
  let back = [];
  const here = (work) => {
    const [result, seconds] = timed(work);
    now += seconds;
    return result;
  };
  const receive = () => {
    for (const helper of helpers) {
      back.push(...helper.hands.filter(({ at }) => at <= now));
      helper.hands = helper.hands.filter(({ at }) => at > now);
    }
  };
  const exchange = () => {
    for (const { made } of back.splice(0)) here(() => session.accept(made));
    for (let most = 1; most <= IN_HAND; most += 1)
      for (const helper of helpers) {
        if (helper.hands.length >= most) continue;
        const piece = here(() => session.takePiece(ahead));
        if (!piece) return;
        const [made, seconds] = timed(() => worker.workOn(piece));
        helper.free = Math.max(helper.free, now + LATENCY) + seconds;
        helper.hands.push({ made, at: helper.free + LATENCY });
      }
  };
  const first = () => Math.min(...helpers.flatMap(({ hands }) => hands.map(({ at }) => at)));
  for (const { data } of clip) {
    here(() => session.pushRgba(data, width, height));
    receive();
    exchange();
  }
  for (;;) {
    receive();
    const began = now;
    for (let steps = 1; ; steps += 1) {
      exchange();
      let pause = false;
      if (helpers.some(({ hands }) => hands.length > 0) && session.awaits()) {
        pause = true;
        if (!here(() => session.makePiece(ahead))) now = Math.max(now, first());
      } else if (!here(() => session.step())) {
        here(() => read(session, clip.length));
        for (const each of [session, worker]) each.free();
        return now;
      }
      if (pause || steps >= SLICE_STEPS || now - began >= SLICE_SECONDS) break;
    }
  }
}
