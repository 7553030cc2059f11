// A result is fixed with the mouse, by keyboard and by touch. The rules behind the tools are tested in Node
// (tests/node/studio-painting.test.mjs, studio-steps.test.mjs).

import { expect, openSample, runEnd, test, useSample } from './fixtures.mjs';
import {
  correct,
  drag,
  fiveObjects,
  frameOnScreen,
  labelAt,
  masks,
  openFive,
  openFix,
  paint,
  pointOf,
  seek,
  selectTool,
} from './studio-page.mjs';

/** Five squares of 19 pixels; object k is at (20, 0), (60, 23), (100, 47), (141, 70), (181, 94) in the first frame. */
const FIVE = { width: 240, height: 136, frames: 6 };
const INSIDE = { 1: [29, 9], 2: [69, 32], 4: [150, 79], 5: [190, 103] };
const BACKGROUND = [30, 100];

const undo = (page) => correct(page, () => page.click('#correct-undo'));
const objects = (page) =>
  page.locator('.object').evaluateAll((rows) => rows.map(({ dataset }) => dataset.object).join());
const expectObjects = (page, expected) => expect.poll(() => objects(page)).toBe(expected);

test.describe('with the mouse', () => {
  const sample = useSample({ sample: 'tiny' });

  /** Opens the five objects again, and the tools. */
  async function openTools(shape = FIVE) {
    const { page } = sample;
    await openFive(page, shape);
    await openFix(page);
    return page;
  }

  test('brush and eraser paint where they are drawn, in other frames too, and are undone and redone', async () => {
    const page = await openTools();
    const before = await masks(page);
    await page.click('#canvas', { position: await inCanvas(page, ...INSIDE[2]) });
    await expect(page.locator('#correct-object')).toHaveValue('2');
    await expect(page.locator('#correct-facts')).toHaveText(/^upper left, .*%$/);
    await expect(page.locator('#show-all')).toBeHidden();
    await seek(page, 2);

    await selectTool(page, 'paint');
    expect(await paint(page, [60, 70], [90, 74])).toMatch(/^Applied to frame/);
    expect(await labelAt(page, 2, 75, 72)).toBe(2);
    expect(await labelAt(page, 2, 75, 90)).toBe(0);
    await selectTool(page, 'erase');
    await page.uncheck('#brush-carry');
    expect(await paint(page, [60, 70], [90, 74])).toBe('Applied to frame 3.');
    expect(await labelAt(page, 2, 75, 72)).toBe(0);
    await page.check('#brush-carry');
    const paintedMasks = await masks(page);

    expect(await undo(page)).toBe('Undone. 5 moving objects.');
    await correct(page, () => page.keyboard.press('Control+z'));
    expect(await masks(page)).toBe(before);
    await expect(page.locator('#correct-undo')).toBeDisabled();
    expect(await correct(page, () => page.click('#correct-redo'))).toBe('Redone. 5 moving objects.');
    await correct(page, () => page.keyboard.press('Control+y'));
    expect(await masks(page)).toBe(paintedMasks);
    await expect(page.locator('#correct-redo')).toBeDisabled();
  });

  test('the ends of a fix are dragged and moved by keys, around the painted frame', async () => {
    const page = await openTools();
    const before = await masks(page);
    const ends = () => page.locator('.fix-handle').evaluateAll((handles) => handles.map(({ value }) => Number(value)));
    await expect(page.locator('#fix-range')).toBeHidden();
    await seek(page, 2);
    await selectTool(page, 'paint');
    await page.selectOption('#correct-object', '2');
    await page.uncheck('#brush-carry');
    await paint(page, [60, 70], [90, 74]);
    await page.check('#brush-carry');
    expect(await ends()).toEqual([2, 2]);
    await page.getByRole('slider', { name: 'Last frame of the fix' }).focus();
    expect(await correct(page, () => page.keyboard.press('ArrowRight'))).toBe('Applied to frames 3–4.');
    expect(await labelAt(page, 3, 75, 72)).toBe(2);
    expect(await frameOnScreen(page)).toBe(3);
    await page.getByRole('slider', { name: 'First frame of the fix' }).focus();
    expect(await correct(page, () => page.keyboard.press('ArrowLeft'))).toBe('Applied to frames 2–4.');

    // Dragged beyond the painted frame, the first end stops there.
    const scrub = await page.locator('#scrub').boundingBox();
    const box = await page.locator('#fix-range').boundingBox();
    const x = (t) => scrub.x + (t / (FIVE.frames - 1)) * (scrub.width - 14);
    await correct(page, async () => {
      await page.mouse.move(x(1), box.y + box.height / 2);
      await page.mouse.down();
      await page.mouse.move(x(4), box.y + box.height / 2, { steps: 3 });
      await page.mouse.up();
    });
    expect(await ends()).toEqual([2, 3]);
    await undo(page);
    expect(await masks(page)).toBe(before);
    await expect(page.locator('#fix-range')).toBeHidden();
  });

  test('the region that a click would add is outlined; the wheel and keys size it, Alt removes it', async () => {
    const page = await openTools();
    const size = page.locator('#add-size');
    await page.selectOption('#correct-object', '4');
    await correct(page, () => page.click('#correct-background'));
    const missed = await masks(page);

    await selectTool(page, 'add');
    const [u, v] = await pointOf(page, ...INSIDE[4]);
    await page.mouse.move(u, v);
    await expect(size).toHaveText(/^Size [1-3] of [23], [\d.]+% of the frame\.$/);
    const first = await size.innerText();
    const [at, count, share] = first.match(/[\d.]+/g).map(Number);
    await page.mouse.wheel(0, at < count ? -120 : 120);
    await expect(size).not.toHaveText(first);
    await page.keyboard.press(at < count ? '-' : '+');
    await expect(size).toHaveText(first);
    await expect(page.locator('#zoom-fit')).toHaveText('100%');
    await expect(page.locator('#add-larger')).toBeHidden();
    await page.uncheck('#brush-carry');
    await correct(page, () => page.mouse.click(u, v));
    const label = await labelAt(page, 0, ...INSIDE[4]);
    expect(label).toBeGreaterThan(0);
    const area = await areaOf(page, label);
    expect((100 * area) / (FIVE.width * FIVE.height)).toBeCloseTo(share, 0);

    await page.mouse.move(u + 1, v);
    await page.keyboard.down('Alt');
    await expect(size).not.toBeEmpty();
    await correct(page, () => page.mouse.click(u + 1, v));
    await page.keyboard.up('Alt');
    expect(await labelAt(page, 0, ...INSIDE[4])).toBe(0);
    for (let steps = 0; steps < 2; steps += 1) await undo(page);
    expect(await masks(page)).toBe(missed);
    await page.check('#brush-carry');

    // The crosshair of the keyboard outlines a region and announces its size.
    await page.focus('#correct-tools [value="add"]');
    await page.keyboard.press('Shift+Tab');
    await page.focus('#canvas');
    await page.keyboard.press('ArrowLeft');
    await expect(page.locator('#live')).toHaveText(/^Size \d/);
    // With another tool the wheel zooms.
    await selectTool(page, 'pick');
    await page.mouse.move(u, v);
    await page.mouse.wheel(0, -120);
    await expect(page.locator('#zoom-fit')).not.toHaveText('100%');
    await page.keyboard.press('0');
  });

  test('strokes join the objects under them, and a click and a button split one', async () => {
    const page = await openTools();
    const before = await masks(page);
    const apply = page.locator('#strokes-apply');
    await selectTool(page, 'together');
    await expect(apply).toBeDisabled();
    for (const [x, y] of [INSIDE[1], INSIDE[2]]) {
      await drag(page, [
        [x, y],
        [x + 4, y],
      ]);
    }
    await expect(page.locator('#strokes-count')).toHaveText('2 strokes');
    expect(await correct(page, () => apply.click())).toMatch(/^Corrected in \d+\.\d\ss\. 4 moving objects\.$/);
    await expectObjects(page, '0,1,3,4,5');
    await expect(page.locator('#strokes-count')).toHaveText('0 strokes');
    await expect(page.locator('#headline')).toHaveText('4 moving objects');
    await selectTool(page, 'apart');
    await drag(page, [INSIDE[1], INSIDE[1]]);
    await expect(page.locator('#strokes-count')).toHaveText('1 stroke');
    await expect(apply).toBeDisabled();

    await selectTool(page, 'pick');
    await page.click('#canvas', { position: await inCanvas(page, ...INSIDE[2]) });
    await expect(page.locator('#correct-object')).toHaveValue('1');
    await correct(page, () => page.click('#correct-split'));
    await expectObjects(page, '0,1,3,4,5,6');
    expect(await labelAt(page, 0, ...INSIDE[2])).not.toBe(await labelAt(page, 0, ...INSIDE[1]));
    await page.selectOption('#correct-object', '6');
    const targets = page.locator('#correct-into option:not([hidden])');
    expect(await targets.evaluateAll((options) => options.map(({ value }) => value).join())).toBe('1,3,4,5');
    await page.selectOption('#correct-into', '3');
    await correct(page, () => page.click('#correct-merge'));
    await expectObjects(page, '0,1,3,4,5');
    for (let steps = 0; steps < 3; steps += 1) await undo(page);
    expect(await masks(page)).toBe(before);
  });

  test('a drag from one object to another joins them; one from the background pans', async () => {
    const page = await openTools();
    await drag(page, [INSIDE[2], BACKGROUND]);
    await expect(page.locator('#correct-object')).toHaveValue('1');
    await expect(page.locator('#correct-undo')).toBeDisabled();
    const message = await correct(page, () => drag(page, [INSIDE[2], INSIDE[4]]));
    expect(message).toBe('Object 4 joined with Object 2. 4 moving objects.');
    await expectObjects(page, '0,1,2,3,5');
    await undo(page);
    await expectObjects(page, '0,1,2,3,4,5');
    await page.keyboard.press('+');
    const leftEdge = () => page.evaluate(() => globalThis.tracecutStudio.app.viewer.zoom.x);
    const before = await leftEdge();
    const box = await page.locator('#canvas').boundingBox();
    await page.mouse.move(box.x + 0.3 * box.width, box.y + 0.8 * box.height);
    await page.mouse.down();
    await page.mouse.move(box.x + 0.3 * box.width - 60, box.y + 0.8 * box.height, { steps: 4 });
    await page.mouse.up();
    expect(await leftEdge()).toBeGreaterThan(before);
    await page.keyboard.press('0');
  });

  test('objects are selected in the list and in the picture, and joined in one step', async () => {
    const { page } = sample;
    await openFive(page, FIVE);
    await page.click('[data-object="2"] .object-main', { modifiers: ['Shift'] });
    await expect(page.locator('#join')).toBeVisible();
    await expect(page.locator('#join-apply')).toBeDisabled();
    await expect(page.getByRole('button', { name: /^Object 2 \(light blue\), selected [\d.]+%/ })).toHaveCount(1);
    await expect(page.locator('#show-all')).toBeHidden();
    await page.click('[data-object="4"] .object-main', { modifiers: ['Control'] });
    await page.click('#canvas', { modifiers: ['Shift'], position: await inCanvas(page, ...INSIDE[5]) });
    await expect(page.locator('#join-message')).toHaveText('Object 2Object 4Object 53 objects selected');
    await expect(page.locator('.is-candidate')).toHaveCount(3);
    await page.click('#join-apply');
    await expectObjects(page, '0,1,2,3');
    await expect(page.locator('#join-message')).toHaveText('3 objects joined.');
    await page.click('#join-undo');
    await expectObjects(page, '0,1,2,3,4,5');
    await page.keyboard.press('Control+y');
    await expectObjects(page, '0,1,2,3');

    // The same by keyboard.
    await page.keyboard.press('Control+z');
    await expectObjects(page, '0,1,2,3,4,5');
    for (const object of [3, 1]) {
      await page.focus(`[data-object="${object}"] .object-main`);
      await page.keyboard.press('Shift+Enter');
    }
    await page.focus('#join-apply');
    await page.keyboard.press('Enter');
    await expectObjects(page, '0,2,3,4,5');
    await expect(page.locator('#join-undo')).toBeFocused();
  });

  test('pieces that look like one object are proposed, joined or dismissed', async () => {
    const { page } = sample;
    await openFive(page, { ...FIVE, parts: 3 });
    await expect(page.locator('#join-message')).toHaveText(/3 pieces look like one\.$/);
    await page.click('#join-apply');
    await expectObjects(page, '0,1,4,5');
    await page.click('#join-undo');
    await expect(page.locator('#join-message')).toHaveText(/look like one\.$/);
    await page.click('#join-dismiss');
    await expect(page.locator('#join')).toBeHidden();
  });

  test('another run asks before it replaces corrections, and undo restores them', async () => {
    const { page } = sample;
    await page.click('#sample');
    expect(await runEnd(page)).toBe('done');
    await openFix(page);
    await selectTool(page, 'paint');
    await page.uncheck('#brush-carry');
    await paint(page, [4, 4], [12, 8]);
    await page.check('#brush-carry');
    const corrected = await masks(page);
    const job = await page.evaluateHandle(() => globalThis.tracecutStudio.app.job);
    const isSameJob = () => page.evaluate((first) => globalThis.tracecutStudio.app.job === first, job);
    const redo = async () => {
      await page.click('#redo-open');
      await page.click('#redo-run');
      await page.waitForSelector('#confirm[open]');
    };
    await page.click('#correct-done');
    await page.keyboard.press('r');
    await redo();
    await page.keyboard.press('Escape');
    expect(await isSameJob()).toBe(true);
    await redo();
    await page.click('#confirm-yes');
    await expect(page.locator('#restore')).toBeVisible();
    expect(await runEnd(page)).toBe('done');
    expect(await isSameJob()).toBe(false);
    await openFix(page);
    await page.click('#correct-undo');
    await expect(page.locator('#restore')).toBeHidden();
    expect(await runEnd(page)).toBe('done');
    expect(await isSameJob()).toBe(true);
    expect(await masks(page)).toBe(corrected);
  });
});

