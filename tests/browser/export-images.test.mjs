// Cut-out images and mask videos, saved by the page and opened again; files that are written while they are made.

import assert from 'node:assert/strict';
import { describe, test } from 'node:test';
import { unzipSync } from 'fflate';
import { adjustMask } from '../../dist/node/edit.js';
import { SMALL, bytesOf, exportAs, openSample, openSave, screenshot, useSite } from './support.mjs';

const { width: WIDTH, height: HEIGHT, frames: FRAMES } = SMALL;
const FRAME = 12;

describe('cut-out pictures', () => {
  const site = useSite();
  let page;
  let faults;
  let labels;
  let zip;

  const status = (pattern) =>
    page.waitForFunction(
      (text) => new RegExp(text).test(document.querySelector('#export-status').textContent),
      pattern,
    );

  async function save(id) {
    const coming = page.waitForEvent('download');
    await exportAs(page, id);
    const file = await coming;
    await status('^Saved');
    return { name: file.suggestedFilename(), bytes: await bytesOf(file) };
  }

  test('are a ZIP of PNG files for editors, transparent where no object is', async () => {
    ({ page, faults } = await openSample(site, { acceptDownloads: true }));
    const found = await page.evaluate((t) => [...globalThis.tracecutStudio.result.labels(t)], FRAME);
    // Specks are left out: less than 0.02 % of the frame.
    ({ labels } = adjustMask(
      { labels: Uint8Array.from(found), width: WIDTH, height: HEIGHT },
      { smallest: Math.ceil(0.0002 * WIDTH * HEIGHT) },
    ));
    await openSave(page);
    const { name, bytes } = await save('cutout-zip');
    await screenshot(page, 'export-images');
    assert.equal(name, 'sample-clip-cutout.zip');
    zip = bytes;
    const files = unzipSync(bytes);
    // At 30 frames per second, as no editor has 15; the clip has no sound.
    assert.equal(Object.keys(files).length, 2 * FRAMES + 2);
    const read = (file) => new TextDecoder().decode(files[file]);
    const isWellFormed = await page.evaluate(
      (xml) => new DOMParser().parseFromString(xml, 'text/xml').querySelector('parsererror') === null,
      read('timeline.xml'),
    );
    assert.ok(isWellFormed);
    assert.match(read('timeline.xml'), new RegExp(`<duration>${2 * FRAMES}</duration><rate><timebase>30<`));
    assert.match(read('README.txt'), new RegExp(`${WIDTH} x ${HEIGHT} pixels`));
    const image = files[`cutout/0000${2 * FRAME + 1}.png`];
    const { alpha, worst } = await page.evaluate(opened, [[...image], 'image/png', 0, FRAME]);
    assert.deepEqual(
      alpha,
      [...labels].map((label) => (label > 0 ? 255 : 0)),
    );
    assert.equal(worst, 0, 'colours are those of the frame');
  });

  test('or an animated PNG with the times of the clip', async () => {
    const { name, bytes } = await save('cutout-apng');
    assert.equal(name, 'sample-clip-cutout.png');
    const { alpha, worst, count, durations } = await page.evaluate(opened, [[...bytes], 'image/png', FRAME, FRAME]);
    assert.equal(count, FRAMES);
    assert.ok(
      durations.every((one) => Math.abs(one - 1e6 / 15) < 1000),
      `${durations} µs`,
    );
    assert.deepEqual(
      alpha,
      [...labels].map((label) => (label > 0 ? 255 : 0)),
    );
    assert.equal(worst, 0);
  });

  test('are streamed to disk if the browser allows it', async () => {
    // A file of the page's own folder stands in for the one that a user would choose.
    await page.evaluate(() => {
      globalThis.asked = [];
      globalThis.showSaveFilePicker = async (options) => {
        globalThis.asked.push(options.suggestedName);
        const folder = await navigator.storage.getDirectory();
        return (globalThis.handle = await folder.getFileHandle('saved.zip', { create: true }));
      };
    });
    await page.click('[data-export="cutout-zip"]');
    await status('^Saved sample-clip-cutout.zip');
    const [asked, written] = await page.evaluate(async () => [
      globalThis.asked,
      [...new Uint8Array(await (await globalThis.handle.getFile()).arrayBuffer())],
    ]);
    assert.deepEqual(asked, ['sample-clip-cutout.zip']);
    assert.ok(Buffer.from(written).equals(zip), 'the same bytes as from memory');
    await page.evaluate(() => {
      globalThis.showSaveFilePicker = async () => {
        throw new DOMException('no file was chosen', 'AbortError');
      };
    });
    await page.click('[data-export="cutout-apng"]');
    await status('^Cancelled');
    await page.evaluate(() => (globalThis.showSaveFilePicker = undefined));
  });

  test('a mask video is white where objects are', async () => {
    const { name, bytes } = await save('alpha-webm');
    assert.equal(name, 'sample-clip-mask.webm');
    const wrong = await page.evaluate(wrongGreys, [[...bytes], (FRAME + 0.5) / 15, [...labels]]);
    // Along borders what the codec loses shows.
    assert.ok(wrong < 0.01 * WIDTH * HEIGHT, `${wrong} pixels`);
    assert.deepEqual(faults, []);
  });
});

