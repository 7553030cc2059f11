// The page with a result: the picture enlarged, compared and as sharp as its source, layers, the timeline, keys, names for
// screen readers, and settings that take another run. The tests go on where the one before ended.

import assert from 'node:assert/strict';
import { describe, test } from 'node:test';
import {
  SMALL,
  accessibilityFaults,
  ended,
  inPhase,
  openLook,
  openRedo,
  picture,
  plainFrame,
  pngFile,
  redo,
  run,
  screenshot,
  setControl,
  showOnly,
  text,
  useSample,
  useSite,
} from './support.mjs';

const site = useSite();
const sample = useSample(site, { bypassCSP: true });

describe('the canvas', () => {
  const state = () =>
    sample.page.evaluate(() => {
      const { scale, x, y } = globalThis.tracecutStudio.app.viewer.zoom;
      return { scale, x, y };
    });
  /** Where a clip pixel is on screen, and the clip pixel at a place of the canvas. */
  const placeAt = (offsetX, offsetY) =>
    sample.page.evaluate((place) => globalThis.tracecutStudio.app.viewer.placeAt(place), { offsetX, offsetY });

  test('is enlarged about the pointer by the wheel, and moved by dragging', async () => {
    const { page } = sample;
    const box = await page.locator('#canvas').boundingBox();
    const [offsetX, offsetY] = [Math.round(box.width * 0.7), Math.round(box.height * 0.4)];
    const before = await placeAt(offsetX, offsetY);
    await page.mouse.move(box.x + offsetX, box.y + offsetY);
    for (let k = 0; k < 5; k += 1) await page.mouse.wheel(0, -100);
    await page.waitForFunction(() => globalThis.tracecutStudio.app.viewer.zoom.scale > 3);
    const after = await placeAt(offsetX, offsetY);
    assert.ok(Math.hypot(after[0] - before[0], after[1] - before[1]) < 1.5, `${before} ${after}`);
    assert.equal(await text(page, '#zoom-fit'), '305%');
    await screenshot(page, 'zoomed');
    assert.deepEqual(await accessibilityFaults(page), []);
    await page.mouse.down();
    await page.mouse.move(box.x + offsetX - 60, box.y + offsetY - 30, { steps: 4 });
    await page.mouse.up();
    const moved = await placeAt(offsetX - 60, offsetY - 30);
    assert.ok(Math.hypot(moved[0] - after[0], moved[1] - after[1]) < 3, `${after} ${moved}`);
    const hidden = await page.evaluate(() => document.querySelectorAll('.object.is-hidden').length);
    assert.equal(hidden, 0, 'a movement is no click');
  });

  test('clicks and strokes hit the visible pixels, also when zoomed', async () => {
    const { page } = sample;
    await setControl(page, '[data-setting="masks.fill"]', '0.5');
    await page.evaluate(() => globalThis.tracecutStudio.app.timeline.seek(12));
    const spot = await page.evaluate(() => {
      const { viewer, segmentation } = globalThis.tracecutStudio.app;
      const { width, height } = segmentation.result;
      const mask = segmentation.mask(12);
      const inside = mask.findIndex((label, p) =>
        label === 2 ? [-4, 4].every((d) => mask[p + d] === 2 && mask[p + d * width] === 2) : false,
      );
      const [x, y] = [inside % width, Math.floor(inside / width)];
      viewer.zoomTo(1, 0.5, 0.5);
      viewer.zoomTo(4, x / width, y / height);
      viewer.draw();
      const { canvas, view, zoom } = viewer;
      const box = canvas.getBoundingClientRect();
      const offsetX = (x + 0.5 - zoom.x * view.width) / view.unit;
      const offsetY = (y + 0.5 - zoom.y * view.height) / view.unit;
      const copy = new OffscreenCanvas(canvas.width, canvas.height).getContext('2d', { willReadFrequently: true });
      copy.drawImage(canvas, 0, 0);
      const scale = canvas.width / box.width;
      return {
        at: [box.left + offsetX, box.top + offsetY],
        found: viewer.spotAt({ offsetX, offsetY }),
        place: [x, y],
        color: [...copy.getImageData(Math.floor(offsetX * scale), Math.floor(offsetY * scale), 1, 1).data],
      };
    });
    assert.equal(spot.found.object, 2);
    assert.ok(Math.hypot(spot.found.x - spot.place[0], spot.found.y - spot.place[1]) < 0.01);
    assert.ok(spot.color[2] > spot.color[0] + 20, `the second object is tinted blue: ${spot.color}`);
    await setControl(page, '[data-setting="masks.fill"]', '0');
    await page.mouse.click(...spot.at);
    assert.equal(await page.getAttribute('[data-object="2"] .object-main', 'aria-pressed'), 'true');
    await page.click('#show-all');
  });

  test('keys and buttons do it too, and the original goes with the result', async () => {
    const { page, faults } = sample;
    await page.keyboard.press('0');
    assert.deepEqual(await state(), { scale: 1, x: 0, y: 0 });
    assert.equal(await page.locator('#zoom-out').isDisabled(), true);
    await page.keyboard.press('+');
    await page.keyboard.press('+');
    await page.click('#zoom-in');
    const { scale, x } = await state();
    assert.ok(Math.abs(scale - 1.25 ** 3) < 1e-9);
    const frame = await page.inputValue('#scrub');
    await page.keyboard.press('Shift+ArrowRight');
    assert.ok((await state()).x > x);
    await page.keyboard.press('Shift+ArrowUp');
    assert.equal(await page.inputValue('#scrub'), frame, 'the frame stays');
    await page.keyboard.press('ArrowRight');
    assert.notEqual(await page.inputValue('#scrub'), frame);
    await page.check('[name="view"][value="beside"]', { force: true });
    const same = await page.evaluate(() => {
      const { viewer } = globalThis.tracecutStudio.app;
      for (const layer of globalThis.tracecutStudio.app.layers) {
        layer.wasOn = layer.isOn;
        layer.isOn = layer.id === 'image';
      }
      viewer.draw();
      const read = (canvas) => {
        const copy = new OffscreenCanvas(canvas.width, canvas.height).getContext('2d', { willReadFrequently: true });
        copy.drawImage(canvas, 0, 0);
        return copy.getImageData(0, 0, canvas.width, canvas.height).data;
      };
      const [a, b] = [read(viewer.canvas), read(document.querySelector('#original'))];
      for (const layer of globalThis.tracecutStudio.app.layers) layer.isOn = layer.wasOn;
      return a.reduce((sum, value, k) => sum + Math.abs(value - b[k]), 0) / a.length;
    });
    // A shift by one pixel makes more than 3.
    assert.ok(same < 1, `the two differ by ${same} in the mean`);
    await page.check('[name="view"][value="overlay"]', { force: true });
    await page.keyboard.press('0');
    await page.keyboard.press('w');
    await page.waitForFunction(() => document.fullscreenElement?.id === 'stage');
    // The page hears of it a moment later.
    await page.waitForSelector('#fill-screen[aria-pressed="true"]');
    await screenshot(page, 'fullscreen');
    await page.keyboard.press('w');
    await page.waitForFunction(() => document.fullscreenElement === null);
    assert.deepEqual(faults, []);
  });

  test('two fingers enlarge and move it', async () => {
    const { page } = sample;
    const zoomed = await page.evaluate(() => {
      const { viewer } = globalThis.tracecutStudio.app;
      const box = viewer.canvas.getBoundingClientRect();
      const fingers = (name, apart) => {
        const [x, y] = [box.left + box.width / 2, box.top + box.height / 2];
        const touches = [-apart, apart].map(
          (by, identifier) => new Touch({ identifier, target: viewer.canvas, clientX: x + by, clientY: y }),
        );
        const event = new TouchEvent(name, { touches, cancelable: true, bubbles: true });
        viewer.canvas.dispatchEvent(event);
        return event.defaultPrevented;
      };
      const taken = [fingers('touchstart', 40), fingers('touchmove', 80), fingers('touchmove', 100)];
      viewer.canvas.dispatchEvent(new TouchEvent('touchend', { touches: [] }));
      const { scale, x } = viewer.zoom;
      return { taken, scale, middle: x + 0.5 / scale };
    });
    assert.deepEqual(zoomed.taken, [true, true, true]);
    assert.ok(Math.abs(zoomed.scale - 2.5) < 0.01 && Math.abs(zoomed.middle - 0.5) < 0.01, JSON.stringify(zoomed));
    await page.keyboard.press('0');
  });
});

