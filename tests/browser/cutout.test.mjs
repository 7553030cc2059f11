// The result as it is saved: the objects that are kept, on a ground of one's choice.

import assert from 'node:assert/strict';
import { describe, test } from 'node:test';
import {
  accessibilityFaults,
  bytesOf,
  openLook,
  openSample,
  openSave,
  plainFrame,
  pngFile,
  screenshot,
  text,
  useSite,
} from './support.mjs';

describe('the cut-out view', () => {
  const site = useSite();
  let page;
  let faults;

  /** Colours on screen deep inside objects 1 and 2, and of the background, in the frame on screen. */
  const colors = () =>
    page.evaluate(() => {
      const { viewer, segmentation } = globalThis.tracecutStudio.app;
      viewer.draw();
      const { width, height } = segmentation.result;
      const mask = segmentation.mask(viewer.view.frame);
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
    await page.evaluate(() => globalThis.tracecutStudio.app.timeline.seek(12));
    assert.equal(await page.locator('#backdrop-row').isVisible(), false);
    await page.check('[name="view"][value="cutout"]', { force: true });
    assert.equal(await page.locator('#backdrop-row').isVisible(), true);
    const [one, two, ground] = await colors();
    assert.equal(ground.shown[3], 0);
    assert.ok(near(one.shown, one.own) && near(two.shown, two.own), JSON.stringify([one, two]));
    await screenshot(page, 'cutout');
    assert.deepEqual(await accessibilityFaults(page), []);
  });

  test('on green, a colour, the frame blurred, grey or dark, or a picture', async () => {
    await page.selectOption('#backdrop', 'green');
    assert.deepEqual((await colors())[2].shown, [0, 0xb1, 0x40, 255]);
    await page.selectOption('#backdrop', 'colour');
    await page.fill('#backdrop-colour', '#204080');
    assert.deepEqual((await colors())[2].shown, [0x20, 0x40, 0x80, 255]);
    await page.selectOption('#backdrop', 'blurred');
    const [, , ground] = await colors();
    assert.equal(ground.shown[3], 255);
    assert.notDeepEqual(ground.shown, ground.own);
    await screenshot(page, 'cutout-blurred');
    await page.selectOption('#backdrop', 'desaturated');
    const [, , grey] = await colors();
    assert.ok(grey.shown[3] === 255 && Math.max(...grey.shown.slice(0, 3)) - Math.min(...grey.shown.slice(0, 3)) <= 2);
    assert.notDeepEqual(grey.shown, grey.own);
    await page.selectOption('#backdrop', 'dimmed');
    const [, , dark] = await colors();
    assert.ok(dark.own.slice(0, 3).every((v, k) => Math.abs(dark.shown[k] - 0.35 * v) <= 2));
    await screenshot(page, 'cutout-spotlight');
    const choosing = page.waitForEvent('filechooser');
    await page.selectOption('#backdrop', 'picture');
    await (
      await choosing
    ).setFiles([
      pngFile(
        'sky.png',
        plainFrame(30, 30, () => [90, 160, 250]),
      ),
    ]);
    await page.waitForFunction(() => document.querySelector('#backdrop').value === 'picture');
    assert.deepEqual((await colors())[2].shown, [90, 160, 250, 255]);
  });

  test('with masks that are smoothed over time, on screen and in saved files', async () => {
    const shown = () =>
      page.evaluate(() => {
        const { viewer } = globalThis.tracecutStudio.app;
        return [...viewer.edgedMask().labels];
      });
    const slide = (value) =>
      page.$eval(
        '#edge-smooth',
        (input, to) => {
          input.value = to;
          input.dispatchEvent(new Event('input'));
        },
        value,
      );
    const before = await shown();
    await slide('1');
    await page.waitForFunction(() => document.querySelector('#edge-smooth-text').textContent === '±1');
    const smooth = await shown();
    assert.notDeepEqual(smooth, before);
    const wanted = await page.evaluate(async () => {
      const library = await import('/model/library.js');
      const { segmentation } = globalThis.tracecutStudio.app;
      const { corrections } = globalThis.tracecutStudio.app.job;
      const { width, height, numFrames } = segmentation.result;
      const masks = { width, height, numFrames, labels: (t) => segmentation.mask(t) };
      const result = await library.smoothMasks(masks, { picture: (t) => corrections.pixels(t) });
      const { maskEdges } = await import('/model/view-settings.js');
      const edges = maskEdges({ smallest: 0.02, grow: 0, feather: 0 }, masks);
      const frame = globalThis.tracecutStudio.app.viewer.view.frame;
      return [...library.adjustMask({ labels: result.labels(frame), width, height }, edges).labels];
    });
    assert.deepEqual(smooth, wanted);
    await screenshot(page, 'smooth');
    await openSave(page);
    const coming = page.waitForEvent('download');
    await page.click('[data-export="png"]');
    const png = await bytesOf(await coming);
    const saved = await page.evaluate(
      async (bytes) => {
        const bitmap = await createImageBitmap(new Blob([Uint8Array.from(bytes)]));
        const context = new OffscreenCanvas(bitmap.width, bitmap.height).getContext('2d');
        context.drawImage(bitmap, 0, 0);
        const { data } = context.getImageData(0, 0, bitmap.width, bitmap.height);
        return Array.from({ length: data.length / 4 }, (_, p) =>
          Number(data[4 * p] + data[4 * p + 1] + data[4 * p + 2] > 0),
        );
      },
      [...png],
    );
    assert.deepEqual(
      saved,
      smooth.map((label) => Number(label > 0)),
    );
    await page.keyboard.press('Escape');
    await slide('0');
    assert.deepEqual(await shown(), before);
  });

  test('with edges that grow, shrink and fade, without specks', async () => {
    const covered = () =>
      page.evaluate(() => {
        const { viewer } = globalThis.tracecutStudio.app;
        const { alpha, labels } = viewer.view.mask();
        return {
          sum: alpha.reduce((sum, value) => sum + value, 0) / 255,
          soft: alpha.filter((value) => value > 0 && value < 255).length,
          labels: labels.filter((label) => label > 0).length,
        };
      });
    assert.equal(await page.locator('#edges-reset').isVisible(), false);
    const plain = await covered();
    assert.equal(plain.soft, 0);
    await openLook(page);
    await page.fill('#edge-grow', '3');
    const larger = await covered();
    assert.ok(larger.sum > plain.sum * 1.05, `${plain.sum} ${larger.sum}`);
    await page.fill('#edge-grow', '-3');
    const smaller = await covered();
    assert.ok(smaller.sum < plain.sum * 0.95, `${plain.sum} ${smaller.sum}`);
    await page.fill('#edge-grow', '0');
    await page.fill('#edge-feather', '6');
    const soft = await covered();
    assert.ok(soft.soft > 500 && Math.abs(soft.sum / plain.sum - 1) < 0.1, JSON.stringify([plain, soft]));
    assert.equal(await text(page, '#edge-feather-text'), '6\u00a0px');
    await screenshot(page, 'cutout-soft');
    await openSave(page);
    const coming = page.waitForEvent('download');
    await page.click('[data-export="cutout-webm"]');
    const bytes = [...(await bytesOf(await coming))];
    await page.click('#export-close');
    const { shown, drawn } = await page.evaluate(async (data) => {
      const { videoFrames } = await import('/dist/index.js');
      const { viewer } = globalThis.tracecutStudio.app;
      let t = 0;
      for await (const { width, height, pixels } of videoFrames(new Blob([Uint8Array.from(data)]))) {
        if (t++ < 12) continue;
        // On a picture of one colour its part is what is not the object.
        const frame = await pixels();
        const own = new OffscreenCanvas(width, height).getContext('2d', { willReadFrequently: true });
        own.drawImage(viewer.canvas, 0, 0, width, height);
        const screen = own.getImageData(0, 0, width, height).data;
        const off = Array.from({ length: screen.length / 4 }, (_, p) =>
          Math.max(...[0, 1, 2].map((c) => Math.abs(screen[4 * p + c] - frame.data[4 * p + c]))),
        );
        return { shown: off.filter((by) => by > 40).length / off.length, drawn: off.length };
      }
      return {};
    }, bytes);
    assert.ok(drawn > 0 && shown < 0.02, `${shown} of the video is not what is on screen`);
    // Nothing in the small sample is as small as the slider's end.
    await page.evaluate(() => (document.querySelector('#edge-smallest').max = 5));
    await openLook(page);
    await page.fill('#edge-smallest', '3');
    assert.ok((await covered()).labels < plain.labels);
    await page.click('#edges-reset');
    assert.deepEqual(await covered(), plain);
    assert.equal(await page.locator('#edges-reset').isVisible(), false);
  });

  test('without what is not kept; and the export says both', async () => {
    await page.selectOption('#backdrop', 'green');
    await page.uncheck('[data-object="1"] input');
    const [one, two] = await colors();
    assert.deepEqual(one.shown, [0, 0xb1, 0x40, 255]);
    assert.ok(near(two.shown, two.own));
    await openSave(page);
    assert.match(await text(page, '#export-kept'), /^Only Object 2, Object 3 will be saved/);
    assert.equal(await text(page, '[data-export="cutout-webm"]'), 'Green WebM');
    const coming = page.waitForEvent('download');
    await page.click('[data-export="cutout-webm"]');
    const file = await coming;
    assert.match(file.suggestedFilename(), /green\.webm$/);
    await page.click('#export-close');
    await page.check('[name="view"][value="overlay"]', { force: true });
    assert.equal(await page.locator('#backdrop-row').isVisible(), false);
    assert.deepEqual(faults, []);
  });
});
