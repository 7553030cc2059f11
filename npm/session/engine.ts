// Runs a session in this thread: a queue of calls, and a run that steps in slices so that the thread stays responsive.

import { type WorkerPool, Pool } from '../worker/helpers.js';
import { type Instance, callInstance, release, startInstance } from '../worker/instance.js';
import { yieldThread } from '../worker/pause.js';
import { type Answer, type Arguments, type RequestName, getRequestSpec } from './requests.js';
import type { BoundaryMap, Superpixels } from '../stages/image.js';
import type { Session } from '../tracecut.js';
import type { ObjectAreas } from './report.js';
import type {
  Background,
  ClusterList,
  ClusterObjects,
  ComponentTable,
  EdgeTable,
  EmbeddingTable,
  FrameRange,
  SaliencyMap,
  SaliencyTable,
  TrajectoryList,
} from './result.js';

/** Most time between two pauses for messages; one step may take longer. */
const SLICE_MS = 30;
/** Most steps between two pauses, in case the clock stands still. */
const SLICE_STEPS = 16;

/** Stages of a run, in order. */
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
 * A step of a run: `done` of `total` steps of a stage; steps differ in duration. `done` only grows; so does `total` during
 * the cut, and is constant elsewhere.
 */
export type StageStep = { readonly stage: Stage; readonly done: number; readonly total: number };

export type OnStep = (step: StageStep) => void;

/**
 * State of a session: `corrections` is the number in force, `memoryBytes` the linear memory of its wasm instance, which
 * never shrinks.
 */
export type SessionInfo = {
  numFrames: number;
  width: number;
  height: number;
  workingWidth: number;
  workingHeight: number;
  corrections: number;
  memoryBytes: number;
};

/**
 * Motion of each pixel from one frame to the next, in input pixels, row by row: `u` to the right, `v` down. `width` ×
 * `height` is the working size.
 */
export type FlowField = {
  readonly width: number;
  readonly height: number;
  readonly u: Float32Array<ArrayBuffer>;
  readonly v: Float32Array<ArrayBuffer>;
};

/** All results of a finished run, as flat arrays. */
export interface RawResult {
  info: SessionInfo;
  seconds: Partial<Record<Stage, number>>;
  trajectories: TrajectoryList;
  clusters: ClusterList & { object: ClusterObjects['object'] | null };
  thresholdClusters: ClusterList;
  embedding: EmbeddingTable;
  edges: EdgeTable;
  /** Null without frames. */
  saliency: SaliencyTable | null;
  /** Null without frames. */
  components: ComponentTable | null;
  /** Frames whose masks should be looked at; null without masks. */
  doubts: FrameRange[] | null;
  /** Areas of the objects; null without masks. */
  areas: ObjectAreas[] | null;
  /** The masks of all frames, one after the other. */
  labels: Uint8Array<ArrayBuffer> | null;
}

export type RawBoundaryMap = Omit<BoundaryMap, 'scaleX' | 'scaleY'>;
export type RawSuperpixels = Omit<Superpixels, 'scaleX' | 'scaleY'>;
export type RawBackground = Omit<Background, 'scaleX' | 'scaleY'>;
export type RawSaliencyMap = Omit<SaliencyMap, 'scaleX' | 'scaleY'>;

/** An engine of a session, in this thread or in a worker. `run` resolves to `null` when it was aborted. */
export interface Engine {
  request: <N extends RequestName>(name: N, ...args: Arguments<N>) => Promise<Answer<N>>;
  run: (onStep: OnStep, signal: AbortSignal) => Promise<RawResult | null>;
  /** Runs until the end of the trajectories. */
  track: (onStep: OnStep, signal: AbortSignal) => Promise<TrajectoryList | null>;
  /** Releases the helpers, as no further window follows. */
  rest: () => void;
  close: () => void;
}

export async function createLocalEngine(
  module: WebAssembly.Module,
  parameters: Record<string, unknown>,
): Promise<LocalEngine> {
  const owner = await startInstance(module);
  return new LocalEngine(
    owner,
    callInstance(owner, (glue) => new glue.Session(parameters)),
  );
}

