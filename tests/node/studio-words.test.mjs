// What the studio says and offers: colours, times, settings, sizes, the part of a clip that is taken, what to try next.

import assert from 'node:assert/strict';
import { test } from 'node:test';
import { parameters } from 'tracecut';
import { clipFacts, lastOf, partWords, takeText, wantedTake } from '../../build/model/clip-words.js';
import { durationOf, sizesOf } from '../../build/model/export-size.js';
import { colourName } from '../../build/model/palette.js';
import { linkOf, readLink } from '../../build/model/recipe.js';
import { ESSENTIALS, Settings, optionsOf } from '../../build/model/settings.js';
import { fitTake, usualTake } from '../../build/model/source.js';
import { Countdown, StageClock, timeLeft } from '../../build/model/stage-clock.js';
import { Store } from '../../build/model/store.js';
import { TimeLeft } from '../../build/model/time-left.js';
import { triesOf, whereWords } from '../../build/model/tries.js';
import { PageError, count, explain, percent, remaining } from '../../build/model/words.js';
import { MOST, Zoom } from '../../build/model/zoom.js';

const VIDEO = { kind: 'video', name: 'a.mp4', width: 1920, height: 1080, fps: 25, count: 100 };

test('colours have names for any number of objects, none of them twice', () => {
  const names = Array.from({ length: 255 }, (_, k) => colourName(k + 1));
  assert.deepEqual(names.slice(0, 8), ['orange', 'light blue', 'pink', 'yellow', 'green', 'red', 'blue', 'purple']);
  assert.equal(new Set(names).size, 255);
  assert.equal(names[9], 'purple 2');
});

test('a place stays where it is while it is enlarged, and nothing beyond the clip is shown', () => {
  const zoom = new Zoom();
  let state = 7;
  const random = () => (state = (Math.imul(state, 1103515245) + 12345) >>> 0) / 2 ** 32;
  for (let k = 0; k < 2000; k += 1) {
    const [u, v, by] = [random(), random(), zoom.by * (0.5 + random())];
    const before = [zoom.x + u / zoom.by, zoom.y + v / zoom.by];
    if (k % 3 === 2) zoom.move(u - 0.5, v - 0.5);
    else zoom.to(by, u, v);
    const after = [zoom.x + u / zoom.by, zoom.y + v / zoom.by];
    const slack = 1e-9;
    assert.ok(zoom.by >= 1 && zoom.by <= MOST);
    for (const axis of ['x', 'y']) assert.ok(zoom[axis] >= 0 && zoom[axis] + 1 / zoom.by <= 1 + slack);
    const atRim = [zoom.x, zoom.y].some((at) => at < slack || at > 1 - 1 / zoom.by - slack);
    if (k % 3 !== 2 && !atRim) after.forEach((at, axis) => assert.ok(Math.abs(at - before[axis]) < slack));
  }
  zoom.reset();
  assert.deepEqual([zoom.by, zoom.x, zoom.y], [1, 0, 0]);
});

const plan = [
  { id: 'a', share: 0.5 },
  { id: 'b', share: 0.25 },
  { id: 'c', share: 0.25 },
];
const clock = (...states) => {
  const made = new StageClock(plan);
  states.forEach((state, k) => Object.assign(made.stages[k], state));
  return made;
};

test('time left: says nothing before anything is through', () => {
  assert.equal(timeLeft(clock(), 0), null);
  assert.equal(timeLeft(clock({ done: 1, total: 100, ms: 50 }), 0), null);
});

test('time left: takes a stage by its own pace, later ones by their shares', () => {
  const guess = timeLeft(clock({ done: 10, total: 20, ms: 1000 }), 0);
  assert.equal(guess, 1000 + 1000 + 1000);
  assert.equal(
    timeLeft(clock({ done: 20, total: 20, ms: 2000 }, { done: 1, total: 1, ms: 500 }), 0),
    (2500 / 0.75) * 0.25,
  );
});

test('time left: is over when all is through', () => {
  const all = clock(...plan.map(() => ({ done: 1, total: 1, ms: 10 })));
  assert.equal(timeLeft(all, 0), 0);
});

test('time left: what is shown goes down with the clock and follows new guesses slowly', () => {
  const shown = new Countdown();
  assert.equal(shown.follow(10_000, 0), 10_000);
  assert.equal(shown.follow(9_900, 100), 9_900);
  const jumped = shown.follow(20_000, 200);
  assert.ok(jumped > 9_800 && jumped < 11_000, jumped);
  assert.equal(shown.follow(null, 300), null);
});

test('time left: of saving is told after two seconds, from the pace of the frames', () => {
  const left = new TimeLeft(0);
  assert.equal(left.after({ done: 1, total: 10 }, 1000), null);
  assert.equal(left.after({ done: 3, total: 10 }, 2500), 5250);
  assert.equal(left.after({ done: 0, total: 10 }, 2600), null, 'other work begins');
});

