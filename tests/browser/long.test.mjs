// Long clips: a coarse preview before the first masks, then window by window; shown as they come, kept small, corrected,
// saved, and stopped early. And real videos: one that the browser records itself, and clips that lie outside of the project.

import assert from 'node:assert/strict';
import { existsSync, readFileSync } from 'node:fs';
import { join } from 'node:path';
import { describe, test } from 'node:test';
import {
  SMALL,
  bytesOf,
  ended,
  exportAs,
  inPhase,
  onlyLong,
  openFix,
  openSave,
  paintedShare,
  plainFrame,
  pngFile,
  redo,
  run,
  screenshot,
  setControl,
  sharedClips,
  text,
  useSample,
  useSite,
} from './support.mjs';

/** Texture of blocks of 2 or, by a higher power, more pixels. */
function noise(x, y, salt, power = 1) {
  let h = Math.imul((x >> power) + 7, 374761393) ^ Math.imul((y >> power) + 3, 668265263) ^ Math.imul(salt, 2246822519);
  h = Math.imul(h ^ (h >>> 13), 1274126177);
  return 60 + (((h ^ (h >>> 16)) >>> 0) % 160);
}

/** A square that goes to and fro on a textured ground; from frame `cut` on, another ground and another square. */
function shots(count, cut) {
  return Array.from({ length: count }, (_, t) => {
    const salt = t < cut ? 1 : 5;
    const phase = t % 40;
    const left = 10 + 2 * (phase < 20 ? phase : 40 - phase);
    return plainFrame(96, 64, (x, y) => {
      const inside = x >= left && x < left + 28 && y >= 16 && y < 48;
      const value = inside ? noise(x - left, y, salt + 1) : noise(x, y, salt);
      return t < cut ? [value, value, inside ? 255 - value : value] : [inside ? 255 : value / 2, value, value / 3];
    });
  });
}

const files = (frames) => frames.map((frame, k) => pngFile(`frame${String(k).padStart(3, '0')}.png`, frame));

const sample = useSample(useSite({ sample: 'tiny' }));

const WIDTH = 320;
const HEIGHT = 216;
const FRAMES = 55;
const SQUARE = { top: 50, side: 80 };

const leftAt = (t) => 20 + 2 * t;

/** A square that moves over a textured ground: more than the pixels from which on there is a preview. */
const clip = Array.from({ length: FRAMES }, (_, t) => {
  const frame = plainFrame(WIDTH, HEIGHT, (x, y) => {
    const { top, side } = SQUARE;
    const inside = x >= leftAt(t) && x < leftAt(t) + side && y >= top && y < top + side;
    const value = inside ? noise(x - leftAt(t), y, 2, 2) : noise(x, y, 1, 2);
    return [value, value, inside ? 255 - value : value];
  });
  return pngFile(`frame${String(t).padStart(2, '0')}.png`, frame);
});

/** Runs in the page: the clip's frames after the first `count` wait for `goOn`, whoever reads them. */
function holdBack(count) {
  const decode = globalThis.createImageBitmap.bind(globalThis);
  const held = new Promise((resolve) => (globalThis.goOn = resolve));
  globalThis.createImageBitmap = async (source, ...rest) => {
    if (source instanceof File && Number(/\d+/.exec(source.name)) >= count) await held;
    return decode(source, ...rest);
  };
}

const CARS = join(sharedClips, 'dashcam-cars-38f.mp4');
const LANE = join(sharedClips, 'dashcam-lane-221f.mp4');
const without = (file) => (existsSync(file) ? false : `${file} is not here`);