export class LocalEngine implements Engine {
  #owner;
  /** Undefined once closed, as it would keep the instance's memory. */
  #session: Session | undefined;
  #queue: Promise<unknown> = Promise.resolve();
  #seconds: Partial<Record<Stage, number>> = {};
  #isWindowed = false;
  /** Time at which the last step ended, in milliseconds. */
  #lastStepEnd = 0;
  #isClosed = false;
  /** Distributes jobs of the run to helpers. */
  pool = new Pool();
  /** Starts the helpers, if this thread does. */
  workers: WorkerPool | undefined;
  /** True to do jobs while the next frame is awaited: in a worker, where nothing else waits. */
  worksAhead = false;

  constructor(owner: Instance, session: Session) {
    this.#owner = owner;
    this.#session = session;
  }

  request<N extends RequestName>(name: N, ...args: Arguments<N>): Promise<Answer<N>> {
    const { work: createCall, restarts } = getRequestSpec(name);
    const isPush = name === 'push' || name === 'pushInShot';
    if (isPush) this.workers?.startMissing();
    this.#isWindowed ||= name === 'pushInShot';
    return this.#enqueue(async () => {
      const call = await createCall(...args);
      if (restarts) this.#seconds = {};
      const answer = this.#call(call);
      // Flow can be computed while frames are still arriving.
      this.#call((session) => this.pool.exchange(session));
      if (isPush && this.worksAhead) this.#workAhead();
      return answer;
    });
  }

  /** Does jobs until there are none, or a request arrives. */
  async #workAhead(): Promise<void> {
    const last = this.#queue;
    await nextTask();
    if (last !== this.#queue || this.#isClosed) return;
    const work = (session: Session) => session.makePiece(this.pool.ahead);
    const hasWorked = await this.#enqueue(async () => this.#call(work)).catch(() => false);
    if (hasWorked) await this.#workAhead();
  }

  run(onStep: OnStep, signal: AbortSignal) {
    return this.#stepUntil(onStep, signal, undefined, (session) => this.#collectResult(session));
  }

  track(onStep: OnStep, signal: AbortSignal) {
    return this.#stepUntil(onStep, signal, 'trajectories', (session) => session.trajectories());
  }

  /** Steps to the end, or to the end of a stage. */
  #stepUntil<T>(
    onStep: OnStep,
    signal: AbortSignal,
    last: Stage | undefined,
    getResult: (session: Session) => T,
  ): Promise<T | null> {
    return this.#enqueue(async () => {
      this.#lastStepEnd = performance.now();
      const wake = () => this.pool.wake();
      signal.addEventListener('abort', wake);
      try {
        while (!signal.aborted && !this.#isClosed) {
          const state = this.#runSlice(onStep, last);
          if (state === 'done') {
            // Helpers have nothing left to do, unless another window follows.
            if (!this.#isWindowed) this.workers?.rest();
            return this.#call(getResult);
          }
          await (state === 'waiting' ? this.pool.next() : nextTask());
        }
      } finally {
        signal.removeEventListener('abort', wake);
      }
      return null;
    });
  }

  rest() {
    this.#isWindowed = false;
    this.workers?.rest();
  }

  close() {
    this.#isClosed = true;
    this.pool.close();
    this.workers?.dismiss();
    this.#enqueue(async () => {
      this.#session = undefined;
      release(this.#owner, 'session');
    });
  }

  /**
   * Steps until the slice is over, nothing is left to do, or the next step waits for a helper. Reports the last step of
   * each stage and of the slice.
   * @param until the last stage, if not all are needed
   */
  #runSlice(onStep: OnStep, until: Stage | undefined): 'more' | 'waiting' | 'done' {
    const began = performance.now();
    let last: StageStep | undefined;
    for (let steps = 1; ; steps += 1) {
      const pause = this.#call((session) => this.#exchangeJobs(session));
      if (!pause) {
        const step = this.#call((session) => session.step()) as StageStep | undefined;
        if (last && step?.stage !== last.stage) onStep(last);
        if (!step) return 'done';
        this.#addTime(step.stage);
        last = step;
        if (step.stage === until && step.done === step.total) {
          onStep(last);
          return 'done';
        }
      }
      if (pause || steps >= SLICE_STEPS || isSliceOver(began)) {
        if (last) onStep(last);
        return pause ?? 'more';
      }
    }
  }

  /**
   * Exchanges jobs with the helpers. While the next step waits for one of them, another job is done here; if there is
   * none, nothing can be done but wait.
   */
  #exchangeJobs(session: Session): 'more' | 'waiting' | undefined {
    this.pool.exchange(session);
    if (!this.pool.busy || !session.awaits()) return undefined;
    return session.makePiece(this.pool.ahead) ? 'more' : 'waiting';
  }

  /** Adds the time since the last step to the step's stage. */
  #addTime(stage: Stage) {
    const now = performance.now();
    this.#seconds[stage] = (this.#seconds[stage] ?? 0) + Math.max(0, now - this.#lastStepEnd) / 1000;
    this.#lastStepEnd = now;
  }

  #collectResult(session: Session): RawResult {
    const info = session.info();
    const objects = session.objects() ?? null;
    const masks = objects && collectMasks(session, info, objects.labels);
    return {
      info,
      seconds: { ...this.#seconds },
      trajectories: session.trajectories(),
      clusters: { ...session.clusters(), object: objects && objects.ofCluster },
      thresholdClusters: session.thresholdClusters(),
      embedding: session.embedding(),
      edges: session.edges(),
      saliency: session.saliency() ?? null,
      components: session.components() ?? null,
      doubts: objects && objects.doubts,
      areas: masks && masks.areas,
      labels: masks && masks.labels,
    };
  }

  #call<T>(call: (session: Session) => T): T {
    try {
      return callInstance(this.#owner, () => call(this.#session!));
    } finally {
      // It would keep the memory of an instance that has ended.
      if (!this.#owner.glue) this.#session = undefined;
    }
  }

  /** Runs `work` after all earlier work has ended, even with an error. */
  #enqueue<T>(work: () => Promise<T>): Promise<T> {
    const result = this.#queue.then(work);
    this.#queue = result.catch(() => {});
    return result;
  }
}

