// The parts of the soak test in Node: `node --expose-gc benches/soak/node.mjs COUNT PART`.

import { createSession, segmentVideo } from 'tracecut';
import { madeFrame, soak } from './points.mjs';

const AT_ONCE = 100;
const frames = [0, 1, 2, 3].map((t) => madeFrame(t));
const small = [0, 1, 2].map((t) => madeFrame(t, 32, 24));
const [count, part] = [Number(process.argv[2]), process.argv[3]];

const PARTS = {
  /** Sessions one after the other, each opened, fed, run, queried and closed. */
  async sessions() {
    return soak('sessions', 'session', count, async () => {
      const one = await createSession();
      for (const frame of frames) await one.push(frame);
      const result = await one.run();
      await result.superpixels(1);
      one.close();
    });
  },

  /** A hundred sessions at once, in rounds: all open and fed before the first is run. */
  async crowd() {
    const result = await soak('crowd', `round of ${AT_ONCE} sessions`, count, async () => {
      const all = await Promise.all(Array.from({ length: AT_ONCE }, () => createSession()));
      await Promise.all(all.map(async (one) => Promise.all(small.map((frame) => one.push(frame)))));
      await Promise.all(all.map((one) => one.run()));
      for (const one of all) one.close();
    });
    // Per session, as for the others.
    return { ...result, slope: { heap: result.slope.heap / AT_ONCE, rss: result.slope.rss / AT_ONCE } };
  },

  /**
   * An endless stream, window by window: hours of a camera with thirty frames a second, at a size so tiny that six hours
   * (648,000 frames, 12,000 windows) take forty minutes of processor time.
   */
  async windows() {
    async function* stream() {
      for (let t = 0; ; t += 1) yield madeFrame(t, 24, 18);
    }
    const windows = segmentVideo(stream(), { window: 60, overlap: 6, frameRate: 30 })[Symbol.asyncIterator]();
    let seen = 0;
    const result = await soak('windows', 'window', count, async () => {
      const { value } = await windows.next();
      for (const { labels } of value.frames()) seen += labels.length > 0 ? 1 : 0;
    });
    await windows.return();
    return { ...result, frames: seen };
  },
};

console.log(JSON.stringify(await PARTS[part]()));