describe('the coarse preview', () => {
  const hasPreview = () => document.body.hasAttribute('data-preview');
  const badge = (page) => page.locator('#preview-mark').isVisible();

  async function begin(count = 20) {
    const { page, faults } = sample;
    await page.evaluate(holdBack, count);
    await page.setInputFiles('#file', clip);
    return { page, faults };
  }

  test('shows what moves in the first frames while the others are still to come, and goes when masks come', async () => {
    const { page, faults } = await begin();
    await page.waitForFunction(hasPreview);
    assert.ok(await badge(page));
    assert.match(await text(page, '#preview-mark'), /^Coarse preview$/);
    assert.match(await page.locator('#live').textContent(), /coarse preview/i);
    assert.equal(await text(page, '#counter'), '1 / 15');
    assert.equal(await page.getAttribute('body', 'data-phase'), 'running');
    const found = await page.evaluate(
      ({ top, side, width, lefts }) => {
        const { viewer, timeline, job, segmentation } = globalThis.tracecutStudio.app;
        return lefts.map((left, t) => {
          timeline.seek(t);
          viewer.draw();
          const { labels } = viewer.edgedMask();
          const shown = job.preview.maskedFrame(t);
          let [both, either] = [0, 0];
          labels.forEach((label, k) => {
            const [x, y] = [(k % width) - lefts[shown], Math.floor(k / width) - top];
            const inside = x >= 0 && x < side && y >= 0 && y < side;
            both += Number(inside && label > 0);
            either += Number(inside || label > 0);
          });
          return { shown, overlap: both / either, labels: new Set(labels).size, settled: segmentation !== null };
        });
      },
      { ...SQUARE, width: WIDTH, lefts: Array.from({ length: 15 }, (_, t) => leftAt(t)) },
    );
    found.forEach(({ shown, overlap, labels, settled }, t) => {
      assert.equal(shown, t - (t % 2), 'picture and mask are of one frame');
      assert.ok(overlap > 0.7, `frame ${t}: ${overlap}`);
      assert.ok(labels === 2 && !settled);
    });
    assert.ok((await page.evaluate(paintedShare)) > 0.5);
    await screenshot(page, 'preview');
    await page.evaluate(() => globalThis.goOn());
    await page.waitForFunction(() => !document.body.hasAttribute('data-preview'));
    assert.ok(
      await page.evaluate(() => globalThis.tracecutStudio.app.segmentation?.mask(0) !== null),
      'masks are there',
    );
    assert.equal(await text(page, '#counter'), `1 / ${FRAMES}`);
    assert.equal(await badge(page), false);
    assert.equal(await ended(page), 'done');
    assert.equal(await page.evaluate(hasPreview), false);
    assert.deepEqual(faults, []);
  });

  test('stays after a cancel, and gives way to another clip', async () => {
    const { page, faults } = await begin();
    await page.waitForFunction(hasPreview);
    await page.keyboard.press('Escape');
    await inPhase(page, 'stopped');
    assert.ok(await badge(page));
    await page.click('#sample');
    assert.equal(await ended(page), 'done');
    assert.equal(await badge(page), false);
    assert.match(await text(page, '#subline'), /^4 frames/);
    await page.evaluate(() => globalThis.goOn());
    assert.deepEqual(faults, []);
  });

  test('that fails is none, and the run goes on', async () => {
    const { page, faults } = await begin(5);
    await page.waitForFunction(() => globalThis.tracecutStudio.app.job?.images.length === 5);
    await page.evaluate(() => globalThis.tracecutStudio.app.job.preview.frames.error(new Error('no frames')));
    await page.waitForFunction(() => globalThis.tracecutStudio.app.job.preview.abort.signal.aborted);
    await page.evaluate(() => globalThis.goOn());
    assert.equal(await ended(page), 'done');
    assert.equal(await page.evaluate(() => globalThis.tracecutStudio.app.job.preview.masks), null);
    assert.deepEqual(faults, []);
  });

  test('is not made where masks come soon', async () => {
    const { page } = sample;
    await page.click('#sample');
    await page.waitForFunction(() => document.querySelector('#subline').textContent.startsWith('4 frames'));
    assert.equal(await page.evaluate(() => globalThis.tracecutStudio.app.job.preview), null);
  });
});

