// The package in a browser: every kind of frame, the worker and the calling thread, the same bytes as in Node, content
// security, what is said when the wasm file is not there. The demo page has tests of its own in tests/browser.

import assert from 'node:assert/strict';
import { test } from 'node:test';
import { emptyPage, useEmptyPage } from '../browser/empty-page.mjs';
import * as inNode from '../entries.mjs';
import { fingerprint, fnv1a } from '../fingerprint.mjs';
import { useServerAndBrowser } from '../site.mjs';

const SCENE = { width: 128, height: 72, frames: 5, seed: 5 };

const site = useServerAndBrowser();

const modules = ['fingerprint.mjs'];
const shared = useEmptyPage(site, prepare, { modules });

/** The package and a few helpers in `globalThis.kit` of an empty page. */
function prepare(page) {
  return page.evaluate(async (scene) => {
    const tracecut = await import('/model/library.js');
    const { fingerprint, fnv1a } = await import('/fingerprint.mjs');
    const frames = async () => {
      const clip = await tracecut.synthClip(scene);
      return Array.from({ length: scene.frames }, (_, t) => clip.frame(t));
    };
    const segment = async (list, options) => {
      const session = await tracecut.createSession(options);
      try {
        for (const frame of list) await session.push(frame);
        return fingerprint(await session.run());
      } finally {
        session.close();
      }
    };
    const failure = (promise) =>
      promise.then(
        () => 'no error',
        (error) => `${error.name} ${error.code}: ${error.message}`,
      );
    globalThis.kit = { ...tracecut, fingerprint, fnv1a, frames, segment, failure };
  }, SCENE);
}

test('any number of threads gives the same result, each a worker of its own, all ended with the session', async () => {
  const { page } = shared;
  const seen = await page.evaluate(async () => {
    const { segment, frames, createSession, fingerprint } = globalThis.kit;
    const list = await frames();
    const prints = [];
    for (const threads of [1, 2, 3, 6]) prints.push(await segment(list, { threads }));
    const session = await createSession({ threads: 4 });
    for (const frame of list) await session.push(frame);
    const controller = new AbortController();
    const stopped = session.run({ signal: controller.signal, onProgress: () => controller.abort() });
    await stopped.catch(() => {});
    globalThis.open = session;
    return prints;
  });
  assert.equal(new Set(seen).size, 1, seen.join(' '));
  // The driver learns of a worker some time after it was started or ended.
  const workers = async (count) => {
    for (let k = 0; page.workers().length !== count && k < 500; k += 1) await page.waitForTimeout(20);
    return page.workers().length;
  };
  assert.equal(await workers(4), 4, 'a run that was stopped may go on');
  const last = await page.evaluate(async () => globalThis.kit.fingerprint(await globalThis.open.run()));
  assert.equal(last, seen[0]);
  assert.equal(await workers(1), 1, 'helpers end with the run');
  await page.evaluate(() => globalThis.open.close());
  assert.equal(await workers(0), 0);
});

test('every kind of frame gives the same result as its pixels', async () => {
  const { page } = shared;
  const differing = await page.evaluate(async () => {
    const { frames, segment } = globalThis.kit;
    const pixels = await frames();
    const expected = await segment(pixels);
    const image = ({ data, width, height }) => new ImageData(data, width, height);
    const drawn = (canvas, frame) => {
      Object.assign(canvas, { width: frame.width, height: frame.height });
      canvas.getContext('2d').putImageData(image(frame), 0, 0);
      return canvas;
    };
    const kinds = {
      ImageData: image,
      Uint8Array: (frame) => ({ ...frame, data: new Uint8Array(frame.data) }),
      HTMLCanvasElement: (frame) => drawn(document.createElement('canvas'), frame),
      OffscreenCanvas: (frame) => drawn(new OffscreenCanvas(1, 1), frame),
      ImageBitmap: (frame) => createImageBitmap(image(frame)),
      'PNG Blob': (frame) => drawn(new OffscreenCanvas(1, 1), frame).convertToBlob(),
      VideoFrame: (frame) =>
        new VideoFrame(frame.data, {
          format: 'RGBX',
          codedWidth: frame.width,
          codedHeight: frame.height,
          timestamp: 0,
        }),
    };
    const wrong = [];
    for (const [name, convert] of Object.entries(kinds)) {
      if ((await segment(await Promise.all(pixels.map(convert)))) !== expected) wrong.push(name);
    }
    return wrong;
  });
  assert.deepEqual(differing, []);
});

