// The picture of a result: zoomed, compared, in layers and as sharp as its source; the timeline, keys, and the places to check.

import { plainFrame } from '../moving.mjs';
import { SMALL, expect, runEnd, test, useSample } from './fixtures.mjs';
import {
  accessibilityFaults,
  frameOnScreen,
  openFive,
  openLook,
  openRedo,
  picture,
  pngFile,
  seek,
  setControl,
  showOnly,
} from './studio-page.mjs';

const FIVE = { width: 240, height: 136, frames: 8 };

test.describe('a sample', () => {
  const sample = useSample({ bypassCSP: true });
  const zoom = () =>
    sample.page.evaluate(() => {
      const { scale, x, y } = globalThis.tracecutStudio.app.viewer.zoom;
      return { scale, x, y };
    });
  /** Returns the pixel of the clip at a place of the canvas. */
  const placeAt = (offsetX, offsetY) =>
    sample.page.evaluate((place) => globalThis.tracecutStudio.app.viewer.placeAt(place), { offsetX, offsetY });
  const distance = ([x, y], [u, v]) => Math.hypot(x - u, y - v);

  test('is zoomed about the pointer by the wheel and two fingers, and moved by dragging', async () => {
    const { page } = sample;
    const box = await page.locator('#canvas').boundingBox();
    const [x, y] = [Math.round(box.width * 0.7), Math.round(box.height * 0.4)];
    const before = await placeAt(x, y);
    await page.mouse.move(box.x + x, box.y + y);
    for (let notches = 0; notches < 5; notches += 1) await page.mouse.wheel(0, -100);
    await expect(page.locator('#zoom-fit')).toHaveText('305%');
    const zoomed = await placeAt(x, y);
    expect(distance(zoomed, before)).toBeLessThan(1.5);
    await page.mouse.down();
    await page.mouse.move(box.x + x - 60, box.y + y - 30, { steps: 4 });
    await page.mouse.up();
    expect(distance(await placeAt(x - 60, y - 30), zoomed)).toBeLessThan(3);
    await expect(page.locator('.object.is-hidden')).toHaveCount(0);

    await page.keyboard.press('0');
    const prevented = await page.evaluate(() => {
      const { canvas } = globalThis.tracecutStudio.app.viewer;
      const { left, top, width, height } = canvas.getBoundingClientRect();
      const move = (name, distance) => {
        const touches = [-distance, distance].map((offset, identifier) => {
          const [clientX, clientY] = [left + width / 2 + offset, top + height / 2];
          return new Touch({ identifier, target: canvas, clientX, clientY });
        });
        return !canvas.dispatchEvent(new TouchEvent(name, { touches, cancelable: true, bubbles: true }));
      };
      const events = [move('touchstart', 40), move('touchmove', 80), move('touchmove', 100)];
      canvas.dispatchEvent(new TouchEvent('touchend', { touches: [] }));
      return events;
    });
    expect(prevented).toEqual([true, true, true]);
    const { scale, x: left } = await zoom();
    expect(scale).toBeCloseTo(2.5);
    expect(left + 0.5 / scale).toBeCloseTo(0.5);
    await page.keyboard.press('0');
  });

  test('is zoomed and moved by keys and buttons, and fills the screen', async () => {
    const { page } = sample;
    expect(await zoom()).toEqual({ scale: 1, x: 0, y: 0 });
    await expect(page.locator('#zoom-out')).toBeDisabled();
    await page.keyboard.press('+');
    await page.keyboard.press('+');
    await page.click('#zoom-in');
    const { scale, x } = await zoom();
    expect(scale).toBeCloseTo(1.25 ** 3);
    const frame = await frameOnScreen(page);
    await page.keyboard.press('Shift+ArrowRight');
    await page.keyboard.press('Shift+ArrowUp');
    expect((await zoom()).x).toBeGreaterThan(x);
    expect(await frameOnScreen(page)).toBe(frame);
    await page.keyboard.press('0');
    await page.keyboard.press('w');
    await expect(page.locator('#fill-screen')).toHaveAttribute('aria-pressed', 'true');
    expect(await page.evaluate(() => document.fullscreenElement.id)).toBe('stage');
    await page.keyboard.press('w');
    await expect(page.locator('#fill-screen')).toHaveAttribute('aria-pressed', 'false');
  });

  test('has its objects in their colours; a click shows one alone, also when zoomed', async () => {
    const { page } = sample;
    await seek(page, 12);
    await setControl(page, '[data-setting="masks.fill"]', '1');
    const objectsOnScreen = async () => (await page.evaluate(paintedObjects)).join();
    expect(await objectsOnScreen()).toBe('1,2,3');
    await page.click('[data-object="1"] .object-main');
    expect(await objectsOnScreen()).toBe('1');
    await page.click('#show-all');
    await page.uncheck('[data-object="1"] .keep input');
    expect(await objectsOnScreen()).toBe('2,3');
    await page.click('#show-all');

    const place = await page.evaluate(zoomToObject, 2);
    expect(place.object).toBe(2);
    await page.mouse.move(...place.at);
    await expect(page.locator('#readout')).toHaveText(/^Object 2\b/);
    expect(await page.evaluate(colourAt, place.at)).toBe(place.colour);
    await setControl(page, '[data-setting="masks.fill"]', '0');
    await page.mouse.click(...place.at);
    await expect(page.locator('[data-object="2"] .object-main')).toHaveAttribute('aria-pressed', 'true');
    await page.keyboard.press('0');
    await page.hover('#canvas', { position: { x: 3, y: 3 } });
    await expect(page.locator('#readout')).toHaveText(/^Background\b/);
    await page.click('#canvas', { position: { x: 3, y: 3 } });
    await expect(page.locator('#show-all')).toBeHidden();
  });

  test('has layers that fade, and keeps its colours below the outlines', async () => {
    const { page } = sample;
    const changed = await page.evaluate(changedShare);
    expect(changed).toBeGreaterThan(0.001);
    expect(changed).toBeLessThan(0.1);
    await openLook(page);
    await showOnly(page, 'masks');
    const opacity = () => page.evaluate(meanOpacity);
    const set = (name, value) => page.locator(`[data-setting="masks.${name}"]`).fill(String(value));
    await set('fill', 0.5);
    const filled = await opacity();
    await set('opacity', 0.5);
    expect((await opacity()) / filled).toBeCloseTo(0.5, 1);
    await set('opacity', 0);
    expect(await opacity()).toBe(0);
    await set('opacity', 1);
    await set('fill', 0);
    const outlines = await opacity();
    expect(outlines).toBeGreaterThan(0);
    expect(outlines).toBeLessThan(0.5 * filled);
    await showOnly(page);
    await page.keyboard.press('1');
    await expect(page.locator('[data-layer="masks"]')).not.toBeChecked();
    await page.keyboard.press('1');
    await expect(page.locator('[data-layer="masks"]')).toBeChecked();
    await page.evaluate(() => (document.querySelector('#look').open = false));
  });

  test('stands beside the original, or over it up to a divider', async () => {
    const { page } = sample;
    const boxes = () =>
      page.evaluate(() =>
        ['original', 'canvas'].map((id) => document.getElementById(id).getBoundingClientRect().toJSON()),
      );
    await page.keyboard.press('+');
    await page.keyboard.press('v');
    await expect(page.locator('#screen')).toHaveAttribute('data-view', 'beside');
    const [left, right] = await boxes();
    expect(left.right).toBeLessThanOrEqual(right.left);
    expect(left.width).toBeCloseTo(right.width, 0);
    expect(left.width).toBeGreaterThan(200);
    // The original is zoomed like the result: the mean difference of a shift by one pixel is above 3.
    expect(await page.evaluate(differenceFromOriginal)).toBeLessThan(1);
    await page.keyboard.press('0');
    await page.keyboard.press('v');
    const [below, above] = await boxes();
    expect(below).toEqual(above);
    await page.focus('#split');
    await page.keyboard.press('Home');
    await expect(page.locator('#original')).toHaveCSS('clip-path', /^inset\(0px (calc\(100%\)|100%) 0px 0px\)$/);
    await page.check('[name="view"][value="overlay"]', { force: true });
    await expect(page.locator('#original')).toBeHidden();
  });

  test('is played and searched by keys, lanes and the slider', async () => {
    const { page } = sample;
    const counter = page.locator('#counter');
    const last = SMALL.frames;
    await page.keyboard.press('Home');
    await expect(counter).toHaveText(`1 / ${last}`);
    await page.keyboard.press('ArrowLeft');
    await expect(counter).toHaveText(`${last} / ${last}`);
    await page.keyboard.press('ArrowRight');
    await expect(counter).toHaveText(`1 / ${last}`);
    await page.keyboard.press('End');
    await expect(counter).toHaveText(`${last} / ${last}`);
    await page.keyboard.press('Home');
    await page.keyboard.press(' ');
    await expect.poll(() => frameOnScreen(page)).toBeGreaterThan(2);
    await page.keyboard.press(' ');
    await expect(page.locator('#play')).toHaveAttribute('aria-label', 'Play');

    await expect(page.locator('.lane')).toHaveCount(3);
    const box = await page.locator('[data-lane="1"] .lane-canvas').boundingBox();
    await page.mouse.click(box.x + (box.width * 12.5) / last, box.y + box.height / 2);
    await expect(counter).toHaveText(`13 / ${last}`);
    const peak = await page.evaluate(() => globalThis.tracecutStudio.app.segmentation.presence.facts(1).peak);
    await page.click('[data-lane="1"] .lane-name');
    await expect(counter).toHaveText(`${peak + 1} / ${last}`);
    await expect(page.locator('#canvas')).toHaveAttribute('aria-label', 'Sample clip: 3 moving objects');
    await expect(page.locator('#frame-text')).toHaveText(/^Frame \d+ of 16, .*: .*Object 1 \(orange\)/);
  });

  test('leaves keys to the focused button and to open dialogs', async () => {
    const { page } = sample;
    const isPlaying = () => page.evaluate(() => globalThis.tracecutStudio.app.timeline.playing);
    // After a click on a control the space bar plays.
    await page.click('[data-object="1"] .keep');
    await page.keyboard.press(' ');
    expect(await isPlaying()).toBe(true);
    await expect(page.locator('#show-all')).toBeVisible();
    await page.keyboard.press(' ');
    // Reached with Tab, it is pressed.
    await page.focus('[data-object="1"] .object-main');
    await page.keyboard.press('Tab');
    await page.keyboard.press(' ');
    expect(await isPlaying()).toBe(false);
    await expect(page.locator('#show-all')).toBeHidden();
    const before = await picture(page);
    await page.keyboard.press('?');
    await page.waitForSelector('#help[open]');
    await expect(page.locator('#help-keys')).toHaveText(/Shift Enter\s*on a listed object: select several/);
    await page.keyboard.press('1');
    await page.keyboard.press('Escape');
    await expect(page.locator('#help')).toBeHidden();
    expect(await picture(page)).toBe(before);
  });

  test('runs again with settings from the dialog, announces its stages, and resets them', async () => {
    const { page } = sample;
    const countTrajectories = () => page.evaluate(() => globalThis.tracecutStudio.result.trajectories.count);
    const before = await countTrajectories();
    await expect(page.locator('#again')).toBeHidden();
    await openRedo(page);
    await expect(page.locator('#redo input[type="range"]:visible')).toHaveCount(0);
    await page.check('[name="trajectory.gridStep"][value="6"]', { force: true });
    await page.click('#redo-close');
    await expect(page.locator('#again')).toBeVisible();
    await page.evaluate(() => {
      globalThis.announcements = new Set();
      const live = document.querySelector('#live');
      new MutationObserver(() => globalThis.announcements.add(live.textContent)).observe(live, { childList: true });
    });
    await page.click('#again');
    expect(await runEnd(page)).toBe('done');
    const announcements = await page.evaluate(() => [...globalThis.announcements]);
    expect(announcements).toContain('Reading frames');
    expect(announcements).toContain('Tracking motion');
    await expect(page.locator('#again')).toBeHidden();
    expect(await countTrajectories()).toBeGreaterThan(1.4 * before);
    await openRedo(page);
    await page.click('#settings-reset');
    await expect(page.locator('[name="trajectory.gridStep"][value="default"]')).toBeChecked();
    await expect(page.locator('#settings-reset')).toBeHidden();
    await page.click('#redo-close');
  });

  test('marks the places to check, shows the next one, and repairs or accepts it', async () => {
    const { page } = sample;
    const doubts = [
      { from: 2, to: 5 },
      { from: 6, to: 8 },
    ];
    await openFive(page, { ...FIVE, doubts });
    await expect(page.locator('#doubt-next')).toHaveText('2 places to check');
    const widths = await page
      .locator('.doubt')
      .evaluateAll((marks) => marks.map((mark) => mark.getBoundingClientRect().width));
    expect(widths).toHaveLength(2);
    expect(widths[0]).toBeGreaterThan(1.5 * widths[1]);
    await expect(page.locator('#doubt-actions')).toBeHidden();
    const { width } = await page.locator('#scrub').boundingBox();
    await page.keyboard.press('n');
    expect(await frameOnScreen(page)).toBe(3);
    expect((await page.locator('#scrub').boundingBox()).width).toBe(width);
    // The test finishes the repair.
    await page.evaluate(() => {
      const { job } = globalThis.tracecutStudio.app;
      job.agreement = Float32Array.of(1, 0.9, 0.3, NaN, 0.8, 1, 1, 1);
      const editor = job.corrections.openEditor;
      editor.interpolate = async ({ from }, { signal, onFrame }) => {
        onFrame({ t: from });
        await new Promise((resolve, reject) => {
          globalThis.finishRepair = resolve;
          signal.addEventListener('abort', () => reject(signal.reason));
        });
        return editor.paint({ label: 3, stroke: { t: from, points: [9, 60], radius: 4 } });
      };
    });
    await page.click('#doubt-neighbours');
    await expect(page.locator('#doubt-status')).toHaveText('1 frame…');
    await page.click('#doubt-stop');
    await expect(page.locator('#doubt-neighbours')).toBeVisible();
    await expect(page.locator('#doubt-next')).toHaveText('2 places to check');
    await page.focus('#doubt-neighbours');
    await page.keyboard.press('Enter');
    await expect(page.locator('#doubt-stop')).toBeFocused();
    await page.evaluate(() => globalThis.finishRepair());
    await expect(page.locator('#doubt-actions')).toBeHidden();
    await expect(page.locator('#doubt-next')).toHaveText('1 place to check');
    await expect(page.locator('#doubt-next')).toBeFocused();

    const strip = page.getByRole('img', { name: 'How sure the masks are: least in frame 3, 30%' });
    await expect(strip).toBeVisible();
    const heights = await strip.evaluate(barHeights, [0, 2, 3, 6]);
    expect(heights[0]).toBe(1);
    expect(heights[1]).toBeGreaterThan(0);
    expect(heights[1]).toBeLessThan(0.5);
    expect(heights.slice(2)).toEqual([0, 1]);
    await page.keyboard.press('n');
    await expect(page.locator('#doubt-neighbours')).toBeDisabled();
    await expect(page.locator('#doubt-neighbours')).toHaveAttribute('title', 'There is no frame after these.');
    await expect(page.locator('#doubt-redo')).toBeEnabled();
    expect(await accessibilityFaults(page)).toEqual([]);
    await page.click('#doubt-fine');
    await expect(page.locator('#doubts')).toBeHidden();
  });

  test('is shown at the size of its source while it rests', async () => {
    const { page } = sample;
    const [width, height, count] = [600, 72, 6];
    // Stripes of one pixel.
    const frames = Array.from({ length: count }, (_, t) =>
      plainFrame(width, height, (x) => [x % 2 === 0 ? 40 + t : 200, 90, 90]),
    );
    await page.setInputFiles(
      '#file',
      frames.map((frame, t) => pngFile(`stripes${t}.png`, frame)),
    );
    await expect(page.locator('#clip-name')).toHaveText(/^stripes0/);
    expect(await runEnd(page)).toBe('done');
    expect(await page.evaluate(() => globalThis.tracecutStudio.app.job.images.width)).toBe(480);
    const isShownAt = (size) =>
      page.waitForFunction((expectedWidth) => {
        const { viewer } = globalThis.tracecutStudio.app;
        viewer.draw();
        return viewer.view.image?.width === expectedWidth;
      }, size);
    await seek(page, 4);
    await isShownAt(width);
    const pixels = await page.evaluate(() => [...pixelsOf(globalThis.tracecutStudio.app.viewer.view.image)]);
    expect(Buffer.from(pixels).equals(Buffer.from(frames[4].data))).toBe(true);
    await page.click('#play');
    await isShownAt(480);
    await page.click('#play');
    await isShownAt(width);
  });
});

