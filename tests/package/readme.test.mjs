// The README's and the guide's blocks of code for browsers, run as they stand on a page that has installed the package.

import assert from 'node:assert/strict';
import { writeFileSync } from 'node:fs';
import { join } from 'node:path';
import { after, before, test } from 'node:test';
import { pathToFileURL } from 'node:url';
import { emptyPage } from '../browser/empty-page.mjs';
import { synthClip } from '../../dist/node.js';
import { TASKS, codeOf, readmeCode, readmePage } from '../readme.mjs';
import { useServerAndBrowser } from '../site.mjs';
import { installed, served } from './installed.mjs';

const site = useServerAndBrowser();
const code = new Map([...readmeCode(), ...codeOf('docs/tasks.md')]);
const cleaners = [];
let folder;
let clip;

before(() => {
  folder = installed({ after: (clean) => cleaners.push(clean) });
});
after(() => cleaners.forEach((clean) => clean()));

const PAGE = `<!doctype html>
<link rel="icon" href="data:,">
<script type="importmap">{ "imports": {
  "tracecut": "./node_modules/tracecut/dist/index.js", "tracecut/export": "./node_modules/tracecut/dist/export.js"
}  }</script>
<script type="module" src="./main.js"></script>
<input type="file"><canvas></canvas>`;

/** A page with this code, which has chosen the clip; errors fail the test. */
async function open(t, script) {
  writeFileSync(join(folder, 'index.html'), PAGE);
  writeFileSync(join(folder, 'main.js'), script);
  const page = await site.browser.newPage();
  const lines = [];
  const wrong = [];
  page.on('console', (message) => (message.type() === 'error' ? wrong : lines).push(message.text()));
  page.on('pageerror', (error) => wrong.push(error.message));
  t.after(async () => {
    await page.close();
    assert.deepEqual(wrong, []);
  });
  await page.goto(await served(t, folder));
  return { page, lines };
}

/** A short video file of the sample scene; how many objects are found in it depends on the browser's encoder. */
async function madeClip() {
  if (clip) return clip;
  const page = await emptyPage({ after: (clean) => cleaners.push(clean) }, site);
  const bytes = await page.evaluate(async () => {
    const { encodeVideo, synthClip } = await import('/dist/index.js');
    const scene = await synthClip({ width: 160, height: 90, frames: 8, seed: 1 });
    const frames = Array.from({ length: 8 }, (_, t) => scene.frame(t));
    const masks = { width: 160, height: 90, numFrames: 8, labels: (t) => scene.mask(t) };
    const file = await encodeVideo(masks, frames, { opacity: 0, outline: false, frameRate: 10, quality: 'very-high' });
    return [...new Uint8Array(await file.arrayBuffer())];
  });
  clip = { name: 'clip.webm', mimeType: 'video/webm', buffer: Buffer.from(bytes) };
  return clip;
}

/** Runs a block that takes `file` and the package's names for granted, and then `check`. */
async function runWithFile(t, heading, check) {
  const { page, lines } = await open(
    t,
    `
    import * as tracecut from 'tracecut';
    import * as files from 'tracecut/export';
    Object.assign(globalThis, tracecut, files);
    const file = await new Promise((chosen) => { document.querySelector('input').onchange = ({ target }) => chosen(target.files[0]); });
    ${code.get(heading)}
    globalThis.outcome = ${check};`,
  );
  await page.waitForFunction(() => document.querySelector('input').onchange);
  await page.locator('input').setInputFiles(await madeClip());
  await page.waitForFunction(() => 'outcome' in globalThis);
  return { outcome: await page.evaluate(() => globalThis.outcome), lines };
}

test("the README's page, opened as a file, shows a video with its objects coloured", async (t) => {
  const text = readmePage();
  assert.equal(text.trimEnd().split('\n').length, 12);
  const [address] = /https:[^']+/.exec(text);
  const { page, asked } = await openFile(t, text, address);
  await page.waitForFunction(() => document.querySelector('input').onchange);
  await page.locator('input').setInputFiles(await madeClip());
  await page.waitForFunction(() => globalThis.drawn.length >= 8);
  const mask = (await synthClip({ width: 160, height: 90, frames: 8, seed: 1 })).mask(7);
  const [before, after] = (await page.evaluate(() => globalThis.drawn.at(-1))).map((list) => Uint8Array.from(list));
  const share = (isObject) => {
    const pixels = [...mask.keys()].filter((p) => mask[p] > 0 === isObject);
    return pixels.filter((p) => Math.abs(before[4 * p] - after[4 * p]) > 3).length / pixels.length;
  };
  assert.ok(share(true) > 0.8 && share(false) < 0.2, `${share(true)} of the objects, ${share(false)} of the rest`);
  assert.deepEqual(asked, [address], 'one file is loaded, and nothing else');
});

/** Opens a page from a file of its own; the address has the file that a CDN would have. */
async function openFile(t, text, address) {
  const file = join(folder, 'page.html');
  writeFileSync(file, text);
  const page = await site.browser.newPage();
  const [wrong, asked] = [[], []];
  t.after(async () => {
    await page.close();
    assert.deepEqual(wrong, []);
  });
  page.on('console', (message) => message.type() === 'error' && wrong.push(message.text()));
  page.on('pageerror', (error) => wrong.push(error.message));
  page.on('request', (request) => /^https?:/.test(request.url()) && asked.push(request.url()));
  const headers = { 'Access-Control-Allow-Origin': '*' };
  const path = join(folder, 'node_modules/tracecut/dist/inline.js');
  await page.route(address, (route) => route.fulfill({ path, headers, contentType: 'text/javascript' }));
  await page.addInitScript(watchDrawing);
  await page.goto(pathToFileURL(file).href);
  return { page, asked };
}

/** Runs in the page: `drawn` are the pixels of the canvas after each frame, and after its masks. */
function watchDrawing() {
  globalThis.drawn = [];
  const { drawImage } = CanvasRenderingContext2D.prototype;
  CanvasRenderingContext2D.prototype.drawImage = function (...args) {
    drawImage.apply(this, args);
    if (!this.canvas.isConnected || !(args[0] instanceof VideoFrame)) return;
    const pixels = () => [...this.getImageData(0, 0, this.canvas.width, this.canvas.height).data];
    const before = pixels();
    queueMicrotask(() => globalThis.drawn.push([before, pixels()]));
  };
}

test("the guide's windows come with the times and masks of all frames", async (t) => {
  const { lines } = await runWithFile(t, 'Video', 'true');
  assert.ok(
    lines.some((line) => line.startsWith('shot 0, objects 1')),
    lines.join('\n'),
  );
  const frames = lines.filter((line) => line.endsWith(` ${160 * 90}`));
  assert.deepEqual(
    frames.map((line) => Number(line.split(' ')[0]).toFixed(1)),
    ['0.0', '0.1', '0.2', '0.3', '0.4', '0.5', '0.6', '0.7'],
  );
});

test("the guide's list of what comes out", async (t) => {
  const { outcome } = await runWithFile(t, 'What comes out', '[masks.numFrames, masks.objects.length]');
  assert.equal(outcome[0], 8);
  assert.ok(outcome[1] >= 1);
});

test('the effects of docs/tasks.md are three videos that differ', async (t) => {
  const [heading] = TASKS.browser;
  const { outcome } = await runWithFile(t, heading, '[blur, spotlight, replace].map(({ type, size }) => [type, size])');
  assert.deepEqual(new Set(outcome.map(([type]) => type)), new Set(['video/mp4']));
  assert.equal(new Set(outcome.map(([, size]) => size)).size, 3);
  assert.ok(outcome.every(([, size]) => size > 1000));
});
