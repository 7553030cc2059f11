// Random call sequences of the JavaScript interface: sessions, videos and image engines, with aborts, closes, errors and wrong
// inputs in between, and a model of the valid outcomes. Runs in Node and in pages; a seed names a sequence.

import { fingerprint } from './fingerprint.mjs';

/** Codes of errors in the documentation. */
export const CODES = [
  'frame-size frame-bytes frame-size-changed too-few-frames decode param data state too-large unsupported wasm-load',
  'poisoned closed busy no-video codec truncated no-frames fetch',
]
  .join(' ')
  .split(' ');

/** No call takes this long on any machine: a sequence that hangs fails with its calls. */
const TIMEOUT_MS = 300_000;
const SIZE = { width: 48, height: 36 };
const NUM_FRAMES = 4;
const MAX_SESSIONS = 3;

/** Returns a function that gives whole numbers below `n`, by xorshift: the same numbers for the same seed. */
function createRandom(seed) {
  let state = (Math.imul(seed + 1, 0x9e3779b1) ^ 0x5bd1e995) >>> 0 || 1;
  return (n) => {
    state ^= state << 13;
    state ^= state >>> 17;
    state ^= state << 5;
    state >>>= 0;
    return Math.floor((state / 2 ** 32) * n);
  };
}

/** Waits for `count` turns of the event loop. */
async function waitTurns(count) {
  const { port1, port2 } = new MessageChannel();
  for (let k = 0; k < count; k += 1)
    await new Promise((resolve) => {
      port1.onmessage = resolve;
      port2.postMessage('');
    });
  port1.close();
}

/**
 * Computes what all sequences need: frames, and the results of plain runs.
 *
 * @param {typeof import('./entries.mjs')} api
 * @param {import('../dist/index.js').SessionOptions} [options] where the engine runs in sequences
 */
export async function prepareSequences(api, options = {}) {
  const clip = await api.synthClip({ ...SIZE, frames: NUM_FRAMES, seed: 5 });
  const frames = Array.from({ length: NUM_FRAMES }, (_, t) => clip.frame(t));
  clip.close();
  const runPrints = new Map();
  for (let count = 2; count <= NUM_FRAMES; count += 1)
    runPrints.set(count, await printRun(api, frames.slice(0, count)));
  const videoPrint = printVideo(await api.segmentVideo(frames, { window: 3, overlap: 1 }).collect());
  return { api, options, frames, runPrints, videoPrint };
}

async function printRun(api, frames, options) {
  const session = await api.createSession(options);
  for (const frame of frames) await session.push(frame);
  const print = fingerprint(await session.run());
  session.close();
  return print;
}

const printVideo = (video) => JSON.stringify(Array.from({ length: video.numFrames }, (_, t) => [...video.labels(t)]));

/**
 * Makes the calls of a sequence, and then a plain run, which must give the usual result.
 *
 * @param {Awaited<ReturnType<typeof prepareSequences>>} setup
 * @returns {Promise<Record<string, number>>} the number of each outcome, by call and code
 */
export async function runSequence(setup, seed, numSteps) {
  const sequence = new CallSequence(setup, seed);
  for (let k = 0; k < numSteps; k += 1) await sequence.step();
  await sequence.end();
  const print = await sequence.withTimeout(printRun(setup.api, setup.frames, setup.options), 'the plain run');
  if (print !== setup.runPrints.get(NUM_FRAMES)) throw sequence.error('the plain run gave another result');
  return sequence.counts;
}

class CallSequence {
  /** @type {SessionModel[]} */
  sessions = [];
  pending = new Set();
  counts = {};
  calls = [];

  constructor(setup, seed) {
    Object.assign(this, { setup, random: createRandom(seed), seed });
  }

  async step() {
    const kind = this.random(20);
    if (kind === 0 || this.sessions.length === 0) return this.createSession();
    if (kind === 1) return this.segmentVideo();
    if (kind === 2) return this.useImageEngine();
    return this.pick(this.sessions).step();
  }

