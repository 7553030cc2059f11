// Corrections by the user, explanations of the labels of pixels, and the agreement of masks.

import assert from 'node:assert/strict';
import { after, test } from 'node:test';
import { createSession, segmentVideo } from 'tracecut';
import { abortAt, each, fingerprint, framesOf, ready, rejects, SMALL } from './support.mjs';

/** Two walkers and more: enough objects to merge. */
const SCENE = { width: 192, height: 108, frames: 10, seed: 4 };

const labelsOf = (objects) => each(objects, 'label');
const highest = ({ objects }) => Math.max(0, ...labelsOf(objects));
const ascending = (a, b) => a - b;

/** All masks, one after the other. */
function masksOf(result) {
  return Buffer.concat(Array.from({ length: result.numFrames }, (_, t) => result.labels(t)));
}

/** Checks that clusters, objects and masks say the same. */
function isConsistent(result) {
  const { clusters, objects } = result;
  assert.equal(clusters.object.length, clusters.count);
  const labels = new Set([0, ...labelsOf(objects)]);
  assert.deepEqual(new Set([0, ...clusters.object]), labels);
  assert.deepEqual(labelsOf(objects), Array.from(labels).sort(ascending).slice(1));
  assert.deepEqual(new Set(clusters.label).size, clusters.count);
  const unknown = masksOf(result).find((label) => !labels.has(label));
  assert.equal(unknown, undefined, 'a mask has a label that no object has');
}

const session = await createSession();
for (const frame of await framesOf(SCENE)) await session.push(frame);
await session.run();
after(() => session.close());

/** The session of the scene without corrections, its newest result, and the masks. */
async function segmented() {
  while (session.corrections > 0) await session.undo();
  const result = await session.run();
  return { session, result, before: masksOf(result) };
}

test('merging renames one object, splitting it again brings both back, undoing restores every byte', async (t) => {
  const { session, result, before } = await segmented();
  assert.ok(highest(result) >= 2, `${highest(result)} objects`);
  assert.equal(session.corrections, 0);

  const merged = await session.merge(1, 2);
  isConsistent(merged);
  const renamed = before.map((label) => (label === 2 ? 1 : label));
  assert.deepEqual(masksOf(merged), renamed);
  assert.ok(!labelsOf(merged.objects).includes(2));
  assert.equal(session.corrections, 1);
  assert.deepEqual(masksOf(result), before, 'the result before stays');

  const stages = new Set();
  const split = await session.split(1, undefined, { onProgress: ({ stage }) => stages.add(stage) });
  isConsistent(split);
  assert.deepEqual(labelsOf(split.objects), labelsOf(result.objects));
  assert.deepEqual([...stages], ['cut', 'masks'], 'nothing else is computed again');
  for (const [p, label] of masksOf(split).entries()) {
    const isMeant = label === before[p] || (label < 3 && before[p] > 0 && before[p] < 3);
    assert.ok(isMeant, `pixel ${p}: ${before[p]} became ${label}`);
  }

  assert.deepEqual(masksOf(await session.undo()), masksOf(merged));
  assert.deepEqual(masksOf(await session.undo()), before);
  assert.equal(session.corrections, 0);
  await rejects(session.undo(), 'state', /no correction/);
});

test('an object of one cluster parts in two, the part at the point gets the lowest free label', async (t) => {
  const { session, result, before } = await segmented();
  const pixel = result.labels(6).indexOf(1);
  const at = { t: 6, x: pixel % SCENE.width, y: Math.floor(pixel / SCENE.width) };
  const split = await session.split(1, at);
  isConsistent(split);
  const fresh = highest(result) + 1;
  assert.deepEqual(labelsOf(split.objects), [...labelsOf(result.objects), fresh]);
  const after = masksOf(split);
  assert.ok(after.includes(1) && after.includes(fresh));
  const changedElsewhere = after.filter((label, p) => label !== before[p] && before[p] !== 1);
  assert.equal(changedElsewhere.length, 0, 'only pixels of the object change');
  assert.deepEqual(masksOf(await session.undo()), before);
  assert.deepEqual(masksOf(await session.split(1, at)), after, 'the same correction gives the same masks');
});

