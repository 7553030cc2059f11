// Texts and small computations of the studio's model: colours, zoom, settings, trims, sizes, suggestions and errors.

import assert from 'node:assert/strict';
import { test } from 'node:test';
import { parameters } from 'tracecut';
import { describeClip, lastFrame, describePart, describeTrim, trimFromInputs } from '../../build/model/clip-text.js';
import { computeDuration, exportSizes } from '../../build/model/export-text.js';
import { colourName } from '../../build/model/palette.js';
import { settingsLink, readLink } from '../../build/model/recipe.js';
import { SETTING_CHOICES, Settings, otherChanges, sessionOptions } from '../../build/model/settings.js';
import { clampTrim, defaultTrim } from '../../build/model/source.js';
import { Store } from '../../build/model/store.js';
import { suggestChanges, describeSearch } from '../../build/model/suggestions.js';
import { PageError, explain, formatCount, formatPercent, formatTimeLeft } from '../../build/model/messages.js';
import { MAX_SCALE, Zoom } from '../../build/model/zoom.js';

const VIDEO = { kind: 'video', name: 'a.mp4', width: 1920, height: 1080, fps: 25, count: 100 };

test('colours have unique names for any number of objects', () => {
  const names = Array.from({ length: 255 }, (_, k) => colourName(k + 1));
  assert.deepEqual(names.slice(0, 8), ['orange', 'light blue', 'pink', 'yellow', 'green', 'red', 'blue', 'purple']);
  assert.equal(new Set(names).size, 255);
  assert.equal(names[9], 'purple 2');
});

test('zoom keeps the place at the pointer, and shows nothing outside of the clip', () => {
  const zoom = new Zoom();
  let state = 7;
  const random = () => (state = (Math.imul(state, 1103515245) + 12345) >>> 0) / 2 ** 32;
  for (let k = 0; k < 2000; k += 1) {
    const [u, v, by] = [random(), random(), zoom.scale * (0.5 + random())];
    const before = [zoom.x + u / zoom.scale, zoom.y + v / zoom.scale];
    if (k % 3 === 2) zoom.pan(u - 0.5, v - 0.5);
    else zoom.zoomTo(by, u, v);
    const after = [zoom.x + u / zoom.scale, zoom.y + v / zoom.scale];
    const slack = 1e-9;
    assert.ok(zoom.scale >= 1 && zoom.scale <= MAX_SCALE);
    for (const axis of ['x', 'y']) assert.ok(zoom[axis] >= 0 && zoom[axis] + 1 / zoom.scale <= 1 + slack);
    const isAtBorder = [zoom.x, zoom.y].some((at) => at < slack || at > 1 - 1 / zoom.scale - slack);
    if (k % 3 !== 2 && !isAtBorder) after.forEach((at, axis) => assert.ok(Math.abs(at - before[axis]) < slack));
  }
  zoom.reset();
  assert.deepEqual([zoom.scale, zoom.x, zoom.y], [1, 0, 0]);
});

test('settings accept legal values of existing parameters, and become options if they matter', () => {
  const all = parameters();
  const store = new Store();
  const settings = new Settings(store, all);
  assert.equal(SETTING_CHOICES.length, 3);
  for (const { name, options } of SETTING_CHOICES)
    for (const { value } of options.filter((option) => option.value !== null)) {
      assert.equal(settings.set(name, value), true, name);
      assert.ok(store.state.changed.has(name), `${name}: ${value} is the default`);
    }
  assert.deepEqual(otherChanges(store.state), []);
  settings.resetAll();
  assert.equal(settings.set('cut.spatialWeight', -1), false);
  assert.equal(settings.set('no.such', 1), false);
  assert.equal(settings.set('trajectory.gridStep', 12), true);
  assert.equal(settings.set('superpixel.mergeThreshold', 5), true);
  assert.deepEqual(otherChanges(store.state), ['trajectory.gridStep = 12', 'superpixel.mergeThreshold = 5']);
  const { changed } = store.state;
  assert.deepEqual(sessionOptions({ changed }), {
    superpixel: { mergeThreshold: 5 },
    trajectory: { gridStep: 12 },
  });
  assert.equal(settings.set('still.radius', 4), false, 'a parameter of still images');
  settings.set('trajectory.gridStep', all.find(({ name }) => name === 'trajectory.gridStep').default);
  assert.deepEqual([...store.state.changed.keys()], ['superpixel.mergeThreshold'], 'a default is no change');
});

