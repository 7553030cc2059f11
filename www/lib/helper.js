// A helper's side: it makes what it is given, one piece after the other, in an instance of its own.

import { guarded, instance } from './instance.js';

/**
 * Answers each piece that arrives at `port` with what became of it, or with `null` if that failed.
 * @param {import('./pool.js').HelperPort} port
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