test('a region of the background becomes an object', async (t) => {
  const { session, result, before } = await segmented();
  const split = await session.split(0, { t: 3, x: 20, y: SCENE.height - 20 });
  isConsistent(split);
  const fresh = highest(result) + 1;
  assert.ok(labelsOf(split.objects).includes(fresh));
  assert.ok(masksOf(split).every((label, p) => label === before[p] || before[p] === 0));
});

test('a correction that is aborted stays in force until it is finished or undone', async (t) => {
  const { session, result } = await segmented();
  const splitMasks = masksOf(await session.split(1));
  await session.undo();
  const reason = new Error('enough');
  const stop = abortAt({ reason });
  await assert.rejects(session.split(1, undefined, stop), (error) => error === reason);
  assert.equal(session.corrections, 1);
  await rejects(session.merge(1, 2), 'state', /run the session first/);
  assert.deepEqual(masksOf(await session.run()), splitMasks);
  await session.undo();
  const late = session.split(1, undefined, { ...stop, signal: AbortSignal.abort(reason) });
  await assert.rejects(late, (error) => error === reason);
  assert.equal(session.corrections, 0, 'aborted before anything was done');
  assert.deepEqual(masksOf(await session.run()), masksOf(result));
});

test('corrections that cannot be are refused, and nothing changes', async (t) => {
  const session = await ready(t);
  await rejects(session.merge(0, 1), 'state', /run the session first/);
  await rejects(session.undo(), 'state', /no correction/);
  const result = await session.run();
  const n = highest(result);
  const at = { t: 0, x: 1, y: 1 };
  await rejects(session.merge(1, 0), 'param', /the background cannot be merged/);
  await rejects(session.merge(1, 1), 'param', /another label/);
  await rejects(session.merge(n + 1, 1), 'param', /labels in use: 0, 1/);
  await rejects(session.merge(0, n + 1), 'param', /labels in use/);
  for (const label of [-1, 0.5, 256, NaN, '1', undefined]) {
    await rejects(session.merge(label, 1), 'param', /^a = /);
    await rejects(session.merge(0, label), 'param', /^b = /);
    await rejects(session.split(label), 'param', /^label = /);
  }
  await rejects(session.split(0), 'param', /place/);
  await rejects(session.split(n + 1), 'param', /labels in use/);
  for (const [wrong, name] of [
    [{ t: SMALL.frames }, 'at.t'],
    [{ t: -1 }, 'at.t'],
    [{ x: NaN }, 'x'],
    [{ x: SMALL.width }, 'x'],
    [{ y: -1 }, 'y'],
    [{ y: '3' }, 'at'],
  ]) {
    await rejects(session.split(1, { ...at, ...wrong }), 'param', new RegExp(`^${name} = `));
  }
  await rejects(session.split(1, null), 'param', /^at = /);
  await rejects(session.merge(0, 1, { onProgress: 3 }), 'param', /onProgress/);
  const first = session.merge(0, 1);
  await rejects(session.merge(0, 2), 'busy');
  await first;
  assert.equal(session.corrections, 1);
  await session.clear();
  assert.equal(session.corrections, 0);
});

/** The labels of the pixels that the middle of a stroke goes through. */
function labelsUnder(result, { t, points }) {
  const mask = result.labels(t);
  const foundLabels = new Set();
  for (let k = 0; k + 1 < points.length; k += 2) {
    const [x0, y0, x1 = x0, y1 = y0] = [points[k], points[k + 1], points[k + 2], points[k + 3]];
    for (let step = 0; step <= 100; step += 1) {
      const [x, y] = [x0 + ((x1 - x0) * step) / 100, y0 + ((y1 - y0) * step) / 100].map(Math.round);
      if (x >= 0 && y >= 0 && x < result.width && y < result.height) foundLabels.add(mask[y * result.width + x]);
    }
  }
  return [...foundLabels];
}

