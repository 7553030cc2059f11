// Random stories of the JavaScript interface: calls of sessions, videos and engines, with aborts, closes, errors and wrong
// inputs in between, and a model of the valid answers. Runs in Node and in pages; a number names a story.

import { fingerprint } from './fingerprint.mjs';

/** Codes that an error may have: those of the documentation. */
export const CODES = [
  'frame-size frame-bytes frame-size-changed too-few-frames decode param data state too-large unsupported wasm-load',
  'poisoned closed busy no-video codec truncated no-frames fetch',
]
  .join(' ')
  .split(' ');

/** No call takes this long, on any machine; the end of a story that hangs. */
const PATIENCE_MS = 120_000;
const SIZE = { width: 48, height: 36 };
const FRAMES = 4;

/** Whole numbers below `n` by xorshift: the same story for the same number. */
function dice(seed) {
  let state = (Math.imul(seed + 1, 0x9e3779b1) ^ 0x5bd1e995) >>> 0 || 1;
  return (n) => {
    state ^= state << 13;
    state ^= state >>> 17;
    state ^= state << 5;
    state >>>= 0;
    return Math.floor((state / 2 ** 32) * n);
  };
}

/**
 * What all stories need: the frames, and what plain runs of some of them give.
 * @param {typeof import('./entries.mjs')} api
 * @param {import('../dist/index.js').SessionOptions} [options] where the engine runs
 */
export async function prepare(api, options = {}) {
  const clip = await api.synthClip({ ...SIZE, frames: FRAMES, seed: 5 });
  const frames = Array.from({ length: FRAMES }, (_, t) => clip.frame(t));
  clip.close();
  const plain = new Map();
  for (let count = 2; count <= FRAMES; count += 1) plain.set(count, await plainRun(api, frames.slice(0, count)));
  const video = videoPrint(await api.segmentVideo(frames, { window: 3, overlap: 1 }).collect());
  return { api, options, frames, plain, video };
}

async function plainRun(api, frames, options) {
  const session = await api.createSession(options);
  for (const frame of frames) await session.push(frame);
  const print = fingerprint(await session.run());
  session.close();
  return print;
}

const videoPrint = (video) => JSON.stringify(Array.from({ length: video.numFrames }, (_, t) => [...video.labels(t)]));

/**
 * Plays a story and then a plain run, which must give what it always gives.
 * @param {Awaited<ReturnType<typeof prepare>>} world
 * @param {number} seed
 * @param {number} steps
 * @returns {Promise<Record<string, number>>} how often each answer came, by call and code
 */
export async function play(world, seed, steps) {
  const story = new Story(world, dice(seed), seed);
  for (let k = 0; k < steps; k += 1) await story.step();
  await story.end();
  const last = await story.patient(plainRun(world.api, world.frames, world.options), 'the plain run');
  if (last !== world.plain.get(FRAMES)) throw new Error(`story ${seed}: the plain run after it gave another result`);
  return story.counts;
}

class Story {
  /** @type {Told[]} */
  sessions = [];
  open = new Set();
  counts = {};
  lines = [];

  constructor(world, roll, seed) {
    Object.assign(this, { world, roll, seed });
  }

  async step() {
    const { roll } = this;
    const kind = roll(20);
    if (kind === 0 || this.sessions.length === 0) return this.create();
    if (kind === 1) return this.video();
    if (kind === 2) return this.pictures();
    const told = this.pick(this.sessions);
    return told.step();
  }

  /** Closes all and waits for whatever is still on its way. */
  async end() {
    for (const told of this.sessions) told.close();
    for (const promise of this.open) await this.patient(promise, 'what was left open');
  }

  pick(list) {
    return list[this.roll(list.length)];
  }

  /** Ends the story where a promise does not settle. */
  async patient(promise, words) {
    let timer;
    const late = new Promise((_, reject) => {
      timer = setTimeout(() => reject(this.fault(`${words} hangs`)), PATIENCE_MS);
    });
    return Promise.race([promise, late]).finally(() => clearTimeout(timer));
  }

  fault(words) {
    return new Error(`story ${this.seed}: ${words}, after:\n${this.lines.slice(-12).join('\n')}`);
  }

