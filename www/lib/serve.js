// The worker's side of the protocol.

import { createLocalEngine } from './engine.js';
import { enlargeHere } from './enlarge-here.js';
import { TraceCutError } from './errors.js';
import { help } from './helper.js';
import { transferables } from './protocol.js';
import { REQUESTS } from './requests.js';

/** @typedef {import('./protocol.js').Reply} Reply */

/**
 * Answers the requests that arrive at `port`, for one session; or helps another, or enlarges masks.
 * @param {import('./protocol.js').Port} port
 */
export function serve(port) {
  /** @type {Promise<import('./engine.js').LocalEngine>} */
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
    const report = (/** @type {import('./engine.js').Progress} */ data) => post({ id, type: 'progress', data });
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
    if (type === 'run') return run(id, type);
    if (type === 'track') return run(id, type);
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
