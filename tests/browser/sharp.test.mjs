// The picture on the page is the source's, also of clips that are kept at the working size.

import assert from 'node:assert/strict';
import { test } from 'node:test';
import { openSample, plainFrame, pngFile, run, screenshot, text, useSite } from './support.mjs';

const site = useSite({ sample: 'tiny' });

/** Wider than the working size; fine stripes tell the two apart. */
const [WIDTH, HEIGHT, FRAMES] = [600, 72, 20];
const frames = Array.from({ length: FRAMES }, (_, t) =>
  plainFrame(WIDTH, HEIGHT, (x, y) => {
    const inside = x >= 40 + 3 * t && x < 130 + 3 * t && y >= 16 && y < 56;
    const seed = Math.imul((inside ? x - 3 * t : x) + 733 * y + (inside ? 5 : 0), 2654435761) >>> 24;
    const value = inside ? 60 + (seed % 90) : x % 2 === 0 ? 90 + (seed % 60) : 140 + (seed % 60);
    return [value, value, 255 - value];
  }),
);

test('a frame that rests is as fine as the source, one that plays is not waited for', async () => {
  const { page, faults } = await openSample(site);
  const files = frames.map((frame, t) => pngFile(`${String(t).padStart(3, '0')}.png`, frame));
  assert.equal(await run(page, files), 'done', await text(page, 'main'));
  const width = () => page.evaluate(() => globalThis.tracecutStudio.app.viewer.view.image?.width);
  const sharp = () =>
    page.waitForFunction((wide) => globalThis.tracecutStudio.app.viewer.view.image?.width === wide, WIDTH);
  const { stored } = await page.evaluate(() => ({ stored: globalThis.tracecutStudio.app.job.images.width }));
  assert.equal(stored, 480);
  for (const t of [0, 19, 7]) {
    await page.evaluate((frame) => globalThis.tracecutStudio.app.timeline.seek(frame), t);
    await sharp();
    const colors = await page.evaluate(() => {
      const context = new OffscreenCanvas(600, 72).getContext('2d', { willReadFrequently: true });
      context.drawImage(globalThis.tracecutStudio.app.viewer.view.image, 0, 0);
      return [...context.getImageData(0, 0, 600, 72).data];
    });
    assert.deepEqual(Buffer.from(colors), Buffer.from(frames[t].data), `frame ${t}`);
  }
  await screenshot(page, 'sharp');
  await page.click('#play');
  await page.waitForFunction(() => globalThis.tracecutStudio.app.viewer.view.frame > 9);
  assert.equal(await width(), 480);
  await page.click('#play');
  await sharp();
  assert.deepEqual(faults, []);
});
