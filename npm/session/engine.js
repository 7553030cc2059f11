// A session in this thread: one queue of calls, and a run that steps in slices so that the thread stays responsive.

import { Pool } from '../worker/helpers.js';
import { end, guarded, instance } from '../worker/instance.js';
import { breath } from '../worker/pause.js';
import { lineOf } from './requests.js';

/** Most time between two chances for messages, in milliseconds; one step may take longer. */
const SLICE_MS = 30;
/** Most steps between two such chances, where the clock stands still. */
const SLICE_STEPS = 16;

/**
 * The stages of a run, in their order.
 * @typedef {'flow' | 'trajectories' | 'affinities' | 'embedding' | 'discontinuities' | 'saliency' | 'connectedness'
 *   | 'clusters' | 'superpixels' | 'cut' | 'masks'} Stage
 */
/**
 * How far a run is: `done` of `total` steps of a stage. `done` only grows, `total` stays; steps differ in how long they
 * take.
 * @typedef {{readonly stage: Stage, readonly done: number, readonly total: number}} Progress
 */
/**
 * What a session holds: `corrections` is the number in force, `memoryBytes` the linear memory of its wasm instance,
 * which never shrinks.
 * @typedef {{numFrames: number, width: number, height: number, workingWidth: number, workingHeight: number,
 *   corrections: number, memoryBytes: number}} Info
 */
/**
 * Where each pixel goes from one frame to the next, in input pixels, row by row: `u` to the right, `v` down. `width` ×
 * `height` is the size that frames are processed at.
 * @typedef {{readonly width: number, readonly height: number, readonly u: Float32Array<ArrayBuffer>, readonly v:
 *   Float32Array<ArrayBuffer>}} FlowField
 */

/**
 * Everything that a finished run leaves, as flat arrays.
 * @typedef {object} RawResult
 * @property {Info} info
 * @property {Partial<Record<Stage, number>>} seconds
 * @property {import('./result.js').TrajectoryList} trajectories
 * @property {import('./result.js').ClusterList & import('./result.js').ClusterObjects} clusters
 * @property {import('./result.js').ClusterList} thresholdClusters
 * @property {import('./result.js').EmbeddingTable} embedding
 * @property {import('./result.js').EdgeTable} edges
 * @property {import('./result.js').SaliencyTable | null} saliency null without frames
 * @property {import('./result.js').ComponentTable | null} components null without frames
 * @property {import('./report.js').Areas[] | null} areas of the objects; null without masks
 * @property {Uint8Array<ArrayBuffer> | null} labels the masks of all frames, one after the other
 */

/** @typedef {Omit<import('../stages/image.js').BoundaryMap, 'scaleX' | 'scaleY'>} RawBoundaryMap */
/** @typedef {Omit<import('../stages/image.js').Superpixels, 'scaleX' | 'scaleY'>} RawSuperpixels */
/** @typedef {Omit<import('./result.js').Background, 'scaleX' | 'scaleY'>} RawBackground */
/** @typedef {Omit<import('./result.js').SaliencyMap, 'scaleX' | 'scaleY'>} RawSaliencyMap */
/** @typedef {Omit<import('./result.js').ConfidenceMap, 'scaleX' | 'scaleY'>} RawConfidenceMap */

/**
 * What the public session needs of an engine, in this thread or in a worker. `run` resolves to `null` when it saw the
 * abort.
 * @typedef {object} Engine
 * @property {<N extends import('./requests.js').RequestName>(name: N, ...args: import('./requests.js').Arguments<N>) =>
 *   Promise<import('./requests.js').Answer<N>>} request
 * @property {(onProgress: (progress: Progress) => void, signal: AbortSignal) => Promise<RawResult | null>} run
 * @property {(onProgress: (progress: Progress) => void, signal: AbortSignal) =>
 *   Promise<import('./result.js').TrajectoryList | null>} track as `run`, no further than the trajectories
 * @property {() => void} rest no further window comes: helpers have nothing left to do
 * @property {() => void} close
 */

/**
 * @param {WebAssembly.Module} module
 * @param {Record<string, unknown>} parameters
 * @returns {Promise<LocalEngine>}
 */
