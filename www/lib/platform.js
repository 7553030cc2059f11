// What differs between browsers and Node, and engines opened there.

import { Crew, usualThreads } from './crew.js';
import { createLocalEngine } from './engine.js';
import { places, workerStarter } from './places.js';
import { createRemoteEngine } from './remote.js';

/**
 * @typedef {object} Platform
 * @property {(source?: import('./options.js').WasmSource) => Promise<WebAssembly.Module>} loadModule
 * @property {(source?: import('./options.js').WasmSource) => Promise<WebAssembly.Module>} loadDecoder
 * @property {(() => Worker) | undefined} startWorker
 * @property {boolean} [inProcess] whether work stays on the calling thread where nobody asks for a worker
 * @property {(() => Worker) | undefined} [startAside]
 * @property {(data: {module: WebAssembly.Module, parameters: Record<string, unknown>, port: MessagePort}) =>
 *   import('./crew.js').HelperWorker} [startHelper] where sessions run on the calling thread: a worker that helps one
 * @property {() => number | undefined} cores as many threads as the machine runs at once, where known
 */

/**
 * Loads once, however often it is called; after a failure the next call tries again.
 * @template T
 * @param {() => Promise<T>} load
 * @returns {() => Promise<T>}
 */
export function once(load) {
  /** @type {Promise<T> | undefined} */
  let loading;
  return () => {
    loading ??= load();
    loading.catch(() => (loading = undefined));
    return loading;
  };
}

/**
 * Loads what a call names, or what `configure` named, or what the package brings; the latter two once.
 * @param {'wasm' | 'decoder'} name
 * @param {(source: import('./options.js').WasmSource) => Promise<WebAssembly.Module>} load
 * @param {() => Promise<WebAssembly.Module>} loadPackaged
 * @returns {(source?: import('./options.js').WasmSource) => Promise<WebAssembly.Module>}
 */
export function loader(name, load, loadPackaged) {
  const packaged = once(loadPackaged);
  /** @type {unknown} */
  let known;
  let configured = packaged;
  return (source) => {
    if (source !== undefined) return load(source);
    const place = places[name];
    if (place === undefined) return packaged();
    if (place !== known) {
      known = place;
      configured = once(async () => load(typeof place === 'function' ? place() : place));
    }
    return configured();
  };
}

/**
 * An engine in a worker where there are workers and the options do not say otherwise (in Node where they ask for one),
 * else in this thread.
 * @param {import('./options.js').SplitOptions} options
 * @param {Platform} platform
 * @returns {Promise<import('./engine.js').Engine>}
 */
export async function openEngine({ wasm, worker, threads, parameters }, platform) {
  const start = workerStarter(worker, platform);
  const module = await platform.loadModule(wasm);
  const usual = worker === false ? 1 : usualThreads(platform.cores());
  if (start) return createRemoteEngine(start, module, parameters, threads ?? usual);
  const engine = await createLocalEngine(module, parameters);
  const { startHelper } = platform;
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
