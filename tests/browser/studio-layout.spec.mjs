// The studio in windows and devices: the picture has the room and stays where it is, everything fits, forced colours show every
// control, the first screen; and what an accessibility checker finds in each state.

import { readFileSync } from 'node:fs';
import { join } from 'node:path';
import { plainFrame } from '../moving.mjs';
import { root } from '../../scripts/tools.mjs';
import { expect, openSample, runEnd, test, useSample } from './fixtures.mjs';
import {
  CONTRAST,
  NO_CONTRAST,
  accessibilityFaults,
  fiveObjects,
  holdFrames,
  openFive,
  openFix,
  openLook,
  openRedo,
  openSave,
  paint,
  pngFiles,
  releaseFrames,
  selectTool,
  showOnly,
  waitForPhase,
} from './studio-page.mjs';

const WIDE = { width: 160, height: 90, frames: 4 };
const UPRIGHT = { width: 90, height: 160, frames: 4 };

const PHONE = { viewport: { width: 390, height: 844 }, isMobile: true, hasTouch: true };

/** Runs in the page: the place of an element in the window, and the share of its height that is in view. */
const placeOf = (page, selector) =>
  page.locator(selector).evaluate((element) => {
    const { top, bottom, left, right, height, width } = element.getBoundingClientRect();
    const visibleHeight = Math.max(0, Math.min(innerHeight, bottom) - Math.max(0, top));
    return { top, bottom, left, right, height, width, share: visibleHeight / height };
  });

const excessWidth = (page) => page.evaluate(() => document.documentElement.scrollWidth - innerWidth);

/** Pages that the tests share: on a desk and on a phone. */
const desk = useSample({ sample: 'tiny', bypassCSP: true });
const phone = useSample({ sample: 'tiny', bypassCSP: true, ...PHONE });

