// Where nothing is found the page says where it looked, and each button starts what it says.

import assert from 'node:assert/strict';
import { describe, test } from 'node:test';
import {
  accessibilityFaults,
  ended,
  openSample,
  plainFrame,
  pngFile,
  run,
  screenshot,
  text,
  useSite,
} from './support.mjs';

/** Texture that shifts by `speed` a frame as a whole. */
function shifting(count, speed, { width = 96, height = 64 } = {}) {
  const noise = (x, y) => {
    const h = Math.imul((x >> 1) + 7, 374761393) ^ Math.imul((y >> 1) + 3, 668265263);
    const mixed = Math.imul(h ^ (h >>> 13), 1274126177);
    return 60 + (((mixed ^ (mixed >>> 16)) >>> 0) % 160);
  };
  return Array.from({ length: count }, (_, t) => {
    const frame = plainFrame(width, height, (x, y) => {
      const value = noise(x + speed * t, y);
      return [value, value, value];
    });
    return pngFile(`f${String(t).padStart(3, '0')}.png`, frame);
  });
}

const take = (page) => page.evaluate(() => globalThis.tracecutStudio.take);
/** What is offered is fetched when it is first needed. */
const tries = async (page) => {
  await page.waitForSelector('[data-try]');
  return page.evaluate(() => [...document.querySelectorAll('[data-try]')].map((button) => button.dataset.try));
};

describe('a clip in which nothing is found', () => {
  const site = useSite();

  test('is told apart from one that has objects; slow motion is tried by leaving frames out', async () => {
    const { page, faults } = await openSample(site, { bypassCSP: true });
    assert.equal(await page.locator('#nothing').isVisible(), false, 'the sample has objects');
    assert.equal(await run(page, shifting(30, 2)), 'done');
    await page.waitForSelector('[data-try]');
    const where = await text(page, '#nothing-where');
    assert.match(where, /^Followed \d.* points over [89]\d.% of the picture, through 30 frames/);
    assert.match(where, /the camera moves, about 2\.0 px a frame/);
    assert.match(where, /taken as background/);
    assert.deepEqual(await tries(page), ['step', 'add']);
    assert.deepEqual(await accessibilityFaults(page), []);
    await screenshot(page, 'nothing');
    await page.click('[data-try="step"]');
    assert.equal(await ended(page), 'done');
    assert.deepEqual(await take(page), { start: 0, frames: 15, step: 2, side: 480 });
    assert.deepEqual(faults, []);
  });

  test('a click adds the thing that was missed', async () => {
    const { page } = await openSample(site, { viewport: { width: 390, height: 844 }, isMobile: true, hasTouch: true });
    assert.equal(await run(page, shifting(8, 0)), 'done');
    await screenshot(page, 'nothing-phone');
    await page.click('[data-try="add"]');
    await page.waitForSelector('#nothing', { state: 'hidden' });
    assert.equal(await page.isChecked('#correct-tools [value="add"]'), true);
    await page.locator('#canvas').click();
    await page.waitForFunction(() => document.querySelectorAll('.object').length === 2);
    await page.click('#correct-done');
    assert.equal(await page.locator('#nothing').isVisible(), false, 'there is an object now');
  });
});
