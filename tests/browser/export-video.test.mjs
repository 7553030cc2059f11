// Videos that the browser encodes, opened again by the browser: under a strict content security policy, as a page may
// have it.

import assert from 'node:assert/strict';
import { execFileSync } from 'node:child_process';
import { writeFileSync } from 'node:fs';
import { test } from 'node:test';
import { createSession, encodeVideo, synthClip } from '../../dist/node.js';
import { useServerAndBrowser } from '../site.mjs';
import { emptyPage, useEmptyPage } from './empty-page.mjs';
import { useFilms, withFfmpeg } from './video-clips.mjs';

const site = useServerAndBrowser();
const films = useFilms();

/** Frame `t` is `[4 x, 40 t, 128]`; the object a square. Odd sides, and times that are not even. */
const WIDTH = 61;
const HEIGHT = 47;
const TIMES = [5, 5.04, 5.1, 5.14, 5.2, 5.5];
const INSIDE = [32, 20];
const OUTSIDE = [6, 40];
const OBJECT_1 = [0xe6, 0x9f, 0x00];

const prepared = (page) => page.evaluate(prepare, [WIDTH, HEIGHT, TIMES]);
const shared = useEmptyPage(site, prepared);

/** Runs in the page: the clip, and how files are read again. */
async function prepare([width, height, times]) {
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
  /** Packets, as they lie in the file. */
  const packets = async (blob) => {
    const input = new media.Input({ formats: media.ALL_FORMATS, source: new media.BlobSource(blob) });
    const track = await input.getPrimaryVideoTrack();
    const starts = [];
    for await (const { timestamp, sideData } of new media.EncodedPacketSink(track).packets())
      starts.push([Math.round(1000 * timestamp), Boolean(sideData.alpha)]);
    return { codec: track.codec, starts };
  };
  /** What a player shows at a time: colours and opacity of places. */
  const shown = async (blob, time, ...places) => {
    const video = Object.assign(document.createElement('video'), { muted: true, src: URL.createObjectURL(blob) });
    const event = (name) =>
      new Promise((done, failed) => Object.assign(video, { [`on${name}`]: done, onerror: () => failed(video.error) }));
    await event('loadeddata');
    const { videoWidth, videoHeight, duration } = video;
    const sought = event('seeked');
    video.currentTime = time;
    await sought;
    // The picture may come a little after the word that it has.
    const context = new OffscreenCanvas(videoWidth, videoHeight).getContext('2d', { willReadFrequently: true });
    for (let left = 200; left > 0; left -= 1) {
      context.drawImage(video, 0, 0);
      if (context.getImageData(0, 0, videoWidth, videoHeight).data.some(Boolean)) break;
      await new Promise((done) => setTimeout(done, 20));
    }
    const colors = places.map(([x, y]) => [...context.getImageData(x, y, 1, 1).data]);
    return { size: [videoWidth, videoHeight], duration, colors };
  };
  globalThis.kit = { ...tracecut, frames, masks, packets, shown };
}

/** Encodes in the page and reads again what is at 0.12 s, in the third frame. */
function encoded(page, options, places = [INSIDE, OUTSIDE]) {
  return page.evaluate(
    async ([chosen, spots]) => {
      const { encodeVideo: encode, masks, frames, packets, shown } = globalThis.kit;
      const progress = [];
      const blob = await encode(masks, chosen.style === 'masks' ? null : frames, {
        ...chosen,
        onProgress: ({ done, total }) => progress.push(`${done}/${total}`),
      });
      return { type: blob.type, progress, ...(await packets(blob)), ...(await shown(blob, 0.12, ...spots)) };
    },
    [options, places],
  );
}

function near(color, wanted, what) {
  const worst = Math.max(...wanted.map((value, k) => Math.abs(value - color[k])));
  assert.ok(worst <= 12, `${what}: ${color} (expected about ${wanted})`);
}

const frameColor = ([x]) => [4 * x, 80, 128];
const mix = (a, b) => a.map((value, k) => (value + b[k]) / 2);

