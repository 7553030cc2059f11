// Runs on the page of the studio: files as people drop them, runs cancelled and continued, the coarse preview, suggestions, and the
// trim.

import { existsSync, readFileSync } from 'node:fs';
import { join } from 'node:path';
import { root } from '../../scripts/tools.mjs';
import { ensureClips, hasFfmpeg } from '../intake.mjs';
import { movingFrames, plainFrame, shiftingFrames, textureAt } from '../moving.mjs';
import { expect, openSample, runEnd, test, useSample } from './fixtures.mjs';
import {
  accessibilityFaults,
  dropFiles,
  holdFrames,
  masks,
  openRedo,
  openSave,
  pngFile,
  pngFiles,
  releaseFrames,
  runAgain,
  saveExport,
  setControl,
  waitForPhase,
} from './studio-page.mjs';
import { needsFfmpeg } from './video-clips.mjs';

const PHONE = { viewport: { width: 390, height: 844 }, isMobile: true, hasTouch: true };

/** Gives files to the studio and expects that their run succeeds. */
async function open(page, files) {
  await page.setInputFiles('#file', files);
  expect(await runEnd(page), await page.locator('#error').innerText()).toBe('done');
}

const trimOf = (page) => page.evaluate(() => globalThis.tracecutStudio.trim);

/** Returns a video of plain frames whose red grows by 10, a tenth of a second each; its length is not in the file. */
async function redsVideo(page) {
  const bytes = await page.evaluate(async () => {
    const { base64Of, encodeClip, evenTimes } = await import('/tests/browser/page-helpers.mjs');
    const draw = (context, k) => {
      context.fillStyle = `rgb(${10 * k}, 90, 90)`;
      context.fillRect(0, 0, 128, 64);
    };
    return base64Of(await encodeClip({ times: evenTimes(24, 10), draw, hasLength: false }));
  });
  return { name: 'reds.webm', mimeType: 'video/webm', buffer: Buffer.from(bytes, 'base64') };
}

/** Returns a file of the intake table, without a type. */
const clipFile = (name, source) => ({ name, mimeType: '', buffer: readFileSync(join(ensureClips(), source)) });