export async function createLocalEngine(module, parameters) {
  const owner = await instance(module);
  return new LocalEngine(
    owner,
    guarded(owner, (glue) => new glue.Session(parameters)),
  );
}

/** @implements {Engine} */
export class LocalEngine {
  #owner;
  /**
   * @type {import('../tracecut.js').Session | undefined} None once it is closed: it would keep the instance's memory.
   */
  #session;
  /** @type {Promise<unknown>} */
  #last = Promise.resolve();
  /** @type {Partial<Record<Stage, number>>} */
  #seconds = {};
  #inShots = false;
  /** When the last step ended, in milliseconds. */
  #clock = 0;
  #closed = false;
  /** Helpers that work on pieces of the run. */
  pool = new Pool();
  /** @type {import('../worker/helpers.js').Crew | undefined} Who starts them, where that is done in this thread. */
  crew;

  /**
   * @param {import('../worker/instance.js').Instance} owner
   * @param {import('../tracecut.js').Session} session
   */
  constructor(owner, session) {
    this.#owner = owner;
    this.#session = session;
  }

  /**
   * @template {import('./requests.js').RequestName} N
   * @param {N} name
   * @param {import('./requests.js').Arguments<N>} args
   * @returns {Promise<import('./requests.js').Answer<N>>}
   */
  request(name, ...args) {
    const { work, restarts } = lineOf(name);
    if (name === 'push' || name === 'pushInShot') this.crew?.muster();
    this.#inShots ||= name === 'pushInShot';
    return this.#inOrder(async () => {
      const call = await work(...args);
      if (restarts) this.#seconds = {};
      const answer = this.#call(call);
      // Flow can be worked on while frames are still coming.
      this.#call((session) => this.pool.exchange(session));
      return answer;
    });
  }

  /** @type {Engine['run']} */
  run(onProgress, signal) {
    return this.#work(onProgress, signal, undefined, (session) => this.#result(session));
  }

  /** @type {Engine['track']} */
  track(onProgress, signal) {
    return this.#work(onProgress, signal, 'trajectories', (session) => session.trajectories());
  }

  /**
   * Steps to the end, or to the end of a stage.
   * @template T
   * @param {(progress: Progress) => void} onProgress
   * @param {AbortSignal} signal
   * @param {Stage | undefined} last
   * @param {(session: import('../tracecut.js').Session) => T} answer
   * @returns {Promise<T | null>}
   */
  #work(onProgress, signal, last, answer) {
    return this.#inOrder(async () => {
      this.#clock = performance.now();
      const wake = () => this.pool.wake();
      signal.addEventListener('abort', wake);
      try {
        while (!signal.aborted && !this.#closed) {
          const state = this.#slice(onProgress, last);
          if (state === 'done') {
            // Helpers have nothing left to do, unless there is another window.
            if (!this.#inShots) this.crew?.rest();
            return this.#call(answer);
          }
          await (state === 'waiting' ? this.pool.next() : macrotask());
        }
      } finally {
        signal.removeEventListener('abort', wake);
      }
      return null;
    });
  }

  rest() {
    this.#inShots = false;
    this.crew?.rest();
  }

  close() {
    this.#closed = true;
    this.pool.close();
    this.crew?.dismiss();
    this.#inOrder(async () => {
      this.#session = undefined;
      end(this.#owner, 'session');
    });
  }

  /**
   * Steps until the slice is over, until nothing is left to do, or until nothing can be done before a helper is back.
   * Reports the last step of each stage and of the slice.
   * @param {(progress: Progress) => void} onProgress
   * @param {Stage | undefined} until the stage that is the last one, if not all are wanted
   * @returns {'more' | 'waiting' | 'done'}
   */
  #slice(onProgress, until) {
    const began = performance.now();
    /** @type {Progress | undefined} */
    let last;
    for (let steps = 1; ; steps += 1) {
      const pause = this.#call((session) => this.#help(session));
      if (!pause) {
        const progress = /** @type {Progress | undefined} */ (this.#call((session) => session.step()));
        if (last && progress?.stage !== last.stage) onProgress(last);
        if (!progress) return 'done';
        this.#count(progress.stage);
        last = progress;
        if (progress.stage === until && progress.done === progress.total) {
          onProgress(last);
          return 'done';
        }
      }
      if (pause || steps >= SLICE_STEPS || isOver(began)) {
        if (last) onProgress(last);
        return pause ?? 'more';
      }
    }
  }

  /**
   * Exchanges pieces with the helpers. While the next step waits for one of them, a piece is made here instead of it;
   * where there is none, nothing can be done but wait.
   * @param {import('../tracecut.js').Session} session
   * @returns {'more' | 'waiting' | undefined}
   */
  #help(session) {
    this.pool.exchange(session);
    if (!this.pool.busy || !session.awaits()) return undefined;
    return session.makePiece(this.pool.ahead) ? 'more' : 'waiting';
  }

  /**
   * What went by since the last step counts for this one.
   * @param {Stage} stage
   */
  #count(stage) {
    const now = performance.now();
    this.#seconds[stage] = (this.#seconds[stage] ?? 0) + Math.max(0, now - this.#clock) / 1000;
    this.#clock = now;
  }

  /**
   * @param {import('../tracecut.js').Session} session
   * @returns {RawResult}
   */
  #result(session) {
    const info = session.info();
    const found = session.objects() ?? null;
    const masks = found && allMasks(session, info, found.labels);
    return {
      info,
      seconds: { ...this.#seconds },
      trajectories: session.trajectories(),
      clusters: { ...session.clusters(), object: found && found.ofCluster },
      thresholdClusters: session.thresholdClusters(),
      embedding: session.embedding(),
      edges: session.edges(),
      saliency: session.saliency() ?? null,
      components: session.components() ?? null,
      areas: masks && masks.areas,
      labels: masks && masks.labels,
    };
  }

  /**
   * @template T
   * @param {(session: import('../tracecut.js').Session) => T} call
   * @returns {T}
   */
  #call(call) {
    try {
      return guarded(this.#owner, () => call(/** @type {import('../tracecut.js').Session} */ (this.#session)));
    } finally {
      // It would keep the memory of an instance that has ended.
      if (!this.#owner.glue) this.#session = undefined;
    }
  }

  /**
   * Runs `work` when everything before it is over, however that ended.
   * @template T
   * @param {() => Promise<T>} work
   * @returns {Promise<T>}
   */
  #inOrder(work) {
    const mine = this.#last.then(work);
    this.#last = mine.catch(() => {});
    return mine;
  }
}

