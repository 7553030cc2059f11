// Parts of the studio's model that need no run: texts and small computations, files that are opened, and the sound of a clip.

import assert from 'node:assert/strict';
import { afterEach, beforeEach, mock, test } from 'node:test';
import { setImmediate } from 'node:timers/promises';
import { parameters } from 'tracecut';
import { App } from '../../build/model/app.js';
import { describeClip, describePart, describeTrim, lastFrame, trimFromInputs } from '../../build/model/clip-text.js';
import { computeDuration, exportSizes } from '../../build/model/export-text.js';
import { explain, formatCount, formatPercent, formatTimeLeft, PageError } from '../../build/model/messages.js';
import { colourName } from '../../build/model/palette.js';
import { Times } from '../../build/model/presence.js';
import { readLink, settingsLink } from '../../build/model/recipe.js';
import { otherChanges, sessionOptions, SETTING_CHOICES, Settings } from '../../build/model/settings.js';
import { Sound } from '../../build/model/sound.js';
import { clampTrim, defaultTrim } from '../../build/model/source.js';
import { Store } from '../../build/model/store.js';
import { describeSearch, suggestChanges } from '../../build/model/suggestions.js';
import { MAX_SCALE, Zoom } from '../../build/model/zoom.js';
import { openFiles } from '../../build/view/source.js';
import { pngBytes } from '../png.mjs';
import { CLIP } from './studio.mjs';

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
    const [u, v, scale] = [random(), random(), zoom.scale * (0.5 + random())];
    const before = [zoom.x + u / zoom.scale, zoom.y + v / zoom.scale];
    if (k % 3 === 2) zoom.pan(u - 0.5, v - 0.5);
    else zoom.zoomTo(scale, u, v);
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
  const allParameters = parameters();
  const store = new Store();
  const settings = new Settings(store, allParameters);
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
  settings.set('trajectory.gridStep', allParameters.find(({ name }) => name === 'trajectory.gridStep').default);
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
  const trim = { start: 0, frames: 100, step: 1, side: 480 };
  assert.deepEqual(ids(state(trim), report), ['step', 'side']);
  assert.deepEqual(ids(state({ ...trim, frames: 20, side: 640 }), { coverage: 0.2 }), ['whole', 'weak']);
  assert.deepEqual(ids(state(trim, { ...VIDEO, kind: 'sample' }), report), []);
  const [{ patch }] = suggestChanges(state(trim), report);
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

const PIXELS = { width: 8, height: 6, data: new Uint8ClampedArray(4 * 8 * 6).fill(255) };
const png = (name) => new File([pngBytes(PIXELS)], name, { type: 'image/png' });

const JPEG = new File([Uint8Array.of(0xff, 0xd8, 0xff, 0xe0)], 'a.jpg', { type: 'image/jpeg' });

/** Stands in for what a browser has. */
const BROWSER = {
  OffscreenCanvas: class {
    getContext() {}
  },
  VideoDecoder: class {},
  createImageBitmap: async () => ({ width: 8, height: 6, close() {} }),
};

beforeEach(() => Object.assign(globalThis, BROWSER));
afterEach(() => Object.keys(BROWSER).forEach((name) => delete globalThis[name]));

test('opens several images as frames, in the order of their names', async () => {
  const source = await openFiles([png('b10.png'), png('b9.png')]);
  assert.deepEqual([source.kind, source.count, source.name], ['images', 2, 'b9.png … b10.png']);
});

test('explains that one picture has no motion', async () => {
  for (const file of [png('a.png'), JPEG])
    await assert.rejects(openFiles([file]), { code: 'one-image', message: file.name });
  const { title, advice } = explain({ code: 'one-image' });
  assert.equal(`${title}. ${advice}`, 'One picture has no motion. Open a video, or all frames of a folder at once.');
});

test('shows the message instead of a clip', async () => {
  const store = new Store();
  const app = new App(store, { openFiles });
  await app.openFiles([png('a.png')]);
  assert.deepEqual([store.state.phase, store.state.error.code], ['error', 'one-image']);
});

test('reports a damaged image before its missing motion', async () => {
  globalThis.createImageBitmap = () => Promise.reject(new Error('damaged'));
  await assert.rejects(openFiles([JPEG]), { code: 'unreadable-image' });
});

