// Videos and images of masks, written by the package and opened again by the browser, under a strict content security policy.

import { execFileSync } from 'node:child_process';
import { writeFileSync } from 'node:fs';
import * as packageInNode from '../entries.mjs';
import { fnv1a } from '../fingerprint.mjs';
import { expect, test, useEmptyPage } from './fixtures.mjs';
import { needsFfmpeg, useFilms } from './video-clips.mjs';

/** Frame `t` is `[4 x, 40 t, 128]`, with a square object. The sides are odd, and the frames do not last equally long. */
const WIDTH = 61;
const HEIGHT = 47;
const TIMES = [5, 5.04, 5.1, 5.14, 5.2, 5.5];
const STARTS_MS = [0, 40, 100, 140, 200, 500];
const INSIDE = [32, 20];
const OUTSIDE = [6, 40];
const OBJECT_1 = [0xe6, 0x9f, 0x00];

const prepare = (page) => page.evaluate(defineClip, [WIDTH, HEIGHT, TIMES]);
const exportPage = useEmptyPage(prepare);

/** Runs in the page: defines the clip, and how files are read. */
async function defineClip([width, height, times]) {
  const tracecut = await import('/model/library.js');
  const media = await import('/dist/vendor/media.js');
  const frames = times.map((_, t) => {
    const image = new ImageData(width, height);
    for (let p = 0; p < width * height; p += 1) image.data.set([4 * (p % width), 40 * t, 128, 255], 4 * p);
    return image;
  });
  const label = (x, y) => Number(x >= 21 && x < 44 && y >= 11 && y < 34);
  const labels = () => Uint8Array.from({ length: width * height }, (_, p) => label(p % width, Math.floor(p / width)));
  const masks = { width, height, numFrames: times.length, labels, times };
  /** Codec and packets of a file; a packet is its time in milliseconds, and whether it has an alpha channel. */
  const readPackets = async (blob) => {
    const input = new media.Input({ formats: media.ALL_FORMATS, source: new media.BlobSource(blob) });
    const track = await input.getPrimaryVideoTrack();
    const starts = [];
    const alphas = new Set();
    for await (const { timestamp, sideData } of new media.EncodedPacketSink(track).packets()) {
      starts.push(Math.round(1000 * timestamp));
      alphas.add(Boolean(sideData.alpha));
    }
    return { codec: track.codec, starts, alphas: [...alphas] };
  };
  const { errorText, playedFrame } = await import('/tests/browser/page-helpers.mjs');
  Object.assign(globalThis, { tracecut, frames, masks, readPackets, errorText, playedFrame });
}

/** Encodes the clip and reads the file: packets, and the third frame as a player shows it. */
function encode(page, options, places = [INSIDE, OUTSIDE]) {
  return page.evaluate(
    async ([encodeOptions, spots]) => {
      const progress = [];
      const onProgress = (step) => progress.push(`${step.done}/${step.total}`);
      const pictures = encodeOptions.style === 'masks' ? null : frames;
      const blob = await tracecut.encodeVideo(masks, pictures, { ...encodeOptions, onProgress });
      const { width, height, duration, colorAt } = await playedFrame(blob, 0.12);
      const shownFrame = { size: [width, height], duration, colors: spots.map(colorAt) };
      return { type: blob.type, progress, ...(await readPackets(blob)), ...shownFrame };
    },
    [options, places],
  );
}

function expectColor(color, expected, name) {
  const distance = Math.max(...expected.map((value, k) => Math.abs(value - color[k])));
  expect(distance, `${name}: ${color} (expected about ${expected})`).toBeLessThanOrEqual(12);
}

const frameColor = ([x]) => [4 * x, 80, 128];
const mix = (a, b) => a.map((value, k) => (value + b[k]) / 2);

test('an overlay has every frame at its time, under its mask', async () => {
  const { colors, duration, ...file } = await encode(exportPage.page, {});
  expect(file).toEqual({
    ...{ type: 'video/webm', codec: 'vp9', starts: STARTS_MS, alphas: [false], size: [WIDTH, HEIGHT] },
    progress: ['1/6', '2/6', '3/6', '4/6', '5/6', '6/6'],
  });
  expect(duration).toBeCloseTo(0.8, 2);
  expectColor(colors[0], mix(frameColor(INSIDE), OBJECT_1), 'inside');
  expectColor(colors[1], frameColor(OUTSIDE), 'outside');
});

