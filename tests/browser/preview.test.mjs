// The coarse preview: there before the first masks, gone with them, and none where masks come soon.

import assert from 'node:assert/strict';
import { describe, test } from 'node:test';
import {
  ended,
  inPhase,
  openSample,
  paintedShare,
  plainFrame,
  pngFile,
  screenshot,
  text,
  useSite,
} from './support.mjs';

const WIDTH = 320;
const HEIGHT = 216;
const FRAMES = 55;
const SQUARE = { top: 50, side: 80 };

function noise(x, y, salt) {
  let h = Math.imul((x >> 2) + 7, 374761393) ^ Math.imul((y >> 2) + 3, 668265263) ^ Math.imul(salt, 2246822519);
  h = Math.imul(h ^ (h >>> 13), 1274126177);
  return 60 + (((h ^ (h >>> 16)) >>> 0) % 160);
}

const leftAt = (t) => 20 + 2 * t;

/** A square that moves over a textured ground: more than the pixels from which on there is a preview. */
const clip = Array.from({ length: FRAMES }, (_, t) => {
  const frame = plainFrame(WIDTH, HEIGHT, (x, y) => {
    const { top, side } = SQUARE;
    const inside = x >= leftAt(t) && x < leftAt(t) + side && y >= top && y < top + side;
    const value = inside ? noise(x - leftAt(t), y, 2) : noise(x, y, 1);
    return [value, value, inside ? 255 - value : value];
  });
  return pngFile(`frame${String(t).padStart(2, '0')}.png`, frame);
});

/** Runs in the page: the clip's frames after the first `count` wait for `goOn`, whoever reads them. */
function holdBack(count) {
  const decode = globalThis.createImageBitmap.bind(globalThis);
  const held = new Promise((resolve) => (globalThis.goOn = resolve));
  globalThis.createImageBitmap = async (source, ...rest) => {
    if (source instanceof File && Number(/\d+/.exec(source.name)) >= count) await held;
    return decode(source, ...rest);
  };
}

describe('the coarse preview', () => {
  const site = useSite({ sample: 'tiny' });
  const hasPreview = () => document.body.hasAttribute('data-preview');
  const badge = (page) => page.locator('#preview-mark').isVisible();

  async function begin(count = 20) {
    const { page, faults } = await openSample(site);
    await page.evaluate(holdBack, count);
    await page.setInputFiles('#file', clip);
    return { page, faults };
  }

  test('shows what moves in the first frames while the others are still to come, and goes when masks come', async () => {
    const { page, faults } = await begin();
    await page.waitForFunction(hasPreview);
    assert.ok(await badge(page));
    assert.match(await text(page, '#preview-mark'), /^Coarse preview$/);
    assert.match(await page.locator('#live').textContent(), /coarse preview/i);
    assert.equal(await text(page, '#counter'), '1 / 15');
    assert.equal(await page.getAttribute('body', 'data-phase'), 'running');
    const found = await page.evaluate(
      ({ top, side, width, lefts }) => {
        const { viewer, timeline, job, points } = globalThis.tracecutStudio.app;
        return lefts.map((left, t) => {
          timeline.seek(t);
          viewer.draw();
          const { labels } = viewer.edgedMask();
          const shown = job.preview.shownAt(t);
          let [both, either] = [0, 0];
          labels.forEach((label, k) => {
            const [x, y] = [(k % width) - lefts[shown], Math.floor(k / width) - top];
            const inside = x >= 0 && x < side && y >= 0 && y < side;
            both += Number(inside && label > 0);
            either += Number(inside || label > 0);
          });
          return { shown, overlap: both / either, labels: new Set(labels).size, settled: points !== null };
        });
      },
      { ...SQUARE, width: WIDTH, lefts: Array.from({ length: 15 }, (_, t) => leftAt(t)) },
    );
    found.forEach(({ shown, overlap, labels, settled }, t) => {
      assert.equal(shown, t - (t % 2), 'picture and mask are of one frame');
      assert.ok(overlap > 0.7, `frame ${t}: ${overlap}`);
      assert.ok(labels === 2 && !settled);
    });
    assert.ok((await page.evaluate(paintedShare)) > 0.5);
    await screenshot(page, 'preview');
    await page.evaluate(() => globalThis.goOn());
    await page.waitForFunction(() => !document.body.hasAttribute('data-preview'));
    assert.ok(await page.evaluate(() => globalThis.tracecutStudio.app.points?.mask(0) !== null), 'masks are there');
    assert.equal(await text(page, '#counter'), `1 / ${FRAMES}`);
    assert.equal(await badge(page), false);
    assert.equal(await ended(page), 'done');
    assert.equal(await page.evaluate(hasPreview), false);
    assert.deepEqual(faults, []);
  });

  test('stays after a cancel, and gives way to another clip', async () => {
    const { page, faults } = await begin();
    await page.waitForFunction(hasPreview);
    await page.keyboard.press('Escape');
    await inPhase(page, 'stopped');
    assert.ok(await badge(page));
    await page.click('#sample');
    assert.equal(await ended(page), 'done');
    assert.equal(await badge(page), false);
    assert.match(await text(page, '#subline'), /^4 frames/);
    assert.deepEqual(faults, []);
  });

  test('that fails is none, and the run goes on', async () => {
    const { page, faults } = await begin(5);
    await page.waitForFunction(() => globalThis.tracecutStudio.app.job?.images.length === 5);
    await page.evaluate(() => globalThis.tracecutStudio.app.job.preview.frames.error(new Error('no frames')));
    await page.waitForFunction(() => globalThis.tracecutStudio.app.job.preview.life.signal.aborted);
    await page.evaluate(() => globalThis.goOn());
    assert.equal(await ended(page), 'done');
    assert.equal(await page.evaluate(() => globalThis.tracecutStudio.app.job.preview.masks), null);
    assert.deepEqual(faults, []);
  });

  test('is not made where masks come soon', async () => {
    const { page } = await openSample(site);
    assert.equal(await page.evaluate(() => globalThis.tracecutStudio.app.job.preview), null);
  });
});
