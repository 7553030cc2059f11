// Frames of video files in Chromium: each once, in order, with its own time; segmented, nearly the masks of Node.

import { existsSync } from 'node:fs';
import { join } from 'node:path';
import { framesOfVideo } from '../../dist/node.js';
import { segmentVideo } from '../../dist/node/index.js';
import { root } from '../../scripts/tools.mjs';
import { expect, giveFile, test, useLibrary } from './fixtures.mjs';
import { range } from './page-helpers.mjs';
import { FILM, needsFfmpeg, useFilms } from './video-clips.mjs';

const CLIPS = [
  { name: 'dashcam-cars-38f.mp4', frames: 38, rate: 25, width: 1280, height: 720 },
  { name: 'dashcam-lane-221f.mp4', frames: 221, rate: 25, width: 960, height: 540 },
  { name: 'static-camera-cars-377f.mp4', frames: 377, rate: 12.5, width: 768, height: 432 },
];
const clipFolder = join(process.env.TRACECUT_SHARED ?? join(root, '..', 'shared'), 'data', 'clips');

// The page has `clip`: thirty numbered frames at 25 per second, every tenth a key frame.
const library = useLibrary((page) =>
  page.evaluate(async () => (globalThis.clip = await makeClip({ times: evenTimes(30, 25), keyEvery: 0.4 }))),
);

const { film } = useFilms();

for (const { name, frames, rate, width, height } of CLIPS)
  test(`reads ${frames} frames of ${name} at the times of its container`, { tag: '@long' }, async () => {
    const path = join(clipFolder, name);
    test.skip(!existsSync(path), `${path} is missing`);
    await giveFile(library.page, path);
    const { info, decoded } = await library.page.evaluate(async () => ({
      info: await tracecut.videoInfo(file),
      decoded: await numbersOf(file, { size: 64 }),
    }));
    expect(info).toMatchObject({ width, height, numFrames: frames, frameRate: rate, decodable: true });
    expect(info.codec).toMatch(/^avc1\./);
    expect(info.duration).toBeCloseTo(frames / rate, 6);
    expect(decoded.indices).toEqual(range(frames));
    decoded.times.forEach((time, k) => expect(time).toBeCloseTo(k / rate, 5));
    for (const duration of decoded.durations) expect(duration).toBeCloseTo(1 / rate, 5);
  });

test('reads every frame once and in order, from WebM and MP4', async () => {
  const [webm, mp4] = await library.page.evaluate(async () => [
    await numbersOf(clip),
    await numbersOf(await makeClip({ times: evenTimes(30, 25), container: 'Mp4', codec: 'vp9' })),
  ]);
  for (const { numbers, times, indices } of [webm, mp4]) {
    expect(numbers).toEqual(range(30));
    expect(indices).toEqual(range(30));
    times.forEach((time, k) => expect(Math.abs(time - k / 25)).toBeLessThan(0.0006));
  }
});

test('selects frames by start (included), end (excluded), step and maxFrames', async () => {
  const cases = [
    [{ start: 0.4, end: 0.8 }, [10, 11, 12, 13, 14, 15, 16, 17, 18, 19]],
    [{ start: 0.41, end: 0.56 }, [11, 12, 13]],
    [{ start: 0.2, step: 2, maxFrames: 4 }, [5, 7, 9, 11]],
    [{ start: -1, end: 0.1 }, [0, 1, 2]],
    [{ start: 1.16 }, [29]],
  ];
  for (const [options, numbers] of cases) {
    const decoded = await library.page.evaluate((selection) => numbersOf(clip, selection), options);
    expect(decoded.numbers, JSON.stringify(options)).toEqual(numbers);
    expect(decoded.indices).toEqual(range(numbers.length));
  }
});

test('reduces frames to a long side of size, and never enlarges them', async () => {
  const sizes = await library.page.evaluate(async () => {
    const large = await makeClip({ times: evenTimes(2, 25), width: 160, height: 90 });
    return Promise.all([undefined, 80, 100, 500].map(async (size) => (await numbersOf(large, { size })).size));
  });
  expect(sizes).toEqual(['160x90', '80x45', '100x56', '160x90']);
});

test('frames can be drawn on a canvas at every size, and are closed when the next one comes', async () => {
  const drawn = await library.page.evaluate(async () => {
    const outcomes = [];
    for (const size of [undefined, 64]) {
      const frames = [];
      for await (const { frame, width, height, pixels } of tracecut.videoFrames(clip, { size, maxFrames: 4 })) {
        const data = pixelsOf(frame, width, height);
        const numbers = [{ data, width, height }, await pixels()].map(numberOf);
        outcomes.push([frame instanceof VideoFrame, frame.displayWidth === width, ...numbers]);
        frames.push(frame);
      }
      outcomes.push(frames.every(({ format }) => format === null));
    }
    return outcomes;
  });
  const expected = [...range(4).map((k) => [true, true, k, k]), true];
  expect(drawn).toEqual([...expected, ...expected]);
});