test.describe('a run', () => {
  const sample = useSample({ sample: 'tiny', bypassCSP: true });

  test('refuses files that the browser cannot decode, and says what to do', async () => {
    const { page } = sample;
    const noise = Buffer.from(Array.from({ length: 4000 }, (_, k) => (k * 167 + (k >> 3)) % 256));
    const video = Buffer.concat([Buffer.from('\0\0\0\x10ftypisom\0\0\x02\0', 'latin1'), noise]);
    const image = pngFile('a.png', plainFrame(32, 32));
    for (const [files, code] of [
      [[{ name: 'broken.mp4', mimeType: 'video/mp4', buffer: video }], 'unreadable-video'],
      [[image, { ...image, name: 'b.png', buffer: image.buffer.subarray(0, 40) }], 'unreadable-image'],
      [[image, pngFile('b.png', plainFrame(40, 32))], 'mixed-sizes'],
    ]) {
      await page.setInputFiles('#file', files);
      expect(await runEnd(page)).toBe('error');
      await expect(page.locator('#error')).toHaveAttribute('data-code', code);
      await expect(page.locator('#error-title')).toHaveText(/^.{11,}/);
      await expect(page.locator('#error-advice')).toHaveText(/\b(use|open|convert|choose)\b/i);
      await expect(page.locator('#canvas')).toBeHidden();
    }
    await page.click('#error-sample');
    expect(await runEnd(page)).toBe('done');
    await expect(page.locator('#error')).toBeHidden();
    await expect(page.locator('#subline')).toHaveText(/^4 frames of 64 × 36/);
  });

  test('begins when images are dropped', async () => {
    const { page } = sample;
    await expect(page.locator('#camera-open'), 'of a computer').toBeHidden();
    await dropFiles(page, pngFiles(movingFrames(6, [64, 48])));
    await expect(page.locator('#clip-name')).toHaveText('frame0.png … frame5.png');
    expect(await runEnd(page)).toBe('done');
    await expect(page.locator('#subline')).toHaveText(/^6 frames of 64 × 48/);
    await expect(page.locator('body')).not.toHaveClass(/is-dropping/);
  });

  test('reads a video without a known type, and shows its average frame rate', async () => {
    needsFfmpeg();
    const { page } = sample;
    await open(page, [clipFile('clip', 'vfr.mp4')]);
    await expect(page.locator('#counter')).toHaveText(/\/ 16$/);
    await expect(page.locator('#headline')).toHaveText('1 moving object');
    await expect(page.locator('#clip-facts')).toHaveText('120 × 90, 0.9 s at 17.14 fps');
  });

  test('uses the frames of a truncated video before the damage, also in saved files', async () => {
    needsFfmpeg();
    const { page } = sample;
    await open(page, [clipFile('cut.mp4', 'cut-off.mp4')]);
    await expect(page.locator('#notice')).toHaveText(/^The file is damaged: the first 8 of 16 frames/);
    await openSave(page);
    expect(JSON.parse((await saveExport(page, 'coco')).bytes).images).toHaveLength(8);
    await page.click('#export-close');
  });

  test('sorts images by their numbers, without hidden files, and uses those before a damaged one', async () => {
    const images = pngFiles(movingFrames(10, [96, 64])).map((file) => ({ ...file, mimeType: '' }));
    images[6].buffer = images[6].buffer.subarray(0, 60);
    const hidden = images.map(({ name }) => ({ name: `._${name}`, mimeType: '', buffer: Buffer.from('Mac OS X') }));
    const { page } = sample;
    await open(page, [...hidden, ...images.toReversed()]);
    await expect(page.locator('#notice')).toHaveText(/^The file is damaged: the first 6 of 10 frames/);
    await expect(page.locator('#counter')).toHaveText(/\/ 6$/);
  });

  test('shows finished frames; cancelled, it keeps them, and continues to the same result', async () => {
    const { page } = sample;
    await open(page, pngFiles(movingFrames(60, [64, 48])));
    const finished = (await masks(page)).split('|');
    // Enough frames for the first window, but not for the second.
    await holdFrames(page, 55);
    await runAgain(page);
    await expect(page.locator('body[data-streaming]')).toHaveCount(1);
    await waitForPhase(page, 'running');
    await expect(page.locator('#counter')).toHaveText('1 / 60');
    await expect(page.locator('.lane')).not.toHaveCount(0);
    await page.keyboard.press('Escape');
    await waitForPhase(page, 'done');
    await expect(page.locator('#notice')).toHaveText(/^Stopped early: \d\d of 60 frames/);
    const part = (await masks(page)).split('|');
    expect(part).toEqual(finished.slice(0, part.length));
    await expect(page.locator('#counter')).toHaveText(`1 / ${part.length}`);
    await expect(page.locator('#correct-open'), 'a partial result is not corrected').toBeHidden();
    await openSave(page);
    expect(JSON.parse((await saveExport(page, 'coco')).bytes).images).toHaveLength(part.length);
    expect((await saveExport(page, 'overlay-webm')).bytes.length).toBeGreaterThan(1000);
    await page.click('#export-close');
    await page.click('#resume');
    await waitForPhase(page, 'running');
    await expect(page.locator('#counter')).toHaveText(/\/ 60$/);
    await releaseFrames(page);
    expect(await runEnd(page)).toBe('done');
    expect((await masks(page)).split('|')).toEqual(finished);
    await expect(page.locator('#correct-open')).toBeVisible();
    await expect(page.locator('#resume')).toBeHidden();
  });

  test('has a coarse preview, which stays after a cancel and gives way to another clip', async () => {
    const { page } = sample;
    const mark = page.locator('#preview-mark');
    const numRead = 20;
    const files = pngFiles(
      Array.from({ length: numRead }, (_, t) =>
        plainFrame(320, 216, (x, y) => {
          const isInside = x >= 20 + 2 * t && x < 100 + 2 * t && y >= 50 && y < 130;
          const value = isInside ? textureAt((x - 2 * t) >> 1, y >> 1, 2) : textureAt(x >> 1, y >> 1, 1);
          return [value, value, isInside ? 255 - value : value];
        }),
      ),
    );
    // Enough frames for a preview; the others are never read.
    for (let t = numRead; t < 50; t += 1) files.push({ ...files[0], name: `frame${t}.png` });
    await holdFrames(page, numRead);
    await page.setInputFiles('#file', files);
    await expect(page.locator('body')).toHaveAttribute('data-preview', '');
    await expect(mark).toBeVisible();
    await expect(mark).toHaveText('Coarse preview');
    await expect(page.locator('#live')).toHaveText(/coarse preview/i);
    await expect(page.locator('#counter')).toHaveText('1 / 15');
    const labels = await page.evaluate(() => {
      const { viewer } = globalThis.tracecutStudio.app;
      viewer.draw();
      return new Set(viewer.edgedMask().labels).size;
    });
    expect(labels, 'the canvas shows the object').toBe(2);
    await page.keyboard.press('Escape');
    await waitForPhase(page, 'stopped');
    await expect(mark).toBeVisible();
    await page.click('#sample');
    await expect(page.locator('#subline')).toHaveText(/^4 frames/);
    await expect(mark).toBeHidden();
    await releaseFrames(page);
  });

  test('that finds nothing suggests what to try, and a click adds the missed object', async () => {
    const { page } = sample;
    await open(page, pngFiles(shiftingFrames(30, 2, [64, 48])));
    const suggestions = page.locator('[data-suggestion]');
    await expect(suggestions).toHaveText(['Every 2nd frame, for slow motion', 'Click the object to add it']);
    await expect(page.locator('#suggestions-report')).toHaveText(/^Tracked .* nothing stands out\.$/);
    expect(await accessibilityFaults(page)).toEqual([]);
    await suggestions.first().click();
    expect(await runEnd(page)).toBe('done');
    expect(await trimOf(page)).toEqual({ start: 0, frames: 15, step: 2, side: 480 });
    await page.click('[data-suggestion="add"]');
    await expect(page.locator('#suggestions')).toBeHidden();
    await expect(page.locator('#correct-tools [value="add"]')).toBeChecked();
    await page.locator('#canvas').click();
    await expect(page.locator('.object')).toHaveCount(2);
    await page.click('#correct-done');
    await expect(page.locator('#suggestions'), 'there is an object now').toBeHidden();
  });
});

