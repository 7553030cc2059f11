// The README's and the guide's blocks of code for browsers, run as they stand on a page that has installed the package.

import assert from 'node:assert/strict';
import { writeFileSync } from 'node:fs';
import { join } from 'node:path';
import { after, before, test } from 'node:test';
import { emptyPage } from '../browser/empty-page.mjs';
import { TASKS, codeOf, readmeCode } from '../readme.mjs';
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

test("the README's lines for the browser show a video with its objects coloured", async (t) => {
  const { page } = await open(t, code.get('In the browser'));
  await page.waitForFunction(() => document.querySelector('input').onchange);
  await page.evaluate(() => {
    // The last thing that a drawn frame needs is its masks.
    globalThis.drawn = 0;
    const { drawImage } = CanvasRenderingContext2D.prototype;
    CanvasRenderingContext2D.prototype.drawImage = function (...args) {
      if (this.canvas === document.querySelector('canvas')) globalThis.drawn += 1;
      return drawImage.apply(this, args);
    };
  });
  await page.locator('input').setInputFiles(await madeClip());
  await page.waitForFunction(() => globalThis.drawn >= 8);
  assert.deepEqual(
    await page.evaluate(() => [document.querySelector('canvas').width, document.querySelector('canvas').height]),
    [160, 90],
  );
});

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