  /** Closes all sessions and waits for pending calls. */
  async end() {
    for (const session of this.sessions) session.close();
    for (const promise of this.pending) await this.withTimeout(promise, 'a pending call');
  }

  pick(list) {
    return list[this.random(list.length)];
  }

  /** Rejects if a promise does not settle. */
  withTimeout(promise, call) {
    let timer;
    const timeout = new Promise((_, reject) => {
      timer = setTimeout(() => reject(this.error(`${call} hangs`)), TIMEOUT_MS);
    });
    return Promise.race([promise, timeout]).finally(() => clearTimeout(timer));
  }

  error(message) {
    return new Error(`sequence ${this.seed}: ${message}, after:\n${this.calls.slice(-12).join('\n')}`);
  }

  /**
   * Makes a call and checks its outcome: `ok`, a code, or `reason` if the caller's own reason is thrown.
   *
   * @param {string} name
   * @param {() => Promise<unknown>} call
   * @param {{allowed: () => string[], reason?: unknown, check?: (value: any) => void}} model `allowed` is called after the
   *   outcome is known
   */
  async call(name, call, { allowed, reason, check }) {
    this.calls.push(name);
    let outcome = 'ok';
    let value;
    try {
      value = await this.withTimeout(call(), name);
    } catch (error) {
      outcome = this.outcomeOf(error, reason, name);
    }
    const key = `${name.replace(/\(.*/s, '')} ${outcome}`;
    this.counts[key] = (this.counts[key] ?? 0) + 1;
    if (!allowed().includes(outcome)) throw this.error(`${name} gave ${outcome} (allowed: ${allowed()})`);
    if (outcome === 'ok') check?.(value);
    return outcome;
  }

  outcomeOf(error, reason, name) {
    if (reason !== undefined && error === reason) return 'reason';
    if (!(error instanceof this.setup.api.TraceCutError)) throw this.error(`${name} gave ${error?.stack ?? error}`);
    if (!CODES.includes(error.code) || !error.message) throw this.error(`${name}: unknown code ${error.code}`);
    return error.code;
  }

  /** Keeps a call pending. */
  defer(promise) {
    const call = promise.finally(() => this.pending.delete(call));
    call.catch(() => {});
    this.pending.add(call);
  }

  async createSession() {
    if (this.sessions.length >= MAX_SESSIONS) this.sessions.shift().close();
    const { api, options } = this.setup;
    const wrong = this.pick([undefined, undefined, undefined, ...WRONG_OPTIONS]);
    const allowed = () => (wrong === undefined ? ['ok'] : ['param', 'unsupported', 'wasm-load']);
    const argument =
      wrong === undefined ? options : wrong && typeof wrong === 'object' ? { ...options, ...wrong } : wrong;
    const check = (session) => this.sessions.push(new SessionModel(this, session));
    const name = `createSession(${typeof wrong})`;
    const outcome = await this.call(name, () => api.createSession(argument), { allowed, check });
    if (outcome !== 'ok' || this.random(3) === 0) return;
    const session = this.sessions.at(-1);
    for (let k = 0; k < NUM_FRAMES; k += 1) await session.push();
    if (this.random(2)) await session.run();
  }