test.describe('the picture', () => {
  /**
   * Least shares that the picture has: of the window, of its height, of its width; and that its box has of the window. With
   * `isBrief` only a result is measured, not every state.
   */
  const DESK = [
    { width: 1440, height: 900, shape: WIDE, area: 0.65 },
    { width: 1366, height: 768, shape: UPRIGHT, down: 0.8 },
    { width: 2560, height: 1440, shape: WIDE, area: 0.65, isBrief: true },
  ];
  const HANDHELD = [
    // A wide picture cannot have 45% of an upright phone: its box has.
    { width: 390, height: 844, shape: WIDE, across: 0.999, box: 0.45 },
    { width: 390, height: 844, shape: UPRIGHT, down: 0.5, box: 0.45, isBrief: true },
    { width: 844, height: 390, shape: WIDE, down: 0.65, isBrief: true },
    { width: 844, height: 390, shape: UPRIGHT, down: 0.65 },
  ];

  for (const [device, shared, windows] of [
    ['a desk', desk, DESK],
    ['a phone', phone, HANDHELD],
  ])
    test(`is the largest thing in every state and stays where it is, on ${device}`, async () => {
      const { page } = shared;
      for (const { width, height, shape, area = 0, down = 0, across = 0, box = 0, isBrief } of windows) {
        await page.setViewportSize({ width, height });
        const places = new Set();
        const measure = async (state) => {
          await page.evaluate(() => scrollTo(0, 0));
          const [canvas, screen] = [await placeOf(page, '#canvas'), await placeOf(page, '#screen')];
          const name = `${width}x${height}, ${state}`;
          const [shareAcross, shareDown] = [canvas.width / width, canvas.height / height];
          expect(shareAcross * shareDown, name).toBeGreaterThanOrEqual(area);
          expect(shareDown, name).toBeGreaterThanOrEqual(down);
          expect(shareAcross, name).toBeGreaterThanOrEqual(across);
          expect((screen.width * screen.height) / (width * height), name).toBeGreaterThanOrEqual(box);
          expect(canvas.share, name).toBe(1);
          places.add([canvas.width, canvas.height, canvas.left, canvas.top].map(Math.round).join());
        };
        if (!isBrief) {
          // Images from the second on do not come, so that the run does not end.
          await holdFrames(page, 1);
          const frame = plainFrame(shape.width, shape.height);
          await page.setInputFiles('#file', pngFiles(Array(shape.frames).fill(frame)));
          await waitForPhase(page, 'running');
          await page.waitForFunction((aspect) => {
            const { clientWidth, clientHeight } = document.querySelector('#canvas');
            return Math.abs(clientWidth / clientHeight - aspect) < 0.05;
          }, shape.width / shape.height);
          await measure('running');
          await releaseFrames(page);
        }
        await openFive(page, shape);
        await measure('done');
        expect(await excessWidth(page)).toBeLessThanOrEqual(0);
        if (isBrief) continue;
        await openFix(page);
        for (const tool of ['paint', 'add', 'apart', 'pick']) {
          await selectTool(page, tool);
          await measure(tool);
        }
        await page.click('#correct-done');
        await page.check('[name="view"][value="cutout"]', { force: true });
        await measure('cut-out');
        await page.check('[name="view"][value="overlay"]', { force: true });
        await page.click('#export-open');
        await page.waitForSelector('#export-preview > *');
        await measure('save');
        await expectDialogFits(page, { height, hasTouch: shared === phone });
        await page.click('#export-close');
        expect([...places]).toHaveLength(1);
      }
    });

  /** Chooses the green backdrop, and expects the preview and its choices in view, side by side or one above the other. */
  async function expectDialogFits(page, { height, hasTouch }) {
    const card = page.locator('[data-export="green"]');
    await (hasTouch ? card.tap() : card.check());
    await page.waitForFunction(() => {
      const { dataset, firstElementChild } = document.querySelector('#export-preview');
      const { naturalWidth, videoWidth } = firstElementChild ?? {};
      return dataset.shows === 'green' && dataset.waits === undefined && (naturalWidth || videoWidth);
    });
    const preview = await placeOf(page, '#export-preview');
    for (const id of ['transparent', 'green', 'blurred', 'zip']) {
      const choice = await placeOf(page, `[data-export="${id}"]`);
      expect([choice.share, preview.share], id).toEqual([1, 1]);
      expect(preview.bottom <= choice.top || preview.right <= choice.left, id).toBe(true);
    }
    expect(preview.height > 0.25 * height || preview.width > 300).toBe(true);
    expect(await page.locator('#export').evaluate((dialog) => dialog.scrollWidth - dialog.clientWidth)).toBe(0);
  }

  test('does not move while a stroke is painted and carried to other frames', async () => {
    const { page } = desk;
    await page.setViewportSize({ width: 1366, height: 768 });
    await openFive(page, WIDE);
    await openFix(page);
    await selectTool(page, 'paint');
    await page.evaluate(() => {
      globalThis.shifts = [];
      new PerformanceObserver((list) => {
        for (const { value, sources } of list.getEntries())
          globalThis.shifts.push({ value, nodes: sources.map(({ node }) => node?.id || node?.nodeName).join() });
      }).observe({ type: 'layout-shift' });
    });
    const before = await placeOf(page, '#canvas');
    await paint(page, [30, 70], [60, 80]);
    await expect(page.locator('#fix-range')).toBeVisible();
    expect(await placeOf(page, '#canvas')).toEqual(before);
    // Shifts are reported with the frame that shows them. The timeline may move by less than a pixel.
    const shifts = await page.evaluate(
      () =>
        new Promise((resolve) => requestAnimationFrame(() => requestAnimationFrame(() => resolve(globalThis.shifts)))),
    );
    expect(shifts.filter(({ value }) => value > 0.001)).toEqual([]);
  });

  test('of an upright clip is in the filmstrip', async () => {
    const { page } = desk;
    await openFive(page, UPRIGHT);
    await expect(page.locator('#trim-strip')).toHaveAttribute('data-ready', 'five.webm');
    const greens = await page.locator('#trim-strip canvas').evaluateAll((canvases) =>
      canvases.map((canvas) => {
        const { data } = canvas.getContext('2d').getImageData(0, 0, canvas.width, canvas.height);
        return data.reduce((sum, value, k) => sum + (k % 4 === 1 ? value : 0), 0) / (data.length / 4);
      }),
    );
    expect(greens.length).toBeGreaterThan(3);
    expect(Math.min(...greens)).toBeGreaterThan(50);
  });
});

