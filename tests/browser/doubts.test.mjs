// The places to check on the page: marks on the timeline, a key and a button that show the next, and one that accepts it.

import assert from 'node:assert/strict';
import { test } from 'node:test';
import { WIDE, fiveObjects } from './five-objects.mjs';
import { accessibilityFaults, openSample, screenshot, text, useSite } from './support.mjs';

const site = useSite({ sample: 'tiny' });

test('places to check are marked, shown one after the other, and gone when they are fine', async () => {
  const { page, faults } = await openSample(site, { bypassCSP: true });
  const doubts = [
    { from: 1, to: 4 },
    { from: 6, to: 8 },
  ];
  await page.setInputFiles('#file', [(await fiveObjects(page, { ...WIDE, doubts })).project]);
  await page.waitForFunction(
    () => globalThis.tracecutStudio.source?.name === 'five.webm' && document.body.dataset.state === 'done',
  );
  const frame = () => page.evaluate(() => globalThis.tracecutStudio.app.timeline.frame);
  assert.equal(await text(page, '#doubt-next'), '2 places to check');
  const marks = await page
    .locator('.doubt')
    .evaluateAll((all) => all.map((mark) => mark.getBoundingClientRect().width));
  assert.ok(marks.length === 2 && marks[0] > 1.5 * marks[1] && marks[1] > 10, `${marks}`);
  assert.equal(await page.locator('#doubt-fine').isVisible(), false);
  await page.keyboard.press('n');
  assert.equal(await frame(), 2);
  await screenshot(page, 'doubts');
  assert.deepEqual(await accessibilityFaults(page), []);
  await page.click('#doubt-next');
  assert.equal(await frame(), 6);
  await page.click('#doubt-fine');
  assert.equal(await text(page, '#doubt-next'), '1 place to check');
  assert.equal(await frame(), 2, 'the one that is left');
  await page.click('#doubt-fine');
  assert.equal(await page.locator('#doubts').isVisible(), false);
  assert.deepEqual(faults, []);
});
