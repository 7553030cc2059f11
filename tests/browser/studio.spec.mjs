// The studio as a whole: its sample on load, and a clip from a dropped file to a saved, fixed cut-out.

import { createSession, synthClip } from '../../dist/node.js';
import { SMALL, downloadBytes, expect, runEnd, test } from './fixtures.mjs';
import { correct, openFix, paint, selectTool } from './studio-page.mjs';

test('segments the sample on load, with the same labels and masks as in Node', async ({ openStudio }) => {
  const page = await openStudio();
  expect(await runEnd(page)).toBe('done');
  await expect(page.locator('#headline')).toHaveText('3 moving objects');
  await expect(page.locator('#subline')).toHaveText(/^16 frames of 192 × 108 · computed in \d/);
  await expect(page.locator('#welcome')).toHaveCount(0);
  const inPage = await page.evaluate(() => {
    const { result } = globalThis.tracecutStudio;
    const masks = Array.from({ length: result.numFrames }, (_, t) => result.labels(t).join(''));
    return { labels: [...result.clusters.label], x: [...result.trajectories.x], masks };
  });
  const clip = await synthClip(SMALL);
  const session = await createSession();
  for (let t = 0; t < clip.numFrames; t += 1) await session.push(clip.frame(t));
  const result = await session.run();
  session.close();
  expect([...result.clusters.label]).toEqual(inPage.labels);
  expect([...result.trajectories.x]).toEqual(inPage.x);
  inPage.masks.forEach((mask, t) => expect(mask === result.labels(t).join(''), `masks of frame ${t}`).toBe(true));
});

/** Wider than the working size, so that the file is larger than the masks. */
const CLIP = { width: 640, height: 360, frames: 8 };

/** The moving square, in pixels: its side, and its upper left corner in frame `t`. */
const SIDE = 140;
const cornerOf = (t) => [130 + 12 * t, 100];

test('cuts out a dropped clip at full size: run, fix, and two clicks to save', async ({ openStudio }) => {
  const page = await openStudio({ sample: 'tiny', bypassCSP: true });
  await runEnd(page);
  const corners = Array.from({ length: CLIP.frames }, (_, t) => cornerOf(t));
  await page.evaluate(dropClip, { ...CLIP, side: SIDE, corners });
  await expect(page.locator('#clip-name')).toHaveText('square.webm');
  await expect(page.locator('body')).toHaveAttribute('data-state', 'done');
  await expect(page.locator('#headline')).toHaveText('1 moving object');

  // A stroke beside the square, in pixels of the masks.
  const scale = 480 / CLIP.width;
  const stroke = [
    [520, 60],
    [580, 60],
  ];
  await openFix(page);
  await selectTool(page, 'paint');
  expect(await paint(page, ...stroke.map(([x, y]) => [x * scale, y * scale]))).toMatch(/^Applied to frame/);
  await page.click('#correct-done');

  await page.evaluate(() => {
    globalThis.clicks = [];
    const record = ({ isTrusted, target }) => isTrusted && globalThis.clicks.push(target.closest('[id]').id);
    addEventListener('click', record, { capture: true });
  });
  await page.click('#export-open');
  await page.waitForSelector('#export[open]');
  const [download] = await Promise.all([page.waitForEvent('download'), page.click('#export-run')]);
  expect(await page.evaluate(() => globalThis.clicks)).toEqual(['export-open', 'export-run']);
  expect(download.suggestedFilename()).toBe('square-cutout.webm');
  const [left, top] = cornerOf(0);
  const places = [
    [left + SIDE / 2, top + SIDE / 2],
    [550, 60],
    [20, 20],
    [left - 40, top],
    [620, 340],
  ];
  const bytes = [...(await downloadBytes(download))];
  const { width, height, opacities } = await page.evaluate(firstFrame, { bytes, places });
  expect([width, height]).toEqual([CLIP.width, CLIP.height]);
  const [square, painted, ...background] = opacities;
  expect(Math.min(square, painted)).toBeGreaterThan(200);
  expect(Math.max(...background)).toBeLessThan(20);
  await page.click('#export-close');

  // The fix is undone without another run.
  expect(await correct(page, () => page.keyboard.press('Control+z'))).toBe('Undone. 1 moving object.');
});

/** Runs in the page: encodes a video of a square that moves over a resting background, and drops it. */
async function dropClip({ width, height, side, corners }) {
  const media = await import('/dist/vendor/media.js');
  const output = new media.Output({ format: new media.WebMOutputFormat(), target: new media.BufferTarget() });
  const video = new media.VideoSampleSource({ codec: 'vp8', bitrate: 1e7 });
  output.addVideoTrack(video);
  await output.start();
  const context = new OffscreenCanvas(width, height).getContext('2d');
  const fill = (left, top, across, down, [hue, salt]) => {
    for (let y = 0; y < down; y += 10)
      for (let x = 0; x < across; x += 10) {
        const grain = (Math.imul(x + salt, 374761393) ^ Math.imul(y + 3, 668265263)) >>> 26;
        context.fillStyle = `hsl(${hue} 50% ${20 + grain}%)`;
        context.fillRect(left + x, top + y, 10, 10);
      }
  };
  for (const [t, [left, top]] of corners.entries()) {
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

/** Runs in the page: the size of a video, and the opacity of places in its first frame, 0 to 255. */
async function firstFrame({ bytes, places }) {
  const video = document.createElement('video');
  const presented = new Promise((resolve, reject) => {
    video.requestVideoFrameCallback(resolve);
    video.onerror = () => reject(video.error);
  });
  Object.assign(video, { muted: true, src: URL.createObjectURL(new Blob([new Uint8Array(bytes)])) });
  document.body.append(video);
  await presented;
  const { videoWidth: width, videoHeight: height } = video;
  const context = new OffscreenCanvas(width, height).getContext('2d', { willReadFrequently: true });
  context.drawImage(video, 0, 0);
  video.remove();
  return { width, height, opacities: places.map(([x, y]) => context.getImageData(x, y, 1, 1).data[3]) };
}
