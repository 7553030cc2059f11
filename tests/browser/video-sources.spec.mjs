// Sources of frames besides files: elements, streams, tracks of a canvas, and addresses of other hosts.

import { expect, test, useLibrary, useServer } from './fixtures.mjs';
import { range } from './page-helpers.mjs';

/** Code of a DOMException with the name AbortError. */
const ABORT_ERR = 20;

// The page has `clip`, thirty numbered frames at 25 per second, and `paintNumbers`.
const library = useLibrary((page) =>
  page.evaluate(async () => {
    globalThis.clip = await makeClip({ times: evenTimes(30, 25), keyEvery: 0.4 });
    /** Paints the next number, or `number` once it is set, whenever the browser presents the canvas, until `stop()`. */
    globalThis.paintNumbers = () => {
      const { canvas, context } = numberCanvas();
      const painting = { canvas, count: 0, number: undefined, stop: () => cancelAnimationFrame(request) };
      const paint = () => {
        drawNumber(context, painting.number ?? Math.min(254, painting.count));
        painting.count += 1;
        request = requestAnimationFrame(paint);
      };
      let request = requestAnimationFrame(paint);
      return painting;
    };
  }),
);

test('a file, its address and its bytes give the same frames', async () => {
  const numbers = await library.page.evaluate(async () => {
    const options = { start: 0.2, maxFrames: 5 };
    const bytes = await clip.arrayBuffer();
    const address = URL.createObjectURL(clip);
    const sources = [clip, address, new URL(address), bytes, new Uint8Array(bytes), new File([clip], 'clip.webm')];
    return Promise.all(sources.map(async (source) => (await numbersOf(source, options)).numbers));
  });
  expect(numbers).toEqual(Array(6).fill([5, 6, 7, 8, 9]));
});

test('a video element gives the frames of its file and continues to play', async () => {
  const outcome = await library.page.evaluate(async () => {
    const src = URL.createObjectURL(clip);
    const video = Object.assign(document.createElement('video'), { src, muted: true, loop: true });
    await video.play();
    const { numbers } = await numbersOf(video, { step: 6 });
    await new Promise((resolve) => video.addEventListener('timeupdate', resolve, { once: true }));
    const { paused, loop } = video;
    video.pause();
    return { numbers, paused, loop };
  });
  expect(outcome).toEqual({ numbers: [0, 6, 12, 18, 24], paused: false, loop: true });
});

test('a video element without a file is refused, with what to pass instead', async () => {
  const error = await library.page.evaluate(async () => {
    const source = new MediaSource();
    const video = Object.assign(document.createElement('video'), { src: URL.createObjectURL(source) });
    await new Promise((resolve) => (source.onsourceopen = resolve));
    return failure(numbersOf(video));
  });
  expect(error.code).toBe('fetch');
  expect(error.message).toMatch(/MediaSource has no file: pass what it is fed with/);
});

for (const [reader, hasProcessor] of [
  ['MediaStreamTrackProcessor', true],
  ['a video element', false],
])
  test(`reads a track by ${reader} until it ends, a time, or a number of frames`, async () => {
    const outcome = await library.page.evaluate(async (isKept) => {
      const { MediaStreamTrackProcessor } = globalThis;
      if (!isKept) delete globalThis.MediaStreamTrackProcessor;
      const painting = paintNumbers();
      try {
        const stream = painting.canvas.captureStream();
        const [track] = stream.getVideoTracks();
        const counted = await numbersOf(stream, { maxFrames: 3 });
        const timed = await numbersOf(track, { end: 0.2 });
        const ended = { numbers: [], times: [] };
        for await (const { time, pixels } of tracecut.videoFrames(track)) {
          ended.numbers.push(numberOf(await pixels()));
          ended.times.push(time);
          if (ended.times.length === 4) track.stop();
        }
        const { duration } = await tracecut.videoInfo(stream);
        return { counted, timed, ended, duration };
      } finally {
        painting.stop();
        globalThis.MediaStreamTrackProcessor = MediaStreamTrackProcessor;
      }
    }, hasProcessor);
    const { counted, timed, ended } = outcome;
    for (const { numbers, times } of [counted, timed, ended]) {
      expect(numbers).toEqual([...numbers].sort((a, b) => a - b));
      expect(times[0]).toBe(0);
      expect(times).toEqual([...new Set(times)].sort((a, b) => a - b));
    }
    expect(counted.numbers).toHaveLength(3);
    expect(timed.times.every((time) => time < 0.2)).toBe(true);
    expect(ended.times.length).toBeGreaterThanOrEqual(4);
    expect(outcome.duration).toBe(Infinity);
  });