  /**
   * Makes a call and looks at its answer: `ok`, a code of the documentation, or `own` for the caller's own reason.
   * @param {string} words
   * @param {() => Promise<unknown>} call
   * @param {{legal: () => string[], own?: unknown, then?: (value: any) => void}} model `legal` is asked when the answer
   *   is there
   */
  async ask(words, call, { legal, own, then }) {
    this.lines.push(words);
    let answer = 'ok';
    let value;
    try {
      value = await this.patient(call(), words);
    } catch (error) {
      answer = this.codeOf(error, own, words);
    }
    const key = `${words.replace(/\(.*/s, '')} ${answer}`;
    this.counts[key] = (this.counts[key] ?? 0) + 1;
    if (!legal().includes(answer)) throw this.fault(`${words} gave ${answer} (legal: ${legal()})`);
    if (answer === 'ok') then?.(value);
    return answer;
  }

  codeOf(error, own, words) {
    if (own !== undefined && error === own) return 'own';
    const { TraceCutError } = this.world.api;
    if (!(error instanceof TraceCutError)) throw this.fault(`${words} gave ${error?.stack ?? error}`);
    if (!CODES.includes(error.code) || !error.message) throw this.fault(`${words}: unknown code ${error.code}`);
    return error.code;
  }

  /** A call that nobody waits for now. */
  later(promise) {
    const settled = promise.finally(() => this.open.delete(settled));
    settled.catch(() => {});
    this.open.add(settled);
  }

  async create() {
    if (this.sessions.length >= 3) this.sessions.shift().close();
    const { api, options } = this.world;
    const wrong = this.pick([undefined, undefined, undefined, ...WRONG_OPTIONS]);
    const legal = () => (wrong === undefined ? ['ok'] : ['param', 'unsupported', 'wasm-load']);
    const given = wrong === undefined ? options : wrong && typeof wrong === 'object' ? { ...options, ...wrong } : wrong;
    const then = (session) => this.sessions.push(new Told(this, session));
    const answer = await this.ask(`createSession(${typeof wrong})`, () => api.createSession(given), { legal, then });
    if (answer !== 'ok' || this.roll(3) === 0) return;
    const told = this.sessions.at(-1);
    for (let k = 0; k < FRAMES; k += 1) await told.push();
    if (this.roll(2)) await told.run();
  }

  /** A video whose source may fail, never end or go on after it was told to stop. */
  async video() {
    const { api, frames, options, video } = this.world;
    const [own, stop] = [new Error('of the source'), new AbortController()];
    const at = this.roll(FRAMES);
    const end = this.pick(['whole', 'throws', 'silent', 'wrong', 'stubborn']);
    const way = this.pick(['collect', 'first', 'abort', 'close', 'pause']);
    const source = storySource(frames, end, at, own);
    const made = api.segmentVideo(source, { ...options, window: 3, overlap: 1, signal: stop.signal });
    const halt = () => (way === 'abort' ? stop.abort(own) : made.close());
    if (end === 'silent' || end === 'stubborn' || way === 'abort' || way === 'close') setTimeout(halt, this.roll(60));
    if (way === 'pause') {
      made.pause();
      setTimeout(() => made.resume(), this.roll(20));
    }
    // What comes first, the fault of the source or the end of the work, is chance.
    const legal = () => ['ok', 'closed', 'own', 'data', 'param', 'frame-bytes', 'no-frames', 'decode'];
    const then = (result) => {
      const whole = end === 'whole' && way !== 'first';
      if (whole && videoPrint(result) !== video) throw this.fault('segmentVideo gave another result');
      if (end === 'throws' || end === 'wrong')
        if (way !== 'first') throw this.fault(`segmentVideo of ${end} gave a result`);
    };
    const call = async () => {
      if (way !== 'first') return made.collect();
      for await (const window of made) return window;
      return null;
    };
    const asked = this.ask(`segmentVideo(${end} at ${at}, ${way})`, call, { legal, own, then });
    if (this.roll(2)) return this.later(asked);
    await asked;
    await this.ask('second collect()', () => made.collect(), { legal: () => ['state', 'closed'] });
    made.close();
  }