test('cut-out objects are transparent around, with clean edges', async () => {
  const edge = [
    [21, 20],
    [17, 20],
    [43, 33],
    [46, 36],
  ];
  const { colors, ...file } = await encode(exportPage.page, { style: 'cutout' }, [INSIDE, OUTSIDE, ...edge]);
  expect(file).toMatchObject({ codec: 'vp9', starts: STARTS_MS, alphas: [true], size: [WIDTH, HEIGHT] });
  expectColor(colors[0], [...frameColor(INSIDE), 255], 'inside');
  expectColor(colors[2], [...frameColor(edge[0]), 255], 'within the edge');
  expectColor(colors[4], [...frameColor(edge[2]), 255], 'within the corner');
  for (const k of [1, 3, 5]) expect(colors[k][3]).toBeLessThanOrEqual(8);
});

test('cut-out objects lie on colours, their frame or a picture; in MP4 on green', async () => {
  const { page } = exportPage;
  const green = await encode(page, { style: 'cutout', format: 'mp4' });
  expect(green).toMatchObject({ type: 'video/mp4', codec: 'avc' });
  const brightness = (factor) => frameColor(OUTSIDE).map((value) => factor * value);
  for (const [background, expected] of [
    [green, [0x00, 0xb1, 0x40]],
    ['rgb(20 40 200)', [20, 40, 200]],
    // The frames are ramps, which a blur changes near the frame border only.
    ['blurred', [24, 80, 128]],
    ['dimmed', brightness(0.35)],
  ]) {
    const { colors } = background === green ? green : await encode(page, { style: 'cutout', background });
    expectColor(colors[0], frameColor(INSIDE), `inside on ${background}`);
    expectColor(colors[1], [...expected, 255], `outside on ${background}`);
  }
  const [, grey] = (await encode(page, { style: 'cutout', background: 'desaturated' })).colors;
  expect(Math.max(...grey.slice(0, 3)) - Math.min(...grey.slice(0, 3))).toBeLessThanOrEqual(8);
  const unchosen = await encode(page, { style: 'cutout', background: 'white', objects: [2] });
  expectColor(unchosen.colors[0], [255, 255, 255], 'an object that is not chosen');
  const colors = await page.evaluate(
    async (places) => {
      const picture = new OffscreenCanvas(400, 100);
      const context = picture.getContext('2d');
      for (const [k, color] of ['#ff0000', '#00ff00', '#ff0000'].entries()) {
        context.fillStyle = color;
        context.fillRect([0, 120, 280][k], 0, 160, 100);
      }
      const options = { style: 'cutout', format: 'mp4', background: picture };
      return places.map((await playedFrame(await tracecut.encodeVideo(masks, frames, options), 0.12)).colorAt);
    },
    [INSIDE, OUTSIDE],
  );
  expectColor(colors[0], frameColor(INSIDE), 'inside');
  expectColor(colors[1], [0, 255, 0], 'the middle of the picture');
});

test('MP4 adds a row and a column to odd sides, and keeps the times', async () => {
  const { colors, duration, ...file } = await encode(exportPage.page, { format: 'mp4' }, [
    [WIDTH, 40],
    [6, HEIGHT],
  ]);
  expect(file).toMatchObject({ codec: 'avc', size: [WIDTH + 1, HEIGHT + 1], starts: STARTS_MS });
  expect(duration).toBeCloseTo(0.8, 2);
  expectColor(colors[0], frameColor([WIDTH - 1, 40]), 'the added column');
  expectColor(colors[1], frameColor([6, HEIGHT - 1]), 'the added row');
});