test('a stream whose size changes keeps its first size', async () => {
  const sizes = await library.page.evaluate(async () => {
    const painting = paintNumbers();
    const stream = painting.canvas.captureStream();
    const sizes = [];
    for await (const { width, height, pixels } of tracecut.videoFrames(stream)) {
      sizes.push(`${width}x${height}`);
      if (sizes.length === 3) {
        Object.assign(painting.canvas, { width: 64, height: 96 });
        painting.number = 255;
      }
      if (numberOf(await pixels()) === 255) break;
    }
    painting.stop();
    return [...new Set(sizes)];
  });
  expect(sizes).toEqual(['128x64']);
});

test('frames that are to be turned or mirrored come upright', async () => {
  const edges = await library.page.evaluate(async () => {
    const context = new OffscreenCanvas(128, 64).getContext('2d');
    drawNumber(context, 0);
    const turns = [{ rotation: 0 }, { rotation: 90 }, { rotation: 180 }, { rotation: 0, flip: true }];
    const frames = turns.map((turn, k) => {
      const plain = new VideoFrame(context.canvas, { timestamp: 4e4 * k });
      const frame = new VideoFrame(plain, turn);
      plain.close();
      return { frame, clip: String(k) };
    });
    const red = [];
    for await (const { pixels } of tracecut.videoFrames(frames)) red.push(redEdge(await pixels()));
    return red;
  });
  expect(edges).toEqual(['left', 'top', 'right', 'right']);
});

// Each entry: number of frames (none if the stream does not end), number of the frame whose time is 0 again, the reading of the stream.
const STREAM_RUNS = {
  complete: [8, -1, (stream) => numbersOf(stream, { step: 3 })],
  enough: [null, -1, (stream) => numbersOf(stream, { maxFrames: 4 })],
  late: [null, 3, (stream) => failure(numbersOf(stream))],
  segmented: [8, -1, (stream) => tracecut.segmentVideo(stream, { window: 6, overlap: 2 }).collect()],
  aborted: [
    null,
    -1,
    (stream) => {
      const controller = new AbortController();
      const onFrame = ({ index }) => index === 5 && controller.abort();
      const options = { window: 4, overlap: 1, signal: controller.signal, onFrame };
      return failure(tracecut.segmentVideo(stream, options).collect());
    },
  ],
};
const STREAM_OUTCOMES = {
  complete: { numCancelled: 0, numbers: [0, 3, 6] },
  enough: { numCancelled: 1, numbers: [0, 1, 2, 3] },
  late: { numCancelled: 1, code: 'data' },
  segmented: { numCancelled: 0 },
  aborted: { numCancelled: 1, code: ABORT_ERR },
};

