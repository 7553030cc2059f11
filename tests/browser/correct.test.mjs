// Results are corrected on the page, with the mouse and by keyboard: objects are joined, split and made background, painted,
// wiped away and added; all of it is taken back, and refused in words.

import assert from 'node:assert/strict';
import { before, beforeEach, describe, test } from 'node:test';
import { WIDE, fiveObjects } from './five-objects.mjs';
import { SMALL, accessibilityFaults, ended, openFix, openSample, redo, screenshot, text, useSite } from './support.mjs';

const FRAME = 12;

/** What the tests do with the page. */
function hands(page) {
  const frame = () => page.evaluate(() => globalThis.tracecutStudio.app.timeline.frame);
  const masks = () =>
    page.evaluate(() => {
      const { segmentation } = globalThis.tracecutStudio.app;
      return Array.from({ length: segmentation.result.numFrames }, (_, t) => segmentation.mask(t).join('')).join('|');
    });
  /** The label at a place of the clip, in frame t. */
  const labelAt = (t, x, y) =>
    page.evaluate(
      ([at, u, v]) => {
        const { segmentation } = globalThis.tracecutStudio.app;
        return segmentation.mask(at)[v * segmentation.result.width + u];
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
      /^(Applied to .*[.]|Corrected|Undone|Redone|Not possible)/.test(
        document.querySelector('#correct-status').textContent,
      ),
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
  return { frame, masks, labelAt, place, use, said, paint, click, press };
}

describe('a result is corrected', () => {
  const site = useSite();
  let page;
  let faults;
  let original;

  /** All masks of the result on screen, as one text. */
  const masks = () =>
    page.evaluate(
      (frames) =>
        Array.from({ length: frames }, (_, t) => [...globalThis.tracecutStudio.app.segmentation.mask(t)].join('')).join(
          '|',
        ),
      SMALL.frames,
    );
  const counts = () =>
    page.evaluate((t) => {
      const found = {};
      for (const label of globalThis.tracecutStudio.app.segmentation.mask(t)) found[label] = (found[label] ?? 0) + 1;
      return found;
    }, FRAME);
  const status = () =>
    page
      .waitForFunction(() =>
        /^(Corrected|Undone|Not possible)/.test(document.querySelector('#correct-status').textContent),
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
      const { segmentation, viewer, timeline } = globalThis.tracecutStudio.app;
      const { width, unit } = viewer.view;
      const own = [];
      segmentation
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
    original = await masks();
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
    assert.match(words, /^Corrected in \d+\.\d\ss\. 2 moving objects\.$/);
    const merged = await counts();
    assert.deepEqual(merged, { 0: found[0], 1: found[1] + found[2], 3: found[3] });
    assert.equal(await page.evaluate(() => globalThis.tracecutStudio.app.timeline.frame), FRAME, 'the frame stays');
    assert.equal(await text(page, '#headline'), '2 moving objects');
    assert.equal(await page.locator('.lane').count(), 2);
    await corrected(() => page.keyboard.press('Control+z'));
    assert.equal(await masks(), original);
    assert.equal(await page.locator('#correct-undo').isDisabled(), true);
  });

  test('an object is turned into background by keyboard only, and restored', async () => {
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
    assert.equal(await masks(), original);
  });

  test('an object is split, and a merged one splits into its parts', async () => {
    await page.selectOption('#correct-object', '2');
    await page.selectOption('#correct-into', '1');
    await corrected(() => page.click('#correct-merge'));
    await page.selectOption('#correct-object', '1');
    assert.match(await corrected(() => page.click('#correct-split')), /^Corrected/);
    assert.equal(await page.locator('.lane').count(), 3);
    await corrected(() => page.click('#correct-undo'));
    await corrected(() => page.click('#correct-undo'));
    assert.equal(await masks(), original);
  });

  test('if nothing can be split, the page says so and stays usable', async () => {
    await page.selectOption('#correct-object', '0');
    assert.equal(await page.locator('#correct-split').isDisabled(), true, 'the background needs a place');
    const sky = await page.evaluate(() => {
      const { segmentation, viewer, timeline } = globalThis.tracecutStudio.app;
      return segmentation.mask(timeline.frame)[viewer.view.width * 3 + 3];
    });
    assert.equal(sky, 0);
    await page.click('#canvas', { position: { x: 5, y: 5 } });
    const words = await corrected(() => page.click('#correct-split'));
    if (/^Corrected/.test(words)) await corrected(() => page.click('#correct-undo'));
    else assert.match(words, /^Not possible here: .{20}/);
    assert.equal(await masks(), original);
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
    assert.equal(await text(page, '#strokes-count'), '2 strokes');
    await page.evaluate(() => globalThis.tracecutStudio.app.viewer.draw());
    await screenshot(page, 'strokes');
    const words = await corrected(() => page.click('#strokes-apply'));
    console.log(`strokes on the page: ${words}`);
    assert.match(words, /^Corrected in .* 2 moving objects/);
    assert.equal((await counts())[3], undefined);
    assert.equal(await text(page, '#strokes-count'), '0 strokes');
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
        const { segmentation, viewer, timeline } = globalThis.tracecutStudio.app;
        return places.map(
          ({ x, y }) => segmentation.mask(timeline.frame)[Math.floor(y) * viewer.view.width + Math.floor(x)],
        );
      },
      [first, second].map(({ x, y }) => ({ x: x * (then / zoom), y: y * (then / zoom) })),
    );
    assert.ok(labels[0] > 0 && labels[1] > 0 && labels[0] !== labels[1], `labels ${labels} under the strokes`);
    await page.check('#correct-tools [value="pick"]', { force: true });
    await corrected(() => page.click('#correct-undo'));
    await corrected(() => page.click('#correct-undo'));
    assert.equal(await masks(), original);
    assert.deepEqual(faults, []);
  });

  test('brush, eraser and a click change all frames, are undone and done again', async () => {
    const { masks, labelAt, use, paint, click, press } = hands(page);
    const before = await masks();

    await use('paint');
    await page.selectOption('#correct-object', '2');
    assert.match(await paint(14, 21, 28, 24), /^Applied to frame/);
    assert.equal(await labelAt(12, 21, 22), 2);
    const painted = await masks();
    await screenshot(page, 'brush');
    assert.deepEqual(await accessibilityFaults(page), []);

    await use('erase');
    assert.equal(await page.inputValue('#correct-object'), '2');
    await page.uncheck('#brush-carry');
    assert.equal(await paint(14, 21, 28, 24), 'Applied to frame 13.');
    assert.equal(await labelAt(12, 21, 22), 0);
    await page.check('#brush-carry');

    await use('add');
    assert.equal(await page.inputValue('#correct-object'), '-1');
    await click(175, 14);
    assert.equal(await labelAt(12, 175, 14), 4);
    assert.equal(await text(page, '#headline'), '4 moving objects');
    const all = await masks();

    for (const _ of [0, 1]) await press('#correct-undo');
    assert.equal(await masks(), painted);
    await page.keyboard.press('Control+z');
    await page.waitForFunction(() => document.querySelector('#correct-undo').disabled);
    assert.equal(await masks(), before);
    for (const _ of [0, 1, 2]) await press('#correct-redo');
    assert.equal(await masks(), all);
    assert.equal(await page.locator('#correct-redo').isDisabled(), true);
    for (const _ of [0, 1, 2]) await press('#correct-undo');
    assert.equal(await masks(), before);
  });

  test('the frames of a fix are shown on the timeline, and its ends are moved, in one step of undo', async () => {
    const { masks, labelAt, use, paint, press, said } = hands(page);
    const before = await masks();
    const range = () => page.locator('.fix-handle').evaluateAll((all) => all.map(({ value }) => Number(value)));
    assert.equal(await page.locator('#fix-range').isVisible(), false);
    await use('paint');
    await page.selectOption('#correct-object', '2');
    // The plain background there looks like that around it: nothing speaks for the paint in other frames.
    assert.match(
      await paint(14, 21, 28, 24),
      /^Applied to frame 13 only: .* drag the ends of the range to add some[.]$/,
    );
    const extend = async (name, key) => {
      await page.getByRole('slider', { name }).focus();
      for (let k = 0; k < 3; k += 1) {
        await page.evaluate(() => (document.querySelector('#correct-status').textContent = ''));
        await page.keyboard.press(key);
        await said();
      }
    };
    await extend('First frame of the fix', 'ArrowLeft');
    await extend('Last frame of the fix', 'ArrowRight');
    const [first, last] = await range();
    assert.deepEqual([first, last], [FRAME - 3, FRAME + 3]);
    assert.equal(await labelAt(last, 21, 22), 2);
    await page.evaluate(() => (document.querySelector('#correct-status').textContent = ''));
    await page.keyboard.press('ArrowLeft');
    assert.equal(await said(), `Applied to frames ${first + 1}–${last}.`);
    assert.equal(await labelAt(last, 21, 22), 0);
    assert.deepEqual(await accessibilityFaults(page), []);
    await page.evaluate(() => (document.querySelector('#correct-status').textContent = ''));
    await page.keyboard.press('ArrowRight');
    assert.equal(await said(), `Applied to frames ${first + 1}–${last + 1}.`);
    assert.equal(await labelAt(last, 21, 22), 2);

    // The pointer drags the other end beyond the painted frame: it stops there.
    const scrub = await page.locator('#scrub').boundingBox();
    const box = await page.locator('#fix-range').boundingBox();
    const x = (t) => scrub.x + (t / (SMALL.frames - 1)) * (scrub.width - 14);
    await page.evaluate(() => (document.querySelector('#correct-status').textContent = ''));
    await page.mouse.move(x(first), box.y + box.height / 2);
    await page.mouse.down();
    await page.mouse.move(x(first + 4), box.y + box.height / 2);
    await page.mouse.move(x(SMALL.frames - 1), box.y + box.height / 2);
    await screenshot(page, 'fix-range');
    await page.mouse.up();
    assert.equal(await said(), `Applied to frames ${FRAME + 1}–${last + 1}.`);
    assert.deepEqual(await range(), [FRAME, last]);
    await press('#correct-undo');
    assert.equal(await masks(), before);
    assert.equal(await page.locator('#fix-range').isVisible(), false);
  });

  /** The middle of the largest object, and its pixels, in frame 12. */
  const largestObject = (page) =>
    page.evaluate(() => {
      const { segmentation } = globalThis.tracecutStudio.app;
      const mask = Array.from(segmentation.mask(12));
      const areas = Map.groupBy(mask.keys(), (p) => mask[p]);
      areas.delete(0);
      const [label, pixels] = [...areas].sort((a, b) => b[1].length - a[1].length)[0];
      const { width } = segmentation.result;
      const mean = (of) => Math.round(pixels.reduce((sum, p) => sum + of(p), 0) / pixels.length);
      return { label, pixels, x: mean((p) => p % width), y: mean((p) => Math.floor(p / width)) };
    });
  const areaOf = (page, label) =>
    page.evaluate(
      (of) => globalThis.tracecutStudio.app.segmentation.mask(12).filter((one) => one === of).length,
      label,
    );

  test('the region that a click would take is outlined; the wheel sizes it, Alt removes it', async () => {
    const { masks, labelAt, place, use, press } = hands(page);
    const whole = await masks();
    const thing = await largestObject(page);
    const size = () => text(page, '#add-size');
    /** Waits until another region is outlined than `before`, or any. */
    const outlined = async (before = '') => {
      const differs = (old) => {
        const now = document.querySelector('#add-size').textContent.trim();
        return now !== '' && now !== old;
      };
      await page.waitForFunction(differs, before);
      return size();
    };
    const clickHere = async () => {
      await page.evaluate(() => (document.querySelector('#correct-status').textContent = ''));
      await page.mouse.down();
      await page.mouse.up();
      await page.waitForFunction(() =>
        /^Applied to .*[.]$/.test(document.querySelector('#correct-status').textContent),
      );
    };
    await use('pick');
    await page.selectOption('#correct-object', String(thing.label));
    await press('#correct-background');
    const missed = await masks();

    await use('add');
    const [u, v] = await place(thing.x, thing.y);
    await page.mouse.move(u, v);
    const first = await outlined();
    assert.match(first, /^Size [1-3] of [23], [\d.]+% of the frame\.$/);
    const [at, count] = first.match(/\d+/g).map(Number);
    await page.mouse.wheel(0, at < count ? -120 : 120);
    const second = await outlined(first);
    await page.keyboard.press(at < count ? '-' : '+');
    assert.equal(await outlined(second), first);
    assert.equal(await text(page, '#zoom-fit'), '100%');
    await screenshot(page, 'add-outline');
    assert.equal(await page.locator('#add-larger').isVisible(), false, 'the size is chosen before the click');
    await clickHere();
    const label = await labelAt(12, thing.x, thing.y);
    assert.ok(label > 0);
    const share = (await areaOf(page, label)) / (SMALL.width * SMALL.height);
    assert.ok(Math.abs(100 * share - Number(first.match(/([\d.]+)%/)[1])) < 0.6, `${first} and ${share}`);

    await page.mouse.move(u + 1, v);
    await page.keyboard.down('Alt');
    await page.waitForFunction(() => document.querySelector('#add-size').textContent !== '');
    await clickHere();
    await page.keyboard.up('Alt');
    assert.equal(await labelAt(12, thing.x, thing.y), 0);
    for (const _ of [0, 1]) await press('#correct-undo');
    assert.equal(await masks(), missed);

    // The crosshair outlines the same, in words too.
    await page.focus('#correct-tools [value="add"]');
    await page.keyboard.press('Tab');
    await page.evaluate(() => document.querySelector('#canvas').focus());
    await page.keyboard.press('ArrowLeft');
    await page.waitForFunction(() => /^Size \d/.test(document.querySelector('#live').textContent));
    await use('pick');
    await press('#correct-undo');
    assert.equal(await masks(), whole);
    // The wheel zooms again.
    await page.mouse.move(u, v);
    await page.mouse.wheel(0, -120);
    await page.waitForFunction(() => document.querySelector('#zoom-fit').textContent !== '100%');
    assert.deepEqual(faults, []);
    await page.context().close();
  });

  test('on touch screens a tap adds, and its size is chosen afterwards', async () => {
    const phone = { viewport: { width: 390, height: 844 }, hasTouch: true, isMobile: true };
    const touched = await openSample(site, phone);
    const { place, use, labelAt, press, said } = hands(touched.page);
    await touched.page.evaluate((frame) => globalThis.tracecutStudio.app.timeline.seek(frame), FRAME);
    await openFix(touched.page);
    const thing = await largestObject(touched.page);
    await touched.page.selectOption('#correct-object', String(thing.label));
    await press('#correct-background');
    await use('add');
    await touched.page.touchscreen.tap(...(await place(thing.x, thing.y)));
    assert.match(await said(), /^Applied to frames? /);
    const label = await labelAt(12, thing.x, thing.y);
    const before = await areaOf(touched.page, label);
    const isLarger = await touched.page.locator('#add-larger').isEnabled();
    assert.match(await press(isLarger ? '#add-larger' : '#add-smaller'), /^Applied to frame/);
    const change = (await areaOf(touched.page, label)) - before;
    assert.ok(isLarger ? change > 0 : change < 0, `${change} pixels`);
    assert.equal(await labelAt(12, thing.x, thing.y), label, 'it is the same object');
    assert.deepEqual(touched.faults, []);
    await touched.page.context().close();
  });
});

