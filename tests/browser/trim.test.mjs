// The filmstrip: what is in it, its handles by keyboard, pointer and finger, and the clip that plays without a run.

import assert from 'node:assert/strict';
import { describe, test } from 'node:test';
import {
  accessibilityFaults,
  ended,
  gifFile,
  inPhase,
  openSample,
  plainFrame,
  pngFile,
  screenshot,
  text,
  useSite,
} from './support.mjs';
import { useLibrary } from './video-support.mjs';

/** Runs in the page: a video of `count` frames, each in one colour that says its number. */
async function makeVideo(count) {
  const media = await import('/dist/vendor/media.js');
  const output = new media.Output({ format: new media.WebMOutputFormat(), target: new media.BufferTarget() });
  const source = new media.VideoSampleSource({ codec: 'vp8', bitrate: 1e6, keyFrameInterval: 1 });
  output.addVideoTrack(source);
  await output.start();
  const context = new OffscreenCanvas(128, 64).getContext('2d');
  for (let k = 0; k < count; k += 1) {
    context.fillStyle = `rgb(${8 * k}, 90, 90)`;
    context.fillRect(0, 0, 128, 64);
    const sample = new media.VideoSample(context.canvas, { timestamp: k / 10, duration: 0.1 });
    await source.add(sample);
    sample.close();
  }
  await output.finalize();
  return [...new Uint8Array(output.target.buffer)];
}

async function videoFile(page, count) {
  const bytes = await page.evaluate(makeVideo, count);
  return { name: 'colours.webm', mimeType: 'video/webm', buffer: Buffer.from(bytes) };
}

const drawn = (page) => page.waitForFunction(() => document.querySelector('#trim-strip').dataset.ready);
const take = (page) => page.evaluate(() => globalThis.tracecutStudio.take);

describe('the strip of a video file', () => {
  const library = useLibrary();

  test('has the frames in the middle of equal parts', async () => {
    const seen = await library.page.evaluate(async () => {
      const clip = await makeClip({ times: evenTimes(60, 25), keyEvery: 20 });
      const numbers = [];
      for await (const { width, pixels, time, duration } of tracecut.videoStrip(clip, { count: 6, size: 64 }))
        numbers.push([numberOf(await pixels()), Math.round(25 * time), Math.round(25 * duration), width]);
      return numbers;
    });
    assert.deepEqual(
      seen,
      [5, 15, 25, 35, 45, 55].map((k) => [k, k, 1, 64]),
    );
  });
});

