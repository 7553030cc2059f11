// Devices: a phone on its side, a phone while fixing, fingers, forced colours, sharing.

import assert from 'node:assert/strict';
import { before, describe, test } from 'node:test';
import {
  accessibilityFaults,
  inPhase,
  onlyLong,
  openFix,
  openSample,
  openSave,
  screenshot,
  text,
  useSite,
} from './support.mjs';

const PHONE = { viewport: { width: 390, height: 844 }, isMobile: true, hasTouch: true, bypassCSP: true };
const SIDE = { ...PHONE, viewport: { width: 844, height: 390 } };

/** Which part of an element's height is within the window, and where it is. */
function inView(page, selector) {
  return page.evaluate((wanted) => {
    const { top, bottom, left, right, height, width } = document.querySelector(wanted).getBoundingClientRect();
    const seen = Math.max(0, Math.min(innerHeight, bottom) - Math.max(0, top));
    return { seen: seen / height, top, bottom, left, right, width, height };
  }, selector);
}

const site = useSite();

describe('a phone', () => {
  let page;
  before(async () => ({ page } = await openSample(site, PHONE)));

  test('on a phone the picture stays in view while fixing', async () => {
    await openFix(page);
    await page.evaluate(() => scrollTo(0, 0));
    await screenshot(page, 'fix-phone');
    for (const selector of ['#correct-split', '#correct-done', '#correct-merge', '#play']) {
      await page.locator(selector).scrollIntoViewIfNeeded();
      assert.ok((await inView(page, '#screen')).seen > 0.95, selector);
      assert.ok((await inView(page, selector)).seen > 0.95, selector);
    }
    assert.deepEqual(await accessibilityFaults(page), []);
    // A tap on the picture chooses what is there.
    const { x, y, width, height } = await page.locator('#canvas').boundingBox();
    await page.touchscreen.tap(x + 0.76 * width, y + 0.6 * height);
    await page.waitForFunction(() => document.querySelector('#correct-object').value !== '1');
    await page.click('#correct-done');
  });

  test('the help tells touches where there are fingers, and only there', async () => {
    await page.click('#help-open');
    await page.waitForSelector('#help[open]');
    assert.match(await text(page, '#help-touch'), /Tap an object[^]*Two fingers/);
    assert.doesNotMatch(await text(page, '#help'), /Click/);
    assert.deepEqual(await accessibilityFaults(page), []);
    await screenshot(page, 'help-phone');
    await page.click('#help-close');
    const { page: desk } = await site.open();
    await inPhase(desk, 'running');
    await desk.click('#help-open');
    await desk.waitForSelector('#help[open]');
    assert.equal(await desk.locator('#help-touch').isVisible(), false);
    assert.match(await text(desk, '#help'), /Click an object/);
  });

  test('what was saved can be shared, where the browser shares such files', async () => {
    await page.evaluate(() => {
      globalThis.shared = [];
      navigator.canShare = ({ files }) => files[0].type !== 'application/json';
      navigator.share = async ({ files, title }) => void globalThis.shared.push([title, files[0].size]);
    });
    await openSave(page);
    assert.equal(await page.locator('#export-share').isVisible(), false, 'nothing is saved yet');
    await page.click('[data-export="coco"]');
    await page.waitForFunction(() => /^Saved/.test(document.querySelector('#export-status').textContent));
    assert.equal(await page.locator('#export-share').isVisible(), false, 'such a file is not shared');
    await page.click('[data-export="png"]');
    await page.waitForSelector('#export-share:not([hidden])');
    assert.deepEqual(await accessibilityFaults(page), []);
    await page.click('#export-share');
    const [[title, size]] = await page.evaluate(() => globalThis.shared);
    assert.match(title, /-mask-0001\.png$/);
    assert.ok(size > 100, `${size}`);
    await screenshot(page, 'share');
    await page.evaluate(() => (navigator.share = () => Promise.reject(new DOMException('no', 'NotAllowedError'))));
    await page.click('#export-share');
    await page.waitForFunction(() => /did not work/.test(document.querySelector('#export-status').textContent));
  });
});