test('an overlay has every frame at its own time, and the masks over it', async () => {
  const { page } = shared;
  const { type, codec, starts, size, duration, colors, progress } = await encoded(page, {});
  assert.equal(type, 'video/webm');
  assert.equal(codec, 'vp9');
  assert.deepEqual(
    starts.map(([time]) => time),
    [0, 40, 100, 140, 200, 500],
  );
  assert.deepEqual(size, [WIDTH, HEIGHT]);
  assert.ok(Math.abs(duration - 0.8) < 0.01, `${duration}`);
  near(colors[0], mix(frameColor(INSIDE), OBJECT_1), 'inside');
  near(colors[1], frameColor(OUTSIDE), 'outside');
  assert.deepEqual(progress, ['1/6', '2/6', '3/6', '4/6', '5/6', '6/6']);
});

test('cut-out objects are transparent around, with clean edges', async () => {
  const { page } = shared;
  const edge = [
    [21, 20],
    [17, 20],
    [43, 33],
    [46, 36],
  ];
  const { codec, starts, size, colors } = await encoded(page, { style: 'cutout' }, [INSIDE, OUTSIDE, ...edge]);
  assert.equal(codec, 'vp9');
  assert.deepEqual(
    starts,
    [0, 40, 100, 140, 200, 500].map((time) => [time, true]),
  );
  assert.deepEqual(size, [WIDTH, HEIGHT]);
  near(colors[0], [...frameColor(INSIDE), 255], 'inside');
  near(colors[2], [...frameColor(edge[0]), 255], 'within the edge');
  near(colors[4], [...frameColor(edge[2]), 255], 'within the corner');
  for (const k of [1, 3, 5]) assert.ok(colors[k][3] <= 8, `${colors[k]} is not transparent`);
});

test('cut-out objects lie on any colour, in MP4 on green', async () => {
  const { page } = shared;
  const green = await encoded(page, { style: 'cutout', format: 'mp4' });
  assert.deepEqual([green.type, green.codec], ['video/mp4', 'avc']);
  near(green.colors[0], frameColor(INSIDE), 'inside');
  near(green.colors[1], [0x00, 0xb1, 0x40], 'outside');
  const blue = await encoded(page, { style: 'cutout', background: 'rgb(20 40 200)' });
  near(blue.colors[0], frameColor(INSIDE), 'inside');
  near(blue.colors[1], [20, 40, 200, 255], 'outside');
  const others = await encoded(page, { style: 'cutout', background: 'white', objects: [2] });
  near(others.colors[0], [255, 255, 255], 'an object that is not chosen');
});

test('cut-out objects lie on their own frame, blurred, or on a picture', async () => {
  const { page } = shared;
  const blurred = await encoded(page, { style: 'cutout', background: 'blurred' });
  near(blurred.colors[0], frameColor(INSIDE), 'inside');
  // The frames are ramps, which look the same when they are blurred, but for their ends.
  near(blurred.colors[1], [24, 80, 128], 'outside');
  const dimmed = await encoded(page, { style: 'cutout', background: 'dimmed' });
  near(dimmed.colors[0], frameColor(INSIDE), 'inside');
  near(
    dimmed.colors[1],
    frameColor(OUTSIDE).map((v) => 0.35 * v),
    'darker outside',
  );
  const grey = await encoded(page, { style: 'cutout', background: 'desaturated' });
  near(grey.colors[0], frameColor(INSIDE), 'inside');
  const [red, green, blue] = grey.colors[1];
  assert.ok(Math.max(red, green, blue) - Math.min(red, green, blue) <= 8, `grey outside: ${grey.colors[1]}`);
  const colors = await page.evaluate(
    async (places) => {
      const { encodeVideo: encode, masks, frames, shown } = globalThis.kit;
      const picture = new OffscreenCanvas(400, 100);
      const context = picture.getContext('2d');
      for (const [k, color] of ['#ff0000', '#00ff00', '#ff0000'].entries()) {
        context.fillStyle = color;
        context.fillRect([0, 120, 280][k], 0, 160, 100);
      }
      const blob = await encode(masks, frames, { style: 'cutout', format: 'mp4', background: picture });
      return (await shown(blob, 0.12, ...places)).colors;
    },
    [INSIDE, OUTSIDE],
  );
  near(colors[0], frameColor(INSIDE), 'inside');
  near(colors[1], [0, 255, 0], 'the middle of the picture');
});

