// Frames of video files: each once, in order, with its own time.

import assert from 'node:assert/strict';
import { existsSync } from 'node:fs';
import { join } from 'node:path';
import { describe, test } from 'node:test';
import { onlyLong, sharedClips } from './support.mjs';
import { giveFile, useLibrary } from './video-support.mjs';

const CLIPS = [
  { name: 'dashcam-cars-38f.mp4', frames: 38, rate: 25, width: 1280, height: 720 },
  { name: 'dashcam-lane-221f.mp4', frames: 221, rate: 25, width: 960, height: 540 },
  { name: 'static-camera-cars-377f.mp4', frames: 377, rate: 12.5, width: 768, height: 432 },
];

const upTo = (count) => Array.from({ length: count }, (_, k) => k);

/** Times that containers round to their own units. */
function assertTimes(found, expected, tolerance = 0.0006) {
  assert.equal(found.length, expected.length, `${found.length} times, not ${expected.length}`);
  found.forEach((time, k) =>
    assert.ok(Math.abs(time - expected[k]) <= tolerance, `frame ${k} at ${time} s, not ${expected[k]} s`),
  );
}

const library = useLibrary();

describe('clips from outside', { timeout: 240_000 }, () => {
  for (const [k, { name, frames, rate, width, height }] of CLIPS.entries()) {
    const path = join(sharedClips, name);
    const { skip } = existsSync(path) ? (k > 0 ? onlyLong : {}) : { skip: `${path} is not here` };

    test(`${name}: ${frames} frames at the times that its container says`, { skip }, async () => {
      const { page } = library;
      await giveFile(page, path);
      const info = await page.evaluate(() => tracecut.videoInfo(file));
      assert.deepEqual(
        [info.width, info.height, info.numFrames, info.frameRate, info.decodable],
        [width, height, frames, rate, true],
      );
      assert.ok(Math.abs(info.duration - frames / rate) < 1e-6, `${info.duration} s`);
      assert.match(info.codec, /^avc1\./);
      const seen = await page.evaluate(() => numbersOf(file, { size: 64 }));
      assertTimes(
        seen.times,
        upTo(frames).map((k) => k / rate),
        1e-6,
      );
      assert.deepEqual(seen.indices, upTo(frames));
      assert.ok(
        seen.durations.every((duration) => Math.abs(duration - 1 / rate) < 1e-6),
        seen.durations.join(),
      );
    });
  }
});

