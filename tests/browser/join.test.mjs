// One thing that was found as several objects: chosen and joined in one step, by mouse and by keyboard; or proposed.

import assert from 'node:assert/strict';
import { describe, test } from 'node:test';
import { WIDE, fiveObjects } from './five.mjs';
import { accessibilityFaults, openFix, openSample, screenshot, text, useSite } from './support.mjs';

describe('joining', () => {
  const site = useSite({ sample: 'tiny' });
  const labels = (page) =>
    page.evaluate(() => [...new Set(globalThis.tracecutStudio.app.points.mask(0))].sort((a, b) => a - b).join());
  const until = (page, wanted) =>
    page.waitForFunction(
      (all) => [...document.querySelectorAll('.object')].map((row) => row.dataset.object).join() === all,
      wanted,
    );

  async function opened(shape, options) {
    const { page, faults } = await openSample(site, { bypassCSP: true, ...options });
    await page.setInputFiles('#file', [(await fiveObjects(page, shape)).project]);
    await page.waitForFunction(
      () => globalThis.tracecutStudio.source?.name === 'five.webm' && document.body.dataset.state === 'done',
    );
    await until(page, '0,1,2,3,4,5');
    return { page, faults };
  }

  /** Where an object is in the picture of the first frame, in CSS pixels of the canvas. */
  const placeOf = (page, object) =>
    page.evaluate((label) => {
      const { points, viewer } = globalThis.tracecutStudio.app;
      const { width, unit } = viewer.view;
      const own = [...points.mask(0).keys()].filter((p) => points.mask(0)[p] === label);
      const p = own[own.length >> 1];
      return { x: ((p % width) + 0.5) / unit, y: (Math.floor(p / width) + 0.5) / unit };
    }, object);

  test('several are chosen in the list and in the picture, and joined in one step of undo', async () => {
    const { page, faults } = await opened(WIDE);
    await page.click('[data-object="2"] .object-main', { modifiers: ['Shift'] });
    await page.waitForSelector('#join', { state: 'visible' });
    assert.equal(await page.locator('#join-do').isDisabled(), true);
    assert.equal(await page.locator('#show-all').isVisible(), false, 'it is not shown alone');
    await page.click('[data-object="4"] .object-main', { modifiers: ['Control'] });
    await page.click('#canvas', { modifiers: ['Shift'], position: await placeOf(page, 5) });
    assert.equal(await text(page, '#join-words'), 'Object 2\nObject 4\nObject 5\n3 objects chosen');
    assert.equal(await page.locator('.is-meant').count(), 3);
    await screenshot(page, 'join');
    assert.deepEqual(await accessibilityFaults(page), []);
    await page.click('#join-do');
    await until(page, '0,1,2,3');
    assert.equal(await labels(page), '0,1,2,3');
    assert.equal(await text(page, '#join-words'), '3 objects joined.');
    await page.click('#join-undo');
    await until(page, '0,1,2,3,4,5');
    await page.keyboard.press('Control+y');
    await until(page, '0,1,2,3');
    await page.keyboard.press('Control+z');
    await until(page, '0,1,2,3,4,5');
    assert.deepEqual(faults, []);
    await page.context().close();
  });

  test('by keyboard alone, also while fixing; the list of keys says so', async () => {
    const { page, faults } = await opened(WIDE);
    await openFix(page);
    for (const object of [3, 1]) {
      await page.focus(`[data-object="${object}"] .object-main`);
      await page.keyboard.press('Shift+Enter');
    }
    await page.click('#canvas', { modifiers: ['Shift'], position: await placeOf(page, 5) });
    await page.focus('#join-do');
    await page.keyboard.press('Enter');
    await until(page, '0,2,3,4');
    assert.equal(await page.evaluate(() => document.activeElement.id), 'join-undo');
    await page.click('#correct-undo');
    await until(page, '0,1,2,3,4,5');
    await page.keyboard.press('?');
    await page.waitForSelector('#help[open]');
    assert.match(await text(page, '#help-keys'), /Shift Enter\s+on an object of the list: choose it with others/);
    assert.deepEqual(faults, []);
    await page.context().close();
  });

  test('those that touch and move alike are proposed, until they are refused', async () => {
    const phone = { viewport: { width: 390, height: 844 }, isMobile: true, hasTouch: true };
    const { page, faults } = await opened({ ...WIDE, parts: 3 }, phone);
    await page.waitForSelector('#join', { state: 'visible' });
    assert.match(await text(page, '#join-words'), /These 3 look like one: join\?$/);
    assert.deepEqual(await accessibilityFaults(page), []);
    await page.locator('#join').scrollIntoViewIfNeeded();
    await screenshot(page, 'join-proposed');
    await page.click('#join-do');
    await until(page, '0,1,4,5');
    await page.click('#join-undo');
    await until(page, '0,1,2,3,4,5');
    await page.waitForFunction(() => /join\?/.test(document.querySelector('#join-words').textContent));
    await page.click('#join-no');
    await page.waitForSelector('#join', { state: 'hidden' });
    // A change of the result does not bring it back.
    await openFix(page);
    await page.selectOption('#correct-object', '5');
    await page.click('#correct-background');
    await until(page, '0,1,2,3,4');
    await page.waitForTimeout(500);
    assert.equal(await page.locator('#join').isVisible(), false);
    assert.deepEqual(faults, []);
    await page.context().close();
  });
});