describe('a clip of one window', () => {
  test('is one shot, even where it has a cut', async () => {
    const { page, faults } = sample;
    await page.setInputFiles('#file', files(shots(20, 10)));
    assert.equal(await ended(page), 'done');
    assert.match(await text(page, '#subline'), /^20 frames of 96 × 64 ·/);
    assert.deepEqual(await page.evaluate(() => globalThis.tracecutStudio.app.job.cuts), []);
    assert.deepEqual(faults, []);
  });
});

describe('a clip of more than one window', () => {
  /** Opens images: all of them are taken, and nothing is waited for. */
  async function openAll(page, frames) {
    await page.setInputFiles('#file', files(frames));
  }

  test('is shown as it comes, with its cut, and objects that keep their numbers', async () => {
    const { page, faults } = sample;
    await openAll(page, shots(130, 90));
    await page.waitForFunction(
      () => document.body.hasAttribute('data-streaming') || document.body.dataset.state === 'error',
    );
    const during = await page.evaluate(() => ({
      phase: document.body.dataset.phase,
      lanes: document.querySelectorAll('.lane').length,
      counter: document.querySelector('#counter').textContent,
    }));
    assert.deepEqual({ ...during, lanes: during.lanes > 0 }, { phase: 'running', lanes: true, counter: '1 / 130' });
    assert.equal(await ended(page), 'done', await page.evaluate(() => document.querySelector('#error').innerText));
    assert.match(await text(page, '#subline'), /^130 frames of 96 × 64 in [34] windows and 2 shots/);
    assert.match(await text(page, '#facts'), /windows of 50 frames/);
    const { cuts, biggest } = await page.evaluate(() => {
      const { segmentation, job } = globalThis.tracecutStudio.app;
      const middle = Array.from({ length: 130 }, (_, t) => {
        const phase = t % 40;
        const left = 10 + 2 * (phase < 20 ? phase : 40 - phase);
        return segmentation.mask(t)[32 * segmentation.result.width + left + 14];
      });
      return { cuts: job.cuts, biggest: middle };
    });
    assert.deepEqual(cuts, [90]);
    const first = new Set(biggest.slice(3, 87));
    const second = new Set(biggest.slice(93, 127));
    assert.equal(first.size, 1, `the square of the first shot is ${[...first]}`);
    assert.equal(second.size, 1, `that of the second ${[...second]}`);
    assert.ok(!first.has(0) && !second.has(0) && [...first][0] !== [...second][0]);
    assert.equal(await page.locator('.cut').count(), 1);
    await screenshot(page, 'long');
    assert.deepEqual(faults, []);
  });

  test('keeps most frames as files, and shows each of them', async () => {
    const { page } = sample;
    const { pictures, kept } = await page.evaluate(() => {
      const { images } = globalThis.tracecutStudio.app.job;
      return { pictures: images.pictures.size, kept: images.files.size };
    });
    assert.ok(pictures <= 65 && kept >= 65, `${pictures} pictures, ${kept} files`);
    for (const t of [0, 40, 70, 129]) {
      await page.evaluate((frame) => globalThis.tracecutStudio.app.timeline.seek(frame), t);
      await page.waitForFunction((frame) => globalThis.tracecutStudio.app.job.images.get(frame) !== null, t);
    }
  });

  test('is saved with all its frames, and merged objects', async () => {
    const { page } = sample;
    const save = async (id) => {
      const coming = page.waitForEvent('download');
      await exportAs(page, id);
      return bytesOf(await coming);
    };
    await openFix(page);
    const labels = await page
      .locator('#correct-object option')
      .evaluateAll((options) => options.map(({ value }) => Number(value)).filter(Boolean));
    await page.selectOption('#correct-object', String(labels[1]));
    await page.selectOption('#correct-into', String(labels[0]));
    assert.equal(await page.locator('#correct-split').isDisabled(), true);
    await page.click('#correct-merge');
    await page.waitForFunction(() => /^Corrected/.test(document.querySelector('#correct-status').textContent));
    await page.click('#correct-done');
    await openSave(page);
    const coco = JSON.parse(await save('coco'));
    assert.equal(coco.images.length, 130);
    assert.ok(coco.annotations.length > 100 && coco.annotations.every(({ track_id }) => track_id !== labels[1]));
    assert.match(String(await save('tracks')), /^130\n\d+\n/);
    assert.ok((await save('overlay-webm')).length > 5000);
    await page.click('#export-close');
  });

  test('stopped early, its windows are kept and saved, and it continues to the same result', async () => {
    const { page, faults } = sample;
    const frames = shots(130, 200);
    const masks = () =>
      page.evaluate(() => {
        const { result } = globalThis.tracecutStudio.app.segmentation;
        return Array.from({ length: result.numFrames }, (_, t) => String(result.labels(t)));
      });
    await openAll(page, frames);
    assert.equal(await ended(page), 'done');
    const whole = await masks();
    await redo(page);
    await page.waitForFunction(() => globalThis.tracecutStudio.app.job?.settledFrames > 40);
    await page.keyboard.press('Escape');
    await inPhase(page, 'done');
    assert.match(await text(page, '#notice'), /^Stopped early: \d+ of 130 frames/);
    const part = await masks();
    assert.ok(part.length >= 40 && part.length < 130, `${part.length} frames`);
    assert.deepEqual(part, whole.slice(0, part.length));
    assert.match(await text(page, '#counter'), new RegExp(`/ ${part.length}$`));
    assert.equal(await page.locator('#correct-open').isVisible(), false, 'what is not whole cannot be corrected');
    await screenshot(page, 'long-stopped');
    await openSave(page);
    const ids = await page
      .locator('[data-export]:enabled')
      .evaluateAll((buttons) => buttons.map((button) => button.dataset.export));
    assert.ok(ids.length >= 9, ids);
    for (const id of ids) {
      const coming = page.waitForEvent('download');
      await exportAs(page, id);
      await page.waitForFunction(() => !/^Saving/.test(document.querySelector('#export-status').textContent));
      const said = await text(page, '#export-status');
      assert.match(said, /^Saved/, `${id}: ${said}`);
      const bytes = await bytesOf(await coming);
      if (id === 'coco') assert.equal(JSON.parse(bytes).images.length, part.length);
      if (id === 'tracks') assert.match(String(bytes), new RegExp(`^${part.length}\n[1-9]`));
    }
    await page.click('#export-close');
    await page.click('#resume');
    await inPhase(page, 'running');
    assert.match(await text(page, '#counter'), /\/ 130$/);
    assert.equal(await ended(page), 'done');
    assert.deepEqual(await masks(), whole);
    assert.equal(await page.locator('#correct-open').isVisible(), true);
    assert.equal(await page.locator('#resume').isVisible(), false);
    assert.deepEqual(faults, []);
  });
});

