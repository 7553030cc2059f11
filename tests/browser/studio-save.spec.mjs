// The save dialog: its preview, and what it saves of a clip larger than its masks, with sound.

import { createHash } from 'node:crypto';
import { gifFile } from '../gif.mjs';
import { plainFrame, textureAt } from '../moving.mjs';
import { expect, openSample, runEnd, test, useSample } from './fixtures.mjs';
import {
  accessibilityFaults,
  giveBytes,
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
const FIVE = { width: 192, height: 108, frames: 6, scale: 2, hasSound: true };
const VIDEO = [384, 216];
const TIMES = [0, 0.1, 0.2, 0.3, 0.4, 0.5];

const CHOICES = ['transparent', 'green', 'blurred', 'zip'];

const dialogPage = useSample({ sample: 'tiny', bypassCSP: true });

test.beforeAll(() => dialogPage.page.evaluate(defineReaders));

/** Each test opens its clip and dialog itself. */
test.afterEach(() => dialogPage.page.evaluate(() => document.querySelector('#export').close()));

/** Opens the project, and the dialog at a frame: with the main choices alone, or with the other choices and the options. */
async function openDialog({ frame = 2, shape = FIVE, isWhole = false } = {}) {
  const { page } = dialogPage;
  await openFive(page, shape);
  await seek(page, frame);
  await page.evaluate((isOpen) => (document.querySelector('#export-more').open = isOpen), isWhole);
  await page.click('#export-open');
  await page.waitForSelector('#export[open]');
  return page;
}

/** Saves one export, and gives its bytes to the page, as `globalThis.saved`. */
async function saveAndOpen(page, id) {
  const { name, bytes } = await saveExport(page, id);
  await giveBytes(page, 'saved', bytes);
  return { name, size: bytes.length };
}

/** Runs in the page: defines how pictures and the saved file are read; pixels stay in the page. */
async function defineReaders() {
  const media = await import('/dist/vendor/media.js');
  const pictures = {};
  const pixelsOf = (width, height, draw) => {
    const context = new OffscreenCanvas(width, height).getContext('2d', { willReadFrequently: true });
    draw(context);
    return context.getImageData(0, 0, width, height);
  };
  const videoTrack = () => new media.Input({ source: new media.BlobSource(saved), formats: media.ALL_FORMATS });
  /** Returns the pixels of the saved video at a time, in seconds. */
  const savedFrame = async (time) => {
    const sink = new media.VideoSampleSink(await videoTrack().getPrimaryVideoTrack());
    const sample = await sink.getSample(time);
    const { displayWidth, displayHeight } = sample;
    const picture = pixelsOf(displayWidth, displayHeight, (context) => sample.draw(context, 0, 0));
    sample.close();
    return picture;
  };
  /** Returns the pixels of an image of the saved ZIP. */
  const savedImage = async (frame) => {
    const { unzipSync } = await import('/dist/vendor/zip.js');
    const files = unzipSync(new Uint8Array(await saved.arrayBuffer()));
    const names = Object.keys(files).filter((file) => file.endsWith('.png'));
    const image = await createImageBitmap(new Blob([files[names.sort()[frame]]], { type: 'image/png' }));
    return pixelsOf(image.width, image.height, (context) => context.drawImage(image, 0, 0));
  };
  /** Returns size, frame times and sound of the saved video. */
  const readVideo = async () => {
    const [video, audio] = [await videoTrack().getPrimaryVideoTrack(), await videoTrack().getPrimaryAudioTrack()];
    const times = [];
    for await (const { timestamp } of new media.EncodedPacketSink(video).packets()) times.push(timestamp);
    return {
      size: [await video.getDisplayWidth(), await video.getDisplayHeight()],
      times: times.sort((a, b) => a - b).map((time) => Number(time.toFixed(3))),
      soundEnd: audio ? await audio.computeDuration() : 0,
    };
  };
  /** Keeps the pixels of the preview, and returns its size. */
  const keepPreview = (name) => {
    const [element] = document.querySelector('#export-preview').children;
    const size = [element.videoWidth ?? element.naturalWidth, element.videoHeight ?? element.naturalHeight];
    pictures[name] = pixelsOf(...size, (context) => context.drawImage(element, 0, 0));
    return size;
  };
  /** Keeps the pixels of a saved frame, and returns the colour near its lower left corner. */
  const keepSaved = async (name, picture) => {
    pictures[name] = await picture;
    const { data, width, height } = pictures[name];
    const at = 4 * (width * (height - 5) + 4);
    return [...data.subarray(at, at + 4)];
  };
  /** Returns the mean difference of two kept pictures over all bytes; infinite if their sizes differ. */
  const distance = (first, second) => {
    const [a, b] = [pictures[first].data, pictures[second].data];
    if (a.length !== b.length) return Infinity;
    return a.reduce((sum, value, k) => sum + Math.abs(value - b[k]), 0) / a.length;
  };
  Object.assign(globalThis, { savedFrame, savedImage, readVideo, keepPreview, keepSaved, distance });
}

/** Runs in the page: shares of the saved frame that objects cover, and whose alpha (or grey) differs from the mask at the size of the video. */
async function compareAlpha([t, channel]) {
  const { app, source, trim } = globalThis.tracecutStudio;
  const { times } = app.job;
  const { data, width, height } = await savedFrame((times[t] + times[t + 1]) / 2 - times[0]);
  const { enlargeMask } = await import('/model/library.js');
  const picture = await source.preview(trim.start + t, Math.max(width, height), times[t]);
  const { labels } = await enlargeMask(app.viewer.view.mask(), picture);
  let [wrong, objects] = [0, 0];
  labels.forEach((label, p) => {
    objects += label > 0;
    wrong += label > 0 !== data[4 * p + channel] > 127;
  });
  return { wrong: wrong / labels.length, objects: objects / labels.length };
}

test('offers four exports and others behind “More”; each is saved as its preview shows', async () => {
  const page = await openDialog({ frame: 3 });
  expect(await page.locator('#export .primary:visible').count()).toBe(1);
  const offered = () =>
    page.locator('[data-export]:visible').evaluateAll((inputs) => inputs.map(({ dataset }) => dataset.export));
  expect(await offered()).toEqual(CHOICES);
  for (const id of CHOICES) {
    await page.check(`[data-export="${id}"]`);
    await waitForPreview(page, id);
    expect(await page.evaluate((name) => keepPreview(name), id)).toEqual(VIDEO);
  }
  await expect(page.locator('#export-preview-text')).toHaveText('Output: 384 × 216');
  await expect(page.locator('#export-status'), 'choosing saves nothing').toHaveText('');
  expect(await accessibilityFaults(page)).toEqual([]);
  const names = ['five-cutout.webm', 'five-green.mp4', 'five-blur.mp4', 'five-masks.zip'];
  const corners = {};
  for (const [k, id] of CHOICES.entries()) {
    expect((await saveAndOpen(page, id)).name).toBe(names[k]);
    const [corner, fromPreview, fromNext] = await page.evaluate(
      async ([preview, next]) => [
        await keepSaved('saved', preview === 'zip' ? savedImage(3) : savedFrame(0.35)),
        distance(preview, 'saved'),
        distance(next, 'saved'),
      ],
      [id, CHOICES[(k + 1) % 4]],
    );
    corners[id] = corner;
    expect(fromPreview, id).toBeLessThan(5);
    expect(fromPreview, id).toBeLessThan(fromNext / 4);
  }
  expect(corners.transparent[3]).toBeLessThan(8);
  const [red, green, blue] = corners.green;
  expect(red < 60 && green > 140 && blue < 110, `green is ${corners.green}`).toBe(true);
  expect(corners.blurred[0]).toBeGreaterThan(60);
  await page.evaluate(() => (document.querySelector('#export-more').open = true));
  expect((await offered()).length).toBeGreaterThan(12);
});

test('videos have the size, the times and the sound of the source, and sharp masks', async () => {
  const page = await openDialog({ isWhole: true });
  await expect(page.locator('.card:has([data-export="transparent"]) .value')).toHaveText(
    /^384 × 216, 0\.6\s+s, about [\d.]+\s[kK]?B$/,
  );
  await expect(page.locator('#export-sound-facts')).toHaveText('Opus, unchanged.');
  await page.evaluate(() => {
    const count = document.querySelector('#export-count');
    new MutationObserver(() => (globalThis.counted ??= []).push(count.textContent)).observe(count, { childList: true });
  });
  for (const [id, channel] of [
    ['cutout-webm', 3],
    ['alpha-webm', 0],
    ['overlay-mp4', null],
  ]) {
    await saveAndOpen(page, id);
    const { size, times, soundEnd } = await page.evaluate(() => readVideo());
    expect([size, times], id).toEqual([VIDEO, TIMES]);
    expect(Math.abs(soundEnd - 0.6), `${id}: sound of ${soundEnd} s`).toBeLessThan(0.03);
    if (channel === null) continue;
    const { wrong, objects } = await page.evaluate(compareAlpha, [2, channel]);
    expect(objects).toBeGreaterThan(0.01);
    expect(wrong).toBeLessThan(0.004);
  }
  expect(await page.evaluate(() => globalThis.counted)).toContain('6 of 6 frames');
});

test('videos have the chosen size and quality, and no sound if it is switched off', async () => {
  const page = await openDialog({ isWhole: true });
  await page.selectOption('#export-size', 'own');
  await page.fill('#export-side', '200');
  await expect(page.locator('.card:has([data-export="zip"]) .value')).toHaveText('200 × 113, 6 frames');
  await page.uncheck('#export-sound');
  await page.selectOption('#export-quality', 'low');
  const { size } = await saveAndOpen(page, 'overlay-webm');
  expect(await page.evaluate(() => readVideo())).toMatchObject({ size: [200, 113], soundEnd: 0 });
  await page.selectOption('#export-quality', 'very-high');
  expect((await saveExport(page, 'overlay-webm')).bytes.length).toBeGreaterThan(size);
  await page.selectOption('#export-quality', 'high');
  await page.check('#export-sound');
});

test('overlays have the mask style on screen', async () => {
  const page = await openDialog();
  const setStyle = async (settings) => {
    await page.click('#export-close');
    await openLook(page);
    for (const [name, value] of Object.entries(settings)) await page.fill(`[data-setting="masks.${name}"]`, value);
    await openSave(page);
  };
  const colorDistance = async (settings) => {
    await setStyle(settings);
    // The size of the masks.
    await page.selectOption('#export-size', 'half');
    await saveAndOpen(page, 'overlay-webm');
    return page.evaluate(distanceFromObjectColor, 2);
  };
  expect(await colorDistance({ fill: '1' })).toBeLessThan(20);
  expect(await colorDistance({ opacity: '0' })).toBeGreaterThan(30);
  await setStyle({ opacity: '1', fill: '0' });
});

/** Runs in the page: the largest difference between the colour of object 1 and the saved video inside it, at the size of the masks. */
async function distanceFromObjectColor(t) {
  const { data, width } = await savedFrame((t + 0.5) / 10);
  const { objectColor, app } = globalThis.tracecutStudio;
  const mask = app.segmentation.mask(t);
  const corner = mask.findIndex((label, p) => label === 1 && mask[p + 12] === 1 && mask[p + 12 * width] === 1);
  const at = 4 * (corner + 6 * width + 6);
  const rgb = Number.parseInt(objectColor(1).slice(1), 16);
  return Math.max(...[16, 8, 0].map((shift, c) => Math.abs(((rgb >> shift) & 255) - data[at + c])));
}

test('the sound of a clip plays with its result, unless it is muted', async () => {
  const { page } = dialogPage;
  await openFive(page, FIVE);
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

test('the preview is never empty, and the dialog does not move from opening to the saved file', async () => {
  const page = await openDialog();
  await page.click('#export-close');
  await page.evaluate(() => {
    globalThis.frames = [];
    const preview = document.querySelector('#export-preview');
    const countBright = (element) => {
      const context = new OffscreenCanvas(240, 136).getContext('2d');
      context.drawImage(element, 0, 0, 240, 136);
      return context.getImageData(0, 0, 240, 136).data.filter((value, at) => at % 4 < 3 && value > 60).length;
    };
    const watch = () => {
      if (!globalThis.frames) return;
      requestAnimationFrame(watch);
      if (!document.querySelector('#export').open) return;
      globalThis.firstBright ??= countBright(preview.lastElementChild);
      const places = ['#export', '#export-main', '#export-run', '#export-cancel', '.export-foot']
        .map((selector) => document.querySelector(selector))
        .filter((element) => element.checkVisibility())
        .map((element) => element.id.replace(/run|cancel/, 'button') + element.getBoundingClientRect().top);
      globalThis.frames.push({ places: places.join(' '), isEmpty: preview.childElementCount === 0 });
    };
    watch();
  });
  await page.click('#export-open');
  for (const id of ['blurred', 'green', 'transparent']) {
    await page.check(`[data-export="${id}"]`);
    await waitForPreview(page, id);
  }
  await saveExport(page, 'transparent');
  const { frames, firstBright } = await page.evaluate(() => {
    const { frames, firstBright } = globalThis;
    globalThis.frames = null;
    return { frames, firstBright };
  });
  expect(firstBright).toBeGreaterThan(500);
  expect(frames.some(({ isEmpty }) => isEmpty)).toBe(false);
  expect([...new Set(frames.map(({ places }) => places))]).toHaveLength(1);
});

test('the preview follows frame and size', async () => {
  const page = await openDialog({ frame: 0 });
  await page.check('[data-export="transparent"]');
  await waitForPreview(page, 'transparent');
  await page.evaluate(() => keepPreview('first'));
  await page.keyboard.press('Escape');
  await seek(page, 5);
  await openSave(page);
  await waitForPreview(page, 'transparent');
  await page.evaluate(() => keepPreview('last'));
  expect(await page.evaluate(() => distance('first', 'last'))).toBeGreaterThan(0.5);
  await page.selectOption('#export-size', 'half');
  await expect(page.locator('#export-preview-text')).toHaveText('Output: 192 × 108');
});

test('the preview shows actual pixels, which can be dragged', async () => {
  const page = await openDialog({ frame: 0, shape: { width: 320, height: 180, frames: 2, scale: 4 } });
  // An image, which browsers would drag as a whole.
  await page.check('[data-export="zip"]');
  await waitForPreview(page, 'zip');
  const place = await page.locator('#export-preview').boundingBox();
  expect(place.width).toBeLessThan(800);
  await page.mouse.click(place.x + place.width / 4, place.y + place.height / 4);
  const watch = () =>
    page.evaluate(() => {
      const box = document.querySelector('#export-preview');
      const { width } = box.firstElementChild.getBoundingClientRect();
      return { width, left: box.scrollLeft, top: box.scrollTop };
    });
  const before = await watch();
  expect(before.width).toBe(1280);
  expect(Math.abs(before.left - (1280 - place.width) / 4), 'the point under the pointer stays').toBeLessThan(20);
  await page.mouse.move(place.x + 200, place.y + 200);
  await page.mouse.down();
  await page.mouse.move(place.x + 150, place.y + 160, { steps: 5 });
  await page.mouse.up();
  await expect
    .poll(async () => {
      const { width, left, top } = await watch();
      return [width, left - before.left, top - before.top].map(Math.round);
    })
    .toEqual([1280, 50, 40]);
  await page.focus('#export-preview');
  await page.keyboard.press('ArrowRight');
  await page.waitForFunction((left) => document.querySelector('#export-preview').scrollLeft > left, before.left + 51);
  await page.click('#export-actual-size');
  await expect(page.locator('#export-actual-size')).toHaveAttribute('aria-pressed', 'false');
});

test('a cancelled export downloads nothing', async () => {
  const page = await openDialog();
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

test('images are streamed to a chosen file if the browser allows it', async () => {
  const page = await openDialog({ isWhole: true });
  const { name, bytes } = await saveExport(page, 'cutout-zip');
  expect(name).toBe('five-cutout.zip');
  // A file of the page's own folder stands in for the user's choice.
  await page.evaluate(() => {
    document.querySelector('#export-status').textContent = '';
    globalThis.showSaveFilePicker = async ({ suggestedName }) => {
      const folder = await navigator.storage.getDirectory();
      return (globalThis.handle = await folder.getFileHandle(suggestedName, { create: true }));
    };
  });
  await page.click('[data-export="cutout-zip"]');
  await expect(page.locator('#export-status')).toHaveText(/^Saved five-cutout.zip/);
  const [file, hash] = await page.evaluate(async () => {
    const written = await globalThis.handle.getFile();
    const digest = new Uint8Array(await crypto.subtle.digest('SHA-256', await written.arrayBuffer()));
    return [
      written.name,
      digest.toHex?.() ?? Array.from(digest, (byte) => byte.toString(16).padStart(2, '0')).join(''),
    ];
  });
  expect([file, hash]).toEqual([name, createHash('sha256').update(bytes).digest('hex')]);
  await page.evaluate(() => {
    globalThis.showSaveFilePicker = async () => {
      throw new DOMException('no file was chosen', 'AbortError');
    };
  });
  await page.click('[data-export="cutout-apng"]');
  await expect(page.locator('#export-status')).toHaveText('Cancelled.');
  await page.evaluate(() => (globalThis.showSaveFilePicker = undefined));
});

test('saved videos have the delays of a GIF', async () => {
  const { page } = dialogPage;
  const delays = [5, 30, 5, 60, 5, 25];
  const frames = delays.map((_, t) =>
    plainFrame(96, 64, (x, y) => {
      const isInside = x >= 12 + 2 * t && x < 40 + 2 * t && y >= 16 && y < 48;
      return Array(3).fill(isInside ? textureAt(x - 2 * t, y, 1) : textureAt(x, y));
    }),
  );
  await page.setInputFiles('#file', [gifFile('uneven.gif', frames, delays)]);
  await page.waitForFunction(() => globalThis.tracecutStudio.source?.name === 'uneven.gif');
  expect(await runEnd(page)).toBe('done');
  await openSave(page);
  await saveAndOpen(page, 'overlay-webm');
  expect((await page.evaluate(() => readVideo())).times).toEqual([0, 0.05, 0.35, 0.4, 1, 1.05]);
  const end = await page.evaluate(async () => (await playedFrame(saved)).duration);
  // The last frame lasts as long as in the GIF.
  expect(end).toBeCloseTo(1.3, 2);
});

test('a link carries the settings to another page', async ({ openStudio }) => {
  const page = await openDialog();
  await page.click('#export-close');
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
  const linkedPage = await openSample(openStudio, { sample: 'tiny', query: new URL(link).hash });
  const options = await linkedPage.evaluate(() => globalThis.tracecutStudio.app.job.options);
  expect(options).toEqual({ trajectory: { gridStep: 6 } });
});

test('each state has one main button: open, save, or finish fixing', async ({ openStudio }) => {
  const page = await openSample(openStudio, { sample: 'tiny' });
  const mainButtons = () =>
    page.evaluate(() =>
      [...document.querySelectorAll('.primary')].filter((button) => button.checkVisibility()).map(({ id }) => id),
    );
  expect(await mainButtons()).toEqual(['open']);
  await expect(page.locator('#subline')).toBeHidden();
  await page.click('#help-open');
  await expect(page.locator('#facts'), 'numbers are in the help').toHaveText(/^4 frames of .* computed in/);
  await page.click('#help-close');
  await openFive(page, FIVE);
  expect(await mainButtons()).toEqual(['export-open']);
  await openFix(page);
  expect(await mainButtons()).toEqual(['correct-done']);
  await page.click('#correct-done');
});

test('clips of 854 × 480 and 4K are saved at their size', { tag: '@long' }, async () => {
  for (const [shape, size] of [
    [{ width: 427, height: 240, frames: 8, scale: 2, hasSound: true }, [854, 480]],
    [{ width: 480, height: 270, frames: 6, scale: 8, hasSound: true }, [3840, 2160]],
  ]) {
    const page = await openDialog({ shape, isWhole: true });
    const times = Array.from({ length: shape.frames }, (_, t) => t / 10);
    for (const id of ['cutout-webm', 'overlay-mp4']) {
      await saveAndOpen(page, id);
      const video = await page.evaluate(() => readVideo());
      expect(video, id).toMatchObject({ size, times });
      expect(Math.abs(video.soundEnd - shape.frames / 10)).toBeLessThan(0.03);
      if (id === 'cutout-webm') expect((await page.evaluate(compareAlpha, [2, 3])).wrong).toBeLessThan(0.002);
    }
    const { bytes } = await saveExport(page, 'png');
    expect([bytes.readUInt32BE(16), bytes.readUInt32BE(20)]).toEqual(size);
    await page.click('#export-close');
  }
});
