// From a dropped clip to a saved cut-out in two clicks: Save, Export.

import assert from 'node:assert/strict';
import { test } from 'node:test';
import { bytesOf, openSample, useSite } from './support.mjs';

const CLIP = { width: 1920, height: 1080, frames: 10 };

/** The moving square, in pixels: its side and its upper left corner in frame `t`. */
const SIDE = 420;
const placeOf = (t) => [400 + 32 * t, 300];

const site = useSite({ sample: 'tiny' });

test('a clip that is dropped is saved as a transparent cut-out of its full size after two clicks', async () => {
  const { page, faults } = await openSample(site, { bypassCSP: true });
  await page.evaluate(() => {
    globalThis.clicks = [];
    const count = ({ isTrusted, target }) => isTrusted && globalThis.clicks.push(target.closest('[id]').id);
    addEventListener('click', count, { capture: true });
  });
  const places = Array.from({ length: CLIP.frames }, (_, t) => placeOf(t));
  await page.evaluate(dropClip, { ...CLIP, side: SIDE, places });
  await page.waitForFunction(
    () => globalThis.tracecutStudio.source?.name === 'square.webm' && document.body.dataset.state === 'done',
  );
  await page.click('#export-open');
  await page.waitForSelector('#export[open]');
  const coming = page.waitForEvent('download');
  await page.click('#export-run');
  const file = await coming;
  assert.equal(file.suggestedFilename(), 'square-cutout.webm');
  assert.deepEqual(await page.evaluate(() => globalThis.clicks), ['export-open', 'export-run']);
  const [left, top] = placeOf(0);
  const inside = [left + SIDE / 2, top + SIDE / 2];
  const { width, height, alphas } = await page.evaluate(alphaOf, [
    [...(await bytesOf(file))],
    [inside, [60, 60], [left - 90, top], [1900, 1060]],
  ]);
  assert.deepEqual([width, height], [CLIP.width, CLIP.height]);
  assert.ok(alphas[0] > 200 && Math.max(...alphas.slice(1)) < 20, String(alphas));
  assert.deepEqual(faults, []);
});

/** Runs in the page: makes a video of a square that moves over a still ground, and drops it. */
async function dropClip({ width, height, side, places }) {
  const media = await import('/dist/vendor/media.js');
  const output = new media.Output({ format: new media.WebMOutputFormat(), target: new media.BufferTarget() });
  const video = new media.VideoSampleSource({ codec: 'vp8', bitrate: 2e7 });
  output.addVideoTrack(video);
  await output.start();
  const context = new OffscreenCanvas(width, height).getContext('2d');
  const fill = (left, top, across, down, [hue, salt]) => {
    for (let y = 0; y < down; y += 20)
      for (let x = 0; x < across; x += 20) {
        const grain = (Math.imul(x + salt, 374761393) ^ Math.imul(y + 3, 668265263)) >>> 26;
        context.fillStyle = `hsl(${hue} 50% ${20 + grain}%)`;
        context.fillRect(left + x, top + y, 20, 20);
      }
  };
  for (const [t, [left, top]] of places.entries()) {
    fill(0, 0, width, height, [120, 7]);
    fill(left, top, side, side, [10, 9]);
    const sample = new media.VideoSample(context.canvas, { timestamp: t / 10, duration: 0.1 });
    await video.add(sample);
    sample.close();
  }
  await output.finalize();
  const transfer = new DataTransfer();
  transfer.items.add(new File([output.target.buffer], 'square.webm', { type: 'video/webm' }));
  for (const type of ['dragenter', 'dragover', 'drop'])
    document.body.dispatchEvent(new DragEvent(type, { dataTransfer: transfer, bubbles: true, cancelable: true }));
}

/** Runs in the page: the opacity of places in a video's first frame. */
async function alphaOf([bytes, places]) {
  const video = document.createElement('video');
  const event = (name) =>
    new Promise((done, failed) => Object.assign(video, { [`on${name}`]: done, onerror: () => failed(video.error) }));
  const loaded = event('loadeddata');
  Object.assign(video, { muted: true, src: URL.createObjectURL(new Blob([new Uint8Array(bytes)])) });
  await loaded;
  const sought = event('seeked');
  video.currentTime = 0.05;
  await sought;
  const { videoWidth: width, videoHeight: height } = video;
  const context = new OffscreenCanvas(width, height).getContext('2d', { willReadFrequently: true });
  const read = () => places.map(([x, y]) => context.getImageData(x, y, 1, 1).data[3]);
  // The picture may come a little after the word that it has.
  for (let left = 200; left > 0 && !read().some(Boolean); left -= 1) {
    context.drawImage(video, 0, 0);
    await new Promise((done) => setTimeout(done, 20));
  }
  return { width, height, alphas: read() };
}
