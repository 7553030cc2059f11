// Cancelling, running again, and files of all kinds: each ends in a result or in words that say what to do.

import assert from 'node:assert/strict';
import { describe, test } from 'node:test';
import { WIDE, fiveObjects } from './five.mjs';
import {
  ended,
  gifFile,
  inPhase,
  openSample,
  plainFrame,
  pngFile,
  run,
  SMALL,
  text,
  useSample,
  useSite,
} from './support.mjs';

const WIDTH = 96;
const HEIGHT = 64;

/** A textured ground with a square of another texture that moves `speed` pixels a frame. */
function movingSquare(count, speed, width = WIDTH, height = HEIGHT) {
  const noise = (x, y, salt) => {
    let h = Math.imul(x + 7, 374761393) ^ Math.imul(y + 3, 668265263) ^ Math.imul(salt, 2246822519);
    h = Math.imul(h ^ (h >>> 13), 1274126177);
    return 60 + (((h ^ (h >>> 16)) >>> 0) % 160);
  };
  // Blocks of 2x2 pixels, so that the texture has structure that can be followed.
  const texture = (x, y, salt) => noise(x >> 1, y >> 1, salt);
  return Array.from({ length: count }, (_, t) => {
    const left = 12 + speed * t;
    return plainFrame(width, height, (x, y) => {
      const inside = x >= left && x < left + 28 && y >= 16 && y < 48;
      const value = inside ? texture(x - left, y, 2) : texture(x, y, 1);
      return [value, value, inside ? 255 - value : value];
    });
  });
}

const files = (frames) => frames.map((frame, k) => pngFile(`frame${k}.png`, frame));

describe('a run', () => {
  const site = useSite();

  test('is cancelled at once and goes on to the same result', async () => {
    const { page, faults } = await openSample(site);
    const labels = () => page.evaluate(() => String(globalThis.tracecutStudio.result.clusters.label));
    const before = await labels();
    await page.click('#again');
    await inPhase(page, 'running');
    await page.waitForFunction(() => globalThis.tracecutStudio.app.job.stages[1].done >= 2);
    const ms = await page.evaluate(() => {
      const start = performance.now();
      document.querySelector('#cancel').click();
      return document.body.dataset.phase === 'stopped' ? performance.now() - start : -1;
    });
    assert.ok(ms >= 0 && ms < 100, `cancelling took ${ms} ms`);
    assert.equal(await page.evaluate(() => document.body.dataset.state), 'loading');
    await page.click('#resume');
    assert.equal(await ended(page), 'done');
    assert.equal(await labels(), before);
    assert.deepEqual(faults, []);
  });

  test('is cancelled with Escape while frames are read, and a new one follows', async () => {
    const { page } = await openSample(site);
    await page.click('#again');
    await page.keyboard.press('Escape');
    await inPhase(page, 'stopped');
    await page.click('#again');
    assert.equal(await ended(page), 'done');
  });

  test('gives way to another clip that is opened meanwhile', async () => {
    const { page, faults } = await openSample(site);
    await page.click('#again');
    await inPhase(page, 'running');
    assert.equal(await run(page, files(movingSquare(9, 2))), 'done');
    assert.match(await text(page, '#subline'), /9 frames of 96 × 64/);
    assert.deepEqual(faults, []);
  });
});

