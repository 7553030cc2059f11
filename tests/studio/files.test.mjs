// Files that the studio opens, and its messages about those that it does not: what browsers decode is replaced.

import assert from 'node:assert/strict';
import { afterEach, beforeEach, test } from 'node:test';
import { App } from '../../build/model/app.js';
import { explain } from '../../build/model/messages.js';
import { Store } from '../../build/model/store.js';
import { openFiles } from '../../build/view/source.js';
import { pngBytes } from '../png.mjs';

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
