// Files that end in damage: with `onDamage` the frames before it come, and the page runs with them.

import assert from 'node:assert/strict';
import { describe, test } from 'node:test';
import {
  SMALL,
  accessibilityFaults,
  bytesOf,
  ended,
  gifFile,
  openSample,
  openSave,
  plainFrame,
  pngFile,
  run,
  screenshot,
  text,
  useSite,
} from './support.mjs';
import { useLibrary } from './video-support.mjs';

const upTo = (count) => Array.from({ length: count }, (_, k) => k);

/** Runs in the page: what comes of the first part of a clip that is made there, with `onDamage`. */
async function cutClip({ made, share, scrambled = false, options = {} }) {
  const whole = await makeClip({ times: evenTimes(40, 25), ...made });
  const bytes = new Uint8Array(await whole.arrayBuffer());
  const at = Math.floor(share * bytes.length);
  if (scrambled) for (let k = at; k < at + 400; k += 1) bytes[k] = (37 * k) & 255;
  const file = new Blob([scrambled ? bytes : bytes.slice(0, at)]);
  const found = { numbers: [], damage: null, plain: null };
  const onDamage = ({ frames, total, error }) => (found.damage = { frames, total, code: error.code });
  for await (const { pixels } of tracecut.videoFrames(file, { ...options, onDamage }))
    found.numbers.push(numberOf(await pixels()));
  return found;
}

describe('frames before the damage', { timeout: 240_000 }, () => {
  const library = useLibrary();

  for (const made of [
    { container: 'Mp4', codec: 'vp9', keyEvery: 1 },
    { container: 'WebM', codec: 'vp8', keyEvery: 1 },
    { container: 'WebM', codec: 'vp9', keyEvery: 0.2 },
  ]) {
    test(`of a ${made.container} file with ${made.codec} that is cut off`, async () => {
      for (const share of [0.6, 0.9]) {
        const { numbers, damage } = await library.page.evaluate(cutClip, { made, share });
        assert.ok(numbers.length >= 36 * share - 6 && numbers.length < 40, `${numbers.length} frames at ${share}`);
        assert.deepEqual(numbers, upTo(numbers.length));
        assert.equal(damage.code, 'truncated');
        assert.equal(damage.frames, numbers.length);
      }
    });
  }

  test('of a file that is damaged in the middle, where the decoder notices', async () => {
    const made = { container: 'Mp4', codec: 'vp9', keyEvery: 1 };
    const { numbers, damage } = await library.page.evaluate(cutClip, { made, share: 0.6, scrambled: true });
    assert.ok(numbers.length > 15 && numbers.length < 40, `${numbers.length}`);
    assert.deepEqual(damage, { frames: numbers.length, total: 40, code: 'truncated' });
  });

  test('none is told of where what is taken ends before it, or nothing is wrong', async () => {
    const made = { container: 'WebM', codec: 'vp8', keyEvery: 1 };
    const taken = await library.page.evaluate(cutClip, { made, share: 0.6, options: { maxFrames: 5 } });
    assert.deepEqual([taken.numbers, taken.damage], [upTo(5), null]);
    const whole = await library.page.evaluate(cutClip, { made, share: 1 });
    assert.deepEqual([whole.numbers, whole.damage], [upTo(40), null]);
  });

  test('of a clip that is segmented: the result has their masks', async () => {
    const { numFrames, damage } = await library.page.evaluate(async () => {
      const whole = await makeClip({ times: evenTimes(30, 25), container: 'Mp4', codec: 'vp9' });
      let damage = null;
      const video = tracecut.segmentVideo(whole.slice(0, 0.6 * whole.size), {
        size: 64,
        window: 12,
        overlap: 3,
        onDamage: ({ frames, total }) => (damage = { frames, total }),
      });
      return { numFrames: (await video.collect()).numFrames, damage };
    });
    assert.ok(numFrames > 9 && numFrames < 30, `${numFrames}`);
    assert.deepEqual(damage, { frames: numFrames, total: 30 });
  });

  test('of an animated GIF; the facts are of these too, and without the option it is an error', async () => {
    const { buffer } = gifFile(
      'x.gif',
      upTo(20).map((k) => plainFrame(64, 32, () => [10 * k, 0, 0])),
    );
    const seen = await library.page.evaluate(
      async (bytes) => {
        const file = new Blob([new Uint8Array(bytes)], { type: 'image/gif' });
        const reds = [];
        let damage = null;
        const onDamage = ({ frames, error }) => (damage = { frames, code: error.code });
        for await (const { pixels } of tracecut.videoFrames(file, { onDamage })) reds.push((await pixels()).data[0]);
        const { numFrames } = await tracecut.videoInfo(file, { onDamage });
        return { reds, damage, numFrames, fault: await failure(tracecut.videoInfo(file)) };
      },
      [...buffer.subarray(0, Math.floor(0.6 * buffer.length))],
    );
    assert.ok(seen.reds.length > 9 && seen.reds.length < 13, `${seen.reds.length}`);
    assert.deepEqual(seen.damage, { frames: seen.reds.length, code: 'truncated' });
    assert.equal(seen.numFrames, seen.reds.length);
    assert.equal(seen.fault.code, 'truncated');
  });
});

