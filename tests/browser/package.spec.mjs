// The package in Chromium: every kind of frame, the results of Node, workers and threads, content security, errors
// while it loads, and random call sequences.

import * as inNode from '../entries.mjs';
import { fingerprint, fnv1a } from '../fingerprint.mjs';
import { expect, test, useEmptyPage } from './fixtures.mjs';

/** The smallest scene of its kind in which an object is found. */
const SCENE = { width: 96, height: 54, frames: 6, seed: 4 };

// A page with the strictest content security policy that the package works with.
const emptyPage = useEmptyPage(prepare);

/** Imports the package into a page. */
function prepare(page) {
  return page.evaluate(async (scene) => {
    const tracecut = await import('/model/library.js');
    const prints = await import('/tests/fingerprint.mjs');
    const clip = await tracecut.synthClip(scene);
    const frames = Array.from({ length: scene.frames }, (_, t) => clip.frame(t));
    const createFilled = async (options, list = frames) => {
      const session = await tracecut.createSession(options);
      for (const frame of list) await session.push(frame);
      return session;
    };
    const segment = async (options, list) => {
      const session = await createFilled(options, list);
      const print = prints.fingerprint(await session.run());
      session.close();
      return print;
    };
    const failure = (promise) =>
      promise.then(
        () => 'no error',
        (error) => `${error.name} ${error.code}: ${error.message}`,
      );
    globalThis.kit = { ...tracecut, ...prints, frames, createFilled, segment, failure };
  }, SCENE);
}

/** Expects a number of workers in the shared page, after garbage is collected if need be. */
async function expectWorkers(count) {
  const { page } = emptyPage;
  const session = await page.context().newCDPSession(page);
  await expect
    .poll(async () => {
      await session.send('HeapProfiler.collectGarbage');
      return page.workers().length;
    })
    .toBe(count);
}

test('results equal those of Node, in a worker, in the page, and for single images', async () => {
  const scene = await inNode.synthClip(SCENE);
  const frames = Array.from({ length: SCENE.frames }, (_, t) => scene.frame(t));
  globalThis.kit = { ...inNode, fingerprint, fnv1a, frames };
  const expected = await computePrints();
  delete globalThis.kit;
  expect(await emptyPage.page.evaluate(computePrints)).toEqual(expected);
  expect(await emptyPage.page.evaluate(() => globalThis.kit.segment({ worker: false }))).toBe(expected.run);
  expect(JSON.parse(expected.objects).length).toBeGreaterThan(0);
});

/** Runs in the page and in Node. */
async function computePrints() {
  const { createSession, frames, superpixels, boundaries, ...prints } = globalThis.kit;
  const hash = ({ buffer }) => prints.fnv1a(new Uint8Array(buffer));
  const printMaps = ({ label, borders, edges }, { pb, thin }) =>
    [label, borders.pb, edges.x0, edges.kind, pb, thin].map(hash);
  const session = await createSession();
  for (const frame of frames) await session.push(frame);
  const result = await session.run();
  const maps = printMaps(await result.superpixels(2), await result.boundaries(2));
  // The last frame has no flow.
  for (const t of [1, frames.length - 1]) maps.push(hash((await result.saliencyMap(t)).saliency));
  session.close();
  const image = printMaps(await superpixels(frames[2]), await boundaries(frames[2], { worker: false }));
  return { run: prints.fingerprint(result), objects: JSON.stringify(result.objects), maps, image };
}

test('every kind of frame gives the result of its pixels', async () => {
  const differing = await emptyPage.page.evaluate(async () => {
    const { synthClip, segment } = globalThis.kit;
    const clip = await synthClip({ width: 48, height: 36, frames: 2, seed: 5 });
    const frames = [clip.frame(0), clip.frame(1)];
    const expected = await segment({}, frames);
    const toImageData = ({ data, width, height }) => new ImageData(data, width, height);
    const paint = (canvas, frame) => {
      Object.assign(canvas, { width: frame.width, height: frame.height });
      canvas.getContext('2d').putImageData(toImageData(frame), 0, 0);
      return canvas;
    };
    const kinds = {
      ImageData: toImageData,
      Uint8Array: (frame) => ({ ...frame, data: new Uint8Array(frame.data) }),
      HTMLCanvasElement: (frame) => paint(document.createElement('canvas'), frame),
      OffscreenCanvas: (frame) => paint(new OffscreenCanvas(1, 1), frame),
      ImageBitmap: (frame) => createImageBitmap(toImageData(frame)),
      PNG: (frame) => paint(new OffscreenCanvas(1, 1), frame).convertToBlob(),
      VideoFrame: ({ data, width, height }) =>
        new VideoFrame(data, { format: 'RGBX', codedWidth: width, codedHeight: height, timestamp: 0 }),
    };
    const names = [];
    for (const [name, convert] of Object.entries(kinds))
      if ((await segment({}, await Promise.all(frames.map(convert)))) !== expected) names.push(name);
    return names;
  });
  expect(differing).toEqual([]);
});