for (const [name, [numFrames, lateFrame, read]] of Object.entries(STREAM_RUNS))
  test(`closes each frame of a stream once and has one open at a time: ${name}`, async () => {
    const { page } = library;
    await page.evaluate(() => {
      globalThis.closeCounts = new Map();
      globalThis.originalClose = VideoFrame.prototype.close;
      VideoFrame.prototype.close = function () {
        if (closeCounts.has(this)) closeCounts.set(this, closeCounts.get(this) + 1);
        originalClose.call(this);
      };
    });
    await page.evaluate(`globalThis.readStream = ${read}`);
    const { maxOpen, ...outcome } = await page.evaluate(
      async ([count, repeated]) => {
        const context = new OffscreenCanvas(128, 64).getContext('2d');
        let [number, peak, numCancelled] = [0, 0, 0];
        const pull = (controller) => {
          if (number === count) return controller.close();
          drawNumber(context, number);
          const timestamp = number === repeated ? 0 : 4e4 * number;
          const frame = new VideoFrame(context.canvas, { timestamp });
          number += 1;
          closeCounts.set(frame, 0);
          peak = Math.max(peak, [...closeCounts.values()].filter((closed) => closed === 0).length);
          controller.enqueue(frame);
        };
        const stream = new ReadableStream({ pull, cancel: () => void (numCancelled += 1) }, { highWaterMark: 0 });
        const { numbers, code } = (await readStream(stream)) ?? {};
        return { maxOpen: peak, numCancelled, numbers, code };
      },
      [numFrames, lateFrame],
    );
    expect({ ...outcome }).toEqual(STREAM_OUTCOMES[name]);
    expect(maxOpen).toBe(1);
    // Frames that were on their way when the run was aborted are closed soon after.
    await page.waitForFunction(() => [...closeCounts.values()].every((count) => count > 0));
    const counts = await page.evaluate(() => {
      VideoFrame.prototype.close = originalClose;
      return [...new Set(closeCounts.values())];
    });
    expect(counts).toEqual([1]);
  });

test('unused frames of a track queue up to a window, and each is closed once', async () => {
  const { page } = library;
  const outcome = await page.evaluate(async () => {
    const { MediaStreamTrackProcessor: Processor } = globalThis;
    const counts = (globalThis.closeCounts = []);
    globalThis.MediaStreamTrackProcessor = class {
      constructor(init) {
        const reader = new Processor(init).readable.getReader();
        const pull = async (controller) => {
          const { value: frame } = await reader.read();
          if (!frame) return controller.close();
          const k = counts.push(0) - 1;
          const close = frame.close.bind(frame);
          frame.close = () => ((counts[k] += 1), close());
          controller.enqueue(frame);
        };
        // Nothing is taken from the processor before it is requested.
        this.readable = new ReadableStream({ pull, cancel: () => reader.cancel() }, { highWaterMark: 0 });
      }
    };
    const painting = paintNumbers();
    const [track] = painting.canvas.captureStream().getVideoTracks();
    const isReady = () => counts.length >= 4 && painting.count >= 30;
    const nextPaint = () => new Promise((resolve) => requestAnimationFrame(resolve));
    const controller = new AbortController();
    const inFlight = [];
    const onFrame = async ({ index }) => {
      while (!isReady()) await nextPaint();
      inFlight.push(counts.length - index);
      if (index === 9) controller.abort();
    };
    const options = { window: 4, overlap: 1, signal: controller.signal, onFrame };
    try {
      const error = await failure(tracecut.segmentVideo(track, options).collect());
      return { code: error.code, maxInFlight: Math.max(...inFlight), state: track.readyState };
    } finally {
      painting.stop();
      globalThis.MediaStreamTrackProcessor = Processor;
    }
  });
  expect(outcome).toMatchObject({ code: ABORT_ERR, state: 'live' });
  expect(outcome.maxInFlight).toBeGreaterThanOrEqual(4);
  expect(outcome.maxInFlight).toBeLessThanOrEqual(8);
  await page.waitForFunction(() => closeCounts.every((count) => count > 0));
  expect(await page.evaluate(() => [...new Set(closeCounts)])).toEqual([1]);
});