test.describe('a phone', () => {
  test('keeps the picture in view while fixing, fits narrow windows and explains touch', async () => {
    const { page } = phone;
    await page.setViewportSize(PHONE.viewport);
    await openFive(page, WIDE);
    await openFix(page);
    for (const selector of ['#correct-split', '#correct-done', '#correct-merge', '#play']) {
      await page.locator(selector).scrollIntoViewIfNeeded();
      for (const visible of ['#screen', selector])
        expect((await placeOf(page, visible)).share, `${visible} at ${selector}`).toBeGreaterThan(0.95);
    }
    const { x, y, width, height } = await page.locator('#canvas').boundingBox();
    await page.touchscreen.tap(x + (73.5 / WIDE.width) * width, y + (37.5 / WIDE.height) * height);
    await expect(page.locator('#correct-object')).toHaveValue('3');
    await page.click('#correct-done');

    await page.click('#help-open');
    await page.waitForSelector('#help[open]');
    await expect(page.locator('#help-touch')).toHaveText(/Tap an object.*Two fingers/);
    expect(await page.locator('#help').innerText()).not.toMatch(/Click/);
    await page.click('#help-close');

    await page.setViewportSize({ width: 360, height: 740 });
    expect(await excessWidth(page)).toBeLessThanOrEqual(0);
    await page.emulateMedia({ colorScheme: 'dark' });
    const brightness = await page.evaluate(() => {
      const { backgroundColor } = getComputedStyle(document.documentElement);
      return [backgroundColor, getComputedStyle(document.body).color].map((c) => Number(c.match(/\d+/)[0]));
    });
    expect(brightness[0]).toBeLessThan(60);
    expect(brightness[1]).toBeGreaterThan(190);
    const name = `${'long-name'.repeat(12)}.mp4`;
    await page.setInputFiles('#file', [{ name, mimeType: 'video/mp4', buffer: Buffer.from('x') }]);
    await expect(page.locator('#notice')).toHaveText(/^Couldn’t open/);
    expect(await excessWidth(page)).toBeLessThanOrEqual(0);
    await page.emulateMedia({ colorScheme: 'light' });
  });

  test('shares what was saved, where the browser shares such files', async () => {
    const { page } = phone;
    await openFive(page, WIDE);
    await page.evaluate(() => {
      globalThis.shared = [];
      navigator.canShare = ({ files }) => files[0].type !== 'application/json';
      navigator.share = async ({ files, title }) => void globalThis.shared.push([title, files[0].size]);
    });
    await openSave(page);
    const [share, status] = ['#export-share', '#export-status'].map((id) => page.locator(id));
    await expect(share).toBeHidden();
    await page.click('[data-export="coco"]');
    await expect(status).toHaveText(/^Saved/);
    await expect(share).toBeHidden();
    await page.click('[data-export="png"]');
    await expect(share).toBeVisible();
    await share.click();
    await expect.poll(() => page.evaluate(() => globalThis.shared.length)).toBe(1);
    const [[title, size]] = await page.evaluate(() => globalThis.shared);
    expect(title).toMatch(/-mask-0001\.png$/);
    expect(size).toBeGreaterThan(100);
    await page.evaluate(() => (navigator.share = () => Promise.reject(new DOMException('no', 'NotAllowedError'))));
    await share.click();
    await expect(status).toHaveText(/Couldn’t share/);
    await page.click('#export-close');
  });

  test('on its side has the controls beside the picture, which stays in view', async () => {
    const { page } = phone;
    await page.setViewportSize({ width: 844, height: 390 });
    await openFive(page, WIDE);
    const screen = await placeOf(page, '#screen');
    expect(screen.width).toBeGreaterThan(0.5 * 844);
    expect(screen.height).toBeGreaterThan(0.6 * 390);
    for (const selector of ['.toolbar', '.block-objects', '#correct-open'])
      expect((await placeOf(page, selector)).left, selector).toBeGreaterThanOrEqual(screen.right);
    await openFix(page);
    const width = await page.evaluate(() => document.querySelector('#correct-tools').scrollWidth);
    expect(width).toBeLessThanOrEqual(await page.evaluate(() => document.querySelector('#correct').clientWidth));
    for (const selector of ['.object >> nth=-1', '#correct-done', '#correct-split']) {
      await page.locator(selector).scrollIntoViewIfNeeded();
      for (const visible of ['#screen', '#play'])
        expect((await placeOf(page, visible)).share, `${visible} at ${selector}`).toBeGreaterThan(0.9);
    }
    expect(await accessibilityFaults(page, NO_CONTRAST)).toEqual([]);
  });
});

