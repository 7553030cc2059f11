// Package and page in Chromium, Firefox and WebKit: the self test's hashes, the sample, abort, own clips, what is saved,
// and all of that without a network. An engine that cannot be found is skipped, aloud; `npm test` has the first alone.

import assert from 'node:assert/strict';
import { mkdirSync, readFileSync } from 'node:fs';
import { join } from 'node:path';
import { after, before, describe, test } from 'node:test';
import { unzipSync } from 'fflate';
import { mounts, serve } from '../../scripts/serve.mjs';
import { root } from '../../scripts/tools.mjs';
import { gifFile } from '../gif.mjs';
import { movingFrames, plainFrame } from '../moving.mjs';
import { pngBytes } from '../png.mjs';
import { ENGINES } from './engines.mjs';
import { ended, faults, inPhase, maskHash, open, press, save, until, visit, textOf } from './page.mjs';

const expected = JSON.parse(readFileSync(join(root, 'cli', 'src', 'selftest', 'expected.json'), 'utf8'));
const clip = movingFrames(8, [96, 64]).map((frame, t) => ({
  name: `frame${t}.png`,
  mimeType: 'image/png',
  buffer: pngBytes(frame, { channels: 4 }),
}));
/** Videos of a made clip, by their codecs, as Chromium encodes them; null where it does not. */
const videos = { vp8: null, avc: null };

before(async () => {
  const server = await serve({ places: [{ prefix: '/tests/', folder: join(root, 'tests') }, ...mounts] });
  const { page, close } = await ENGINES[0].start();
  try {
    await page.goto(`${server.url}dist/index.js`);
    for (const [codec, container] of Object.entries({ vp8: 'WebM', avc: 'Mp4' }))
      videos[codec] = await page.call(encoded, codec, container).then(fromText);
  } finally {
    await close();
    await server.close();
  }
});

const fromText = (text) => text && Buffer.from(text, 'base64');

/** Runs in the page. */
async function encoded(codec, container) {
  const [{ synthClip }, media] = await Promise.all([import('/dist/index.js'), import('/dist/vendor/media.js')]);
  const size = { width: 160, height: 96 };
  if (!(await media.getFirstEncodableVideoCodec([codec], size))) return null;
  const { base64Of, encodeClip, evenTimes } = await import('/tests/browser/page-helpers.mjs');
  const clip = await synthClip({ ...size, frames: 12 });
  const draw = (context, t) => context.putImageData(new ImageData(clip.frame(t).data, size.width), 0, 0);
  return base64Of(await encodeClip({ ...size, times: evenTimes(12, 10), draw, codec, container, keyEvery: 2 }));
}

/** Results that must be equal in all engines, by name. */
const outcomes = new Map();
function sameInAll(name, value, engine) {
  const first = outcomes.get(name) ?? { value, engine };
  outcomes.set(name, first);
  assert.equal(value, first.value, `${name} differs between ${engine} and ${first.engine}`);
}

for (const { name, missing, start } of ENGINES) {
  const lacks = missing();
  if (lacks) console.log(`!!! SKIPPED: all tests in ${name}, which need "apt-get install ${lacks}"`);
  describe(name, { skip: lacks ? `${lacks} is not installed` : false, timeout: 600_000 }, () => inEngine(name, start));
}

function inEngine(name, start) {
  let server, engine, page;
  before(async () => {
    [server, engine] = await Promise.all([serve(), start()]);
    page = engine.page;
    console.log(`${name} ${engine.version}`);
  });
  after(async () => {
    await engine?.close();
    await server?.close();
  });

  test('the page segments its sample', async () => {
    await visit(page, server.url);
    assert.equal(await ended(page), 'done', await textOf(page, '#error'));
    assert.equal(await textOf(page, '#headline'), '3 moving objects');
    sameInAll('the sample', await maskHash(page), name);
    const folder = join(root, 'out', 'screens');
    mkdirSync(folder, { recursive: true });
    await page.screenshot(join(folder, `engine-${name.toLowerCase()}.png`));
    assert.deepEqual(await faults(page), []);
  });

  test('the self test gives the hashes of all engines', async () => {
    // In the page at hand: what the engine has compiled is compiled.
    const { same: isSame, checks } = await page.call(async () => (await import('/dist/selftest.js')).selftest());
    const hashes = Object.fromEntries(checks.map((check) => [check.name, check.hash]));
    assert.deepEqual(hashes, expected.hashes);
    assert.equal(isSame, true);
  });

  test('a clip of images is segmented, its masks are saved as the same bytes, and a video of them', async () => {
    assert.equal(await open(page, clip), 'done', await textOf(page, '#error'));
    sameInAll('the images', await maskHash(page), name);
    const { name: file, bytes } = await save(page, 'zip');
    assert.match(file, /\.zip$/);
    const masks = Object.keys(unzipSync(bytes)).filter((path) => path.endsWith('.png'));
    assert.equal(masks.length, clip.length);
    sameInAll('the ZIP of masks', bytes.toString('base64'), name);
    // Before the page has played any: an encoder that comes first was the end of WebKit's.
    const video = await save(page, 'overlay-webm');
    assert.equal(video.bytes.readUInt32BE(0), 0x1a45dfa3);
    assert.deepEqual(await faults(page), []);
  });

  test('a video is segmented; where there is no decoder for it, the page says what to do', async () => {
    const webm = { name: 'clip.webm', mimeType: 'video/webm', buffer: videos.vp8 };
    assert.equal(await open(page, [webm]), 'done', await textOf(page, '#error'));
    assert.match(await textOf(page, '#subline'), /12 frames of 160 × 96/);
    if (!videos.avc) return;
    const state = await open(page, [{ name: 'clip.mp4', mimeType: 'video/mp4', buffer: videos.avc }]);
    const plays = await page.call(() => document.createElement('video').canPlayType('video/mp4; codecs="avc1.42001f"'));
    if (plays) assert.equal(state, 'done', await textOf(page, '#error'));
    else {
      assert.equal(state, 'error');
      assert.equal(await textOf(page, '#error-title'), 'This browser can’t decode this video');
      assert.equal(await textOf(page, '#error-advice'), 'Convert it to WebM, or try another browser.');
      assert.match(await textOf(page, '#error-detail'), /the codec avc1\S* cannot be decoded .*; convert it to WebM$/);
    }
    assert.deepEqual(await faults(page), []);
  });

  test('an animated image is segmented', async () => {
    const frames = [0, 1, 2].map((k) => plainFrame(48, 32, (x, y) => [(x * 5 + k * 9) % 256, y * 7, 0]));
    assert.equal(await open(page, [gifFile('clip.gif', frames)]), 'done', await textOf(page, '#error'));
    assert.deepEqual(await faults(page), []);
  });

  test('without a network the page opens again, and a run is cancelled', async () => {
    await until(page, () => navigator.serviceWorker.ready.then(({ active }) => active.state === 'activated'));
    const { url } = server;
    await server.close();
    server = null;
    await visit(page, url);
    await inPhase(page, 'running');
    await press(page, '#cancel');
    await inPhase(page, 'stopped');
    assert.deepEqual(await faults(page), []);
  });
}
