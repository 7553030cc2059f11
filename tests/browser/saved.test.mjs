// Work is not lost: kept by itself, offered after a reload or a killed tab, saved and opened as a project file.

import assert from 'node:assert/strict';
import { readFile } from 'node:fs/promises';
import { describe, test } from 'node:test';
import { accessibilityFaults, ended, inPhase, plainFrame, pngFile, screenshot, text, useSite } from './support.mjs';

/** A textured square that moves over a textured ground. */
function clip(count, width, height) {
  const noise = (x, y, salt) => {
    const h = Math.imul((x >> 1) + 7, 374761393) ^ Math.imul((y >> 1) + 3, 668265263) ^ Math.imul(salt, 2246822519);
    const mixed = Math.imul(h ^ (h >>> 13), 1274126177);
    return 60 + (((mixed ^ (mixed >>> 16)) >>> 0) % 160);
  };
  return Array.from({ length: count }, (_, t) => {
    const inside = (x, y) => x >= 10 + 2 * t && x < 38 + 2 * t && y >= 16 && y < 48;
    const frame = plainFrame(width, height, (x, y) => {
      const value = inside(x, y) ? noise(x - 2 * t, y, 2) : noise(x, y, 1);
      return [value, value, inside(x, y) ? 255 - value : value];
    });
    return pngFile(`frame${String(t).padStart(3, '0')}.png`, frame);
  });
}

describe('work', () => {
  const site = useSite();

  const masks = (page) =>
    page.evaluate(() => {
      const { points } = globalThis.tracecutDemo.app;
      return Array.from({ length: points.result.numFrames }, (_, t) => points.mask(t).join('')).join('|');
    });
  const keptAfter = (page, then) =>
    page.waitForFunction((before) => Number(document.body.dataset.kept ?? 0) > before, then);

  async function opened(page) {
    assert.equal(await ended(page), 'done');
    await page.setInputFiles('#file', clip(12, 96, 64));
    await inPhase(page, 'running');
    assert.equal(await ended(page), 'done');
    await keptAfter(page, 0);
  }

  /** Adds the ground at a place of the clip to a new object. */
  async function addThing(page) {
    const then = Number(await page.evaluate(() => document.body.dataset.kept));
    await page.click('#correct-open');
    await page.check('#correct-tools [value="paint"]', { force: true });
    await page.selectOption('#correct-object', '-1');
    await page.evaluate(() => new Promise((done) => requestAnimationFrame(() => setTimeout(done, 100))));
    const box = await page.locator('#canvas').boundingBox();
    await page.mouse.move(box.x + 0.8 * box.width, box.y + 0.1 * box.height);
    await page.mouse.down();
    await page.mouse.move(box.x + 0.9 * box.width, box.y + 0.1 * box.height, { steps: 4 });
    await page.mouse.up();
    await page.waitForFunction(() => /^In .*[.]/.test(document.querySelector('#correct-status').textContent));
    await keptAfter(page, then);
  }

  test('is offered again after a killed tab, with corrections, and can be discarded', async () => {
    const { page, faults } = await site.open({ bypassCSP: true });
    await opened(page);
    await addThing(page);
    const before = await masks(page);
    const address = page.url();
    const context = page.context();
    // No handler of the page runs: as if its process had been killed.
    await page.close({ runBeforeUnload: false });

    const again = await context.newPage();
    await again.goto(address);
    await again.waitForSelector('#saved:not([hidden])', { timeout: 60_000 });
    assert.match(await text(again, '#saved-text'), /^Your work on .* was kept\.$/);
    await ended(again);
    await screenshot(again, 'saved');
    assert.deepEqual(await accessibilityFaults(again), []);
    await again.click('#saved-open');
    await again.waitForFunction(() => globalThis.tracecutDemo.app.points?.result.numFrames === 12);
    assert.equal(await ended(again), 'done');
    assert.equal(await masks(again), before);
    await again.click('#correct-open');
    await again.click('#correct-undo');
    await again.waitForFunction(() => document.querySelector('#correct-undo').disabled);
    assert.notEqual(await masks(again), before);
    await again.click('#correct-redo');
    await again.waitForFunction(() => document.querySelector('#correct-redo').disabled);
    assert.equal(await masks(again), before);
    await again.close({ runBeforeUnload: false });

    const third = await context.newPage();
    await third.goto(address);
    await third.click('#saved-forget', { timeout: 60_000 });
    await ended(third);
    await third.reload();
    assert.equal(await ended(third), 'done');
    assert.equal(await third.locator('#saved').isVisible(), false);
    assert.deepEqual(faults, []);
    await context.close();
  });

  test('is saved as a file that holds the clip too, and opened from it', async () => {
    const { page, faults } = await site.open({ bypassCSP: true });
    await opened(page);
    await addThing(page);
    const before = await masks(page);
    await page.click('#export-open');
    const [download] = await Promise.all([page.waitForEvent('download'), page.click('[data-export="project"]')]);
    assert.match(download.suggestedFilename(), /-project\.tracecut$/);
    const file = { name: 'work.tracecut', mimeType: 'application/zip', buffer: await readFile(await download.path()) };
    await page.click('#export-close');

    const { page: other } = await site.open({ bypassCSP: true });
    assert.equal(await ended(other), 'done');
    await other.setInputFiles('#file', file);
    await other.waitForFunction(() => globalThis.tracecutDemo.app.points?.result.numFrames === 12);
    assert.equal(await ended(other), 'done');
    assert.equal(await masks(other), before);
    await other.setInputFiles('#file', { ...file, buffer: file.buffer.subarray(0, 500) });
    await inPhase(other, 'error');
    assert.match(await text(other, '#error'), /project/i);
    assert.deepEqual(faults, []);
    await other.context().close();
    await page.context().close();
  });
});
