// The first screen: a cut-out that moves, before anything is computed, and a line that says what one gets.

import assert from 'node:assert/strict';
import { test } from 'node:test';
import { fiveObjects, WIDE } from './five.mjs';
import { ended, screenshot, text, useSite } from './support.mjs';

const site = useSite({ sample: 'tiny' });

/** A page that never gets what computes. */
async function openIdle(options) {
  const { page } = await site.open({ ...options, query: 'favicon.svg' });
  await page.route('**/*.wasm', () => {});
  await page.goto(new URL('./', page.url()).href);
  return page;
}

/** Runs in the page: where the objects are, and which pictures are there. */
function looks() {
  return [...document.querySelectorAll('#welcome img')].map((image) => ({
    left: Math.round(image.getBoundingClientRect().left),
    wide: image.naturalWidth,
    seen: Number(getComputedStyle(image).opacity),
  }));
}

for (const [width, height] of [
  [1440, 900],
  [390, 844],
  [844, 390],
])
  test(`a cut-out moves before anything is computed, ${width}x${height}`, async () => {
    const page = await openIdle({ viewport: { width, height }, reducedMotion: 'no-preference' });
    await page.waitForFunction(() =>
      [...document.querySelectorAll('#welcome img')].every((image) => image.naturalWidth),
    );
    const before = await page.evaluate(looks);
    await page.waitForTimeout(500);
    const after = await page.evaluate(looks);
    assert.ok(
      before.every(({ left, wide }, k) => k === 0 || (wide > 0 && left !== after[k].left)),
      JSON.stringify([before, after]),
    );
    assert.equal(await page.evaluate(() => document.body.dataset.phase), 'opening');
    const line = page.locator('#welcome p');
    assert.match(await line.innerText(), /^Open or drop a video: what moves is cut out/);
    const [box, place] = [await line.boundingBox(), await page.locator('.welcome-picture').boundingBox()];
    assert.ok(place.width > 200 && place.y + place.height <= box.y, JSON.stringify([place, box]));
    assert.ok(box.y + box.height <= height, 'all of it is in view');
    // It lets the pointer through.
    assert.equal(await page.evaluate(() => getComputedStyle(document.querySelector('#welcome')).pointerEvents), 'none');
    await screenshot(page, `first-${width}x${height}`);
  });

test('whoever wants no motion sees the objects at rest, cut out', async () => {
  const page = await openIdle({ reducedMotion: 'reduce' });
  await page.waitForFunction(() => [...document.querySelectorAll('#welcome img')].every((image) => image.naturalWidth));
  const before = await page.evaluate(looks);
  await page.waitForTimeout(300);
  assert.deepEqual(await page.evaluate(looks), before);
  assert.deepEqual(
    before.map(({ seen }) => seen),
    [0, 1, 1],
  );
});

test('it goes when the sample is done, and when something of one’s own is opened', async () => {
  const { page } = await site.open();
  assert.equal(await ended(page), 'done');
  assert.equal(await page.locator('#welcome').count(), 0);
  const idle = await openIdle();
  assert.equal(await idle.locator('#welcome').count(), 1);
  const { video } = await fiveObjects(page, WIDE);
  const { page: other } = await site.open();
  await other.waitForFunction(() => globalThis.tracecutStudio);
  await other.setInputFiles('#file', [video]);
  await other.waitForFunction(() => globalThis.tracecutStudio?.source?.name === 'five.webm');
  assert.equal(await other.locator('#welcome').count(), 0);
  assert.match(await text(other, '#clip-name'), /five/);
});
