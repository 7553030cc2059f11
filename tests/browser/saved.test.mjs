// Work is not lost: kept by itself, offered after a reload or a killed tab, saved and opened as a project file.

import assert from 'node:assert/strict';
import { describe, test } from 'node:test';
import {
  accessibilityFaults,
  bytesOf,
  ended,
  inPhase,
  openFix,
  openSave,
  plainFrame,
  pngFile,
  screenshot,
  text,
  useSite,
} from './support.mjs';

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
  const site = useSite({ sample: 'tiny' });

  const masks = (page) =>
    page.evaluate(() => {
      const { points } = globalThis.tracecutDemo.app;
      return Array.from({ length: points.result.numFrames }, (_, t) => points.mask(t).join('')).join('|');
    });
  /** Until all is kept, and something was since `then`. */
  const keptAfter = (page, then) =>
    page.waitForFunction(
      (before) => Number(document.body.dataset.kept ?? 0) > before && !('unkept' in document.body.dataset),
      then,
    );

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
    await openFix(page);
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

  /** Chooses edges, a ground, a trail, and that the first object is not kept. */
  async function chooseLook(page) {
    const then = Number(await page.evaluate(() => document.body.dataset.kept));
    for (const [name, value] of Object.entries({ grow: 3, feather: 2, smallest: 0.5, smooth: 1 }))
      await page.fill(`#edge-${name}`, String(value));
    await page.check('[name="view"][value="cutout"]', { force: true });
    await page.selectOption('#ground', 'green');
    await page.selectOption('#trail', { label: 'Short trail' });
    await page.uncheck('[data-object="1"] input');
    await keptAfter(page, then);
  }

  /** What is chosen, as the page shows it. */
  async function chosen(page) {
    const values = await page.$$eval(
      '#edge-grow, #edge-feather, #edge-smallest, #edge-smooth, #ground, #trail',
      (all) => all.map(({ id, value }) => `${id} ${value}`),
    );
    const kept = await page.$$eval('[data-object] input', (all) => all.map(({ checked }) => checked));
    return { values, kept };
  }

  test('is offered again after a killed tab, with corrections, and can be discarded', async () => {
    const { page, faults } = await site.open({ bypassCSP: true });
    await opened(page);
    await addThing(page);
    await chooseLook(page);
    const look = await chosen(page);
    const before = await masks(page);
    const address = page.url();
    const context = page.context();
    // No handler of the page runs: as if its process had been killed.
    await page.close({ runBeforeUnload: false });

    const again = await context.newPage();
    await again.goto(address);
    await again.waitForSelector('#saved:not([hidden])', { timeout: 180_000 });
    assert.match(await text(again, '#saved-text'), /^Your work on .* was kept\.$/);
    await ended(again);
    await screenshot(again, 'saved');
    assert.deepEqual(await accessibilityFaults(again), []);
    await again.click('#saved-open');
    await again.waitForFunction(() => globalThis.tracecutDemo.app.points?.result.numFrames === 12);
    assert.equal(await ended(again), 'done');
    assert.equal(await masks(again), before);
    assert.deepEqual(await chosen(again), look);
    await openFix(again);
    await again.click('#correct-undo');
    await again.waitForFunction(() => document.querySelector('#correct-undo').disabled);
    assert.notEqual(await masks(again), before);
    await again.click('#correct-redo');
    await again.waitForFunction(() => document.querySelector('#correct-redo').disabled);
    assert.equal(await masks(again), before);
    await again.close({ runBeforeUnload: false });

    const third = await context.newPage();
    await third.goto(address);
    await third.click('#saved-forget', { timeout: 180_000 });
    // A reload would come before the storage has forgotten it.
    await third.waitForFunction(() => document.querySelector('#works-open').hidden);
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
    await chooseLook(page);
    const look = await chosen(page);
    assert.deepEqual(look.values.sort(), [
      ...['edge-feather 2', 'edge-grow 3', 'edge-smallest 0.5', 'edge-smooth 1', 'ground green', 'trail 4 2'],
    ]);
    assert.ok(look.kept.length > 1 && !look.kept[0]);
    const before = await masks(page);
    const alpha = (of) => of.evaluate(() => globalThis.tracecutDemo.app.viewer.edgedMask().alpha.join());
    const smooth = (of) => of.waitForFunction(() => document.querySelector('#edge-smooth-text').textContent === '±1');
    await page.evaluate(() => globalThis.tracecutDemo.app.timeline.seek(5));
    await smooth(page);
    const edged = await alpha(page);
    await openSave(page);
    const [download] = await Promise.all([page.waitForEvent('download'), page.click('[data-export="project"]')]);
    assert.match(download.suggestedFilename(), /-project\.tracecut$/);
    const file = { name: 'work.tracecut', mimeType: 'application/zip', buffer: await bytesOf(download) };
    await page.click('#export-close');

    const { page: other } = await site.open({ bypassCSP: true });
    assert.equal(await ended(other), 'done');
    await other.setInputFiles('#file', file);
    await other.waitForFunction(() => globalThis.tracecutDemo.app.points?.result.numFrames === 12);
    assert.equal(await ended(other), 'done');
    assert.equal(await masks(other), before);
    const again = await chosen(other);
    assert.deepEqual({ ...again, values: again.values.sort() }, look);
    await other.evaluate(() => globalThis.tracecutDemo.app.timeline.seek(5));
    await other.waitForFunction(() => !/%/.test(document.querySelector('#edge-smooth-text').textContent));
    await smooth(other);
    await other.waitForFunction(() => globalThis.tracecutDemo.app.viewer.store.state.smoothed);
    assert.equal(await alpha(other), edged);
    await other.setInputFiles('#file', { ...file, buffer: file.buffer.subarray(0, 500) });
    await inPhase(other, 'error');
    assert.match(await text(other, '#error'), /project/i);
    assert.deepEqual(faults, []);
    await other.context().close();
    await page.context().close();
  });

  test('is not replaced by the next clip, nor by a run over corrections: all are in a list, to open and to delete', async () => {
    const { page, faults } = await site.open({ bypassCSP: true });
    const then = async (act) => {
      const before = Number(await page.evaluate(() => document.body.dataset.kept ?? 0));
      await act();
      await keptAfter(page, before);
    };
    const listed = async () => {
      await page.click('#works-open');
      await page.waitForSelector('#works[open]');
      const names = await page.locator('.work-name').allInnerTexts();
      await page.keyboard.press('Escape');
      return names;
    };
    await opened(page);
    await addThing(page);
    const corrected = await masks(page);
    await then(async () => {
      await page.click('#again');
      await page.click('#ask-yes');
    });
    await then(() => page.click('#again'));
    assert.equal((await listed()).length, 2, 'the corrected work, and one for all runs after');
    await then(async () => {
      await page.setInputFiles('#file', [...clip(9, 96, 64)]);
      await inPhase(page, 'running');
    });
    const names = await listed();
    assert.equal(names.length, 3);
    assert.match(names[0], /frame000\.png … frame008\.png\n.* · 9 frames · \d/);
    assert.match(names[2], /12 frames, corrected/);
    await page.click('#works-open');
    await page.waitForSelector('#works[open]');
    assert.deepEqual(await accessibilityFaults(page), []);
    await screenshot(page, 'works');
    await page.click('.work:nth-child(3) [data-open]');
    await page.waitForFunction(() => globalThis.tracecutDemo.app.points?.result.numFrames === 12);
    assert.equal(await ended(page), 'done');
    // What was painted follows the masks.
    for (let tries = 0; tries < 50 && (await masks(page)) !== corrected; tries += 1) await page.waitForTimeout(200);
    assert.ok((await masks(page)) === corrected, 'the corrected masks are back');
    // Kept again under its own name.
    await then(async () => {
      await openFix(page);
      await page.click('#correct-undo');
    });
    await page.click('#correct-done');
    assert.equal((await listed()).length, 3);
    await page.click('#works-open');
    await page.waitForSelector('#works[open]');
    const remove = page.locator('.work:nth-child(1) button').last();
    await remove.focus();
    await page.keyboard.press('Enter');
    assert.equal(await remove.innerText(), 'Delete for good?');
    await page.keyboard.press('Enter');
    await page.waitForFunction(() => document.querySelectorAll('.work').length === 2);
    await page.keyboard.press('Escape');

    const again = await page.context().newPage();
    await again.goto(page.url());
    await again.waitForSelector('#saved-all:not([hidden])', { timeout: 180_000 });
    await again.click('#saved-all');
    await again.waitForSelector('#works[open]');
    assert.equal(await again.locator('.work').count(), 2);
    assert.deepEqual(faults, []);
    await page.context().close();
  });

  test('goes, the oldest first, when there are more than eight', async () => {
    const { page } = await site.open();
    await ended(page);
    const ids = await page.evaluate(async () => {
      const { keep, kept } = await import('/demo/saved/storage.js');
      const about = { name: 'n', take: { start: 0, frames: 2, step: 1, side: 480 }, changed: [] };
      for (let at = 1; at <= 10; at += 1)
        await keep({ id: `w${at}`, name: 'n', at, files: [], project: new Uint8Array(3), edits: null, about });
      return (await kept()).map(({ id }) => id);
    });
    assert.deepEqual(ids, ['w10', 'w9', 'w8', 'w7', 'w6', 'w5', 'w4', 'w3']);
    await page.context().close();
  });
});