test('a video that was recorded upright is turned', async () => {
  const rotated = await library.page.evaluate(async () => {
    const upright = await makeClip({ times: evenTimes(3, 25), container: 'Mp4', codec: 'vp9', rotation: 90 });
    const frames = tracecut.videoFrames(upright);
    const { value } = await frames.next();
    const edge = redEdge(await value.pixels());
    await frames.return();
    const { width, height } = await tracecut.videoInfo(upright);
    return { size: [value.width, value.height], info: [width, height], edge };
  });
  expect(rotated).toEqual({ size: [64, 128], info: [64, 128], edge: 'top' });
});

test('an abort while decoding rejects with its reason, and the page can decode again', async () => {
  const aborted = await library.page.evaluate(async () => {
    const controller = new AbortController();
    const error = await failure(
      (async () => {
        for await (const { index } of tracecut.videoFrames(clip, { signal: controller.signal }))
          if (index === 3) controller.abort(new TypeError('enough'));
      })(),
    );
    return { error, numbers: (await numbersOf(clip, { step: 10 })).numbers };
  });
  expect(aborted).toEqual({ error: { code: 'TypeError', message: 'enough' }, numbers: [0, 10, 20] });
});

test('without WebCodecs facts can be read, and reading frames names the browsers that have it', async () => {
  const { error, info } = await library.page.evaluate(async () => {
    const { VideoDecoder } = globalThis;
    delete globalThis.VideoDecoder;
    try {
      return { error: await failure(numbersOf(clip)), info: await tracecut.videoInfo(clip) };
    } finally {
      globalThis.VideoDecoder = VideoDecoder;
    }
  });
  expect(error.code).toBe('unsupported');
  expect(error.message).toMatch(/WebCodecs.*Chrome 94, Firefox 130, Safari 16\.4/);
  expect(info).toMatchObject({ decodable: false, numFrames: 30, frameRate: 25, width: 128, height: 64 });
});

test('a worker, which has no document, decodes and segments', async () => {
  const outcome = await library.page.evaluate(async () => {
    const code = `
      import { segmentVideo, videoFrames } from '${location.origin}/dist/index.js';
      onmessage = async ({ data }) => {
        try {
          const times = [];
          for await (const { time } of videoFrames(data, { maxFrames: 3 })) times.push(time);
          const { numFrames, width } = await segmentVideo(data, { maxFrames: 4, size: 64 }).collect();
          postMessage({ times, numFrames, width });
        } catch (error) {
          postMessage({ error: String(error) });
        }
      };`;
    const worker = new Worker(URL.createObjectURL(new Blob([code], { type: 'text/javascript' })), { type: 'module' });
    worker.postMessage(clip);
    const { data } = await new Promise((resolve) => (worker.onmessage = resolve));
    worker.terminate();
    return data;
  });
  expect(outcome).toEqual({ times: [0, 0.04, 0.08], numFrames: 4, width: 64 });
});

test('other files, unknown codecs and ranges without frames are errors that name the cause', async () => {
  const errors = await library.page.evaluate(async () => {
    const header = (text) => [...text].map((letter) => letter.charCodeAt(0));
    const bytes = new Uint8Array(await clip.arrayBuffer());
    bytes.set(header('V_QQ9'), String.fromCharCode(...bytes.subarray(0, 2000)).indexOf('V_VP8'));
    return {
      empty: await failure(numbersOf(new Blob([]))),
      text: await failure(numbersOf(new Blob(['no video '.repeat(100)]))),
      codec: await failure(numbersOf(new Blob([bytes]))),
      range: await failure(numbersOf(clip, { start: 9, end: 10 })),
    };
  });
  expect(errors.empty).toMatchObject({ code: 'no-video', message: expect.stringMatching(/empty/) });
  expect(errors.text).toMatchObject({ code: 'no-video', message: expect.stringMatching(/not a video, nor an image/) });
  expect(errors.codec).toMatchObject({ code: 'codec', message: expect.stringMatching(/V_QQ9.*convert/) });
  expect(errors.range).toEqual({
    code: 'no-frames',
    message: 'the source has no frame from 9 s to 10 s; its frames are at 0 s to 1.16 s',
  });
});

test('closes every frame that the decoder gives, also when reading ends early', async () => {
  const { page } = library;
  await page.evaluate(async () => {
    const { VideoDecoder } = globalThis;
    globalThis.decoded = [];
    globalThis.VideoDecoder = class extends VideoDecoder {
      constructor({ output, error }) {
        super({ output: (frame) => (decoded.push(frame), output(frame)), error });
      }
    };
    await numbersOf(clip, { step: 3 });
    for await (const { index } of tracecut.videoFrames(clip)) if (index === 2) break;
    globalThis.VideoDecoder = VideoDecoder;
  });
  await page.waitForFunction(() => decoded.every(({ format }) => format === null));
  expect(await page.evaluate(() => decoded.length)).toBeGreaterThan(30);
});