describe('the layers of a sample', () => {
  test('fades a layer, and shows its outlines without its fill', async () => {
    const { page } = sample;
    await openLook(page);
    await showOnly(page, 'masks');
    const alpha = () => page.evaluate(meanAlpha);
    const setting = (name, value) => page.locator(`[data-setting="masks.${name}"]`).fill(String(value));
    await setting('fill', 0.5);
    const whole = await alpha();
    await setting('opacity', 0.5);
    const faded = await alpha();
    assert.ok(Math.abs(faded / whole - 0.5) < 0.02, `half of ${whole} is ${faded}`);
    await setting('opacity', 0);
    assert.equal(await alpha(), 0);
    await setting('opacity', 1);
    await setting('fill', 0);
    const lines = await alpha();
    assert.ok(lines > 0 && lines < 0.5 * whole, `outlines ${lines} of ${whole}`);
    await showOnly(page);
  });

  test('the picture keeps its colours, but for the outlines', async () => {
    const { page } = sample;
    const changed = await page.evaluate(() => {
      const { viewer } = globalThis.tracecutStudio.app;
      viewer.draw();
      const { width, height } = viewer.canvas;
      const bytesOf = (picture) => {
        const context = new OffscreenCanvas(width, height).getContext('2d');
        context.imageSmoothingQuality = 'high';
        context.drawImage(picture, 0, 0, width, height);
        return context.getImageData(0, 0, width, height).data;
      };
      const [shown, frame] = [viewer.canvas, viewer.view.image].map(bytesOf);
      const differs = (p) => [0, 1, 2].some((c) => Math.abs(shown[4 * p + c] - frame[4 * p + c]) > 8);
      let count = 0;
      for (let p = 0; p < width * height; p += 1) count += differs(p) ? 1 : 0;
      return count / (width * height);
    });
    assert.ok(changed > 0.001 && changed < 0.1, `${changed} of the picture changed`);
  });
});

