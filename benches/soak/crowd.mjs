// A hundred sessions at once, in rounds: all open and fed before the first is run.

import { createSession } from 'tracecut';
import { madeFrame, soak } from './points.mjs';

const AT_ONCE = 100;
const frames = [0, 1, 2].map((t) => madeFrame(t, 32, 24));

async function crowd() {
  const all = await Promise.all(Array.from({ length: AT_ONCE }, () => createSession()));
  await Promise.all(all.map(async (one) => Promise.all(frames.map((frame) => one.push(frame)))));
  await Promise.all(all.map((one) => one.run()));
  for (const one of all) one.close();
}

const result = await soak('crowd', `round of ${AT_ONCE} sessions`, Number(process.argv[2]), crowd);
// Of a session, as with the others.
const slope = { heap: result.slope.heap / AT_ONCE, rss: result.slope.rss / AT_ONCE };
console.log(JSON.stringify({ ...result, slope }));
