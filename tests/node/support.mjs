// What the tests of the package share: clips, sessions, PNG files, and checks of errors.

import assert from 'node:assert/strict';
import { execFileSync } from 'node:child_process';
import { readFile } from 'node:fs/promises';
import { setFlagsFromString } from 'node:v8';
import { runInNewContext } from 'node:vm';
import { MessageChannel } from 'node:worker_threads';
import { createSession, synthClip, TraceCutError } from 'tracecut';
import { serve } from '../../dist/worker/serve.js';
import { root } from '../../scripts/tools.mjs';
import { fingerprint, fnv1a } from '../fingerprint.mjs';
import { pngBytes } from '../png.mjs';
import { withTrap } from '../faulty-wasm.mjs';

export { fingerprint, fnv1a };

/** The smallest scene with an object: the scene of most tests. */
export const SMALL = { width: 96, height: 54, frames: 8, seed: 5 };

/** The stages of a run with masks, in order. */
export const STAGES =
  'flow trajectories affinities embedding discontinuities saliency connectedness clusters superpixels cut masks'.split(
    ' ',
  );

const frameLists = new Map();
const results = new Map();

/** Returns the value of a map for a scene, which is computed once in a process. */
function computeOnce(map, scene, compute) {
  const key = JSON.stringify(scene);
  if (!map.has(key)) map.set(key, compute());
  return map.get(key);
}

async function renderFrames(scene) {
  const clip = await synthClip(scene);
  const frames = Array.from({ length: clip.numFrames }, (_, t) => clip.frame(t));
  clip.close();
  return frames;
}

/** Returns the frames of a synthetic clip, the same ones each time. */
export const framesOf = (scene = SMALL) => computeOnce(frameLists, scene, () => renderFrames(scene));

/** Returns the result of a synthetic clip with default options, the same one each time. */
export const resultOf = (scene = SMALL) => computeOnce(results, scene, async () => segment(await framesOf(scene)));

/** Returns the fingerprint of that result. */
export const printOf = async (scene) => fingerprint(await resultOf(scene));

/** Collects an iterable as a list. */
export async function collect(items) {
  const list = [];
  for await (const item of items) list.push(item);
  return list;
}

/** One property of each of a list, or several of them as a row. */
export const each = (list, ...names) =>
  list.map((item) => (names.length > 1 ? names.map((name) => item[name]) : item[names[0]]));

/** Returns options of a call that one of its reports aborts: the first one, or the first one that `isDue`. */
export function abortAt({ reason, isDue = () => true, callback = 'onProgress' } = {}) {
  const controller = new AbortController();
  return { signal: controller.signal, [callback]: (report) => void (isDue(report) && controller.abort(reason)) };
}

/** The frames of a clip that repeats, counted as they are taken; `ended` settles once nobody wants more. */
export function endless(frames) {
  const source = { numTaken: 0 };
  source.ended = new Promise((resolve) => {
    source[Symbol.asyncIterator] = async function* () {
      try {
        for (;;) yield frames[source.numTaken++ % frames.length];
      } finally {
        resolve();
      }
    };
  });
  return source;
}

/** Returns the intersection over union of the pixels of two masks that are not zero. */
export function overlapOf(a, b) {
  let [intersection, union] = [0, 0];
  a.forEach((label, p) => {
    intersection += Number(label > 0 && b[p] > 0);
    union += Number(label > 0 || b[p] > 0);
  });
  return intersection / union;
}

/** A frame of one colour, or of `colour(x, y)`. */
export function plain(width, height, colour = 0) {
  const data = new Uint8ClampedArray(4 * width * height);
  for (let p = 0; p < width * height; p += 1) {
    const value = typeof colour === 'function' ? colour(p % width, Math.floor(p / width)) : colour;
    data.set([value, value, value, 255], 4 * p);
  }
  return { data, width, height };
}

/** Returns a mask with the labels `label(x, y)`. */
export const mapPixels = (width, height, label) =>
  Uint8Array.from({ length: width * height }, (_, p) => Number(label(p % width, Math.floor(p / width))));

/** A session of one thread, which is closed when the test ends. Tests of workers use more threads. */
export async function open(t, options) {
  const session = await createSession({ threads: 1, ...options });
  t.after(() => session.close());
  return session;
}