test('masks alone need no frames, and a frame rate if they have no times; alpha is white on black', async () => {
  const { page } = exportPage;
  const { colors } = await encode(page, { style: 'masks', colors: ['#000000', '#2060c0'] });
  expectColor(colors[0], [0x20, 0x60, 0xc0], 'the object');
  expectColor(colors[1], [0, 0, 0], 'the background');
  const starts = await page.evaluate(async () => {
    const untimed = { ...masks, times: undefined };
    const startsOf = async (options) =>
      (await readPackets(await tracecut.encodeVideo(untimed, null, { style: 'masks', ...options }))).starts;
    return [await startsOf({}), await startsOf({ frameRate: 10 })];
  });
  expect(starts).toEqual([
    [0, 40, 80, 120, 160, 200],
    [0, 100, 200, 300, 400, 500],
  ]);
  const alpha = await encode(page, { style: 'alpha' });
  expectColor(alpha.colors[0], [255, 255, 255], 'alpha inside');
  expectColor(alpha.colors[1], [0, 0, 0], 'alpha outside');
});

test('frames may be larger than their masks and of any kind, and are read one by one', async () => {
  const results = await exportPage.page.evaluate(
    async (places) => {
      const size = { resizeWidth: 2 * masks.width, resizeHeight: 2 * masks.height, resizeQuality: 'pixelated' };
      const large = await Promise.all(frames.map((frame) => createImageBitmap(frame, size)));
      const draw = (bitmap) => {
        const canvas = new OffscreenCanvas(bitmap.width, bitmap.height);
        canvas.getContext('2d').drawImage(bitmap, 0, 0);
        return canvas;
      };
      const kinds = {
        bitmap: (bitmap) => bitmap,
        frame: (bitmap, k) => ({ frame: new VideoFrame(bitmap, { timestamp: k }), index: k }),
        blob: (bitmap) => draw(bitmap).convertToBlob(),
        pixels: (bitmap) => {
          const { data, width, height } = draw(bitmap).getContext('2d').getImageData(0, 0, bitmap.width, bitmap.height);
          return { data, width, height };
        },
      };
      const outputs = [];
      for (const [name, convert] of Object.entries(kinds)) {
        let open = 0;
        const source = async function* () {
          open += 1;
          try {
            for (const [k, bitmap] of [...large, ...large].entries()) {
              const item = await convert(bitmap, k);
              yield item;
              item.frame?.close();
            }
          } finally {
            open -= 1;
          }
        };
        const blob = await tracecut.encodeVideo(masks, source(), { style: 'cutout', background: 'black' });
        const { width, height, colorAt } = await playedFrame(blob, 0.12);
        outputs.push({ name, open, size: [width, height], colors: places.map(colorAt) });
      }
      return outputs;
    },
    [INSIDE, OUTSIDE].map((place) => place.map((value) => 2 * value)),
  );
  expect(results).toHaveLength(4);
  for (const { name, open, size, colors } of results) {
    expect([open, size], name).toEqual([0, [2 * WIDTH, 2 * HEIGHT]]);
    expectColor(colors[0], frameColor(INSIDE), `${name} inside`);
    expectColor(colors[1], [0, 0, 0], `${name} outside`);
  }
});

test('an abort ends encoding and the frame source', async () => {
  const { name, ended, read, limit } = await exportPage.page.evaluate(async () => {
    const controller = new AbortController();
    let [read, ended] = [0, false];
    const source = function* () {
      try {
        for (const frame of frames) {
          read += 1;
          yield frame;
        }
      } finally {
        ended = true;
      }
    };
    const onProgress = (progress) => progress.done === 2 && controller.abort();
    const options = { style: 'cutout', signal: controller.signal, onProgress };
    const name = await tracecut.encodeVideo(masks, source(), options).then(
      () => 'done',
      (error) => error.name,
    );
    // Frames are read ahead, one for each worker that enlarges.
    return { name, ended, read, limit: 3 + Math.min(4, navigator.hardwareConcurrency) };
  });
  expect([name, ended]).toEqual(['AbortError', true]);
  expect(read).toBeLessThanOrEqual(limit);
});

