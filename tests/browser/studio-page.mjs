// Actions on a page of the studio that several specs need.

import { join } from 'node:path';
import { root } from '../../scripts/tools.mjs';
import { plainFrame } from '../moving.mjs';
import { pngBytes } from '../png.mjs';
import { downloadBytes, expect } from './fixtures.mjs';

/** Opens the tools that fix a result, which are loaded when they are first opened. */
export async function openFix(page) {
  await page.click('#correct-open');
  await page.waitForSelector('body[data-correcting]');
}

export async function selectTool(page, tool) {
  await page.check(`#correct-tools [value="${tool}"]`, { force: true });
}

/** Opens edges and layers, over the picture. */
export async function openLook(page) {
  await page.evaluate(() => (document.querySelector('#look').open = true));
}

/** Opens the dialog of settings, with all that it has. */
export async function openRedo(page) {
  await page.click('#redo-open');
  await page.evaluate(() => (document.querySelector('#clip-more').open = true));
}

/** Opens the dialog that saves, with all that it has. */
export async function openSave(page) {
  await page.click('#export-open');
  await page.waitForSelector('#export[open]');
  await page.evaluate(() => (document.querySelector('#export-more').open = true));
}

/** Sets a control of a dialog that may be closed. */
export async function setControl(page, selector, value) {
  await page.locator(selector).evaluate((control, text) => {
    control.value = text;
    control.dispatchEvent(new Event('input', { bubbles: true }));
  }, value);
}

/** Shows these layers only; without any named, all of them. */
export async function showOnly(page, ...ids) {
  await page.evaluate((layerIds) => {
    for (const box of document.querySelectorAll('.layer:not([hidden]) [data-layer]'))
      if (box.checked !== (layerIds.length === 0 || layerIds.includes(box.dataset.layer))) box.click();
  }, ids);
}

/** Opens a project of five objects, without a run. @param {Parameters<typeof fiveObjects>[1]} shape of the clip */
export async function openFive(page, shape) {
  const { project } = await fiveObjects(page, shape);
  const before = await page.evaluateHandle(() => globalThis.tracecutStudio.source);
  await page.setInputFiles('#file', [project]);
  await page.waitForFunction(
    (last) => globalThis.tracecutStudio.source !== last && document.body.dataset.state === 'done',
    before,
  );
  await expect(page.locator('.object')).toHaveCount(6);
}

export async function seek(page, frame) {
  await page.evaluate((t) => globalThis.tracecutStudio.app.timeline.seek(t), frame);
}

export function frameOnScreen(page) {
  return page.evaluate(() => globalThis.tracecutStudio.app.timeline.frame);
}

/** Returns the masks of all frames as one text. */
export function masks(page) {
  return page.evaluate(() => {
    const { segmentation } = globalThis.tracecutStudio.app;
    return Array.from({ length: segmentation.result.numFrames }, (_, t) => segmentation.mask(t).join('')).join('|');
  });
}

/** Returns the label at a place of the clip, in frame `t`. */
export function labelAt(page, t, x, y) {
  return page.evaluate(
    ([frame, column, row]) => {
      const { segmentation } = globalThis.tracecutStudio.app;
      return segmentation.mask(frame)[row * segmentation.result.width + column];
    },
    [t, x, y],
  );
}

/** Returns where a pixel of the clip is in the window. */
export async function pointOf(page, x, y) {
  const box = await page.locator('#canvas').boundingBox();
  const unit = await page.evaluate(() => globalThis.tracecutStudio.app.viewer.view.unit);
  return [box.x + (x + 0.5) / unit, box.y + (y + 0.5) / unit];
}

/** Presses the mouse at the first place of the clip, moves it to the others, and releases it. */
export async function drag(page, [start, ...path]) {
  await page.mouse.move(...(await pointOf(page, ...start)));
  await page.mouse.down();
  for (const place of path) await page.mouse.move(...(await pointOf(page, ...place)), { steps: 4 });
  await page.mouse.up();
}

/** Does something that corrects the result, and returns the status text once it is done. */
export async function correct(page, act) {
  const status = page.locator('#correct-status');
  await status.evaluate((element) => (element.textContent = ''));
  await act();
  await expect(status).toHaveText(
    /^(Applied to .*\.|Corrected .*|Undone.*|Redone.*|Not possible.*|.* joined with .*)$/,
  );
  return status.innerText();
}

/** Paints along places of the clip. */
export function paint(page, ...path) {
  return correct(page, () => drag(page, path));
}

/**
 * Returns a file for `setInputFiles`: a PNG of one frame.
 *
 * @param {{data: Uint8ClampedArray, width: number, height: number}} frame RGBA
 */
export function pngFile(name, frame) {
  return { name, mimeType: 'image/png', buffer: pngBytes(frame, { channels: 4 }) };
}

