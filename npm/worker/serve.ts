// The main program of a worker: serves a session, helps one, or enlarges masks.

import { TraceCutError } from '../check/errors.js';
import { type LocalEngine, type StageStep, createLocalEngine } from '../session/engine.js';
import { REQUESTS } from '../session/requests.js';
import { callInstance, enlargeInThread, startInstance } from './instance.js';
import { type Message, type Port, type Reply, findTransferables } from './protocol.js';
import type { HelperPort } from './helpers.js';

/** Answers the requests that arrive at `port`, for one session; or helps another, or enlarges masks. */
export function serve(port: Port) {
  let engine: Promise<LocalEngine> = Promise.reject(new TraceCutError('state', 'the first request must be "create"'));
  engine.catch(() => {});
  const runs = new Map<number, AbortController>();

  const post = (reply: Reply) => port.postMessage(reply, findTransferables(reply.data));

  async function run(id: number, type: 'run' | 'track') {
    const controller = new AbortController();
    runs.set(id, controller);
    const report = (data: StageStep) => post({ id, type: 'progress', data });
    const running = (await engine)[type](report, controller.signal);
    return running.finally(() => runs.delete(id));
  }

  async function answer({ id, type, data }: { id: number } & Message) {
    if (type === 'create') {
      engine = createLocalEngine(data.module, data.parameters);
      (await engine).worksAhead = true;
      return undefined;
    }
    if (type === 'enlarge') return enlargeInThread(data);
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
      const { code = 'poisoned', message } = error as Partial<TraceCutError> & Error;
      post({ id: request.id, type: 'failed', data: { code, message } });
    }
  });
}

/** Answers each job that arrives at `port` with its result, or with an empty array if it failed. */
export function help(port: HelperPort, module: WebAssembly.Module, parameters: Record<string, unknown>) {
  const open = async () => {
    const owner = await startInstance(module);
    return { owner, session: callInstance(owner, (glue) => new glue.Session(parameters)) };
  };
  let helper = open();
  let last: Promise<unknown> = Promise.resolve();

  async function answer(job: Uint32Array) {
    try {
      const { owner, session } = await helper;
      const result = callInstance(owner, () => session.workOn(job));
      port.postMessage(result, [result.buffer as ArrayBuffer]);
    } catch {
      // The session will do the job itself, and report the error; the next job gets a fresh instance.
      helper = open();
      helper.catch(() => {});
      port.postMessage(new Uint32Array(), []);
    }
  }

  port.addEventListener('message', ({ data }) => {
    last = last.then(() => answer(data as Uint32Array));
  });
  port.start();
}