test('an added object gets its size after a tap on touch screens', async ({ openStudio }) => {
  const page = await openSample(openStudio, {
    ...{ sample: 'tiny', viewport: { width: 390, height: 844 }, hasTouch: true, isMobile: true },
  });
  await openFive(page, FIVE);
  await openFix(page);
  await page.selectOption('#correct-object', '4');
  await correct(page, () => page.click('#correct-background'));
  await selectTool(page, 'add');
  await page.uncheck('#brush-carry');
  const [u, v] = await pointOf(page, ...INSIDE[4]);
  expect(await correct(page, () => page.touchscreen.tap(u, v))).toBe('Applied to frame 1.');
  const label = await labelAt(page, 0, ...INSIDE[4]);
  const before = await areaOf(page, label);
  const isLarger = await page.locator('#add-larger').isEnabled();
  await correct(page, () => page.click(isLarger ? '#add-larger' : '#add-smaller'));
  const change = (await areaOf(page, label)) - before;
  expect(Math.sign(change)).toBe(isLarger ? 1 : -1);
  expect(await labelAt(page, 0, ...INSIDE[4])).toBe(label);
});

test('a project is opened, fixed with the brush and saved as a video by keyboard alone', async ({ openStudio }) => {
  // One column, which scrolls.
  const page = await openSample(openStudio, { sample: 'tiny', viewport: { width: 800, height: 900 } });
  const { project } = await fiveObjects(page, FIVE);
  // Before the last key, which would else be faster than the interception of the dialog.
  const choosing = page.waitForEvent('filechooser');
  await tabTo(page, '#open');
  await page.keyboard.press('Enter');
  await (await choosing).setFiles([project]);
  await expectObjects(page, '0,1,2,3,4,5');

  await page.evaluate(() => scrollTo(0, document.body.scrollHeight));
  await page.keyboard.press('m');
  await page.waitForSelector('body[data-correcting]');
  await expect(page.locator('#correct-tools')).toBeInViewport({ ratio: 1 });
  await expect(page.locator('#correct-tools [value="pick"]')).toBeFocused();
  await page.keyboard.press('ArrowRight');
  await expect(page.locator('#correct-tools [value="paint"]')).toBeFocused();
  expect(await frameOnScreen(page)).toBe(0);
  await tabTo(page, '#canvas', 'Shift+Tab');
  await correct(page, async () => {
    for (const key of ['ArrowLeft', 'ArrowUp', ' ', 'ArrowLeft', 'ArrowLeft', 'Shift+ArrowUp', ' '])
      await page.keyboard.press(key);
  });
  const edits = () =>
    page.evaluate(() =>
      globalThis.tracecutStudio.app.job.corrections.edits.map(({ paints: [{ label, parts }] }) => [
        label,
        [...parts.keys()][0],
      ]),
    );
  expect(await edits()).toEqual([[1, 0]]);
  await page.keyboard.press('Escape');
  await expect(page.locator('body')).not.toHaveAttribute('data-correcting');
  await expect(page.locator('#correct-open')).toBeFocused();
  await expect(page.locator('#canvas')).not.toHaveAttribute('tabindex');

  await page.keyboard.press('e');
  await page.waitForSelector('#export[open]');
  await tabTo(page, '[data-export="transparent"]');
  await tabTo(page, '#export-run');
  const [video] = await Promise.all([page.waitForEvent('download'), page.keyboard.press('Enter')]);
  expect(video.suggestedFilename()).toBe('five-cutout.webm');
  await expect(page.locator('#export-status')).toHaveText(/^Saved/);
  await expect(page.locator('#export-run')).toBeFocused();
  await tabTo(page, '#export-more > summary', 'Shift+Tab');
  await page.keyboard.press('Enter');
  await tabTo(page, '[data-export="coco"]');
  const [annotations] = await Promise.all([page.waitForEvent('download'), page.keyboard.press('Enter')]);
  expect(annotations.suggestedFilename()).toBe('five-coco.json');
  await page.keyboard.press('Escape');
  await expect(page.locator('#export')).toBeHidden();

  await tabTo(page, '#scrub');
  await page.keyboard.press('ArrowRight');
  await expect(page.locator('#scrub')).toHaveValue('1');
  await tabTo(page, '.lane-name');
  await tabTo(page, '.object-main');
  await page.keyboard.press('Enter');
  await expect(page.locator('.object-main[aria-pressed="true"]')).toBeFocused();
  await tabTo(page, '#look > summary', 'Shift+Tab');
  await page.keyboard.press('Enter');
  await tabTo(page, '[data-layer="masks"]');
  await page.keyboard.press(' ');
  await expect(page.locator('[data-layer="masks"]')).not.toBeChecked();
});