  /** Segments a video whose source may fail, never end or continue after it was cancelled. */
  async segmentVideo() {
    const { api, frames, options, videoPrint } = this.setup;
    const [reason, controller] = [new Error('of the source'), new AbortController()];
    const at = this.random(NUM_FRAMES);
    const ending = this.pick(['complete', 'throws', 'silent', 'wrong', 'stubborn']);
    const use = this.pick(['collect', 'first', 'abort', 'close', 'pause']);
    const source = createSource(frames, ending, at, reason);
    const video = api.segmentVideo(source, { ...options, window: 3, overlap: 1, signal: controller.signal });
    const stop = () => (use === 'abort' ? controller.abort(reason) : video.close());
    if (ending === 'silent' || ending === 'stubborn' || use === 'abort' || use === 'close')
      waitTurns(this.random(200)).then(stop);
    if (use === 'pause') {
      video.pause();
      waitTurns(this.random(50)).then(() => video.resume());
    }
    // Whether the error of the source or the end of the work comes first is left to chance.
    const allowed = () => ['ok', 'closed', 'reason', 'data', 'param', 'frame-bytes', 'no-frames', 'decode'];
    const check = (result) => {
      if (use === 'first') return;
      if (ending === 'complete' && printVideo(result) !== videoPrint)
        throw this.error('segmentVideo gave another result');
      if (ending === 'throws' || ending === 'wrong') throw this.error(`segmentVideo of ${ending} gave a result`);
    };
    const segment = async () => {
      if (use !== 'first') return video.collect();
      for await (const window of video) return window;
      return null;
    };
    const promise = this.call(`segmentVideo(${ending} at ${at}, ${use})`, segment, { allowed, reason, check });
    if (this.random(2)) return this.defer(promise);
    await promise;
    await this.call('second collect()', () => video.collect(), { allowed: () => ['state', 'closed'] });
    video.close();
  }

  /** Uses an engine for single images, and closes it at some time. */
  async useImageEngine() {
    const { api, frames, options } = this.setup;
    const { threads, ...engineOptions } = options;
    const engine = await this.withTimeout(api.createImageEngine(engineOptions), 'createImageEngine');
    let closed = false;
    const allowed = () => (closed ? ['ok', 'closed'] : ['ok']);
    const refused = { allowed: () => ['param', 'data', 'closed'] };
    const promises = [
      this.call('engine.superpixels()', () => engine.superpixels(frames[0]), { allowed }),
      this.call('engine.boundaries()', () => engine.boundaries(frames[1]), { allowed }),
      this.call('engine.flow()', () => engine.flow(frames[0], frames[1]), { allowed }),
      this.call('engine.flow(wrong)', () => engine.flow(frames[0], 7), refused),
      this.call('engine.superpixels(wrong)', () => engine.superpixels(null), refused),
    ];
    if (this.random(2)) await Promise.all(promises);
    closed = true;
    engine.close();
    engine.close();
    await Promise.all(promises);
    await this.call('engine.boundaries(closed)', () => engine.boundaries(frames[0]), { allowed: () => ['closed'] });
  }
}

const WRONG_OPTIONS = [
  null,
  7,
  'fast',
  { flow: { patchStride: -1 } },
  { clip: 3 },
  { worker: 'yes' },
  { threads: -1 },
  { speed: 1 },
];

/** Yields frames, and behaves as `ending` says from frame `at` on. */
async function* createSource(frames, ending, at, reason) {
  for (const [t, frame] of frames.entries()) {
    if (t === at && ending === 'throws') throw reason;
    if (t === at && ending === 'silent') await new Promise(() => {});
    if (t === at && ending === 'wrong') yield { data: new Uint8Array(3), width: 5, height: 5 };
    try {
      yield frame;
    } finally {
      // Continues although it was cancelled.
      if (ending === 'stubborn') yield frame;
    }
  }
}

/** State of a session without frames. */
const EMPTY = { numPushed: 0, begun: false, finished: false, hasTracks: false };

/**
 * Model of a session: whether it is closed, how many runs are pending, and since it was last cleared how many frames were
 * pushed, whether a run has begun or ended, and whether trajectories were set.
 */
class SessionModel {
  closed = false;
  numRunning = 0;
  result = null;

  constructor(sequence, session) {
    const { random, setup } = sequence;
    Object.assign(this, EMPTY, { sequence, session, random, frames: setup.frames });
  }

  step() {
    const kind = this.random(24);
    if (this.finished && this.numRunning === 0 && kind < 8) return this.correct();
    if (kind < 8) return this.push();
    if (kind < 14) return this.run();
    if (kind < 16) return this.readMap();
    if (kind < 20) return this.correct();
    if (kind === 20) return this.clear();
    if (kind === 21) return this.setTrajectories();
    if (kind === 22) return this.useResult();
    return this.random(4) === 0 ? this.close() : undefined;
  }

