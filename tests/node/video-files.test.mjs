// Video in Node: the pictures of files, each once and with its own time, by ffmpeg, and raw video from streams. Turned pictures,
// pixels that are not square and sizes that change are in the intake table (tests/native/intake.test.mjs).

import assert from 'node:assert/strict';
import { execFileSync, spawnSync } from 'node:child_process';
import { chmodSync, existsSync, mkdtempSync, readFileSync, rmSync, writeFileSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import { Readable } from 'node:stream';
import { after, test } from 'node:test';
import { pathToFileURL } from 'node:url';
import { createSession, framesOfRaw, framesOfVideo, segmentVideo, videoFrames, videoInfo } from 'tracecut/node';
import { root } from '../../scripts/tools.mjs';
import { collect, fnv1a, framesOf, rejects } from './support.mjs';

const folder = mkdtempSync(join(tmpdir(), 'tracecut-'));
after(() => rmSync(folder, { recursive: true, force: true }));

const hasFfmpeg = spawnSync('ffmpeg', ['-version']).status === 0;
const skip = !hasFfmpeg && 'there is no ffmpeg';
const hasX264 = hasFfmpeg && String(spawnSync('ffmpeg', ['-hide_banner', '-encoders']).stdout).includes(' libx264 ');
const skipX264 = skip || (!hasX264 && 'this ffmpeg has no libx264');

const ffmpeg = (...args) => execFileSync('ffmpeg', ['-v', 'error', '-y', ...args]);

/** Makes a file of `count` different pictures; `args` say how. Losslessly, if they name no codec. */
function clip(name, args = [], { count = 8, size = '64x48', rate = 25 } = {}) {
  const path = join(folder, name);
  const codec = args.includes('-c:v') ? [] : ['-c:v', 'ffv1', '-pix_fmt', 'bgr0'];
  const source = ['-f', 'lavfi', '-i', `testsrc2=s=${size}:r=${rate}`, '-frames:v', String(count)];
  ffmpeg(...source, ...codec, ...args, `file:${path}`);
  return path;
}

const times = (frames) => frames.map(({ time }) => Number(time.toFixed(6)));
const durations = (frames) => frames.map(({ duration }) => Number(duration.toFixed(6)));
/** Number, time and pixels of each frame. */
const frameFacts = (frames) => frames.map(({ frame, index, time }) => [index, time, fnv1a(frame.data)]);
const sizeOf = ({ frame: { width, height } }) => `${width}x${height}`;

/** The frames until an error, and that. */
async function untilError(reading) {
  const frames = [];
  try {
    for await (const frame of reading) frames.push(frame);
  } catch (error) {
    return { frames, error };
  }
  return { frames, error: null };
}

const X264 = ['-c:v', 'libx264', '-pix_fmt', 'yuv420p'];
/** Pictures that stand on their own, in the order in which they are shown. */
const INTRA = [...X264, '-g', '1', '-bf', '0', '-crf', '10'];

test('frames last until the next one, and the last as long as the file says', { skip }, async () => {
  const path = clip('five.mkv', [], { count: 4, rate: 5 });
  const frames = await collect(framesOfVideo(path));
  assert.deepEqual(durations(frames), [0.2, 0.2, 0.2, 0.2]);
  assert.deepEqual(times(frames), [0, 0.2, 0.4, 0.6]);
  const result = await segmentVideo(framesOfVideo(path)).collect();
  assert.equal(result.numFrames, 4);
  assert.ok(Math.abs(result.end - 0.8) < 1e-9, `${result.end}`);
});

test('pictures come once, with the times of the file, however uneven these are', { skip }, async () => {
  const uneven = (vf) => ['-vf', vf, '-fps_mode', 'passthrough', '-enc_time_base', '1:1000'];
  // A recording: whole milliseconds, and a pause after the first picture.
  const recording = clip('recording.mkv', uneven('settb=1/1000,setpts=N*49+mod(N*N*7\\,19)+gte(N\\,1)*250'));
  const recorded = await collect(framesOfVideo(recording));
  assert.deepEqual(times(recorded), [0, 0.306, 0.357, 0.403, 0.463, 0.499, 0.549, 0.594]);
  // A pause on the way, and a beginning that is not zero, which the file keeps.
  const late = clip('-late: 1.mkv', uneven('settb=1/1000,setpts=500+N*40+gte(N\\,5)*500'));
  const frames = await collect(framesOfVideo(late));
  assert.deepEqual(times(frames), [0.5, 0.54, 0.58, 0.62, 0.66, 1.2, 1.24, 1.28]);
  assert.deepEqual(durations(frames).slice(3, 6), [0.04, 0.54, 0.04]);
  const raw = ffmpeg('-i', `file:${late}`, '-f', 'rawvideo', '-pix_fmt', 'rgba', '-fps_mode', 'passthrough', '-');
  frames.forEach(({ frame, index }, k) => {
    assert.equal(index, k);
    assert.deepEqual(Buffer.from(frame.data), raw.subarray(k * 4 * 64 * 48, (k + 1) * 4 * 64 * 48), `frame ${k}`);
  });
});

test('a file that is cut off gives the whole frames before that, and an error that counts them', { skip }, async () => {
  const path = clip('whole.mkv');
  const allFrames = await collect(framesOfVideo(path));
  const cut = join(folder, 'cut.mkv');
  const bytes = readFileSync(path);
  writeFileSync(cut, bytes.subarray(0, Math.floor(bytes.length * 0.6)));
  const { frames, error } = await untilError(framesOfVideo(cut));
  assert.ok(frames.length >= 3 && frames.length <= 5, `${frames.length}`);
  assert.deepEqual(frameFacts(frames), frameFacts(allFrames.slice(0, frames.length)));
  assert.deepEqual([error.code, error.frames], ['truncated', frames.length]);
  assert.match(error.message, /^cut\.mkv is cut off or damaged after \d whole frames$/);
  const damages = [];
  const undamaged = await collect(framesOfVideo(cut, { onDamage: (damage) => damages.push(damage) }));
  assert.equal(undamaged.length, frames.length);
  assert.deepEqual([damages.length, damages[0].frames, damages[0].error.code], [1, frames.length, 'truncated']);
  // segmentVideo makes a result of them.
  const options = { onDamage: (damage) => damages.push(damage), maxFrames: 8 };
  const result = await segmentVideo(framesOfVideo(cut), options).collect();
  assert.deepEqual([result.numFrames, damages[1].frames], [frames.length, frames.length]);
  const truncated = { frames: frames.length, reason: error.message };
  assert.deepEqual(result.truncated, truncated);
  await assert.rejects(segmentVideo(framesOfVideo(cut)).collect(), (thrown) => {
    assert.deepEqual([thrown.code, thrown.frames, thrown.result?.truncated], ['truncated', frames.length, truncated]);
    return true;
  });
});

test('of an MP4 that ends early no whole picture is lost', { skip: skipX264 }, async () => {
  const path = clip('fast.mp4', [...X264, '-g', '4', '-movflags', '+faststart'], { count: 16, size: '240x180' });
  const allFrames = await collect(framesOfVideo(path));
  const bytes = readFileSync(path);
  writeFileSync(path, bytes.subarray(0, Math.floor(bytes.length * 0.6)));
  const { frames, error } = await untilError(framesOfVideo(path));
  assert.ok(frames.length >= 4 && frames.length < 16, `${frames.length}`);
  assert.deepEqual(frameFacts(frames), frameFacts(allFrames.slice(0, frames.length)));
  assert.deepEqual([error.code, error.frames], ['truncated', frames.length]);
  const late = clip('late.mp4', X264);
  writeFileSync(late, readFileSync(late).subarray(0, 1000));
  await rejects(collect(framesOfVideo(late)), 'truncated', /^late\.mp4 is cut off: the index.* is missing$/);
});

test('a GIF that is cut off says so', { skip }, async () => {
  const path = clip('moves.gif', ['-c:v', 'gif', '-f', 'gif']);
  assert.equal((await collect(framesOfVideo(path))).length, 8);
  const bytes = readFileSync(path);
  writeFileSync(path, bytes.subarray(0, Math.floor(bytes.length * 0.9)));
  const { frames, error } = await untilError(framesOfVideo(path));
  assert.ok(frames.length > 1 && frames.length < 8, `${frames.length}`);
  assert.deepEqual([error?.code, error?.frames], ['truncated', frames.length]);
});

test('damage in the middle ends the frames before it', { skip: skipX264 }, async () => {
  const path = clip('damaged.mp4', INTRA, { count: 12, size: '240x180' });
  const allFrames = await collect(framesOfVideo(path));
  const list = String(ffmpeg('-i', path, '-c', 'copy', '-f', 'framecrc', '-'));
  const sizes = [...list.matchAll(/^0,.*?,.*?,.*?, *(\d+),/gm)].map(([, size]) => Number(size));
  assert.equal(sizes.length, 12);
  const bytes = readFileSync(path);
  const begin = bytes.indexOf('mdat') + 4 + sizes.slice(0, 7).reduce((sum, size) => sum + size, 0);
  bytes.fill(0, begin + (sizes[7] >> 3), begin + sizes[7] - 8);
  writeFileSync(path, bytes);
  const { frames, error } = await untilError(framesOfVideo(path));
  assert.deepEqual([frames.length, error?.code, error?.frames], [7, 'truncated', 7]);
  assert.deepEqual(frameFacts(frames), frameFacts(allFrames.slice(0, 7)));
});

test('the default track is the video, or else the largest of several pictures', { skip }, async () => {
  const video = clip('video.mkv');
  const poster = clip('poster.mkv', ['-c:v', 'mjpeg', '-pix_fmt', 'yuvj420p'], { count: 1, size: '320x240' });
  const both = (name, inputs, ...args) => {
    const maps = inputs.flatMap((_, k) => ['-map', String(k)]);
    const path = join(folder, name);
    ffmpeg(...inputs.flatMap((input) => ['-i', input]), ...maps, '-c', 'copy', ...args, path);
    return path;
  };
  const defaultTrack = async (path) => {
    const frames = await collect(framesOfVideo(path));
    return [frames.length, sizeOf(frames[0])];
  };
  const small = clip('small.mkv', [], { count: 4, size: '32x24' });
  const disposed = (first, second) => ['-disposition:v:0', first, '-disposition:v:1', second];
  assert.deepEqual(await defaultTrack(both('a.mkv', [small, video], ...disposed('0', 'default'))), [8, '64x48']);
  assert.deepEqual(await defaultTrack(both('b.mkv', [small, video], ...disposed('default', '0'))), [4, '32x24']);
  assert.deepEqual(await defaultTrack(both('c.mkv', [small, video], ...disposed('0', '0'))), [8, '64x48']);
  assert.deepEqual(await defaultTrack(poster), [1, '320x240']);
});

test('an error names the cause', { skip }, async () => {
  const file = (name, bytes) => {
    writeFileSync(join(folder, name), bytes);
    return join(folder, name);
  };
  const rejectsFile = (path, code, message) => rejects(collect(framesOfVideo(path)), code, message);
  await rejectsFile(join(folder, 'none.mp4'), 'no-video', /^none\.mp4 is missing: there is no such file$/);
  await rejectsFile(file('words.mp4', 'no video'), 'no-video', /^words\.mp4 is not a video/);
  await rejectsFile(file('words.txt', 'no video\n'.repeat(99)), 'no-video', /^words\.txt is not a video/);
  await rejectsFile(file('nothing.mp4', ''), 'no-video', /^nothing\.mp4 is empty$/);
  const sound = join(folder, 'sound.wav');
  ffmpeg('-f', 'lavfi', '-i', 'sine', '-t', '0.1', sound);
  await rejectsFile(pathToFileURL(sound), 'no-video', /^sound\.wav has no video track$/);
  // An animated WebP whose pictures nobody can read, as its format is unknown to ffmpeg 5.
  const flags = [2, 0, 0, 0, 63, 0, 0, 47, 0, 0];
  const webp = [Buffer.from('RIFF\x30\0\0\0WEBPVP8X\x0a\0\0\0', 'latin1'), Buffer.from(flags), Buffer.alloc(30)];
  await rejectsFile(
    file('moves.webp', Buffer.concat(webp)),
    'unsupported',
    /^moves\.webp is an animated WebP, which this ffmpeg/,
  );
  const small = clip('size.mkv');
  await rejects(collect(framesOfVideo(small, { maxPixels: 100 })), 'too-large', /3072 pixels .* maxPixels/);
});

test('segmentVideo and videoFrames read a file by its path or address', async () => {
  const path = clip('direct.mkv');
  const frames = await collect(framesOfVideo(path));
  const result = await segmentVideo(path).collect();
  assert.deepEqual(
    [...result.times],
    frames.map(({ time }) => time),
  );
  const readFrames = [];
  for await (const { time } of videoFrames(pathToFileURL(path), { step: 2 })) readFrames.push(time);
  assert.deepEqual(
    readFrames,
    frames.filter((_, t) => t % 2 === 0).map(({ time }) => time),
  );
  await rejects(videoInfo(path), 'unsupported', /videoFrames reads them/);
  await rejects(segmentVideo(join(folder, 'none.mp4')).collect(), 'no-video', /^none\.mp4 is missing/);
  await rejects(segmentVideo(path, { clip: { maxPixels: 100 } }).collect(), 'too-large', /3072 pixels/);
  const reason = new Error('never mind');
  await assert.rejects(segmentVideo(path, { signal: AbortSignal.abort(reason) }).collect(), reason);
  const { PATH } = process.env;
  try {
    process.env.PATH = '';
    const message =
      /ffmpeg could not be started: it was not found .*https:\/\/ffmpeg\.org.*framesOfVideo.*tracecut\/node/;
    await rejects(segmentVideo(path).collect(), 'unsupported', message);
  } finally {
    process.env.PATH = PATH;
  }
});

test('a required package reads a file too', () => {
  const path = clip('required.mkv');
  const code = `require('./dist/node/index.cjs').segmentVideo(process.argv[1]).collect().then((r) => console.log(r.numFrames > 1))`;
  const printed = execFileSync(process.execPath, ['--eval', code, path], { cwd: root, encoding: 'utf8' });
  assert.equal(printed, 'true\n');
});

test('wrong use, and no ffmpeg, are errors that say what to do', async () => {
  const missing = { ffmpeg: join(folder, 'no-ffmpeg-here') };
  const message = /could not be started: it was not found \(expected ffmpeg/;
  await rejects(collect(framesOfVideo('clip.mp4', missing)), 'unsupported', message);
  await rejects(collect(framesOfVideo(5)), 'data', /path = 5/);
  await rejects(collect(framesOfVideo('a', { program: 'x' })), 'param', /program/);
  await assert.rejects(
    collect(framesOfVideo('a', { signal: AbortSignal.abort(new Error('never mind')) })),
    /never mind/,
  );
});

test('an abort ends the reading of a file', { skip }, async () => {
  const path = clip('abort.mkv', [], { count: 60, size: '320x240' });
  const stop = new AbortController();
  const reading = framesOfVideo(path, { signal: stop.signal });
  assert.equal((await reading.next()).value.index, 0);
  stop.abort(new Error('enough'));
  await assert.rejects(collect(reading), /enough/);
});

/** Writes a program that replaces ffmpeg and prints a list, messages and pixels; with `forever` it does not end. */
function standIn(name, { list = '', messages = [], forever = false }) {
  const path = join(folder, name);
  const script = `#!${process.execPath}
const { appendFileSync, writeSync } = require('node:fs');
appendFileSync(${JSON.stringify(`${path}.pid`)}, process.pid + '\\n');
const say = (text) => writeSync(2, text);
say("[info] Input #0, made, from 'file':\\n[info]   Stream #0:0: Video: raw (default)\\n[info] Output #0, x\\n");
if (process.argv.includes('framecrc')) writeSync(1, ${JSON.stringify(list)});
else {
  say('[Parsed_showinfo_3 @ 0x1] [info] config in time_base: 1/100, frame_rate: 25/1\\n');
  for (const [message, pixel] of ${JSON.stringify(messages)}) {
    say(message);
    if (pixel !== undefined) writeSync(1, Buffer.from([pixel, pixel, pixel]));
  }
  if (${forever}) setInterval(() => {}, 1000);
}
`;
  writeFileSync(path, script);
  chmodSync(path, 0o755);
  return { path, pids: () => readFileSync(`${path}.pid`, 'utf8').trim().split('\n').map(Number) };
}

const noScripts = process.platform === 'win32' && 'a script is no program there';
const listOf = (...packets) => `#tb 0: 1/100\n#codec_id 0: raw\n#dimensions 0: 1x1\n${packets.join('\n')}\n`;
const packet = (time, duration = 0, more = '') => `0, ${time}, ${time}, ${duration}, 3, 0x1${more}`;
const showInfoLine = (n, time) =>
  `[Parsed_showinfo_3 @ 0x1] [info] n: ${n} pts: ${time} pts_time:x fmt:rgb24 sar:1/1 s:1x1 i:P iskey:1 type:I `;

/** Reads from a stand-in: the red of each frame, its time and its duration. */
async function readBy(name, options) {
  const { frames, error } = await untilError(framesOfVideo('a', { ffmpeg: standIn(name, options).path }));
  return { frames: frames.map(({ frame, time, duration }) => [frame.data[0], time, duration]), error };
}

test('times that are missing or do not increase are mended', { skip: noScripts }, async () => {
  const missing = '-9223372036854775808';
  const list = listOf(packet(0, 20), packet(0, 30), packet(missing, 5), packet(200, 25));
  const messages = [0, 0, 'NOPTS', 200].map((time, k) => [`${showInfoLine(k, time)}\n`, k]);
  const { frames, error } = await readBy('equal', { list, messages });
  assert.equal(error, null);
  assert.deepEqual(frames, [
    [0, 0, 0.2],
    [1, 0.2, 0.2],
    [2, 0.4, 1.6],
    [3, 2, 0.25],
  ]);
});

test('pictures that end before players begin are left out', { skip: noScripts }, async () => {
  const times = [-50, -25, 50];
  const list = listOf(...times.map((time) => packet(time)));
  const { frames } = await readBy('early', {
    list,
    messages: times.map((time, k) => [`${showInfoLine(k, time)}\n`, k]),
  });
  assert.deepEqual(frames, [
    [1, -0.25, 0.75],
    [2, 0.5, 0.75],
  ]);
});

test('messages of several threads on one line are separated', { skip: noScripts }, async () => {
  const list = listOf(packet(0, 4), packet(4, 4), packet(8, 4));
  const torn = (message) => `[vist#0:0/raw @ 0x2] [dec:raw @ 0x3] [info] ${message}`;
  const messages = [
    [`${showInfoLine(0, 0)}${torn('decoder -> ist_index:0')}\n`, 0],
    [`${torn('decoder -> ist_index:0')}${showInfoLine(1, 4)}\n`, 1],
    [`${torn('corrupt decoded frame')}\n${torn('decoder -> ist_index:0')}\n${showInfoLine(2, 8)}\n`, 2],
  ];
  const { frames, error } = await readBy('torn', { list, messages });
  assert.deepEqual([frames.length, error.code, error.frames], [2, 'truncated', 2]);
});

test('leaving the loop, and an abort, end ffmpeg', { skip: noScripts }, async () => {
  const isAlive = (pid) => {
    try {
      return process.kill(pid, 0);
    } catch {
      return false;
    }
  };
  const messages = [0, 4, 8].map((time, k) => [`${showInfoLine(k, time)}\n`, k]);
  const standInOutput = { list: listOf(packet(0), packet(4), packet(8)), messages, forever: true };
  const program = standIn('left', standInOutput);
  for await (const { index } of framesOfVideo('a', { ffmpeg: program.path })) if (index === 1) break;
  assert.ok(!program.pids().some(isAlive));
  const aborted = standIn('aborted', standInOutput);
  const stop = new AbortController();
  const reading = framesOfVideo('a', { ffmpeg: aborted.path, signal: stop.signal });
  await reading.next();
  await reading.next();
  setImmediate(() => stop.abort(new Error('enough')));
  await assert.rejects(collect(reading), /enough/);
  assert.ok(!aborted.pids().some(isAlive));
});

test('an ffmpeg that is too old says so', { skip: noScripts }, async () => {
  const messages = [["[error] Unrecognized option 'fps_mode'.\n"]];
  const { error } = await readBy('old', { list: listOf(packet(0), packet(4)), messages });
  assert.deepEqual([error.code, error.message], ['unsupported', 'this ffmpeg is too old (expected 5.1 or later)']);
  assert.ok(existsSync(join(folder, 'old')));
});

const rgb = ({ data }) => data.filter((_, k) => k % 4 < 3);

test('raw frames are read in every format', async () => {
  const readOne = async (format, bytes) => {
    const [{ frame }] = await collect(framesOfRaw([Uint8Array.from(bytes)], { width: 2, height: 1, format }));
    assert.deepEqual([frame.width, frame.height, frame.data[3], frame.data[7]], [2, 1, 255, 255]);
    return [...rgb(frame)];
  };
  assert.deepEqual(await readOne('rgba', [1, 2, 3, 9, 4, 5, 6, 9]), [1, 2, 3, 4, 5, 6]);
  assert.deepEqual(await readOne('bgra', [3, 2, 1, 9, 6, 5, 4, 9]), [1, 2, 3, 4, 5, 6]);
  assert.deepEqual(await readOne('rgb24', [1, 2, 3, 4, 5, 6]), [1, 2, 3, 4, 5, 6]);
  assert.deepEqual(await readOne('bgr24', [3, 2, 1, 6, 5, 4]), [1, 2, 3, 4, 5, 6]);
  assert.deepEqual(await readOne('gray', [7, 8]), [7, 7, 7, 8, 8, 8]);
});

const grey = { width: 2, height: 1, format: 'gray', frameRate: 4 };

test('frames have numbers and times, however the stream is cut into pieces', async () => {
  const bytes = [1, 2, 3, 4, 5, 6];
  for (const size of [1, 4, 6]) {
    const pieces = bytes
      .filter((_, k) => k % size === 0)
      .map((_, k) => Uint8Array.from(bytes.slice(k * size, (k + 1) * size)));
    for (const source of [pieces, Readable.from(pieces), Readable.toWeb(Readable.from(pieces))]) {
      const frames = await collect(framesOfRaw(source, grey));
      assert.deepEqual(
        frames.map(({ frame, index, time, duration }) => [frame.data[0], index, time, duration]),
        [0, 1, 2].map((k) => [2 * k + 1, k, k / 4, 1 / 4]),
      );
    }
  }
  assert.deepEqual(await collect(framesOfRaw([], grey)), []);
});

test('a stream that is cut off gives the frames before that, then an error that counts them', async () => {
  const frames = [];
  const reading = (async () => {
    for await (const { index } of framesOfRaw([Uint8Array.of(1, 2, 3)], grey)) frames.push(index);
  })();
  await rejects(reading, 'truncated', /frame 1 of the stream has 1 bytes \(expected 2\)/);
  await assert.rejects(reading, { frames: 1 });
  assert.deepEqual(frames, [0]);
});

test('what cannot be read is refused before memory is taken', async () => {
  const refused = (options, code, message) => rejects(collect(framesOfRaw([], { ...grey, ...options })), code, message);
  await refused({ format: 'yuv420p' }, 'param', /format = "yuv420p" \(expected rgba, bgra, rgb24, bgr24, gray\)/);
  await refused({ width: 16384, height: 16384 }, 'too-large', /268435456 pixels in a frame .*the parameter maxPixels/);
  await refused({ width: 0 }, 'frame-size', /width = 0/);
  await refused({ maxPixels: 1 }, 'too-large', /expected at most 1;/);
  await refused({ maxPixels: 0 }, 'param', /maxPixels = 0/);
  await refused({ frameRate: 0 }, 'param', /frameRate/);
  await refused({ pixels: 1 }, 'param', /pixels/);
  await rejects(collect(framesOfRaw('clip.rgb', grey)), 'data', /source = "clip.rgb"/);
  await rejects(collect(framesOfRaw(['words'], grey)), 'data', /a piece of the stream/);
});

test('unread parts of a stream are cancelled', async () => {
  let closed = false;
  async function* endless() {
    try {
      for (;;) yield Uint8Array.of(1, 2);
    } finally {
      closed = true;
    }
  }
  for await (const { index } of framesOfRaw(endless(), grey)) if (index === 2) break;
  assert.ok(closed);
});

test('a session and segmentVideo take them', async () => {
  const frames = await framesOf();
  const { width, height } = frames[0];
  const bytes = frames.map(({ data }) => new Uint8Array(data));
  const raw = () => framesOfRaw(bytes, { width, height, format: 'rgba' });
  const expected = await segmentVideo(frames).collect();
  const result = await segmentVideo(raw()).collect();
  assert.equal(fnv1a(result.labels(3)), fnv1a(expected.labels(3)));
  const session = await createSession();
  for await (const { frame } of raw()) await session.push(frame);
  assert.equal(session.numFrames, frames.length);
  session.close();
});