/** Runs in the page: the objects whose colours are on the canvas, with masks filled, where their masks are. */
function paintedObjects() {
  const { app, objectColor } = globalThis.tracecutStudio;
  const { viewer, segmentation, timeline } = app;
  viewer.draw();
  const { canvas, view } = viewer;
  const data = pixelsOf(canvas);
  const mask = segmentation.mask(timeline.frame);
  const counts = Array.from({ length: segmentation.count }, () => ({ all: 0, painted: 0 }));
  mask.forEach((label, p) => {
    const [x, y] = [p % view.width, Math.floor(p / view.width)];
    const [u, v] = [x, y].map((place) => Math.floor(((place + 0.5) * canvas.width) / view.width));
    const at = 4 * (v * canvas.width + u);
    const colour = `#${[0, 1, 2].map((c) => data[at + c].toString(16).padStart(2, '0')).join('')}`;
    counts[label].all += 1;
    if (colour === objectColor(label).toLowerCase()) counts[label].painted += 1;
  });
  return [...counts.keys()].filter((label) => label > 0 && counts[label].painted > 0.6 * counts[label].all);
}

/** Runs in the page: zooms to the inside of an object and returns the place in the window, and its colour if filled. */
function zoomToObject(object) {
  const { app, objectColor } = globalThis.tracecutStudio;
  const { viewer, segmentation, timeline } = app;
  const { width, height } = segmentation.result;
  const mask = segmentation.mask(timeline.frame);
  const inside = mask.findIndex(
    (label, p) => label === object && [-4, 4].every((d) => mask[p + d] === object && mask[p + d * width] === object),
  );
  const [x, y] = [inside % width, Math.floor(inside / width)];
  viewer.zoomTo(1, 0.5, 0.5);
  viewer.zoomTo(4, x / width, y / height);
  const { canvas, view, zoom } = viewer;
  const { left, top } = canvas.getBoundingClientRect();
  const offsetX = (x + 0.5 - zoom.x * width) / view.unit;
  const offsetY = (y + 0.5 - zoom.y * height) / view.unit;
  const spot = viewer.spotAt({ offsetX, offsetY });
  const isExact = Math.hypot(spot.x - x, spot.y - y) < 0.01;
  const colour = objectColor(object).toLowerCase();
  return { at: [left + offsetX, top + offsetY], object: isExact ? spot.object : -1, colour };
}