/** Returns the canvas as it is drawn now, as a data URL. */
export function picture(page) {
  return page.evaluate(() => {
    globalThis.tracecutStudio.app.viewer.draw();
    return document.querySelector('#canvas').toDataURL();
  });
}

/**
 * Returns what axe-core finds wrong with the page as it is, one line each. The page's context needs `bypassCSP`.
 *
 * @param {object} [options] options of axe-core: `runOnly` and `rules`; `within` is the selector of a part to check alone
 */
export async function accessibilityFaults(page, options = {}) {
  if (!(await page.evaluate(() => 'axe' in globalThis)))
    await page.addScriptTag({ path: join(root, 'node_modules', 'axe-core', 'axe.min.js') });
  return page.evaluate(async ({ within, ...chosenRules }) => {
    const { violations, passes } = await globalThis.axe.run(within ?? document, {
      resultTypes: ['violations'],
      ...chosenRules,
    });
    if (!chosenRules.runOnly && !within && passes.length < 10)
      return [`only ${passes.length} rules had anything to check`];
    return violations.flatMap(({ id, nodes }) =>
      nodes.map(({ target, failureSummary }) => `${id}: ${target.join(' ')}: ${failureSummary}`),
    );
  }, options);
}

/** Options of `accessibilityFaults`: contrast alone, which takes longest, and all other rules. */
export const CONTRAST = { runOnly: ['color-contrast'] };
export const NO_CONTRAST = { rules: { 'color-contrast': { enabled: false } } };

/** Returns files for `setInputFiles` with these frames, in their order. */
export function pngFiles(frames, name = 'frame') {
  return frames.map((frame, t) => pngFile(`${name}${t}.png`, frame));
}

/** Returns the three images of a small clip in which nothing moves. */
export const stillFiles = (name) =>
  pngFiles(
    [0, 9, 18].map((red) => plainFrame(48, 32, (x, y) => [(x * 5 + red) % 256, y * 7, 0])),
    name,
  );

/** Drops files on a page. @param {{name: string, mimeType: string, buffer: Buffer}[]} files */
export function dropFiles(page, files) {
  const contents = files.map(({ name, mimeType, buffer }) => [name, mimeType, buffer.toString('base64')]);
  return page.evaluate((list) => {
    const dataTransfer = new DataTransfer();
    for (const [name, type, base64] of list) {
      const bytes = Uint8Array.from(atob(base64), (char) => char.charCodeAt(0));
      dataTransfer.items.add(new File([bytes], name, { type }));
    }
    for (const type of ['dragenter', 'dragover', 'drop'])
      document.body.dispatchEvent(new DragEvent(type, { dataTransfer, bubbles: true, cancelable: true }));
  }, contents);
}

/** Waits for a phase of the page (see studio/model/store.ts). */
export async function waitForPhase(page, phase) {
  await expect(page.locator('body')).toHaveAttribute('data-phase', phase);
}

/** Runs a finished clip again. */
export async function runAgain(page) {
  await page.click('#redo-open');
  await page.click('#redo-run');
}

/** Lets the images of a clip from number `count` on wait in the page until `releaseFrames` is called there. */
export async function holdFrames(page, count) {
  await page.evaluate((first) => {
    const decode = globalThis.createImageBitmap.bind(globalThis);
    const released = new Promise((resolve) => (globalThis.releaseFrames = resolve));
    globalThis.createImageBitmap = async (source, ...rest) => {
      if (source instanceof File && Number(/\d+/.exec(source.name)) >= first) await released;
      return decode(source, ...rest);
    };
  }, count);
}

export const releaseFrames = (page) => page.evaluate(() => globalThis.releaseFrames());

/** Saves one export of the open dialog and returns its name and bytes. The main exports are cards, which are chosen first. */
export async function saveExport(page, id) {
  const [download] = await Promise.all([
    page.waitForEvent('download'),
    page.click(`[data-export="${id}"]`).then(async () => {
      if (await page.locator(`.card [data-export="${id}"]`).count()) await page.click('#export-run');
    }),
  ]);
  await expect(page.locator('#export-status')).toHaveText(/^Saved/);
  return { name: download.suggestedFilename(), bytes: await downloadBytes(download) };
}

/** Gives bytes to the page, as the blob `globalThis[name]`: as text, as arrays of numbers take seconds. */
export async function giveBytes(page, name, bytes) {
  const url = `data:application/octet-stream;base64,${bytes.toString('base64')}`;
  await page.evaluate(async ([key, data]) => (globalThis[key] = await (await fetch(data)).blob()) && null, [name, url]);
}

/** Waits for the preview of an export in the dialog. */
export async function waitForPreview(page, id) {
  const preview = page.locator('#export-preview');
  await expect(preview).toHaveAttribute('data-shows', id);
  await expect(preview).not.toHaveAttribute('data-waits');
  await expect(preview.locator(':scope > *')).toHaveCount(1);
}

