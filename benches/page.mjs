// `node benches/page.mjs`: how long the page's main thread is blocked. Prints, for reading and running a 4K clip, playing it
// with both layers, and saving 470 masks and cut-out frames, the longest task of the main thread and the number of tasks
// above 50 ms. The browser does not report shorter ones. Needs an idle machine. Options:
//   --open           instead, for the page as `npm run site` makes it: the seconds from choosing a file of 1080p to its
//                    preview, its first masks and all masks, and to the first and the last progress of each stage before
//                    the first masks, the minimum of three; and the seconds of the package in this browser on 1 and on
//                    2 threads, for the clip of `npm run bench -- --threads 2`
//   --clip FILE      opens this file instead
//   --export [KIND]  instead, seconds of a frame when a 4K clip is saved at its own size as every kind of file, or these kinds; only
//                    the processor seconds, of all processes of the browser, are true on a busy machine
//   --frames N       number of frames of the file that is made: 80 to open, 30 to save

import { mkdtempSync, writeFileSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import { parseArgs } from 'node:util';
import { build } from '../scripts/build.mjs';
import { launchBrowser } from '../scripts/browser.mjs';
import { serve } from '../scripts/serve.mjs';
import { writeSite } from '../scripts/site.mjs';

const CLIP = { width: 3840, height: 2160, frames: 30, speed: 0.012, pan: 0 };
const OPENED_CLIP = { width: 1920, height: 1080, speed: 0.006, pan: 0.001 };
/** The second size of `npm run bench`. */
const SYNTHETIC_CLIP = { width: 480, height: 270, frames: 30, seed: 1 };
const ROUNDS = 3;
const MASKS = { width: 854, height: 480, frames: 470 };
/** Maximum duration of tasks, in milliseconds. */
const LIMITS_MS = {
  reading: 50,
  running: 100,
  'playing with both layers': 100,
  'resting on 4K frames': 100,
  'zipping 470 masks': 50,
  'zipping 40 cut-out frames': 50,
};
const TIMEOUT_MS = 600_000;

const EXPORTED_SIZE = { width: 3840, height: 2160 };
/** Maximum time for a 4K frame that is saved at its own size on two cores, in seconds. */
const MAX_EXPORT_S = 0.35;
/** Long side of the masks of that clip. */
const WORKING_PX = 480;
/** The files that are made of it, by name: a function of the package and its options. */
const EXPORTS = {
  'transparent video': ['encodeVideo', { style: 'cutout', format: 'webm' }],
  'green screen': ['encodeVideo', { style: 'cutout', format: 'webm', background: '#00b140' }],
  'blurred background': ['encodeVideo', { style: 'cutout', format: 'webm', background: 'blurred' }],
  'overlay video': ['encodeVideo', { style: 'overlay', format: 'webm' }],
  'mask video': ['encodeVideo', { style: 'alpha', format: 'webm' }],
  masks: ['masksZip', {}],
  'cut-out images': ['encodeImages', { format: 'zip' }],
};

const { values: options, positionals: kinds } = parseArgs({
  options: {
    open: { type: 'boolean', default: false },
    clip: { type: 'string' },
    export: { type: 'boolean', default: false },
    frames: { type: 'string' },
  },
  allowPositionals: true,
});
await build();
const folder = mkdtempSync(join(tmpdir(), 'tracecut-'));
const server = await serve();
const browser = await launchBrowser();
try {
  if (options.export) await timeExports();
  else await (options.open ? timeOpening() : timeTasks());
} finally {
  await browser.close();
  await server.close();
}

/** Opens the page with a fresh profile, after the sample has ended. */
async function openPage({ url } = server) {
  const context = await browser.newContext({
    viewport: { width: 1280, height: 800 },
    reducedMotion: 'reduce',
    serviceWorkers: 'block',
  });
  const page = await context.newPage();
  page.setDefaultTimeout(TIMEOUT_MS);
  await page.goto(url);
  await waitForEnd(page);
  return page;
}

function waitForEnd(page) {
  return page.waitForFunction(() => ['done', 'error'].includes(document.body.dataset.state));
}

/** Opens a file and waits until its masks are computed. */
async function runClip(page, file) {
  await page.setInputFiles('#file', file);
  await page.waitForFunction(() => document.body.dataset.phase === 'running');
  await waitForEnd(page);
}

async function saveClip(page, clip) {
  const file = join(folder, 'clip.webm');
  writeFileSync(file, Buffer.from(await page.evaluate(makeClip, clip), 'base64'));
  return file;
}

/** Prints the times from choosing a file to its masks, and of the package on one thread and on two. */
async function timeOpening() {
  const maker = await openPage();
  const numFrames = Number(options.frames ?? 80);
  const clip = options.clip ?? (await saveClip(maker, { ...OPENED_CLIP, frames: numFrames }));
  let readingMs = Infinity;
  for (let round = 0; round < ROUNDS && !options.clip; round += 1)
    readingMs = Math.min(readingMs, (await maker.evaluate(readAll, numFrames)) / numFrames);
  await maker.context().close();
  await writeSite(join(folder, 'site'));
  const site = await serve({ places: [{ prefix: '/', folder: join(folder, 'site') }] });
  const marks = new Map();
  const seconds = { 1: Infinity, 2: Infinity };
  for (let round = 0; round < ROUNDS; round += 1) {
    const page = await openPage(site);
    await page.evaluate(watchMarks);
    await runClip(page, clip);
    for (const [name, ms] of await page.evaluate(() => [...globalThis.marks]))
      marks.set(name, Math.min(marks.get(name) ?? Infinity, ms));
    // In turns, so that other load on the machine affects all alike.
    for (const threads of [1, 2])
      seconds[threads] = Math.min(seconds[threads], await page.evaluate(runPackage, { threads, ...SYNTHETIC_CLIP }));
    await page.context().close();
  }
  await site.close();
  console.log('Seconds from choosing the file, the minimum of three:');
  for (const [name, ms] of [...marks].sort((a, b) => a[1] - b[1])) console.log(`${(ms / 1000).toFixed(2)}\t${name}`);
  if (!options.clip) console.log(`reading alone, at 480 pixels: ${readingMs.toFixed(1)} ms a frame`);
  const { width, height, frames } = SYNTHETIC_CLIP;
  const walls = `1 thread ${seconds[1].toFixed(2)} s, 2 threads ${seconds[2].toFixed(2)} s`;
  console.log(
    `package, ${frames} frames of ${width}x${height}: ${walls}, ratio ${(seconds[2] / seconds[1]).toFixed(3)}`,
  );
}

/** Prints the longest task of the main thread in each phase. */
async function timeTasks() {
  const page = await openPage();
  const clip = await saveClip(page, CLIP);
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
  await phase('running', () => runClip(page, clip));
  await phase('playing with both layers', async () => {
    await page.evaluate(() => {
      for (const id of ['masks', 'image']) {
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
}

/** Runs in the page. */
function watchTasks() {
  globalThis.longTasks = [];
  new PerformanceObserver((list) => {
    for (const { duration } of list.getEntries()) globalThis.longTasks.push(duration);
  }).observe({ type: 'longtask', buffered: false });
}

/** Runs in the page: collects the time at which each state and each stage of a run is reached, from the choice of a file. */
function watchMarks() {
  const { body } = document;
  const marks = (globalThis.marks = new Map());
  const counts = new Map();
  let begun = 0;
  const mark = (name) => marks.has(name) || marks.set(name, performance.now() - begun);
  const look = () => {
    if (body.hasAttribute('data-preview')) mark('preview');
    if (body.hasAttribute('data-streaming')) mark('first masks');
    if (body.dataset.phase === 'running') mark('run begins');
    const isDone = body.dataset.phase === 'done' && marks.has('run begins');
    if (isDone) mark('all masks');
    for (const { id, done } of globalThis.tracecutStudio.app.job?.stages ?? []) {
      if (!marks.has('run begins') || marks.has('first masks') || done === 0) continue;
      if (!counts.has(id)) mark(`${id}: first`);
      // The last change before the first masks.
      if (done !== counts.get(id)) marks.set(`${id}: last`, performance.now() - begun);
      counts.set(id, done);
    }
  };
  new MutationObserver(look).observe(body, { attributes: true });
  setInterval(look, 10);
  addEventListener('change', () => (begun = performance.now()), { capture: true, once: true });
}

/** Runs in the page: returns the wall seconds from the first frame to the masks. */
async function runPackage({ threads, ...size }) {
  const library = await import('/dist/index.js');
  const clip = await library.synthClip(size);
  const frames = Array.from({ length: size.frames }, (_, t) => clip.frame(t));
  clip.close();
  const session = await library.createSession({ threads });
  const begun = performance.now();
  for (const frame of frames) await session.push(frame);
  await session.run();
  session.close();
  return (performance.now() - begun) / 1000;
}

/**
 * Runs in the page: makes a file of a textured square over a textured background. `speed` and `pan` are their motion a
 * frame as shares of the width.
 */
async function makeClip({ width, height, frames, speed, pan }) {
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
      context.drawImage(ground, -width * pan * t, 0, width * (1 + pan * frames), width);
      context.drawImage(square, width * (0.2 + speed * t), height * 0.3, height * 0.4, height * 0.4);
      yield canvas;
    }
  }
  const masks = { width: 16, height: 9, numFrames: frames, labels: () => new Uint8Array(144) };
  const blob = await library.encodeVideo(masks, pictures(), { format: 'webm', quality: 'low', frameRate: 25 });
  globalThis.madeClip = blob;
  const url = await new Promise((done) => {
    const reader = new FileReader();
    reader.onload = () => done(reader.result);
    reader.readAsDataURL(blob);
  });
  return url.slice(url.indexOf(',') + 1);
}

/** Runs in the page: reads all frames at the working size, and returns the wall milliseconds. */
async function readAll(frames) {
  const library = await import('/model/library.js');
  const begun = performance.now();
  let count = 0;
  for await (const { width } of library.videoFrames(globalThis.madeClip, { size: 480 })) count += Number(width === 480);
  if (count !== frames) throw new Error(`${count} of ${frames} frames`);
  return performance.now() - begun;
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

/** Prints the seconds of a frame for each kind of file. */
async function timeExports() {
  const page = await openPage();
  const numFrames = Number(options.frames ?? 30);
  await page.evaluate(makeObjects, { ...EXPORTED_SIZE, frames: numFrames, side: WORKING_PX });
  const session = await browser.newBrowserCDPSession();
  const processorSeconds = async () => {
    const { processInfo } = await session.send('SystemInfo.getProcessInfo');
    return processInfo.reduce((sum, { cpuTime }) => sum + cpuTime, 0);
  };
  const measure = async (name, work) => {
    const before = await processorSeconds();
    const { seconds, size } = await work();
    const processor = ((await processorSeconds()) - before) / numFrames;
    const verdict = seconds <= MAX_EXPORT_S ? '' : `, above ${MAX_EXPORT_S} s`;
    const times = `${seconds.toFixed(2)} s a frame, ${processor.toFixed(2)} s of processors`;
    console.log(`${name}: ${times}, ${(size / 1e6).toFixed(1)} MB${verdict}`);
  };
  await measure('reading alone', () => page.evaluate(readFrames));
  for (const [name, [make, settings]] of Object.entries(EXPORTS))
    if (kinds.length === 0 || kinds.includes(name))
      await measure(name, () => page.evaluate(exportClip, { make, options: settings }));
}

/** Runs in the page: makes a file of two objects with wavy outlines over a textured background, and their masks. */
async function makeObjects({ width, height, frames, side }) {
  const library = await import('/model/library.js');
  const scale = side / width;
  const mask = new OffscreenCanvas(side, Math.round(height * scale)).getContext('2d', { willReadFrequently: true });
  const outline = (k, t) => {
    const path = new Path2D();
    const [x, y] = [width * (0.3 + 0.4 * k + 0.002 * t), height * (0.55 - 0.1 * k)];
    for (let step = 0; step < 720; step += 1) {
      const angle = (step * Math.PI) / 360;
      const wave = 1 + 0.2 * Math.sin(3 * angle + 0.05 * t) + 0.04 * Math.sin(31 * angle + k);
      const radius = height * (0.28 - 0.08 * k) * wave;
      path.lineTo(x + 0.7 * radius * Math.cos(angle), y + radius * Math.sin(angle));
    }
    return path;
  };
  const texture = (red, blue) => {
    const pixels = new ImageData(256, 256);
    for (let p = 0; p < 65536; p += 1) {
      const grain = Math.imul(p + 7, 2654435761) >>> 27;
      const wave = 30 * Math.sin(p / 41) + 20 * Math.sin((p >> 8) / 17);
      pixels.data.set([red + wave + grain, 90 + wave + grain, blue + grain, 255], 4 * p);
    }
    const canvas = new OffscreenCanvas(256, 256);
    canvas.getContext('2d').putImageData(pixels, 0, 0);
    return canvas;
  };
  const context = new OffscreenCanvas(width, height).getContext('2d');
  const [backdrop, ...objects] = [texture(70, 80), texture(150, 60), texture(60, 170)].map((canvas) => {
    const pattern = context.createPattern(canvas, 'repeat');
    pattern.setTransform(new DOMMatrix([3, 0, 0, 3, 0, 0]));
    return pattern;
  });
  async function* pictures() {
    for (let t = 0; t < frames; t += 1) {
      context.fillStyle = backdrop;
      context.fillRect(0, 0, width, height);
      objects.forEach((object, k) => {
        context.fillStyle = object;
        context.fill(outline(k, t));
      });
      yield context.canvas;
    }
  }
  const labels = (t) => {
    mask.setTransform(scale, 0, 0, scale, 0, 0);
    mask.clearRect(0, 0, width, height);
    [1, 2].forEach((label) => {
      mask.fillStyle = `rgb(${label} 0 0)`;
      mask.fill(outline(label - 1, t));
    });
    const { data } = mask.getImageData(0, 0, side, mask.canvas.height);
    // Pixels at the outline are partly clear.
    return Uint8Array.from({ length: data.length / 4 }, (_, p) => (data[4 * p + 3] > 127 ? data[4 * p] : 0));
  };
  const masks = { width: side, height: mask.canvas.height, numFrames: frames, times: null };
  const kept = Array.from({ length: frames }, (_, t) => labels(t));
  const empty = { ...masks, width: 16, height: 9, labels: () => new Uint8Array(144) };
  const file = await library.encodeVideo(empty, pictures(), { format: 'webm', quality: 'high', frameRate: 30 });
  globalThis.exported = { file, masks: { ...masks, labels: (t) => kept[t] } };
}

/** Runs in the page: decodes the clip and returns the seconds of a frame. */
async function readFrames() {
  const library = await import('/model/library.js');
  const { file, masks } = globalThis.exported;
  const begun = performance.now();
  for await (const { frame } of library.videoFrames(file))
    if (frame.codedWidth === 0) throw new Error('a closed frame');
  return { seconds: (performance.now() - begun) / 1000 / masks.numFrames, size: file.size };
}

/** Runs in the page: saves the clip as a file and returns its size and the seconds of a frame. */
async function exportClip({ make, options }) {
  const library = await import('/model/library.js');
  const { file, masks } = globalThis.exported;
  const begun = performance.now();
  const frames = library.videoFrames(file);
  const shared = { frameRate: 30 };
  const made =
    make === 'masksZip'
      ? new Blob([await library.masksZip(await library.masksAtSize(masks, frames), { ...options, ...shared })])
      : await library[make](masks, frames, { ...options, ...shared });
  const { size } = made instanceof Blob ? made : await new Response(made).blob();
  return { seconds: (performance.now() - begun) / 1000 / masks.numFrames, size };
}
