// Code of the README, the guide and the tasks for browsers, and the example for mediabunny, unchanged in pages that have
// installed the package.

import { cpSync, writeFileSync } from 'node:fs';
import { join } from 'node:path';
import { pathToFileURL } from 'node:url';
import { synthClip } from '../../dist/node.js';
import { root } from '../../scripts/tools.mjs';
import { TASKS, alphaOverlaps, codeOf, readmeCode, readmePage, writeSceneVideo } from '../readme.mjs';
import { installed, served } from '../package/project.mjs';
import { expect, test } from './fixtures.mjs';
import { needsFfmpeg } from './video-clips.mjs';

const SCENE = { width: 160, height: 90, frames: 8, seed: 1 };
const PAGE = `<!doctype html>
<link rel="icon" href="data:,">
<script type="importmap">{ "imports": { "tracecut": "./node_modules/tracecut/dist/index.js", "tracecut/export": "./node_modules/tracecut/dist/export.js"
}  }</script>
<script type="module" src="./main.js"></script>
<input type="file"><canvas></canvas>`;
const code = new Map([...readmeCode(), ...codeOf('docs/tasks.md')]);

let folder;
/** A video file of the scene; the number of objects that are found in it depends on the encoder. */
let clip;
const cleanups = [];
test.beforeAll(async ({ openEmptyPage }) => {
  folder = installed({ after: (clean) => cleanups.push(clean) });
  const page = await openEmptyPage();
  const bytes = await page.evaluate(async (options) => {
    const { encodeVideo, synthClip: createScene } = await import('/dist/index.js');
    const scene = await createScene(options);
    const frames = Array.from({ length: scene.numFrames }, (_, t) => scene.frame(t));
    const masks = { width: scene.width, height: scene.height, numFrames: frames.length, labels: (t) => scene.mask(t) };
    const file = await encodeVideo(masks, frames, { opacity: 0, outline: false, frameRate: 10, quality: 'very-high' });
    return [...new Uint8Array(await file.arrayBuffer())];
  }, SCENE);
  clip = { name: 'clip.webm', mimeType: 'video/webm', buffer: Buffer.from(bytes) };
  await page.context().close();
});
test.afterAll(() => cleanups.forEach((clean) => clean()));

/** Runs a block of code that expects `file` and the package's names, then returns an expression's value and what was logged. */
async function runWithFile({ cleanup, openPage }, heading, expression) {
  writeFileSync(join(folder, 'index.html'), PAGE);
  writeFileSync(
    join(folder, 'main.js'),
    `import * as tracecut from 'tracecut';
    import * as files from 'tracecut/export';
    Object.assign(globalThis, tracecut, files);
    const file = await new Promise((resolve) => {
      document.querySelector('input').onchange = ({ target }) => resolve(target.files[0]);
    });
    ${code.get(heading)}
    globalThis.outcome = ${expression};`,
  );
  const lines = [];
  const page = await openPage(await served(cleanup, folder), (target) =>
    target.on('console', (message) => lines.push(message.text())),
  );
  await page.waitForFunction(() => document.querySelector('input').onchange);
  await page.locator('input').setInputFiles(clip);
  await page.waitForFunction(() => 'outcome' in globalThis);
  return { outcome: await page.evaluate(() => globalThis.outcome), lines };
}