  /**
   * Makes a call. A closed session refuses all; a running one is busy, unless a pending run ends before the call is made.
   *
   * @param {string[]} outcomes allowed otherwise
   */
  call(name, call, outcomes, more = {}) {
    const { closed, numRunning } = this;
    const allowed = () =>
      closed ? ['closed'] : [...outcomes, ...(numRunning > 0 ? ['busy'] : []), ...(this.closed ? ['closed'] : [])];
    return this.sequence.call(name, call, { allowed, ...more });
  }

  close() {
    this.sequence.calls.push('close()');
    this.closed = true;
    this.session[this.sequence.pick(['close', 'free'])]();
  }

  async push() {
    if (this.random(6) === 0) return this.pushWrong();
    if (this.numPushed >= NUM_FRAMES) return undefined;
    const frame = this.frames[this.numPushed];
    const outcomes = this.finished ? ['state'] : this.begun || this.hasTracks ? ['ok', 'state', 'data'] : ['ok'];
    const wasRunning = this.numRunning > 0;
    const check = () => (this.numPushed += 1);
    await this.call(`push(${this.numPushed})`, () => this.session.push(frame), outcomes, { check });
    if (wasRunning || this.numRunning > 0 || this.closed || this.hasTracks) return undefined;
    const { numFrames } = this.session;
    if (numFrames !== this.numPushed) throw this.sequence.error(`numFrames is ${numFrames}`);
    return undefined;
  }

  pushWrong() {
    const frame = this.sequence.pick(WRONG_FRAMES);
    const outcomes = ['param', 'data', 'decode', 'frame-size', 'frame-bytes', 'frame-size-changed', 'state'];
    return this.call('push(wrong)', () => this.session.push(frame), outcomes);
  }

  async run() {
    if (this.random(8) === 0) {
      const options = this.sequence.pick(WRONG_RUN_OPTIONS);
      return this.call('run(wrong)', () => this.session.run(options), ['param']);
    }
    const isUncertain = this.hasTracks || this.numRunning > 0;
    const complete = this.numPushed < 2 ? ['too-few-frames'] : ['ok'];
    const outcomes = isUncertain ? ['ok', 'too-few-frames', 'state', 'data'] : complete;
    return this.#work('run', (options) => this.session.run(options), outcomes);
  }

  /** Starts work that may be aborted, closed, or ended by its `onProgress`, and awaits it or not. */
  async #work(name, call, outcomes) {
    const { random, sequence } = this;
    const [reason, controller] = [new Error('enough'), new AbortController()];
    const ending = sequence.pick(['none', 'none', 'early', 'progress', 'soon', 'thrown', 'close']);
    const onProgress = this.#createOnProgress(ending, reason, controller);
    if (ending === 'early') controller.abort(reason);
    if (ending === 'soon') waitTurns(random(100)).then(() => controller.abort(reason));
    const [isFirst, isStarted] = [this.numRunning === 0 && !this.closed, ending !== 'early' && !name.endsWith('Wrong')];
    const promise = this.call(
      `${name}(${ending})`,
      () => call({ onProgress, signal: controller.signal }),
      ending === 'none' ? outcomes : [...outcomes, 'reason'],
      { reason, check: (result) => this.#checkResult(name, result) },
    );
    this.numRunning += 1;
    if (isStarted) this.begun = true;
    const ended = promise.finally(() => (this.numRunning -= 1));
    // Until then everything else is refused.
    if (isFirst && isStarted && name === 'run')
      await sequence.call('clear(at once)', () => this.session.clear(), { allowed: () => ['busy'] });
    if (random(4) === 0) sequence.defer(ended);
    else await ended;
  }

