// Video files as cameras, browsers and programs write them: each picture once, with the time of the file, and damage is reported.
// Reads the files of the intake table that need decoders of Chromium; tests/native/intake.test.mjs reads all files.

import { existsSync, readFileSync, readdirSync, statSync, writeFileSync } from 'node:fs';
import { join } from 'node:path';
import { CASES, CLIP, checkOutcome, ensureClips, maskOfRed } from '../intake.mjs';
import { expect, giveFile, test, useLibrary } from './fixtures.mjs';
import { range } from './page-helpers.mjs';
import { FILM, H264, needsFfmpeg, useFilms } from './video-clips.mjs';

needsFfmpeg();

const { width, height, count } = FILM;
const even = range(count).map((k) => k / 25);
const CLIP_SIZE = `${CLIP.width}x${CLIP.height}`;

const library = useLibrary((page) => page.evaluate(`globalThis.maskOfRed = ${maskOfRed}`));
const films = useFilms();
const { film, ffmpeg } = films;
/** Returns the path of a file that a test made, or of one of the intake table. */
const pathOf = (name) => (existsSync(films.path(name)) ? films.path(name) : join(ensureClips(), name));

/** Reads a file in the page. `reports` tells whether damage is reported to `onDamage`. */
async function readFile(name, { options = {}, reports = false } = {}) {
  await giveFile(library.page, pathOf(name));
  return library.page.evaluate(readInPage, { options, reports });
}

/** Runs in the page: reads all frames and facts of a file, and recognizes pictures of the film by the place of its square. */
async function readInPage({ options, reports }) {
  const pictureOf = ({ data, width: columns }) => {
    let [sum, numRed] = [0, 0];
    for (let at = 0; at < data.length; at += 4) {
      if (data[at] - data[at + 1] < 40) continue;
      sum += (at / 4) % columns;
      numRed += 1;
    }
    return Math.round(((240 / columns) * (sum / numRed) + 0.5 - 54) / 3);
  };
  const read = { pictures: [], sizes: [], times: [], durations: [], damage: null, error: null };
  const onDamage = reports ? ({ frames, error }) => (read.damage = { frames, code: error.code }) : undefined;
  try {
    for await (const { pixels, time, duration } of tracecut.videoFrames(file, { ...options, onDamage })) {
      const picture = await pixels();
      read.pictures.push(pictureOf(picture));
      read.sizes.push(`${picture.width}x${picture.height}`);
      read.times.push(time);
      read.durations.push(duration);
    }
  } catch ({ code, message, frames }) {
    read.error = { code, message, frames };
  }
  const info = await tracecut.videoInfo(file, { onDamage() {} }).catch(({ code, message }) => ({ code, message }));
  return { ...read, sizes: [...new Set(read.sizes)], info: { ...info, times: info.times && [...info.times] } };
}

function expectTimes(times, expected) {
  expect(times).toHaveLength(expected.length);
  times.forEach((time, k) => expect(Math.abs(time - expected[k]), `time of frame ${k}`).toBeLessThan(0.0011));
}

/** Checks that a file has all pictures of the film once, at these times. */
async function expectFilm(name, times) {
  const read = await readFile(name);
  expect(read.error).toBeNull();
  expect(read.pictures).toEqual(range(count));
  expect(read.sizes).toEqual([`${width}x${height}`]);
  expectTimes(read.times, times);
  expectTimes(read.info.times, times);
}

/** One or two files for each codec, transform, colour space, kind of damage and kind of animated image. */
const DECODED_FILES = [
  ...['plain.mp4', 'vp9.webm', 'recording.webm', 'alpha.webm', 'alpha-vp9.webm', 'edit-list.mp4', 'cover.mkv'],
  ...['rot90.mp4', 'rot180.mp4', 'mirrored.mp4', 'sar.mp4', 'sar-high.mp4', 'size-changes.webm', 'bt709.mp4'],
  ...['cut-off.mp4', 'cut-off.webm', 'cut-off-fragments.mp4', 'hole.mp4'],
  ...['delays.png', 'delays.gif', 'delays.webp', 'exif'],
];

for (const row of CASES.filter(({ file }) => DECODED_FILES.includes(file)))
  test(row.name, async () => {
    const path = join(ensureClips(), row.file);
    const isFolder = statSync(path).isDirectory();
    await library.page.setInputFiles('#file', isFolder ? filesIn(path) : path);
    const outcome = await library.page.evaluate(readIntakeFile, { isFolder });
    expect(outcome.error).toBeUndefined();
    checkOutcome(row, outcome);
    if (outcome.info && !row.isTruncated) checkInfo(row, outcome);
  });