  /** An engine for single images, closed at some time. */
  async pictures() {
    const { api, frames, options } = this.world;
    const { threads, ...ofEngine } = options;
    const engine = await this.patient(api.createImageEngine(ofEngine), 'createImageEngine');
    let closed = false;
    const legal = () => (closed ? ['ok', 'closed'] : ['ok']);
    const asked = [
      this.ask('engine.superpixels()', () => engine.superpixels(frames[0]), { legal }),
      this.ask('engine.boundaries()', () => engine.boundaries(frames[1]), { legal }),
      this.ask('engine.flow()', () => engine.flow(frames[0], frames[1]), { legal }),
      this.ask('engine.flow(wrong)', () => engine.flow(frames[0], 7), { legal: () => ['param', 'data', 'closed'] }),
      this.ask('engine.superpixels(wrong)', () => engine.superpixels(null), {
        legal: () => ['param', 'data', 'closed'],
      }),
    ];
    if (this.roll(2)) await Promise.all(asked);
    closed = true;
    engine.close();
    engine.close();
    await Promise.all(asked);
    await this.ask('engine.boundaries(closed)', () => engine.boundaries(frames[0]), { legal: () => ['closed'] });
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

/** Frames of a source that behaves as `end` says from frame `at` on. */
async function* storySource(frames, end, at, own) {
  for (const [t, frame] of frames.entries()) {
    if (t === at && end === 'throws') throw own;
    if (t === at && end === 'silent') await new Promise(() => {});
    if (t === at && end === 'wrong') yield { data: new Uint8Array(3), width: 5, height: 5 };
    try {
      yield frame;
    } finally {
      // Whoever is told to stop and goes on all the same.
      if (end === 'stubborn') yield frame;
    }
  }
}

/** What is known of a session that holds nothing. */
const EMPTY = { pushed: 0, begun: false, finished: false, given: false };

/**
 * A session, and what is known of it: whether it is closed, how many runs are under way, and since it was cleared: how many
 * frames were pushed, whether a run has begun or ended, and whether trajectories were given.
 */
class Told {
  closed = false;
  /** How many runs nobody has heard the end of. */
  running = 0;
  result = null;

  constructor(story, session) {
    Object.assign(this, EMPTY, { story, session, roll: story.roll, frames: story.world.frames });
  }

  step() {
    const way = this.roll(24);
    if (this.finished && this.running === 0 && way < 8) return this.correct();
    if (way < 8) return this.push();
    if (way < 14) return this.run();
    if (way < 16) return this.map();
    if (way < 20) return this.correct();
    if (way === 20) return this.clear();
    if (way === 21) return this.give();
    if (way === 22) return this.askResult();
    return this.roll(4) === 0 ? this.close() : undefined;
  }

  /**
   * Makes a call. A closed session refuses all; one with a run under way too, but a run that nobody waits for may be over
   * by the time that the call is made.
   * @param {string} words
   * @param {() => Promise<unknown>} call
   * @param {string[]} otherwise what it may answer otherwise
   * @param {{own?: unknown, then?: (value: any) => void}} [more]
   */
  ask(words, call, otherwise, more = {}) {
    const { closed, running } = this;
    const legal = () => {
      if (closed) return ['closed'];
      return [...otherwise, ...(running > 0 ? ['busy'] : []), ...(this.closed ? ['closed'] : [])];
    };
    return this.story.ask(words, call, { legal, ...more });
  }

  close() {
    this.story.lines.push('close()');
    this.closed = true;
    this.session[this.story.pick(['close', 'free'])]();
  }

  async push() {
    if (this.roll(6) === 0) return this.pushWrong();
    if (this.pushed >= FRAMES) return undefined;
    const frame = this.frames[this.pushed];
    const answers = this.finished ? ['state'] : this.begun || this.given ? ['ok', 'state', 'data'] : ['ok'];
    const wasRunning = this.running;
    await this.ask(`push(${this.pushed})`, () => this.session.push(frame), answers, { then: () => (this.pushed += 1) });
    if (wasRunning || this.running > 0 || this.closed || this.given) return undefined;
    if (this.session.numFrames !== this.pushed) throw this.story.fault(`numFrames is ${this.session.numFrames}`);
    return undefined;
  }

  pushWrong() {
    const frame = this.story.pick(WRONG_FRAMES);
    return this.ask('push(wrong)', () => this.session.push(frame), [
      ...['param', 'data', 'decode', 'frame-size', 'frame-bytes', 'frame-size-changed', 'state'],
    ]);
  }

  /** What a run may end in, however it is ended. */
  async run() {
    if (this.roll(8) === 0) {
      const options = this.story.pick(WRONG_RUNS);
      return this.ask('run(wrong)', () => this.session.run(options), ['param']);
    }
    const loose = this.given || this.running > 0;
    const whole = loose ? ['ok', 'too-few-frames', 'state', 'data'] : this.pushed < 2 ? ['too-few-frames'] : ['ok'];
    return this.#work('run', (options) => this.session.run(options), whole);
  }

  /** Work that may be aborted, closed, or ended by its `onProgress`, awaited or not. */
  async #work(name, call, whole) {
    const { roll, story } = this;
    const [own, stop] = [new Error('enough'), new AbortController()];
    const end = story.pick(['none', 'none', 'early', 'progress', 'soon', 'thrown', 'close']);
    const onProgress = this.#ending(end, own, stop);
    if (end === 'early') stop.abort(own);
    if (end === 'soon') setTimeout(() => stop.abort(own), roll(30));
    const [isFirst, isFree] = [this.running === 0 && !this.closed, end !== 'early' && !name.endsWith('Wrong')];
    const then = (result) => this.#found(name, result);
    const asked = this.ask(
      `${name}(${end})`,
      () => call({ onProgress, signal: stop.signal }),
      end === 'none' ? whole : [...whole, 'own'],
      { own, then },
    );
    this.running += 1;
    if (isFree) this.begun = true;
    const over = asked.finally(() => (this.running -= 1));
    // In the meantime everything else is refused.
    if (isFirst && isFree && name === 'run') await story.ask('clear(at once)', () => this.session.clear(), BUSY);
    if (roll(4) === 0) story.later(over);
    else await over;
  }

  /** What hears of progress, and ends the work after some of it. */
  #ending(end, own, stop) {
    let left = this.roll(6);
    return () => {
      left -= 1;
      if (left >= 0) return;
      if (end === 'progress') stop.abort(own);
      if (end === 'thrown') throw own;
      if (end === 'close') this.close();
    };
  }

