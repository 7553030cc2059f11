// Masks changed by hand on the page: brush, eraser, things added by a click; in clips of one window and of many.

import assert from 'node:assert/strict';
import { describe, test } from 'node:test';
import { accessibilityFaults, openFix, openSample, screenshot, text, useSite } from './support.mjs';

/** What the tests do with the page. */
function hands(page) {
  const frame = () => page.evaluate(() => globalThis.tracecutStudio.app.timeline.frame);
  const masks = () =>
    page.evaluate(() => {
      const { points } = globalThis.tracecutStudio.app;
      return Array.from({ length: points.result.numFrames }, (_, t) => points.mask(t).join('')).join('|');
    });
  /** The label at a place of the clip, in frame t. */
  const labelAt = (t, x, y) =>
    page.evaluate(
      ([at, u, v]) => {
        const { points } = globalThis.tracecutStudio.app;
        return points.mask(at)[v * points.result.width + u];
      },
      [t, x, y],
    );
  /** From pixels of the clip to the window's. */
  const place = async (x, y) => {
    const box = await page.locator('#canvas').boundingBox();
    const unit = await page.evaluate(() => globalThis.tracecutStudio.app.viewer.view.unit);
    return [box.x + (x + 0.5) / unit, box.y + (y + 0.5) / unit];
  };
  const use = async (tool) => {
    await page.check(`#correct-tools [value="${tool}"]`, { force: true });
    // The picture gives way to the tool's row.
    await page.evaluate(() => new Promise((done) => requestAnimationFrame(() => setTimeout(done, 100))));
    await page.evaluate(() => (document.querySelector('#correct-status').textContent = ''));
  };
  const said = async () => {
    await page.waitForFunction(() =>
      /^(In .*[.]|Corrected|Undone|Done again|That is not)/.test(document.querySelector('#correct-status').textContent),
    );
    return text(page, '#correct-status');
  };
  const paint = async (...line) => {
    await page.mouse.move(...(await place(line[0], line[1])));
    await page.mouse.down();
    await page.mouse.move(...(await place(line[2], line[3])), { steps: 6 });
    await page.mouse.up();
    return said();
  };
  const click = async (x, y) => {
    await page.mouse.click(...(await place(x, y)));
    return said();
  };
  const press = async (button) => {
    await page.evaluate(() => (document.querySelector('#correct-status').textContent = ''));
    await page.click(button);
    return said();
  };
  return { frame, masks, labelAt, place, use, paint, click, press };
}