/** A place in frame `t` with the same label all around. */
function insideOf(result, t, label, radius = 8) {
  const { width, height } = result;
  const mask = result.labels(t);
  for (let y = radius; y < height - radius; y += 1) {
    for (let x = radius; x < width - radius; x += 1) {
      let isWhole = true;
      for (let v = y - radius; isWhole && v <= y + radius; v += 1) {
        for (let u = x - radius; isWhole && u <= x + radius; u += 1) isWhole = mask[v * width + u] === label;
      }
      if (isWhole) return { x, y };
    }
  }
  throw new Error(`label ${label} is nowhere ${2 * radius} pixels wide in frame ${t}`);
}

test('strokes split an object, joining strokes merge it again, and the mask follows them along their middle', async (t) => {
  const { session, result, before } = await segmented();
  const { x, y } = insideOf(result, 6, 1);
  const strokes = [
    { t: 6, points: [x - 6, y - 4, x - 6, y + 4], radius: 3 },
    { t: 6, points: new Float32Array([x + 6, y - 4, x + 6, y + 4]), radius: 3 },
  ];
  const separated = await session.apart(strokes);
  isConsistent(separated);
  const [leftLabels, right] = strokes.map((stroke) => labelsUnder(separated, stroke));
  assert.deepEqual([leftLabels, right].flat().sort(ascending), [1, highest(result) + 1]);
  const changedElsewhere = masksOf(separated).filter((label, p) => label !== before[p] && before[p] !== 1);
  assert.equal(changedElsewhere.length, 0, 'nothing but the object changes');

  const together = await session.together([strokes[0], { ...strokes[1], t: 6 }]);
  isConsistent(together);
  for (const stroke of strokes) assert.deepEqual(labelsUnder(together, stroke), [1]);
  assert.deepEqual(labelsOf(together.objects), labelsOf(result.objects));
  assert.equal(session.corrections, 2);
  assert.deepEqual(masksOf(await session.undo()), masksOf(separated));
  assert.deepEqual(masksOf(await session.undo()), before);
});

test('a stroke from an object into the background adds the region there to the object, even across the frame border', async (t) => {
  const { session, result } = await segmented();
  const from = insideOf(result, 3, 1);
  const stroke = { t: 3, points: [from.x, from.y, from.x, -500], radius: 4 };
  assert.ok(labelsUnder(result, stroke).includes(0));
  const together = await session.together([stroke]);
  isConsistent(together);
  const label = Math.min(...labelsUnder(result, stroke).filter((l) => l > 0));
  assert.deepEqual(labelsUnder(together, stroke), [label]);
});

test('strokes that cannot be are refused, and nothing changes', async (t) => {
  const { session, result } = await segmented();
  const good = { t: 0, points: [3, 3, 9, 9], radius: 4 };
  for (const strokes of [undefined, null, 3, [], new Array(256).fill(good)]) {
    await rejects(session.together(strokes), 'param', /^strokes = /);
  }
  await rejects(session.apart([good]), 'param', /^strokes = a list of 1 /);
  const wrong = [
    [null, /^strokes\[1\] = null/],
    [{ ...good, t: SCENE.frames }, /^strokes\[1\].t = 10/],
    [{ ...good, t: 0.5 }, /^strokes\[1\].t/],
    [{ ...good, radius: -1 }, /^strokes\[1\].radius = -1/],
    [{ ...good, radius: NaN }, /^strokes\[1\].radius = NaN/],
    [{ ...good, radius: undefined }, /^strokes\[1\] = .* numbers/],
    [{ ...good, points: [] }, /^strokes\[1\].points = 0 points/],
    [{ ...good, points: undefined }, /^strokes\[1\].points = 0 points/],
    [{ ...good, points: [1, 2, 3] }, /^strokes\[1\] = .* x0, y0, x1, y1/],
    [{ ...good, points: ['1', '2'] }, /^strokes\[1\] = .* numbers/],
    [{ ...good, points: [1, NaN] }, /^strokes\[1\].points\[0\] = \(1, NaN\)/],
    [{ ...good, points: [1, 1, Infinity, 2] }, /^strokes\[1\].points\[1\] = \(inf, 2\)/],
    [{ ...good, points: [-9, 4, 5, 1000] }, /all outside/],
  ];
  for (const [stroke, message] of wrong) {
    await rejects(session.together([good, stroke]), 'param', message);
    await rejects(session.apart([good, stroke]), 'param', message);
  }
  const sky = insideOf(result, 0, 0);
  await rejects(session.together([{ t: 0, points: [sky.x, sky.y], radius: 1 }]), 'data', /over no object/);
  assert.equal(session.corrections, 0);
  assert.deepEqual(masksOf(await session.run()), masksOf(result));
});