describe('video files', () => {
  const sample = useSample(useSite());

  test('a recording whose length is not written in the file', async () => {
    const { page, faults } = sample;
    const bytes = await page.evaluate(recordSample);
    const file = { name: 'recording.webm', mimeType: 'video/webm', buffer: Buffer.from(bytes) };
    assert.equal(
      await run(page, [file]),
      'done',
      await page.evaluate(() => document.querySelector('#error').innerText),
    );
    assert.match(await text(page, '#subline'), new RegExp(`frames of ${SMALL.width} × ${SMALL.height}`));
    assert.deepEqual(faults, []);
  });

  test('a clip of many frames shows masks after its first window', { skip: without(LANE) }, async () => {
    const { page, faults } = sample;
    await page.setInputFiles('#file', [LANE]);
    await page.waitForFunction(
      () => document.body.hasAttribute('data-streaming') || document.body.dataset.state === 'error',
    );
    const { settled, read, shown, phase } = await page.evaluate(() => {
      const { job, segmentation } = globalThis.tracecutStudio.app;
      const shown = segmentation.mask(20).some((label) => label > 0);
      return { settled: job.settledFrames, read: job.images.length, shown, phase: document.body.dataset.phase };
    });
    assert.equal(phase, 'running');
    assert.ok(settled >= 40 && settled <= 50, `${settled} frames are settled`);
    assert.ok(read < 120, `${read} frames were read before anything was shown`);
    assert.ok(shown, 'no mask in frame 20');
    assert.deepEqual(faults, []);
  });

  test('start, length, step and size are as chosen', { skip: without(LANE) }, async () => {
    const { page } = sample;
    await page.setInputFiles('#file', [LANE]);
    await inPhase(page, 'running');
    assert.deepEqual(await page.evaluate(() => globalThis.tracecutStudio.trim), {
      start: 0,
      frames: 221,
      step: 1,
      side: 480,
    });
    assert.equal(await page.isHidden('#clip-all'), true, 'the whole clip is taken already');
    // Under way; it begins anew with what is chosen now.
    for (const [id, value] of Object.entries({ frames: '8', step: '2', side: '320', start: '100' }))
      await setControl(page, `#clip-${id}`, value);
    await screenshot(page, 'running');
    await inPhase(page, 'done');
    assert.match(await text(page, '#subline'), /8 frames of 320 × 180/);
    const trim = await page.evaluate(() => globalThis.tracecutStudio.trim);
    assert.deepEqual(trim, { start: 100, frames: 8, step: 2, side: 320 });
  });
});