test('a browser that cannot read tracks, a track of sound, and one that has ended have errors of their own', async () => {
  const errors = await library.page.evaluate(async () => {
    const { MediaStreamTrackProcessor } = globalThis;
    const { requestVideoFrameCallback } = HTMLVideoElement.prototype;
    const [track] = document.createElement('canvas').captureStream().getVideoTracks();
    const [sound] = new AudioContext().createMediaStreamDestination().stream.getAudioTracks();
    delete globalThis.MediaStreamTrackProcessor;
    delete HTMLVideoElement.prototype.requestVideoFrameCallback;
    const unsupported = await failure(numbersOf(track));
    Object.assign(globalThis, { MediaStreamTrackProcessor });
    Object.assign(HTMLVideoElement.prototype, { requestVideoFrameCallback });
    track.stop();
    return { unsupported, sound: await failure(numbersOf(sound)), ended: await failure(numbersOf(track)) };
  });
  expect(errors.unsupported.code).toBe('unsupported');
  expect(errors.unsupported.message).toMatch(/needs MediaStreamTrackProcessor, or in a page requestVideoFrameCallback/);
  expect(errors.sound.code).toBe('no-video');
  expect(errors.sound.message).toMatch(/no video track/);
  expect(errors.ended.code).toBe('no-frames');
});

test.describe('files of another host', () => {
  const requests = [];
  let bytes;
  test.beforeAll(async () => {
    bytes = Buffer.from(await library.page.evaluate(() => base64Of(clip)), 'base64');
  });
  const host = useServer((request, response) => serveClip(bytes, request, response, requests));
  const address = (path) => `${host.origin}/${path}`;

  test('are read in ranges if the server supports them, and whole otherwise', async () => {
    for (const path of ['ranges', 'whole']) {
      const { numbers } = await library.page.evaluate(
        (url) => numbersOf(url, { start: 0.8, maxFrames: 3 }),
        address(path),
      );
      expect(numbers, path).toEqual([20, 21, 22]);
    }
    expect(requests).toContainEqual({ path: '/ranges', range: expect.stringMatching(/^bytes=\d+-$/) });
  });

  test('give the frames before the end of a truncated WebM, then an error', async () => {
    for (const path of ['ranges?cut', 'whole?cut']) {
      const { numbers, error } = await library.page.evaluate(async (url) => {
        const decoded = [];
        const readAll = async () => {
          for await (const { pixels } of tracecut.videoFrames(url)) decoded.push(numberOf(await pixels()));
        };
        return { error: await failure(readAll()), numbers: decoded };
      }, address(path));
      expect(error.code, path).toBe('truncated');
      expect(numbers.length).toBeGreaterThan(12);
      expect(numbers.length).toBeLessThan(30);
      expect(numbers).toEqual(range(numbers.length));
    }
  });

  test('that may not be read, or are missing, are errors that say so', async ({ faults }) => {
    // The browser reports the first one too, after it has refused it.
    const report = library.page.waitForEvent('console', (message) => /CORS policy/.test(message.text()));
    faults.expected.push(/CORS policy/);
    const [forbidden, missing] = await library.page.evaluate(
      (urls) => Promise.all(urls.map((url) => failure(numbersOf(url)))),
      [address('closed'), 'nothing-here.mp4'],
    );
    expect(forbidden).toMatchObject({ code: 'fetch', message: expect.stringMatching(/Access-Control-Allow-Origin/) });
    expect(missing.code).toBe('fetch');
    expect(missing.message).toMatch(/nothing-here.mp4 cannot be fetched: 404/);
    await report;
  });
});

function serveClip(file, request, response, requests) {
  const { url: path, headers: requested } = request;
  const bytes = path.endsWith('?cut') ? file.subarray(0, Math.floor(0.7 * file.length)) : file;
  requests.push({ path, range: requested.range });
  const headers = { 'Content-Type': 'video/webm' };
  if (path !== '/closed')
    Object.assign(headers, { 'Access-Control-Allow-Origin': '*', 'Access-Control-Expose-Headers': '*' });
  const [, from, to] = /^bytes=(\d+)-(\d*)$/.exec(path.startsWith('/ranges') ? (requested.range ?? '') : '') ?? [];
  if (from === undefined) return response.writeHead(200, headers).end(bytes);
  const last = to ? Math.min(Number(to), bytes.length - 1) : bytes.length - 1;
  headers['Content-Range'] = `bytes ${from}-${last}/${bytes.length}`;
  return response.writeHead(206, headers).end(bytes.subarray(Number(from), last + 1));
}
