// The save dialog: its preview, and what it saves of a clip larger than its masks, with sound.

import { expect, runEnd, test, useSample } from './fixtures.mjs';
import { definePlayedFrame } from './video-clips.mjs';
import {
  accessibilityFaults,
  openFive,
  openFix,
  openLook,
  openRedo,
  openSave,
  saveExport,
  seek,
  waitForPreview,
} from './studio-page.mjs';

/** Masks of the project, and its video, which is twice as large. */
const FIVE = { width: 240, height: 136, frames: 6, scale: 2, hasSound: true };
const VIDEO = { width: 480, height: 272 };

const CHOICES = ['transparent', 'green', 'blurred', 'zip'];

const shared = useSample({ sample: 'tiny', bypassCSP: true });

/** Opens the project, and the dialog at a frame. */
async function openDialog(page, frame, shape = FIVE) {
  await openFive(page, shape);
  await seek(page, frame);
  await page.click('#export-open');
  await page.waitForSelector('#export[open]');
}

/** Runs in the page: keeps the pixels of the preview in `globalThis.pictures`, and returns its size. */
function keepPreview(name) {
  const [element] = document.querySelector('#export-preview').children;
  const [width, height] = [element.videoWidth ?? element.naturalWidth, element.videoHeight ?? element.naturalHeight];
  const context = new OffscreenCanvas(width, height).getContext('2d', { willReadFrequently: true });
  context.drawImage(element, 0, 0);
  (globalThis.pictures ??= {})[name] = context.getImageData(0, 0, width, height);
  return [width, height];
}

/** Runs in the page: keeps the pixels of a frame of a saved file, and returns the colour near its lower left corner. */
async function keepSaved({ name, bytes, frame, isZip }) {
  let picture;
  if (isZip) {
    const { unzipSync } = await import('/dist/vendor/zip.js');
    const files = unzipSync(new Uint8Array(bytes));
    const names = Object.keys(files).filter((file) => file.endsWith('.png'));
    const image = await createImageBitmap(new Blob([files[names.sort()[frame]]], { type: 'image/png' }));
    const context = new OffscreenCanvas(image.width, image.height).getContext('2d', { willReadFrequently: true });
    context.drawImage(image, 0, 0);
    picture = context.getImageData(0, 0, image.width, image.height);
  } else picture = await playedFrame(new Blob([new Uint8Array(bytes)]), (frame + 0.5) / 10);
  globalThis.pictures[name] = picture;
  const at = 4 * (picture.width * (picture.height - 5) + 4);
  return [...picture.data.subarray(at, at + 4)];
}

/** Runs in the page: the mean difference of two kept pictures over all bytes; infinite if their sizes differ. */
function distance([first, second]) {
  const [a, b] = [globalThis.pictures[first], globalThis.pictures[second]];
  if (a.data.length !== b.data.length) return Infinity;
  return a.data.reduce((sum, value, k) => sum + Math.abs(value - b.data[k]), 0) / a.data.length;
}

/** Runs in the page: size, frame times and sound of a saved video. */
async function readVideo(bytes) {
  const media = await import('/dist/vendor/media.js');
  const source = new media.BlobSource(new Blob([new Uint8Array(bytes)]));
  const input = new media.Input({ source, formats: media.ALL_FORMATS });
  const [video, audio] = [await input.getPrimaryVideoTrack(), await input.getPrimaryAudioTrack()];
  const times = [];
  for await (const { timestamp } of new media.EncodedPacketSink(video).packets()) times.push(timestamp);
  return {
    size: [await video.getDisplayWidth(), await video.getDisplayHeight()],
    times: times.sort((a, b) => a - b).map((time) => Number(time.toFixed(3))),
    soundEnd: audio ? await audio.computeDuration() : 0,
  };
}

const times = Array.from({ length: FIVE.frames }, (_, t) => t / 10);

