// A single image: no motion, but boundaries, superpixels and the discontinuities of its pixels' embedding.

import assert from 'node:assert/strict';
import { beforeEach, describe, test } from 'node:test';
import {
  ended,
  gifFile,
  inPhase,
  layerNames,
  paintedShare,
  picture,
  plainFrame,
  pngFile,
  run,
  screenshot,
  showOnly,
  SMALL,
  text,
  useSample,
  useSite,
} from './support.mjs';

const WIDTH = 120;
const HEIGHT = 80;

/** A bright disc on a dark, slightly uneven ground. */
const disc = plainFrame(WIDTH, HEIGHT, (x, y) => {
  const inside = (x - 50) ** 2 + (y - 40) ** 2 < 24 ** 2;
  const grain = ((x * 7 + y * 13) % 5) * 2;
  return inside ? [210 + grain, 180, 90] : [40 + grain, 60, 110];
});

const KINDS = ['combined', 'discontinuity', 'spectral', 'pb'];

describe('a still image', () => {
  const sample = useSample(useSite());
  beforeEach(() => (sample.faults.length = 0));

  test('shows its boundaries, superpixels and embedding discontinuities', async () => {
    const { page, faults } = sample;
    assert.equal(
      await run(page, [pngFile('disc.png', disc)]),
      'done',
      await page.evaluate(() => document.querySelector('#error').innerText),
    );
    assert.match(await text(page, '#headline'), /still image/);
    assert.match(await text(page, '#subline'), /^\d+ superpixels? · 120 × 80 · computed in \d/);
    assert.match(await text(page, '#notice'), /motion/);
    for (const absent of ['#timeline', '.block-objects', '#take-frames'])
      assert.equal(await page.locator(absent).isVisible(), false, absent);
    assert.equal(await page.locator('#take-side').isVisible(), true);
    const ids = await layerNames(page);
    assert.deepEqual(ids, ['superpixels', 'contours', 'boundaries', 'still', 'image']);
    const pictures = new Set();
    for (const id of ids) {
      await showOnly(page, id);
      await page.waitForFunction(paintedShare);
      pictures.add(await picture(page));
      await screenshot(page, `still-${id}`);
    }
    assert.equal(pictures.size, ids.length);
    assert.deepEqual(faults, []);
  });

  test('has its choice of boundaries strong along the disc, faint elsewhere, and named under the pointer', async () => {
    const { page } = sample;
    await run(page, [pngFile('disc.png', disc)]);
    await showOnly(page, 'still');
    const pictures = new Set();
    for (const [k, kind] of KINDS.entries()) {
      await page.selectOption('[data-setting="still.kind"]', String(k));
      await page.waitForFunction(paintedShare);
      pictures.add(await picture(page));
      const { rim, ground } = await page.evaluate(shades);
      assert.ok(rim < ground - 60, `${kind}: ${rim} along the disc, ${ground} on the ground`);
    }
    assert.equal(pictures.size, KINDS.length);
    const box = await page.locator('#canvas').boundingBox();
    await page.hover('#canvas', { position: { x: (box.width * 74) / WIDTH, y: box.height / 2 } });
    assert.match(
      await text(page, '#readout'),
      /^combined \d\.\d\d, discontinuity \d\.\d\d, spectral \d\.\d\d, Pb 0\.[1-9]\d$/,
    );
    await page.keyboard.press('6');
    assert.equal(await page.locator('[data-layer="still"]').isChecked(), false);
  });

  test('is cancelled, goes on, and gives way to what is opened meanwhile', async () => {
    const { page, faults } = sample;
    const large = plainFrame(400, 300, (x, y) => [(x * y) % 251, (3 * x) % 200, y % 256]);
    await page.setInputFiles('#file', [pngFile('large.png', large)]);
    await page.waitForFunction(() => globalThis.tracecutStudio.app.job?.current?.id === 'imageEdges');
    await page.keyboard.press('Escape');
    await inPhase(page, 'stopped');
    await page.click('#resume');
    await inPhase(page, 'running');
    await page.click('#sample');
    assert.equal(await ended(page), 'done');
    assert.match(
      await text(page, '#subline'),
      new RegExp(`${SMALL.frames} frames of ${SMALL.width} × ${SMALL.height}`),
    );
    assert.equal((await layerNames(page)).includes('still'), false);
    assert.equal(await page.locator('#timeline').isVisible(), true);
    assert.deepEqual(faults, []);
  });

  for (const [what, frame] of Object.entries({
    'of one pixel': plainFrame(1, 1),
    'of one colour': plainFrame(60, 40),
    'of 2 × 90': plainFrame(2, 90),
  })) {
    test(`${what} is answered too`, async () => {
      const { page, faults } = sample;
      assert.equal(
        await run(page, [pngFile('plain.png', frame)]),
        'done',
        await page.evaluate(() => document.querySelector('#error').innerText),
      );
      assert.deepEqual(faults, []);
    });
  }

  test('may be a GIF of one frame; a damaged file is refused in words', async () => {
    const { page } = sample;
    assert.equal(await run(page, [gifFile('disc.gif', [disc])]), 'done');
    assert.match(await text(page, '#clip-facts'), /^120 × 80$/);
    const damaged = { ...pngFile('disc.png', disc), buffer: pngFile('disc.png', disc).buffer.subarray(0, 60) };
    assert.equal(await run(page, [damaged]), 'error');
    assert.equal(await page.getAttribute('#error', 'data-code'), 'unreadable-image');
  });
});

/** Runs in the page: the mean grey along the disc's rim, at its darkest nearby, and of the ground far from it. */
function shades() {
  const { viewer } = globalThis.tracecutStudio.app;
  viewer.draw();
  const { canvas } = viewer;
  const { data } = canvas.getContext('2d').getImageData(0, 0, canvas.width, canvas.height);
  const grey = (x, y) =>
    data[4 * (Math.round((y * canvas.height) / 80) * canvas.width + Math.round((x * canvas.width) / 120))];
  const mean = (list) => list.reduce((sum, value) => sum + value, 0) / list.length;
  const turns = Array.from({ length: 24 }, (_, k) => (2 * Math.PI * k) / 24);
  const nearRim = (turn) =>
    Math.min(...[22, 23, 24, 25, 26].map((r) => grey(50 + r * Math.cos(turn), 40 + r * Math.sin(turn))));
  return { rim: mean(turns.map(nearRim)), ground: mean([10, 20, 30, 40, 50, 60, 70].map((y) => grey(105, y))) };
}