test.describe('the trim', () => {
  const sample = useSample({ sample: 'tiny', bypassCSP: true });
  const drawn = (page) => expect(page.locator('#trim-strip')).toHaveAttribute('data-ready', 'reds.webm');

  test('shows the clip, and its handles select a part by keyboard and pointer', async () => {
    const { page } = sample;
    const [from, to, text] = ['#trim-from', '#trim-to', '#trim-text'].map((id) => page.locator(id));
    const run = page.locator('#trim-run');
    await expect(page.locator('#trim'), 'the sample cannot be trimmed').toBeHidden();
    await open(page, [await redsVideo(page)]);
    await drawn(page);
    const reds = await page
      .locator('#trim-strip canvas')
      .evaluateAll((canvases) => canvases.map((canvas) => canvas.getContext('2d').getImageData(9, 9, 1, 1).data[0]));
    // The middle of each of twelve equal parts.
    expect(reds).toHaveLength(12);
    reds.forEach((red, k) => expect(Math.abs(red - 10 * (2 * k + 1)), `picture ${k}`).toBeLessThan(5));
    await expect(text).toHaveText(/^Whole clip, 2\.4\ss$/);
    await expect(run).toBeHidden();

    await from.focus();
    for (let press = 0; press < 5; press += 1) await page.keyboard.press('ArrowRight');
    await expect(page.locator('#preview'), 'the frame at the handle is shown').toBeVisible();
    await expect(from).toHaveAttribute('aria-valuetext', /^0\.5\ss$/);
    await page.keyboard.press('Tab');
    const box = await page.locator('#trim-box').boundingBox();
    await page.mouse.move(box.x + box.width - 10, box.y + box.height / 2);
    await page.mouse.down();
    await page.mouse.move(box.x + box.width * 0.6, box.y + box.height / 2, { steps: 6 });
    await page.mouse.up();
    await expect(page.locator('#preview'), 'the result is back').toBeHidden();
    const last = Number(await to.inputValue());
    expect(last).toBeGreaterThan(10);
    expect(last).toBeLessThan(18);
    await expect(text).toHaveText(/^0\.5–1\.\d\ss of 2\.4\ss$/);
    await expect(run).toHaveText('Run this part');
    expect(await accessibilityFaults(page)).toEqual([]);
    await run.click();
    expect(await runEnd(page)).toBe('done');
    expect(await trimOf(page)).toEqual({ start: 5, frames: last - 4, step: 1, side: 480 });
    const times = await page.evaluate(() => globalThis.tracecutStudio.app.job.times);
    expect(times.map((time) => Math.round(10 * time))).toEqual(Array.from({ length: last - 4 }, (_, k) => k + 5));
    await expect(run).toBeHidden();

    await setControl(page, '#trim-to', '0');
    await expect(to, 'the handles do not meet').toHaveValue('6');
    await page.click('#trim-all');
    await expect(run).toHaveText('Run the whole clip');
    await openRedo(page);
    await expect(page.locator('#clip-all'), 'the whole clip is chosen').toBeHidden();
    for (const [id, value] of Object.entries({ frames: '8', step: '2', side: '320', start: '6' }))
      await setControl(page, `#clip-${id}`, value);
    await expect(page.locator('#clip-text')).toHaveText(/^8 frames of 128 × 64, 0\.6\ss to 2\.0\ss/);
    await expect(page.locator('#clip-all')).toBeVisible();
    await page.click('#redo-run');
    expect(await runEnd(page)).toBe('done');
    expect(await trimOf(page)).toEqual({ start: 6, frames: 8, step: 2, side: 320 });
  });

  test('plays the clip without a run, a video by its player and images one by one', async () => {
    const { page } = sample;
    const play = page.locator('#trim-play');
    await open(page, [await redsVideo(page)]);
    await drawn(page);
    await play.click();
    await expect(play).toHaveAttribute('aria-label', 'Stop the clip');
    await page.waitForFunction(() => document.querySelector('#preview video')?.currentTime > 0.15);
    await page.keyboard.press('p');
    await expect(page.locator('#preview')).toBeHidden();
    await expect(play).toHaveAttribute('aria-label', 'Play the clip');

    const images = Array.from({ length: 6 }, (_, k) => plainFrame(64, 32, () => [20 + 30 * k, 90, 90]));
    const clips = [pngFiles(images)];
    if (hasFfmpeg()) clips.push([join(ensureClips(), 'delays.gif')]);
    for (const files of clips) {
      await open(page, files);
      await play.focus();
      await page.keyboard.press('Enter');
      await page.evaluate(() => {
        globalThis.shownFrames = new Set();
        globalThis.reader = new OffscreenCanvas(96, 32).getContext('2d', { willReadFrequently: true });
      });
      await page.waitForFunction(() => {
        const { reader, shownFrames } = globalThis;
        reader.drawImage(document.querySelector('#preview canvas'), 0, 0);
        return shownFrames.add(reader.getImageData(0, 0, 96, 32).data.join()).size >= 4;
      });
      await play.click();
      await expect(page.locator('#preview')).toBeHidden();
    }
    if (!hasFfmpeg()) return;
    await expect(page.locator('#clip-facts')).toHaveText('120 × 90, 16 images');
    const middle = await page.evaluate(async () => {
      const { data } = await globalThis.tracecutStudio.source.preview(9, 480);
      const columns = [];
      for (let p = 0; 4 * p < data.length; p += 1) if (data[4 * p] - data[4 * p + 1] > 60) columns.push(p % 120);
      return columns.reduce((sum, x) => sum + x, 0) / columns.length;
    });
    expect(Math.abs(middle - 62.5), 'the red square in picture 9').toBeLessThan(2);
  });

  test('fits a phone, whose camera records a clip, with handles for fingers', async ({ openStudio }) => {
    const page = await openSample(openStudio, { sample: 'tiny', bypassCSP: true, ...PHONE });
    const [chooser] = await Promise.all([page.waitForEvent('filechooser'), page.tap('#camera-open')]);
    expect(await chooser.element().getAttribute('capture')).toBe('environment');
    expect(await chooser.element().getAttribute('accept')).toBe('video/*');
    await chooser.setFiles(await redsVideo(page));
    await drawn(page);
    expect(await runEnd(page)).toBe('done');
    await expect(page.locator('[data-suggestion="add"]')).toHaveText('Tap the object to add it');
    await page.locator('#trim-box').scrollIntoViewIfNeeded();
    const { x, y, width, height } = await page.locator('#trim-box').boundingBox();
    expect(height).toBeGreaterThanOrEqual(44);
    const session = await page.context().newCDPSession(page);
    const touch = (type, ...shares) =>
      session.send('Input.dispatchTouchEvent', {
        type,
        touchPoints: shares.map((share) => ({ x: x + 10 + share * (width - 20), y: y + 22 })),
      });
    await touch('touchStart', 0);
    for (const share of [0.1, 0.2, 0.3]) await touch('touchMove', share);
    await touch('touchEnd');
    await expect.poll(async () => Number(await page.inputValue('#trim-from'))).toBeGreaterThan(4);
    expect(await page.evaluate(() => document.documentElement.scrollWidth <= innerWidth)).toBe(true);
    expect(await accessibilityFaults(page)).toEqual([]);
  });
});