test('offers four exports and others behind “More”; each is saved as its preview shows', async () => {
  const { page } = shared;
  await definePlayedFrame(page);
  await openDialog(page, 3);
  expect(await page.locator('#export .primary:visible').count()).toBe(1);
  const offered = () =>
    page.locator('[data-export]:visible').evaluateAll((all) => all.map((one) => one.dataset.export));
  expect(await offered()).toEqual(CHOICES);
  for (const id of CHOICES) {
    await page.check(`[data-export="${id}"]`);
    await waitForPreview(page, id);
    expect(await page.evaluate(keepPreview, id)).toEqual([VIDEO.width, VIDEO.height]);
  }
  await expect(page.locator('#export-preview-text')).toHaveText('Output: 480 × 272');
  await expect(page.locator('#export-status'), 'choosing saves nothing').toHaveText('');
  expect(await accessibilityFaults(page)).toEqual([]);
  const names = ['five-cutout.webm', 'five-green.mp4', 'five-blur.mp4', 'five-masks.zip'];
  const corners = {};
  for (const [k, id] of CHOICES.entries()) {
    const { name, bytes } = await saveExport(page, id);
    expect(name).toBe(names[k]);
    const saved = { name: 'saved', bytes: [...bytes], frame: 3, isZip: id === 'zip' };
    corners[id] = await page.evaluate(keepSaved, saved);
    const own = await page.evaluate(distance, [id, 'saved']);
    const other = await page.evaluate(distance, [CHOICES[(k + 1) % 4], 'saved']);
    expect(own, id).toBeLessThan(3);
    expect(own, id).toBeLessThan(other / 4);
  }
  expect(corners.transparent[3]).toBeLessThan(8);
  const [red, green, blue] = corners.green;
  expect(red < 60 && green > 140 && blue < 110, `green is ${corners.green}`).toBe(true);
  expect(corners.blurred[0]).toBeGreaterThan(60);
  await page.evaluate(() => (document.querySelector('#export-more').open = true));
  expect((await offered()).length).toBeGreaterThan(12);
});

test('videos have the size, the times and the sound of the source, and sharp masks', async () => {
  const { page } = shared;
  await expect(page.locator('.card:has(:checked) .value')).toHaveText(/^480 × 272, 6 frames$/);
  await expect(page.locator('#export-sound-facts')).toHaveText('Opus, unchanged.');
  for (const id of ['cutout-webm', 'overlay-mp4']) {
    const { bytes } = await saveExport(page, id);
    const { soundEnd, ...video } = await page.evaluate(readVideo, [...bytes]);
    expect(video, id).toEqual({ size: [VIDEO.width, VIDEO.height], times });
    expect(Math.abs(soundEnd - 0.6), `${id}: sound of ${soundEnd} s`).toBeLessThan(0.03);
    if (id !== 'cutout-webm') continue;
    const { wrong, objects } = await page.evaluate(compareAlpha, { bytes: [...bytes], t: 2 });
    expect(objects).toBeGreaterThan(0.01);
    expect(wrong).toBeLessThan(0.004);
  }
});

/** Runs in the page: shares of the frame that objects cover, and whose alpha differs from the mask at the size of the video. */
async function compareAlpha({ bytes, t }) {
  const { data, width, height } = await playedFrame(new Blob([new Uint8Array(bytes)]), (t + 0.5) / 10);
  const { enlargeMask } = await import('/model/library.js');
  const { app, source } = globalThis.tracecutStudio;
  const { labels } = await enlargeMask(
    { labels: app.segmentation.mask(t), width: width / 2, height: height / 2 },
    await source.preview(t, Math.max(width, height), app.job.times[t]),
  );
  let [wrong, objects] = [0, 0];
  labels.forEach((label, p) => {
    objects += label > 0;
    wrong += label > 0 !== data[4 * p + 3] > 127;
  });
  return { wrong: wrong / labels.length, objects: objects / labels.length };
}

// Not run to the end yet: until then save, save-preview, export-size and export-images.test.mjs stay.
test.fixme('size, sound, quality and mask style are those that are chosen', async () => {
  const { page } = shared;
  await page.selectOption('#export-size', 'own');
  await page.fill('#export-side', '200');
  await expect(page.locator('.card:has([data-export="zip"]) .value')).toHaveText('200 × 113, 6 frames');
  await page.uncheck('#export-sound');
  await page.selectOption('#export-quality', 'low');
  const small = await saveExport(page, 'overlay-webm');
  const { size, soundEnd } = await page.evaluate(readVideo, [...small.bytes]);
  expect([size, soundEnd]).toEqual([[200, 113], 0]);
  await page.selectOption('#export-quality', 'very-high');
  expect((await saveExport(page, 'overlay-webm')).bytes.length).toBeGreaterThan(small.bytes.length);
  await page.selectOption('#export-size', 'working');
  await page.click('#export-close');
  const colorDistance = async (settings) => {
    await openLook(page);
    for (const [name, value] of Object.entries(settings)) await page.fill(`[data-setting="masks.${name}"]`, value);
    await openSave(page);
    const { bytes } = await saveExport(page, 'overlay-webm');
    const result = await page.evaluate(distanceFromObjectColor, { bytes: [...bytes], t: 2 });
    await page.click('#export-close');
    return result;
  };
  expect(await colorDistance({ fill: '1' })).toBeLessThan(20);
  expect(await colorDistance({ opacity: '0' })).toBeGreaterThan(30);
  await page.fill('[data-setting="masks.opacity"]', '1');
});