describe('masks changed by hand', () => {
  const site = useSite();

  test('brush, eraser and a click change all frames, are undone and done again', async () => {
    const { page, faults } = await openSample(site, { bypassCSP: true });
    const { masks, labelAt, use, paint, click, press } = hands(page);
    const before = await masks();
    await page.evaluate(() => globalThis.tracecutStudio.app.timeline.seek(12));
    await openFix(page);

    await use('paint');
    await page.selectOption('#correct-object', '2');
    assert.match(await paint(14, 21, 28, 24), /^In \d+ frames/);
    assert.equal(await labelAt(12, 21, 22), 2);
    const painted = await masks();
    await screenshot(page, 'brush');
    assert.deepEqual(await accessibilityFaults(page), []);

    await use('erase');
    assert.equal(await page.inputValue('#correct-object'), '2');
    await page.uncheck('#brush-carry');
    assert.equal(await paint(14, 21, 28, 24), 'In frame 13.');
    assert.equal(await labelAt(12, 21, 22), 0);
    await page.check('#brush-carry');

    await use('add');
    assert.equal(await page.inputValue('#correct-object'), '-1');
    await click(175, 14);
    assert.equal(await labelAt(12, 175, 14), 4);
    assert.equal(await text(page, '#headline'), '4 moving objects and the background');
    const all = await masks();

    for (const _ of [0, 1]) await press('#correct-undo');
    assert.equal(await masks(), painted);
    await page.keyboard.press('Control+z');
    await page.waitForFunction(() => document.querySelector('#correct-undo').disabled);
    assert.equal(await masks(), before);
    for (const _ of [0, 1, 2]) await press('#correct-redo');
    assert.equal(await masks(), all);
    assert.equal(await page.locator('#correct-redo').isDisabled(), true);
    assert.deepEqual(faults, []);
    await page.context().close();
  });

  test('what was missed is added whole by a click, made larger or smaller, and taken away with Alt', async () => {
    const { page, faults } = await openSample(site, { bypassCSP: true });
    const { masks, labelAt, place, use, click, press } = hands(page);
    const whole = await masks();
    await page.evaluate(() => globalThis.tracecutStudio.app.timeline.seek(12));
    await openFix(page);
    /** The middle of the largest object, and how much of its pixels and of any the label there has. */
    const thing = await page.evaluate(() => {
      const { points } = globalThis.tracecutStudio.app;
      const mask = Array.from(points.mask(12));
      const areas = Map.groupBy(mask.keys(), (p) => mask[p]);
      areas.delete(0);
      const [label, pixels] = [...areas].sort((a, b) => b[1].length - a[1].length)[0];
      const { width } = points.result;
      const mean = (of) => Math.round(pixels.reduce((sum, p) => sum + of(p), 0) / pixels.length);
      return { label, pixels, x: mean((p) => p % width), y: mean((p) => Math.floor(p / width)) };
    });
    const added = async () => {
      const { own, both } = await page.evaluate(({ x, y, pixels }) => {
        const { points } = globalThis.tracecutStudio.app;
        const mask = points.mask(12);
        const label = mask[y * points.result.width + x];
        const all = mask.reduce((sum, one) => sum + Number(label > 0 && one === label), 0);
        return { own: all, both: pixels.filter((p) => label > 0 && mask[p] === label).length };
      }, thing);
      return { own, overlap: both / (own + thing.pixels.length - both) };
    };
    await page.selectOption('#correct-object', String(thing.label));
    await press('#correct-background');
    assert.equal(await labelAt(12, thing.x, thing.y), 0);
    const missed = await masks();

    await use('add');
    const start = performance.now();
    assert.match(await click(thing.x, thing.y), /^In \d+ frames/);
    const first = await added();
    assert.ok(
      first.overlap > 0.6,
      `overlap ${first.overlap.toFixed(2)} after ${Math.round(performance.now() - start)} ms`,
    );
    const label = await labelAt(12, thing.x, thing.y);
    const sizes = [first.own];
    for (const [button, sign] of [
      ['#add-larger', 1],
      ['#add-smaller', -1],
    ]) {
      if (await page.locator(button).isDisabled()) continue;
      assert.match(await press(button), /^In \d+ frames?|^In frame/);
      const { own } = await added();
      assert.ok(sign * (own - sizes.at(-1)) > 0, `${button}: ${sizes.at(-1)} to ${own} pixels`);
      assert.equal(await labelAt(12, thing.x, thing.y), label, 'it is the same object');
      sizes.push(own);
    }
    assert.ok(sizes.length > 1, 'there are sizes to choose from');

    const [u, v] = await place(thing.x, thing.y);
    await page.evaluate(() => (document.querySelector('#correct-status').textContent = ''));
    await page.keyboard.down('Alt');
    await page.mouse.click(u, v);
    await page.keyboard.up('Alt');
    await page.waitForFunction(() => /^In /.test(document.querySelector('#correct-status').textContent));
    assert.equal(await labelAt(12, thing.x, thing.y), 0);
    for (const _ of [0, 1]) await press('#correct-undo');
    assert.equal(await masks(), missed, 'a change of size is no step of its own');
    await press('#correct-undo');
    assert.equal(await masks(), whole);
    assert.deepEqual(faults, []);
    await page.context().close();
  });
});