  /** Returns an `onProgress` that ends the work after some reports. */
  #createOnProgress(ending, reason, controller) {
    let numLeft = this.random(6);
    return () => {
      numLeft -= 1;
      if (numLeft >= 0) return;
      if (ending === 'progress') controller.abort(reason);
      if (ending === 'thrown') throw reason;
      if (ending === 'close') this.close();
    };
  }

  #checkResult(name, result) {
    Object.assign(this, { result, finished: true });
    if (name !== 'run' || this.hasTracks || this.session.corrections > 0) return;
    if (fingerprint(result) !== this.sequence.setup.runPrints.get(result.numFrames))
      throw this.sequence.error(`a run of ${result.numFrames} frames gave another result`);
  }

  /** Reads a map of a frame that may not exist. */
  async readMap() {
    const name = this.sequence.pick(['flow', 'boundaries', 'superpixels', 'saliencyMap', 'background']);
    const t = this.sequence.pick([0, 1, NUM_FRAMES - 1, -1, 1.5, NaN, '0', undefined, 99]);
    const isWrong = !Number.isInteger(t) || t < 0 || t > Math.max(0, this.session.numFrames - 1);
    const outcomes = isWrong ? ['param'] : ['ok', 'state', 'param'];
    await this.call(`${name}(${String(t)})`, () => this.session[name](t), outcomes);
  }

  async correct() {
    const { session, random } = this;
    const stroke = (t, x) => ({ t, points: [x, 10, x + 8, 14], radius: 3 });
    const calls = {
      merge: (options) => session.merge(random(3), 1 + random(3), options),
      mergeWrong: (options) => session.merge(-1, 'x', options),
      split: (options) => session.split(random(2), { t: 0, x: random(SIZE.width), y: random(SIZE.height) }, options),
      splitWrong: (options) => session.split(0, { t: 9.5 }, options),
      together: (options) => session.together([stroke(0, 8), stroke(1, 20)], options),
      apart: (options) => session.apart([stroke(0, 4), stroke(0, 30)], options),
      apartWrong: (options) => session.apart('there', options),
      undo: (options) => session.undo(options),
    };
    const name = this.sequence.pick(Object.keys(calls));
    const wrong = ['param', 'data', 'state'];
    return this.#work(name, calls[name], name.endsWith('Wrong') ? wrong : ['ok', 'too-few-frames', ...wrong]);
  }

  async clear() {
    await this.call('clear()', () => this.session.clear(), ['ok'], { check: () => Object.assign(this, EMPTY) });
  }

  /** Sets wrong trajectories, or the ones of an earlier result. */
  async setTrajectories() {
    const isWrong = this.random(2) === 0 || !this.result;
    const tracks = isWrong
      ? this.sequence.pick(WRONG_TRACKS)
      : { ...SIZE, numFrames: this.result.numFrames, ...this.result.trajectories };
    const outcomes = ['param', 'data', 'state', ...(isWrong ? [] : ['ok'])];
    const check = () => (this.hasTracks = true);
    const name = `setTrajectories(${isWrong ? 'wrong' : 'valid'})`;
    await this.call(name, () => this.session.setTrajectories(tracks), outcomes, { check });
  }

  /** Queries a result, which keeps its masks but may lose its session. */
  async useResult() {
    if (!this.result) return;
    const allowed = () => ['ok', 'closed', 'state', 'busy', 'param'];
    await this.sequence.call('result.superpixels()', () => this.result.superpixels(0), { allowed });
    if (fingerprint(this.result).length < 10) throw this.sequence.error('a result is empty');
  }
}

const WRONG_RUN_OPTIONS = [null, 7, 'now', { signal: 1 }, { onProgress: 'x' }, { signal: { addEventListener() {} } }];
const WRONG_TRACKS = [
  null,
  3,
  {},
  { numFrames: 2, width: 9, height: 9, startFrame: [0], offset: [0, 5], x: [1], y: [1] },
];
const WRONG_FRAMES = [
  null,
  undefined,
  7,
  'frame.png',
  {},
  { data: new Uint8ClampedArray(8), width: 48, height: 36 },
  { data: new Uint8ClampedArray(4 * 8 * 8), width: 8, height: -8 },
  { data: new Uint8ClampedArray(0), width: 0, height: 0 },
  new Uint8Array([137, 80, 78, 71, 1, 2, 3]),
  new ArrayBuffer(0),
];
