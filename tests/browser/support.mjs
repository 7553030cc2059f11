// What the browser tests share: the project's server, one browser, pages that are watched, files made on the spot.

import { mkdirSync } from 'node:fs';
import { join } from 'node:path';
import { before } from 'node:test';
import { root } from '../../scripts/tools.mjs';
import { movingFrames } from '../moving.mjs';
import { pngBytes } from '../png.mjs';
import { useServerAndBrowser } from '../site.mjs';

export { plainFrame } from '../moving.mjs';
export { SMALL, bytesOf } from '../site.mjs';

/** A run of the sample takes seconds; on a busy machine far more. */
const PATIENCE_MS = 180_000;

/** Option of tests that are too slow for every time: `npm run test:long` runs the files that have them. */
export const onlyLong = { skip: process.env.TRACECUT_LONG ? false : 'npm run test:long runs it' };

/** Folder of clips that are not part of the project; tests that need them are passed over without it. */
export const sharedClips = join(process.env.TRACECUT_SHARED ?? join(root, '..', 'shared'), 'data', 'clips');

/**
 * Server and browser for the tests of one file.
 *
 * @param {{sample?: 'whole' | 'small' | 'tiny', isOwn?: boolean}} [options] as of `useServerAndBrowser`
 * @returns {{open: (options?: object) => Promise<{page: import('playwright-core').Page, faults: string[]}>, folder: () => string}}
 *   `open` gives a fresh page at the site; `faults` collects errors on its console, failed requests, and requests to anywhere
 *   else
 */
export function useSite({ sample = 'small', isOwn = false } = {}) {
  const site = useServerAndBrowser({ sample, isOwn });
  const open = async ({ query = '', ...options } = {}) => {
    await site.ready();
    const context = await site.browser.newContext({
      viewport: { width: 1280, height: 800 },
      reducedMotion: 'reduce',
      serviceWorkers: 'block',
      ...options,
    });
    // Nobody answers a dialog of the browser's here: files come as downloads.
    await context.addInitScript(() => (globalThis.showSaveFilePicker = undefined));
    const page = await context.newPage();
    page.setDefaultTimeout(PATIENCE_MS);
    const faults = watch(page, site.url);
    await page.goto(site.url + query);
    return { page, faults };
  };
  return { open, folder: () => site.folder };
}

function watch(page, url) {
  const faults = [];
  page.on('console', (message) => {
    const expected = message.text().includes('Service Worker registration blocked by Playwright');
    if (['error', 'warning'].includes(message.type()) && !expected) faults.push(`${message.type()}: ${message.text()}`);
  });
  page.on('pageerror', (error) => faults.push(`page error: ${error.message}`));
  page.on('request', (request) => {
    if (!request.url().startsWith(url) && !/^(blob|data):/.test(request.url()))
      faults.push(`request to ${request.url()}`);
  });
  page.on('requestfailed', (request) => {
    // A player that is told to let go of its file stops reading it.
    if (!request.url().startsWith('blob:')) faults.push(`failed: ${request.url()}`);
  });
  return faults;
}

/** Waits until a run has ended and gives the state it ended in. */
export async function ended(page) {
  await page.waitForFunction(() => ['done', 'error'].includes(document.body.dataset.state));
  return page.evaluate(() => document.body.dataset.state);
}

/** Opens what corrects a result, which is fetched when it is first opened. */
export async function openFix(page) {
  await page.click('#correct-open');
  await page.waitForSelector('body[data-correcting]');
}

/** Opens the edges and layers, over the picture. */
export async function openLook(page) {
  await page.evaluate(() => (document.querySelector('#look').open = true));
}

/** Opens the sheet of settings, with all that it has. */
export async function openRedo(page) {
  await page.click('#redo-open');
  await page.evaluate(() => (document.querySelector('#clip-more').open = true));
}

/** Sets a control of a sheet that may be closed. */
export async function setControl(page, selector, value) {
  await page.locator(selector).evaluate((control, wanted) => {
    control.value = wanted;
    control.dispatchEvent(new Event('input', { bubbles: true }));
  }, value);
}

/** Runs a finished clip again. */
export async function redo(page) {
  await page.click('#redo-open');
  await page.click('#redo-run');
}

/** Opens the dialog that saves, with all that it has. */
export async function openSave(page) {
  await page.click('#export-open');
  await page.waitForSelector('#export[open]');
  await page.evaluate(() => (document.querySelector('#export-more').open = true));
}

/** Waits for one phase of the page (see studio/model/store.ts). */
export async function inPhase(page, phase) {
  await page.waitForFunction((wanted) => document.body.dataset.phase === wanted, phase);
}

/** Saves one thing in the dialog: one of the cards is chosen, and then exported. */
export async function exportAs(page, id) {
  await page.click(`[data-export="${id}"]`);
  if (await page.locator(`.card [data-export="${id}"]`).count()) await page.click('#export-run');
}

/** Opens the site and waits for the sample. */
export async function openSample(site, options) {
  const opened = await site.open(options);
  const state = await ended(opened.page);
  if (state !== 'done') throw new Error(`the sample ended in ${state}: ${await text(opened.page, '#error')}`);
  return opened;
}

/**
 * One page with the finished sample for all tests of a suite that may share it; read `page` and `faults` in the tests.
 */
export function useSample(site, options) {
  const shared = { page: null, faults: null };
  before(async () => Object.assign(shared, await openSample(site, options)));
  return shared;
}

/** Hands files to the page, which starts by itself; gives the state that the run ended in. */
export async function run(page, files) {
  await page.setInputFiles('#file', files);
  return ended(page);
}

