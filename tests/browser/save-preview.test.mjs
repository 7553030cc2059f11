// The frame on screen as it will be saved: what stands in the dialog is what stands in the file.

import assert from 'node:assert/strict';
import { describe, test } from 'node:test';
import { WIDE, fiveObjects } from './five-objects.mjs';
import { accessibilityFaults, bytesOf, exportAs, openSample, screenshot, useSite } from './support.mjs';

const CHOICES = ['transparent', 'green', 'blurred', 'zip'];

/** Opens the project of a clip with five objects, and the dialog at one of its frames. */
async function openAt(site, frame, options = {}, shape = WIDE) {
  const { page, faults } = await openSample(site, options);
  const { project } = await fiveObjects(page, shape);
  await page.setInputFiles('#file', [project]);
  await page.waitForFunction(
    () => globalThis.tracecutStudio.source?.name === 'five.webm' && document.body.dataset.state === 'done',
  );
  await openDialog(page, frame);
  return { page, faults };
}

async function openDialog(page, frame) {
  await page.evaluate((t) => globalThis.tracecutStudio.app.timeline.seek(t), frame);
  await page.evaluate(() => document.querySelector('#export-open').click());
  await page.waitForSelector('#export[open]');
}

/** Waits for the preview of a choice. */
function shown(page, id) {
  return page.waitForFunction((wanted) => {
    const { dataset, firstElementChild: one } = document.querySelector('#export-preview');
    return dataset.shows === wanted && dataset.waits === undefined && one && (one.naturalWidth || one.videoWidth);
  }, id);
}

/** Runs in the page: the pixels that the preview shows, over nothing. */
function previewPixels() {
  const one = document.querySelector('#export-preview').firstElementChild;
  const [width, height] = [one.videoWidth ?? one.naturalWidth, one.videoHeight ?? one.naturalHeight];
  const canvas = new OffscreenCanvas(width, height);
  const context = canvas.getContext('2d');
  context.drawImage(one, 0, 0);
  return { width, height, data: [...context.getImageData(0, 0, width, height).data] };
}

/** Runs in the page: the same of a frame of a file that was saved. */
async function savedPixels({ bytes, frame, type }) {
  const file = new Blob([new Uint8Array(bytes)], { type });
  const canvas = new OffscreenCanvas(1, 1);
  const draw = (one, width, height) => {
    Object.assign(canvas, { width, height });
    canvas.getContext('2d').drawImage(one, 0, 0);
  };
  if (type === 'application/zip') {
    const { unzipSync } = await import('/dist/vendor/zip.js');
    const files = unzipSync(new Uint8Array(bytes));
    const names = Object.keys(files).filter((name) => name.endsWith('.png'));
    const image = await createImageBitmap(new Blob([files[names.sort()[frame]]], { type: 'image/png' }));
    draw(image, image.width, image.height);
  } else {
    const video = document.createElement('video');
    Object.assign(video, { muted: true, src: URL.createObjectURL(file) });
    await new Promise((done) => video.addEventListener('loadeddata', done, { once: true }));
    const seeked = new Promise((done) => video.addEventListener('seeked', done, { once: true }));
    video.currentTime = (frame + 0.5) / 10;
    await seeked;
    draw(video, video.videoWidth, video.videoHeight);
  }
  const { width, height } = canvas;
  return { width, height, data: [...canvas.getContext('2d').getImageData(0, 0, width, height).data] };
}

/** How far two pictures are from each other: the mean over all bytes. */
function distance(a, b) {
  assert.deepEqual([a.width, a.height], [b.width, b.height]);
  return a.data.reduce((sum, value, k) => sum + Math.abs(value - b.data[k]), 0) / a.data.length;
}

