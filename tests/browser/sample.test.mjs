// The sample clip on the page: the objects are found and coloured, each layer shows something of its own, and the
// labels are those that the package gives in Node.

import assert from 'node:assert/strict';
import { describe, test } from 'node:test';
import { createSession, synthClip } from '../../dist/node.js';
import '../page-modules.mjs';
import { layerNames, paintedShare, picture, screenshot, showOnly, text, useSample, useSite } from './support.mjs';

const { SAMPLE } = await import('../../studio/view/source.js');

const FRAME = 12;

describe('the sample', () => {
  const sample = useSample(useSite({ sample: 'whole' }));

  test('is segmented on load, without a click, and described in words', async () => {
    const { page, faults } = sample;
    assert.match(await text(page, '#headline'), /^[2-9] moving objects and the background$/);
    assert.match(await text(page, '#subline'), /trajectories · 24 frames of 480 × 270 · computed in \d/);
    const ms = await page.evaluate(() => performance.getEntriesByName('masks')[0].startTime);
    console.log(`from opening the page to the sample's masks: ${(ms / 1000).toFixed(2)} s of page time`);
    const objects = await page.evaluate(() => globalThis.tracecutDemo.result.objects.length);
    assert.ok(objects >= 2, `${objects} objects`);
    await page.evaluate((frame) => globalThis.tracecutDemo.app.timeline.seek(frame), FRAME);
    await screenshot(page, 'sample');
    assert.deepEqual(faults, []);
  });

  test('moves of objects are told against the scene, not the picture', async () => {
    const { page } = sample;
    const found = await page.evaluate(() => {
      const { points } = globalThis.tracecutDemo.app;
      return [1, 2, 3].map((object) => ({
        ...points.presence.facts(object, points.scene).moved,
        mask: [...points.mask(0)].flatMap((label, p) => (label === object ? [p] : [])),
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
    assert.equal(owners[0], 0, 'grey is the background');
    assert.ok(pure / total > 0.93, `${((100 * pure) / total).toFixed(1)} % of painted pixels lie in their object`);
    const found = new Set(owners.filter((owner) => owner > 0));
    assert.ok(found.size >= 2, `${found.size} of ${masks - 1} objects have a colour of their own`);
  });

  test('says in the readout what saliency, foreground and components are under the pointer', async () => {
    const { page } = sample;
    await page.evaluate((frame) => globalThis.tracecutDemo.app.timeline.seek(frame), FRAME);
    await showOnly(page, 'saliency', 'foreground', 'components');
    await page.hover('#canvas', { position: await page.evaluate(middleOfObject, 1) });
    const words =
      /^Object 1 · trajectory .* · saliency (0\.[5-9]\d|1\.00), trajectory’s \S+, in context \S+ · foreground · component \d of \d$/;
    await page.waitForFunction(() => /saliency/.test(document.querySelector('#readout').textContent));
    assert.match(await text(page, '#readout'), words);
    await page.hover('#canvas', { position: await page.evaluate(middleOfObject, 0) });
    assert.match(await text(page, '#readout'), /^Background · .*saliency 0\.[0-4]/);
    const { width, height } = await page.locator('#canvas').boundingBox();
    await page.hover('#canvas', { position: { x: 0.09 * width, y: 0.8 * height } });
    assert.match(await text(page, '#readout'), /not foreground · no component$/);
  });

  test('has the foreground red where the scene has its objects', async () => {
    const { page } = sample;
    await showOnly(page, 'foreground');
    const [inside, outside] = await page.evaluate(redPixels, FRAME);
    assert.ok(inside > 300, `${inside} red pixels in objects`);
    assert.ok(outside < 0.1 * inside, `${outside} outside`);
  });

  test('gives a component the same colour from frame to frame', async () => {
    const { page } = sample;
    const { changes, steps } = await page.evaluate(colorChanges);
    assert.ok(steps > 1000, `${steps} steps of trajectories in components`);
    assert.ok(changes <= 0.02 * steps, `${changes} of ${steps} change their colour`);
  });

  test('names the object under the pointer, and shows it alone after a click', async () => {
    const { page } = sample;
    await page.evaluate((frame) => globalThis.tracecutDemo.app.timeline.seek(frame), FRAME);
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
    assert.ok(all.every(Boolean));
    await page.click('[data-object="1"] .object-main');
    assert.deepEqual(
      await colors(),
      all.map((_, k) => k === 1),
    );
    await page.click('#show-all');
    await page.click('[data-object="0"] .eye');
    assert.deepEqual(
      await colors(),
      all.map((_, k) => k > 0),
    );
  });

  test('has the same labels, masks, saliency and components as in Node, to the byte', async () => {
    const { page } = sample;
    const inPage = await page.evaluate(() => {
      const { result } = globalThis.tracecutDemo;
      const masks = Array.from({ length: result.numFrames }, (_, t) => [...result.labels(t)].join(''));
      const { saliency, components } = result;
      const salient = [saliency.ofPoints, saliency.inContext, saliency.foreground, components.ofPoint].map((list) => [
        ...list,
      ]);
      return { label: [...result.clusters.label], x: [...result.trajectories.x], masks, salient };
    });
    const clip = await synthClip(SAMPLE);
    const session = await createSession();
    for (let t = 0; t < clip.numFrames; t += 1) await session.push(clip.frame(t));
    const result = await session.run();
    session.close();
    assert.deepEqual([...result.clusters.label], inPage.label);
    assert.deepEqual([...result.trajectories.x], inPage.x);
    const { saliency, components } = result;
    const salient = [saliency.ofPoints, saliency.inContext, saliency.foreground, components.ofPoint].map((list) => [
      ...list,
    ]);
    assert.deepEqual(salient, inPage.salient);
    inPage.masks.forEach((mask, t) => assert.ok(mask === [...result.labels(t)].join(''), `masks of frame ${t} differ`));
  });
});

describe('the layers of a sample', () => {
  const sample = useSample(useSite());

  test('colours have names for any number of objects, none of them twice', async () => {
    const names = await sample.page.evaluate(async () => {
      const { colourName } = await import('/view/result/palette.js');
      return Array.from({ length: 255 }, (_, k) => colourName(k + 1));
    });
    assert.deepEqual(names.slice(0, 8), ['orange', 'light blue', 'pink', 'yellow', 'green', 'red', 'blue', 'purple']);
    assert.equal(new Set(names).size, 255);
    assert.equal(names[9], 'purple 2');
  });

  test('shows something different in each layer', async () => {
    const { page } = sample;
    await page.evaluate((frame) => globalThis.tracecutDemo.app.timeline.seek(frame), FRAME);
    const ids = await layerNames(page);
    assert.deepEqual(ids, [
      'masks',
      'trajectories',
      'superpixels',
      'contours',
      'boundaries',
      'discontinuities',
      'embedding',
      'saliency',
      'foreground',
      'components',
      'flow',
      'background',
      'image',
    ]);
    const pictures = new Map();
    for (const id of ids) {
      await showOnly(page, id);
      // Some layers are fetched or computed when they are first shown.
      await page.waitForFunction(paintedShare);
      const share = await page.evaluate(paintedShare);
      assert.ok(share > 0.002, `${id} paints ${share} of the canvas`);
      pictures.set(await picture(page), id);
      await screenshot(page, `sample-${id}`);
    }
    assert.equal(pictures.size, ids.length, `only ${[...pictures.values()]} differ`);
  });

  test('fades a layer, and shows its outlines without its fill', async () => {
    const { page } = sample;
    await showOnly(page, 'masks');
    const alpha = () => page.evaluate(meanAlpha);
    const setting = (name, value) => page.locator(`[data-setting="masks.${name}"]`).fill(String(value));
    const whole = await alpha();
    await setting('opacity', 0.5);
    const faded = await alpha();
    assert.ok(Math.abs(faded / whole - 0.5) < 0.02, `half of ${whole} is ${faded}`);
    await setting('opacity', 0);
    assert.equal(await alpha(), 0);
    await setting('opacity', 1);
    await setting('fill', 0);
    const lines = await alpha();
    assert.ok(lines > 0 && lines < 0.5 * whole, `outlines ${lines} of ${whole}`);
    await setting('fill', 0.5);
    assert.equal(await alpha(), whole);
  });

  test('changes each layer with its switches, and back', async () => {
    const { page } = sample;
    const switches = [
      ['contours', 'deleted'],
      ['superpixels', 'mean'],
      ['boundaries', 'thin'],
      ['saliency', 'shown'],
      ['saliency', 'context'],
      ['components', 'links'],
    ];
    for (const [id, setting] of switches) {
      await showOnly(page, id);
      await page.waitForFunction(paintedShare);
      const before = await picture(page);
      await page.click(`[data-setting="${id}.${setting}"]`);
      assert.notEqual(await picture(page), before, `${id}.${setting}`);
      await page.click(`[data-setting="${id}.${setting}"]`);
      assert.equal(await picture(page), before, `${id}.${setting} back`);
    }
  });

  test('switches the foreground with its key', async () => {
    const { page } = sample;
    const on = () => page.locator('[data-layer="foreground"]').isChecked();
    await showOnly(page, 'masks');
    await page.keyboard.press('f');
    assert.equal(await on(), true);
    await page.keyboard.press('F');
    assert.equal(await on(), false);
  });
});

/**
 * Runs in the page. Draws nothing but the points of a frame and counts, for each object's colour, in which object of
 * the scene the painted pixels lie.
 */
function paintedPixels(frame) {
  const { app, source, result, objectColor } = globalThis.tracecutDemo;
  const were = app.layers.map((layer) => layer.on);
  for (const layer of app.layers) layer.on = layer.id === 'trajectories';
  app.layers.find((layer) => layer.id === 'trajectories').settings.trail.value = 0;
  app.timeline.seek(frame);
  app.viewer.draw();
  const { canvas } = app.viewer;
  const { data } = canvas.getContext('2d').getImageData(0, 0, canvas.width, canvas.height);
  app.layers.forEach((layer, k) => (layer.on = were[k]));
  const mask = source.clip.mask(frame);
  const masks = 1 + mask.reduce((most, value) => Math.max(most, value), 0);
  const colors = Array.from({ length: app.points.count }, (_, k) => Number.parseInt(objectColor(k).slice(1), 16));
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

/** Runs in the page: the mean opacity of the canvas, 0 to 1. */
function meanAlpha() {
  const { viewer } = globalThis.tracecutDemo.app;
  viewer.draw();
  const { data } = viewer.canvas.getContext('2d').getImageData(0, 0, viewer.canvas.width, viewer.canvas.height);
  let sum = 0;
  for (let at = 3; at < data.length; at += 4) sum += data[at];
  return sum / 255 / (data.length / 4);
}

/** Runs in the page: the pixel of an object that is nearest to its centre of gravity, in CSS pixels of the canvas. */
function middleOfObject(object) {
  const { points, viewer, timeline } = globalThis.tracecutDemo.app;
  const own = [];
  points
    .mask(timeline.frame)
    .forEach((label, p) => label === object && own.push([p % viewer.view.width, Math.floor(p / viewer.view.width)]));
  const mean = [0, 1].map((axis) => own.reduce((sum, place) => sum + place[axis], 0) / own.length);
  const distance = ([x, y]) => Math.hypot(x - mean[0], y - mean[1]);
  const [x, y] = own.reduce((best, place) => (distance(place) < distance(best) ? place : best));
  return { x: (x + 0.5) / viewer.view.unit, y: (y + 0.5) / viewer.view.unit };
}

/** Runs in the page: how many pixels of the red of the foreground lie in objects of the scene, and how many do not. */
function redPixels(frame) {
  const { app, source, result } = globalThis.tracecutDemo;
  app.layers.find((layer) => layer.id === 'foreground').settings.trail.value = 0;
  app.timeline.seek(frame);
  app.viewer.draw();
  const { canvas } = app.viewer;
  const { data } = canvas.getContext('2d').getImageData(0, 0, canvas.width, canvas.height);
  const mask = source.clip.mask(frame);
  const scale = result.width / canvas.width;
  const counts = [0, 0];
  for (let p = 0; 4 * p < data.length; p += 1) {
    if (data[4 * p] < 250 || data[4 * p + 1] !== 0x2b || data[4 * p + 2] !== 0x3d) continue;
    const [x, y] = [p % canvas.width, Math.floor(p / canvas.width)];
    counts[mask[Math.floor(y * scale) * result.width + Math.floor(x * scale)] > 0 ? 0 : 1] += 1;
  }
  return counts;
}

/** Runs in the page: how many steps trajectories take in components, and in how many of them the colour changes. */
async function colorChanges() {
  const { steadyColors } = await import('/view/layers/components.js');
  const { points } = globalThis.tracecutDemo.app;
  const { count, startFrame, offset } = points.result.trajectories;
  const { ofPoint } = points.result.components;
  const colors = steadyColors(points);
  let [changes, steps] = [0, 0];
  for (let i = 0; i < count; i += 1) {
    for (let p = offset[i]; p + 1 < offset[i + 1]; p += 1) {
      if (ofPoint[p] < 0 || ofPoint[p + 1] < 0) continue;
      const t = startFrame[i] + p - offset[i];
      steps += 1;
      if (colors[t][ofPoint[p]] !== colors[t + 1][ofPoint[p + 1]]) changes += 1;
    }
  }
  return { changes, steps };
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
