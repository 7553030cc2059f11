// Masks at the size of the source in a browser: in a worker, with every kind of picture, the same bytes as in Node.

import assert from 'node:assert/strict';
import { test } from 'node:test';
import { enlargeMask } from '../../dist/node/edit.js';
import { fnv1a } from '../fingerprint.mjs';
import { useServerAndBrowser } from '../site.mjs';
import { emptyPage } from './empty-page.mjs';

const site = useServerAndBrowser();
const [WIDTH, HEIGHT, BY] = [428, 240, 2];

/** Runs in the page and here: a disc on a ground, and its mask at half the size. */
function made([width, height, by]) {
  const inside = (x, y) => Math.hypot(x - 200.3, y - 115.8) < 75;
  const data = new Uint8ClampedArray(4 * width * height);
  for (let p = 0; p < width * height; p += 1) {
    const [x, y] = [p % width, Math.floor(p / width)];
    const texture = (x * 7 + y * 13) % 23;
    data.set(inside(x, y) ? [150 + texture, 90, 60, 255] : [60, 90 + texture, 120, 255], 4 * p);
  }
  const [w, h] = [width / by, height / by];
  const at = (p) => inside(by * (p % w) + by - 2.5, by * Math.floor(p / w) + by - 2.5);
  return {
    picture: { data, width, height },
    mask: { width: w, height: h, labels: Uint8Array.from({ length: w * h }, (_, p) => Number(at(p))) },
  };
}

async function open(t) {
  const page = await emptyPage(t, site);
  await page.evaluate(`globalThis.made = ${made}; globalThis.fnv1a = ${fnv1a}`);
  await page.evaluate(
    async (size) => {
      const { enlargeMask } = await import('/dist/edit.js');
      const { picture, mask } = globalThis.made(size);
      const pixels = new ImageData(picture.data, picture.width);
      const print = ({ labels, alpha }) => [labels, alpha].map((bytes) => globalThis.fnv1a(bytes));
      Object.assign(globalThis, { enlargeMask, picture, mask, pixels, print });
    },
    [WIDTH, HEIGHT, BY],
  );
  return page;
}

test('every kind of picture gives the bytes of Node, and stays as it was', async (t) => {
  const page = await open(t);
  const { mask, picture } = made([WIDTH, HEIGHT, BY]);
  const expected = await enlargeMask(mask, picture);
  const found = await page.evaluate(async () => {
    const { enlargeMask, mask, pixels, print } = globalThis;
    const canvas = new OffscreenCanvas(pixels.width, pixels.height);
    canvas.getContext('2d').putImageData(pixels, 0, 0);
    const bitmap = await createImageBitmap(pixels);
    const init = { format: 'RGBA', codedWidth: pixels.width, codedHeight: pixels.height, timestamp: 0 };
    const frame = new VideoFrame(pixels.data, init);
    const blob = await canvas.convertToBlob();
    const all = {};
    for (const [name, picture] of Object.entries({ pixels, canvas, bitmap, frame, blob })) {
      all[name] = print(await enlargeMask(mask, picture));
    }
    all.here = print(await enlargeMask(mask, pixels, { worker: false }));
    const still = [bitmap.width, frame.codedWidth, pixels.data.length, mask.labels.length];
    frame.close();
    return { all, still };
  });
  for (const [name, prints] of Object.entries(found.all)) {
    assert.deepEqual(prints, [fnv1a(expected.labels), fnv1a(expected.alpha)], name);
  }
  assert.deepEqual(found.still, [WIDTH, WIDTH, 4 * WIDTH * HEIGHT, mask.labels.length]);
});

