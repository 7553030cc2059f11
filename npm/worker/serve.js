// What a worker does: it serves a session, helps one, or enlarges masks.

import { TraceCutError } from '../check/errors.js';
import { createLocalEngine } from '../session/engine.js';
import { REQUESTS } from '../session/requests.js';
import { enlargeHere } from './decode.js';
import { guarded, instance } from './instance.js';
import { transferables } from './protocol.js';

/** @typedef {import('./protocol.js').Reply} Reply */

/**
 * Answers the requests that arrive at `port`, for one session; or helps another, or enlarges masks.
 * @param {import('./protocol.js').Port} port
 */
export function serve(port) {
  /** @type {Promise<import('../session/engine.js').LocalEngine>} */
  let engine = Promise.reject(new TraceCutError('state', 'the first request must be "create"'));
  engine.catch(() => {});
  /** @type {Map<number, AbortController>} */
  const runs = new Map();

  /** @param {Reply} reply */
  const post = (reply) => port.postMessage(reply, transferables(reply.data));

  /**
   * @param {number} id
   * @param {'run' | 'track'} type
   */
  async function run(id, type) {
    const controller = new AbortController();
    runs.set(id, controller);
    const report = (/** @type {import('../session/engine.js').Progress} */ data) =>
      post({ id, type: 'progress', data });
    const running = (await engine)[type](report, controller.signal);
    return running.finally(() => runs.delete(id));
  }

  /** @param {{id: number} & import('./protocol.js').Message} request */
  async function answer({ id, type, data }) {
    if (type === 'create') {
      engine = createLocalEngine(data.module, data.parameters);
      await engine;
      return undefined;
    }
    if (type === 'enlarge') return enlargeHere(data);
    if (type === 'help') return help(data.port, data.module, data.parameters);
    if (type === 'helper') return (await engine).pool.add(data.number, data.port);
    if (type === 'lost') return (await engine).pool.lose(data.number);
    if (type === 'run' || type === 'track') return run(id, type);
    if (!Object.keys(REQUESTS).includes(type)) throw new TraceCutError('state', `unknown request "${type}"`);
    return (await engine).request(type, ...data);
  }

  port.addEventListener('message', async ({ data: request }) => {
    if (request.type === 'abort') {
      runs.get(request.id)?.abort();
      return;
    }
    try {
      post({ id: request.id, type: 'done', data: await answer(request) });
    } catch (error) {
      const { code = 'poisoned', message } = /** @type {Partial<TraceCutError> & Error} */ (error);
      post({ id: request.id, type: 'failed', data: { code, message } });
    }
  });
}

/**
 * Answers each piece that arrives at `port` with what became of it, or with `null` if that failed.
 * @param {import('./helpers.js').HelperPort} port
 * @param {WebAssembly.Module} module
 * @param {Record<string, unknown>} parameters those of the session that it helps
 */
export function help(port, module, parameters) {
  const open = async () => {
    const owner = await instance(module);
    return { owner, session: guarded(owner, (glue) => new glue.Session(parameters)) };
  };
  let helper = open();
  /** @type {Promise<unknown>} */
  let last = Promise.resolve();

  /** @param {Uint32Array} piece */
  async function answer(piece) {
    try {
      const { owner, session } = await helper;
      const made = guarded(owner, () => session.workOn(piece));
      port.postMessage(made, [/** @type {ArrayBuffer} */ (made.buffer)]);
    } catch {
      // The session will make it itself, and say what is wrong; the next piece gets a fresh instance.
      helper = open();
      helper.catch(() => {});
      port.postMessage(new Uint32Array(), []);
    }
  }

  port.addEventListener('message', ({ data }) => {
    last = last.then(() => answer(/** @type {Uint32Array} */ (data)));
  });
  port.start();
}
