// Engines: in a worker, or on this thread with helpers beside it.

import { Crew, usualThreads } from './crew.js';
import { createLocalEngine } from './engine.js';
import { once, platform, workerStarter } from './platform.js';
import { createRemoteEngine } from './remote.js';

/**
 * An engine in a worker where there are workers and the options do not say otherwise (in Node where they ask for one),
 * else in this thread.
 * @param {import('./options.js').SplitOptions} options
 * @returns {Promise<import('./engine.js').Engine>}
 */
export async function openEngine({ wasm, worker, threads, parameters }) {
  const { loadModule, startHelper, cores } = platform;
  const start = workerStarter(worker);
  const module = await loadModule(wasm);
  const usual = worker === false ? 1 : usualThreads(cores());
  if (start) return createRemoteEngine(start, module, parameters, threads ?? usual);
  const engine = await createLocalEngine(module, parameters);
  if (startHelper) {
    engine.crew = new Crew(
      (threads ?? usual) - 1,
      (port) => startHelper({ module, parameters, port }),
      (number, port) => engine.pool.add(number, port),
      (number) => engine.pool.lose(number),
    );
  }
  return engine;
}

/**
 * Loads the module that reads image files when the first one comes.
 * @param {import('./options.js').WasmSource} [decoder]
 */
export function decoderLoader(decoder) {
  return once(() => platform.loadDecoder(decoder));
}
