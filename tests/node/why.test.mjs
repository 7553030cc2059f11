// Explanations of the labels of pixels, and the agreement of masks.

import assert from 'node:assert/strict';
import { test } from 'node:test';
import { segmentVideo } from 'tracecut';
import { framesOf, ready, rejects } from './support.mjs';

const SCENE = { width: 200, height: 112, frames: 8, seed: 2 };

/** Pixels all over the clip. */
const PLACES = Array.from({ length: 40 }, (_, k) => [k % 8, (k * 37) % 200, (k * 61) % 112]);

test('the explanation of a pixel agrees with the masks, and its sums with their terms', async (t) => {
  const session = await ready(t, {}, await framesOf(SCENE));
  const result = await session.run();
  const visited = new Set();
  for (const [frame, x, y] of PLACES) {
    const why = await result.explain(frame, x, y);
    assert.equal(why.label, result.labels(frame)[y * 200 + x]);
    const superpixels = await result.superpixels(frame);
    assert.equal(why.superpixel, superpixels.label[y * 200 + x]);
    assert.deepEqual(
      why.costs.map(({ label }) => label),
      [...result.clusters.object],
    );
    const own = why.costs[why.cluster];
    assert.equal(why.source === 'superpixel', own.label === why.label);
    for (const cost of why.costs) {
      const links = why.links.filter(({ cluster }) => cluster !== cost.cluster);
      assert.equal(
        cost.total,
        links.reduce((sum, link) => sum + link.cost, cost.trajectories + cost.evidence),
      );
      assert.equal(Math.round(cost.total * 65536), cost.total * 65536, 'whole steps');
      assert.ok(cost.total >= own.total, 'the cut could do better');
      assert.equal(cost.votes, why.voters.filter(({ cluster }) => cluster === cost.cluster).length);
    }
    const others = why.costs.filter(({ label }) => label !== own.label);
    assert.equal(why.flip.margin, Math.min(...others.map(({ total }) => total)) - own.total);
    assert.equal(why.costs[why.flip.cluster].total - own.total, why.flip.margin);
    if (why.border) {
      const { i, j, d } = result.edges(frame);
      const label = (of) => result.clusters.object[result.clusters.label[of]];
      const sought = [own.label, why.costs[why.flip.cluster].label].sort().join();
      const between = [...i.keys()].filter((k) => [label(i[k]), label(j[k])].sort().join() === sought);
      assert.equal(why.border.edges, between.length);
      assert.equal(Math.fround(why.border.d), Math.max(...between.map((k) => d[k])));
    }
    visited.add(why.label);
  }
  assert.ok(visited.size > 1, 'all pixels were of one label: choose other ones');
  await rejects(result.explain(8, 0, 0), 'param', /8 .*0\.\.=7/);
  await rejects(result.explain(0, 200, 0), 'param', /200 .*0\.\.=199/);
  await rejects(result.explain(0, 0, -1), 'param', /-1 .*0\.\.=111/);
});

test('of a reduced clip, places are in input pixels, maps at the working size', async (t) => {
  const session = await ready(t, { clip: { maxSide: 120 } }, await framesOf(SCENE));
  const result = await session.run();
  for (const [frame, x, y] of PLACES) {
    const why = await result.explain(frame, x, y);
    assert.equal(why.label, result.labels(frame)[y * 200 + x]);
    const { label, width, scaleX, scaleY } = await result.superpixels(frame);
    const cell = (place, scale) => Math.floor((place + 0.5) / scale);
    assert.equal(why.superpixel, label[cell(y, scaleY) * width + cell(x, scaleX)]);
    const { startFrame, offset, x: xs, y: ys } = result.trajectories;
    const away = Array.from(startFrame, (begin, i) => {
      const point = offset[i] + frame - begin;
      return begin <= frame && point < offset[i + 1] ? (xs[point] - x) ** 2 + (ys[point] - y) ** 2 : Infinity;
    });
    assert.equal(why.nearest, away.indexOf(Math.min(...away)));
  }
});

