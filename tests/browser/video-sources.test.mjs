// Everything that frames can come from, and everything that can be wrong with it.

import assert from 'node:assert/strict';
import { createServer } from 'node:http';
import { after, before, describe, test } from 'node:test';
import { gifFile, plainFrame } from './support.mjs';
import { useLibrary } from './video-support.mjs';

const upTo = (count) => Array.from({ length: count }, (_, k) => k);

// In the page, under `clip`: thirty numbered frames at 25 a second.
const library = useLibrary((page) =>
  page.evaluate(async () => (globalThis.clip = await makeClip({ times: evenTimes(30, 25), keyEvery: 0.4 }))),
);

describe('sources', { timeout: 240_000 }, () => {
  test('a blob address, bytes and a file give the same frames', async () => {
    const seen = await library.page.evaluate(async () => {
      const options = { start: 0.2, maxFrames: 5 };
      const bytes = await clip.arrayBuffer();
      const sources = [
        clip,
        URL.createObjectURL(clip),
        new URL(URL.createObjectURL(clip)),
        bytes,
        new Uint8Array(bytes),
        new File([clip], 'clip.webm'),
      ];
      return Promise.all(sources.map(async (source) => (await numbersOf(source, options)).numbers));
    });
    assert.deepEqual(
      seen,
      seen.map(() => [5, 6, 7, 8, 9]),
    );
  });

  test('an animated GIF, frame by frame', async () => {
    const { buffer } = gifFile(
      'ramp.gif',
      upTo(6).map((k) => plainFrame(20, 10, () => [40 * k, 40 * k, 40 * k])),
    );
    const seen = await library.page.evaluate(
      async (bytes) => {
        const gif = new Blob([Uint8Array.from(bytes)]);
        const frames = [];
        for await (const { pixels, time, duration } of tracecut.videoFrames(gif))
          frames.push([(await pixels()).data[0], time, duration]);
        return { frames, info: await tracecut.videoInfo(gif) };
      },
      [...buffer],
    );
    assert.deepEqual(
      seen.frames.map(([level]) => level),
      upTo(6).map((k) => 40 * k),
    );
    seen.frames.forEach(([, time, duration], k) =>
      assert.ok(Math.abs(time - 0.07 * k) < 1e-6 && Math.abs(duration - 0.07) < 1e-6, `${time} ${duration}`),
    );
    const { width, height, numFrames, codec, decodable } = seen.info;
    assert.deepEqual(
      { width, height, numFrames, codec, decodable },
      { width: 20, height: 10, numFrames: 6, codec: 'image/gif', decodable: true },
    );
  });

  test('a video element gives the frames of its file, and plays on', async () => {
    const seen = await library.page.evaluate(async () => {
      const video = Object.assign(document.createElement('video'), {
        src: URL.createObjectURL(clip),
        muted: true,
        loop: true,
      });
      await video.play();
      const { numbers } = await numbersOf(video, { step: 6 });
      await new Promise((resolve) => video.addEventListener('timeupdate', resolve));
      const { paused, loop } = video;
      video.pause();
      return { numbers, paused, loop };
    });
    assert.deepEqual(seen, { numbers: [0, 6, 12, 18, 24], paused: false, loop: true });
  });

  test('an element that plays no file is refused, with what to do instead', async () => {
    const fault = await library.page.evaluate(async () => {
      const source = new MediaSource();
      const video = Object.assign(document.createElement('video'), { src: URL.createObjectURL(source) });
      await new Promise((resolve) => (source.onsourceopen = resolve));
      return failure(numbersOf(video));
    });
    assert.equal(fault.code, 'fetch');
    assert.match(fault.message, /MediaSource has no file: pass what it is fed with/);
  });

  test('where WebCodecs is missing there are facts, and frames say what it takes', async () => {
    const seen = await library.page.evaluate(async () => {
      const { VideoDecoder } = globalThis;
      delete globalThis.VideoDecoder;
      try {
        return { fault: await failure(numbersOf(clip)), info: await tracecut.videoInfo(clip) };
      } finally {
        globalThis.VideoDecoder = VideoDecoder;
      }
    });
    assert.equal(seen.fault.code, 'unsupported');
    assert.match(seen.fault.message, /WebCodecs.*Chrome 94, Firefox 130, Safari 16\.4/);
    const { decodable, numFrames, frameRate, width, height } = seen.info;
    assert.deepEqual([decodable, numFrames, frameRate, width, height], [false, 30, 25, 128, 64]);
  });

  test('a worker, which has no document, decodes and segments too', async () => {
    const seen = await library.page.evaluate(async () => {
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
    assert.deepEqual([seen.error, seen.times, seen.numFrames, seen.width], [undefined, [0, 0.04, 0.08], 4, 64]);
  });

  test("a stream of a canvas or its track, with and without the browser's own reader of tracks, up to its end, a time and a number", async () => {
    for (const bare of [false, true]) {
      const seen = await library.page.evaluate(streamed, bare);
      const { ended, timed, counted } = seen;
      for (const { numbers, times } of [ended, timed, counted]) {
        assert.deepEqual(
          numbers,
          [...new Set(numbers)].sort((a, b) => a - b),
          numbers.join(),
        );
        assert.ok(
          times.every((time, k) => k === 0 || time > times[k - 1]),
          times.join(),
        );
        assert.equal(times[0], 0);
      }
      assert.ok(ended.numbers.length >= 6, `${ended.numbers.length} of 12 frames`);
      assert.ok(timed.times.length >= 2 && timed.times.every((time) => time < 0.4), timed.times.join());
      assert.equal(counted.numbers.length, 3);
      assert.equal(seen.info.duration, Infinity);
      assert.equal(seen.alive, 'live', 'the track of the caller was stopped');
    }
  });

  test('a stream whose size changes on the way keeps the first one', async () => {
    const sizes = await library.page.evaluate(async () => {
      const canvas = Object.assign(document.createElement('canvas'), { width: 128, height: 64 });
      const context = canvas.getContext('2d');
      let k = 0;
      const timer = setInterval(() => {
        if (k === 4) Object.assign(canvas, { width: 64, height: 96 });
        drawNumber(context, k++);
      }, 70);
      const found = { sizes: new Set(), numbers: [] };
      for await (const { width, height, pixels } of tracecut.videoFrames(canvas.captureStream(), { end: 1 })) {
        found.sizes.add(`${width}x${height}`);
        found.numbers.push(numberOf(await pixels()));
      }
      clearInterval(timer);
      return { sizes: [...found.sizes], last: found.numbers.at(-1) };
    });
    assert.deepEqual(sizes.sizes, ['128x64']);
    assert.ok(sizes.last > 5, `the last frame is ${sizes.last}`);
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
      const found = [];
      for await (const { pixels } of tracecut.videoFrames(frames)) found.push(redEdge(await pixels()));
      return found;
    });
    assert.deepEqual(edges, ['left', 'top', 'right', 'right']);
  });

  test('each frame of a stream is closed once, and the stream is cancelled if it did not end', async () => {
    const seen = await library.page.evaluate(async () => {
      const counts = new Map();
      const { close } = VideoFrame.prototype;
      VideoFrame.prototype.close = function () {
        if (counts.has(this)) counts.set(this, counts.get(this) + 1);
        close.call(this);
      };
      const context = new OffscreenCanvas(128, 64).getContext('2d');
      const counting = (count, timeOf) => {
        const source = { number: 0, open: 0, peak: 0, cancelled: 0 };
        counts.clear();
        const pull = (controller) => {
          if (source.number === count) return controller.close();
          drawNumber(context, source.number);
          const frame = new VideoFrame(context.canvas, { timestamp: 1e6 * timeOf(source.number++) });
          counts.set(frame, 0);
          source.peak = Math.max(source.peak, [...counts.values()].filter((closed) => closed === 0).length);
          controller.enqueue(frame);
        };
        const cancel = () => void (source.cancelled += 1);
        source.stream = new ReadableStream({ pull, cancel }, { highWaterMark: 0 });
        return source;
      };
      const even = (k) => k / 25;
      const runs = {
        whole: [8, even, ({ stream }) => numbersOf(stream, { step: 3 })],
        enough: [Infinity, even, ({ stream }) => numbersOf(stream, { maxFrames: 4 })],
        late: [Infinity, (k) => (k === 3 ? 0 : even(k)), ({ stream }) => failure(numbersOf(stream))],
        segmented: [14, even, ({ stream }) => tracecut.segmentVideo(stream, { window: 6, overlap: 2 }).collect()],
        aborted: [
          Infinity,
          even,
          ({ stream }) => {
            const controller = new AbortController();
            const onFrame = ({ index }) => index === 5 && controller.abort();
            const options = { window: 4, overlap: 1, signal: controller.signal, onFrame };
            return failure(tracecut.segmentVideo(stream, options).collect());
          },
        ],
      };
      const seen = {};
      for (const [name, [count, timeOf, run]] of Object.entries(runs)) {
        const source = counting(count, timeOf);
        const { numbers, code } = (await run(source)) ?? {};
        // What was on its way when the run was aborted is closed soon after.
        while ([...counts.values()].includes(0)) await new Promise((resolve) => setTimeout(resolve, 10));
        const { peak, cancelled } = source;
        seen[name] = { closed: [...new Set(counts.values())], peak, cancelled, numbers, code };
      }
      VideoFrame.prototype.close = close;
      return seen;
    });
    const once = { closed: [1], peak: 1, numbers: undefined, code: undefined };
    assert.deepEqual(seen, {
      whole: { ...once, cancelled: 0, numbers: [0, 3, 6] },
      enough: { ...once, cancelled: 1, numbers: [0, 1, 2, 3] },
      late: { ...once, cancelled: 1, code: 'data' },
      segmented: { ...once, cancelled: 0 },
      aborted: { ...once, cancelled: 1, code: 20 }, // that of an AbortError
    });
  });

  test('the frames of a track that nobody uses queue up to a window, and each is closed once', async () => {
    const seen = await library.page.evaluate(async () => {
      const { MediaStreamTrackProcessor: Processor } = globalThis;
      const counts = [];
      globalThis.MediaStreamTrackProcessor = class {
        constructor(init) {
          const reader = new Processor(init).readable.getReader();
          const pull = async (controller) => {
            const { value: frame, done } = await reader.read();
            if (done) return controller.close();
            const k = counts.push(0) - 1;
            const close = frame.close.bind(frame);
            frame.close = () => ((counts[k] += 1), close());
            controller.enqueue(frame);
          };
          // Nothing is taken from the processor before it is asked for.
          this.readable = new ReadableStream({ pull, cancel: () => reader.cancel() }, { highWaterMark: 0 });
        }
      };
      const canvas = Object.assign(document.createElement('canvas'), { width: 128, height: 64 });
      const context = canvas.getContext('2d');
      const [track] = canvas.captureStream().getVideoTracks();
      let painted = 0;
      let goOn;
      const held = new Promise((resolve) => (goOn = resolve));
      const timer = setInterval(() => {
        drawNumber(context, painted++ % 200);
        if (painted === 30) goOn();
      }, 40);
      const controller = new AbortController();
      const inFlight = [];
      const onFrame = async ({ index }) => {
        await held;
        inFlight.push(counts.length - index);
        if (index === 9) controller.abort();
      };
      const options = { window: 4, overlap: 1, signal: controller.signal, onFrame };
      try {
        const fault = await failure(tracecut.segmentVideo(track, options).collect());
        await new Promise((resolve) => setTimeout(resolve, 200));
        return {
          fault: fault.code,
          peak: Math.max(...inFlight),
          closed: [...new Set(counts)],
          alive: track.readyState,
        };
      } finally {
        clearInterval(timer);
        globalThis.MediaStreamTrackProcessor = Processor;
      }
    });
    assert.deepEqual([seen.fault, seen.alive], [20, 'live']); // 20 is an AbortError
    assert.ok(seen.peak >= 4 && seen.peak <= 4 + 4, `${seen.peak} frames in flight`);
    assert.deepEqual(seen.closed, [1]);
  });

  test('a browser that cannot read a track, one of sound, and one that has ended are told apart', async () => {
    const faults = await library.page.evaluate(async () => {
      const { MediaStreamTrackProcessor } = globalThis;
      const { requestVideoFrameCallback } = HTMLVideoElement.prototype;
      const [track] = document.createElement('canvas').captureStream().getVideoTracks();
      const [sound] = new AudioContext().createMediaStreamDestination().stream.getAudioTracks();
      delete globalThis.MediaStreamTrackProcessor;
      delete HTMLVideoElement.prototype.requestVideoFrameCallback;
      const old = await failure(numbersOf(track));
      Object.assign(globalThis, { MediaStreamTrackProcessor });
      Object.assign(HTMLVideoElement.prototype, { requestVideoFrameCallback });
      track.stop();
      return { old, sound: await failure(numbersOf(sound)), ended: await failure(numbersOf(track)) };
    });
    assert.equal(faults.old.code, 'unsupported');
    assert.match(faults.old.message, /needs MediaStreamTrackProcessor, or in a page requestVideoFrameCallback/);
    assert.deepEqual([faults.sound.code, faults.ended.code], ['no-video', 'no-frames']);
    assert.match(faults.sound.message, /no video track/);
  });
});