/** As `open`, with the frames of the small clip, or these. */
export async function ready(t, options, frames) {
  const session = await open(t, options);
  for (const frame of frames ?? (await framesOf())) await session.push(frame);
  return session;
}

/** Opens a session of one thread, pushes the frames, runs it and closes it. */
export async function segment(frames, options) {
  const session = await createSession({ threads: 1, ...options });
  try {
    for (const frame of frames) await session.push(frame);
    return await session.run();
  } finally {
    session.close();
  }
}

/** Checks that `promise` rejects with a TraceCutError of this code whose message matches. */
export async function rejects(promise, code, message = /./) {
  await assert.rejects(promise, (error) => {
    assert.ok(error instanceof TraceCutError, `${error?.stack ?? error} is no TraceCutError`);
    assert.equal(error.code, code, error.message);
    assert.match(error.message, message);
    return true;
  });
}

/** A PNG file of a frame: RGB, eight bits. Its header may claim another size. */
export function png(frame, claim) {
  return new Uint8Array(pngBytes(frame, { claim }));
}

/** Returns the bytes of a wasm file of the package. */
export const readWasm = async (name = 'tracecut') =>
  new Uint8Array(await readFile(new URL(`../../dist/${name}_bg.wasm`, import.meta.url)));

/** Compiles a wasm file of the package. */
export const compileWasm = async (name) => WebAssembly.compile(await readWasm(name));

/** The wasm file with a fault: a run stops at its first step. */
export const trappingWasm = async () => withTrap(await readWasm(), 'session_step');

/** Runs a module in a process of its own, in the folder of the repository, and returns what it prints. */
export const runModule = (code) =>
  execFileSync(process.execPath, ['--input-type=module', '--eval', code], { cwd: root, encoding: 'utf8' });

/** Checks that the track file of a result lists every trajectory with its label, points and frames. */
export function checkTrackFile(result) {
  const lines = result.toTracksDat().trimEnd().split('\n');
  const { count, startFrame, offset, x, y, label = result.clusters.label } = result.trajectories;
  assert.deepEqual(lines.slice(0, 2), [`${result.numFrames}`, `${count}`]);
  let line = 2;
  for (let i = 0; i < count; i += 1) {
    const length = offset[i + 1] - offset[i];
    assert.equal(lines[line], `${label[i]} ${length}`);
    for (let p = 0; p < length; p += 1) {
      const [px, py, frame] = lines[line + 1 + p].split(' ').map(Number);
      assert.ok(Math.abs(px - x[offset[i] + p]) <= 0.0006 && Math.abs(py - y[offset[i] + p]) <= 0.0006);
      assert.equal(frame, startFrame[i] + p);
    }
    line += 1 + length;
  }
  assert.equal(line, lines.length);
}

/**
 * The memories of the instances that start from now on until the test ends, in their order, for as long as anything
 * else keeps them.
 */
export function watchMemories(t) {
  const memories = [];
  const { instantiate } = WebAssembly;
  WebAssembly.instantiate = async (...args) => {
    const instance = await instantiate(...args);
    // Node has wasm of its own.
    const isOurs = Object.keys(instance.exports).some((name) => name.startsWith('__wbindgen'));
    if (isOurs) memories.push(new WeakRef(instance.exports.memory));
    return instance;
  };
  t.after(() => (WebAssembly.instantiate = instantiate));
  return memories;
}

/** A stand-in for a `Worker` of a browser: its far side answers as worker.js does. */
export function standIn(answer = serve) {
  const { port1, port2 } = new MessageChannel();
  /** Ends of its channels to other workers. */
  const ends = [];
  answer({
    postMessage: (message, transfer) => port2.postMessage(message, transfer),
    addEventListener: (type, listener) =>
      port2.on(type, (data) => {
        if (data.data?.port) ends.push(data.data.port);
        listener({ data });
      }),
  });
  const listeners = {};
  port1.on('message', (data) => listeners.message?.({ data }));
  return {
    terminated: false,
    postMessage: (message, transfer) => port1.postMessage(message, transfer),
    addEventListener: (type, listener) => (listeners[type] = listener),
    terminate() {
      this.terminated = true;
      port1.close();
      for (const end of ends) end.close();
    },
    fail: (message) => listeners.error({ message }),
  };
}

