// Masks at the size of their frames in Chromium: in workers, from every kind of picture, the same bytes as in Node.

import { enlargeMask } from '../../dist/node/edit.js';
import { fnv1a } from '../fingerprint.mjs';
import { expect, test } from './fixtures.mjs';

const SIZE = { width: 214, height: 120 };
const NUM_PIXELS = SIZE.width * SIZE.height;

/** Runs in Node and in the page: returns a picture of a disc, and its mask at half the size. */
function createDisc({ width, height }) {
  const isInside = (x, y) => Math.hypot(x - 100.3, y - 57.8) < 37;
  const data = new Uint8ClampedArray(4 * width * height);
  for (let p = 0; p < width * height; p += 1) {
    const [x, y] = [p % width, Math.floor(p / width)];
    const texture = (x * 7 + y * 13) % 23;
    data.set(isInside(x, y) ? [150 + texture, 90, 60, 255] : [60, 90 + texture, 120, 255], 4 * p);
  }
  const [w, h] = [width / 2, height / 2];
  const labels = Uint8Array.from({ length: w * h }, (_, p) =>
    Number(isInside(2 * (p % w) - 0.5, 2 * Math.floor(p / w) - 0.5)),
  );
  return { picture: { data, width, height }, mask: { width: w, height: h, labels } };
}

/** Opens a page with the disc. */
async function openDisc(openEmptyPage) {
  const page = await openEmptyPage();
  await page.evaluate(`globalThis.createDisc = ${createDisc}`);
  await page.evaluate(async (size) => {
    const { enlargeMask } = await import('/dist/edit.js');
    const { fnv1a } = await import('/tests/fingerprint.mjs');
    const { picture, mask } = globalThis.createDisc(size);
    const pixels = new ImageData(picture.data, picture.width);
    const print = ({ labels, alpha }) => [labels, alpha].map((bytes) => fnv1a(bytes));
    Object.assign(globalThis, { enlargeMask, fnv1a, picture, mask, pixels, print });
  }, SIZE);
  return page;
}

test('every kind of picture gives the bytes of Node, and is not changed', async ({ openEmptyPage }) => {
  const page = await openDisc(openEmptyPage);
  const { mask, picture } = createDisc(SIZE);
  const { labels, alpha } = await enlargeMask(mask, picture);
  const { prints, sizes } = await page.evaluate(async () => {
    const { enlargeMask, mask, pixels, print } = globalThis;
    const canvas = new OffscreenCanvas(pixels.width, pixels.height);
    canvas.getContext('2d').putImageData(pixels, 0, 0);
    const bitmap = await createImageBitmap(pixels);
    const init = { format: 'RGBA', codedWidth: pixels.width, codedHeight: pixels.height, timestamp: 0 };
    const frame = new VideoFrame(pixels.data, init);
    const blob = await canvas.convertToBlob();
    const prints = {};
    for (const [name, picture] of Object.entries({ pixels, canvas, bitmap, frame, blob }))
      prints[name] = print(await enlargeMask(mask, picture));
    prints.withoutWorker = print(await enlargeMask(mask, pixels, { worker: false }));
    const sizes = [bitmap.width, frame.codedWidth, pixels.data.length, mask.labels.length];
    frame.close();
    return { prints, sizes };
  });
  for (const [name, print] of Object.entries(prints)) expect(print, name).toEqual([fnv1a(labels), fnv1a(alpha)]);
  expect(sizes).toEqual([SIZE.width, SIZE.width, 4 * NUM_PIXELS, mask.labels.length]);
});

test('one worker per core at most enlarges; they survive a refused picture and end when idle', async ({
  openEmptyPage,
}) => {
  const page = await openDisc(openEmptyPage);
  // Only the test moves the clock, so that idle workers do not end on a busy machine.
  await page.clock.install({ time: 0 });
  await page.clock.pauseAt(1000);
  const outcome = await page.evaluate(async () => {
    const { enlargeMask, mask, pixels } = globalThis;
    await enlargeMask(mask, pixels);
    const refused = await enlargeMask(mask, new ImageData(30, 20)).catch((error) => `${error.code}: ${error.message}`);
    const numPixels = (await enlargeMask(mask, pixels)).alpha.length;
    return { refused, numPixels };
  });
  expect(outcome).toEqual({
    refused: "param: mask = 107x60 (expected at most the picture's size, 30x20)",
    numPixels: NUM_PIXELS,
  });
  await expect.poll(() => page.workers().length).toBe(1);
  const numCores = await page.evaluate(async () => {
    const { enlargeMask, mask, pixels } = globalThis;
    await Promise.all([1, 2, 3, 4].map(() => enlargeMask(mask, pixels)));
    return navigator.hardwareConcurrency;
  });
  await expect.poll(() => page.workers().length).toBe(Math.min(4, numCores));
  await page.clock.fastForward(6000);
  await expect.poll(() => page.workers().length).toBe(0);
  // The next mask starts one again.
  await page.evaluate(() => globalThis.enlargeMask(globalThis.mask, globalThis.pixels));
  await expect.poll(() => page.workers().length).toBe(1);
});

test('three workers give the bytes of one, also if all frames share a buffer', async ({ openEmptyPage }) => {
  const outcomes = [];
  for (const numCores of [1, 3]) {
    const page = await openDisc(openEmptyPage);
    outcomes.push(await page.evaluate(exportFrames, numCores));
  }
  const [single, triple] = outcomes;
  expect([single.numWorkers, triple.numWorkers]).toEqual([1, 3]);
  expect(triple.prints).toEqual(single.prints);
});

/** Runs in the page: exports four frames of one buffer in three ways. */
async function exportFrames(numCores) {
  Object.defineProperty(navigator, 'hardwareConcurrency', { value: numCores, configurable: true });
  const { encodeVideo } = await import('/dist/index.js');
  const { encodeImages } = await import('/dist/export.js');
  const { masksAtSize } = await import('/dist/edit.js');
  const { picture, mask, fnv1a } = globalThis;
  const numFrames = 4;
  const masks = { width: mask.width, height: mask.height, numFrames, times: null, labels: () => mask.labels };
  const buffer = new ImageData(picture.width, picture.height);
  async function* frames() {
    for (let k = 0; k < numFrames; k += 1) {
      picture.data.forEach((value, p) => (buffer.data[p] = p % 4 < 3 ? value + 6 * k * (p % 3) : 255));
      yield buffer;
    }
  }
  const { Worker, setTimeout: setTimer } = globalThis;
  // Idle workers do not end, however busy the machine is.
  globalThis.setTimeout = (action, delay) => (delay > 1000 ? 0 : setTimer(action, delay));
  let numWorkers = 0;
  globalThis.Worker = class extends Worker {
    constructor(address, options) {
      super(address, options);
      // Files are written in a worker of another kind.
      numWorkers += Number(!String(address).includes('aside'));
    }
  };
  const video = await encodeVideo(masks, frames(), { style: 'cutout' });
  const images = await new Response(await encodeImages(masks, frames())).arrayBuffer();
  const large = await masksAtSize(masks, frames());
  const files = [await video.arrayBuffer(), images].map((bytes) => new Uint8Array(bytes));
  for (let k = 0; k < numFrames; k += 1) files.push(large.labels(k));
  return { numWorkers, prints: files.map((bytes) => fnv1a(bytes)) };
}