/** Runs in the page: numbered frames of a canvas, as streams that end in three ways. */
async function streamed(bare) {
  const { MediaStreamTrackProcessor } = globalThis;
  if (bare) delete globalThis.MediaStreamTrackProcessor;
  const painted = (count, options, source = (stream) => stream) => {
    const canvas = Object.assign(document.createElement('canvas'), { width: 128, height: 64 });
    const context = canvas.getContext('2d');
    const stream = canvas.captureStream();
    const [track] = stream.getVideoTracks();
    const result = numbersOf(source(stream), options);
    let k = 0;
    const timer = setInterval(() => {
      drawNumber(context, k++);
      if (k === count) track.stop();
    }, 70);
    return result.finally(() => clearInterval(timer)).then((seen) => ({ ...seen, alive: track.readyState, stream }));
  };
  try {
    const counted = await painted(Infinity, { maxFrames: 3 });
    const firstTrack = (stream) => stream.getVideoTracks()[0];
    const timed = await painted(Infinity, { end: 0.4 }, firstTrack);
    const ended = await painted(12, {}, firstTrack);
    const info = await tracecut.videoInfo(counted.stream);
    return { counted, timed, ended, info, alive: counted.alive };
  } finally {
    globalThis.MediaStreamTrackProcessor = MediaStreamTrackProcessor;
  }
}