/**
 * Collects garbage until `gone` is true. No event says that an object is collected, so this asks after each collection, in a
 * task of its own: a task keeps what it asks a `WeakRef` for, and finalizers come later.
 */
export async function untilCollected(gone, rounds = 30) {
  setFlagsFromString('--expose-gc');
  const collectGarbage = runInNewContext('gc');
  const task = () => new Promise(setImmediate);
  for (let i = 0; i < rounds && !gone(); i += 1) {
    await task();
    collectGarbage();
    await task();
  }
  return gone();
}

/** A JPEG file of 24 by 16 pixels whose red is 6 (x + y), green 15 y and blue 10 x, give or take what JPEG loses. */
export const JPEG = fromBase64(`
  /9j/4AAQSkZJRgABAQAAAQABAAD/2wBDAAMCAgICAgMCAgIDAwMDBAYEBAQEBAgGBgUGCQgKCgkICQkKDA8MCgsOCwkJDRENDg8QEBEQCgwSExIQEw8QEBD/
  2wBDAQMDAwQDBAgEBAgQCwkLEBAQEBAQEBAQEBAQEBAQEBAQEBAQEBAQEBAQEBAQEBAQEBAQEBAQEBAQEBAQEBAQEBD/wAARCAAQABgDASIAAhEBAxEB/8QA
  FgABAQEAAAAAAAAAAAAAAAAACAAG/8QAGhAAAQUBAAAAAAAAAAAAAAAAAAUHJDKhov/EABcBAAMBAAAAAAAAAAAAAAAAAAUGBwj/xAAeEQABBAEFAAAAAAAA
  AAAAAAAAAQUGIgcEIyQxMv/aAAwDAQACEQMRAD8AFCIz1YuG+RGerF5FIiM9WLyb9EZ6sXBXh2SfNwSySjqwW0RnqxcIcSIz1YvJGk2nJPGS5UNHKNpLH//Z
`);
export const PROGRESSIVE_JPEG = fromBase64(`
  /9j/4AAQSkZJRgABAQAAAQABAAD/2wBDAAMCAgICAgMCAgIDAwMDBAYEBAQEBAgGBgUGCQgKCgkICQkKDA8MCgsOCwkJDRENDg8QEBEQCgwSExIQEw8QEBD/
  2wBDAQMDAwQDBAgEBAgQCwkLEBAQEBAQEBAQEBAQEBAQEBAQEBAQEBAQEBAQEBAQEBAQEBAQEBAQEBAQEBAQEBAQEBD/wgARCAAQABgDASIAAhEBAxEB/8QA
  FwABAQEBAAAAAAAAAAAAAAAABwAFBv/EABcBAAMBAAAAAAAAAAAAAAAAAAQFBgf/2gAMAwEAAhADEAAAARPfUugViFs42k1H/8QAFhAAAwAAAAAAAAAAAAAA
  AAAAAAMF/9oACAEBAAEFAkxxMcTHExxMcTHP/8QAGhEAAgIDAAAAAAAAAAAAAAAAAAUDBCIxYf/aAAgBAwEBPwGk06QtMdn/xAAaEQACAgMAAAAAAAAAAAAA
  AAAABgQxBSEj/9oACAECAQE/AcOyVsiMnOz/xAAVEAEBAAAAAAAAAAAAAAAAAAAAMv/aAAgBAQAGPwKUpSlL/8QAFhABAQEAAAAAAAAAAAAAAAAAADHB/9oA
  CAEBAAE/IZMspMspMsv/2gAMAwEAAgADAAAAEOAv/8QAFhEBAQEAAAAAAAAAAAAAAAAAACEx/9oACAEDAQE/EMiE/8QAFREBAQAAAAAAAAAAAAAAAAAAACH/
  2gAIAQIBAT8QbG//xAAVEAEBAAAAAAAAAAAAAAAAAAAQ8f/aAAgBAQABPxCYYmGJhj//2Q==
`);

function fromBase64(base64) {
  return new Uint8Array(Buffer.from(base64, 'base64'));
}