describe('the filmstrip of the page', () => {
  const site = useSite({ sample: 'tiny' });

  test('shows the clip; the handles select the range by keyboard and by pointer, and times stay', async () => {
    const { page, faults } = await openSample(site, { bypassCSP: true });
    assert.equal(await page.locator('#trim').isVisible(), false, 'the sample is not trimmed');
    await page.setInputFiles('#file', [await videoFile(page, 30)]);
    await drawn(page);
    assert.equal(await ended(page), 'done');
    const reds = await page.evaluate(() =>
      [...document.querySelectorAll('#trim-strip canvas')].map(
        (canvas) => canvas.getContext('2d').getImageData(9, 9, 1, 1).data[0],
      ),
    );
    assert.equal(reds.length, 12);
    assert.ok(
      reds.every((red, k) => k === 0 || red > reds[k - 1]),
      reds.join(),
    );
    assert.match(await text(page, '#trim-text'), /^Whole clip, 3\.0\ss$/);
    assert.equal(await page.locator('#trim-run').isVisible(), false);

    await page.focus('#trim-from');
    for (let press = 0; press < 5; press += 1) await page.keyboard.press('ArrowRight');
    assert.equal(await page.locator('#preview').isVisible(), true, 'the frame under the handle is shown');
    assert.match(await page.getAttribute('#trim-from', 'aria-valuetext'), /^0\.5\ss$/);
    await page.keyboard.press('Tab');
    const box = await page.locator('#trim-box').boundingBox();
    await page.mouse.move(box.x + box.width - 10, box.y + box.height / 2);
    await page.mouse.down();
    await page.mouse.move(box.x + box.width * 0.6, box.y + box.height / 2, { steps: 6 });
    await page.mouse.up();
    assert.equal(await page.locator('#preview').isVisible(), false, 'the result is back');
    const last = Number(await page.inputValue('#trim-to'));
    assert.ok(last > 14 && last < 20, `${last}`);
    assert.match(await text(page, '#trim-text'), /^0\.5–1\.\d\ss of 3\.0\ss$/);
    assert.equal(await text(page, '#trim-run'), 'Run this part');
    assert.deepEqual(await accessibilityFaults(page), []);
    await screenshot(page, 'trim');
    await page.click('#trim-run');
    assert.equal(await ended(page), 'done');
    assert.deepEqual(await take(page), { start: 5, frames: last - 4, step: 1, side: 480 });
    const times = await page.evaluate(() => globalThis.tracecutStudio.app.job.times);
    assert.deepEqual(
      times.map((time) => Math.round(10 * time)),
      Array.from({ length: last - 4 }, (_, k) => k + 5),
    );
    assert.equal(await page.locator('#trim-run').isVisible(), false);
    await page.click('#trim-all');
    assert.equal(await text(page, '#trim-run'), 'Run the whole clip');
    assert.deepEqual(faults, []);
  });

  test('the handles never meet, and a run under way follows them, also where it is over sooner', async () => {
    for (const count of [30, 4]) {
      const { page } = await openSample(site);
      // The moment that a run is under way the page itself moves the handle: from here it might be over.
      await page.evaluate(() => {
        const moved = new MutationObserver(() => {
          if (document.body.dataset.phase !== 'running') return;
          moved.disconnect();
          const handle = document.querySelector('#trim-to');
          handle.value = '0';
          for (const kind of ['input', 'change']) handle.dispatchEvent(new Event(kind, { bubbles: true }));
        });
        moved.observe(document.body, { attributeFilter: ['data-phase'] });
      });
      await page.setInputFiles('#file', [await videoFile(page, count)]);
      await page.waitForFunction(
        () => globalThis.tracecutStudio.take?.frames === 2 && document.body.dataset.phase === 'done',
      );
      assert.equal(await page.inputValue('#trim-to'), '1');
      await page.context().close();
    }
  });

  test('the clip plays without a run, a video by its player and images one by one', async () => {
    const { page, faults } = await openSample(site);
    await page.setInputFiles('#file', [await videoFile(page, 30)]);
    await drawn(page);
    // What is found takes the screen from the clip.
    await inPhase(page, 'done');
    await page.click('#trim-play');
    assert.equal(await page.getAttribute('#trim-play', 'aria-label'), 'Stop the clip');
    await page.waitForFunction(() => document.querySelector('#preview video')?.currentTime > 0.15);
    await page.keyboard.press('p');
    assert.equal(await page.locator('#preview').isVisible(), false);
    assert.equal(await page.getAttribute('#trim-play', 'aria-label'), 'Play the clip');

    const frames = Array.from({ length: 6 }, (_, k) => plainFrame(64, 32, () => [20 + 30 * k, 90, 90]));
    for (const files of [frames.map((frame, k) => pngFile(`f${k}.png`, frame)), [gifFile('six.gif', frames)]]) {
      await page.setInputFiles('#file', files);
      await drawn(page);
      assert.equal(await ended(page), 'done');
      await page.focus('#trim-play');
      await page.keyboard.press('Enter');
      const seen = new Set();
      while (seen.size < 4) {
        await page.waitForFunction(() => document.querySelector('#preview canvas')?.width === 64);
        seen.add(
          await page.evaluate(
            () => document.querySelector('#preview canvas').getContext('2d').getImageData(3, 3, 1, 1).data[0],
          ),
        );
      }
      await page.click('#trim-play');
      assert.equal(await page.locator('#preview').isVisible(), false);
    }
    // The test itself reads the canvas again and again.
    assert.deepEqual(
      faults.filter((fault) => !fault.includes('willReadFrequently')),
      [],
    );
  });

  test('fits a phone, with handles for fingers', async () => {
    const phone = { viewport: { width: 390, height: 844 }, isMobile: true, hasTouch: true, bypassCSP: true };
    const { page } = await openSample(site, phone);
    await page.setInputFiles('#file', [await videoFile(page, 30)]);
    await drawn(page);
    assert.equal(await ended(page), 'done');
    const box = await page.locator('#trim-box').boundingBox();
    assert.ok(box.height >= 44, `${box.height}`);
    const touch = await page.context().newCDPSession(page);
    await page.locator('#trim-box').scrollIntoViewIfNeeded();
    const { x, width, y } = await page.locator('#trim-box').boundingBox();
    const point = (share) => [{ x: x + 10 + share * (width - 20), y: y + 22 }];
    await touch.send('Input.dispatchTouchEvent', { type: 'touchStart', touchPoints: point(0) });
    for (const share of [0.1, 0.2, 0.3])
      await touch.send('Input.dispatchTouchEvent', { type: 'touchMove', touchPoints: point(share) });
    await touch.send('Input.dispatchTouchEvent', { type: 'touchEnd', touchPoints: [] });
    await page.waitForFunction(() => Number(document.querySelector('#trim-from').value) > 5);
    assert.equal(await page.evaluate(() => document.documentElement.scrollWidth <= innerWidth), true);
    assert.deepEqual(await accessibilityFaults(page), []);
    await screenshot(page, 'trim-phone');
  });
});