/** Runs in the page: the largest difference between the colour of object 1 and the video deep inside it, at the size of the masks. */
async function distanceFromObjectColor({ bytes, t }) {
  const { data, width } = await playedFrame(new Blob([new Uint8Array(bytes)]), (t + 0.5) / 10);
  const mask = globalThis.tracecutStudio.app.segmentation.mask(t);
  const inside = mask.findIndex((label, p) => label === 1 && mask[p + 16] === 1 && mask[p + 16 * width] === 1);
  const at = inside + 8 * width + 8;
  const rgb = Number.parseInt(globalThis.tracecutStudio.objectColor(1).slice(1), 16);
  return Math.max(...[16, 8, 0].map((shift, c) => Math.abs(((rgb >> shift) & 255) - data[4 * at + c])));
}

test.fixme('the sound of a clip plays with its result, unless it is muted', async () => {
  const { page } = shared;
  await expect(page.locator('#mute')).toHaveAttribute('aria-label', 'Mute');
  await page.evaluate(() => {
    const { play } = HTMLMediaElement.prototype;
    HTMLMediaElement.prototype.play = function () {
      globalThis.player = this;
      return play.call(this);
    };
  });
  const isPaused = () => page.evaluate(() => globalThis.player.paused);
  const storedCount = () => page.evaluate(() => Object.keys(localStorage).length);
  await page.click('#play');
  await page.waitForFunction(() => globalThis.player?.paused === false && globalThis.player.currentTime > 0);
  await page.click('#mute');
  expect([await isPaused(), await storedCount()]).toEqual([true, 1]);
  await page.click('#mute');
  await page.waitForFunction(() => !globalThis.player.paused);
  expect(await storedCount()).toBe(0);
  await page.click('#play');
  expect(await isPaused()).toBe(true);
});

test.fixme('the preview is never empty, and the dialog does not move from opening to the saved file', async () => {
  const { page } = shared;
  await page.evaluate(() => {
    globalThis.frames = [];
    const preview = document.querySelector('#export-preview');
    const countBright = (element) => {
      const context = new OffscreenCanvas(240, 136).getContext('2d');
      context.drawImage(element, 0, 0, 240, 136);
      return context.getImageData(0, 0, 240, 136).data.filter((value, at) => at % 4 < 3 && value > 60).length;
    };
    const look = () => {
      requestAnimationFrame(look);
      if (!document.querySelector('#export').open) return;
      globalThis.firstBright ??= countBright(preview.lastElementChild);
      const places = ['#export', '#export-main', '#export-run', '#export-cancel', '.export-foot']
        .map((selector) => document.querySelector(selector))
        .filter((element) => element.checkVisibility())
        .map((element) => element.id.replace(/run|cancel/, 'button') + element.getBoundingClientRect().top);
      globalThis.frames.push({ places: places.join(' '), isEmpty: preview.childElementCount === 0 });
    };
    look();
  });
  await page.evaluate(() => (document.querySelector('#export-more').open = false));
  await page.click('#export-open');
  await waitForPreview(page, 'zip');
  for (const id of ['green', 'transparent']) {
    await page.check(`[data-export="${id}"]`);
    await waitForPreview(page, id);
  }
  await saveExport(page, 'transparent');
  const { frames, firstBright } = await page.evaluate(() => ({ frames, firstBright }));
  expect(firstBright).toBeGreaterThan(500);
  expect(frames.some(({ isEmpty }) => isEmpty)).toBe(false);
  expect([...new Set(frames.map(({ places }) => places))]).toHaveLength(1);
  await page.click('#export-close');
});