describe('the page runs with the frames before the damage', () => {
  const site = useSite();
  const texture = (x, y) =>
    60 + (((Math.imul((x >> 1) + 7, 374761393) ^ Math.imul((y >> 1) + 3, 668265263)) >>> 0) % 160);
  const frames = upTo(10).map((t) =>
    plainFrame(96, 64, (x, y) => {
      const inside = x >= 12 + 2 * t && x < 40 + 2 * t && y >= 16 && y < 48;
      const value = inside ? texture(x - 2 * t, y + 90) : texture(x, y);
      return [value, value, inside ? 255 - value : value];
    }),
  );

  test('a folder with a damaged PNG, and a GIF that is cut off', async () => {
    const { page, faults } = await openSample(site, { bypassCSP: true });
    const files = frames.map((frame, k) => pngFile(`f${k}.png`, frame));
    files[6] = { ...files[6], buffer: files[6].buffer.subarray(0, 60) };
    assert.equal(await run(page, files), 'done');
    assert.match(await text(page, '#notice'), /^The file is cut off or damaged\. 6 of 10 frames come before that/);
    assert.match(await text(page, '#counter'), /\/ 6$/);
    assert.deepEqual(await accessibilityFaults(page), []);
    await screenshot(page, 'damage');
    const gif = gifFile('cut.gif', frames);
    assert.equal(await run(page, [{ ...gif, buffer: gif.buffer.subarray(0, 0.65 * gif.buffer.length) }]), 'done');
    assert.match(await text(page, '#notice'), /^The file is cut off or damaged\. [567] frames come before that/);
    assert.deepEqual(faults, []);
  });

  test('a video that is cut off; what is saved has as many frames', async () => {
    const { page } = await openSample(site);
    const bytes = await page.evaluate(async () => {
      const { source } = globalThis.tracecutStudio;
      const media = await import('/dist/vendor/media.js');
      const output = new media.Output({ format: new media.WebMOutputFormat(), target: new media.BufferTarget() });
      const video = new media.VideoSampleSource({ codec: 'vp8', bitrate: 4e5, keyFrameInterval: 0.2 });
      output.addVideoTrack(video);
      await output.start();
      for (let t = 0; t < source.count; t += 1) {
        const canvas = new OffscreenCanvas(source.width, source.height);
        canvas.getContext('2d').putImageData(await source.preview(t, source.width), 0, 0);
        const sample = new media.VideoSample(canvas, { timestamp: t / 5, duration: 1 / 5 });
        await video.add(sample);
        sample.close();
      }
      await output.finalize();
      const all = new Uint8Array(output.target.buffer);
      return [...all.subarray(0, Math.floor(0.7 * all.length))];
    });
    const file = { name: 'cut.webm', mimeType: 'video/webm', buffer: Buffer.from(bytes) };
    assert.equal(
      await run(page, [file]),
      'done',
      await page.evaluate(() => document.querySelector('#error').innerText),
    );
    const said = /^The file is cut off or damaged\. (\d+) frames/.exec(await text(page, '#notice'));
    assert.ok(said && Number(said[1]) >= 6 && Number(said[1]) < SMALL.frames, await text(page, '#notice'));
    await openSave(page);
    const [download] = await Promise.all([page.waitForEvent('download'), page.click('[data-export="coco"]')]);
    const coco = JSON.parse(await bytesOf(download));
    assert.equal(coco.images.length, Number(said[1]));
    await ended(page);
  });
});