/** Checks the facts of a file against its frames. */
function checkInfo(row, { info, times, lastDuration }) {
  expect(info).toMatchObject({ width: CLIP.width, height: CLIP.height, numFrames: row.numFrames, decodable: true });
  expect(info.times).toEqual(times);
  const duration = times.at(-1) + lastDuration - times[0];
  expect(info.duration).toBeCloseTo(duration, 6);
  expect(info.frameRate).toBeCloseTo(info.numFrames / duration, 5);
}

const filesIn = (folder) =>
  readdirSync(folder, { withFileTypes: true })
    .filter((entry) => entry.isFile())
    .map(({ name }) => join(folder, name));

/** Runs in the page: reads frames and facts of a file, or segments a folder. */
async function readIntakeFile({ isFolder }) {
  const { readFrames, segmentVideo, videoFrames, videoInfo } = globalThis.tracecut;
  const { files } = document.querySelector('#file');
  const outcome = { times: null, masks: [], isTruncated: false };
  const onDamage = () => (outcome.isTruncated = true);
  // The masks that are checked: more of them take long to transfer.
  const endMasks = (count, maskOf) => Object.fromEntries([0, count - 1].map((t) => [t, [...maskOf(t)]]));
  try {
    if (isFolder) {
      const result = await segmentVideo(readFrames([...files])).collect();
      const { width, height, numFrames } = result;
      return { ...outcome, width, height, numFrames, masks: endMasks(numFrames, (t) => result.labels(t)) };
    }
    outcome.times = [];
    for await (const { pixels, width, height, time, duration } of videoFrames(files[0], { onDamage })) {
      Object.assign(outcome, { width, height, lastDuration: duration });
      outcome.masks.push(globalThis.maskOfRed(await pixels()));
      outcome.times.push(time);
    }
    const info = await videoInfo(files[0], { onDamage });
    const masks = endMasks(outcome.masks.length, (t) => outcome.masks[t]);
    return { ...outcome, masks, numFrames: outcome.times.length, info: { ...info, times: [...info.times] } };
  } catch (error) {
    return { error: { code: error.code ?? error.name, message: error.message } };
  }
}

test('without durations in the file, the last picture lasts as long as the one before', async () => {
  const { durations } = await readFile('alpha.webm');
  expect(durations.at(-1)).toBeCloseTo(durations.at(-2), 6);
});

test('of two pictures with equal times the second one moves on', async () => {
  const twice = 'settb=1/1000,setpts=N*40-40*eq(N\\,5)';
  film('equal.webm', ['-vf', twice, '-fps_mode', 'passthrough', '-enc_time_base', '1:1000', '-b:v', '2M']);
  await expectFilm('equal.webm', even);
});

test('VP8 pictures that are never shown are left out', async () => {
  const hidden = ['-auto-alt-ref', '1', '-lag-in-frames', '16', '-b:v', '200k', '-cpu-used', '4'];
  const encode = ['-f', 'lavfi', '-i', 'testsrc2=s=96x72:r=25:d=1.6', '-c:v', 'libvpx', ...hidden];
  ffmpeg([...encode, '-pass', '1', '-f', 'null', '-']);
  ffmpeg([...encode, '-pass', '2', 'hidden.webm']);
  const read = await readFile('hidden.webm');
  expect([read.error, read.info.numFrames]).toEqual([null, 40]);
  expectTimes(
    read.times,
    range(40).map((k) => k / 25),
  );
});

test('a transport stream may have pixels that are not square, and several tracks, of which the largest is read', async () => {
  for (const [source, name] of [
    ['sar.mp4', 'wide.ts'],
    ['two-tracks.mp4', 'two.ts'],
  ]) {
    ffmpeg(['-i', pathOf(source), '-map', '0', '-c', 'copy', '-f', 'mpegts', name]);
    const { sizes, times } = await readFile(name);
    expect([sizes, times.length], name).toEqual([[CLIP_SIZE], count]);
  }
});

test('where the size changes, frames are scaled to the first one, also if only later ones are selected', async () => {
  const { times, sizes } = await readFile('size-changes.webm', { options: { start: 0.4 } });
  expectTimes(times, even.slice(10));
  expect(sizes).toEqual([CLIP_SIZE]);
});

