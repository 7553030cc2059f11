// Real video: one that the browser records itself, and clips that lie outside of the project.

import assert from 'node:assert/strict';
import { existsSync, readFileSync } from 'node:fs';
import { join } from 'node:path';
import { describe, test } from 'node:test';
import { ended, inPhase, onlyLong, run, screenshot, sharedClips, SMALL, text, useSample, useSite } from './support.mjs';

const CARS = join(sharedClips, 'dashcam-cars-38f.mp4');
const LANE = join(sharedClips, 'dashcam-lane-221f.mp4');
const without = (file) => (existsSync(file) ? false : `${file} is not here`);

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
      const { job, points } = globalThis.tracecutStudio.app;
      const shown = points.mask(20).some((label) => label > 0);
      return { settled: job.settled, read: job.images.length, shown, phase: document.body.dataset.phase };
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
    assert.deepEqual(await page.evaluate(() => globalThis.tracecutStudio.take), {
      start: 0,
      frames: 221,
      step: 1,
      side: 480,
    });
    assert.equal(await page.locator('#take-all').isVisible(), false, 'the whole clip is taken already');
    // Under way; it begins anew with what is chosen now.
    await page.fill('#take-frames', '8');
    await page.selectOption('#take-step', '2');
    await page.selectOption('#take-side', '320');
    await page.locator('#take-start').fill('100');
    await screenshot(page, 'running');
    await inPhase(page, 'done');
    assert.match(await text(page, '#subline'), /8 frames of 320 × 180/);
    const take = await page.evaluate(() => globalThis.tracecutStudio.take);
    assert.deepEqual(take, { start: 100, frames: 8, step: 2, side: 320 });
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
      await page.selectOption('#take-side', '320');
      await page.waitForFunction(() => globalThis.tracecutStudio.take?.side === 320);
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