test('MP4 has even sides, one more where they are odd, and the same times', async () => {
  const { page } = shared;
  const { codec, starts, size, duration, colors } = await encoded(page, { format: 'mp4' }, [
    INSIDE,
    [WIDTH, 40],
    [6, HEIGHT],
  ]);
  assert.equal(codec, 'avc');
  assert.deepEqual(size, [WIDTH + 1, HEIGHT + 1]);
  assert.deepEqual(
    starts.map(([time]) => time),
    [0, 40, 100, 140, 200, 500],
  );
  assert.ok(Math.abs(duration - 0.8) < 0.01, `${duration}`);
  near(colors[1], frameColor([WIDTH - 1, 40]), 'the column added');
  near(colors[2], frameColor([6, HEIGHT - 1]), 'the row added');
});

test('masks alone need no frames, and a rate where there are no times', async () => {
  const { page } = shared;
  const { colors } = await encoded(page, { style: 'masks', colors: ['#000000', '#2060c0'] });
  near(colors[0], [0x20, 0x60, 0xc0], 'the object');
  near(colors[1], [0, 0, 0], 'the background');
  const times = await page.evaluate(async () => {
    const { encodeVideo: encode, masks, packets } = globalThis.kit;
    const bare = { ...masks, times: undefined };
    const starts = async (options) =>
      (await packets(await encode(bare, null, { style: 'masks', ...options }))).starts.map(([time]) => time);
    return [await starts({}), await starts({ frameRate: 10 })];
  });
  assert.deepEqual(times, [
    [0, 40, 80, 120, 160, 200],
    [0, 100, 200, 300, 400, 500],
  ]);
});

test('frames may be larger than their masks, of any kind, and come one by one', async () => {
  const { page } = shared;
  const results = await page.evaluate(
    async ([inside, outside]) => {
      const { encodeVideo: encode, masks, frames, shown } = globalThis.kit;
      const large = await Promise.all(
        frames.map((frame) =>
          createImageBitmap(frame, {
            resizeWidth: 2 * frame.width,
            resizeHeight: 2 * frame.height,
            resizeQuality: 'pixelated',
          }),
        ),
      );
      const canvas = (bitmap) => {
        const own = new OffscreenCanvas(bitmap.width, bitmap.height);
        own.getContext('2d').drawImage(bitmap, 0, 0);
        return own;
      };
      const kinds = {
        bitmap: (bitmap) => bitmap,
        frame: (bitmap, k) => ({ frame: new VideoFrame(bitmap, { timestamp: k }), index: k }),
        blob: (bitmap) => canvas(bitmap).convertToBlob(),
        pixels: (bitmap) => {
          const { data, width, height } = canvas(bitmap)
            .getContext('2d')
            .getImageData(0, 0, bitmap.width, bitmap.height);
          return { data, width, height };
        },
      };
      const found = [];
      for (const [name, make] of Object.entries(kinds)) {
        let open = 0;
        const source = async function* () {
          open += 1;
          try {
            for (const [k, bitmap] of [...large, ...large].entries()) {
              const item = await make(bitmap, k);
              yield item;
              item.frame?.close();
            }
          } finally {
            open -= 1;
          }
        };
        const blob = await encode(masks, source(), { style: 'cutout', background: 'black' });
        found.push([
          name,
          open,
          await shown(
            blob,
            0.12,
            inside.map((v) => 2 * v),
            outside.map((v) => 2 * v),
          ),
        ]);
      }
      return found;
    },
    [INSIDE, OUTSIDE],
  );
  assert.equal(results.length, 4);
  for (const [name, still, { size, colors }] of results) {
    assert.deepEqual([still, size], [0, [2 * WIDTH, 2 * HEIGHT]], name);
    near(colors[0], frameColor(INSIDE), `${name} inside`);
    near(colors[1], [0, 0, 0], `${name} outside`);
  }
});