describe('clips dropped on the page, whole', onlyLong, () => {
  const sample = useSample(useSite());

  for (const [name, frames, windows] of [
    ['dashcam-cars-38f', 38, 1],
    ['dashcam-lane-221f', 221, 6],
    ['static-camera-cars-377f', 377, 10],
  ]) {
    const file = join(sharedClips, `${name}.mp4`);
    test(`${name}: all ${frames} frames`, { skip: without(file) }, async () => {
      const { page, faults } = sample;
      const dropped = await page.evaluateHandle(transferOf, {
        name: `${name}.mp4`,
        base64: readFileSync(file, 'base64'),
      });
      for (const type of ['dragenter', 'dragover', 'drop'])
        await page.dispatchEvent('body', type, { dataTransfer: dropped });
      await inPhase(page, 'running');
      await setControl(page, '#clip-side', '320');
      await page.waitForFunction(() => globalThis.tracecutStudio.trim?.side === 320);
      assert.equal(await ended(page), 'done', await page.evaluate(() => document.querySelector('#error').innerText));
      assert.match(
        await text(page, '#subline'),
        new RegExp(`${frames} frames of 320 × \\d+${windows > 1 ? ` in ${windows} windows` : ''} ·`),
      );
      assert.match(await text(page, '#counter'), new RegExp(`/ ${frames}$`));
      await page.evaluate((frame) => globalThis.tracecutStudio.app.timeline.seek(frame), frames - 1);
      await screenshot(page, name);
      assert.deepEqual(faults, []);
    });
  }
});

/** Runs in the page: what a drag of one file carries. */
function transferOf({ name, base64 }) {
  const transfer = new DataTransfer();
  const bytes = Uint8Array.from(atob(base64), (character) => character.charCodeAt(0));
  transfer.items.add(new File([bytes], name, { type: 'video/mp4' }));
  return transfer;
}

/** Runs in the page: records frames of the sample, and gives the file's bytes. */
async function recordSample() {
  const { source } = globalThis.tracecutStudio;
  const canvas = document.createElement('canvas');
  Object.assign(canvas, { width: source.width, height: source.height });
  const ctx = canvas.getContext('2d');
  const recorder = new MediaRecorder(canvas.captureStream(15), { mimeType: 'video/webm;codecs=vp8' });
  const parts = [];
  recorder.ondataavailable = (event) => parts.push(event.data);
  const stopped = new Promise((resolve) => (recorder.onstop = resolve));
  recorder.start();
  for (let t = 0; t < source.count; t += 1) {
    ctx.putImageData(await source.preview(t, source.width), 0, 0);
    await new Promise((resolve) => setTimeout(resolve, 70));
  }
  recorder.stop();
  await stopped;
  return [...new Uint8Array(await new Blob(parts).arrayBuffer())];
}