test('frames whose masks disagree with nearby frames are doubts', async (t) => {
  const session = await ready(t, {}, await framesOf(SCENE));
  const result = await session.run();
  const { clip, frames, objects } = await result.agreement();
  assert.ok(clip > 0 && clip <= 1 && frames.length === result.numFrames, `${clip}`);
  assert.ok(objects.every((values) => values.length === frames.length));
  const median = [...frames].sort((a, b) => a - b)[frames.length >> 1];
  const isDoubtful = (t) => result.doubts.some(({ from, to }) => from <= t && t < to);
  frames.forEach((value, t) => assert.ok(!(value < 0.7 * median) || isDoubtful(t), `frame ${t}: ${value}`));
});

test('trajectories from outside and a closed session have no reasons', async (t) => {
  const session = await ready(t, { clip: { dense: false } }, await framesOf(SCENE));
  const sparse = await session.run();
  await rejects(sparse.explain(0, 0, 0), 'state', /explanations.*clip\.dense/);
  const dense = await ready(t, {}, await framesOf(SCENE));
  const result = await dense.run();
  dense.close();
  await rejects(result.explain(0, 0, 0), 'closed', /explanations/);
  await rejects(result.agreement(), 'closed', /agreements/);
});

test('a worker and the last window of a clip explain the same as a session in this thread', async (t) => {
  const frames = await framesOf(SCENE);
  const plain = await (await ready(t, {}, frames)).run();
  const result = await (await ready(t, { worker: true }, frames)).run();
  const [why, agreement] = [await plain.explain(3, 90, 50), await plain.agreement()];
  assert.deepEqual(await result.explain(3, 90, 50), why);
  assert.deepEqual(await result.agreement(), agreement);
  const windows = [];
  for await (const window of segmentVideo(frames, { window: 6, overlap: 3 })) {
    windows.push(window);
    if (windows.length < 2) continue;
    assert.equal((await window.explain(2, 90, 50)).label, window.labels(2)[50 * 200 + 90]);
    await rejects(windows[0].explain(2, 90, 50), 'state', /explanations of this window are gone/);
  }
  assert.equal(windows.length, 2);
});

test('after a correction the newest result answers, and says what a stroke forbids', async (t) => {
  const session = await ready(t, {}, await framesOf(SCENE));
  const first = await session.run();
  const [{ label }] = first.objects;
  const at = first.labels(2).indexOf(label);
  const place = [2, at % 200, Math.floor(at / 200)];
  const second = await session.merge(0, label);
  await rejects(first.explain(...place), 'state', /explanations of a result .* corrected since/);
  await rejects(first.agreement(), 'state', /agreements of a result .* corrected since/);
  assert.equal((await second.explain(...place)).label, 0);
  const third = await session.undo();
  assert.equal((await third.explain(...place)).label, label);
  assert.equal((await first.superpixels(2)).width, 200, 'superpixels do not depend on corrections');
});

test('a stroke is reported as the source of its pixels, with the labels it forbids', async (t) => {
  const session = await ready(t, {}, await framesOf(SCENE));
  const first = await session.run();
  const [{ label }] = first.objects;
  const mask = first.labels(2);
  const inside = mask.findIndex((of, k) => of === label && mask[k + 6] === label && mask[k + 6 * 200] === label);
  const [x, y] = [inside % 200, Math.floor(inside / 200)];
  const strokes = [
    { t: 2, points: [x + 3, y + 3], radius: 2 },
    { t: 2, points: [x + 3, y < 20 ? y + 60 : y - 20], radius: 2 },
  ];
  const result = await session.apart(strokes);
  const why = await result.explain(2, x + 3, y + 3);
  assert.equal(why.source, 'stroke');
  assert.ok(why.costs.some(({ forbidden }) => forbidden > 0));
  assert.equal(why.costs[why.cluster].forbidden, 0);
});
