// `node benches/export.mjs`: seconds of a frame when a 4K clip of 30 frames is saved in the page at its own size, as every
// kind of file. Options: `--frames N` for another number of frames; names of kinds for these alone. Needs an idle machine; only
// the processor seconds, of all processes of the browser, are true on a busy one.

import { parseArgs } from 'node:util';
import { build } from '../scripts/build.mjs';
import { launchBrowser } from '../scripts/browser.mjs';
import { serve } from '../scripts/serve.mjs';

const SIZE = { width: 3840, height: 2160 };
const TIMEOUT_MS = 600_000;
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
  options: { frames: { type: 'string', default: '30' } },
  allowPositionals: true,
});
const numFrames = Number(options.frames);

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
  await measureExports(page);
} finally {
  await browser.close();
  await server.close();
}

/** Prints the seconds of a frame for each kind of file. */
async function measureExports(page) {
  await page.evaluate(makeObjects, { ...SIZE, frames: numFrames, side: WORKING_PX });
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
      await measure(name, () => page.evaluate(saveClip, { make, options: settings }));
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
async function saveClip({ make, options }) {
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
