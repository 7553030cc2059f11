// Running again keeps what was corrected and chosen, as far as it applies to the new result, and is one step of undo.

import assert from 'node:assert/strict';
import { describe, test } from 'node:test';
import { ended, inPhase, movingClip, openFix, useSite } from './support.mjs';

describe('running again', () => {
  const site = useSite({ sample: 'tiny' });
  const clip = movingClip(16, [96, 64]);

  /** For each frame how many pixels each label has, and where the middle of them is. */
  const objects = (page) =>
    page.evaluate(() => {
      const { points } = globalThis.tracecutStudio.app;
      const { width, numFrames } = points.result;
      return Array.from({ length: numFrames }, (_, t) => {
        const found = {};
        points.mask(t).forEach((label, p) => {
          const one = (found[label] ??= { n: 0, x: 0, y: 0 });
          one.n += 1;
          one.x += p % width;
          one.y += Math.floor(p / width);
        });
        for (const one of Object.values(found)) Object.assign(one, { x: one.x / one.n, y: one.y / one.n });
        return found;
      });
    });
  const masks = (page) =>
    page.evaluate(() => {
      const { points } = globalThis.tracecutStudio.app;
      return Array.from({ length: points.result.numFrames }, (_, t) => points.mask(t).join('')).join('|');
    });
  const labels = async (page) => Object.keys((await objects(page))[4]).join();

  async function opened(files = clip) {
    const { page, faults } = await site.open({ bypassCSP: true });
    assert.equal(await ended(page), 'done');
    await page.setInputFiles('#file', files);
    await inPhase(page, 'running');
    assert.equal(await ended(page), 'done');
    return { page, faults };
  }

  /** Paints a line in a frame, from and to parts of the picture; waits until it is done. */
  async function paint(page, { tool, frame, from, to, object, carries = true }) {
    await openFix(page);
    await page.check(`#correct-tools [value="${tool}"]`, { force: true });
    if (object) await page.selectOption('#correct-object', object);
    await page.setChecked('#brush-carry', carries);
    await page.evaluate((t) => globalThis.tracecutStudio.app.timeline.seek(t), frame);
    await page.evaluate(() => {
      document.querySelector('#correct-status').textContent = '';
      return new Promise((done) => requestAnimationFrame(() => setTimeout(done, 100)));
    });
    const box = await page.locator('#canvas').boundingBox();
    const at = ([x, y]) => [box.x + x * box.width, box.y + y * box.height];
    await page.mouse.move(...at(from));
    await page.mouse.down();
    await page.mouse.move(...at(to), { steps: 4 });
    await page.mouse.up();
    await page.waitForFunction(() => /^In .*[.]$/.test(document.querySelector('#correct-status').textContent));
    await page.click('#correct-done');
  }

  /** Runs again, whether that is asked or not. */
  async function again(page) {
    await page.click('#again');
    if (await page.locator('#ask[open]').isVisible()) await page.click('#ask-yes');
    await inPhase(page, 'running');
    assert.equal(await ended(page), 'done');
  }

  const disc = { tool: 'paint', object: '-1', frame: 4, from: [0.75, 0.2], to: [0.83, 0.24] };

  test('keeps what was painted, joined and left out, in the same objects; undo is one step', async () => {
    const { page, faults } = await opened();
    assert.equal(await labels(page), '0,1');
    await paint(page, disc);
    await paint(page, { ...disc, from: [0.1, 0.1], to: [0.2, 0.1] });
    assert.equal(await labels(page), '0,1,2,3');
    // Two of them are one thing.
    for (const object of [3, 2]) await page.click(`[data-object="${object}"] .object-main`, { modifiers: ['Shift'] });
    await page.click('#join-do');
    await page.waitForFunction(() => document.querySelectorAll('.object').length === 3);
    const joined = await labels(page);
    await page.uncheck('[data-object="1"] input');
    const before = await masks(page);
    await again(page);
    assert.equal(await masks(page), before);
    assert.equal(await labels(page), joined);
    assert.equal(await page.isChecked('[data-object="1"] input'), false);
    assert.equal(await page.locator('#notice').isVisible(), false);
    // What comes after can be undone by itself; then the run is.
    await paint(page, { tool: 'erase', object: '1', frame: 4, from: [0.3, 0.5], to: [0.3, 0.7] });
    assert.notEqual(await masks(page), before);
    await page.keyboard.press('Control+z');
    await page.waitForFunction(() => /^Undone/.test(document.querySelector('#correct-status').textContent));
    assert.equal(await masks(page), before);
    assert.equal(await page.locator('#restore').isVisible(), true);
    await page.keyboard.press('Control+z');
    await page.waitForFunction(() => document.querySelector('#restore').hidden);
    assert.equal(await ended(page), 'done');
    assert.equal(await masks(page), before);
    assert.equal(await page.isChecked('[data-object="1"] input'), false);
    await openFix(page);
    await page.click('#correct-undo');
    await page.waitForFunction(() => document.querySelectorAll('.object').length === 4);
    assert.deepEqual(faults, []);
    await page.context().close();
  });
});
