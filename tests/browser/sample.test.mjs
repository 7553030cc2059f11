// The sample clip on the page: the objects are found and coloured, and the labels are those that the package gives in Node.

import assert from 'node:assert/strict';
import { describe, test } from 'node:test';
import { createSession, synthClip } from '../../dist/node.js';
import { screenshot, text, useSample, useSite } from './support.mjs';

const { SAMPLE } = await import('../../build/view/source.js');

const FRAME = 12;

describe('the sample', () => {
  const sample = useSample(useSite({ sample: 'whole' }));

  test('is segmented on load, without a click, and described in words', async () => {
    const { page, faults } = sample;
    assert.match(await text(page, '#headline'), /^[2-9] moving objects$/);
    assert.match(await text(page, '#subline'), /^24 frames of 480 × 270 · computed in \d/);
    const ms = await page.evaluate(() => performance.getEntriesByName('masks')[0].startTime);
    console.log(`from opening the page to the sample's masks: ${(ms / 1000).toFixed(2)} s of page time`);
    const objects = await page.evaluate(() => globalThis.tracecutStudio.result.objects.length);
    assert.ok(objects >= 2, `${objects} objects`);
    await page.evaluate((frame) => globalThis.tracecutStudio.app.timeline.seek(frame), FRAME);
    await screenshot(page, 'sample');
    const excess = await page.evaluate(() => document.documentElement.scrollHeight - innerHeight);
    assert.equal(excess, 0, 'the page is as high as the window');
    assert.deepEqual(faults, []);
  });

  test('moves of objects are told against the scene, not the picture', async () => {
    const { page } = sample;
    const found = await page.evaluate(() => {
      const { segmentation } = globalThis.tracecutStudio.app;
      return [1, 2, 3].map((object) => ({
        ...segmentation.presence.facts(object, segmentation.scene).motion,
        mask: [...segmentation.mask(0)].flatMap((label, p) => (label === object ? [p] : [])),
      }));
    });
    const clip = await synthClip(SAMPLE);
    const truth = motionsOf(clip);
    const said = (await text(page, '#summary')).split(';');
    for (const [k, { x, mask }] of found.entries()) {
      const first = clip.mask(0);
      const count = new Map();
      for (const p of mask) count.set(first[p], (count.get(first[p]) ?? 0) + 1);
      const [[owner]] = [...count].sort(([, a], [, b]) => b - a);
      assert.ok(
        Math.abs(x - truth[owner]) < 0.04,
        `object ${k + 1} moved by ${x} of the width, in truth ${truth[owner]}`,
      );
      if (Math.abs(truth[owner]) > 0.08)
        assert.ok(
          said.some(
            (words) => words.includes(`Object ${k + 1} `) && words.includes(truth[owner] > 0 ? 'right' : 'left'),
          ),
          said.join(';'),
        );
    }
  });

  test('has its objects coloured where the scene has them', async () => {
    const { page } = sample;
    const { counts, masks } = await page.evaluate(paintedPixels, FRAME);
    const total = counts.flat().reduce((sum, n) => sum + n, 0);
    const owners = counts.map((row) => row.indexOf(Math.max(...row)));
    const pure = counts.reduce((sum, row, k) => sum + row[owners[k]], 0);
    assert.ok(total > 1000, `only ${total} painted pixels`);
    assert.ok(pure / total > 0.93, `${((100 * pure) / total).toFixed(1)} % of painted pixels lie in their object`);
    const found = new Set(owners.filter((owner) => owner > 0));
    assert.ok(found.size >= 2, `${found.size} of ${masks - 1} objects have a colour of their own`);
  });

  test('names the object under the pointer, and shows it alone after a click', async () => {
    const { page } = sample;
    await page.evaluate((frame) => globalThis.tracecutStudio.app.timeline.seek(frame), FRAME);
    const place = await page.evaluate(middleOfObject, 1);
    await page.hover('#canvas', { position: place });
    assert.match(await text(page, '#readout'), /^Object 1\b/);
    await page.click('#canvas', { position: place });
    assert.equal(await page.getAttribute('[data-object="1"] .object-main', 'aria-pressed'), 'true');
    await page.hover('#canvas', { position: { x: 3, y: 3 } });
    assert.match(await text(page, '#readout'), /^Background\b/);
    await page.click('#canvas', { position: { x: 3, y: 3 } });
    assert.equal(await page.locator('#show-all').isVisible(), false, 'a click on the background brings all back');
  });

  test('hides an object, and shows one alone', async () => {
    const { page } = sample;
    const colors = () =>
      page.evaluate(paintedPixels, FRAME).then(({ counts }) => counts.map((row) => row.some((n) => n > 0)));
    const all = await colors();
    assert.ok(all.slice(1).every(Boolean));
    await page.click('[data-object="1"] .object-main');
    assert.deepEqual(
      await colors(),
      all.map((_, k) => k === 1),
    );
    await page.click('#show-all');
    await page.uncheck('[data-object="1"] .keep input');
    assert.deepEqual(
      await colors(),
      all.map((_, k) => k > 1),
    );
    await page.click('#show-all');
  });

  test('has the same labels and masks as in Node, to the byte', async () => {
    const { page } = sample;
    const inPage = await page.evaluate(() => {
      const { result } = globalThis.tracecutStudio;
      const masks = Array.from({ length: result.numFrames }, (_, t) => [...result.labels(t)].join(''));
      return { label: [...result.clusters.label], x: [...result.trajectories.x], masks };
    });
    const clip = await synthClip(SAMPLE);
    const session = await createSession();
    for (let t = 0; t < clip.numFrames; t += 1) await session.push(clip.frame(t));
    const result = await session.run();
    session.close();
    assert.deepEqual([...result.clusters.label], inPage.label);
    assert.deepEqual([...result.trajectories.x], inPage.x);
    inPage.masks.forEach((mask, t) => assert.ok(mask === [...result.labels(t)].join(''), `masks of frame ${t} differ`));
  });
});