describe('files', () => {
  const shared = useSample(useSite());
  const noise = Buffer.from(Array.from({ length: 4000 }, (_, k) => (k * 167 + (k >> 3)) % 256));
  const beginning = (head) => Buffer.concat([Buffer.from(head, 'latin1'), noise]);
  const mp4 = beginning('\0\0\0\x10ftypisom\0\0\x02\0');

  const refused = {
    'a text file': [
      [{ name: 'notes.txt', mimeType: 'text/plain', buffer: Buffer.from('not a video') }],
      'unknown-file',
    ],
    'a damaged video': [[{ name: 'broken.mp4', mimeType: 'video/mp4', buffer: mp4 }], 'unreadable-video'],
    'an empty video': [[{ name: 'empty.webm', mimeType: 'video/webm', buffer: Buffer.alloc(0) }], 'unknown-file'],
    'two videos': [['a.mp4', 'b.mp4'].map((name) => ({ name, mimeType: 'video/mp4', buffer: mp4 })), 'many-videos'],
    'a video and an image': [
      [{ name: 'a.mp4', mimeType: 'video/mp4', buffer: mp4 }, pngFile('b.png', plainFrame(32, 32))],
      'mixed-files',
    ],
    'a truncated image': [
      [
        pngFile('a.png', plainFrame(32, 32)),
        { name: 'b.png', mimeType: 'image/png', buffer: beginning('\x89PNG\r\n').subarray(0, 40) },
      ],
      'unreadable-image',
    ],
    'images of different sizes': [files([plainFrame(32, 32), plainFrame(40, 32)]), 'mixed-sizes'],
    'an image and a text file': [
      [pngFile('a.png', plainFrame(32, 32)), { name: 'b.txt', mimeType: 'text/plain', buffer: Buffer.from('b') }],
      'unknown-file',
    ],
  };
  for (const [what, [given, code]] of Object.entries(refused)) {
    test(`${what}: refused in words`, async () => {
      const { page } = shared;
      assert.equal(await run(page, given), 'error');
      assert.equal(await page.getAttribute('#error', 'data-code'), code);
      assert.ok((await text(page, '#error-title')).length > 10);
      assert.match(await text(page, '#error-advice'), /\b(use|open|convert|choose|leave)\b/i);
      assert.equal(await page.locator('#canvas').isVisible(), false);
    });
  }

  test('after a refusal the sample runs as before', async () => {
    const { page } = shared;
    assert.equal(await run(page, refused['a damaged video'][0]), 'error');
    await page.click('#error-sample');
    assert.equal(await ended(page), 'done');
    assert.equal(await page.locator('#error').isVisible(), false);
    assert.match(
      await text(page, '#subline'),
      new RegExp(`${SMALL.frames} frames of ${SMALL.width} × ${SMALL.height}`),
    );
  });

  const still = movingSquare(1, 0)[0];
  const answered = {
    'two frames': [movingSquare(2, 2), /frames? of 96 × 64|background|Nothing/],
    'a still video': [
      Array.from({ length: 9 }, () => still),
      /^No motion that differs from the background|^Nothing to follow/,
    ],
    'black frames': [
      Array.from({ length: 9 }, () => plainFrame(64, 48)),
      /^No motion that differs from the background|^Nothing to follow/,
    ],
    'frames of one pixel': [Array.from({ length: 9 }, () => plainFrame(1, 1)), /^No motion|^Nothing to follow/],
    'frames of 17x3': [movingSquare(9, 1, 17, 3), /background|Nothing to follow/],
  };
  for (const [what, [frames, words]] of Object.entries(answered)) {
    test(`${what}: a result, with a remark where nothing moves`, async () => {
      const { page, faults } = shared;
      faults.length = 0;
      assert.equal(
        await run(page, files(frames)),
        'done',
        await page.evaluate(() => document.querySelector('#error').innerText),
      );
      const headline = await text(page, '#headline');
      assert.match(headline, words);
      assert.equal(await page.locator('#notice').isVisible(), /^No/.test(headline));
      assert.deepEqual(faults, []);
    });
  }

  test('images of a sequence are taken in the order of their numbers', async () => {
    const { page } = shared;
    const shades = Array.from({ length: 12 }, (_, t) => plainFrame(WIDTH, HEIGHT, () => [20 * t, 0, 0]));
    assert.equal(await run(page, files(shades).reverse()), 'done');
    assert.match(await text(page, '#clip-name'), /frame0\.png … frame11\.png/);
    const reds = await page.evaluate(async () => {
      const { source, take } = globalThis.tracecutStudio;
      const found = [];
      for await (const { frame } of source.frames(take, new AbortController().signal)) found.push(frame.data[0]);
      return found;
    });
    assert.deepEqual(
      reds,
      shades.map((_, t) => 20 * t),
    );
  });

  test('an animated GIF is taken apart', async () => {
    const { page } = shared;
    const frames = movingSquare(10, 2);
    assert.equal(await run(page, [gifFile('square.gif', frames)]), 'done', await text(page, 'main'));
    assert.match(await text(page, '#clip-facts'), /96 × 64, 10 images/);
    const reds = await page.evaluate(async () => {
      const { source } = globalThis.tracecutStudio;
      return [...(await source.preview(9, 480)).data].filter((_, k) => k % 4 === 0);
    });
    const expected = [...frames[9].data].filter((_, k) => k % 4 === 0).map((red) => red & 254);
    assert.deepEqual(reds, expected);
  });

  test('dropping files opens them', async () => {
    const { page } = shared;
    const given = files(movingSquare(8, 2)).map(({ name, buffer }) => ({ name, bytes: [...buffer] }));
    await page.evaluate((list) => {
      const transfer = new DataTransfer();
      for (const { name, bytes } of list)
        transfer.items.add(new File([new Uint8Array(bytes)], name, { type: 'image/png' }));
      for (const type of ['dragenter', 'drop']) {
        document.body.dispatchEvent(new DragEvent(type, { dataTransfer: transfer, bubbles: true, cancelable: true }));
      }
    }, given);
    assert.equal(await ended(page), 'done');
    assert.match(await text(page, '#subline'), /8 frames of 96 × 64/);
  });
});

describe('the camera', () => {
  const site = useSite({ sample: 'tiny' });

  test('of a phone records a video, which is segmented', async () => {
    const { page, faults } = await openSample(site, { isMobile: true, hasTouch: true });
    const { video } = await fiveObjects(page, WIDE);
    const chooser = page.waitForEvent('filechooser');
    await page.tap('#camera-open');
    const input = (await chooser).element();
    assert.equal(await input.getAttribute('capture'), 'environment');
    assert.equal(await input.getAttribute('accept'), 'video/*');
    await (await chooser).setFiles(video);
    await page.waitForFunction(() => globalThis.tracecutStudio.source?.name === 'five.webm');
    assert.equal(await ended(page), 'done');
    assert.deepEqual(faults, []);
    await page.context().close();
  });

  test('of a computer has no button', async () => {
    const { page } = await openSample(site);
    assert.equal(await page.locator('#camera-open').isVisible(), false);
    await page.context().close();
  });
});