test('any number of threads gives the same result; threads are workers that end with the run, or with the session', async () => {
  const { page } = emptyPage;
  const expected = await page.evaluate(() => globalThis.kit.segment({ threads: 1 }));
  const aborted = await page.evaluate(async () => {
    const session = await globalThis.kit.createFilled({ threads: 3 });
    const controller = new AbortController();
    globalThis.session = session;
    return session.run({ signal: controller.signal, onProgress: () => controller.abort() }).catch(({ name }) => name);
  });
  expect(aborted).toBe('AbortError');
  // The run may continue.
  await expectWorkers(3);
  expect(await page.evaluate(async () => globalThis.kit.fingerprint(await globalThis.session.run()))).toBe(expected);
  await expectWorkers(1);
  await page.evaluate(() => globalThis.session.close());
  await expectWorkers(0);
});

test('an internal error ends its worker, and other sessions continue', async () => {
  const outcome = await emptyPage.page.evaluate(async () => {
    const { createFilled, failure, fingerprint, frames, segment } = globalThis.kit;
    const { withTrap } = await import('/tests/faulty-wasm.mjs');
    const bytes = new Uint8Array(await (await fetch('/dist/tracecut_bg.wasm')).arrayBuffer());
    const options = { threads: 1 };
    const session = await createFilled(options);
    const faulty = await createFilled({ ...options, wasm: withTrap(bytes, 'session_step') });
    const errors = [await failure(session.push({ ...frames[0], width: 3 }))];
    const running = session.run();
    for (const call of [() => faulty.run(), () => faulty.push(frames[0])]) errors.push(await failure(call()));
    globalThis.session = session;
    return { errors, isSame: fingerprint(await running) === (await segment(options)) };
  });
  expect(outcome).toEqual({
    errors: [
      expect.stringMatching(/^TraceCutError frame-bytes/),
      expect.stringMatching(/^TraceCutError poisoned/),
      expect.stringMatching(/^TraceCutError poisoned/),
    ],
    isSame: true,
  });
  await expectWorkers(1);
  await emptyPage.page.evaluate(() => globalThis.session.close());
});

test('sessions that are closed or no longer referenced end their workers, unless a result may still ask them', async () => {
  const { page } = emptyPage;
  await page.evaluate(async () => {
    const { createFilled } = globalThis.kit;
    const options = { threads: 1 };
    globalThis.session = await createFilled(options);
    globalThis.result = await (await createFilled(options)).run();
    await createFilled(options);
    (await createFilled(options)).close();
  });
  await expectWorkers(2);
  expect(await page.evaluate(async () => (await globalThis.result.superpixels(0)).count)).toBeGreaterThan(0);
  await page.evaluate(() => {
    globalThis.session.close();
    globalThis.result = null;
  });
  await expectWorkers(0);
});

test('a wasm file that is missing, is something else, or is forbidden by the policy is a wasm-load error', async ({
  openEmptyPage,
}) => {
  const load = (page, options) =>
    page.evaluate((argument) => globalThis.kit.failure(globalThis.kit.createSession(argument)), options);
  expect(await load(emptyPage.page, { wasm: '/dist/none.wasm' })).toMatch(
    /^TraceCutError wasm-load: .*none\.wasm could not be fetched: the server answered 404/,
  );
  expect(await load(emptyPage.page, { wasm: '/empty' })).toMatch(
    /^TraceCutError wasm-load: .*HTML.*optimizeDeps.exclude/,
  );
  const page = await openEmptyPage({ policy: "script-src 'self'" });
  await page.evaluate(async () => {
    const { createSession } = await import('/model/library.js');
    const failure = (promise) => promise.catch(({ name, code, message }) => `${name} ${code}: ${message}`);
    globalThis.kit = { createSession, failure };
  });
  expect(await load(page)).toMatch(/^TraceCutError wasm-load: .*Content Security Policy/i);
});

for (const options of [{ threads: 1 }, { threads: 2 }, { worker: false }])
  test(`random call sequences with ${JSON.stringify(options)} have valid outcomes`, async ({ openEmptyPage }) => {
    const page = await openEmptyPage();
    const { counts, unhandled } = await page.evaluate(async (sessionOptions) => {
      const unhandled = [];
      addEventListener('unhandledrejection', ({ reason }) => unhandled.push(String(reason)));
      const [api, { prepareSequences, runSequence }] = await Promise.all([
        import('/model/library.js'),
        import('/tests/call-sequences.mjs'),
      ]);
      const setup = await prepareSequences(api, sessionOptions);
      const counts = {};
      for (const seed of [0, 1])
        for (const [outcome, count] of Object.entries(await runSequence(setup, seed, 30)))
          counts[outcome] = (counts[outcome] ?? 0) + count;
      return { counts, unhandled };
    }, options);
    expect(unhandled).toEqual([]);
    // Outcomes that do not depend on timing.
    for (const outcome of ['push ok', 'run reason', 'run closed', 'clear busy', 'createSession param'])
      expect(counts[outcome], JSON.stringify(counts)).toBeGreaterThan(0);
  });