describe('views and words', () => {
  test('the original stands beside the result, or under a slider that the keyboard moves', async () => {
    const { page } = sample;
    const boxes = () =>
      page.evaluate(() =>
        ['original', 'canvas'].map((id) => document.getElementById(id).getBoundingClientRect().toJSON()),
      );
    await page.keyboard.press('v');
    await page.waitForFunction(() => document.querySelector('#screen').dataset.view === 'beside');
    const [left, right] = await boxes();
    assert.ok(
      left.right <= right.left && Math.abs(left.width - right.width) < 1 && left.width > 200,
      JSON.stringify([left, right]),
    );
    const differ = await page.evaluate(() => {
      const [a, b] = ['original', 'canvas'].map((id) => document.getElementById(id).toDataURL());
      return a.length > 10000 && a !== b;
    });
    assert.ok(differ);
    await page.keyboard.press('v');
    const [under, over] = await boxes();
    assert.deepEqual(under, over);
    await page.focus('#split');
    await page.keyboard.press('Home');
    const clip = await page.evaluate(() => getComputedStyle(document.querySelector('#original')).clipPath);
    assert.match(clip, /^inset\(0px 100% 0px 0px\)$|^inset\(0px calc\(100%\) 0px 0px\)$/);
    await page.check('[name="view"][value="overlay"]', { force: true });
    assert.equal(await page.locator('#original').isVisible(), false);
  });

  test('each object has a lane, and a click in it seeks', async () => {
    const { page } = sample;
    const lanes = await page.locator('.lane').count();
    assert.equal(lanes, await page.evaluate(() => globalThis.tracecutStudio.result.objects.length));
    const box = await page.locator('[data-lane="1"] .lane-canvas').boundingBox();
    await page.mouse.click(box.x + (box.width * 12.5) / SMALL.frames, box.y + box.height / 2);
    assert.equal(await text(page, '#counter'), `13 / ${SMALL.frames}`);
    await page.click('[data-lane="1"] .lane-name');
    const peak = await page.evaluate(() => globalThis.tracecutStudio.app.segmentation.presence.facts(1).peak);
    assert.equal(await text(page, '#counter'), `${peak + 1} / ${SMALL.frames}`);
  });

  test('a question mark lists the keys; while the list is open they do nothing else', async () => {
    const { page } = sample;
    const before = await picture(page);
    await page.keyboard.press('?');
    await page.waitForSelector('#help[open]');
    await page.keyboard.press('1');
    await page.keyboard.press('Escape');
    assert.equal(await page.locator('#help').isVisible(), false);
    assert.equal(await picture(page), before);
    assert.equal(await page.evaluate(() => document.body.dataset.phase), 'done');
  });
});