describe('addresses', { timeout: 240_000 }, () => {
  let server;
  let asked;
  before(async () => {
    const bytes = Buffer.from(await library.page.evaluate(async () => [...new Uint8Array(await clip.arrayBuffer())]));
    asked = [];
    server = createServer((request, response) => serveClip(bytes, request, response, asked));
    await new Promise((resolve) => server.listen(0, '127.0.0.1', resolve));
  });
  after(() => new Promise((resolve) => (server.close(resolve), server.closeAllConnections())));
  const address = (path) => `http://127.0.0.1:${server.address().port}/${path}`;

  test('a file of another site is read piece by piece where its server can do that, else whole', async () => {
    for (const path of ['ranges', 'whole']) {
      const seen = await library.page.evaluate((url) => numbersOf(url, { start: 0.8, maxFrames: 3 }), address(path));
      assert.deepEqual(seen.numbers, [20, 21, 22], path);
    }
    assert.ok(
      asked.some(({ path, range }) => path === '/ranges' && /^bytes=\d+-$/.test(range)),
      JSON.stringify(asked),
    );
  });

  test('a truncated WebM is reported, with or without range requests', async () => {
    for (const path of ['ranges?cut', 'whole?cut']) {
      const seen = await library.page.evaluate(async (url) => {
        const numbers = [];
        const fault = await failure(
          (async () => {
            for await (const { pixels } of tracecut.videoFrames(url)) numbers.push(numberOf(await pixels()));
          })(),
        );
        return { numbers, code: fault?.code };
      }, address(path));
      assert.equal(seen.code, 'truncated', path);
      assert.ok(seen.numbers.length > 12 && seen.numbers.length < 30, `${seen.numbers.length}`);
      assert.deepEqual(seen.numbers, upTo(seen.numbers.length));
    }
  });

  test('a site that does not allow it, and a missing file, are named', async () => {
    const [closed, missing] = await library.page.evaluate(
      (urls) => Promise.all(urls.map((url) => failure(numbersOf(url)))),
      [address('closed'), 'nothing-here.mp4'],
    );
    assert.equal(closed.code, 'fetch');
    assert.match(closed.message, /Access-Control-Allow-Origin/);
    assert.equal(missing.code, 'fetch');
    assert.match(missing.message, /nothing-here.mp4 cannot be fetched: 404/);
  });
});