/**
 * Runs in the page. Draws nothing but the masks of a frame and counts, for each object's colour, in which object of
 * the scene the painted pixels lie.
 */
function paintedPixels(frame) {
  const { app, source, result, objectColor } = globalThis.tracecutStudio;
  const were = app.layers.map((layer) => layer.isOn);
  for (const layer of app.layers) layer.isOn = layer.id === 'masks';
  const { fill } = app.layers.find((layer) => layer.id === 'masks').settings;
  const before = fill.value;
  fill.value = 1;
  app.timeline.seek(frame);
  app.viewer.draw();
  const { canvas } = app.viewer;
  const { data } = canvas.getContext('2d').getImageData(0, 0, canvas.width, canvas.height);
  app.layers.forEach((layer, k) => (layer.isOn = were[k]));
  fill.value = before;
  const mask = source.clip.mask(frame);
  const masks = 1 + mask.reduce((most, value) => Math.max(most, value), 0);
  const colors = Array.from({ length: app.segmentation.count }, (_, k) => Number.parseInt(objectColor(k).slice(1), 16));
  const counts = colors.map(() => new Array(masks).fill(0));
  const scale = result.width / canvas.width;
  for (let y = 0; y < canvas.height; y += 1) {
    for (let x = 0; x < canvas.width; x += 1) {
      const at = 4 * (y * canvas.width + x);
      const object = colors.indexOf((data[at] << 16) | (data[at + 1] << 8) | data[at + 2]);
      if (data[at + 3] < 255 || object < 0) continue;
      counts[object][mask[Math.floor(y * scale) * result.width + Math.floor(x * scale)]] += 1;
    }
  }
  return { counts, masks };
}

/** Runs in the page: the pixel of an object that is nearest to its centre of gravity, in CSS pixels of the canvas. */
function middleOfObject(object) {
  const { segmentation, viewer, timeline } = globalThis.tracecutStudio.app;
  const own = [];
  segmentation
    .mask(timeline.frame)
    .forEach((label, p) => label === object && own.push([p % viewer.view.width, Math.floor(p / viewer.view.width)]));
  const mean = [0, 1].map((axis) => own.reduce((sum, place) => sum + place[axis], 0) / own.length);
  const distance = ([x, y]) => Math.hypot(x - mean[0], y - mean[1]);
  const [x, y] = own.reduce((best, place) => (distance(place) < distance(best) ? place : best));
  return { x: (x + 0.5) / viewer.view.unit, y: (y + 0.5) / viewer.view.unit };
}

/** How far each object of a made clip moves to the right against the scene, in parts of the width. */
function motionsOf(clip) {
  const { width, numFrames, numObjects } = clip;
  const middles = (t) => {
    const mask = clip.mask(t);
    return Array.from({ length: numObjects + 1 }, (_, object) => {
      const columns = [...mask.keys()].filter((p) => mask[p] === object).map((p) => p % width);
      return columns.reduce((sum, x) => sum + x, 0) / columns.length;
    });
  };
  let scene = 0;
  for (let t = 0; t + 1 < numFrames; t += 1) {
    const [{ u }, mask] = [clip.flow(t), clip.mask(t)];
    const steps = [...u].filter((_, p) => mask[p] === 0 && p % 11 === 0).sort((a, b) => a - b);
    scene += steps[steps.length >> 1];
  }
  const [from, to] = [middles(0), middles(numFrames - 1)];
  return from.map((x, object) => (to[object] - x - scene) / width);
}