test('settings name parameters that there are, take what is legal, and make options of what counts', () => {
  const all = parameters();
  const store = new Store();
  const settings = new Settings(store, all);
  for (const { name, range } of ESSENTIALS) {
    const { min, max } = all.find((one) => one.name === name);
    assert.ok(range[0] >= min && range[1] <= max, name);
  }
  assert.equal(settings.set('cut.spatialWeight', -1), false);
  assert.equal(settings.set('no.such', 1), false);
  assert.equal(settings.set('trajectory.gridStep', 12), true);
  assert.equal(settings.set('superpixel.mergeThreshold', 5), true);
  const { changed } = store.state;
  assert.deepEqual(optionsOf({ changed, source: VIDEO }), {
    superpixel: { mergeThreshold: 5 },
    trajectory: { gridStep: 12 },
  });
  assert.deepEqual(optionsOf({ changed, source: { ...VIDEO, kind: 'still' } }), { superpixel: { mergeThreshold: 5 } });
  settings.set('trajectory.gridStep', all.find(({ name }) => name === 'trajectory.gridStep').default);
  assert.deepEqual([...store.state.changed.keys()], ['superpixel.mergeThreshold'], 'a default is no change');
});

test('a link carries settings; masks cannot be left out by one', () => {
  const store = new Store();
  const settings = new Settings(store, parameters());
  readLink(settings, '#flow.smoothness=40&cut.spatialWeight=3&clip.dense=false&cut.no=1&affinity.noiseFloor=');
  assert.deepEqual(Object.fromEntries(store.state.changed), { 'flow.smoothness': 40, 'cut.spatialWeight': 3 });
  const link = linkOf(store.state.changed, 'https://host/page/#old');
  assert.equal(link, 'https://host/page/#cut.spatialWeight=3&flow.smoothness=40');
  assert.equal(linkOf(new Map(), 'https://host/page/#old'), 'https://host/page/');
});

test('the part of a clip that is taken lies within it, and is put into words', () => {
  const take = usualTake(VIDEO);
  assert.deepEqual(take, { start: 0, frames: 100, step: 1, side: 480 });
  assert.deepEqual(fitTake({ ...take, start: 200, step: 3 }, VIDEO), { start: 98, frames: 1, step: 3, side: 480 });
  assert.equal(lastOf({ ...take, start: 10, frames: 4, step: 5 }), 25);
  const typed = { start: 40, frames: 50, step: 1, side: 320 };
  assert.equal(wantedTake(typed, take, VIDEO, false).frames, 100, 'to the end, as before');
  assert.equal(wantedTake(typed, take, VIDEO, true).frames, 50);
  assert.equal(wantedTake({ ...typed, frames: NaN }, take, VIDEO, true).frames, 2);
  assert.equal(takeText(VIDEO, { ...take, frames: 50 }, 0), '50 frames of 480 × 270, 0.0\u00a0s to 2.0\u00a0s.');
  assert.match(
    takeText(VIDEO, take, 1e-3),
    /About 13\u00a0s on this computer\. More than 50 frames are taken in windows/,
  );
  assert.equal(clipFacts(VIDEO), '1920 × 1080, 4.0 s at 25 fps');
  assert.equal(partWords(VIDEO, 25, 50), '1.0–2.0\u00a0s of 4.0\u00a0s');
  assert.equal(partWords({ ...VIDEO, kind: 'images' }, 6, 29), 'images 7–30 of 100');
});

test('results are saved at sizes of the source, each once, and last as long as their frames', () => {
  const names = (source, working) => sizesOf(source, working).map(({ name, side }) => `${name} ${side}`);
  assert.deepEqual(names(VIDEO, { width: 480, height: 270 }), ['source 1920', 'half 960', 'working 480', 'own 1920']);
  const small = { width: 480, height: 270 };
  assert.deepEqual(names({ ...VIDEO, ...small }, small), ['source 480', 'half 240', 'own 480']);
  assert.equal(durationOf({ numFrames: 3, times: [1, 2, 4], end: 5 }, 25), 4);
  assert.equal(durationOf({ numFrames: 3, times: [1, 2, 4] }, 25), 5);
  assert.equal(durationOf({ numFrames: 50, times: null }, 25), 2);
});

test('where nothing was found, only what can change that is offered', () => {
  const report = { numFrames: 30, trajectories: 200, coverage: 0.9, speed: 2, cameraMoves: true, motions: [1] };
  assert.equal(
    whereWords(report),
    'Followed 200 points over 90\u00a0% of the picture, through 30 frames; the camera moves, about 2.0 px a frame. All points move alike: they were taken as background.',
  );
  assert.match(whereWords({ ...report, trajectories: 0 }), /no point to follow/);
  const state = (take, source = VIDEO) => ({ source, job: { take }, changed: new Map() });
  const ids = (...given) => triesOf(...given).map(({ id }) => id);
  const whole = { start: 0, frames: 100, step: 1, side: 480 };
  assert.deepEqual(ids(state(whole), report), ['step', 'side']);
  assert.deepEqual(ids(state({ ...whole, frames: 20, side: 640 }), { coverage: 0.2 }), ['whole', 'weak']);
  assert.deepEqual(ids(state(whole, { ...VIDEO, kind: 'sample' }), report), []);
  const [{ patch }] = triesOf(state(whole), report);
  assert.deepEqual(patch.take, { start: 0, frames: 50, step: 2, side: 480 });
});

test('errors say what to do, in terms of what the browser plays; numbers read easily', () => {
  assert.match(explain(new PageError('codec')).advice, /MP4/);
  assert.doesNotMatch(explain(new PageError('codec'), false).advice, /MP4/);
  assert.equal(explain(new RangeError('x')).code, 'memory');
  assert.equal(explain('odd').code, 'unknown');
  assert.deepEqual([count(1234567), percent(0.004), percent(0.62)], ['1\u202f234\u202f567', '0.4\u00a0%', '62\u00a0%']);
  assert.deepEqual([remaining(1000), remaining(33_000)], ['almost done', 'about 35\u00a0s left']);
});