/** Runs in the page: a picture's opacity, and how far its colours are from those of the frame where it is opaque. */
async function opened([bytes, type, frameIndex, frame]) {
  const decoder = new ImageDecoder({ data: Uint8Array.from(bytes), type, colorSpaceConversion: 'none' });
  await decoder.tracks.ready;
  await decoder.completed;
  const count = decoder.tracks.selectedTrack.frameCount;
  const durations = [];
  for (let k = 0; k < count; k += 1) {
    const { image: one } = await decoder.decode({ frameIndex: k });
    durations.push(one.duration);
    one.close();
  }
  const { image } = await decoder.decode({ frameIndex });
  const pixelsOf = (picture, width, height) => {
    const context = new OffscreenCanvas(width, height).getContext('2d', { willReadFrequently: true });
    context.drawImage(picture, 0, 0);
    return context.getImageData(0, 0, width, height).data;
  };
  const [width, height] = [image.displayWidth, image.displayHeight];
  const data = pixelsOf(image, width, height);
  image.close();
  const own = pixelsOf(await globalThis.tracecutStudio.app.job.images.open(frame), width, height);
  const alpha = Array.from({ length: width * height }, (_, p) => data[4 * p + 3]);
  let worst = 0;
  alpha.forEach((one, p) => {
    for (let c = 0; one === 255 && c < 3; c += 1) worst = Math.max(worst, Math.abs(data[4 * p + c] - own[4 * p + c]));
  });
  return { alpha, worst, count, durations };
}

/** Runs in the page: pixels that a player shows on the wrong side of grey. */
async function wrongGreys([bytes, time, labels]) {
  const video = document.createElement('video');
  const event = (name) =>
    new Promise((done, failed) =>
      Object.assign(video, { [`on${name}`]: done, onerror: () => failed(new Error(video.error?.message)) }),
    );
  const loaded = event('loadeddata');
  Object.assign(video, { muted: true, src: URL.createObjectURL(new Blob([Uint8Array.from(bytes)])) });
  await loaded;
  const sought = event('seeked');
  video.currentTime = time;
  await sought;
  const { videoWidth: width, videoHeight: height } = video;
  const context = new OffscreenCanvas(width, height).getContext('2d', { willReadFrequently: true });
  for (let left = 200; left > 0; left -= 1) {
    context.drawImage(video, 0, 0);
    if (context.getImageData(0, 0, width, height).data.some((byte, k) => k % 4 < 3 && byte > 128)) break;
    await new Promise((done) => setTimeout(done, 20));
  }
  const { data } = context.getImageData(0, 0, width, height);
  return labels.filter((label, p) => label > 0 !== data[4 * p] > 127).length;
}
