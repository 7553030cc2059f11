// The sound of a clip, played in step with its frames.

import assert from 'node:assert/strict';
import { afterEach, mock, test } from 'node:test';
import { setImmediate } from 'node:timers/promises';
import { Sound } from '../../build/model/sound.js';
import { Times } from '../../build/model/presence.js';
import { Store } from '../../build/model/store.js';
import { CLIP } from './studio.mjs';

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