test('invalid input and missing encoders are refused with a message', async () => {
  const messages = await exportPage.page.evaluate(async () => {
    const refuse = (...args) => errorText(tracecut.encodeVideo(...args));
    const list = [
      await refuse(masks, frames.slice(0, 4)),
      await refuse(masks, [frames[0], new ImageData(3, 3)]),
      await refuse(masks, [{ data: new Uint8Array(3), width: 1, height: 1 }]),
      await refuse(masks, null),
      await refuse(masks, frames, { style: 'cutout', format: 'mp4', background: 'transparent' }),
      await refuse(masks, frames, { style: 'outline' }),
      await refuse(masks, frames, { codec: 'vp9' }),
      await refuse(masks, frames, { style: 'cutout', background: 'no colour' }),
    ];
    const { VideoEncoder } = globalThis;
    delete globalThis.VideoEncoder;
    list.push(await refuse(masks, frames));
    globalThis.VideoEncoder = VideoEncoder;
    return list;
  });
  const expected = [
    /^data: the frames ended after 4 of 6 \(expected one for each frame of the masks\)/,
    /^frame-size-changed: frame 1 is 3 × 3 pixels \(expected 61 × 47/,
    /^data: frame 0 = an Object \(expected something a canvas can draw/,
    /^param: frames = null \(expected an iterable/,
    /^param: background = "transparent" \(expected a colour: MP4 files cannot be transparent, format: 'webm' can\)/,
    /^param: style = "outline" \(expected 'overlay', 'cutout', 'masks', 'alpha'\)/,
    /^param: codec = "vp9" \(expected a known option/,
    /^param: background = "no colour" \(expected 'transparent', 'blurred', 'desaturated', 'dimmed', a CSS colour or a picture\)/,
    /^unsupported: .*masksZip saves the masks as PNG files/,
  ];
  expected.forEach((pattern, k) => expect(messages[k]).toMatch(pattern));
});

test('takes the next codec if the browser lacks one, and says so if it lacks all', async ({ openEmptyPage }) => {
  const encodeWithout = async (codecs, options) => {
    // A page of its own, as support is queried once.
    const page = await openEmptyPage();
    await prepare(page);
    await page.evaluate((pattern) => {
      const query = VideoEncoder.isConfigSupported.bind(VideoEncoder);
      VideoEncoder.isConfigSupported = (config) =>
        new RegExp(pattern).test(config.codec) ? Promise.resolve({ supported: false, config }) : query(config);
    }, codecs);
    return page.evaluate(
      (encodeOptions) =>
        tracecut.encodeVideo(masks, frames, encodeOptions).then(
          async (blob) => (await readPackets(blob)).codec,
          ({ message }) => message,
        ),
      options,
    );
  };
  expect(await encodeWithout('^vp09', { style: 'cutout' })).toBe('vp8');
  expect(await encodeWithout('^(vp09|vp8)', {})).toBe('av1');
  expect(await encodeWithout('^avc', { format: 'mp4' })).toBe('vp9');
  expect(await encodeWithout('^vp', { style: 'cutout' })).toMatch(
    /encodes none of vp9, vp8 for WebM files of 61 × 47 pixels; try a background colour and format: 'mp4', or PNG files by masksZip/,
  );
  expect(await encodeWithout('.', { format: 'mp4' })).toMatch(
    /encodes none of avc, vp9, av1 for MP4 files of 62 × 48 pixels; try format: 'webm'/,
  );
});

test.describe('colours', () => {
  needsFfmpeg();
  const films = useFilms();

  test('videos have the colours of BT.709 in limited range', async () => {
    const entries = 'stream=width,pix_fmt,color_range,color_space,color_transfer,color_primaries';
    for (const options of [{ format: 'mp4' }, { format: 'webm' }, { style: 'cutout' }]) {
      const bytes = await exportPage.page.evaluate(async (encodeOptions) => {
        const blob = await tracecut.encodeVideo(masks, frames, { ...encodeOptions, quality: 'very-high' });
        return [...new Uint8Array(await blob.arrayBuffer())];
      }, options);
      const path = films.path(`colours.${options.format ?? 'webm'}`);
      writeFileSync(path, Buffer.from(bytes));
      const probe = ['-v', 'error', '-select_streams', 'v', '-show_entries', entries, '-of', 'json', path];
      const [{ width, ...colours }] = JSON.parse(execFileSync('ffprobe', probe)).streams;
      expect(colours).toEqual({
        ...{ pix_fmt: 'yuv420p', color_range: 'tv', color_space: 'bt709' },
        ...{ color_transfer: 'bt709', color_primaries: 'bt709' },
      });
      if (options.style) continue;
      // Frame 5 is [4 x, 200, 128].
      const [x, y] = OUTSIDE;
      const raw = films.ffmpeg(['-i', path, '-fps_mode', 'passthrough', '-f', 'rawvideo', '-pix_fmt', 'yuv420p', '-']);
      const luma = raw[(raw.length / 6) * 5 + y * width + x];
      const expected = 16 + (219 / 255) * (0.2126 * 4 * x + 0.7152 * 200 + 0.0722 * 128);
      expect(Math.abs(luma - expected), `${luma} (expected ${expected})`).toBeLessThan(4);
    }
  });
});

test('an animated PNG plays with its colours, its opacity and its times', async () => {
  const { count, durations, wrong } = await exportPage.page.evaluate(async () => {
    const { encodeImages } = await import('/dist/export.js');
    const data = await new Response(await encodeImages(masks, frames, { format: 'apng' })).arrayBuffer();
    const decoder = new ImageDecoder({ data, type: 'image/png', colorSpaceConversion: 'none' });
    await decoder.tracks.ready;
    await decoder.completed;
    const { frameCount } = decoder.tracks.selectedTrack;
    const durations = [];
    let wrong = 0;
    for (let t = 0; t < frameCount; t += 1) {
      const { image } = await decoder.decode({ frameIndex: t });
      durations.push(Math.round(image.duration / 1000));
      const context = new OffscreenCanvas(masks.width, masks.height).getContext('2d');
      context.drawImage(image, 0, 0);
      const pixels = new Uint32Array(context.getImageData(0, 0, masks.width, masks.height).data.buffer);
      const expected = new Uint32Array(frames[t].data.buffer);
      masks.labels(t).forEach((label, p) => (wrong += pixels[p] !== (label > 0 ? expected[p] : 0)));
    }
    return { count: frameCount, durations, wrong };
  });
  expect([count, wrong]).toEqual([6, 0]);
  expect(durations).toEqual([40, 60, 40, 60, 300, 300]);
});

/** Runs in a page, in a worker, and in Node: all kinds of files of a clip, as text. */
async function maskFiles(tracecut) {
  const clip = await tracecut.synthClip({ width: 120, height: 67, frames: 5 });
  const masks = {
    ...{ width: 120, height: 67, numFrames: 5, times: [0, 0.04, 0.08, 0.12, 0.2] },
    labels: (t) => clip.mask(t),
  };
  const { maskPng, masksZip, cocoRle, labelsNpy } = tracecut;
  const files = [
    await maskPng(masks, 2),
    await maskPng(masks, 2, { object: 1 }),
    await masksZip(masks),
    await masksZip(masks, { perObject: true }),
    labelsNpy(masks),
  ];
  const texts = files.map((file) => Array.from(file, (byte) => String.fromCharCode(byte)).join(''));
  return [...texts, JSON.stringify(await cocoRle(masks))];
}

test('files of masks have the same bytes in a page, in a worker and in Node', async () => {
  const { page } = exportPage;
  const serve = (name, body) =>
    page.route(`**/${name}`, (route) => route.fulfill({ contentType: 'text/javascript', body }));
  await serve('files.js', `export ${maskFiles}`);
  await serve(
    'worker.js',
    "import { maskFiles } from './files.js'; import('/model/library.js').then(maskFiles).then((files) => postMessage(files));",
  );
  const [inPage, inWorker] = await page.evaluate(async () => {
    const worker = new Worker('/worker.js', { type: 'module' });
    const answer = new Promise((resolve, reject) =>
      Object.assign(worker, { onmessage: ({ data }) => resolve(data), onerror: reject }),
    );
    const { maskFiles } = await import('/files.js');
    return [await maskFiles(tracecut), await answer];
  });
  const hashes = (files) => files.map((file) => fnv1a(Buffer.from(file, 'utf8')));
  const expected = hashes(await maskFiles(packageInNode));
  expect(hashes(inPage)).toEqual(expected);
  expect(hashes(inWorker)).toEqual(expected);
});