test('the page of the README, target as a file, loads one script and shows a video with coloured objects', async ({
  openPage,
}) => {
  const html = readmePage();
  expect(html.trimEnd().split('\n')).toHaveLength(12);
  const [address] = /https:[^']+/.exec(html);
  writeFileSync(join(folder, 'page.html'), html);
  const requests = [];
  const page = await openPage(pathToFileURL(join(folder, 'page.html')).href, async (target) => {
    target.on('request', (request) => /^https?:/.test(request.url()) && requests.push(request.url()));
    const headers = { 'Access-Control-Allow-Origin': '*' };
    const path = join(folder, 'node_modules/tracecut/dist/inline.js');
    await target.route(address, (route) => route.fulfill({ path, headers, contentType: 'text/javascript' }));
    await target.addInitScript(recordDrawing);
  });
  await page.waitForFunction(() => document.querySelector('input').onchange);
  await page.locator('input').setInputFiles(clip);
  await page.waitForFunction(() => globalThis.drawings.length >= 8);
  const mask = (await synthClip(SCENE)).mask(7);
  const [frame, coloured] = await page.evaluate(() => globalThis.drawings.at(-1));
  const changedShare = (isObject) => {
    const pixels = [...mask.keys()].filter((p) => mask[p] > 0 === isObject);
    return pixels.filter((p) => Math.abs(frame[4 * p] - coloured[4 * p]) > 3).length / pixels.length;
  };
  expect(changedShare(true)).toBeGreaterThan(0.8);
  expect(changedShare(false)).toBeLessThan(0.2);
  expect(requests).toEqual([address]);
});

/** Runs in the page: records the pixels of the canvas after each frame, and after its masks. */
function recordDrawing() {
  globalThis.drawings = [];
  const { drawImage } = CanvasRenderingContext2D.prototype;
  CanvasRenderingContext2D.prototype.drawImage = function (...args) {
    drawImage.apply(this, args);
    if (!this.canvas.isConnected || !(args[0] instanceof VideoFrame)) return;
    const pixels = () => [...this.getImageData(0, 0, this.canvas.width, this.canvas.height).data];
    const frame = pixels();
    queueMicrotask(() => globalThis.drawings.push([frame, pixels()]));
  };
}

test('the windows of the guide have the times and masks of all frames', async ({ cleanup, openPage }) => {
  const { lines } = await runWithFile({ cleanup, openPage }, 'Video', 'true');
  expect(lines).toContainEqual(expect.stringMatching(/^shot 0, objects 1/));
  const frames = lines.filter((line) => line.endsWith(` ${SCENE.width * SCENE.height}`));
  const times = frames.map((line) => Number(line.split(' ')[0]).toFixed(1));
  expect(times).toEqual(['0.0', '0.1', '0.2', '0.3', '0.4', '0.5', '0.6', '0.7']);
});

test('the results of the guide', async ({ cleanup, openPage }) => {
  const expression = '[masks.numFrames, masks.objects.length]';
  const { outcome } = await runWithFile({ cleanup, openPage }, 'What comes out', expression);
  expect(outcome[0]).toBe(8);
  expect(outcome[1]).toBeGreaterThanOrEqual(1);
});

test('the effects of the tasks are three different videos', async ({ cleanup, openPage }) => {
  const expression = '[blur, spotlight, replace].map(({ type, size }) => [type, size])';
  const { outcome } = await runWithFile({ cleanup, openPage }, TASKS.browser[0], expression);
  expect(new Set(outcome.map(([type]) => type))).toEqual(new Set(['video/mp4']));
  expect(new Set(outcome.map(([, size]) => size)).size).toBe(3);
  for (const [, size] of outcome) expect(size).toBeGreaterThan(1000);
});

test('the example for mediabunny writes the objects with alpha', { tag: '@long' }, async ({ cleanup, openPage }) => {
  needsFfmpeg();
  const example = installed(cleanup, 'examples/mediabunny');
  cpSync(join(root, 'node_modules', 'mediabunny'), join(example, 'node_modules', 'mediabunny'), { recursive: true });
  const source = join(example, 'clip.webm');
  await writeSceneVideo(source, ['-c:v', 'libvpx', '-b:v', '4M']);
  const page = await openPage(await served(cleanup, example));
  await page.locator('input').setInputFiles(source);
  const [download] = await Promise.all([page.waitForEvent('download'), page.locator('a').click()]);
  expect(download.suggestedFilename()).toBe('cutout.webm');
  // The browser decodes colours a little differently.
  const overlaps = await alphaOverlaps(await download.path(), source, ['-c:v', 'libvpx-vp9']);
  expect(Math.min(...overlaps)).toBeGreaterThan(0.7);
});