test('shows every control in forced colours', async ({ openStudio }) => {
  const page = await openSample(openStudio, { sample: 'tiny', forcedColors: 'active' });
  await openFive(page, WIDE);
  await openLook(page);
  // A control of one colour cannot be seen.
  for (const selector of [
    ...['#scrub', '#edge-grow', '[data-layer="masks"]', '#correct-open'],
    ...['#loop', '.segmented', '.keep', '.swatch'],
  ]) {
    const control = page.locator(selector).first();
    await control.scrollIntoViewIfNeeded();
    const colours = await page.evaluate(countColours, [...(await control.screenshot())]);
    expect(colours, selector).toBeGreaterThanOrEqual(2);
  }
  const style = (locator) =>
    locator.evaluate((element) => {
      const { color, backgroundColor, forcedColorAdjust } = getComputedStyle(element);
      return [color, backgroundColor, forcedColorAdjust].join();
    });
  const [primary, secondary] = [await style(page.locator('#export-open')), await style(page.locator('#again'))];
  expect(primary).not.toBe(secondary);
  await openRedo(page);
  await page.check('[name="cut.temporalWeight"][value="3"]', { force: true });
  expect(await style(page.locator('#again'))).toBe(primary);
  expect(await style(page.locator('#export-open'))).toBe(secondary);
  await page.click('#redo-close');
  const views = page.locator('#views span');
  expect(await style(views.nth(0))).not.toBe(await style(views.nth(1)));
  await page.locator('[data-layer="image"]').evaluate((box) => box.click());
  expect(await style(page.locator('[data-layer="masks"]'))).not.toBe(await style(page.locator('[data-layer="image"]')));
});

/** Runs in the page: how many colours cover at least a two-hundredth of a PNG. */
async function countColours(bytes) {
  const image = await createImageBitmap(new Blob([new Uint8Array(bytes)]));
  const data = pixelsOf(image);
  const counts = new Map();
  for (let at = 0; at < data.length; at += 4) {
    const colour = (data[at] << 16) | (data[at + 1] << 8) | data[at + 2];
    counts.set(colour, (counts.get(colour) ?? 0) + 1);
  }
  return [...counts.values()].filter((count) => count > data.length / 800).length;
}