const BT709 = ['-color_range', 'tv', '-colorspace', 'bt709', '-color_primaries', 'bt709', '-color_trc', 'bt709'];

// The object covers 9% of each frame. The larger clip gives the figures of docs/determinism.md.
for (const [size, tag] of [
  [{ width: 160, height: 120, count: 6, side: 42 }, []],
  [{ ...FILM, count: 25, side: 62 }, '@long'],
]) {
  const { width, height, count: numFrames } = size;
  test(`${numFrames} frames in H.264 have nearly the pixels and masks that Node has by ffmpeg`, { tag }, async () => {
    needsFfmpeg();
    const toYuv = ['-vf', 'scale=out_color_matrix=bt709:out_range=tv,format=yuv420p'];
    const path = film(`bt709-${numFrames}.mp4`, [...toYuv, '-c:v', 'libx264', '-crf', '18', ...BT709], size);
    await giveFile(library.page, path);
    const inPage = await library.page.evaluate(async () => {
      const encode = (bytes) => btoa(Array.from(bytes, (byte) => String.fromCharCode(byte)).join(''));
      const pixelsOfFrames = [];
      for await (const { pixels } of tracecut.videoFrames(file)) pixelsOfFrames.push(encode((await pixels()).data));
      const masks = await tracecut.segmentVideo(file).collect();
      const labels = pixelsOfFrames.map((_, t) => encode(masks.labels(t)));
      return { pixels: pixelsOfFrames, labels, times: [...masks.times] };
    });
    const masks = await segmentVideo(framesOfVideo(path)).collect();
    expect(inPage.times).toHaveLength(numFrames);
    inPage.times.forEach((time, t) => expect(time).toBeCloseTo(masks.times[t], 5));
    const bytesOf = (text) => Buffer.from(text, 'base64');
    let [sum, largest, numDiffering, numOfObjects, t] = [0, 0, 0, 0, 0];
    for await (const { frame } of framesOfVideo(path)) {
      bytesOf(inPage.pixels[t]).forEach((level, at) => {
        if (at % 4 === 3) return;
        const difference = Math.abs(level - frame.data[at]);
        sum += difference;
        largest = Math.max(largest, difference);
      });
      const labels = bytesOf(inPage.labels[t]);
      masks.labels(t).forEach((label, p) => {
        numDiffering += Number(label !== labels[p]);
        numOfObjects += Number(label > 0);
      });
      t += 1;
    }
    expect(t).toBe(numFrames);
    const numPixels = numFrames * width * height;
    const meanDifference = sum / (3 * numPixels);
    const percent = (count) => `${((100 * count) / numPixels).toFixed(2)}%`;
    console.log(`Levels differ by ${meanDifference.toFixed(2)} of 255 on average, by ${largest} at most.`);
    console.log(`${percent(numDiffering)} of the mask pixels differ; ${percent(numOfObjects)} are of an object.`);
    expect(numOfObjects / numPixels).toBeGreaterThan(0.08);
    expect(meanDifference).toBeLessThan(3);
    expect(numDiffering / numPixels).toBeLessThan(0.005);
  });
}

test('leaving the loop, an abort and close end the worker, and the page can segment again', async ({ openLibrary }) => {
  // No other test has started workers here.
  const page = await openLibrary();
  await page.evaluate(async () => {
    const scene = await tracecut.synthClip({ width: 96, height: 64, frames: 12, seed: 1 });
    const frames = Array.from({ length: 12 }, (_, t) => scene.frame(t));
    const segment = (options) => tracecut.segmentVideo(frames, { window: 6, overlap: 3, threads: 1, ...options });
    Object.assign(globalThis, { segment });
  });
  const endings = {
    leave: async () => {
      for await (const { index } of segment()) if (index === 1) break;
    },
    abort: () => {
      const controller = new AbortController();
      const onProgress = ({ window }) => window === 1 && controller.abort(new Error('enough'));
      return failure(segment({ signal: controller.signal, onProgress }).collect());
    },
    close: () => {
      const video = segment({ onProgress: ({ window }) => window === 1 && video.close() });
      return failure(video.collect());
    },
    // The worker may still be starting.
    closeAtOnce: () => {
      const video = segment();
      const collecting = failure(video.collect());
      video.close();
      return collecting;
    },
    collect: async () => (await segment().collect()).numFrames,
  };
  const outcomes = {};
  for (const [name, run] of Object.entries(endings)) {
    outcomes[name] = await page.evaluate(run);
    await expect.poll(() => page.workers().length, name).toBe(0);
  }
  expect(outcomes).toMatchObject({
    abort: { message: 'enough' },
    close: { code: 'closed' },
    closeAtOnce: { code: 'closed' },
    collect: 12,
  });
});