test('workers enlarge, one a core, go on after a refusal, and end when idle', async (t) => {
  const page = await open(t);
  const seen = await page.evaluate(async () => {
    const { enlargeMask, mask, pixels } = globalThis;
    let workers = 0;
    const { Worker } = globalThis;
    globalThis.Worker = class extends Worker {
      constructor(...args) {
        super(...args);
        workers += 1;
      }
    };
    const bitmap = await createImageBitmap(pixels);
    await enlargeMask(mask, bitmap);
    const first = workers;
    const refused = await enlargeMask(mask, new ImageData(30, 20)).catch((error) => `${error.code}: ${error.message}`);
    await enlargeMask(mask, pixels, { worker: false });
    const start = performance.now();
    await enlargeMask(mask, pixels, { worker: false });
    const here = performance.now() - start;
    let [longest, last, over] = [0, performance.now(), false];
    const tick = () => {
      const now = performance.now();
      [longest, last] = [Math.max(longest, now - last), now];
      if (!over) setTimeout(tick);
    };
    tick();
    const all = await Promise.all([1, 2, 3, 4].map(() => enlargeMask(mask, bitmap)));
    over = true;
    return {
      workers,
      first,
      cores: navigator.hardwareConcurrency,
      refused,
      here,
      longest,
      sizes: all.map(({ alpha }) => alpha.length),
    };
  });
  const most = Math.min(4, seen.cores);
  assert.equal(seen.first, 1);
  assert.equal(seen.workers, most);
  assert.equal(seen.refused, "param: mask = 214x120 (expected at most the picture's size, 30x20)");
  assert.deepEqual(seen.sizes, Array(4).fill(WIDTH * HEIGHT));
  t.diagnostic(`the page waited ${seen.longest.toFixed(0)} ms at most, a mask takes ${seen.here.toFixed(0)} ms`);
  // The driver learns of a worker some time after it was started or ended.
  const workers = async (count) => {
    for (let k = 0; page.workers().length !== count && k < 1000; k += 1) await page.waitForTimeout(20);
    return page.workers().length;
  };
  // With nothing left to do they end, and their memory with them; the next mask has one again.
  assert.equal(await workers(most), most);
  assert.equal(await workers(0), 0);
  const again = await page.evaluate(
    async () => (await globalThis.enlargeMask(globalThis.mask, globalThis.pixels)).width,
  );
  assert.equal(again, WIDTH);
  assert.equal(await workers(1), 1);
});

test('several workers make what one makes, of frames that share one object', async (t) => {
  const page = await open(t);
  const [one, three] = await page.evaluate(async () => {
    const { encodeVideo } = await import('/dist/index.js');
    const { encodeImages } = await import('/dist/export.js');
    const { masksAtSize } = await import('/dist/edit.js');
    const { picture, mask, fnv1a } = globalThis;
    const numFrames = 6;
    const masks = { width: mask.width, height: mask.height, numFrames, times: null, labels: () => mask.labels };
    const shared = new ImageData(picture.width, picture.height);
    async function* frames() {
      for (let k = 0; k < numFrames; k += 1) {
        picture.data.forEach((value, p) => (shared.data[p] = p % 4 < 3 ? value + 6 * k * (p % 3) : 255));
        yield shared;
      }
    }
    const { Worker } = globalThis;
    const all = [];
    for (const cores of [1, 3]) {
      Object.defineProperty(navigator, 'hardwareConcurrency', { value: cores, configurable: true });
      let workers = 0;
      globalThis.Worker = class extends Worker {
        constructor(address, options) {
          super(address, options);
          // Files are made aside.
          workers += Number(!String(address).includes('aside'));
        }
      };
      const video = await encodeVideo(masks, frames(), { style: 'cutout' });
      const images = await new Response(await encodeImages(masks, frames())).arrayBuffer();
      const large = await masksAtSize(masks, frames());
      const bytes = [await video.arrayBuffer(), images].map((buffer) => new Uint8Array(buffer));
      for (let k = 0; k < numFrames; k += 1) bytes.push(large.labels(k));
      all.push({ workers, prints: bytes.map((one) => fnv1a(one)) });
      // Idle workers end.
      await new Promise((done) => setTimeout(done, 6000));
    }
    return all;
  });
  assert.deepEqual([one.workers, three.workers], [1, 3]);
  assert.deepEqual(three.prints, one.prints);
});