/** Presses Tab until an element has the focus; each element on the way shows that it has it. */
async function tabTo(page, selector, key = 'Tab') {
  for (let presses = 0; presses < 60; presses += 1) {
    await page.keyboard.press(key);
    const focus = await page.evaluate((expected) => {
      const focused = document.activeElement;
      const marked = focused.type === 'radio' ? (focused.closest('.card') ?? focused.nextElementSibling) : focused;
      const { outlineStyle, outlineWidth } = getComputedStyle(marked);
      const isMarked = focused === document.body || (outlineStyle !== 'none' && outlineWidth !== '0px');
      return { isMarked, isReached: focused.matches(expected), text: focused.outerHTML.slice(0, 80) };
    }, selector);
    expect(focus.isMarked, focus.text).toBe(true);
    if (focus.isReached) return;
  }
  throw new Error(`${selector} is not reached with ${key}`);
}

/** Returns where a pixel of the clip is, relative to the canvas. */
async function inCanvas(page, x, y) {
  const unit = await page.evaluate(() => globalThis.tracecutStudio.app.viewer.view.unit);
  return { x: (x + 0.5) / unit, y: (y + 0.5) / unit };
}

/** Returns the number of pixels of an object in the first frame. */
function areaOf(page, object) {
  return page.evaluate(
    (expected) => globalThis.tracecutStudio.app.segmentation.mask(0).filter((label) => label === expected).length,
    object,
  );
}