describe('clips made on the spot', { timeout: 240_000 }, () => {
  test('every frame comes once and in order, from WebM and MP4', async () => {
    const { page } = library;
    for (const kind of [
      { container: 'WebM', codec: 'vp8' },
      { container: 'Mp4', codec: 'vp9' },
    ]) {
      const seen = await page.evaluate(
        async (made) => numbersOf(await makeClip({ times: evenTimes(30, 25), ...made })),
        kind,
      );
      assert.deepEqual(seen.numbers, upTo(30), kind.container);
      assertTimes(
        seen.times,
        upTo(30).map((k) => k / 25),
      );
    }
  });

  test('frames that last unequally long keep their times', async () => {
    const { page } = library;
    const times = [0, 0.02, 0.1, 0.13, 0.5, 0.52, 0.6, 1.2, 1.24];
    const seen = await page.evaluate(async (at) => numbersOf(await makeClip({ times: at })), times);
    assert.deepEqual(seen.numbers, upTo(times.length));
    assertTimes(seen.times, times);
    assertTimes(
      seen.durations,
      [...times.slice(1), 1.28].map((time, k) => time - times[k]),
      0.0012,
    );
  });

  test('start is in, end is out, step and maxFrames count the frames between', async () => {
    const { page } = library;
    const cases = [
      [{ start: 0.4, end: 0.8 }, [10, 11, 12, 13, 14, 15, 16, 17, 18, 19]],
      [{ start: 0.41, end: 0.56 }, [11, 12, 13]],
      [{ start: 0.4, step: 7 }, [10, 17, 24]],
      [{ step: 10 }, [0, 10, 20]],
      [{ maxFrames: 3 }, [0, 1, 2]],
      [{ start: 0.2, step: 2, maxFrames: 4 }, [5, 7, 9, 11]],
      [{ start: -1, end: 0.1 }, [0, 1, 2]],
      [{ start: 1.16 }, [29]],
    ];
    for (const [take, numbers] of cases) {
      const seen = await page.evaluate(
        async (options) =>
          numbersOf((globalThis.thirty ??= await makeClip({ times: evenTimes(30, 25), keyEvery: 10 })), options),
        take,
      );
      assert.deepEqual(seen.numbers, numbers, JSON.stringify(take));
      assert.deepEqual(seen.indices, upTo(numbers.length));
    }
  });

  test('size is the long side; frames are never enlarged', async () => {
    const { page } = library;
    const sizes = await page.evaluate(async () => {
      const clip = await makeClip({ times: evenTimes(2, 25), width: 160, height: 90 });
      return Promise.all([undefined, 80, 100, 500].map(async (size) => (await numbersOf(clip, { size })).size));
    });
    assert.deepEqual(sizes, ['160x90', '80x45', '100x56', '160x90']);
  });

  test('a canvas draws frames as they come, whatever their size; each is there until the next', async () => {
    const seen = await library.page.evaluate(async () => {
      const clip = await makeClip({ times: evenTimes(4, 25) });
      const found = [];
      for (const size of [undefined, 64]) {
        const kept = [];
        for await (const { frame, width, height, pixels } of tracecut.videoFrames(clip, { size })) {
          const context = new OffscreenCanvas(width, height).getContext('2d', { willReadFrequently: true });
          context.drawImage(frame, 0, 0);
          const numbers = [context.getImageData(0, 0, width, height), await pixels()].map(numberOf);
          found.push([frame instanceof VideoFrame, frame.displayWidth === width, ...numbers]);
          kept.push(frame);
        }
        found.push(kept.every(({ format }) => format === null));
      }
      return found;
    });
    const frames = [0, 1, 2, 3].map((k) => [true, true, k, k]);
    assert.deepEqual(seen, [...frames, true, ...frames, true]);
  });

  test('a clip filmed upright comes as it is shown', async () => {
    const { page } = library;
    const seen = await page.evaluate(async () => {
      const turned = await makeClip({ times: evenTimes(3, 25), container: 'Mp4', codec: 'vp9', rotation: 90 });
      const frames = tracecut.videoFrames(turned);
      const { value } = await frames.next();
      const edge = redEdge(await value.pixels());
      await frames.return();
      const { width, height } = await tracecut.videoInfo(turned);
      return { size: [value.width, value.height], info: [width, height], edge };
    });
    assert.deepEqual(seen, { size: [64, 128], info: [64, 128], edge: 'top' });
  });

  test('a recording whose length is not written in the file', async () => {
    const { page } = library;
    const seen = await page.evaluate(async () => {
      const canvas = Object.assign(document.createElement('canvas'), { width: 128, height: 64 });
      const context = canvas.getContext('2d');
      const recorder = new MediaRecorder(canvas.captureStream(), { mimeType: 'video/webm;codecs=vp8' });
      const parts = [];
      recorder.ondataavailable = (event) => parts.push(event.data);
      recorder.start();
      for (let k = 0; k < 10; k += 1) {
        drawNumber(context, k);
        await new Promise((resolve) => setTimeout(resolve, 60));
      }
      await new Promise((resolve) => ((recorder.onstop = resolve), recorder.stop()));
      const recording = new Blob(parts);
      return { ...(await numbersOf(recording)), info: await tracecut.videoInfo(recording) };
    });
    assert.ok(seen.numbers.length >= 5, seen.numbers.join());
    assert.deepEqual(
      seen.numbers,
      [...seen.numbers].sort((a, b) => a - b),
    );
    assert.equal(seen.info.numFrames, seen.numbers.length);
  });

  test('no frame is left open, and nothing is complained about', async () => {
    await library.page.evaluate(() => globalThis.gc?.());
    assert.deepEqual(library.faults, []);
  });
});
