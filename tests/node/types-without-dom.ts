// Never run: it has to compile in a project for Node that knows no browser types, as `types.ts` does in one that knows
// them.

import { createSession, maskPng, segmentVideo, synthClip, type Result } from 'tracecut';

const clip = await synthClip({ width: 320, height: 180, frames: 10 });
const session = await createSession({ clip: { seed: 1 } });
await session.push(clip.frame(0));
const result: Result = await session.run();
const file: Uint8Array = await maskPng(result, 0);
for await (const window of segmentVideo([clip.frame(0)])) {
  const times: Float64Array = window.times;
  console.log(times, file);
}

// @ts-expect-error: parameters are known by name
await createSession({ clip: { maxSize: 320 } });