test('the worker and the calling thread give the same result, under a strict content security policy', async () => {
  const { page } = shared;
  const [inWorker, inPage] = await page.evaluate(async () => {
    const { frames, segment } = globalThis.kit;
    const list = await frames();
    return [await segment(list), await segment(list, { worker: false })];
  });
  assert.equal(inWorker, inPage);
});

test('masks, saliency, superpixels and boundaries equal those in Node, in a run and for single images', async (t) => {
  const { page } = shared;
  const clip = await inNode.synthClip(SCENE);
  const frames = async () => Array.from({ length: SCENE.frames }, (_, k) => clip.frame(k));
  globalThis.kit = { ...inNode, fingerprint, fnv1a, frames };
  t.after(() => delete globalThis.kit);
  assert.deepEqual(await page.evaluate(denseHashes), await denseHashes());
});

/** Runs in the page and in Node. */
async function denseHashes() {
  const { createSession, fingerprint: whole, fnv1a: hash, frames, superpixels, boundaries } = globalThis.kit;
  const parts = ({ label, borders, edges }, { pb, thin }) =>
    [label, borders.pb, edges.x0, edges.kind, pb, thin].map(({ buffer }) => hash(new Uint8Array(buffer)));
  const list = await frames();
  const session = await createSession();
  for (const frame of list) await session.push(frame);
  const result = await session.run();
  const ofFrame = parts(await result.superpixels(2), await result.boundaries(2));
  // The last frame has no flow of its own.
  for (const t of [1, list.length - 1])
    ofFrame.push(hash(new Uint8Array((await result.saliencyMap(t)).saliency.buffer)));
  session.close();
  const ofImage = parts(await superpixels(list[2]), await boundaries(list[2], { worker: false }));
  return { run: whole(result), ofFrame, ofImage };
}

test('an abort takes effect at once and a second run continues; closing ends a run', async () => {
  const { page } = shared;
  const outcome = await page.evaluate(async () => {
    const { createSession, fingerprint, frames, segment, failure, synthClip } = globalThis.kit;
    const list = await frames();
    const session = await createSession();
    for (const frame of list) await session.push(frame);
    const controller = new AbortController();
    setTimeout(() => controller.abort(), 15);
    const aborted = await session.run({ signal: controller.signal }).then(
      () => 'done',
      (error) => error.name,
    );
    const same = fingerprint(await session.run()) === (await segment(list));
    const clip = await synthClip({ width: 320, height: 180, frames: 4 });
    await session.clear();
    for (let i = 0; i < 4; i += 1) await session.push(clip.frame(i));
    const run = failure(session.run());
    session.close();
    return { aborted, same, closed: await run };
  });
  assert.ok(['AbortError', 'done'].includes(outcome.aborted), outcome.aborted);
  assert.ok(outcome.same);
  assert.match(outcome.closed, /^TraceCutError closed/);
});

test('a wasm file that is missing, or that the policy forbids, is a wasm-load error in words', async (t) => {
  const { page } = shared;
  const missing = await page.evaluate(() =>
    globalThis.kit.failure(globalThis.kit.createSession({ wasm: '/dist/none.wasm' })),
  );
  assert.match(missing, /^TraceCutError wasm-load: .*none\.wasm could not be fetched: the server answered 404/);
  const html = await page.evaluate(() => globalThis.kit.failure(globalThis.kit.createSession({ wasm: '/empty' })));
  assert.match(html, /^TraceCutError wasm-load: .*HTML.*optimizeDeps.exclude/);
  const strict = await emptyPage(t, site, { policy: "script-src 'self'", modules });
  await prepare(strict);
  const forbidden = await strict.evaluate(() => globalThis.kit.failure(globalThis.kit.createSession()));
  assert.match(forbidden, /^TraceCutError wasm-load: .*Content Security Policy/i);
});

test('errors cross from the worker with code and message', async () => {
  const { page } = shared;
  const messages = await page.evaluate(async () => {
    const { createSession, failure } = globalThis.kit;
    const session = await createSession();
    const pushed = [new Uint8Array(3), { data: new Uint8Array(3), width: 1, height: 1 }, 'frame', null];
    const list = [await failure(createSession({ clip: { maxSize: 1 } })), await failure(session.run())];
    for (const frame of pushed) list.push(await failure(session.push(frame)));
    session.close();
    return list.map((message) => /^TraceCutError ([\w-]+): ./.exec(message)?.[1] ?? message);
  });
  assert.deepEqual(messages, ['param', 'too-few-frames', 'decode', 'frame-bytes', 'data', 'data']);
});
