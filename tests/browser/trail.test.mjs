// The trail behind cut-out objects: on screen, in what is saved, and in transparent videos; in a clip of three windows.

import assert from 'node:assert/strict';
import { test } from 'node:test';
import {
  accessibilityFaults,
  bytesOf,
  ended,
  inPhase,
  movingClip,
  openSample,
  openSave,
  screenshot,
  text,
  useSite,
} from './support.mjs';

const site = useSite({ sample: 'tiny' });
const [WIDTH, HEIGHT] = [96, 64];
const FRAME = 55;

/** The pixels on screen, one for each of the clip. */
const onScreen = (page) =>
  page.evaluate(
    ([width, height]) => {
      const { viewer } = globalThis.tracecutDemo.app;
      viewer.draw();
      const context = new OffscreenCanvas(width, height).getContext('2d', { willReadFrequently: true });
      context.imageSmoothingEnabled = false;
      context.drawImage(viewer.canvas, 0, 0, width, height);
      return [...context.getImageData(0, 0, width, height).data];
    },
    [WIDTH, HEIGHT],
  );

/** How many pixels are neither clear nor opaque. */
const through = (pixels) => pixels.filter((value, k) => k % 4 === 3 && value > 20 && value < 235).length;

/** The part of all pixels in which two pictures differ to the eye on black, in brightness or opacity: videos blur colours. */
function unlike(a, b) {
  const light = (pixels, p) => {
    const [red, green, blue, alpha] = pixels.slice(4 * p, 4 * p + 4);
    return ((0.3 * red + 0.59 * green + 0.11 * blue) * alpha) / 255;
  };
  const off = Array.from({ length: a.length / 4 }, (_, p) =>
    Math.max(Math.abs(light(a, p) - light(b, p)), Math.abs(a[4 * p + 3] - b[4 * p + 3])),
  );
  return off.filter((by) => by > 32).length / off.length;
}

async function saved(page, id) {
  await openSave(page);
  const coming = page.waitForEvent('download');
  await page.click(`[data-export="${id}"]`);
  const bytes = [...(await bytesOf(await coming))];
  await page.waitForFunction(() => /^Saved/.test(document.querySelector('#export-status').textContent));
  await page.click('#export-close');
  return bytes;
}

/** A frame of an archive of PNG files. */
const fromArchive = (page, bytes, name) =>
  page.evaluate(
    async ([data, file]) => {
      const { unzipSync } = await import('/dist/vendor/zip.js');
      const bitmap = await createImageBitmap(new Blob([unzipSync(Uint8Array.from(data))[file]]), {
        premultiplyAlpha: 'none',
      });
      const context = new OffscreenCanvas(bitmap.width, bitmap.height).getContext('2d', { willReadFrequently: true });
      context.drawImage(bitmap, 0, 0);
      return [...context.getImageData(0, 0, bitmap.width, bitmap.height).data];
    },
    [bytes, name],
  );

/** A frame of a video, on nothing. */
const fromVideo = (page, bytes, t, fps) =>
  page.evaluate(
    async ([data, at, rate]) => {
      const url = URL.createObjectURL(new Blob([Uint8Array.from(data)], { type: 'video/webm' }));
      const video = Object.assign(document.createElement('video'), { muted: true, src: url });
      await new Promise((done) => (video.onloadeddata = done));
      // The picture may come a little after the word that it has.
      const shown = new Promise((done) => {
        const look = (_, { mediaTime }) =>
          Math.abs(mediaTime - at) < 1 / rate ? done() : video.requestVideoFrameCallback(look);
        video.requestVideoFrameCallback(look);
      });
      video.currentTime = at;
      await shown;
      const { videoWidth, videoHeight } = video;
      const context = new OffscreenCanvas(videoWidth, videoHeight).getContext('2d', { willReadFrequently: true });
      context.drawImage(video, 0, 0);
      return [...context.getImageData(0, 0, videoWidth, videoHeight).data];
    },
    [bytes, (t + 0.5) / fps, fps],
  );

test('is on screen as it is saved, over cuts of windows, and goes again', async () => {
  const { page, faults } = await openSample(site, { bypassCSP: true });
  await page.setInputFiles('#file', movingClip(110, [WIDTH, HEIGHT]));
  await inPhase(page, 'running');
  assert.equal(await ended(page), 'done');
  assert.match(await text(page, '#subline'), /in 3 windows/);
  await page.evaluate((t) => globalThis.tracecutDemo.app.timeline.seek(t), FRAME);
  await page.check('[name="view"][value="cutout"]', { force: true });
  const fps = await page.evaluate(() => globalThis.tracecutDemo.app.viewer.store.state.film.fps);
  const plain = await onScreen(page);
  await page.selectOption('#trail', { label: 'Copies' });
  // Frames of a long clip are files, which come when they are asked for.
  const whole = () => page.evaluate((t) => globalThis.tracecutDemo.app.viewer.trail.made.has(t - 32), FRAME);
  for (let left = 200; left > 0 && !(await whole()); left -= 1) await page.waitForTimeout(50);
  const trail = await onScreen(page);
  assert.ok(through(plain) < 60 && through(trail) > 300, `${through(plain)} and ${through(trail)} pixels let through`);
  assert.ok(unlike(plain, trail) > 0.04);
  await screenshot(page, 'trail');
  assert.deepEqual(await accessibilityFaults(page), []);

  const png = await fromArchive(page, await saved(page, 'cutout-zip'), `000${FRAME}.png`);
  assert.ok(unlike(png, trail) < 0.02, `${unlike(png, trail)} of the picture is not what is on screen`);
  const webm = await fromVideo(page, await saved(page, 'cutout-webm'), FRAME, fps);
  assert.ok(unlike(webm, png) < 0.04, `${unlike(webm, png)} of the transparent video is not what is on screen`);
  await page.selectOption('#ground', 'green');
  const [green, screen] = [await fromVideo(page, await saved(page, 'cutout-webm'), FRAME, fps), await onScreen(page)];
  assert.ok(unlike(green, screen) < 0.04, `${unlike(green, screen)} of the green video is not what is on screen`);

  await page.selectOption('#ground', 'transparent');
  await page.uncheck('[data-object="1"] input');
  assert.equal(through(await onScreen(page)), 0, 'what is not kept has no trail');
  await page.check('[data-object="1"] input');
  await page.selectOption('#trail', { label: 'No trail' });
  assert.deepEqual(await onScreen(page), plain);
  assert.deepEqual(faults, []);
  await page.context().close();
});