  #found(name, result) {
    Object.assign(this, { result, finished: true });
    if (name !== 'run' || this.given || this.session.corrections > 0) return;
    if (fingerprint(result) !== this.story.world.plain.get(result.numFrames))
      throw this.story.fault(`a run of ${result.numFrames} frames gave another result`);
  }

  /** Maps of frames that are there, and of some that are not. */
  async map() {
    const name = this.story.pick(['flow', 'boundaries', 'superpixels', 'saliencyMap', 'background']);
    const t = this.story.pick([0, 1, FRAMES - 1, -1, 1.5, NaN, '0', undefined, 99]);
    const isWrong = !Number.isInteger(t) || t < 0 || t > Math.max(0, this.session.numFrames - 1);
    const answers = isWrong ? ['param'] : ['ok', 'state', 'param'];
    await this.ask(`${name}(${String(t)})`, () => this.session[name](t), answers);
  }

  async correct() {
    const { session, roll } = this;
    const stroke = (t, x) => ({ t, points: [x, 10, x + 8, 14], radius: 3 });
    const calls = {
      merge: (o) => session.merge(roll(3), 1 + roll(3), o),
      mergeWrong: (o) => session.merge(-1, 'x', o),
      split: (o) => session.split(roll(2), { t: 0, x: roll(SIZE.width), y: roll(SIZE.height) }, o),
      splitWrong: (o) => session.split(0, { t: 9.5 }, o),
      together: (o) => session.together([stroke(0, 8), stroke(1, 20)], o),
      apart: (o) => session.apart([stroke(0, 4), stroke(0, 30)], o),
      apartWrong: (o) => session.apart('there', o),
      undo: (o) => session.undo(o),
    };
    const name = this.story.pick(Object.keys(calls));
    const wrong = ['param', 'data', 'state'];
    return this.#work(name, calls[name], name.endsWith('Wrong') ? wrong : ['ok', 'too-few-frames', ...wrong]);
  }

  async clear() {
    await this.ask('clear()', () => this.session.clear(), ['ok'], { then: () => Object.assign(this, EMPTY) });
  }

  /** Trajectories from outside: wrong ones, or those of an earlier result. */
  async give() {
    const wrong = this.roll(2) === 0 || !this.result;
    const tracks = wrong
      ? this.story.pick(WRONG_TRACKS)
      : { ...SIZE, numFrames: this.result.numFrames, ...this.result.trajectories };
    const answers = ['param', 'data', 'state', ...(wrong ? [] : ['ok'])];
    const words = `setTrajectories(${wrong ? 'wrong' : 'known'})`;
    await this.ask(words, () => this.session.setTrajectories(tracks), answers, { then: () => (this.given = true) });
  }

  /** A result answers from what it has for ever, and asks its session as long as that may be asked. */
  async askResult() {
    if (!this.result) return;
    const legal = () => ['ok', 'closed', 'state', 'busy', 'param'];
    await this.story.ask('result.superpixels()', () => this.result.superpixels(0), { legal });
    if (fingerprint(this.result).length < 10) throw this.story.fault('a result is gone');
  }
}

const BUSY = { legal: () => ['busy'] };
const WRONG_RUNS = [null, 7, 'now', { signal: 1 }, { onProgress: 'x' }, { signal: { addEventListener() {} } }];
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