test('an abort ends it, and the frame source is notified', async () => {
  const { page } = shared;
  const outcome = await page.evaluate(async () => {
    const { encodeVideo: encode, masks, frames } = globalThis.kit;
    const controller = new AbortController();
    let [given, ended] = [0, false];
    const source = function* () {
      try {
        for (const frame of frames) {
          given += 1;
          yield frame;
        }
      } finally {
        ended = true;
      }
    };
    const options = {
      style: 'cutout',
      signal: controller.signal,
      onProgress: ({ done }) => done === 2 && controller.abort(),
    };
    const name = await encode(masks, source(), options).then(
      () => 'done',
      (error) => error.name,
    );
    // Frames are taken ahead, as many as workers enlarge at once.
    const ahead = Math.min(4, navigator.hardwareConcurrency);
    return { name, most: Math.min(frames.length, 3 + ahead), given, ended };
  });
  const { name, most, given, ended } = outcome;
  assert.deepEqual({ name, ended }, { name: 'AbortError', ended: true });
  assert.ok(given <= most, `${given} frames were read, of at most ${most}`);
});

test('videos have the colours of BT.709 in limited range', withFfmpeg, async () => {
  const { page } = shared;
  const entries = 'stream=width,pix_fmt,color_range,color_space,color_transfer,color_primaries';
  for (const options of [{ format: 'mp4' }, { format: 'webm' }, { style: 'cutout' }]) {
    const bytes = await page.evaluate(async (chosen) => {
      const { encodeVideo: encode, masks, frames } = globalThis.kit;
      return [
        ...new Uint8Array(await (await encode(masks, frames, { ...chosen, quality: 'very-high' })).arrayBuffer()),
      ];
    }, options);
    const path = films.path(`colours.${options.format ?? 'webm'}`);
    writeFileSync(path, Buffer.from(bytes));
    const probe = ['-v', 'error', '-select_streams', 'v', '-show_entries', entries, '-of', 'json', path];
    const [{ width, ...colours }] = JSON.parse(execFileSync('ffprobe', probe)).streams;
    assert.deepEqual(colours, {
      ...{ pix_fmt: 'yuv420p', color_range: 'tv', color_space: 'bt709' },
      ...{ color_transfer: 'bt709', color_primaries: 'bt709' },
    });
    if (options.style) continue;
    // Frame 5 is [4 x, 200, 128].
    const [x, y] = OUTSIDE;
    const raw = films.ffmpeg(['-i', path, '-fps_mode', 'passthrough', '-f', 'rawvideo', '-pix_fmt', 'yuv420p', '-']);
    const luma = raw[(raw.length / 6) * 5 + y * width + x];
    const expected = 16 + (219 / 255) * (0.2126 * 4 * x + 0.7152 * 200 + 0.0722 * 128);
    assert.ok(Math.abs(luma - expected) < 4, `${luma} (expected ${expected})`);
  }
});