/** The visible words of an element. */
export async function text(page, selector) {
  return (await page.locator(selector).innerText()).trim();
}

/** The names of the layers that the panel offers, in its order. */
export function layerNames(page) {
  return page.locator('.layer:not([hidden]) [data-layer]').evaluateAll((all) => all.map((box) => box.dataset.layer));
}

/** The picture on the canvas, drawn as things stand, as a data URL. */
export async function picture(page) {
  return page.evaluate(() => {
    globalThis.tracecutStudio.app.viewer.draw();
    return document.querySelector('#canvas').toDataURL();
  });
}

/** Switches all layers off but these; without any named, all of them on. */
export async function showOnly(page, ...ids) {
  await page.evaluate((wanted) => {
    for (const box of document.querySelectorAll('.layer:not([hidden]) [data-layer]'))
      if (box.checked !== (wanted.length === 0 || wanted.includes(box.dataset.layer))) box.click();
  }, ids);
}

/** Runs in the page: the share of the canvas that is painted at all. */
export function paintedShare() {
  const { viewer } = globalThis.tracecutStudio.app;
  viewer.draw();
  const { canvas } = viewer;
  const { data } = canvas.getContext('2d').getImageData(0, 0, canvas.width, canvas.height);
  let painted = 0;
  for (let at = 3; at < data.length; at += 4) if (data[at] > 0) painted += 1;
  return painted / (data.length / 4);
}

/**
 * What axe-core finds wrong with the page as it is, one line each. The page's context needs `bypassCSP`.
 *
 * @param {import('playwright-core').Page} page
 * @param {object} [options] those of axe-core: `runOnly` and `rules`
 */
export async function accessibilityFaults(page, options = {}) {
  if (!(await page.evaluate(() => 'axe' in globalThis))) {
    await page.addScriptTag({ path: join(root, 'node_modules', 'axe-core', 'axe.min.js') });
  }
  return page.evaluate(async (chosen) => {
    const { violations, passes } = await globalThis.axe.run(document, { resultTypes: ['violations'], ...chosen });
    if (!chosen.runOnly && passes.length < 10) return [`only ${passes.length} rules had anything to check`];
    return violations.flatMap(({ id, nodes }) =>
      nodes.map(({ target, failureSummary }) => `${id}: ${target.join(' ')}: ${failureSummary}`),
    );
  }, options);
}

/** Options of `accessibilityFaults`: contrast alone, which takes longest, and all but that. */
export const CONTRAST = { runOnly: ['color-contrast'] };
export const NO_CONTRAST = { rules: { 'color-contrast': { enabled: false } } };

/**
 * With `TRACECUT_SCREENS=1`, writes a picture of the page, or of what is in view of it, to out/screens/, for people to look at.
 */
export async function screenshot(page, name, { whole = true } = {}) {
  if (!process.env.TRACECUT_SCREENS) return;
  const folder = join(root, 'out', 'screens');
  mkdirSync(folder, { recursive: true });
  await page.screenshot({ path: join(folder, `${name}.png`), fullPage: whole });
}

/**
 * A file for `setInputFiles`: a PNG of one frame.
 *
 * @param {string} name
 * @param {{data: Uint8ClampedArray, width: number, height: number}} frame RGBA
 */
export function pngFile(name, frame) {
  return { name, mimeType: 'image/png', buffer: pngBytes(frame, { channels: 4 }) };
}

/**
 * A file for `setInputFiles`: an animated GIF of grey frames (the red channel of each, halved).
 *
 * @param {string} name
 * @param {{data: Uint8ClampedArray, width: number, height: number}[]} frames
 * @param {number[]} [delays] how long each is shown, in hundredths of a second; 7 if not given
 */
export function gifFile(name, frames, delays = []) {
  const { width, height } = frames[0];
  const size = [width & 255, width >> 8, height & 255, height >> 8];
  const greys = Array.from({ length: 128 }, (_, k) => [2 * k, 2 * k, 2 * k]).flat();
  const loop = [0x21, 0xff, 11, ...Buffer.from('NETSCAPE2.0'), 3, 1, 0, 0, 0];
  const parts = [Buffer.from('GIF89a'), Buffer.from([...size, 0xf6, 0, 0, ...greys, ...loop])];
  for (const [k, { data }] of frames.entries()) {
    const delay = delays[k] ?? 7;
    parts.push(
      Buffer.from([0x21, 0xf9, 4, 0, delay & 255, delay >> 8, 0, 0, 0x2c, 0, 0, 0, 0, ...size, 0, 7]),
      gifCodes(data),
      Buffer.from([0]),
    );
  }
  return { name, mimeType: 'image/gif', buffer: Buffer.concat([...parts, Buffer.from([0x3b])]) };
}

/** Pixels as codes of 8 bits: the table is cleared so often that codes never grow, so nothing is compressed. */
function gifCodes(data) {
  const codes = [];
  for (let k = 0; 4 * k < data.length; k += 1) {
    if (k % 100 === 0) codes.push(128);
    codes.push(data[4 * k] >> 1);
  }
  codes.push(129);
  const blocks = [];
  for (let k = 0; k < codes.length; k += 255) {
    const block = codes.slice(k, k + 255);
    blocks.push(block.length, ...block);
  }
  return Buffer.from(blocks);
}

/** The files of a clip that moves. */
export function movingClip(count, size) {
  return movingFrames(count, size).map((frame, t) => pngFile(`frame${String(t).padStart(3, '0')}.png`, frame));
}
