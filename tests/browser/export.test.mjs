// Files of masks made in the browser, in a page and in a worker of its own: byte for byte those of Node.

import assert from 'node:assert/strict';
import { test } from 'node:test';
import * as inNode from '../entries.mjs';
import { fnv1a } from '../fingerprint.mjs';
import { useServerAndBrowser } from '../site.mjs';
import { emptyPage } from './empty-page.mjs';

const site = useServerAndBrowser();

/** Runs in a page, in a worker, and in Node: every file of a clip whose masks are known, as text. */
async function files(tracecut) {
  const clip = await tracecut.synthClip({ width: 120, height: 67, frames: 5 });
  const masks = {
    width: 120,
    height: 67,
    numFrames: 5,
    labels: (t) => clip.mask(t),
    times: [0, 0.04, 0.08, 0.12, 0.2],
  };
  const { maskPng, masksZip, cocoRle, labelsNpy } = tracecut;
  const bytes = [
    await maskPng(masks, 2),
    await maskPng(masks, 2, { object: 1 }),
    await masksZip(masks),
    await masksZip(masks, { perObject: true }),
    labelsNpy(masks),
  ];
  return [
    ...bytes.map((file) => Array.from(file, (byte) => String.fromCharCode(byte)).join('')),
    JSON.stringify(await cocoRle(masks)),
  ];
}

test('files of masks are the same everywhere', async (t) => {
  const page = await emptyPage(t, site);
  const serve = (name, body) =>
    page.route(`${site.url}${name}`, (route) => route.fulfill({ contentType: 'text/javascript', body }));
  await serve('files.js', `export ${files}`);
  await serve(
    'worker.js',
    "import { files } from './files.js'; import('/model/library.js').then(files).then((list) => postMessage(list));",
  );
  const [inPage, inWorker] = await page.evaluate(async () => {
    const worker = new Worker('/worker.js', { type: 'module' });
    const answer = new Promise((done, failed) =>
      Object.assign(worker, { onmessage: ({ data }) => done(data), onerror: failed }),
    );
    const { files: made } = await import('/files.js');
    return [await made(await import('/model/library.js')), await answer];
  });
  const hashes = (list) => list.map((file) => fnv1a(Buffer.from(file, 'utf8')));
  const expected = hashes(await files(inNode));
  assert.deepEqual(hashes(inPage), expected);
  assert.deepEqual(hashes(inWorker), expected);
});
