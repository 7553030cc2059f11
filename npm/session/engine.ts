// A session in this thread: one queue of calls, and a run that steps in slices so that the thread stays responsive.

import { type Crew, Pool } from '../worker/helpers.js';
import { type Instance, end, guarded, instance } from '../worker/instance.js';
import { breath } from '../worker/pause.js';
import { type Answer, type Arguments, type RequestName, lineOf } from './requests.js';
import type { BoundaryMap, Superpixels } from '../stages/image.js';
import type { Session } from '../tracecut.js';
import type { Areas } from './report.js';
import type {
  Background,
  ClusterList,
  ClusterObjects,
  ComponentTable,
  ConfidenceMap,
  EdgeTable,
  EmbeddingTable,
  SaliencyMap,
  SaliencyTable,
  TrajectoryList,
} from './result.js';

/** Most time between two chances for messages, in milliseconds; one step may take longer. */
const SLICE_MS = 30;
/** Most steps between two such chances, where the clock stands still. */
const SLICE_STEPS = 16;

/** The stages of a run, in their order. */
export type Stage =
  | 'flow'
  | 'trajectories'
  | 'affinities'
  | 'embedding'
  | 'discontinuities'
  | 'saliency'
  | 'connectedness'
  | 'clusters'
  | 'superpixels'
  | 'cut'
  | 'masks';

/**
 * How far a run is: `done` of `total` steps of a stage. `done` only grows, `total` stays; steps differ in how long they
 * take.
 */
export type Progress = { readonly stage: Stage; readonly done: number; readonly total: number };

export type OnProgress = (progress: Progress) => void;

/**
 * What a session holds: `corrections` is the number in force, `memoryBytes` the linear memory of its wasm instance,
 * which never shrinks.
 */
export type Info = {
  numFrames: number;
  width: number;
  height: number;
  workingWidth: number;
  workingHeight: number;
  corrections: number;
  memoryBytes: number;
};

/**
 * Where each pixel goes from one frame to the next, in input pixels, row by row: `u` to the right, `v` down. `width` ×
 * `height` is the size that frames are processed at.
 */
export type FlowField = {
  readonly width: number;
  readonly height: number;
  readonly u: Float32Array<ArrayBuffer>;
  readonly v: Float32Array<ArrayBuffer>;
};

/** Everything that a finished run leaves, as flat arrays. */
export interface RawResult {
  info: Info;
  seconds: Partial<Record<Stage, number>>;
  trajectories: TrajectoryList;
  clusters: ClusterList & ClusterObjects;
  thresholdClusters: ClusterList;
  embedding: EmbeddingTable;
  edges: EdgeTable;
  /** Null without frames. */
  saliency: SaliencyTable | null;
  /** Null without frames. */
  components: ComponentTable | null;
  /** Of the objects; null without masks. */
  areas: Areas[] | null;
  /** The masks of all frames, one after the other. */
  labels: Uint8Array<ArrayBuffer> | null;
}

export type RawBoundaryMap = Omit<BoundaryMap, 'scaleX' | 'scaleY'>;
export type RawSuperpixels = Omit<Superpixels, 'scaleX' | 'scaleY'>;
export type RawBackground = Omit<Background, 'scaleX' | 'scaleY'>;
export type RawSaliencyMap = Omit<SaliencyMap, 'scaleX' | 'scaleY'>;
export type RawConfidenceMap = Omit<ConfidenceMap, 'scaleX' | 'scaleY'>;

/**
 * What the public session needs of an engine, in this thread or in a worker. `run` resolves to `null` when it saw the
 * abort.
 */
export interface Engine {
  request: <N extends RequestName>(name: N, ...args: Arguments<N>) => Promise<Answer<N>>;
  run: (onProgress: OnProgress, signal: AbortSignal) => Promise<RawResult | null>;
  /** As `run`, no further than the trajectories. */
  track: (onProgress: OnProgress, signal: AbortSignal) => Promise<TrajectoryList | null>;
  /** No further window comes: helpers have nothing left to do. */
  rest: () => void;
  close: () => void;
}

export async function createLocalEngine(
  module: WebAssembly.Module,
  parameters: Record<string, unknown>,
): Promise<LocalEngine> {
  const owner = await instance(module);
  return new LocalEngine(
    owner,
    guarded(owner, (glue) => new glue.Session(parameters)),
  );
}