/** Runs in the page: the colour of the canvas at a place in the window. */
function colourAt([clientX, clientY]) {
  const { viewer } = globalThis.tracecutStudio.app;
  viewer.draw();
  const { canvas } = viewer;
  const { left, top, width } = canvas.getBoundingClientRect();
  const scale = canvas.width / width;
  const [u, v] = [clientX - left, clientY - top].map((offset) => Math.floor(offset * scale));
  const data = pixelsOf(canvas).subarray(4 * (v * canvas.width + u));
  return `#${[...data.slice(0, 3)].map((value) => value.toString(16).padStart(2, '0')).join('')}`;
}

/** Runs in the page: the share of the canvas that differs from the frame below it. */
function changedShare() {
  const { viewer } = globalThis.tracecutStudio.app;
  viewer.draw();
  const { width, height } = viewer.canvas;
  const [drawn, frame] = [viewer.canvas, viewer.view.image].map((image) => pixelsOf(image, width, height));
  let count = 0;
  for (let at = 0; at < drawn.length; at += 4)
    if ([0, 1, 2].some((c) => Math.abs(drawn[at + c] - frame[at + c]) > 8)) count += 1;
  return count / (width * height);
}

/** Runs in the page: the mean difference of the original from the result without layers. */
function differenceFromOriginal() {
  const { viewer, layers } = globalThis.tracecutStudio.app;
  const states = layers.map(({ isOn }) => isOn);
  for (const layer of layers) layer.isOn = layer.id === 'image';
  viewer.draw();
  const [original, result] = [document.querySelector('#original'), viewer.canvas].map((canvas) => pixelsOf(canvas));
  layers.forEach((layer, k) => (layer.isOn = states[k]));
  return result.reduce((sum, value, k) => sum + Math.abs(value - original[k]), 0) / result.length;
}

/** Runs in the page: the mean opacity of the canvas, 0 to 1. */
function meanOpacity() {
  const { viewer } = globalThis.tracecutStudio.app;
  viewer.draw();
  const data = pixelsOf(viewer.canvas);
  let sum = 0;
  for (let at = 3; at < data.length; at += 4) sum += data[at];
  return sum / 255 / (data.length / 4);
}

/** Runs in the page: the share of the strip's height that the bars of frames have. */
function barHeights(canvas, frames) {
  const { width, height } = canvas;
  const { data } = canvas.getContext('2d').getImageData(0, 0, width, height);
  return frames.map((t) => {
    const x = Math.min(width - 1, Math.round((t / 7) * width));
    const opaque = Array.from({ length: height }, (_, y) => data[4 * (y * width + x) + 3]).filter(Boolean);
    return opaque.length / height;
  });
}