test('on a phone on its side the picture stands beside the controls and stays there', async () => {
  const { page, faults } = await openSample(site, SIDE);
  assert.deepEqual(await accessibilityFaults(page), []);
  await screenshot(page, 'landscape');
  const screen = await inView(page, '#screen');
  assert.ok(screen.width > 0.5 * 844 && screen.height > 0.6 * 390, JSON.stringify(screen));
  for (const selector of ['.toolbar', '.block-objects', '#correct-open'])
    assert.ok((await inView(page, selector)).left >= screen.right, selector);
  for (const selector of ['#edge-grow', '.block-settings']) {
    await page.locator(selector).scrollIntoViewIfNeeded();
    assert.ok((await inView(page, '#screen')).seen > 0.95, selector);
    assert.ok((await inView(page, '#play')).seen > 0.95, selector);
  }
  await screenshot(page, 'landscape-scrolled');
  assert.equal(await page.evaluate(() => document.documentElement.scrollWidth <= innerWidth), true);
  await page.evaluate(() => scrollTo(0, 0));
  await openFix(page);
  await screenshot(page, 'landscape-fix');
  const overlap = await page.evaluate(
    () => document.querySelector('#correct-tools').scrollWidth - document.querySelector('#correct').clientWidth,
  );
  assert.ok(overlap <= 0, `the tools are ${overlap} px too wide`);
  for (const selector of ['#correct-done', '#correct-split']) {
    await page.locator(selector).scrollIntoViewIfNeeded();
    for (const kept of ['#screen', '#play'])
      assert.ok((await inView(page, kept)).seen > 0.95, `${kept} at ${selector}`);
  }
  assert.deepEqual(await accessibilityFaults(page), []);
  assert.deepEqual(faults, []);
});

for (const colorScheme of ['light', 'dark']) {
  test(`forced colours show every control, ${colorScheme}`, colorScheme === 'light' ? {} : onlyLong, async () => {
    const { page } = await openSample(site, { forcedColors: 'active', colorScheme, bypassCSP: true });
    await page.evaluate(() => globalThis.tracecutStudio.app.timeline.seek(12));
    await screenshot(page, `forced-${colorScheme}`);
    // A control that is all of one colour cannot be seen.
    const controls = [
      '#scrub',
      '#edge-grow',
      '[data-layer="masks"]',
      '#correct-open',
      '#loop',
      '.segmented',
      '.keep',
      '.swatch',
    ];
    for (const selector of controls) {
      const box = page.locator(selector).first();
      await box.scrollIntoViewIfNeeded();
      const colours = await coloursOf(page, await box.screenshot());
      assert.ok(colours >= 2, `${selector} has ${colours} colours`);
    }
    // What is to be pressed next looks like the other such buttons: words on a ground of their own.
    const lookOf = (id) =>
      page.evaluate((one) => {
        const { color, backgroundColor, forcedColorAdjust } = getComputedStyle(document.querySelector(one));
        return [color, backgroundColor, forcedColorAdjust].join();
      }, id);
    const [next, plain] = [await lookOf('#open'), await lookOf('#again')];
    assert.notEqual(next, plain);
    await page.locator('[data-parameter="affinity.noiseFloor"] input').first().fill('0.4');
    assert.deepEqual([await lookOf('#open'), await lookOf('#again')], [plain, next]);
    await page.click('#settings-reset');
    const states = await page.evaluate(() =>
      [...document.querySelectorAll('#views span')].map((span) => getComputedStyle(span).backgroundColor),
    );
    assert.notEqual(states[0], states[1], 'the view that is chosen');
    await page.click('[data-layer="image"]');
    const [on, off] = ['masks', 'image'].map((id) => page.locator(`[data-layer="${id}"]`));
    const colour = (box) => box.evaluate((element) => getComputedStyle(element).backgroundColor);
    assert.notEqual(await colour(on), await colour(off), 'a switch that is on');
    await openFix(page);
    await page.evaluate(() => document.querySelector('.panel').scrollTo(0, 0));
    await screenshot(page, `forced-fix-${colorScheme}`);
    await openSave(page);
    await screenshot(page, `forced-save-${colorScheme}`);
  });
}

/** How many colours a picture has that make up a two-hundredth of it or more. */
function coloursOf(page, png) {
  return page.evaluate(
    async (bytes) => {
      const picture = await createImageBitmap(new Blob([new Uint8Array(bytes)]));
      const canvas = new OffscreenCanvas(picture.width, picture.height);
      const ctx = canvas.getContext('2d');
      ctx.drawImage(picture, 0, 0);
      const { data } = ctx.getImageData(0, 0, picture.width, picture.height);
      const counts = new Map();
      for (let at = 0; at < data.length; at += 4) {
        const colour = (data[at] << 16) | (data[at + 1] << 8) | data[at + 2];
        counts.set(colour, (counts.get(colour) ?? 0) + 1);
      }
      return [...counts.values()].filter((count) => count > data.length / 800).length;
    },
    [...png],
  );
}