describe('the page', () => {
  test('is driven by keys', async () => {
    const { page } = sample;
    const counter = () => text(page, '#counter');
    await page.keyboard.press('Home');
    assert.equal(await counter(), `1 / ${SMALL.frames}`);
    await page.keyboard.press('ArrowRight');
    assert.equal(await counter(), `2 / ${SMALL.frames}`);
    await page.keyboard.press('End');
    assert.equal(await counter(), `${SMALL.frames} / ${SMALL.frames}`);
    await page.keyboard.press('ArrowRight');
    assert.equal(await counter(), `1 / ${SMALL.frames}`, 'looping');
    await page.keyboard.press('ArrowLeft');
    await page.keyboard.press('Home');
    assert.equal(await counter(), `1 / ${SMALL.frames}`);
    await page.keyboard.press(' ');
    await page.waitForFunction(() => globalThis.tracecutStudio.app.timeline.frame > 2);
    await page.keyboard.press(' ');
    assert.equal(await page.getAttribute('#play', 'aria-label'), 'Play');
    await page.keyboard.press('1');
    assert.equal(await page.locator('[data-layer="masks"]').isChecked(), false);
    await page.keyboard.press('1');
    assert.equal(await page.locator('[data-layer="masks"]').isChecked(), true);
  });

  test('leaves the space bar to a button that was reached by keyboard, and to no other', async () => {
    const { page } = sample;
    const playing = () => page.evaluate(() => globalThis.tracecutStudio.app.timeline.playing);
    await page.click('[data-object="1"] .keep');
    await page.keyboard.press('1');
    await page.keyboard.press('1');
    await page.keyboard.press(' ');
    assert.equal(await playing(), true, 'after a click the space bar plays');
    assert.equal(await page.locator('#show-all').isVisible(), true, 'and the object stays hidden');
    await page.keyboard.press(' ');
    await page.focus('[data-object="1"] .object-main');
    await page.keyboard.press('Tab');
    await page.keyboard.press(' ');
    assert.equal(await playing(), false);
    assert.equal(await page.locator('#show-all').isVisible(), false, 'the button under the focus was pressed');
  });

  test('gives every control a name', async () => {
    const { page } = sample;
    const nameless = await page.evaluate(() => {
      const controls = [...document.querySelectorAll('button, input, select, canvas[role], [role="progressbar"]')];
      const named = (e) =>
        e.getAttribute('aria-label') || e.labels?.length || e.textContent.trim() || e.closest('[hidden]');
      return controls.filter((e) => !named(e)).map((e) => e.outerHTML);
    });
    assert.deepEqual(nameless, []);
    assert.match(await page.getAttribute('#canvas', 'aria-label'), /moving object/);
    assert.equal(await page.getAttribute('#canvas', 'aria-describedby'), 'frame-text');
    assert.match(await page.textContent('#frame-text'), /^Frame \d+ of 16, .*: .*Object 1 \(orange\)/);
    assert.match(await page.locator('#live').textContent(), /moving object/);
  });

  test('shows the stages and the finished share while it runs', async () => {
    const { page } = sample;
    await page.evaluate(() => {
      globalThis.heard = [];
      new MutationObserver(() => globalThis.heard.push(document.querySelector('#live').textContent)).observe(
        document.querySelector('#live'),
        { childList: true, characterData: true, subtree: true },
      );
      globalThis.lines = new Set();
      const line = document.querySelector('#subline');
      new MutationObserver(() => globalThis.lines.add(line.textContent)).observe(line, { childList: true });
    });
    await redo(page);
    await inPhase(page, 'done');
    const heard = await page.evaluate(() => globalThis.heard.join('\n'));
    assert.match(heard, /Reading frames/);
    assert.match(heard, /Tracking motion/);
    const lines = await page.evaluate(() => [...globalThis.lines].join('\n'));
    assert.match(lines, /^\d+%( · (about \d+\ss left|almost done))?$/m);
  });
});

