// Several sessions of one page: side by side, one that fails among them, and ones that are forgotten.

import assert from 'node:assert/strict';
import { test } from 'node:test';
import { emptyPage } from '../browser/empty-page.mjs';
import { useServerAndBrowser } from '../site.mjs';

const site = useServerAndBrowser();

/**
 * An empty page of the server with the package, two clips' worth of helpers and a module that traps, in
 * `globalThis.kit`.
 */
async function open(t) {
  const page = await emptyPage(t, site, { modules: ['fingerprint.mjs', 'faulty-wasm.mjs'] });
  await page.evaluate(async () => {
    const tracecut = await import('/dist/index.js');
    const { fingerprint } = await import('/fingerprint.mjs');
    const { withMemory, withTrap } = await import('/faulty-wasm.mjs');
    const clip = await tracecut.synthClip({ width: 128, height: 72, frames: 6, seed: 3 });
    const frames = Array.from({ length: clip.numFrames }, (_, k) => clip.frame(k));
    const filled = async (options) => {
      // One thread on any machine, so that workers can be counted.
      const session = await tracecut.createSession({ threads: 1, ...options });
      for (const frame of frames) await session.push(frame);
      return session;
    };
    const alone = async (options) => {
      const session = await filled(options);
      const text = fingerprint(await session.run());
      session.close();
      return text;
    };
    const packaged = async (name) => new Uint8Array(await (await fetch(`/dist/${name}_bg.wasm`)).arrayBuffer());
    const trap = async () => withTrap(await packaged('tracecut'), 'session_step');
    const little = async () => withMemory(await packaged('tracecut'), 16);
    const brokenDecoder = async () => withTrap(await packaged('decoder'), 'decode');
    const failure = (promise) =>
      promise.then(
        () => 'no error',
        (error) => `${error.name} ${error.code}`,
      );
    globalThis.kit = { ...tracecut, fingerprint, frames, filled, alone, trap, little, brokenDecoder, failure };
  });
  return page;
}

/** The number of workers, once garbage is collected and no more than `most` are left, or after some time. */
async function workersLeft(page, most) {
  const collector = await page.context().newCDPSession(page);
  for (let i = 0; i < 100 && page.workers().length > most; i += 1) {
    await collector.send('HeapProfiler.collectGarbage');
    await page.evaluate(() => new Promise((resolve) => setTimeout(resolve, 20)));
  }
  return page.workers().length;
}

test('sessions with different parameters, in workers and on the page, give in turn what each gives alone', async (t) => {
  const page = await open(t);
  const [together, apart] = await page.evaluate(async () => {
    const { createSession, fingerprint, frames, alone } = globalThis.kit;
    const settings = [
      { trajectory: { gridStep: 5 } },
      { clip: { maxSide: 96 } },
      { refine: { band: 0 }, worker: false },
    ];
    const sessions = await Promise.all(settings.map((options) => createSession(options)));
    for (const frame of frames) for (const session of sessions) await session.push(frame);
    const results = await Promise.all(sessions.map((session) => session.run()));
    for (const session of sessions) session.free();
    const separate = [];
    for (const options of settings) separate.push(await alone(options));
    return [results.map(fingerprint), separate];
  });
  assert.deepEqual(together, apart);
  assert.equal(new Set(apart).size, 3);
});

for (const worker of [true, false]) {
  const where = worker ? 'in workers' : 'on the page';

  test(`memory that runs out, limits and a decoder that stops are errors of their own, ${where}`, async (t) => {
    const page = await open(t);
    const outcome = await page.evaluate(async (inWorker) => {
      const { alone, brokenDecoder, createSession, failure, filled, fingerprint, frames, little } = globalThis.kit;
      const wasm = await little();
      const full = await createSession({ worker: inWorker, threads: 1, wasm });
      let pushed = 0;
      const pushing = async () => {
        for (; pushed < 2000; pushed += 1) await full.push(frames[0]);
      };
      const errors = [await failure(pushing()), await failure(full.run())];
      const clip = { maxPixels: 128 * 72, maxFrames: frames.length };
      const session = await filled({ worker: inWorker, wasm, decoder: await brokenDecoder(), clip });
      const canvas = new OffscreenCanvas(129, 72);
      canvas.getContext('2d');
      errors.push(await failure(session.push(canvas)), await failure(session.push(frames[0])));
      const head = [137, 80, 78, 71, 13, 10, 26, 10];
      errors.push(await failure(session.push(Uint8Array.from(head))), await failure(session.push(new Blob(['x']))));
      const same = fingerprint(await session.run()) === (await alone({ worker: inWorker }));
      session.close();
      return { errors, pushed, same };
    }, worker);
    const codes = ['memory', 'memory', 'too-large', 'too-large', 'decode', 'decode'];
    assert.deepEqual(
      outcome.errors,
      codes.map((code) => `TraceCutError ${code}`),
    );
    assert.ok(outcome.pushed > 100 && outcome.pushed < 1000, `${outcome.pushed} frames`);
    assert.ok(outcome.same);
    assert.equal(await workersLeft(page, 0), 0, 'the worker without memory has ended');
  });
}

for (const worker of [true, false]) {
  test(`a session that hits an error leaves others working, ${worker ? 'in workers' : 'on the page'}`, async (t) => {
    const page = await open(t);
    const outcome = await page.evaluate(async (inWorker) => {
      const { fingerprint, filled, frames, alone, trap, failure } = globalThis.kit;
      const [good, hurt] = [await filled({ worker: inWorker }), await filled({ worker: inWorker, wasm: await trap() })];
      const refused = await failure(good.push({ ...frames[0], width: 3 }));
      globalThis.good = good;
      const running = good.run();
      const errors = [
        refused,
        await failure(hurt.run()),
        await failure(hurt.push(frames[0])),
        await failure(hurt.run()),
      ];
      return { errors, same: fingerprint(await running) === (await alone({ worker: inWorker })) };
    }, worker);
    assert.deepEqual(outcome.errors, ['TraceCutError frame-bytes', ...Array(3).fill('TraceCutError poisoned')]);
    assert.ok(outcome.same);
    assert.equal(await workersLeft(page, worker ? 1 : 0), worker ? 1 : 0, 'the failed worker has ended');
    await page.evaluate(() => globalThis.good.close());
  });
}

test('a closed session ends its worker, and so does one that was forgotten', async (t) => {
  const page = await open(t);
  await page.evaluate(async () => {
    const { filled } = globalThis.kit;
    globalThis.kept = await filled();
    globalThis.result = await (await filled()).run();
    await filled();
    (await filled()).close();
  });
  assert.equal(await workersLeft(page, 2), 2, 'those of the session that is kept and of the result that may ask');
  assert.ok(await page.evaluate(async () => (await globalThis.result.superpixels(0)).count > 0));
  await page.evaluate(() => globalThis.kept.close());
});