test.describe('the first screen', () => {
  /** Opens a page that never gets its wasm. */
  async function openIdle(openStudio, sites, options) {
    const page = await openStudio({ sample: 'tiny', query: 'favicon.svg', ...options });
    await page.route('**/*.wasm', () => {});
    await page.goto(await sites('tiny'));
    return page;
  }

  for (const reducedMotion of ['no-preference', 'reduce'])
    test(`says what the studio is for, with a picture, motion: ${reducedMotion}`, async ({ openStudio, sites }) => {
      const page = await openIdle(openStudio, sites, { reducedMotion });
      const picture = page.locator('#welcome picture img');
      for (const [width, height] of reducedMotion === 'reduce'
        ? [[1366, 768]]
        : [
            [1366, 768],
            [2560, 1440],
            [390, 844],
            [844, 390],
          ]) {
        await page.setViewportSize({ width, height });
        await expect.poll(() => picture.evaluate(({ naturalWidth }) => naturalWidth)).toBeGreaterThan(0);
        for (const selector of ['#welcome h1', '#welcome-open', '#welcome ul', '#welcome picture']) {
          const { left, right, bottom } = await placeOf(page, selector);
          const isInside = left >= 0 && right <= width && bottom <= height;
          expect(isInside, `${selector} in ${width}x${height}`).toBe(true);
        }
        expect((await placeOf(page, '#welcome picture')).width).toBeGreaterThan(0.5 * width);
        expect(await picture.evaluate((image) => image.naturalWidth / image.clientWidth)).toBeGreaterThan(0.9);
        await expect(page.locator('#welcome li')).toHaveCount(3);
        await expect(page.locator('button:visible')).toHaveCount(1);
      }
      const choosing = page.waitForEvent('filechooser');
      const source = await picture.evaluate(({ currentSrc }) => currentSrc);
      expect(source).toMatch(reducedMotion === 'reduce' ? /still\.avif$/ : /sample\.avif$/);
      await page.click('#welcome-open');
      await choosing;
    });

  test('moves nothing when it ends, with the result or a file of the user', async ({ openStudio }) => {
    const page = await openSample(openStudio, { sample: 'tiny', viewport: { width: 1440, height: 900 } });
    await expect(page.locator('#welcome')).toHaveCount(0);
    const shifts = await page.evaluate(
      () =>
        new Promise((resolve) => {
          const observer = new PerformanceObserver((list) => resolve(list.getEntries().map(({ value }) => value)));
          observer.observe({ type: 'layout-shift', buffered: true });
          requestAnimationFrame(() => requestAnimationFrame(() => resolve(observer.takeRecords().map((r) => r.value))));
        }),
    );
    expect(shifts.reduce((sum, value) => sum + value, 0)).toBeLessThanOrEqual(0.02);

    const { video } = await fiveObjects(page, WIDE);
    await page.reload();
    await page.waitForFunction(() => globalThis.tracecutStudio);
    await page.setInputFiles('#file', [video]);
    await expect(page.locator('#clip-name')).toHaveText('five.webm');
    await expect(page.locator('#welcome')).toHaveCount(0);
  });
});