/** Collects the masks of all frames, one after the other, and the number of pixels of each object in each frame. */
function collectMasks(session: Session, { numFrames, width, height }: SessionInfo, objectLabels: Uint8Array) {
  const labels = new Uint8Array(numFrames * width * height);
  const areas = Array.from(objectLabels, (label) => ({ label, areas: new Uint32Array(numFrames) }));
  for (let t = 0; t < numFrames; t += 1) {
    const mask = session.labels(t);
    labels.set(mask, t * width * height);
    const pixels = countLabels(mask);
    for (const object of areas) object.areas[t] = pixels[object.label]!;
  }
  return { labels, areas };
}

/** Counts the pixels of each label, run by run: neighbours mostly have one label. */
function countLabels(mask: Uint8Array) {
  const pixels = new Uint32Array(256);
  for (let from = 0, to = 0; from < mask.length; from = to) {
    const label = mask[from]!;
    while (to < mask.length && mask[to] === label) to += 1;
    pixels[label]! += to - from;
  }
  return pixels;
}

/** Returns true if a slice is over, or the clock was set back during it. */
function isSliceOver(began: number) {
  const elapsed = performance.now() - began;
  return elapsed < 0 || elapsed >= SLICE_MS;
}

let waitForTask: (() => Promise<void>) | undefined;

/** Lets waiting messages and events in. Browsers delay nested calls of `setTimeout` by 4 ms. */
function nextTask() {
  waitForTask ??= createTaskSource();
  return waitForTask();
}

function createTaskSource() {
  if (typeof setImmediate === 'function') return () => new Promise<void>((resolve) => setImmediate(resolve));
  return globalThis.MessageChannel ? createChannelTask() : yieldThread;
}

function createChannelTask() {
  const { port1, port2 } = new MessageChannel();
  const resolvers: (() => void)[] = [];
  port1.onmessage = () => resolvers.shift()?.();
  return () =>
    new Promise<void>((resolve) => {
      resolvers.push(resolve);
      port2.postMessage(null);
    });
}
