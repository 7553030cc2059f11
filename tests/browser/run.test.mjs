// Runs on the page: cancelled, begun again, given up for another; and files of all kinds, videos, images and a single one,
// each of which ends in a result or in words that say what to do, also where nothing moves.

import assert from 'node:assert/strict';
import { beforeEach, describe, test } from 'node:test';
import { WIDE, fiveObjects } from './five-objects.mjs';
import {
  SMALL,
  accessibilityFaults,
  ended,
  gifFile,
  inPhase,
  layerNames,
  openLook,
  openRedo,
  openSample,
  paintedShare,
  picture,
  plainFrame,
  pngFile,
  redo,
  run,
  screenshot,
  showOnly,
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

/** A bright disc on a dark, slightly uneven ground. */
const disc = plainFrame(120, 80, (x, y) => {
  const inside = (x - 50) ** 2 + (y - 40) ** 2 < 24 ** 2;
  const grain = ((x * 7 + y * 13) % 5) * 2;
  return inside ? [210 + grain, 180, 90] : [40 + grain, 60, 110];
});

const KINDS = ['combined', 'discontinuity', 'spectral', 'pb'];

/** Texture that shifts by `speed` a frame as a whole. */
function shifting(count, speed, { width = 96, height = 64 } = {}) {
  const noise = (x, y) => {
    const h = Math.imul((x >> 1) + 7, 374761393) ^ Math.imul((y >> 1) + 3, 668265263);
    const mixed = Math.imul(h ^ (h >>> 13), 1274126177);
    return 60 + (((mixed ^ (mixed >>> 16)) >>> 0) % 160);
  };
  return Array.from({ length: count }, (_, t) => {
    const frame = plainFrame(width, height, (x, y) => {
      const value = noise(x + speed * t, y);
      return [value, value, value];
    });
    return pngFile(`f${String(t).padStart(3, '0')}.png`, frame);
  });
}

const trim = (page) => page.evaluate(() => globalThis.tracecutStudio.trim);
/** What is offered is fetched when it is first needed. */
const tries = async (page) => {
  await page.waitForSelector('[data-suggestion]');
  return page.evaluate(() =>
    [...document.querySelectorAll('[data-suggestion]')].map((button) => button.dataset.suggestion),
  );
};

describe('a run', () => {
  const sample = useSample(useSite());

  test('is cancelled at once and continues to the same result', async () => {
    const { page, faults } = sample;
    const labels = () => page.evaluate(() => String(globalThis.tracecutStudio.result.clusters.label));
    const before = await labels();
    await redo(page);
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
    const { page } = sample;
    await redo(page);
    await page.keyboard.press('Escape');
    await inPhase(page, 'stopped');
    await page.click('#again');
    assert.equal(await ended(page), 'done');
  });

  test('gives way to another clip that is opened meanwhile', async () => {
    const { page, faults } = sample;
    await redo(page);
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
    'two frames': [movingSquare(2, 2), /moving object|Nothing/],
    'a still video': [Array.from({ length: 9 }, () => still), /^No moving objects|^Nothing to track/],
    'black frames': [Array.from({ length: 9 }, () => plainFrame(64, 48)), /^No moving objects|^Nothing to track/],
    'frames of one pixel': [Array.from({ length: 9 }, () => plainFrame(1, 1)), /^No moving objects|^Nothing to track/],
    'frames of 17x3': [movingSquare(9, 1, 17, 3), /moving object|Nothing to track/],
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
      const { source, trim } = globalThis.tracecutStudio;
      const found = [];
      for await (const { frame } of source.frames(trim, new AbortController().signal)) found.push(frame.data[0]);
      return found;
    });
    assert.deepEqual(
      reds,
      shades.map((_, t) => 20 * t),
    );
  });

  test('an animated GIF is decoded into frames', async () => {
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

describe('a still image', () => {
  const sample = useSample(useSite());
  beforeEach(() => (sample.faults.length = 0));

  test('shows its boundaries, superpixels and embedding discontinuities', async () => {
    const { page, faults } = sample;
    assert.equal(
      await run(page, [pngFile('disc.png', disc)]),
      'done',
      await page.evaluate(() => document.querySelector('#error').innerText),
    );
    assert.match(await text(page, '#headline'), /still image/i);
    assert.match(await text(page, '#subline'), /^\d+ superpixels? · 120 × 80 · computed in \d/);
    assert.match(await text(page, '#notice'), /motion/);
    for (const absent of ['#timeline', '.block-objects', '#clip-frames'])
      assert.equal(await page.locator(absent).isVisible(), false, absent);
    await openRedo(page);
    assert.equal(await page.locator('#clip-side').isVisible(), true);
    await page.click('#redo-close');
    const ids = await layerNames(page);
    assert.deepEqual(ids, ['superpixels', 'contours', 'boundaries', 'still', 'image']);
    const pictures = new Set();
    for (const id of ids) {
      await showOnly(page, id);
      await page.waitForFunction(paintedShare);
      pictures.add(await picture(page));
      await screenshot(page, `still-${id}`);
    }
    assert.equal(pictures.size, ids.length);
    assert.deepEqual(faults, []);
  });

  test('has its choice of boundaries strong along the disc, faint elsewhere, and named under the pointer', async () => {
    const { page } = sample;
    await run(page, [pngFile('disc.png', disc)]);
    await showOnly(page, 'still');
    const pictures = new Set();
    await openLook(page);
    for (const [k, kind] of KINDS.entries()) {
      await page.selectOption('[data-setting="still.kind"]', String(k));
      await page.waitForFunction(paintedShare);
      pictures.add(await picture(page));
      const { rim, ground } = await page.evaluate(shades);
      assert.ok(rim < ground - 60, `${kind}: ${rim} along the disc, ${ground} on the ground`);
    }
    assert.equal(pictures.size, KINDS.length);
    const box = await page.locator('#canvas').boundingBox();
    await page.hover('#canvas', { position: { x: (box.width * 74) / 120, y: box.height / 2 } });
    assert.match(
      await text(page, '#readout'),
      /^combined \d\.\d\d, discontinuity \d\.\d\d, spectral \d\.\d\d, Pb 0\.[1-9]\d$/,
    );
    await page.keyboard.press('6');
    assert.equal(await page.locator('[data-layer="still"]').isChecked(), false);
  });

  test('is cancelled, continues, and yields to a newly opened clip', async () => {
    const { page, faults } = sample;
    const large = plainFrame(400, 300, (x, y) => [(x * y) % 251, (3 * x) % 200, y % 256]);
    await page.setInputFiles('#file', [pngFile('large.png', large)]);
    await page.waitForFunction(() => globalThis.tracecutStudio.app.job?.current?.id === 'imageEdges');
    await page.keyboard.press('Escape');
    await inPhase(page, 'stopped');
    await page.click('#resume');
    await inPhase(page, 'running');
    await page.click('#sample');
    assert.equal(await ended(page), 'done');
    assert.match(
      await text(page, '#subline'),
      new RegExp(`${SMALL.frames} frames of ${SMALL.width} × ${SMALL.height}`),
    );
    assert.equal((await layerNames(page)).includes('still'), false);
    assert.equal(await page.locator('#timeline').isVisible(), true);
    assert.deepEqual(faults, []);
  });

  for (const [what, frame] of Object.entries({
    'of one pixel': plainFrame(1, 1),
    'of one colour': plainFrame(60, 40),
    'of 2 × 90': plainFrame(2, 90),
  })) {
    test(`${what} is answered too`, async () => {
      const { page, faults } = sample;
      assert.equal(
        await run(page, [pngFile('plain.png', frame)]),
        'done',
        await page.evaluate(() => document.querySelector('#error').innerText),
      );
      assert.deepEqual(faults, []);
    });
  }

  test('may be a GIF of one frame; a damaged file is refused in words', async () => {
    const { page } = sample;
    assert.equal(await run(page, [gifFile('disc.gif', [disc])]), 'done');
    assert.match(await text(page, '#clip-facts'), /^120 × 80$/);
    const damaged = { ...pngFile('disc.png', disc), buffer: pngFile('disc.png', disc).buffer.subarray(0, 60) };
    assert.equal(await run(page, [damaged]), 'error');
    assert.equal(await page.getAttribute('#error', 'data-code'), 'unreadable-image');
  });
});

describe('a clip in which nothing is found', () => {
  const site = useSite();

  test('differs from one that has objects; slow motion is tried with frames skipped', async () => {
    const { page, faults } = await openSample(site, { bypassCSP: true });
    assert.equal(await page.locator('#suggestions').isVisible(), false, 'the sample has objects');
    assert.equal(await run(page, shifting(30, 2)), 'done');
    await page.waitForSelector('[data-suggestion]');
    const where = await text(page, '#suggestions-report');
    assert.match(where, /^Tracked \d.* points over [89]\d% of the picture in 30 frames/);
    assert.match(where, /the camera moves about 2\.0 px\/frame/);
    assert.match(where, /nothing stands out/);
    assert.deepEqual(await tries(page), ['step', 'add']);
    assert.deepEqual(await accessibilityFaults(page), []);
    await screenshot(page, 'nothing');
    await page.click('[data-suggestion="step"]');
    assert.equal(await ended(page), 'done');
    assert.deepEqual(await trim(page), { start: 0, frames: 15, step: 2, side: 480 });
    assert.deepEqual(faults, []);
  });

  test('a click adds the thing that was missed', async () => {
    const { page } = await openSample(site, { viewport: { width: 390, height: 844 }, isMobile: true, hasTouch: true });
    assert.equal(await run(page, shifting(8, 0)), 'done');
    await screenshot(page, 'nothing-phone');
    await page.click('[data-suggestion="add"]');
    await page.waitForSelector('#suggestions', { state: 'hidden' });
    assert.equal(await page.isChecked('#correct-tools [value="add"]'), true);
    await page.locator('#canvas').click();
    await page.waitForFunction(() => document.querySelectorAll('.object').length === 2);
    await page.click('#correct-done');
    assert.equal(await page.locator('#suggestions').isVisible(), false, 'there is an object now');
  });
});

/** Runs in the page: the mean grey along the disc's rim, at its darkest nearby, and of the ground far from it. */
function shades() {
  const { viewer } = globalThis.tracecutStudio.app;
  viewer.draw();
  const { canvas } = viewer;
  const { data } = canvas.getContext('2d').getImageData(0, 0, canvas.width, canvas.height);
  const grey = (x, y) =>
    data[4 * (Math.round((y * canvas.height) / 80) * canvas.width + Math.round((x * canvas.width) / 120))];
  const mean = (list) => list.reduce((sum, value) => sum + value, 0) / list.length;
  const turns = Array.from({ length: 24 }, (_, k) => (2 * Math.PI * k) / 24);
  const nearRim = (turn) =>
    Math.min(...[22, 23, 24, 25, 26].map((r) => grey(50 + r * Math.cos(turn), 40 + r * Math.sin(turn))));
  return { rim: mean(turns.map(nearRim)), ground: mean([10, 20, 30, 40, 50, 60, 70].map((y) => grey(105, y))) };
}
