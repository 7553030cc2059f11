// Painting in the studio: things are added, painted, wiped away and parted, in all windows of a clip.

import assert from 'node:assert/strict';
import { test } from 'node:test';
import { Brush, NEW_OBJECT } from '../../build/model/brush.js';
import { showCorrected } from '../../build/model/show-result.js';
import { movingFrames } from '../moving.mjs';
import { CLIP, openModel } from './studio.mjs';

test('in a clip of three windows things are added, painted and parted, and each step is undone', async () => {
  const { app, store } = await openModel(movingFrames(110, [96, 64]));
  await app.openFiles([CLIP]);
  assert.match(store.state.subline, /in 3 windows/);
  const { corrections } = store.state.job;
  const told = [];
  let [object, sizes] = [NEW_OBJECT, []];
  const brush = new Brush({
    store,
    corrector: () => corrections,
    object: () => object,
    choose: (chosen) => (object = chosen),
    carries: () => true,
    tellCarrying() {},
    tellSizes: (...both) => (sizes = both),
    show: (frames) => showCorrected(store, frames),
    tell: (text) => told.push(text),
  });
  const masks = () => Array.from({ length: 110 }, (_, t) => store.state.found.points.mask(t).join('')).join('|');
  const labelAt = (t, x, y) => store.state.found.points.objectAt(t, x, y);
  const change = async (promise) => showCorrected(store, await promise);
  const before = masks();

  store.set({ frame: 55 });
  await brush.add({ x: 76, y: 14 }, 0, false);
  await brush.working;
  assert.equal(told.at(-1), 'In 110 frames, 1 to 110.');
  assert.equal(labelAt(55, 76, 14), object);
  for (const t of [0, 30, 109]) assert.equal(labelAt(t, 76, 14), object, `frame ${t}`);
  const added = masks();
  if (sizes[1]) {
    await brush.resize(1);
    await brush.working;
    assert.notEqual(masks(), added);
    await brush.resize(-1);
    await brush.working;
    assert.equal(masks(), added, 'another size is no step of its own');
    assert.equal(corrections.count(), 1);
  }

  brush.stroke({ t: 55, points: [66, 14, 70, 14], radius: 3 }, 'paint');
  await brush.working;
  const painted = masks();
  for (const _ of [0, 1]) await change(corrections.undo());
  assert.equal(masks(), before);
  for (const _ of [0, 1]) await change(corrections.redo());
  assert.equal(masks(), painted);

  // The square is taken apart by two strokes, in all windows; and put together again.
  const halves = (t, left) => [labelAt(t, left + 4, 38), labelAt(t, left + 22, 38)];
  const [whole] = halves(55, 35);
  const line = (x) => ({ t: 55, points: [x, 30, x, 46], radius: 2 });
  await change(corrections.apart([line(39), line(57)]));
  const [one, other] = halves(55, 35);
  assert.ok(one === whole && other > 0 && other !== one, `${one} and ${other}`);
  for (const [t, left] of [
    [50, 40],
    [70, 20],
    [100, 30],
  ])
    assert.deepEqual(halves(t, left), [one, other], `frame ${t}`);
  const apart = masks();
  await change(corrections.together([line(39), line(57)]));
  assert.deepEqual(halves(100, 30), [one, one]);
  await change(corrections.undo());
  assert.equal(masks(), apart);

  object = one;
  brush.stroke({ t: 55, points: [39, 30, 39, 46], radius: 2 }, 'erase');
  await brush.working;
  assert.equal(labelAt(55, 39, 38), 0);
  while (corrections.count() > 0) await change(corrections.undo());
  assert.equal(masks(), before);
});