test('frames of long clips are kept as files, and shown again', async ({ openLibrary }) => {
  const page = await openLibrary();
  const { numPictures, numFiles, reds, isFirstReady } = await page.evaluate(async () => {
    const { FrameStore } = await import('/view/frame-store.js');
    const store = new FrameStore(4);
    for (let t = 0; t < 10; t += 1) {
      const data = new Uint8ClampedArray(4 * 16 * 16).map((_, k) => (k % 4 === 0 ? 20 * t : 255));
      await store.add(new ImageData(data, 16, 16));
    }
    const [numPictures, numFiles] = [store.pictures.size, store.files.size];
    const ready = new Promise((resolve) => (store.onReady = resolve));
    const first = store.get(0, 0);
    await ready;
    const isFirstReady = first === null && store.get(0, 0) !== null;
    const reds = [];
    for (let t = 0; t < 10; t += 1) reds.push((await store.pixels(t, { width: 16, height: 16 })).data[0]);
    return { numPictures, numFiles, reds, isFirstReady };
  });
  expect(numPictures).toBeLessThanOrEqual(5);
  expect(numFiles).toBeGreaterThanOrEqual(6);
  expect(isFirstReady).toBe(true);
  reds.forEach((red, t) => expect(Math.abs(red - 20 * t), `frame ${t}`).toBeLessThan(6));
});