test.describe('an accessibility checker', () => {
  /** Runs in the page: texts of controls and headings that do not fit; some end in dots on purpose. */
  function cutTexts() {
    const kinds = 'button, h1, h2, h3, label > span, summary, .object-name, .layer-name, legend, .value';
    // Heard, not seen, while a result is fixed on a phone.
    const isShrunk = (heading) => heading !== null && heading.offsetWidth <= 1;
    return [...document.querySelectorAll(kinds)]
      .filter((element) => element.checkVisibility() && !element.closest('.visually-hidden'))
      .filter((element) => !isShrunk(element.closest('.heading')))
      .filter((element) => getComputedStyle(element).textOverflow !== 'ellipsis')
      .filter(({ clientWidth, scrollWidth }) => clientWidth > 0 && scrollWidth > clientWidth + 1)
      .map((element) => element.textContent.trim());
  }

  for (const [device, shared, viewport] of [
    ['a desk', desk, { width: 1280, height: 800 }],
    ['a phone', phone, { width: 360, height: 740 }],
  ])
    test(`finds nothing in any state, and every text fits, on ${device}`, async ({ faults }) => {
      const isDesk = shared === desk;
      const { page } = shared;
      await page.setViewportSize(viewport);
      /** @param within the part that the state changes; without `hasColours` another state has all its colours */
      const check = async (state, { within, hasColours = true } = {}) => {
        const isWhole = isDesk && hasColours;
        if (isDesk || !hasColours)
          expect(await accessibilityFaults(page, { within, ...(isWhole ? {} : NO_CONTRAST) }), state).toEqual([]);
        if (isWhole) {
          await page.emulateMedia({ colorScheme: 'dark' });
          expect(await accessibilityFaults(page, { within, ...CONTRAST }), `${state}, dark`).toEqual([]);
          await page.emulateMedia({ colorScheme: 'light' });
        }
        expect(await page.evaluate(cutTexts), state).toEqual([]);
        expect(await excessWidth(page), state).toBeLessThanOrEqual(0);
      };
      await openFive(page, { ...WIDE, doubts: [{ from: 1, to: 3 }] });
      await check('result');
      await page.keyboard.press('n');
      await check('place to check', { within: '.stage' });
      for (const view of ['beside', 'slider', 'cutout', 'overlay']) {
        await page.check(`[name="view"][value="${view}"]`, { force: true });
        if (view === 'cutout') await check(view, { within: '.stage', hasColours: false });
      }
      await openFix(page);
      for (const object of [1, 2]) await page.click(`[data-object="${object}"] .object-main`, { modifiers: ['Shift'] });
      await check('fix, selected');
      await selectTool(page, 'paint');
      await page.uncheck('#brush-carry');
      await paint(page, [30, 70], [60, 80]);
      await check('fix, painted', { within: '.stage' });
      await selectTool(page, 'apart');
      await check('fix, strokes', { within: '.stage', hasColours: false });
      await page.click('#correct-done');
      await showOnly(page);
      await openLook(page);
      await check('edges and layers', { within: '#look' });
      await page.evaluate(() => (document.querySelector('#look').open = false));
      await openRedo(page);
      await check('redo', { within: '#redo' });
      await page.click('#redo-run');
      await page.waitForSelector('#confirm[open]');
      await check('question', { within: '#confirm', hasColours: false });
      await page.keyboard.press('Escape');
      await page.keyboard.press('Escape');
      await expect(page.locator('dialog[open]')).toHaveCount(0);
      await page.keyboard.press('?');
      await page.waitForSelector('#help[open]');
      await check('help', { within: '#help' });
      await page.click('#help-close');
      await openSave(page);
      await page.click('#recipe-box > summary');
      await check('save', { within: '#export' });
      await page.click('#export-close');
      await page.focus('#trim-from');
      await page.keyboard.press('ArrowRight');
      await page.waitForSelector('#trim-run', { state: 'visible' });
      await check('trim', { within: '#trim', hasColours: false });
      await page.waitForSelector('#projects-open', { state: 'visible' });
      await page.click('#projects-open');
      await page.waitForSelector('#projects[open]');
      await check('projects', { within: '#projects' });
      await page.click('#projects-close');
      await page.setInputFiles('#file', pngFiles([0, 1].map(() => plainFrame(96, 64))));
      await page.waitForSelector('#suggestions', { state: 'visible' });
      await check('nothing found');
      await page.click('#sample');
      expect(await runEnd(page)).toBe('done');
      await page.setInputFiles('#file', [{ name: 'notes.txt', mimeType: 'text/plain', buffer: Buffer.from('x') }]);
      expect(await runEnd(page)).toBe('error');
      await check('error');
      faults.expected.push(/./);
    });
});

test('the help has the first steps; the hashes of this browser match, and one that differs is told', async () => {
  const { hashes, version } = JSON.parse(readFileSync(join(root, 'cli', 'src', 'selftest', 'expected.json'), 'utf8'));
  const { page } = desk;
  await expect(page.locator('#guide')).toBeHidden();
  await page.focus('#help-open');
  await page.keyboard.press('Enter');
  await page.waitForSelector('#guide', { state: 'visible' });
  expect(await page.locator('#guide strong').allInnerTexts()).toEqual(['Objects', 'Fix', 'Save']);
  await page.click('#about-open');
  await expect(page.locator('#about')).toHaveText(
    new RegExp(`TraceCut ${version.replaceAll('.', '\\.')}, free software`),
  );
  await page.click('#about-check');
  await expect(page.locator('#about-status')).toHaveText('All 19 parts match.');
  const names = await page.locator('#about dt').allInnerTexts();
  const lines = await page.locator('#about dd').allInnerTexts();
  expect(Object.fromEntries(names.map((name, k) => [name, lines[k].split(' ')[0]]))).toEqual(hashes);
  expect(lines.every((line) => line.endsWith('· same'))).toBe(true);
  expect(await accessibilityFaults(page, NO_CONTRAST)).toEqual([]);
  // An engine that rounds differently.
  await page.evaluate(() => (Math.round = Math.floor));
  await page.click('#about-check');
  await expect(page.locator('#about-status')).toHaveText(/Please report/);
  await expect(page.locator('#about .hash-differs').first()).toHaveText(/differs from [0-9a-f]{16}/);
});