/** Runs in the page: creates a video of five objects and its project, of this size, and returns both as base64. */
async function createFive({ width, height, frames, parts = 0, doubts = [], scale = 1, hasSound = false }) {
  const { base64Of, encodeClip, wav } = await import('/tests/browser/page-helpers.mjs');
  const { saveProject } = await import('/dist/edit.js');
  const side = Math.round(Math.min(width, height) / 7);
  // Parts of one thing are side by side; all other objects stand apart and move the other way.
  const placeOf = (k, t) => (k < parts ? [20 + k * side + 3 * t, 4 + t] : placeApart(k, parts > 0 ? -2 * t : t));
  const placeApart = (k, t) => [
    Math.round(((k + 0.5) * (width - side)) / 5.5 + t),
    Math.round((k * (height - side)) / 5 + t),
  ];
  const draw = (context, t) => {
    context.setTransform(scale, 0, 0, scale, 0, 0);
    for (let y = 0; y < height; y += 8)
      for (let x = 0; x < width; x += 8) {
        context.fillStyle = `hsl(${((x * 7 + y * 3) % 80) + 60} 30% ${40 + ((x * 13 + y * 29) % 30)}%)`;
        context.fillRect(x, y, 8, 8);
      }
    for (let k = 0; k < 5; k += 1) {
      context.fillStyle = `hsl(${70 * k} 80% 50%)`;
      context.fillRect(...placeOf(k, t), side, side);
    }
  };
  const times = Array.from({ length: frames }, (_, t) => t / 10);
  let video = await encodeClip({ times, draw, width: scale * width, height: scale * height, keyEvery: 5 });
  if (hasSound) {
    const { encodeVideo, videoFrames } = await import('/dist/index.js');
    const sound = wav(Int16Array.from({ length: 8000 }, (_, k) => 9000 * Math.sin(k / 5)));
    const masks = { width: 16, height: 9, numFrames: frames, labels: () => new Uint8Array(144), times };
    const options = { quality: 'very-high', sound: { source: sound, end: frames / 10 } };
    video = await encodeVideo(masks, videoFrames(video), options);
  }
  const labels = (t) => {
    const mask = new Uint8Array(width * height);
    for (let k = 0; k < 5; k += 1) {
      const [left, top] = placeOf(k, t);
      for (let y = top; y < top + side; y += 1) mask.fill(k + 1, y * width + left, y * width + left + side);
    }
    return mask;
  };
  // Lines of points over the ground, which stands still, and over each object.
  const lines = [];
  for (let y = 4; y < height; y += 16)
    for (let x = 4; x < width; x += 16) {
      const label = labels(0)[y * width + x];
      const [left, top] = placeOf(label - 1, 0);
      const at = (t) => (label === 0 ? [x, y] : placeOf(label - 1, t).map((v, axis) => v + [x - left, y - top][axis]));
      lines.push({ label, points: Array.from({ length: frames }, (_, t) => at(t)) });
    }
  const trajectories = {
    count: lines.length,
    startFrame: new Uint32Array(lines.length),
    offset: Uint32Array.from({ length: lines.length + 1 }, (_, k) => k * frames),
    x: Float32Array.from(lines.flatMap(({ points }) => points.map(([x]) => x))),
    y: Float32Array.from(lines.flatMap(({ points }) => points.map(([, y]) => y))),
    label: Uint8Array.from(lines, ({ label }) => label),
  };
  const source = {
    width,
    height,
    numFrames: frames,
    shots: [{ first: 0, last: frames - 1 }],
    times: Float64Array.from(times),
    end: frames / 10,
    labels,
    ...(parts > 0 ? { trajectories } : {}),
    doubts,
  };
  const trim = { start: 0, frames, step: 1, side: Math.max(width, height) };
  const about = { name: 'five.webm', trim, changed: [], types: { 'five.webm': 'video/webm' } };
  const files = { 'five.webm': new Uint8Array(await video.arrayBuffer()) };
  const project = await saveProject(source, { about, files });
  return Promise.all([video, new Blob([project])].map(base64Of));
}

/** Files of five objects by their options. */
const cache = new Map();

/**
 * @param {import('@playwright/test').Page} page
 * @param {{width: number, height: number, frames: number, parts?: number, doubts?: object[], scale?: number, hasSound?: boolean}} options
 *   size of the masks; `parts` of the objects touch and move alike; the video is larger by `scale`
 * @returns {Promise<{video: object, project: object}>} files for `setInputFiles`
 */
export async function fiveObjects(page, options) {
  const key = JSON.stringify(options);
  if (!cache.has(key)) cache.set(key, await page.evaluate(createFive, options));
  const [video, project] = cache.get(key);
  return {
    video: { name: 'five.webm', mimeType: 'video/webm', buffer: Buffer.from(video, 'base64') },
    project: { name: 'five.tracecut', mimeType: 'application/zip', buffer: Buffer.from(project, 'base64') },
  };
}