test.describe('clips of cars are segmented whole @long', () => {
  const sample = useSample({ sample: 'tiny' });
  const folder = join(process.env.TRACECUT_SHARED ?? join(root, '..', 'shared'), 'data', 'clips');
  for (const [name, numFrames, numWindows] of [
    ['dashcam-cars-38f', 38, 1],
    ['dashcam-lane-221f', 221, 6],
    ['static-camera-cars-377f', 377, 10],
  ])
    test(name, async () => {
      const path = join(folder, `${name}.mp4`);
      test.skip(!existsSync(path), `needs ${name}.mp4`);
      const { page } = sample;
      await page.setInputFiles('#file', { name, mimeType: 'video/mp4', buffer: readFileSync(path) });
      await waitForPhase(page, 'running');
      await setControl(page, '#clip-side', '320');
      await page.waitForFunction(() => globalThis.tracecutStudio.trim?.side === 320);
      expect(await runEnd(page), await page.locator('#error').innerText()).toBe('done');
      const windows = numWindows > 1 ? ` in ${numWindows} windows` : '';
      await expect(page.locator('#subline')).toHaveText(new RegExp(`${numFrames} frames of 320 × \\d+${windows} ·`));
      await expect(page.locator('#counter')).toHaveText(new RegExp(`/ ${numFrames}$`));
      if (numWindows > 1) return;
      await openSave(page);
      const { bytes } = await saveExport(page, 'background-png');
      expect([bytes.readUInt32BE(16), bytes.readUInt32BE(20)]).toEqual([1280, 720]);
    });
});
