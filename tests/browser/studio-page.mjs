// Actions on a page of the studio that several specs need.

import { join } from 'node:path';
import { root } from '../../scripts/tools.mjs';
import { pngBytes } from '../png.mjs';
import { downloadBytes, expect } from './fixtures.mjs';
import { fiveObjects } from './five-objects.mjs';

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
  await page.locator(selector).evaluate((control, wanted) => {
    control.value = wanted;
    control.dispatchEvent(new Event('input', { bubbles: true }));
  }, value);
}

/** Shows these layers only; without any named, all of them. */
export async function showOnly(page, ...ids) {
  await page.evaluate((wanted) => {
    for (const box of document.querySelectorAll('.layer:not([hidden]) [data-layer]'))
      if (box.checked !== (wanted.length === 0 || wanted.includes(box.dataset.layer))) box.click();
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

/** Presses the mouse at the first place of the clip and moves it to the others; `release` ends it. */
export async function drag(page, [start, ...path]) {
  await page.mouse.move(...(await pointOf(page, ...start)));
  await page.mouse.down();
  for (const place of path) await page.mouse.move(...(await pointOf(page, ...place)), { steps: 4 });
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
  return correct(page, async () => {
    await drag(page, path);
    await page.mouse.up();
  });
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
 * @param {object} [options] options of axe-core: `runOnly` and `rules`
 */
export async function accessibilityFaults(page, options = {}) {
  if (!(await page.evaluate(() => 'axe' in globalThis)))
    await page.addScriptTag({ path: join(root, 'node_modules', 'axe-core', 'axe.min.js') });
  return page.evaluate(async (chosen) => {
    const { violations, passes } = await globalThis.axe.run(document, { resultTypes: ['violations'], ...chosen });
    if (!chosen.runOnly && passes.length < 10) return [`only ${passes.length} rules had anything to check`];
    return violations.flatMap(({ id, nodes }) =>
      nodes.map(({ target, failureSummary }) => `${id}: ${target.join(' ')}: ${failureSummary}`),
    );
  }, options);
}

/** Options of `accessibilityFaults`: contrast alone, which takes longest, and all other rules. */
export const CONTRAST = { runOnly: ['color-contrast'] };
export const NO_CONTRAST = { rules: { 'color-contrast': { enabled: false } } };

/** Returns files for `setInputFiles` with these frames, in their order. */
export function pngFiles(frames) {
  return frames.map((frame, t) => pngFile(`frame${t}.png`, frame));
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