test('refuses files of different kinds, and files that are neither videos nor images', async () => {
  const mp4 = new File(['0000ftypisom'], 'a.mp4', { type: 'video/mp4' });
  await assert.rejects(openFiles([png('a.png'), mp4]), { code: 'mixed-files' });
  await assert.rejects(openFiles([mp4, mp4]), { code: 'many-videos' });
  await assert.rejects(openFiles([new File(['hello'], 'a.txt')]), { code: 'unknown-file', message: 'a.txt' });
  await assert.rejects(openFiles([new File([], 'a.mp4')]), { code: 'unknown-file', message: 'a.mp4 is empty' });
});

afterEach(() => mock.reset());

const FPS = 25;

/** Opens a clip with sound; `show` shows its next frame after the time of one frame. */
async function openClip({ isUserActive = () => true, hasSound = async () => true } = {}) {
  const clock = { now: 0 };
  mock.method(performance, 'now', () => clock.now);
  const player = {
    ...{ currentTime: 0, paused: true, isClosed: false, seeks: 0 },
    play: async () => void (player.paused = false),
    pause: () => void (player.paused = true),
    close: () => void (player.isClosed = true),
  };
  const store = new Store();
  const sound = new Sound(store, { hasSound, isUserActive, open: () => player });
  store.set({ source: { kind: 'video', file: CLIP } });
  await setImmediate();
  const seconds = Array.from({ length: 100 }, (_, t) => 2 + t / FPS);
  store.set({ timeline: { numFrames: 100, fps: FPS, times: new Times(seconds, null), cuts: [] } });
  /** @param soundRate speed of the player until then */
  const show = (frame, soundRate = 1) => {
    clock.now += 1000 / FPS;
    if (!player.paused) player.currentTime += soundRate / FPS;
    const before = player.currentTime;
    store.set({ frame });
    if (player.currentTime !== before) player.seeks += 1;
  };
  return { store, sound, player, show };
}

test('plays from the frame on screen, without seeking while it is in step', async () => {
  const { store, player, show } = await openClip();
  store.set({ frame: 10 });
  assert.equal(player.paused, true);
  store.set({ isPlaying: true });
  assert.equal(player.paused, false);
  assert.equal(player.currentTime, 2 + 10 / FPS);
  for (let frame = 11; frame < 60; frame += 1) show(frame);
  assert.equal(player.seeks, 0);
  store.set({ isPlaying: false });
  assert.equal(player.paused, true);
});

test('seeks where the picture jumps, and rarely where it is slow', async () => {
  const { store, player, show } = await openClip();
  store.set({ isPlaying: true });
  for (const frame of [1, 2, 3, 50]) show(frame);
  assert.ok(Math.abs(player.currentTime - (2 + 50 / FPS)) < 1e-9);
  assert.equal(player.seeks, 1);
  // A busy page shows each frame for twice its time.
  for (let frame = 51; frame < 100; frame += 1) {
    show(frame, 2);
    show(frame, 0);
    assert.ok(Math.abs(player.currentTime - (2 + frame / FPS)) < 1.3);
  }
  assert.ok(player.seeks > 1 && player.seeks < 6, `${player.seeks} seeks`);
});

test('stays silent if muted, without sound, and in automatic playback', async () => {
  const { store, sound, player } = await openClip();
  store.set({ isMuted: true, isPlaying: true });
  assert.equal(player.paused, true);
  sound.toggle();
  assert.deepEqual([store.state.isMuted, player.paused], [false, false]);
  sound.toggle();
  assert.deepEqual([store.state.isMuted, player.paused], [true, true]);

  const silent = await openClip({ hasSound: async () => false });
  silent.store.set({ isPlaying: true });
  assert.deepEqual([silent.store.state.hasSound, silent.player.paused], [false, true]);

  const automatic = await openClip({ isUserActive: () => false });
  automatic.store.set({ isPlaying: true });
  assert.equal(automatic.player.paused, true);
  automatic.sound.toggle();
  assert.deepEqual([automatic.store.state.isMuted, automatic.player.paused], [false, false]);
});

test('offers no sound that the browser cannot decode', async () => {
  const { store, player } = await openClip();
  player.play = () => Promise.reject(new DOMException('no decoder', 'NotSupportedError'));
  store.set({ isPlaying: true });
  await setImmediate();
  assert.equal(store.state.hasSound, false);
});

test('closes the sound when another clip is opened', async () => {
  const { store, player } = await openClip();
  store.set({ isPlaying: true });
  store.set({ isPlaying: false, source: { kind: 'sample' } });
  assert.deepEqual([player.isClosed, store.state.hasSound], [true, false]);
});
