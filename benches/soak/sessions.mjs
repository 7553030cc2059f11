// Sessions one after the other in one process, each opened, fed, run, asked and closed.

import { createSession } from 'tracecut';
import { madeFrame, soak } from './points.mjs';

const frames = [0, 1, 2, 3].map((t) => madeFrame(t));

async function session() {
  const one = await createSession();
  for (const frame of frames) await one.push(frame);
  const result = await one.run();
  await result.superpixels(1);
  one.close();
}

console.log(JSON.stringify(await soak('sessions', 'session', Number(process.argv[2]), session)));
