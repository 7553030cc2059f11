// The studio's model in Node: a platform without a browser, the synthetic sample, segmented once for all test files, and edits.

import { createHash } from 'node:crypto';
import { existsSync, mkdirSync, readFileSync, renameSync, writeFileSync } from 'node:fs';
import { join } from 'node:path';
import { fitSize, segmentVideo } from 'tracecut';
import { openProject, saveProject } from 'tracecut/edit';
import { App } from '../../build/model/app.js';
import { Brush } from '../../build/model/brush.js';
import { PageError } from '../../build/model/messages.js';
import { Selection } from '../../build/model/selection.js';
import { showCorrected } from '../../build/model/show-result.js';
import { Store } from '../../build/model/store.js';
import { platform, setPlatform } from '../../dist/platform.js';
import { root } from '../../scripts/tools.mjs';
import { framesOf } from '../node/support.mjs';

// One thread takes less processor time than two, and gives the same results.
setPlatform({ ...platform, cores: () => 1 });

/** A file that is opened as a clip. */
export const CLIP = new File(['clip'], 'clip.mp4', { type: 'video/mp4' });

/** The sample of these tests. */
export const SAMPLE = { width: 192, height: 108, frames: 16, seed: 4 };
const FRAME_SECONDS = 1 / 15;

/** Frames in memory. @implements {import('../../studio/model/clip-job.js').Images} */
class Images {
  frames = [];
  width = 0;
  height = 0;
  onReady = () => {};

  get length() {
    return this.frames.length;
  }

  async add(frame) {
    [this.width, this.height] = [frame.width, frame.height];
    this.frames.push({ ...frame, data: frame.data.slice() });
  }

  get = (t) => this.frames[t] ?? null;
  has = (t) => t < this.length;
  open = async (t) => this.get(t);
  pixels = async (t) => this.frames[t];

  close() {
    this.frames = [];
  }
}

/**
 * Resolves with the state of a store once it satisfies a condition, which is tested after each change.
 *
 * @param {import('../../studio/model/store.js').Store} store
 * @param {(state: import('../../studio/model/store.js').State) => unknown} condition
 */
export function waitForState(store, condition) {
  return new Promise((resolve) => {
    store.watch(Object.keys(store.state), (state) => condition(state) && resolve(state));
  });
}

/** Returns the masks of the result on screen as text, frame by frame. */
export function maskText({ analysis: { segmentation } }) {
  return Array.from({ length: segmentation.result.numFrames }, (_, t) => segmentation.mask(t).join('')).join('|');
}

/** Returns a gate for `openModel`: frames from number `count` on are read only after `open()`. */
export function frameGate(count = Infinity) {
  let open;
  const isOpen = new Promise((resolve) => (open = resolve));
  const gate = { count, open, wait: (t) => (t < gate.count ? null : isOpen) };
  return gate;
}

/**
 * Returns a source of frames, which are read at any size.
 *
 * @param {ReturnType<typeof frameGate>} [options.gate] holds frames back
 * @returns {import('../../studio/model/source.js').Source}
 */
export function sourceOf(frames, { kind = 'video', name = 'clip.mp4', gate } = {}) {
  const [{ width, height }] = frames;
  return {
    ...{ kind, name, width, height, fps: 1 / FRAME_SECONDS, count: frames.length },
    files: kind === 'sample' ? undefined : [new File(['clip'], name, { type: 'video/mp4' })],
    preview: async (t, side) => resized(frames[t], side),
    async *frames({ start, frames: count, step, side }, signal) {
      for (let k = 0; k < count; k += 1) {
        signal.throwIfAborted();
        const t = start + k * step;
        await gate?.wait(t);
        yield { frame: resized(frames[t], side), time: t * FRAME_SECONDS, end: (t + step) * FRAME_SECONDS };
      }
    },
    close() {},
  };
}

function resized(frame, side) {
  const { width, height } = fitSize(frame, side);
  if (width === frame.width) return { data: frame.data.slice(), width, height };
  const pixels = new Uint32Array(frame.data.buffer, frame.data.byteOffset, frame.width * frame.height);
  const nearest = (k) => Math.floor(((k + 0.5) * frame.width) / width);
  const small = Uint32Array.from({ length: width * height }, (_, p) => {
    const [x, y] = [nearest(p % width), nearest(Math.floor(p / width))];
    return pixels[y * frame.width + x];
  });
  return { data: new Uint8ClampedArray(small.buffer), width, height };
}

/** Returns the frames of the sample, the same ones each time. */
const sampleFrames = () => framesOf(SAMPLE);

/**
 * Opens the model of a page. Each file that is opened in it has these frames.
 *
 * @param {ReturnType<typeof frameGate>} [options.gate] holds frames of files back
 */
