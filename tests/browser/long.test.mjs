// Long clips: taken window by window, shown as they come, kept small, corrected, saved, and stopped early.

import assert from 'node:assert/strict';
import { describe, test } from 'node:test';
import {
  bytesOf,
  ended,
  inPhase,
  openFix,
  openSave,
  plainFrame,
  pngFile,
  screenshot,
  text,
  useSample,
  useSite,
} from './support.mjs';

const WIDTH = 96;
const HEIGHT = 64;

function noise(x, y, salt) {
  let h = Math.imul((x >> 1) + 7, 374761393) ^ Math.imul((y >> 1) + 3, 668265263) ^ Math.imul(salt, 2246822519);
  h = Math.imul(h ^ (h >>> 13), 1274126177);
  return 60 + (((h ^ (h >>> 16)) >>> 0) % 160);
}

/** A square that goes to and fro on a textured ground; from frame `cut` on, another ground and another square. */
function shots(count, cut) {
  return Array.from({ length: count }, (_, t) => {
    const salt = t < cut ? 1 : 5;
    const phase = t % 40;
    const left = 10 + 2 * (phase < 20 ? phase : 40 - phase);
    return plainFrame(WIDTH, HEIGHT, (x, y) => {
      const inside = x >= left && x < left + 28 && y >= 16 && y < 48;
      const value = inside ? noise(x - left, y, salt + 1) : noise(x, y, salt);
      return t < cut ? [value, value, inside ? 255 - value : value] : [inside ? 255 : value / 2, value, value / 3];
    });
  });
}

const files = (frames) => frames.map((frame, k) => pngFile(`frame${String(k).padStart(3, '0')}.png`, frame));

describe('a clip of one window', () => {
  const sample = useSample(useSite({ sample: 'tiny' }));

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
  const sample = useSample(useSite({ sample: 'tiny' }));

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
      const { points, job } = globalThis.tracecutStudio.app;
      const middle = Array.from({ length: 130 }, (_, t) => {
        const phase = t % 40;
        const left = 10 + 2 * (phase < 20 ? phase : 40 - phase);
        return points.mask(t)[32 * points.result.width + left + 14];
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
      await page.click(`[data-export="${id}"]`);
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

  test('stopped early, what is done is kept and saved, and goes on to what it would have been', async () => {
    const { page, faults } = sample;
    const frames = shots(130, 200);
    const masks = () =>
      page.evaluate(() => {
        const { result } = globalThis.tracecutStudio.app.points;
        return Array.from({ length: result.numFrames }, (_, t) => String(result.labels(t)));
      });
    await openAll(page, frames);
    assert.equal(await ended(page), 'done');
    const whole = await masks();
    await page.click('#again');
    await page.waitForFunction(() => globalThis.tracecutStudio.app.job?.settled > 40);
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
      await page.click(`[data-export="${id}"]`);
      await page.waitForFunction(() => !/^Making/.test(document.querySelector('#export-status').textContent));
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