describe('settings', () => {
  test('are chosen in a sheet, applied by “Redo”, and reset', async () => {
    const { page, faults } = sample;
    const choice = (value) => page.check(`[name="trajectory.gridStep"][value="${value}"]`, { force: true });
    const count = () => page.evaluate(() => globalThis.tracecutStudio.result.trajectories.count);
    const before = await count();
    assert.equal(await page.locator('#again').isVisible(), false);
    await openRedo(page);
    assert.equal(await page.locator('#redo input[type="range"]:visible').count(), 0, 'no numbers of the method');
    await choice(6);
    await page.click('#redo-close');
    assert.equal(await page.locator('#again').isVisible(), true);
    await redo(page);
    assert.equal(await ended(page), 'done');
    assert.equal(await page.locator('#again').isVisible(), false);
    const more = await count();
    assert.ok(more > 1.4 * before, `${more} trajectories at 6 px, ${before} at 8`);
    await openRedo(page);
    await choice('default');
    assert.equal(await page.locator('#settings-reset').isVisible(), false);
    await page.click('#redo-run');
    assert.equal(await ended(page), 'done');
    assert.equal(await count(), before);
    assert.deepEqual(faults, []);
  });

  test('of clips are not offered for still images', async () => {
    const { page } = sample;
    assert.equal(await run(page, [pngFile('plain.png', plainFrame(80, 60))]), 'done');
    await openRedo(page);
    assert.equal(await page.locator('#settings-list').isVisible(), false);
    assert.match(await page.getAttribute('#lab-open', 'href'), /lab/);
    await page.click('#redo-close');
    await page.click('#sample');
    assert.equal(await ended(page), 'done');
  });
});

/** Wider than the working size; fine stripes tell the two apart. */
const [WIDTH, HEIGHT, FRAMES] = [600, 72, 20];
const stripes = Array.from({ length: FRAMES }, (_, t) =>
  plainFrame(WIDTH, HEIGHT, (x, y) => {
    const inside = x >= 40 + 3 * t && x < 130 + 3 * t && y >= 16 && y < 56;
    const seed = Math.imul((inside ? x - 3 * t : x) + 733 * y + (inside ? 5 : 0), 2654435761) >>> 24;
    const value = inside ? 60 + (seed % 90) : x % 2 === 0 ? 90 + (seed % 60) : 140 + (seed % 60);
    return [value, value, 255 - value];
  }),
);

test('a frame that rests is as fine as the source, one that plays is not waited for', async () => {
  const { page, faults } = sample;
  const files = stripes.map((frame, t) => pngFile(`${String(t).padStart(3, '0')}.png`, frame));
  assert.equal(await run(page, files), 'done', await text(page, 'main'));
  const width = () => page.evaluate(() => globalThis.tracecutStudio.app.viewer.view.image?.width);
  // The picture of the frame before stays until the next one is drawn.
  const sharp = () =>
    page.waitForFunction((wide) => {
      const { viewer } = globalThis.tracecutStudio.app;
      viewer.draw();
      return viewer.view.image?.width === wide;
    }, WIDTH);
  const { stored } = await page.evaluate(() => ({ stored: globalThis.tracecutStudio.app.job.images.width }));
  assert.equal(stored, 480);
  for (const t of [0, 19, 7]) {
    await page.evaluate((frame) => globalThis.tracecutStudio.app.timeline.seek(frame), t);
    await sharp();
    const colors = await page.evaluate(() => {
      const context = new OffscreenCanvas(600, 72).getContext('2d', { willReadFrequently: true });
      context.drawImage(globalThis.tracecutStudio.app.viewer.view.image, 0, 0);
      return [...context.getImageData(0, 0, 600, 72).data];
    });
    assert.deepEqual(Buffer.from(colors), Buffer.from(stripes[t].data), `frame ${t}`);
  }
  await screenshot(page, 'sharp');
  await page.click('#play');
  await page.waitForFunction(() => globalThis.tracecutStudio.app.viewer.view.frame > 9);
  assert.equal(await width(), 480);
  await page.click('#play');
  await sharp();
  assert.deepEqual(faults, []);
});

/** Runs in the page: the mean opacity of the canvas, 0 to 1. */
function meanAlpha() {
  const { viewer } = globalThis.tracecutStudio.app;
  viewer.draw();
  const { data } = viewer.canvas.getContext('2d').getImageData(0, 0, viewer.canvas.width, viewer.canvas.height);
  let sum = 0;
  for (let at = 3; at < data.length; at += 4) sum += data[at];
  return sum / 255 / (data.length / 4);
}