export async function openModel(frames, { gate } = {}) {
  frames ??= await sampleFrames();
  const store = new Store();
  store.set({ isReducedMotion: true });
  const app = new App(store, {
    openSample: async () => sourceOf(frames, { kind: 'sample', name: 'Sample clip' }),
    async openFiles([file]) {
      if (!file.type.startsWith('video/')) throw new PageError('unknown-file', file.name);
      return sourceOf(frames, { name: file.name, gate });
    },
    createImages: () => new Images(),
  });
  return { app, store, selection: new Selection(store), frames };
}

/** Returns the bytes of the sample's project, which are cached in out/tests for each wasm file. */
async function readSampleProject() {
  const hash = createHash('sha256').update(readFileSync(join(root, 'dist', 'tracecut_bg.wasm')));
  const file = join(root, 'out', 'tests', `sample-${hash.digest('hex').slice(0, 16)}.tracecut`);
  if (existsSync(file)) return readFileSync(file);
  const frames = (await sampleFrames()).map((frame, t) => ({
    frame,
    time: t * FRAME_SECONDS,
    duration: FRAME_SECONDS,
  }));
  const bytes = await saveProject(await segmentVideo(frames).collect());
  mkdirSync(join(root, 'out', 'tests'), { recursive: true });
  // Test files run in parallel.
  writeFileSync(`${file}.${process.pid}`, bytes);
  renameSync(`${file}.${process.pid}`, file);
  return bytes;
}

let sampleProject;

/** Opens the model with the sample as a saved project: nothing is segmented. */
export async function openSampleWork() {
  const model = await openModel();
  sampleProject ??= readSampleProject();
  const project = await openProject(await sampleProject);
  const trim = { start: 0, frames: SAMPLE.frames, step: 1, side: SAMPLE.width };
  const about = { name: 'clip.mp4', trim, changed: [], run: 'first' };
  const files = [CLIP];
  await model.app.openProject('clip.mp4', async () => ({ files, about, project: { ...project, edits: null } }));
  return { ...model, corrections: model.store.state.job.corrections };
}

/** Returns a storage in memory. @returns {import('../../studio/model/saved-projects.js').ProjectStorage & {records: Map<string, object>}} */
export function memoryStorage() {
  const records = new Map();
  return {
    records,
    put: async (record) => void records.set(record.id, record),
    list: async () => [...records.values()].sort((a, b) => b.at - a.at),
    remove: async (id) => void records.delete(id),
  };
}

/** Returns the mask of a frame. */
export function maskAt(store, t) {
  return store.state.analysis.segmentation.mask(t);
}

/** Returns the masks of all frames as text. */
export function masksOf(store) {
  const { numFrames } = store.state.analysis.segmentation.result;
  return Array.from({ length: numFrames }, (_, t) => maskAt(store, t).join('')).join('|');
}

/** Returns the pixels of an object in a frame. */
export function pixelsOf(store, t, object) {
  const mask = maskAt(store, t);
  return [...mask.keys()].filter((p) => mask[p] === object);
}

/** Returns the number of pixels and the centre of each label in a frame. */
export function regionsOf(store, t) {
  const { width } = store.state.analysis.segmentation.result;
  const labels = [...new Set(maskAt(store, t))].sort((a, b) => a - b);
  const mean = (values) => values.reduce((sum, value) => sum + value, 0) / values.length;
  return Object.fromEntries(
    labels.map((label) => {
      const pixels = pixelsOf(store, t, label);
      const [x, y] = [pixels.map((p) => p % width), pixels.map((p) => Math.floor(p / width))].map(mean);
      return [label, { area: pixels.length, x, y }];
    }),
  );
}

/** Returns a short stroke on an object. */
export function strokeOn(store, t, object) {
  const { width } = store.state.analysis.segmentation.result;
  const pixels = pixelsOf(store, t, object);
  const p = pixels[pixels.length >> 1];
  const [x, y] = [p % width, Math.floor(p / width)];
  return { t, points: [x, y, x + 2, y], radius: 1 };
}

/** Shows a correction once it is applied. @param {Promise<number[] | null>} correction resolves to the changed frames */
export async function show(store, correction) {
  showCorrected(store, await correction);
}

/**
 * Returns a brush, with its status texts and what it tells the panel.
 *
 * @param {number} object that is painted at first
 * @param {{isCarrying?: boolean}} [options] whether edits are carried to other frames
 */
export function createBrush(store, object, { isCarrying = true } = {}) {
  const panel = { object, texts: [], canShrink: false, canGrow: false };
  const brush = new Brush({
    store,
    corrector: () => store.state.job.corrections,
    object: () => panel.object,
    choose: (label) => (panel.object = label),
    appliesToOthers: () => isCarrying,
    onCarrying() {},
    onSizes: (canShrink, canGrow) => Object.assign(panel, { canShrink, canGrow }),
    showFrames: (frames) => showCorrected(store, frames),
    showStatus: (text) => panel.texts.push(text),
  });
  return { brush, panel };
}