export class LocalEngine implements Engine {
  #owner;
  /** None once it is closed: it would keep the instance's memory. */
  #session: Session | undefined;
  #last: Promise<unknown> = Promise.resolve();
  #seconds: Partial<Record<Stage, number>> = {};
  #inShots = false;
  /** When the last step ended, in milliseconds. */
  #clock = 0;
  #closed = false;
  /** Helpers that work on pieces of the run. */
  pool = new Pool();
  /** Who starts them, where that is done in this thread. */
  crew: Crew | undefined;

  constructor(owner: Instance, session: Session) {
    this.#owner = owner;
    this.#session = session;
  }

  request<N extends RequestName>(name: N, ...args: Arguments<N>): Promise<Answer<N>> {
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

  run(onProgress: OnProgress, signal: AbortSignal) {
    return this.#work(onProgress, signal, undefined, (session) => this.#result(session));
  }

  track(onProgress: OnProgress, signal: AbortSignal) {
    return this.#work(onProgress, signal, 'trajectories', (session) => session.trajectories());
  }

  /** Steps to the end, or to the end of a stage. */
  #work<T>(
    onProgress: OnProgress,
    signal: AbortSignal,
    last: Stage | undefined,
    answer: (session: Session) => T,
  ): Promise<T | null> {
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
   * @param until the stage that is the last one, if not all are wanted
   */
  #slice(onProgress: OnProgress, until: Stage | undefined): 'more' | 'waiting' | 'done' {
    const began = performance.now();
    let last: Progress | undefined;
    for (let steps = 1; ; steps += 1) {
      const pause = this.#call((session) => this.#help(session));
      if (!pause) {
        const progress = this.#call((session) => session.step()) as Progress | undefined;
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
   */
  #help(session: Session): 'more' | 'waiting' | undefined {
    this.pool.exchange(session);
    if (!this.pool.busy || !session.awaits()) return undefined;
    return session.makePiece(this.pool.ahead) ? 'more' : 'waiting';
  }

  /** What went by since the last step counts for this one. */
  #count(stage: Stage) {
    const now = performance.now();
    this.#seconds[stage] = (this.#seconds[stage] ?? 0) + Math.max(0, now - this.#clock) / 1000;
    this.#clock = now;
  }

  #result(session: Session): RawResult {
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

  #call<T>(call: (session: Session) => T): T {
    try {
      return guarded(this.#owner, () => call(this.#session!));
    } finally {
      // It would keep the memory of an instance that has ended.
      if (!this.#owner.glue) this.#session = undefined;
    }
  }

  /** Runs `work` when everything before it is over, however that ended. */
  #inOrder<T>(work: () => Promise<T>): Promise<T> {
    const mine = this.#last.then(work);
    this.#last = mine.catch(() => {});
    return mine;
  }
}

/** The masks of all frames, one after the other, and how many pixels each object has in each. */
function allMasks(session: Session, { numFrames, width, height }: Info, known: Uint8Array) {
  const labels = new Uint8Array(numFrames * width * height);
  const areas = Array.from(known, (label) => ({ label, areas: new Uint32Array(numFrames) }));
  for (let t = 0; t < numFrames; t += 1) {
    const mask = session.labels(t);
    labels.set(mask, t * width * height);
    const pixels = new Uint32Array(256);
    for (const label of mask) pixels[label]! += 1;
    for (const object of areas) object.areas[t] = pixels[object.label]!;
  }
  return { labels, areas };
}

/** Whether a slice is over; one during which the clock was put back is. */
function isOver(began: number) {
  const past = performance.now() - began;
  return past < 0 || past >= SLICE_MS;
}

let nextTask: (() => Promise<void>) | undefined;

/** Lets waiting messages and events in. `setTimeout` would do, but browsers make nested ones wait 4 ms. */
function macrotask() {
  nextTask ??= taskSource();
  return nextTask();
}

function taskSource() {
  if (typeof setImmediate === 'function') return () => new Promise<void>((resolve) => setImmediate(resolve));
  return globalThis.MessageChannel ? channelTask() : breath;
}

function channelTask() {
  const { port1, port2 } = new MessageChannel();
  const waiting: (() => void)[] = [];
  port1.onmessage = () => waiting.shift()?.();
  return () =>
    new Promise<void>((resolve) => {
      waiting.push(resolve);
      port2.postMessage(null);
    });
}