test('files are recognized by their content, without hidden files, in the order of their numbers', async () => {
  await giveFile(library.page, pathOf('delays.png'));
  const kinds = await library.page.evaluate(async () => {
    const named = (name, ...parts) => new File(parts, name, { type: 'video/mp4' });
    const files = [
      named('IMG_10', file),
      named('._img_2', file),
      named('img_2', 'GET / HTTP/1.1 '.repeat(99)),
      named('a'),
    ];
    return (await tracecut.sortFiles(files)).map((entry) => [entry.file.name, entry.kind, entry.type]);
  });
  expect(kinds).toEqual([
    ['a', null, null],
    ['img_2', null, null],
    ['IMG_10', 'image', 'image/png'],
  ]);
});

test('a transport stream that begins between two key pictures is read from the first of them on', async () => {
  film('long.ts', [...H264, '-g', '5', '-f', 'mpegts']);
  const complete = await readFile('long.ts');
  expect(complete.pictures).toEqual(range(count));
  // From the second packet of the video on: the first key picture is lost.
  const bytes = readFileSync(pathOf('long.ts'));
  writeFileSync(films.path('tapped.ts'), bytes.subarray(188 * Math.ceil((0.3 * bytes.length) / 188)));
  const read = await readFile('tapped.ts');
  const [first] = read.pictures;
  expect(read.error).toBeNull();
  expect([5, 10]).toContain(first);
  expect(read.pictures).toEqual(range(count).slice(first));
  expectTimes(read.times, complete.times.slice(first));
  expect(read.info.numFrames).toBe(read.pictures.length);
});

test('an animated AVIF has each picture once; without ImageDecoder animations are refused and still images read', async () => {
  film('moving.avif', ['-c:v', 'libaom-av1', '-cpu-used', '8', '-crf', '20']);
  await expectFilm('moving.avif', even);
  film('still.png', ['-frames:v', '1']);
  await library.page.evaluate(() => {
    globalThis.OriginalDecoder = ImageDecoder;
    delete globalThis.ImageDecoder;
  });
  for (const name of ['delays.webp', 'delays.png', 'moving.avif']) {
    const { error } = await readFile(name);
    expect(error, name).toMatchObject({
      code: 'unsupported',
      message: expect.stringMatching(`image/${name.split('.')[1]}`),
    });
  }
  expect((await readFile('still.png')).sizes).toEqual([`${width}x${height}`]);
  await library.page.evaluate(() => (globalThis.ImageDecoder = OriginalDecoder));
});

test('containers that no browser reads, and codecs that this one does not decode, are named', async () => {
  film('old.avi', ['-c:v', 'mjpeg']);
  const avi = await readFile('old.avi');
  expect(avi.error.code).toBe('no-video');
  expect(avi.error.message).toMatch(/video\/x-msvideo cannot be read here; convert it/);
  film('old.mp4', ['-c:v', 'mpeg4']);
  const mp4 = await readFile('old.mp4');
  expect([mp4.error.code, mp4.info.decodable, mp4.info.numFrames]).toEqual(['codec', false, count]);
  expect(mp4.error.message).toMatch(/^the codec mp4v cannot be decoded by this browser; convert it/);
});

test('a video without colour information is read as BT.601', async () => {
  const tags = ['-colorspace', 'smpte170m', '-color_primaries', 'smpte170m', '-color_trc', 'smpte170m'];
  film('plain.mp4', H264);
  film('tagged.mp4', [...H264, ...tags]);
  const means = [];
  for (const name of ['plain.mp4', 'tagged.mp4']) {
    await giveFile(library.page, pathOf(name));
    means.push(
      await library.page.evaluate(async () => {
        const sums = [0, 0, 0];
        for await (const { pixels } of tracecut.videoFrames(file, { maxFrames: 1 })) {
          const { data } = await pixels();
          data.forEach((level, at) => at % 4 < 3 && (sums[at % 4] += (4 * level) / data.length));
        }
        return sums;
      }),
    );
  }
  means[0].forEach((mean, channel) => expect(Math.abs(mean - means[1][channel])).toBeLessThan(1));
});