test.fixme('the preview follows frame and size, and shows actual pixels that can be dragged', async () => {
  const { page } = shared;
  await openDialog(page, 0);
  await waitForPreview(page, 'transparent');
  await page.evaluate(keepPreview, 'first');
  await page.keyboard.press('Escape');
  await seek(page, 5);
  await openSave(page);
  await waitForPreview(page, 'transparent');
  await page.evaluate(keepPreview, 'last');
  expect(await page.evaluate(distance, ['first', 'last'])).toBeGreaterThan(0.5);
  await page.selectOption('#export-size', 'half');
  await expect(page.locator('#export-preview-text')).toHaveText('Output: 240 × 136');
  await page.click('#export-close');

  await openDialog(page, 2, { width: 320, height: 180, frames: 4, scale: 4 });
  await page.evaluate(() => (document.querySelector('#export-more').open = false));
  await waitForPreview(page, 'transparent');
  const place = await page.locator('#export-preview').boundingBox();
  expect(place.width).toBeLessThan(800);
  await page.mouse.click(place.x + place.width / 4, place.y + place.height / 4);
  const look = () =>
    page.evaluate(() => {
      const box = document.querySelector('#export-preview');
      const { width } = box.firstElementChild.getBoundingClientRect();
      return { width, left: box.scrollLeft, top: box.scrollTop };
    });
  const before = await look();
  expect(before.width).toBe(1280);
  expect(Math.abs(before.left - (1280 - place.width) / 4), 'the point under the pointer stays').toBeLessThan(20);
  await page.mouse.move(place.x + 200, place.y + 200);
  await page.mouse.down();
  await page.mouse.move(place.x + 150, place.y + 160, { steps: 5 });
  await page.mouse.up();
  const after = await look();
  const moved = [after.width, after.left - before.left, after.top - before.top].map(Math.round);
  expect(moved).toEqual([1280, 50, 40]);
  await page.focus('#export-preview');
  await page.keyboard.press('ArrowRight');
  await page.waitForFunction((left) => document.querySelector('#export-preview').scrollLeft > left, after.left);
  await page.click('#export-actual-size');
  await expect(page.locator('#export-actual-size')).toHaveAttribute('aria-pressed', 'false');
});

test.fixme('a cancelled export downloads nothing', async () => {
  const { page } = shared;
  let downloads = 0;
  page.on('download', () => (downloads += 1));
  await page.evaluate(() => {
    document.querySelector('[data-export="overlay-webm"]').click();
    document.querySelector('#export-cancel').click();
  });
  await expect(page.locator('#export-status')).toHaveText('Cancelled.');
  await expect(page.locator('#export-progress')).toBeHidden();
  expect(downloads).toBe(0);
});

test.fixme('images are streamed to a chosen file if the browser allows it', async () => {
  const { page } = shared;
  const { name, bytes } = await saveExport(page, 'cutout-zip');
  expect(name).toBe('five-cutout.zip');
  // A file of the page's own folder stands in for the user's choice.
  await page.evaluate(() => {
    globalThis.showSaveFilePicker = async ({ suggestedName }) => {
      globalThis.suggestedName = suggestedName;
      const folder = await navigator.storage.getDirectory();
      return (globalThis.handle = await folder.getFileHandle('saved.zip', { create: true }));
    };
  });
  await page.evaluate(() => (document.querySelector('#export-status').textContent = ''));
  await page.click('[data-export="cutout-zip"]');
  await expect(page.locator('#export-status')).toHaveText(/^Saved five-cutout.zip/);
  const written = await page.evaluate(async () => [
    ...new Uint8Array(await (await globalThis.handle.getFile()).arrayBuffer()),
  ]);
  expect(await page.evaluate(() => globalThis.suggestedName)).toBe('five-cutout.zip');
  expect(Buffer.from(written).equals(bytes)).toBe(true);
  await page.evaluate(() => {
    globalThis.showSaveFilePicker = async () => {
      throw new DOMException('no file was chosen', 'AbortError');
    };
  });
  await page.click('[data-export="cutout-apng"]');
  await expect(page.locator('#export-status')).toHaveText('Cancelled.');
  await page.click('#export-close');
});

test.fixme('a link carries the settings to another page', async ({ openStudio }) => {
  const { page } = shared;
  await page.context().grantPermissions(['clipboard-read', 'clipboard-write']);
  await openRedo(page);
  await page.check('[name="trajectory.gridStep"][value="6"]', { force: true });
  await page.click('#redo-close');
  await openSave(page);
  await page.evaluate(() => (document.querySelector('#recipe-box').open = true));
  await expect(page.locator('#recipe')).toHaveText(/"tracecut".*"sha256": "[0-9a-f]{64}"/s);
  await page.click('#copy-link');
  await expect(page.locator('#export-status')).toHaveText('Link copied.');
  const link = await page.evaluate(() => navigator.clipboard.readText());
  expect(link).toMatch(/#trajectory\.gridStep=6$/);
  await page.click('#export-close');
  const other = await openStudio({ sample: 'tiny', query: new URL(link).hash });
  expect(await runEnd(other)).toBe('done');
  const options = await other.evaluate(() => globalThis.tracecutStudio.app.job.options);
  expect(options).toEqual({ trajectory: { gridStep: 6 } });
});

test.fixme('each state has one main button: open, save, or finish fixing', async () => {
  const { page } = shared;
  const mainButtons = () =>
    page.evaluate(() =>
      [...document.querySelectorAll('.primary')].filter((one) => one.checkVisibility()).map(({ id }) => id),
    );
  expect(await mainButtons()).toEqual(['export-open']);
  await openFix(page);
  expect(await mainButtons()).toEqual(['correct-done']);
  await page.click('#correct-done');
});
