// The sample clip on the page: the objects are found and coloured, each layer shows something of its own, and the labels are
// those that the package gives in Node.

import assert from 'node:assert/strict';
import { describe, test } from 'node:test';
import { createSession, synthClip } from '../../dist/node.js';
import { SAMPLE } from '../../www/demo/source.js';
import { screenshot, text, useSample, useSite } from './support.mjs';

const FRAME = 12;

describe('the sample', () => {
  const sample = useSample(useSite());

  test('is segmented on load, without a click, and described in words', async () => {
    const { page, faults } = sample;
    assert.match(await text(page, '#headline'), /^[2-9] moving objects and the background$/);
    assert.match(await text(page, '#subline'), /trajectories · 24 frames of 384 × 216 · computed in \d/);
    const clusters = await page.evaluate(() => globalThis.tracecutDemo.result.clusters.count);
    assert.ok(clusters >= 3, `${clusters} clusters`);
    await page.evaluate((frame) => globalThis.tracecutDemo.app.timeline.seek(frame), FRAME);
    await screenshot(page, 'sample');
    assert.deepEqual(faults, []);
  });

  test('has its objects coloured where the scene has them', async () => {
    const { page } = sample;
    const { counts, masks } = await page.evaluate(paintedPixels, FRAME);
    const total = counts.flat().reduce((sum, n) => sum + n, 0);
    const owners = counts.map((row) => row.indexOf(Math.max(...row)));
    const pure = counts.reduce((sum, row, k) => sum + row[owners[k]], 0);
    assert.ok(total > 1000, `only ${total} painted pixels`);
    assert.equal(owners[0], 0, 'the largest cluster is the background');
    assert.ok(pure / total > 0.93, `${((100 * pure) / total).toFixed(1)} % of painted pixels lie in their cluster's object`);
    const found = new Set(owners.filter((owner) => owner > 0));
    assert.ok(found.size >= 2, `${found.size} of ${masks - 1} objects have a cluster of their own`);
  });

  test('shows something different in each layer', async () => {
    const { page } = sample;
    await page.evaluate((frame) => globalThis.tracecutDemo.app.timeline.seek(frame), FRAME);
    const ids = await page.evaluate(() => globalThis.tracecutDemo.app.layers.map((layer) => layer.id));
    assert.deepEqual(ids, ['trajectories', 'discontinuities', 'embedding', 'flow', 'image']);
    const pictures = new Map();
    for (const id of ids) {
      for (const box of await page.locator('[data-layer]').all()) {
        await box.setChecked((await box.getAttribute('data-layer')) === id);
      }
      // Flow is computed when it is first shown.
      await page.waitForFunction(paintedShare);
      const share = await page.evaluate(paintedShare);
      assert.ok(share > 0.002, `${id} paints ${share} of the canvas`);
      pictures.set(await page.evaluate(() => document.querySelector('#canvas').toDataURL()), id);
      await screenshot(page, `sample-${id}`);
    }
    assert.equal(pictures.size, ids.length, `only ${[...pictures.values()]} differ`);
  });

  test('hides a cluster, and shows one alone', async () => {
    const { page } = sample;
    const colors = () => page.evaluate(paintedPixels, FRAME).then(({ counts }) => counts.map((row) => row.some((n) => n > 0)));
    const all = await colors();
    assert.ok(all.every(Boolean));
    await page.click('[data-cluster="1"] .object-main');
    assert.deepEqual(await colors(), all.map((_, k) => k === 1));
    await page.click('#show-all');
    await page.click('[data-cluster="0"] .eye');
    assert.deepEqual(await colors(), all.map((_, k) => k > 0));
  });

  test('has the same labels as in Node, to the byte', async () => {
    const { page } = sample;
    const inPage = await page.evaluate(() => {
      const { clusters, trajectories } = globalThis.tracecutDemo.result;
      return { label: [...clusters.label], x: [...trajectories.x] };
    });
    const clip = await synthClip(SAMPLE);
    const session = await createSession();
    for (let t = 0; t < clip.numFrames; t += 1) await session.push(clip.frame(t));
    const result = await session.run();
    session.close();
    assert.deepEqual([...result.clusters.label], inPage.label);
    assert.deepEqual([...result.trajectories.x], inPage.x);
  });
});

/**
 * Runs in the page. Draws nothing but the points of a frame and counts, for each cluster's colour, in which object of the
 * scene the painted pixels lie.
 */
function paintedPixels(frame) {
  const { app, source, result, clusterColor } = globalThis.tracecutDemo;
  for (const layer of app.layers) layer.on = layer.id === 'trajectories';
  app.layers[0].settings.trail.value = 0;
  app.timeline.seek(frame);
  app.viewer.draw();
  const { canvas } = app.viewer;
  const { data } = canvas.getContext('2d').getImageData(0, 0, canvas.width, canvas.height);
  const mask = source.clip.mask(frame);
  const masks = 1 + mask.reduce((most, value) => Math.max(most, value), 0);
  const colors = Array.from({ length: result.clusters.count }, (_, k) => Number.parseInt(clusterColor(k).slice(1), 16));
  const counts = colors.map(() => new Array(masks).fill(0));
  const scale = result.width / canvas.width;
  for (let y = 0; y < canvas.height; y += 1) {
    for (let x = 0; x < canvas.width; x += 1) {
      const at = 4 * (y * canvas.width + x);
      const cluster = colors.indexOf((data[at] << 16) | (data[at + 1] << 8) | data[at + 2]);
      if (data[at + 3] < 255 || cluster < 0) continue;
      counts[cluster][mask[Math.floor(y * scale) * result.width + Math.floor(x * scale)]] += 1;
    }
  }
  return { counts, masks };
}

/** Runs in the page: the share of the canvas that is painted at all. */
function paintedShare() {
  const { canvas } = globalThis.tracecutDemo.app.viewer;
  const { data } = canvas.getContext('2d').getImageData(0, 0, canvas.width, canvas.height);
  let painted = 0;
  for (let at = 3; at < data.length; at += 4) if (data[at] > 0) painted += 1;
  return painted / (data.length / 4);
}
