// The result as it is saved: the objects that are kept, on a ground of one's choice.

import assert from 'node:assert/strict';
import { describe, test } from 'node:test';
import { accessibilityFaults, openSample, plainFrame, pngFile, screenshot, text, useSite } from './support.mjs';

describe('the cut-out view', () => {
  const site = useSite();
  let page;
  let faults;

  /** Colours on screen deep inside objects 1 and 2, and of the background, in the frame on screen. */
  const colors = () =>
    page.evaluate(() => {
      const { viewer, points } = globalThis.tracecutDemo.app;
      viewer.draw();
      const { width, height } = points.result;
      const mask = points.mask(viewer.view.frame);
      const reach = 5;
      const inside = (wanted) =>
        mask.findIndex((label, p) => {
          const [x, y] = [p % width, Math.floor(p / width)];
          if (label !== wanted || x < reach || y < reach || x >= width - reach || y >= height - reach) return false;
          return [-reach, 0, reach].every((dy) =>
            [-reach, 0, reach].every((dx) => mask[p + dy * width + dx] === wanted),
          );
        });
      const readable = { willReadFrequently: true };
      const context = new OffscreenCanvas(viewer.canvas.width, viewer.canvas.height).getContext('2d', readable);
      context.drawImage(viewer.canvas, 0, 0);
      const scale = viewer.canvas.width / width;
      const own = new OffscreenCanvas(width, height).getContext('2d', readable);
      own.drawImage(viewer.view.image, 0, 0);
      return [1, 2, 0].map((label) => {
        const at = inside(label);
        const [x, y] = [at % width, Math.floor(at / width)];
        return {
          shown: [...context.getImageData(Math.floor((x + 0.5) * scale), Math.floor((y + 0.5) * scale), 1, 1).data],
          own: [...own.getImageData(x, y, 1, 1).data],
        };
      });
    });
  const near = (a, b) => Math.max(...b.map((value, k) => Math.abs(value - a[k]))) <= 24;

  test('shows the objects alone, transparent around, in their own colours', async () => {
    ({ page, faults } = await openSample(site, { bypassCSP: true }));
    await page.evaluate(() => globalThis.tracecutDemo.app.timeline.seek(12));
    assert.equal(await page.locator('#ground-row').isVisible(), false);
    await page.check('[name="view"][value="cutout"]', { force: true });
    assert.equal(await page.locator('#ground-row').isVisible(), true);
    const [one, two, ground] = await colors();
    assert.equal(ground.shown[3], 0);
    assert.ok(near(one.shown, one.own) && near(two.shown, two.own), JSON.stringify([one, two]));
    await screenshot(page, 'cutout');
    assert.deepEqual(await accessibilityFaults(page), []);
  });

  test('on green, a colour, the frame blurred, or a picture', async () => {
    await page.selectOption('#ground', 'green');
    assert.deepEqual((await colors())[2].shown, [0, 0xb1, 0x40, 255]);
    await page.selectOption('#ground', 'colour');
    await page.fill('#ground-colour', '#204080');
    assert.deepEqual((await colors())[2].shown, [0x20, 0x40, 0x80, 255]);
    await page.selectOption('#ground', 'blurred');
    const [, , ground] = await colors();
    assert.equal(ground.shown[3], 255);
    assert.notDeepEqual(ground.shown, ground.own);
    await screenshot(page, 'cutout-blurred');
    const choosing = page.waitForEvent('filechooser');
    await page.selectOption('#ground', 'picture');
    await (
      await choosing
    ).setFiles([
      pngFile(
        'sky.png',
        plainFrame(30, 30, () => [90, 160, 250]),
      ),
    ]);
    await page.waitForFunction(() => document.querySelector('#ground').value === 'picture');
    assert.deepEqual((await colors())[2].shown, [90, 160, 250, 255]);
  });

  test('without what is not kept; and the export says both', async () => {
    await page.selectOption('#ground', 'green');
    await page.uncheck('[data-object="1"] input');
    const [one, two] = await colors();
    assert.deepEqual(one.shown, [0, 0xb1, 0x40, 255]);
    assert.ok(near(two.shown, two.own));
    await page.click('#export-open');
    assert.match(await text(page, '#export-kept'), /^Object 2, Object 3 of 3 objects are kept/);
    assert.equal(await text(page, '[data-export="cutout-webm"]'), 'Green WebM');
    const coming = page.waitForEvent('download');
    await page.click('[data-export="cutout-webm"]');
    const file = await coming;
    assert.match(file.suggestedFilename(), /cutout\.webm$/);
    await page.click('#export-close');
    await page.check('[name="view"][value="overlay"]', { force: true });
    assert.equal(await page.locator('#ground-row').isVisible(), false);
    assert.deepEqual(faults, []);
  });
});