describe('the preview of what is saved', () => {
  const site = useSite({ sample: 'tiny' });

  test('is what the file has, for each choice', async () => {
    const { page, faults } = await openAt(site, 5, { bypassCSP: true });
    const seen = {};
    for (const id of CHOICES) {
      await page.check(`[data-export="${id}"]`);
      await shown(page, id);
      seen[id] = await page.evaluate(previewPixels);
      assert.deepEqual([seen[id].width, seen[id].height], [WIDE.width, WIDE.height]);
      await screenshot(page, `preview-${id}`);
    }
    assert.match(await page.innerText('#export-preview-text'), /^Output: 480 × 270$/);
    assert.deepEqual(await accessibilityFaults(page), []);
    for (const [k, id] of CHOICES.entries()) {
      const coming = page.waitForEvent('download');
      await exportAs(page, id);
      const type = { transparent: 'video/webm', zip: 'application/zip' }[id] ?? 'video/mp4';
      const saved = await page.evaluate(savedPixels, { bytes: [...(await bytesOf(await coming))], frame: 5, type });
      await page.waitForFunction(() => /^Saved/.test(document.querySelector('#export-status').textContent));
      const [own, other] = [distance(seen[id], saved), distance(seen[CHOICES[(k + 1) % 4]], saved)];
      console.log(`${id}: ${own.toFixed(2)} from what is saved, ${other.toFixed(2)} from what another choice saves`);
      assert.ok(own < 3 && own < other / 4, `${id}: ${own}, ${other}`);
    }
    const corner = seen.transparent.data.slice(0, 4);
    assert.ok(corner[3] < 8, `${corner[3]}: transparent where there is no object`);
    assert.deepEqual(faults, []);
  });

  test('is never black, and the dialog does not jump from opening to the saved file', async () => {
    const { page, faults } = await openAt(site, 5);
    await page.keyboard.press('Escape');
    await page.evaluate(() => {
      globalThis.looks = [];
      const box = document.querySelector('#export-preview');
      /** Number of bright values of a picture: of the sketch, or of the preview if it came at once. */
      const bright = (picture) => {
        const context = new OffscreenCanvas(480, 270).getContext('2d');
        context.drawImage(picture, 0, 0, 480, 270);
        const { data } = context.getImageData(0, 0, 480, 270);
        return data.filter((value, at) => at % 4 < 3 && value > 60).length;
      };
      const look = () => {
        if (document.querySelector('#export').open) {
          globalThis.firstBright ??= bright(box.lastElementChild);
          const places = ['#export', '#export-main', '#export-run', '#export-cancel', '.export-foot']
            .map((selector) => document.querySelector(selector))
            .filter((one) => one.checkVisibility())
            .map((one) => one.id.replace(/run|cancel/, 'button') + one.getBoundingClientRect().top);
          globalThis.looks.push({ places: places.join(' '), isEmpty: box.childElementCount === 0 });
        }
        requestAnimationFrame(look);
      };
      look();
    });
    await page.click('#export-open');
    await page.waitForSelector('#export[open]');
    await shown(page, 'transparent');
    assert.ok(
      (await page.evaluate(() => globalThis.firstBright)) > 1000,
      'the objects are there from the first frame on',
    );
    for (const id of ['green', 'blurred']) {
      await page.check(`[data-export="${id}"]`);
      await shown(page, id);
    }
    assert.equal(await page.textContent('#export-status'), '', 'nothing is saved by choosing');
    const coming = page.waitForEvent('download');
    await page.click('#export-run');
    await coming;
    await page.waitForFunction(() => /^Saved/.test(document.querySelector('#export-status').textContent));
    const looks = await page.evaluate(() => globalThis.looks);
    assert.ok(looks.every(({ isEmpty }) => !isEmpty));
    assert.equal(
      new Set(looks.map(({ places }) => places)).size,
      1,
      [...new Set(looks.map((one) => one.places))].join(),
    );
    assert.match(await page.innerText('.card:has(:checked) .value'), /^480 × 270, 0\.8\ss, about [\d.]+\s[kKM]?B$/);
    assert.deepEqual(faults, []);
  });

  test('follows the frame and the settings, and shows true pixels that can be dragged', async () => {
    const { page } = await openAt(site, 0);
    await shown(page, 'transparent');
    const first = await page.evaluate(previewPixels);
    await page.keyboard.press('Escape');
    await openDialog(page, 7);
    await shown(page, 'transparent');
    assert.ok(distance(first, await page.evaluate(previewPixels)) > 2, 'another frame');
    await page.click('#export-actual-size');
    const wide = () => page.evaluate(() => document.querySelector('#export-preview > *').getBoundingClientRect().width);
    assert.equal(await wide(), WIDE.width / (await page.evaluate(() => devicePixelRatio)));
    await page.click('#export-preview');
    assert.equal(
      await page.getAttribute('#export-actual-size', 'aria-pressed'),
      'false',
      'a click shows the whole again',
    );
    await page.click('#export-more > summary');
    await page.selectOption('#export-size', 'half');
    await page.waitForFunction(() => /240 × 135/.test(document.querySelector('#export-preview-text').textContent));
    const half = await page.evaluate(previewPixels);
    assert.deepEqual([half.width, half.height], [240, 135]);
  });

  test('is true to the pixel where the clip is larger than the place', async () => {
    const { page } = await openAt(site, 2, {}, { width: 1280, height: 720, frames: 4 });
    await shown(page, 'transparent');
    const place = await page.locator('#export-preview').boundingBox();
    assert.ok(place.width < 800);
    await page.mouse.click(place.x + place.width / 4, place.y + place.height / 4);
    const look = () =>
      page.evaluate(() => {
        const box = document.querySelector('#export-preview');
        return { wide: box.firstElementChild.getBoundingClientRect().width, left: box.scrollLeft, top: box.scrollTop };
      });
    const before = await look();
    assert.equal(before.wide, 1280);
    // What was under the pointer stays there.
    assert.ok(Math.abs(before.left - (1280 - place.width) / 4) < 20, JSON.stringify(before));
    await page.mouse.move(place.x + 200, place.y + 200);
    await page.mouse.down();
    await page.mouse.move(place.x + 150, place.y + 160, { steps: 5 });
    await page.mouse.up();
    const after = await look();
    assert.deepEqual([after.wide, after.left - before.left, after.top - before.top].map(Math.round), [1280, 50, 40]);
    await page.focus('#export-preview');
    await page.keyboard.press('ArrowRight');
    await page.waitForFunction((left) => document.querySelector('#export-preview').scrollLeft > left, after.left);
  });
});