test('a clip corrected in the same way twice has the same masks', async (t) => {
  const prints = [];
  for (const { session } of [await segmented(), { session: await ready(t, {}, await framesOf(SCENE)) }]) {
    await session.run();
    await session.merge(1, 2);
    prints.push(fingerprint(await session.split(0, { t: 0, x: 10, y: 10 })));
  }
  assert.equal(prints[0], prints[1]);
});

/** Pixels all over the clip. */
const PLACES = Array.from({ length: 40 }, (_, k) => [
  k % SCENE.frames,
  (k * 37) % SCENE.width,
  (k * 61) % SCENE.height,
]);

test('the explanation of a pixel agrees with the masks, and its sums with their terms', async (t) => {
  const { result } = await segmented();
  const visited = new Set();
  for (const [frame, x, y] of PLACES) {
    const explanation = await result.explain(frame, x, y);
    assert.equal(explanation.label, result.labels(frame)[y * SCENE.width + x]);
    const superpixels = await result.superpixels(frame);
    assert.equal(explanation.superpixel, superpixels.label[y * SCENE.width + x]);
    assert.deepEqual(labelsOf(explanation.costs), [...result.clusters.object]);
    const ownCost = explanation.costs[explanation.cluster];
    assert.equal(explanation.source === 'superpixel', ownCost.label === explanation.label);
    for (const cost of explanation.costs) {
      const links = explanation.links.filter(({ cluster }) => cluster !== cost.cluster);
      assert.equal(
        cost.total,
        links.reduce((sum, link) => sum + link.cost, cost.trajectories + cost.evidence),
      );
      assert.equal(Math.round(cost.total * 65536), cost.total * 65536, 'whole steps');
      assert.ok(cost.total >= ownCost.total, 'the cut could do better');
      assert.equal(cost.votes, explanation.voters.filter(({ cluster }) => cluster === cost.cluster).length);
    }
    const otherCosts = explanation.costs.filter(({ label }) => label !== ownCost.label);
    assert.equal(explanation.flip.margin, Math.min(...otherCosts.map(({ total }) => total)) - ownCost.total);
    assert.equal(explanation.costs[explanation.flip.cluster].total - ownCost.total, explanation.flip.margin);
    if (explanation.border) {
      const { i, j, d } = result.edges(frame);
      const labelOf = (trajectory) => result.clusters.object[result.clusters.label[trajectory]];
      const labels = [ownCost.label, explanation.costs[explanation.flip.cluster].label].sort().join();
      const between = [...i.keys()].filter((k) => [labelOf(i[k]), labelOf(j[k])].sort().join() === labels);
      assert.equal(explanation.border.edges, between.length);
      assert.equal(Math.fround(explanation.border.d), Math.max(...between.map((k) => d[k])));
    }
    visited.add(explanation.label);
  }
  assert.ok(visited.size > 1, 'all pixels were of one label: choose other ones');
  await rejects(result.explain(SCENE.frames, 0, 0), 'param', /10 .*0\.\.=9/);
  await rejects(result.explain(0, SCENE.width, 0), 'param', /192 .*0\.\.=191/);
  await rejects(result.explain(0, 0, -1), 'param', /-1 .*0\.\.=107/);
});

