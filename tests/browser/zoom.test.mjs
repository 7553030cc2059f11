// Looking closer at the picture: wheel, fingers, keys, buttons; places and clicks stay true.

import assert from 'node:assert/strict';
import { describe, test } from 'node:test';
import { accessibilityFaults, openSample, screenshot, text, useSite } from './support.mjs';

describe('the canvas', () => {
  const site = useSite();
  let page;
  let faults;

  const state = () =>
    page.evaluate(() => {
      const { by, x, y } = globalThis.tracecutStudio.app.viewer.zoom;
      return { by, x, y };
    });
  /** Where a clip pixel is on screen, and the clip pixel at a place of the canvas. */
  const placeAt = (offsetX, offsetY) =>
    page.evaluate((place) => globalThis.tracecutStudio.app.viewer.placeAt(place), { offsetX, offsetY });

  test('is enlarged about the pointer by the wheel, and moved by dragging', async () => {
    ({ page, faults } = await openSample(site, { bypassCSP: true }));
    const box = await page.locator('#canvas').boundingBox();
    const [offsetX, offsetY] = [Math.round(box.width * 0.7), Math.round(box.height * 0.4)];
    const before = await placeAt(offsetX, offsetY);
    await page.mouse.move(box.x + offsetX, box.y + offsetY);
    for (let k = 0; k < 5; k += 1) await page.mouse.wheel(0, -100);
    await page.waitForFunction(() => globalThis.tracecutStudio.app.viewer.zoom.by > 3);
    const after = await placeAt(offsetX, offsetY);
    assert.ok(Math.hypot(after[0] - before[0], after[1] - before[1]) < 1.5, `${before} ${after}`);
    assert.equal(await text(page, '#zoom-fit'), '305\u00a0%');
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

  test('what is clicked and drawn is what is there, also enlarged', async () => {
    await page.evaluate(() => globalThis.tracecutStudio.app.timeline.seek(12));
    const spot = await page.evaluate(() => {
      const { viewer, points } = globalThis.tracecutStudio.app;
      const { width, height } = points.result;
      const mask = points.mask(12);
      const inside = mask.findIndex((label, p) =>
        label === 2 ? [-4, 4].every((d) => mask[p + d] === 2 && mask[p + d * width] === 2) : false,
      );
      const [x, y] = [inside % width, Math.floor(inside / width)];
      viewer.enlarge(1, 0.5, 0.5);
      viewer.enlarge(4, x / width, y / height);
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
    await page.mouse.click(...spot.at);
    assert.equal(await page.getAttribute('[data-object="2"] .object-main', 'aria-pressed'), 'true');
    await page.click('#show-all');
  });

  test('keys and buttons do it too, and the original goes with the result', async () => {
    await page.keyboard.press('0');
    assert.deepEqual(await state(), { by: 1, x: 0, y: 0 });
    assert.equal(await page.locator('#zoom-out').isDisabled(), true);
    await page.keyboard.press('+');
    await page.keyboard.press('+');
    await page.click('#zoom-in');
    const { by, x } = await state();
    assert.ok(Math.abs(by - 1.25 ** 3) < 1e-9);
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
        layer.wasOn = layer.on;
        layer.on = layer.id === 'image';
        if (layer.id === 'image') layer.settings.color.value = 1;
      }
      viewer.draw();
      const read = (canvas) => {
        const copy = new OffscreenCanvas(canvas.width, canvas.height).getContext('2d', { willReadFrequently: true });
        copy.drawImage(canvas, 0, 0);
        return copy.getImageData(0, 0, canvas.width, canvas.height).data;
      };
      const [a, b] = [read(viewer.canvas), read(document.querySelector('#original'))];
      for (const layer of globalThis.tracecutStudio.app.layers) layer.on = layer.wasOn;
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
    const { page: phone } = await openSample(site, { viewport: { width: 390, height: 844 }, hasTouch: true });
    const zoomed = await phone.evaluate(() => {
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
      const { by, x } = viewer.zoom;
      return { taken, by, middle: x + 0.5 / by };
    });
    assert.deepEqual(zoomed.taken, [true, true, true]);
    assert.ok(Math.abs(zoomed.by - 2.5) < 0.01 && Math.abs(zoomed.middle - 0.5) < 0.01, JSON.stringify(zoomed));
    await screenshot(phone, 'zoomed-phone');
  });
});
