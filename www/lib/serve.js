// The worker's side of the protocol.

import { createLocalEngine } from './engine.js';
import { TraceCutError } from './errors.js';
import { transferables } from './protocol.js';

/** @typedef {import('./protocol.js').Request} Request */
/** @typedef {import('./protocol.js').Reply} Reply */

/**
 * Answers the requests that arrive at `port`, for one session.
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

  /** @param {Request} request */
  async function answer({ id, type, data }) {
    switch (type) {
      case 'create':
        engine = createLocalEngine(data.module, data.parameters);
        await engine;
        return undefined;
      case 'push':
        return (await engine).push(data);
      case 'pushInShot':
        return (await engine).pushInShot(data);
      case 'advance':
        return (await engine).advance(data);
      case 'setTrajectories':
        return (await engine).setTrajectories(data);
      case 'correct':
        return (await engine).correct(data);
      case 'flow':
        return (await engine).flow(data);
      case 'boundaries':
        return (await engine).boundaries(data);
      case 'superpixels':
        return (await engine).superpixels(data);
      case 'saliencyMap':
        return (await engine).saliencyMap(data);
      case 'boundariesOf':
        return (await engine).boundariesOf(data);
      case 'superpixelsOf':
        return (await engine).superpixelsOf(data.image, data.count);
      case 'discontinuitiesOf':
        return (await engine).discontinuitiesOf(data);
      case 'clear':
        return (await engine).clear();
      case 'run': {
        const controller = new AbortController();
        runs.set(id, controller);
        const running = (await engine).run((progress) => post({ id, type: 'progress', data: progress }), controller.signal);
        return running.finally(() => runs.delete(id));
      }
      default:
        throw new TraceCutError('state', `unknown request "${type}"`);
    }
  }

  port.addEventListener('message', async ({ data: request }) => {
    if (request.type === 'abort') {
      runs.get(request.id)?.abort();
      return;
    }
    try {
      post({ id: request.id, type: 'done', data: await answer(request) });
    } catch (error) {
      const { code = 'poisoned', message } = /** @type {{code?: string, message: string}} */ (error);
      post({ id: request.id, type: 'failed', data: { code, message } });
    }
  });
}