function serveClip(whole, request, response, asked) {
  const range = request.headers.range;
  const bytes = request.url.endsWith('?cut') ? whole.subarray(0, Math.floor(0.7 * whole.length)) : whole;
  asked.push({ path: request.url, range });
  const headers = { 'Content-Type': 'video/webm' };
  if (request.url !== '/closed')
    Object.assign(headers, { 'Access-Control-Allow-Origin': '*', 'Access-Control-Expose-Headers': '*' });
  const [, from, to] = /^bytes=(\d+)-(\d*)$/.exec(request.url.startsWith('/ranges') ? (range ?? '') : '') ?? [];
  if (from === undefined) return response.writeHead(200, headers).end(bytes);
  const last = to ? Math.min(Number(to), bytes.length - 1) : bytes.length - 1;
  headers['Content-Range'] = `bytes ${from}-${last}/${bytes.length}`;
  return response.writeHead(206, headers).end(bytes.subarray(Number(from), last + 1));
}

describe('faults', { timeout: 240_000 }, () => {
  test('other files are reported as not videos', async () => {
    const seen = await library.page.evaluate(async () => {
      const header = (text) => [...text].map((letter) => letter.charCodeAt(0));
      const sound = new Uint8Array(44 + 1000);
      const view = new DataView(sound.buffer);
      sound.set(header('RIFF'), 0);
      view.setUint32(4, 1036, true);
      sound.set(header('WAVEfmt '), 8);
      [
        [16, 16],
        [24, 8000],
        [28, 8000],
        [40, 1000],
      ].forEach(([at, value]) => view.setUint32(at, value, true));
      [
        [20, 1],
        [22, 1],
        [32, 1],
        [34, 8],
      ].forEach(([at, value]) => view.setUint16(at, value, true));
      sound.set(header('data'), 36);
      const sources = {
        empty: new Blob([]),
        text: new Blob(['no video '.repeat(100)]),
        sound: new Blob([sound]),
        picture: new Blob([clip.slice(0, 0), '\x89PNG\r\n']),
      };
      const failures = {};
      for (const [name, source] of Object.entries(sources)) failures[name] = await failure(numbersOf(source));
      return failures;
    });
    assert.equal(seen.empty.code, 'no-video');
    assert.match(seen.empty.message, /empty/);
    assert.equal(seen.text.code, 'no-video');
    assert.match(seen.text.message, /not a video, nor an image/);
    assert.equal(seen.sound.code, 'no-video');
    assert.match(seen.sound.message, /only sound/);
  });

  test('a codec that nobody knows is named', async () => {
    const fault = await library.page.evaluate(async () => {
      const bytes = new Uint8Array(await clip.arrayBuffer());
      const text = String.fromCharCode(...bytes.subarray(0, 2000));
      bytes.set(
        [...'V_QQ9'].map((letter) => letter.charCodeAt(0)),
        text.indexOf('V_VP8'),
      );
      return failure(numbersOf(new Blob([bytes])));
    });
    assert.equal(fault.code, 'codec');
    assert.match(fault.message, /V_QQ9.*convert/);
  });

  test('a range without frames is named with the times that there are', async () => {
    const fault = await library.page.evaluate(() => failure(numbersOf(clip, { start: 9, end: 10 })));
    assert.deepEqual(fault, {
      code: 'no-frames',
      message: 'the source has no frame from 9 s to 10 s; its frames are at 0 s to 1.16 s',
    });
  });

  test('an abort while decoding rejects with its reason, and the page can decode again', async () => {
    const seen = await library.page.evaluate(async () => {
      const controller = new AbortController();
      const fault = await failure(
        (async () => {
          for await (const { index } of tracecut.videoFrames(clip, { signal: controller.signal }))
            if (index === 3) controller.abort(new TypeError('enough'));
        })(),
      );
      return { fault, numbers: (await numbersOf(clip, { step: 10 })).numbers };
    });
    assert.deepEqual(seen, { fault: { code: 'TypeError', message: 'enough' }, numbers: [0, 10, 20] });
  });

  test('nothing is left open', () => {
    // The browser itself tells of the site that allows nothing.
    const others = library.faults.filter((fault) => !fault.includes('CORS policy'));
    assert.deepEqual(others, []);
  });
});