test('what cannot be encoded is refused in words', async () => {
  const { page } = shared;
  const messages = await page.evaluate(async () => {
    const { encodeVideo: encode, masks, frames } = globalThis.kit;
    const failure = (...given) =>
      encode(...given).then(
        () => 'no error',
        (error) => `${error.code}: ${error.message}`,
      );
    const list = [
      await failure(masks, frames.slice(0, 4)),
      await failure(masks, [frames[0], new ImageData(3, 3)]),
      await failure(masks, [{ data: new Uint8Array(3), width: 1, height: 1 }]),
      await failure(masks, null),
      await failure(masks, frames, { style: 'cutout', format: 'mp4', background: 'transparent' }),
      await failure(masks, frames, { style: 'outline' }),
      await failure(masks, frames, { codec: 'vp9' }),
      await failure(masks, frames, { style: 'cutout', background: 'no colour' }),
    ];
    const { VideoEncoder } = globalThis;
    delete globalThis.VideoEncoder;
    list.push(await failure(masks, frames));
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
  expected.forEach((pattern, k) => assert.match(messages[k], pattern));
});

test('takes the next codec where the browser lacks one, and says so where it lacks all', async (t) => {
  const lacking = async (pattern, options) => {
    // Of its own: what a browser encodes is asked once.
    const page = await emptyPage(t, site);
    await prepared(page);
    await page.evaluate((names) => {
      const asked = VideoEncoder.isConfigSupported.bind(VideoEncoder);
      VideoEncoder.isConfigSupported = (config) =>
        new RegExp(names).test(config.codec) ? Promise.resolve({ supported: false, config }) : asked(config);
    }, pattern);
    return encoded(page, options).then(
      ({ codec, colors }) => ({ codec, colors }),
      (error) => ({ words: error.message }),
    );
  };
  const clear = await lacking('^vp09', { style: 'cutout' });
  assert.equal(clear.codec, 'vp8');
  near(clear.colors[0], [...frameColor(INSIDE), 255], 'inside');
  assert.ok(clear.colors[1][3] <= 8, `${clear.colors[1]} is not transparent`);
  assert.equal((await lacking('^(vp09|vp8)', {})).codec, 'av1');
  assert.equal((await lacking('^avc', { format: 'mp4' })).codec, 'vp9');
  assert.match(
    (await lacking('^vp', { style: 'cutout' })).words,
    /encodes none of vp9, vp8 for WebM files of 61 × 47 pixels; try a background colour and format: 'mp4', or PNG files by masksZip/,
  );
  assert.match(
    (await lacking('.', { format: 'mp4' })).words,
    /encodes none of avc, vp9, av1 for MP4 files of 62 × 48 pixels; try format: 'webm'/,
  );
});

test('a video that was segmented is cut out, frame for frame', async () => {
  const { page } = shared;
  const { shots, starts, colors, wanted, labels } = await page.evaluate(async () => {
    const { encodeVideo: encode, packets, segmentVideo, shown, synthClip: synth, videoFrames } = globalThis.kit;
    const clip = await synth({ width: 128, height: 72, frames: 8, seed: 5 });
    const frames = Array.from({ length: 8 }, (_, k) => clip.frame(k));
    const none = {
      width: 128,
      height: 72,
      numFrames: 8,
      labels: () => new Uint8Array(128 * 72),
      times: [0, 0.04, 0.1, 0.14, 0.2, 0.24, 0.3, 0.34],
    };
    const video = await encode(none, frames, { quality: 'very-high' });
    const result = await segmentVideo(video).collect();
    const cutout = await encode(result, videoFrames(video), { style: 'cutout' });
    const mask = result.labels(2);
    const spots = Array.from({ length: 18 * 32 }, (_, k) => [4 * (k % 32) + 2, 4 * Math.floor(k / 32) + 2]);
    return {
      shots: result.shots,
      starts: (await packets(cutout)).starts,
      colors: (await shown(cutout, 0.12, ...spots)).colors,
      wanted: spots.map(([x, y]) => [...frames[2].data.subarray(4 * (128 * y + x), 4 * (128 * y + x) + 3)]),
      labels: spots.map(([x, y]) => mask[128 * y + x]),
    };
  });
  assert.deepEqual(shots, [{ first: 0, last: 7 }]);
  assert.deepEqual(
    starts,
    [0, 40, 100, 140, 200, 240, 300, 340].map((time) => [time, true]),
  );
  const inside = labels
    .map((label, k) => ({ label, color: colors[k], wanted: wanted[k] }))
    .filter(({ label }) => label > 0);
  assert.ok(inside.length > 10, `${inside.length} places in objects`);
  const opacity = (list) => list.reduce((sum, color) => sum + color[3], 0) / list.length / 255;
  assert.ok(opacity(inside.map(({ color }) => color)) > 0.97);
  assert.ok(opacity(colors.filter((_, k) => labels[k] === 0)) < 0.03);
  const errors = inside
    .map(({ color, wanted: own }) => Math.max(...own.map((value, c) => Math.abs(value - color[c]))))
    .sort((a, b) => a - b);
  assert.ok(errors[errors.length >> 1] < 24, `colours are off by ${errors[errors.length >> 1]} in the middle`);
});

test('Node says what to use instead', async () => {
  const clip = await synthClip({ width: 64, height: 48, frames: 4 });
  const session = await createSession();
  for (let t = 0; t < 4; t += 1) await session.push(clip.frame(t));
  const result = await session.run();
  session.close();
  await assert.rejects(encodeVideo(result, [clip.frame(0)]), { code: 'unsupported', message: /WebCodecs.*masksZip/ });
});
