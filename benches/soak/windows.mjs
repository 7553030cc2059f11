// A stream without end, window by window: what a camera of thirty frames a second gives in hours, at a size so tiny that
// six of them (648,000 frames, 12,000 windows) take forty minutes of processor time.

import { segmentVideo } from 'tracecut';
import { madeFrame, soak } from './points.mjs';

const [WIDTH, HEIGHT] = [24, 18];

async function* stream() {
  for (let t = 0; ; t += 1) yield madeFrame(t, WIDTH, HEIGHT);
}

const windows = segmentVideo(stream(), { window: 60, overlap: 6, frameRate: 30 })[Symbol.asyncIterator]();
let frames = 0;

async function window() {
  const { value } = await windows.next();
  for (const { labels } of value.frames()) frames += labels.length > 0 ? 1 : 0;
}

const result = await soak('windows', 'window', Number(process.argv[2]), window);
await windows.return();
console.log(JSON.stringify({ ...result, frames }));
