// Corrections by the user on the page: with the mouse and by keyboard, taken back, and refused in words.

import assert from 'node:assert/strict';
import { beforeEach, describe, test } from 'node:test';
import { accessibilityFaults, openFix, openSample, screenshot, SMALL, text, useSite } from './support.mjs';

const FRAME = 12;

describe('a result is corrected', () => {
  const site = useSite();
  let page;
  let faults;
  let before;

  /** All masks of the result on screen, as one text. */
  const masks = () =>
    page.evaluate(
      (frames) =>
        Array.from({ length: frames }, (_, t) => [...globalThis.tracecutStudio.app.points.mask(t)].join('')).join('|'),
      SMALL.frames,
    );
  const counts = () =>
    page.evaluate((t) => {
      const found = {};
      for (const label of globalThis.tracecutStudio.app.points.mask(t)) found[label] = (found[label] ?? 0) + 1;
      return found;
    }, FRAME);
  const status = () =>
    page
      .waitForFunction(() =>
        /^(Corrected|Undone|That is not)/.test(document.querySelector('#correct-status').textContent),
      )
      .then(() => text(page, '#correct-status'));

  /** The picture gives way to what is above it; waits until it has. */
  const settled = () =>
    page.evaluate(
      () => new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(() => setTimeout(done, 50)))),
    );
  const unit = () => page.evaluate(() => globalThis.tracecutStudio.app.viewer.view.unit);

  /** Waits for what `act` sets off. */
  async function corrected(act) {
    await page.evaluate(() => (document.querySelector('#correct-status').textContent = ''));
    await act();
    return status();
  }

  /** Runs in the page: a place in the middle of an object, in CSS pixels of the canvas. */
  const placeOf = (object) =>
    page.evaluate((label) => {
      const { points, viewer, timeline } = globalThis.tracecutStudio.app;
      const { width, unit } = viewer.view;
      const own = [];
      points
        .mask(timeline.frame)
        .forEach((found, p) => found === label && own.push([p % width, Math.floor(p / width)]));
      const mean = [0, 1].map((axis) => own.reduce((sum, place) => sum + place[axis], 0) / own.length);
      const distance = ([x, y]) => Math.hypot(x - mean[0], y - mean[1]);
      const [x, y] = own.reduce((best, place) => (distance(place) < distance(best) ? place : best));
      return { x: (x + 0.5) / unit, y: (y + 0.5) / unit };
    }, object);

  beforeEach(async () => {
    if (page) return;
    ({ page, faults } = await openSample(site, { bypassCSP: true }));
    before = await masks();
    await page.evaluate((frame) => globalThis.tracecutStudio.app.timeline.seek(frame), FRAME);
    await openFix(page);
    await settled();
  });

  test('a click on an object chooses it, with its facts', async () => {
    await page.click('#canvas', { position: await placeOf(2) });
    assert.equal(await page.inputValue('#correct-object'), '2');
    assert.match(await text(page, '#correct-facts'), /%$/);
    assert.equal(await page.locator('#show-all').isVisible(), false, 'and does not show it alone');
    await screenshot(page, 'correct');
    assert.deepEqual(await accessibilityFaults(page), []);
  });

  test('objects are merged, in place, and the merge is taken back', async () => {
    const found = await counts();
    await page.click('#canvas', { position: await placeOf(2) });
    await page.selectOption('#correct-into', '1');
    const words = await corrected(() => page.click('#correct-merge'));
    console.log(`a merge on the page: ${words}`);
    assert.match(words, /^Corrected in \d+\.\d\ss\. 2 moving objects and the background\.$/);
    const merged = await counts();
    assert.deepEqual(merged, { 0: found[0], 1: found[1] + found[2], 3: found[3] });
    assert.equal(await page.evaluate(() => globalThis.tracecutStudio.app.timeline.frame), FRAME, 'the frame stays');
    assert.equal(await text(page, '#headline'), '2 moving objects and the background');
    assert.equal(await page.locator('.lane').count(), 2);
    await corrected(() => page.keyboard.press('Control+z'));
    assert.equal(await masks(), before);
    assert.equal(await page.locator('#correct-undo').isDisabled(), true);
  });

  test('an object is made background by keyboard alone, and brought back', async () => {
    const found = await counts();
    await page.focus('#correct-object');
    await page.keyboard.press('Home');
    await page.keyboard.press('ArrowDown');
    await page.keyboard.press('ArrowDown');
    await page.keyboard.press('ArrowDown');
    assert.equal(await page.inputValue('#correct-object'), '3');
    await page.focus('#correct-background');
    await corrected(() => page.keyboard.press('Enter'));
    assert.deepEqual(await counts(), { 0: found[0] + found[3], 1: found[1], 2: found[2] });
    await page.focus('#correct-undo');
    await corrected(() => page.keyboard.press('Enter'));
    assert.equal(await masks(), before);
  });

  test('an object is split, and a merged one falls apart into what it was', async () => {
    await page.selectOption('#correct-object', '2');
    await page.selectOption('#correct-into', '1');
    await corrected(() => page.click('#correct-merge'));
    await page.selectOption('#correct-object', '1');
    assert.match(await corrected(() => page.click('#correct-split')), /^Corrected/);
    assert.equal(await page.locator('.lane').count(), 3);
    await corrected(() => page.click('#correct-undo'));
    await corrected(() => page.click('#correct-undo'));
    assert.equal(await masks(), before);
  });

  test('where nothing can be split, the page says so, and goes on', async () => {
    await page.selectOption('#correct-object', '0');
    assert.equal(await page.locator('#correct-split').isDisabled(), true, 'the background needs a place');
    const sky = await page.evaluate(() => {
      const { points, viewer, timeline } = globalThis.tracecutStudio.app;
      return points.mask(timeline.frame)[viewer.view.width * 3 + 3];
    });
    assert.equal(sky, 0);
    await page.click('#canvas', { position: { x: 5, y: 5 } });
    const words = await corrected(() => page.click('#correct-split'));
    if (/^Corrected/.test(words)) await corrected(() => page.click('#correct-undo'));
    else assert.match(words, /^That is not possible here: .{20}/);
    assert.equal(await masks(), before);
    assert.deepEqual(faults, []);
  });

  /** Paints from one place of the canvas to another, in CSS pixels. */
  async function paint(from, to) {
    const box = await page.locator('#canvas').boundingBox();
    await page.mouse.move(box.x + from.x, box.y + from.y);
    await page.mouse.down();
    await page.mouse.move(box.x + (from.x + to.x) / 2, box.y + (from.y + to.y) / 2, { steps: 4 });
    await page.mouse.move(box.x + to.x, box.y + to.y, { steps: 4 });
    await page.mouse.up();
  }

  test('strokes over two objects make them one; two strokes part them again', async () => {
    await page.check('#correct-tools [value="together"]', { force: true });
    assert.equal(await page.locator('#strokes-apply').isDisabled(), true);
    await settled();
    let [first, second] = [await placeOf(2), await placeOf(3)];
    const then = await unit();
    await paint(first, { x: first.x + 3, y: first.y });
    await paint(second, { x: second.x + 3, y: second.y });
    assert.equal(await text(page, '#strokes-count'), '2 painted');
    await page.evaluate(() => globalThis.tracecutStudio.app.viewer.draw());
    await screenshot(page, 'strokes');
    const words = await corrected(() => page.click('#strokes-apply'));
    console.log(`strokes on the page: ${words}`);
    assert.match(words, /^Corrected in .* 2 moving objects/);
    assert.equal((await counts())[3], undefined);
    assert.equal(await text(page, '#strokes-count'), '0 painted');
    await page.check('#correct-tools [value="apart"]', { force: true });
    await settled();
    const zoom = then / (await unit());
    [first, second] = [first, second].map(({ x, y }) => ({ x: x * zoom, y: y * zoom }));
    await paint(first, { x: first.x + 3, y: first.y });
    assert.equal(await page.locator('#strokes-apply').isDisabled(), true, 'one stroke parts nothing');
    await paint(second, { x: second.x + 3, y: second.y });
    assert.match(await corrected(() => page.click('#strokes-apply')), /^Corrected in .* 3 moving objects/);
    const labels = await page.evaluate(
      (places) => {
        const { points, viewer, timeline } = globalThis.tracecutStudio.app;
        return places.map(({ x, y }) => points.mask(timeline.frame)[Math.floor(y) * viewer.view.width + Math.floor(x)]);
      },
      [first, second].map(({ x, y }) => ({ x: x * (then / zoom), y: y * (then / zoom) })),
    );
    assert.ok(labels[0] > 0 && labels[1] > 0 && labels[0] !== labels[1], `labels ${labels} under the strokes`);
    await page.check('#correct-tools [value="pick"]', { force: true });
    await corrected(() => page.click('#correct-undo'));
    await corrected(() => page.click('#correct-undo'));
    assert.equal(await masks(), before);
    assert.deepEqual(faults, []);
  });
});
