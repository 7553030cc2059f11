// The parts of the soak test but for the long clips: `node --expose-gc benches/soak/parts.mjs COUNT PART`.

import { readFileSync } from 'node:fs';
import { setTimeout as pause } from 'node:timers/promises';
import { createSession, segmentVideo } from 'tracecut';
import { plainFrame, textureAt } from '../../tests/moving.mjs';
import { pngBytes } from '../../tests/png.mjs';

const AT_ONCE = 100;
/** Images of a clip of the page. */
const FRAMES = 4;
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

  page: soakPage,
};

/** A page that runs for long: it opens one clip of files after the other, segments it and shows it. */
async function soakPage() {
  // Only here, as the other parts measure this process.
  const { launchBrowser } = await import('../../scripts/browser.mjs');
  const { serve } = await import('../../scripts/serve.mjs');
  const server = await serve();
  // Interpreted: compiled code grows for as long as more functions become hot, by kilobytes a clip for a thousand clips.
  const browser = await launchBrowser({ args: ['--js-flags=--no-opt --no-maglev --no-sparkplug'] });
  const context = await browser.newContext({ serviceWorkers: 'block' });
  const page = await context.newPage();
  page.setDefaultTimeout(300_000);
  const session = await context.newCDPSession(page);
  await page.goto(server.url);
  const done = () => page.waitForFunction(() => ['done', 'error'].includes(document.body.dataset.state));
  await done();

  async function clip(k) {
    const files = Array.from({ length: FRAMES }, (_, t) => ({
      name: `clip${k}-${t}.png`,
      mimeType: 'image/png',
      buffer: pngBytes(madeFrame(4 * k + t), { channels: 4 }),
    }));
    await page.setInputFiles('#file', files);
    await page.waitForFunction((name) => document.querySelector('#clip-name').textContent.includes(name), `clip${k}`);
    await done();
  }

  /**
   * Measures the live objects of the main thread, of scripts and of the browser, and the memory of the page's process with its
   * workers, which collect garbage when the browser signals low memory.
   */
  async function measure() {
    await session.send('Memory.simulatePressureNotification', { level: 'critical' });
    for (let k = 0; k < 3; k += 1) {
      await session.send('HeapProfiler.collectGarbage');
      await pause(100);
    }
    const usage = await session.send('Runtime.getHeapUsage');
    const { usedSize, backingStorageSize = 0, embedderHeapUsedSize = 0 } = usage;
    return { heap: usedSize + backingStorageSize + embedderHeapUsedSize, rss: await renderers() };
  }

  /**
   * Returns the resident bytes of all renderer processes, without files and memory shared with the GPU process, where tiles
   * come and go by megabytes.
   */
  async function renderers() {
    const { processInfo } = await (await browser.newBrowserCDPSession()).send('SystemInfo.getProcessInfo');
    const ids = processInfo.filter(({ type }) => type === 'renderer').map(({ id }) => id);
    const kilobytes = ids.map((id) =>
      Number(/^RssAnon:\s+(\d+) kB$/m.exec(readFileSync(`/proc/${id}/status`, 'utf8'))[1]),
    );
    return 1024 * kilobytes.reduce((sum, size) => sum + size, 0);
  }

  const result = await soak('page', 'clip', count, clip, measure);
  await browser.close();
  await server.close();
  return { ...result, cpuSeconds: null };
}

/** Number of points of a curve; the first half is the warm-up. */
const POINTS = 20;

/**
 * Runs `work` `count` times and measures memory in between, after collecting garbage.
 * @param {string} part
 * @param {string} unit name of one repetition
 * @param {number} count
 * @param {(k: number) => Promise<void>} work
 * @param {() => Promise<{heap: number, rss: number}>} [measure]
 * @returns {Promise<import('../soak.mjs').SoakResult>}
 */
async function soak(part, unit, count, work, measure = processMemory) {
  const points = [];
  const every = Math.max(1, Math.floor(count / POINTS));
  const began = process.cpuUsage();
  for (let k = 1; k <= count; k += 1) {
    await work(k);
    if (k % every === 0) points.push({ done: k, ...(await measure()) });
  }
  const { user, system } = process.cpuUsage(began);
  const cpuSeconds = Math.round((user + system) / 1e5) / 10;
  const late = points.slice(points.length >> 1);
  const slope = { heap: slopeOf(late, 'heap'), rss: slopeOf(late, 'rss') };
  return { part, unit, count, cpuSeconds, points, slope };
}

/** Returns the memory of this process in bytes; `rss` includes wasm memories. */
async function processMemory() {
  // Finalizers run in a separate task.
  for (let k = 0; k < 3; k += 1) {
    globalThis.gc();
    await pause(10);
  }
  const { heapUsed, external, rss } = process.memoryUsage();
  return { heap: heapUsed + external, rss };
}

/** Returns the bytes per repetition: the median slope between any two points, which single outliers do not move. */
function slopeOf(points, key) {
  const slopes = points.flatMap((from, k) =>
    points.slice(k + 1).map((to) => (to[key] - from[key]) / (to.done - from.done)),
  );
  slopes.sort((a, b) => a - b);
  return (slopes[(slopes.length - 1) >> 1] + slopes[slopes.length >> 1]) / 2;
}

/** Returns the pixels of frame `t` of an endless clip: a square that moves to and fro over noise. */
function madeFrame(t, width = 48, height = 36) {
  const left = 4 + Math.abs((t % 40) - 20);
  return plainFrame(width, height, (x, y) => {
    const inside = x >= left && x < left + 14 && y >= 10 && y < 26;
    const value = inside ? textureAt(x - left, y, 2) : textureAt(x, y, 1);
    return [value, value, inside ? 255 - value : value];
  });
}

console.log(JSON.stringify(await PARTS[part]()));