test('of a reduced clip, places are in input pixels, maps at the working size; a closed session has no reasons', async (t) => {
  const session = await ready(t, { clip: { maxSide: 120 } }, await framesOf(SCENE));
  const result = await session.run();
  for (const [frame, x, y] of PLACES) {
    const explanation = await result.explain(frame, x, y);
    assert.equal(explanation.label, result.labels(frame)[y * SCENE.width + x]);
    const { label, width, scaleX, scaleY } = await result.superpixels(frame);
    const cell = (place, scale) => Math.floor((place + 0.5) / scale);
    assert.equal(explanation.superpixel, label[cell(y, scaleY) * width + cell(x, scaleX)]);
    const { startFrame, offset, x: xs, y: ys } = result.trajectories;
    const distances = Array.from(startFrame, (begin, i) => {
      const point = offset[i] + frame - begin;
      return begin <= frame && point < offset[i + 1] ? (xs[point] - x) ** 2 + (ys[point] - y) ** 2 : Infinity;
    });
    assert.equal(explanation.nearest, distances.indexOf(Math.min(...distances)));
  }
  session.close();
  await rejects(result.explain(0, 0, 0), 'closed', /explanations/);
  await rejects(result.agreement(), 'closed', /agreements/);
});

test('frames have an agreement, and doubts are ranges of them', async (t) => {
  const { result } = await segmented();
  const { clip, frames, objects } = await result.agreement();
  assert.ok(clip > 0 && clip <= 1 && frames.length === result.numFrames, `${clip}`);
  assert.ok(objects.every((values) => values.length === frames.length));
  const ends = result.doubts.flatMap(({ from, to }) => [from, to]);
  assert.ok(
    ends.every((end, k) => end > (ends[k - 1] ?? -1) && end <= result.numFrames),
    `${ends}`,
  );
});

test('a worker and the last window of a clip explain the same as a session in this thread', async (t) => {
  const frames = await framesOf(SCENE);
  const { result: plain } = await segmented();
  const result = await (await ready(t, { worker: true }, frames)).run();
  const [explanation, agreement] = [await plain.explain(3, 90, 50), await plain.agreement()];
  assert.deepEqual(await result.explain(3, 90, 50), explanation);
  assert.deepEqual(await result.agreement(), agreement);
  const windows = [];
  for await (const window of segmentVideo(frames, { window: 7, overlap: 4 })) {
    windows.push(window);
    if (windows.length < 2) continue;
    assert.equal((await window.explain(2, 90, 50)).label, window.labels(2)[50 * SCENE.width + 90]);
    await rejects(windows[0].explain(2, 90, 50), 'state', /explanations of this window are gone/);
  }
  assert.equal(windows.length, 2);
});

test('after a correction the newest result answers, and says what a stroke forbids', async (t) => {
  const { session, result: first } = await segmented();
  const [{ label }] = first.objects;
  const at = first.labels(2).indexOf(label);
  const place = [2, at % SCENE.width, Math.floor(at / SCENE.width)];
  const second = await session.merge(0, label);
  await rejects(first.explain(...place), 'state', /explanations of a result .* corrected since/);
  await rejects(first.agreement(), 'state', /agreements of a result .* corrected since/);
  assert.equal((await second.explain(...place)).label, 0);
  const third = await session.undo();
  assert.equal((await third.explain(...place)).label, label);
  assert.equal((await first.superpixels(2)).width, SCENE.width, 'superpixels do not depend on corrections');
});

test('a stroke is reported as the source of its pixels, with the labels it forbids', async (t) => {
  const { session, result: first } = await segmented();
  const [{ label }] = first.objects;
  const mask = first.labels(2);
  const inside = mask.findIndex(
    (value, k) => value === label && mask[k + 6] === label && mask[k + 6 * SCENE.width] === label,
  );
  const [x, y] = [inside % SCENE.width, Math.floor(inside / SCENE.width)];
  const strokes = [
    { t: 2, points: [x + 3, y + 3], radius: 2 },
    { t: 2, points: [x + 3, y < 20 ? y + 60 : y - 20], radius: 2 },
  ];
  const result = await session.apart(strokes);
  const explanation = await result.explain(2, x + 3, y + 3);
  assert.equal(explanation.source, 'stroke');
  assert.ok(explanation.costs.some(({ forbidden }) => forbidden > 0));
  assert.equal(explanation.costs[explanation.cluster].forbidden, 0);
});
