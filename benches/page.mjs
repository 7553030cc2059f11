// `node benches/page.mjs`: how long the page's main thread is blocked. Prints, for reading and running a 4K clip, playing it
// with three layers, and saving 470 masks and cut-out frames, the longest task of the main thread and the number of tasks
// above 50 ms. The browser does not report shorter ones. Needs an idle machine.

import { mkdtempSync, writeFileSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import { build } from '../scripts/build.mjs';
import { launchBrowser } from '../scripts/browser.mjs';
import { serve } from '../scripts/serve.mjs';

const CLIP = { width: 3840, height: 2160, frames: 30 };
const MASKS = { width: 854, height: 480, frames: 470 };
/** Maximum duration of tasks, in milliseconds. */
const LIMITS_MS = {
  reading: 50,
  running: 100,
  'playing with three layers': 100,
  'resting on 4K frames': 100,
  'zipping 470 masks': 50,
  'zipping 40 cut-out frames': 50,
};
const TIMEOUT_MS = 600_000;

await build();
const server = await serve();
const browser = await launchBrowser();
try {
  const context = await browser.newContext({
    viewport: { width: 1280, height: 800 },
    reducedMotion: 'reduce',
    serviceWorkers: 'block',
  });
  const page = await context.newPage();
  page.setDefaultTimeout(TIMEOUT_MS);
  await page.goto(server.url);
  await page.waitForFunction(() => ['done', 'error'].includes(document.body.dataset.state));
  const clip = join(mkdtempSync(join(tmpdir(), 'tracecut-')), 'clip-4k.webm');
  writeFileSync(clip, Buffer.from(await page.evaluate(makeClip, CLIP), 'base64'));
  await page.evaluate(watchTasks);
  const figures = [];
  const phase = async (name, work) => {
    await page.evaluate(() => new Promise((done) => setTimeout(done, 300)));
    await page.evaluate(() => globalThis.longTasks.splice(0));
    const begun = performance.now();
    await work();
    // An observer sees a task only after it ends.
    await page.evaluate(() => new Promise((done) => setTimeout(done, 300)));
    const tasks = await page.evaluate(() => globalThis.longTasks.splice(0));
    const longest = Math.round(Math.max(0, ...tasks));
    const shown = longest > 0 ? `${longest} ms` : 'none above 50 ms';
    figures.push([name, longest <= LIMITS_MS[name]]);
    console.log(`${name}: ${shown}, ${tasks.length} tasks in ${((performance.now() - begun) / 1000).toFixed(1)} s`);
  };

  await phase('reading', () => page.evaluate(readAll, CLIP.frames));
  await phase('running', async () => {
    await page.setInputFiles('#file', clip);
    await page.waitForFunction(() => document.body.dataset.phase === 'running');
    await page.waitForFunction(() => ['done', 'error'].includes(document.body.dataset.state));
  });
  await phase('playing with three layers', async () => {
    await page.evaluate(() => {
      for (const id of ['masks', 'trajectories', 'superpixels']) {
        const box = document.querySelector(`[data-layer="${id}"]`);
        if (!box.checked) box.click();
      }
      if (document.querySelector('#play').getAttribute('aria-label') !== 'Pause')
        document.querySelector('#play').click();
    });
    await page.waitForTimeout(5000);
    await page.click('#play');
  });
  await phase('resting on 4K frames', async () => {
    for (const t of [3, 11, 25]) {
      await page.evaluate((frame) => globalThis.tracecutStudio.app.timeline.seek(frame), t);
      await page.waitForTimeout(2500);
    }
  });
  await phase('zipping 470 masks', () => page.evaluate(zipMasks, MASKS));
  await phase('zipping 40 cut-out frames', () => page.evaluate(zipCutouts, MASKS));
  const over = figures.filter(([, isBelow]) => !isBelow).map(([name]) => name);
  console.log(over.length > 0 ? `Above the limit: ${over.join(', ')}.` : 'All below the limits.');
} finally {
  await browser.close();
  await server.close();
}

/** Runs in the page. */
function watchTasks() {
  globalThis.longTasks = [];
  new PerformanceObserver((list) => {
    for (const { duration } of list.getEntries()) globalThis.longTasks.push(duration);
  }).observe({ type: 'longtask', buffered: false });
}

/** Runs in the page: makes a file of a textured square over a textured background. */
async function makeClip({ width, height, frames }) {
  const library = await import('/model/library.js');
  const texture = (salt, side) => {
    const small = new ImageData(side, side);
    for (let p = 0; p < side * side; p += 1) {
      const h = Math.imul(p + 7 + salt, 2654435761) >>> 24;
      small.data.set([60 + (h % 120), 60 + (h % 97), salt > 1 ? 200 : 80, 255], 4 * p);
    }
    const canvas = new OffscreenCanvas(side, side);
    canvas.getContext('2d').putImageData(small, 0, 0);
    return canvas;
  };
  const [ground, square] = [texture(1, 160), texture(9, 40)];
  const canvas = new OffscreenCanvas(width, height);
  const context = canvas.getContext('2d');
  async function* pictures() {
    for (let t = 0; t < frames; t += 1) {
      context.drawImage(ground, 0, 0, width, width);
      context.drawImage(square, width * (0.2 + 0.012 * t), height * 0.3, height * 0.4, height * 0.4);
      yield canvas;
    }
  }
  const masks = { width: 16, height: 9, numFrames: frames, labels: () => new Uint8Array(144) };
  const blob = await library.encodeVideo(masks, pictures(), { format: 'webm', quality: 'low', frameRate: 25 });
  globalThis.clip4k = blob;
  const url = await new Promise((done) => {
    const reader = new FileReader();
    reader.onload = () => done(reader.result);
    reader.readAsDataURL(blob);
  });
  return url.slice(url.indexOf(',') + 1);
}

/** Runs in the page: reads all frames at the working size. */
async function readAll(frames) {
  const library = await import('/model/library.js');
  let count = 0;
  for await (const { width } of library.videoFrames(globalThis.clip4k, { size: 480 })) count += Number(width === 480);
  if (count !== frames) throw new Error(`${count} of ${frames} frames`);
}

/** Runs in the page: makes an archive of many masks. */
async function zipMasks({ width, height, frames }) {
  const library = await import('/model/library.js');
  const labels = (t) => {
    const mask = new Uint8Array(width * height);
    for (let y = 100; y < 300; y += 1) mask.fill(1, y * width + t, y * width + t + 150 + (y % 40));
    return mask;
  };
  const bytes = await library.masksZip({ width, height, numFrames: frames, labels }, { frameRate: 25 });
  if (bytes.length < 1e5) throw new Error(`${bytes.length} bytes`);
}

/** Runs in the page: makes an archive of pictures with alpha. */
async function zipCutouts({ width, height }) {
  const library = await import('/model/library.js');
  const numFrames = 40;
  const labels = () => new Uint8Array((width * height) / 4).fill(1, 20_000, 60_000);
  const picture = new ImageData(width, height);
  for (let k = 0; k < picture.data.length; k += 1)
    picture.data[k] = k % 4 === 3 ? 255 : Math.imul(k, 2654435761) >>> 24;
  const masks = { width: width / 2, height: height / 2, numFrames, labels };
  const stream = await library.encodeImages(masks, Array(numFrames).fill(picture), { frameRate: 25 });
  const { size } = await new Response(stream).blob();
  if (size < 1e6) throw new Error(`${size} bytes`);
}