/**
 * The masks of all frames, one after the other, and how many pixels each object has in each.
 * @param {import('../tracecut.js').Session} session
 * @param {Info} info
 * @param {Uint8Array} known the labels of objects
 */
function allMasks(session, { numFrames, width, height }, known) {
  const labels = new Uint8Array(numFrames * width * height);
  const areas = Array.from(known, (label) => ({ label, areas: new Uint32Array(numFrames) }));
  for (let t = 0; t < numFrames; t += 1) {
    const mask = session.labels(t);
    labels.set(mask, t * width * height);
    const pixels = new Uint32Array(256);
    for (const label of mask) /** @type {any} */ (pixels)[label] += 1;
    for (const object of areas) object.areas[t] = /** @type {number} */ (pixels[object.label]);
  }
  return { labels, areas };
}

/**
 * Whether a slice is over; one during which the clock was put back is.
 * @param {number} began
 */
function isOver(began) {
  const past = performance.now() - began;
  return past < 0 || past >= SLICE_MS;
}

/** @type {(() => Promise<void>) | undefined} */
let nextTask;

/** Lets waiting messages and events in. `setTimeout` would do, but browsers make nested ones wait 4 ms. */
function macrotask() {
  nextTask ??= taskSource();
  return nextTask();
}

function taskSource() {
  if (typeof setImmediate === 'function')
    return () => new Promise((/** @type {(value: void) => void} */ resolve) => setImmediate(resolve));
  return globalThis.MessageChannel ? channelTask() : breath;
}

function channelTask() {
  const { port1, port2 } = new MessageChannel();
  /** @type {(() => void)[]} */
  const waiting = [];
  port1.onmessage = () => waiting.shift()?.();
  return () =>
    new Promise((/** @type {(value: void) => void} */ resolve) => {
      waiting.push(resolve);
      port2.postMessage(null);
    });
}
