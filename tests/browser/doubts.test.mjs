// The places to check on the page: marks on the timeline, a key and a button that show the next, and one that accepts it.

import assert from 'node:assert/strict';
import { test } from 'node:test';
import { WIDE, fiveObjects } from './five-objects.mjs';
import { accessibilityFaults, openSample, screenshot, text, useSite } from './support.mjs';

const site = useSite({ sample: 'tiny' });

/** Opens a project with places to check. */
async function openDoubts(...doubts) {
  const { page, faults } = await openSample(site, { bypassCSP: true });
  await page.setInputFiles('#file', [(await fiveObjects(page, { ...WIDE, doubts })).project]);
  await page.waitForFunction(
    () => globalThis.tracecutStudio.source?.name === 'five.webm' && document.body.dataset.state === 'done',
  );
  await page.waitForSelector('#doubts', { state: 'visible' });
  return { page, faults };
}

test('places to check are marked, shown one after the other, and gone when they are fine', async () => {
  const { page, faults } = await openDoubts({ from: 1, to: 4 }, { from: 6, to: 8 });
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
  await page.context().close();
});

test('a place takes the masks of its neighbours, in one step of undo; a strip shows how sure the masks are', async () => {
  const { page, faults } = await openDoubts({ from: 2, to: 4 }, { from: 6, to: 8 });
  const mask = (t) => page.evaluate((at) => globalThis.tracecutStudio.app.segmentation.mask(at).join(''), t);
  const before = await mask(2);
  const scrub = page.locator('#scrub');
  const width = (await scrub.boundingBox()).width;
  // The library's work is not this test's: a frame gets the mask of the first one.
  await page.evaluate(() => {
    const { job } = globalThis.tracecutStudio.app;
    const { corrections } = job;
    job.agreement = Float32Array.of(1, 0.9, 0.3, NaN, 0.8, 1, 1, 1);
    const editor = corrections.openEditor;
    editor.interpolate = async ({ from }, { signal, onFrame }) => {
      onFrame({ t: from });
      await new Promise((resolve, reject) => {
        globalThis.finishRepair = resolve;
        signal.addEventListener('abort', () => reject(signal.reason));
      });
      return editor.paint({ label: 3, stroke: { t: from, points: [9, 9], radius: 4 } });
    };
  });
  assert.equal(await page.locator('#certainty').isVisible(), false);
  await page.keyboard.press('n');
  assert.equal((await scrub.boundingBox()).width, width, 'the scrubber keeps its width');
  await page.click('#doubt-neighbours');
  assert.equal(await text(page, '#doubt-status'), '1 frame…');
  await page.click('#doubt-stop');
  await page.waitForSelector('#doubt-neighbours', { state: 'visible' });
  assert.equal(await text(page, '#doubt-next'), '2 places to check', 'a stopped repair changes nothing');
  await page.focus('#doubt-neighbours');
  await page.keyboard.press('Enter');
  await page.waitForSelector('#doubt-stop', { state: 'visible' });
  assert.equal(await page.evaluate(() => document.activeElement.id), 'doubt-stop');
  await page.evaluate(() => globalThis.finishRepair());
  await page.waitForSelector('#doubt-actions', { state: 'hidden' });
  assert.equal(await text(page, '#doubt-next'), '1 place to check');
  assert.equal(await page.evaluate(() => document.activeElement.id), 'doubt-next');
  assert.notEqual(await mask(2), before);

  const strip = page.getByRole('img', { name: 'How sure the masks are: least in frame 3, 30%' });
  assert.equal(await strip.isVisible(), true);
  const heights = await strip.evaluate((canvas) => {
    const { width: columns, height: rows } = canvas;
    const { data } = canvas.getContext('2d').getImageData(0, 0, columns, rows);
    const opaque = (x) =>
      Array.from({ length: rows }, (_, y) => data[4 * (y * columns + x) + 3]).filter(Boolean).length;
    return [0, 2, 3, 6].map((t) => opaque(Math.min(columns - 1, Math.round((t / 7) * columns))) / rows);
  });
  assert.ok(
    heights[0] === 1 && heights[1] < 0.5 && heights[1] > 0 && heights[2] === 0 && heights[3] === 1,
    `${heights}`,
  );
  await page.keyboard.press('n');
  assert.equal(await page.locator('#doubt-neighbours').isDisabled(), true);
  assert.equal(await page.locator('#doubt-neighbours').getAttribute('title'), 'There is no frame after these.');
  assert.equal(await page.locator('#doubt-redo').isDisabled(), false);
  await screenshot(page, 'doubt-actions');
  assert.deepEqual(await accessibilityFaults(page), []);
  await page.keyboard.press('Control+z');
  await page.waitForFunction((old) => globalThis.tracecutStudio.app.segmentation.mask(2).join('') === old, before);
  assert.deepEqual(faults, []);
});