test('a link contains settings, but cannot turn off masks', () => {
  const store = new Store();
  const settings = new Settings(store, parameters());
  readLink(settings, '#flow.smoothness=40&cut.spatialWeight=3&clip.dense=false&cut.no=1&affinity.noiseFloor=');
  assert.deepEqual(Object.fromEntries(store.state.changed), { 'flow.smoothness': 40, 'cut.spatialWeight': 3 });
  const link = settingsLink(store.state.changed, 'https://host/page/#old');
  assert.equal(link, 'https://host/page/#cut.spatialWeight=3&flow.smoothness=40');
  assert.equal(settingsLink(new Map(), 'https://host/page/#old'), 'https://host/page/');
});

test('a trim lies within its clip, and is described', () => {
  const trim = defaultTrim(VIDEO);
  assert.deepEqual(trim, { start: 0, frames: 100, step: 1, side: 480 });
  assert.deepEqual(clampTrim({ ...trim, start: 200, step: 3 }, VIDEO), { start: 98, frames: 1, step: 3, side: 480 });
  assert.equal(lastFrame({ ...trim, start: 10, frames: 4, step: 5 }), 25);
  const typed = { start: 40, frames: 50, step: 1, side: 320 };
  assert.equal(trimFromInputs(typed, trim, VIDEO, false).frames, 100, 'to the end, as before');
  assert.equal(trimFromInputs(typed, trim, VIDEO, true).frames, 50);
  assert.equal(trimFromInputs({ ...typed, frames: NaN }, trim, VIDEO, true).frames, 2);
  assert.equal(describeTrim(VIDEO, { ...trim, frames: 50 }, 0), '50 frames of 480 × 270, 0.0\u00a0s to 2.0\u00a0s.');
  assert.match(describeTrim(VIDEO, trim, 1e-3), /About 13\u00a0s on this computer\. First results appear/);
  assert.equal(describeClip(VIDEO), '1920 × 1080, 4.0 s at 25 fps');
  assert.equal(describePart(VIDEO, 25, 50), '1.0–2.0\u00a0s of 4.0\u00a0s');
  assert.equal(describePart({ ...VIDEO, kind: 'images' }, 6, 29), 'images 7–30 of 100');
});

test('exports have sizes of the source, without duplicates, and last as long as their frames', () => {
  const names = (source, working) => exportSizes(source, working).map(({ name, side }) => `${name} ${side}`);
  assert.deepEqual(names(VIDEO, { width: 480, height: 270 }), ['source 1920', 'half 960', 'working 480', 'own 1920']);
  const small = { width: 480, height: 270 };
  assert.deepEqual(names({ ...VIDEO, ...small }, small), ['source 480', 'half 240', 'own 480']);
  assert.equal(computeDuration({ numFrames: 3, times: [1, 2, 4], end: 5 }, 25), 4);
  assert.equal(computeDuration({ numFrames: 3, times: [1, 2, 4] }, 25), 5);
  assert.equal(computeDuration({ numFrames: 50, times: null }, 25), 2);
});

test('suggests only changes that may find objects', () => {
  const report = { numFrames: 30, trajectories: 200, coverage: 0.9, speed: 2, cameraMoves: true, motions: [1] };
  assert.equal(
    describeSearch(report),
    'Tracked 200 points over 90% of the picture in 30 frames; the camera moves about 2.0 px/frame. Everything moves together, so nothing stands out.',
  );
  assert.match(describeSearch({ ...report, trajectories: 0 }), /^No points to track/);
  const state = (trim, source = VIDEO) => ({ source, job: { trim }, changed: new Map() });
  const ids = (...given) => suggestChanges(...given).map(({ id }) => id);
  const whole = { start: 0, frames: 100, step: 1, side: 480 };
  assert.deepEqual(ids(state(whole), report), ['step', 'side']);
  assert.deepEqual(ids(state({ ...whole, frames: 20, side: 640 }), { coverage: 0.2 }), ['whole', 'weak']);
  assert.deepEqual(ids(state(whole, { ...VIDEO, kind: 'sample' }), report), []);
  const [{ patch }] = suggestChanges(state(whole), report);
  assert.deepEqual(patch.trim, { start: 0, frames: 50, step: 2, side: 480 });
});

test('errors advise formats that the browser plays, and numbers are formatted', () => {
  assert.match(explain(new PageError('codec')).advice, /MP4/);
  assert.doesNotMatch(explain(new PageError('codec'), false).advice, /MP4/);
  assert.equal(explain(new RangeError('x')).code, 'memory');
  assert.equal(explain('odd').code, 'unknown');
  assert.deepEqual([formatCount(1234567), formatPercent(0.004), formatPercent(0.62)], ['1,234,567', '0.4%', '62%']);
  assert.deepEqual([formatTimeLeft(1000), formatTimeLeft(33_000)], ['almost done', 'about 35\u00a0s left']);
});