describe('five objects are joined and corrected', () => {
  const site = useSite({ sample: 'tiny' });
  const labels = (page) =>
    page.evaluate(() => [...new Set(globalThis.tracecutStudio.app.segmentation.mask(0))].sort((a, b) => a - b).join());
  const until = (page, wanted) =>
    page.waitForFunction(
      (all) => [...document.querySelectorAll('.object')].map((row) => row.dataset.object).join() === all,
      wanted,
    );

  let page, faults;
  before(async () => ({ page, faults } = await openSample(site, { bypassCSP: true })));

  /** Opens the project anew: five objects, or some of them parts of one thing. */
  async function open(shape = WIDE) {
    await page.setInputFiles('#file', [(await fiveObjects(page, shape)).project]);
    await page.waitForFunction(
      () => globalThis.tracecutStudio.source?.name === 'five.webm' && document.body.dataset.state === 'done',
    );
    await until(page, '0,1,2,3,4,5');
  }

  /** Where an object is in the picture of the first frame, in CSS pixels of the canvas. */
  const placeOf = (page, object) =>
    page.evaluate((label) => {
      const { segmentation, viewer } = globalThis.tracecutStudio.app;
      const { width, unit } = viewer.view;
      const own = [...segmentation.mask(0).keys()].filter((p) => segmentation.mask(0)[p] === label);
      const p = own[own.length >> 1];
      return { x: ((p % width) + 0.5) / unit, y: (Math.floor(p / width) + 0.5) / unit };
    }, object);

  test('several are chosen in the list and in the picture, and joined in one step of undo', async () => {
    await open();
    await page.click('[data-object="2"] .object-main', { modifiers: ['Shift'] });
    await page.waitForSelector('#join', { state: 'visible' });
    assert.equal(await page.locator('#join-apply').isDisabled(), true);
    assert.equal(await page.getByRole('button', { name: /^Object 2 \(light blue\), selected [\d.]+%/ }).count(), 1);
    assert.equal(await page.locator('#show-all').isVisible(), false, 'it is not shown alone');
    await page.click('[data-object="4"] .object-main', { modifiers: ['Control'] });
    await page.click('#canvas', { modifiers: ['Shift'], position: await placeOf(page, 5) });
    assert.equal(await text(page, '#join-message'), 'Object 2\nObject 4\nObject 5\n3 objects selected');
    assert.equal(await page.locator('.is-candidate').count(), 3);
    await screenshot(page, 'join');
    assert.deepEqual(await accessibilityFaults(page), []);
    await page.click('#join-apply');
    await until(page, '0,1,2,3');
    assert.equal(await labels(page), '0,1,2,3');
    assert.equal(await text(page, '#join-message'), '3 objects joined.');
    await page.click('#join-undo');
    await until(page, '0,1,2,3,4,5');
    await page.keyboard.press('Control+y');
    await until(page, '0,1,2,3');
    await page.keyboard.press('Control+z');
    await until(page, '0,1,2,3,4,5');
    assert.deepEqual(faults, []);
  });

  test('by keyboard alone, also while fixing; the list of keys says so', async () => {
    await open();
    await openFix(page);
    for (const object of [3, 1]) {
      await page.focus(`[data-object="${object}"] .object-main`);
      await page.keyboard.press('Shift+Enter');
    }
    await page.click('#canvas', { modifiers: ['Shift'], position: await placeOf(page, 5) });
    await page.focus('#join-apply');
    await page.keyboard.press('Enter');
    await until(page, '0,2,3,4');
    assert.equal(await page.evaluate(() => document.activeElement.id), 'join-undo');
    await page.click('#correct-undo');
    await until(page, '0,1,2,3,4,5');
    await page.keyboard.press('?');
    await page.waitForSelector('#help[open]');
    assert.match(await text(page, '#help-keys'), /Shift Enter\s+on a listed object: select several/);
    await page.click('#help-close');
    await page.click('#correct-done');
    assert.deepEqual(faults, []);
  });

  test('a drag from one object to another joins them, in one step of undo; a click still picks', async () => {
    await open();
    await openFix(page);
    const settle = () => page.evaluate(() => new Promise((done) => requestAnimationFrame(() => setTimeout(done, 100))));
    await settle();
    const box = await page.locator('#canvas').boundingBox();
    const [from, to] = [await placeOf(page, 2), await placeOf(page, 4)];
    const drag = async (start, end) => {
      await page.mouse.move(box.x + start.x, box.y + start.y);
      await page.mouse.down();
      await page.mouse.move(box.x + end.x, box.y + end.y, { steps: 4 });
    };
    await drag(from, { x: from.x, y: 4 });
    await page.mouse.up();
    assert.equal(await labels(page), '0,1,2,3,4,5', 'a drag to the background joins nothing');
    assert.equal(await page.inputValue('#correct-object'), '1', 'and picks nothing');
    await drag(from, to);
    await page.evaluate(() => globalThis.tracecutStudio.app.viewer.draw());
    await screenshot(page, 'join-drag');
    await page.mouse.up();
    await until(page, '0,1,2,3,5');
    assert.equal(await text(page, '#correct-status'), 'Object 4 joined with Object 2. 4 moving objects.');
    await page.keyboard.press('Control+z');
    await until(page, '0,1,2,3,4,5');
    assert.equal(await page.locator('#correct-undo').isDisabled(), true);
    await page.mouse.click(box.x + to.x, box.y + to.y);
    assert.equal(await page.inputValue('#correct-object'), '4');
    // When zoomed in, a drag from the background still pans.
    await page.keyboard.press('+');
    const left = () => page.evaluate(() => globalThis.tracecutStudio.app.viewer.zoom.x);
    const before = await left();
    const ground = { x: box.width * 0.3, y: box.height * 0.8 };
    await drag(ground, { x: ground.x - 60, y: ground.y });
    await page.mouse.up();
    assert.ok((await left()) > before);
    await page.keyboard.press('0');
    await page.click('#correct-done');
    assert.deepEqual(faults, []);
  });

  test('those that touch and move alike are proposed, until they are refused', async () => {
    await open({ ...WIDE, parts: 3 });
    await page.waitForSelector('#join', { state: 'visible' });
    assert.match(await text(page, '#join-message'), /3 pieces look like one\.$/);
    assert.deepEqual(await accessibilityFaults(page), []);
    await page.locator('#join').scrollIntoViewIfNeeded();
    await screenshot(page, 'join-proposed');
    await page.click('#join-apply');
    await until(page, '0,1,4,5');
    await page.click('#join-undo');
    await until(page, '0,1,2,3,4,5');
    await page.waitForFunction(() => /look like one/.test(document.querySelector('#join-message').textContent));
    await page.click('#join-dismiss');
    await page.waitForSelector('#join', { state: 'hidden' });
    // A change of the result does not bring it back.
    await openFix(page);
    await page.selectOption('#correct-object', '5');
    await page.click('#correct-background');
    await until(page, '0,1,2,3,4');
    await page.waitForTimeout(500);
    assert.equal(await page.locator('#join').isVisible(), false);
    await page.click('#correct-done');
    assert.deepEqual(faults, []);
  });

  async function corrected() {
    await open();
    await openFix(page);
    await page.selectOption('#correct-object', '2');
    await page.click('#correct-background');
    await page.waitForFunction(() => /^Corrected/.test(document.querySelector('#correct-status').textContent));
    await until(page, '0,1,3,4,5');
  }

  test('corrections are not lost by a key; another run asks, and is a step of undo', async () => {
    await corrected();
    const masks = () => page.evaluate(() => String(globalThis.tracecutStudio.app.segmentation.mask(3)));
    const before = await masks();
    await page.click('#correct-done');
    await page.keyboard.press('r');
    assert.equal(await page.evaluate(() => document.body.dataset.phase), 'done');
    await redo(page);
    await page.waitForSelector('#confirm[open]');
    assert.deepEqual(await accessibilityFaults(page), []);
    await screenshot(page, 'ask');
    await page.keyboard.press('Escape');
    assert.equal(await masks(), before, 'whoever says no keeps them');
    for (const undo of [() => page.click('#restore'), () => page.keyboard.press('Control+z')]) {
      await redo(page);
      await page.click('#confirm-yes');
      await page.waitForSelector('#restore', { state: 'visible' });
      assert.equal(await ended(page), 'done');
      await undo();
      await page.waitForFunction(() => document.querySelector('#restore').hidden);
      assert.equal(await ended(page), 'done');
      assert.equal(await masks(), before);
    }
    await redo(page);
    await page.click('#confirm-yes');
    await page.waitForSelector('#restore', { state: 'visible' });
    assert.equal(await ended(page), 'done');
    await openFix(page);
    await page.click('#correct-undo');
    await page.waitForFunction(() => document.querySelector('#restore').hidden);
    assert.equal(await ended(page), 'done');
    assert.equal(await masks(), before, 'undo in “Fix” is the same');
    await openFix(page);
    await page.click('#correct-undo');
    await until(page, '0,1,2,3,4,5');
    await page.click('#correct-done');
    assert.deepEqual(faults, []);
  });

  test('corrections are described by their kind; first an object is merged with another', async () => {
    await corrected();
    const into = () =>
      page.evaluate(() => [...document.querySelector('#correct-into').options].map(({ value }) => value));
    assert.ok(!(await into()).includes('0'), 'the background has a button of its own');
    assert.notEqual(await page.inputValue('#correct-into'), '0');
    await page.click('#correct-undo');
    await page.waitForFunction(() => document.querySelectorAll('.object').length === 6);
    assert.match(await text(page, '#correct-status'), /^Undone\. 5 moving objects/);
    await page.click('#correct-redo');
    await page.waitForFunction(() => document.querySelectorAll('.object').length === 5);
    assert.match(await text(page, '#correct-status'), /^Redone\. 4 moving objects/);
    await page.click('#correct-done');
  });
});