test.describe('damaged files', () => {
  for (const name of ['cut-off.mp4', 'cut-off.webm'])
    test(`${name} gives the frames before the damage, then an error that counts them`, async () => {
      const { times, error } = await readFile(name);
      expect(times).toHaveLength(8);
      expect(error).toMatchObject({ code: 'truncated', frames: 8 });
      expect(error.message).toMatch(/breaks off after frame 8.*cut off or damaged$/);
    });

  test('damage after the selected frames is not reported, nor is any of an intact file', async () => {
    const selected = await readFile('cut-off.webm', { options: { maxFrames: 5 }, reports: true });
    expect([selected.times.length, selected.damage]).toEqual([5, null]);
    const intact = await readFile('vp9.webm', { reports: true });
    expect([intact.times.length, intact.damage]).toEqual([count, null]);
  });

  test('frames and facts of an animated GIF end before the damage', async () => {
    const bytes = readFileSync(pathOf('delays.gif'));
    writeFileSync(films.path('cut.gif'), bytes.subarray(0, Math.floor(0.6 * bytes.length)));
    const { times, damage, info } = await readFile('cut.gif', { reports: true });
    expect(times.length).toBeGreaterThan(5);
    expect(times.length).toBeLessThan(count);
    expect(damage).toEqual({ frames: times.length, code: 'truncated' });
    expect(info).toMatchObject({ numFrames: times.length, codec: 'image/gif' });
    expect((await readFile('cut.gif')).error.code).toBe('truncated');
  });

  test('frames that the decoder still held when it met the damage come too', async () => {
    const order = ['-bf', '2', '-g', '8', '-x264-params', 'b-adapt=0', '-bsf:v', 'filter_units=remove_types=6'];
    film('order.mp4', [...H264, ...order]);
    // The order of decoding is 0, 3, 1, 2, 6, 4, 5, …: the fifth packet holds picture 6.
    scrambleMp4Packet('order.mp4', 'scrambled.mp4', 4);
    const { pictures, error } = await readFile('scrambled.mp4');
    expect(pictures).toEqual([0, 1, 2, 3]);
    expect(error).toMatchObject({ code: 'truncated', frames: 4 });
  });

  test('a WebM file with a hole in a cluster gives the frames before it', async () => {
    film('intact.webm', ['-c:v', 'libvpx-vp9', '-pix_fmt', 'yuv420p', '-b:v', '2M']);
    const bytes = readFileSync(pathOf('intact.webm'));
    const start = Math.floor(0.6 * bytes.length);
    bytes.fill(0, start, Math.min(bytes.length, start + 9000));
    writeFileSync(films.path('holed.webm'), bytes);
    const { pictures, error } = await readFile('holed.webm');
    expect(pictures.length).toBeGreaterThan(2);
    expect(pictures.length).toBeLessThan(count);
    expect(pictures).toEqual(range(pictures.length));
    expect(error.code).toBe('truncated');
  });

  test('a segmentation of a damaged file has the masks before it, in its result or in its error', async () => {
    await giveFile(library.page, pathOf('cut-off.mp4'));
    const outcome = await library.page.evaluate(async () => {
      const size = 64;
      const damage = [];
      const onDamage = ({ frames, total }) => damage.push({ frames, total });
      const result = await tracecut.segmentVideo(file, { size, onDamage }).collect();
      const error = await tracecut
        .segmentVideo(file, { size })
        .collect()
        .catch((reason) => reason);
      const restored = tracecut.VideoResult.fromJSON(JSON.stringify(result));
      const windows = [];
      const readWindows = async () => {
        for await (const { times } of tracecut.segmentVideo(file, { size, window: 4, overlap: 1 }))
          windows.push(times.length);
      };
      const windowError = await failure(readWindows());
      const before = await tracecut.segmentVideo(file, { size, maxFrames: 3 }).collect();
      const facts = ({ numFrames, truncated }) => ({ numFrames, truncated });
      const results = [result, error.result, restored].map(facts);
      return { damage, results, code: error.code, frames: error.frames, windows, windowError, before: facts(before) };
    });
    const truncated = expect.objectContaining({ frames: 8, reason: expect.stringMatching(/cut off or damaged/) });
    expect(outcome.results).toEqual(Array(3).fill({ numFrames: 8, truncated }));
    expect(outcome.damage).toEqual([{ frames: 8, total: count }]);
    expect([outcome.code, outcome.frames, outcome.windowError.code]).toEqual(['truncated', 8, 'truncated']);
    expect(outcome.windows.length).toBeGreaterThan(1);
    expect(outcome.before).toEqual({ numFrames: 3, truncated: null });
  });
});

/** Overwrites the middle of a packet of an H.264 file, found by its number. */
function scrambleMp4Packet(source, target, packet) {
  const bytes = readFileSync(pathOf(source));
  // The data of the file are in the order of decoding, each picture behind its length.
  let at = bytes.indexOf('mdat') + 4;
  for (let k = 0; k < packet; k += 1) at += 4 + bytes.readUInt32BE(at);
  const size = bytes.readUInt32BE(at);
  for (let k = at + 40; k < at + size; k += 1) bytes[k] = (37 * k) & 255;
  writeFileSync(films.path(target), bytes);
}
