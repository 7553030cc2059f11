// What Node reads: Y4M, raw video, video files by ffmpeg.

import assert from 'node:assert/strict';
import { execFileSync, spawnSync } from 'node:child_process';
import { mkdtempSync, rmSync, writeFileSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import { Readable } from 'node:stream';
import { test } from 'node:test';
import { pathToFileURL } from 'node:url';
import { createSession, framesOfRaw, framesOfVideo, framesOfY4m, segmentVideo } from 'tracecut/node';
import { fnv1a, framesOf, rejects } from './support.mjs';

const hasFfmpeg = spawnSync('ffmpeg', ['-version']).status === 0;

/** A Y4M stream, in pieces of a few bytes. */
function stream(header, frames, piece = 7) {
  const bytes = Buffer.concat([
    Buffer.from(`YUV4MPEG2 ${header}\n`),
    ...frames.flatMap((frame) => [Buffer.from('FRAME Ip\n'), Buffer.from(frame)]),
  ]);
  return Array.from({ length: Math.ceil(bytes.length / piece) }, (_, k) => bytes.subarray(k * piece, (k + 1) * piece));
}

async function all(frames) {
  const list = [];
  for await (const frame of frames) list.push(frame);
  return list;
}

const rgb = ({ data }) => data.filter((_, k) => k % 4 < 3);

/** Bytes that go through most combinations of brightness and chroma; the command line's test has the same. */
const mixed = (length) => Uint8Array.from({ length }, (_, k) => (k * 7 + (k >> 8) * 13 + (k >> 16) * 91) & 255);

test('Y4M gives the pixels that the command line reads', async () => {
  const expected = {
    'W128 H128 F25:1 C444': '14c189a9',
    'W128 H128 C444 XCOLORRANGE=FULL': '277e5219',
    'W33 H21 F30000:1001 Ip C420jpeg': 'b33c712f',
    'W33 H21 C422': '0a323128',
    'W33 H21 Cmono': 'c2588092',
  };
  const length = { C444: 3 * 128 * 128, C420: 33 * 21 + 2 * 17 * 11, C422: 33 * 21 + 2 * 17 * 21, Cmono: 33 * 21 };
  const found = {};
  for (const header of Object.keys(expected)) {
    const bytes = mixed(length[/C444|C420|C422|Cmono/.exec(header)[0]]);
    const [{ frame }] = await all(framesOfY4m(stream(header, [bytes], 5000)));
    assert.ok(frame.data.every((value, k) => k % 4 < 3 || value === 255));
    found[header] = fnv1a(rgb(frame));
  }
  assert.deepEqual(found, expected);
});

test('frames have numbers and times, however the stream is cut into pieces', async () => {
  for (const piece of [1, 3, 1000]) {
    const rows = ['16 126 235', '0 255 17'].map((row) => row.split(' ').map(Number));
    const frames = await all(framesOfY4m(stream('W3 H1 F50:2 Cmono', rows, piece)));
    const times = frames.map(({ index, time, duration }) => ({ index, time, duration }));
    assert.deepEqual(
      times,
      [0, 1].map((index) => ({ index, time: 0.04 * index, duration: 0.04 })),
    );
    assert.deepEqual([...rgb(frames[0].frame)], [0, 0, 0, 128, 128, 128, 255, 255, 255]);
    assert.deepEqual([...rgb(frames[1].frame)], [0, 0, 0, 255, 255, 255, 1, 1, 1]);
  }
  assert.deepEqual(await all(framesOfY4m(stream('W3 H1', []))), []);
  const web = Readable.toWeb(Readable.from(stream('W1 H1 Cmono', [[16]])));
  assert.equal((await all(framesOfY4m(web))).length, 1);
});

test('streams that are not Y4M, too large or cut off are errors that say so, before memory is taken', async () => {
  const said = (header, frames, code, message) => rejects(all(framesOfY4m(stream(header, frames))), code, message);
  await rejects(all(framesOfY4m([])), 'no-video', /empty/);
  await rejects(all(framesOfY4m([Buffer.from('RIFF\n')])), 'no-video', /not Y4M/);
  await rejects(all(framesOfY4m([Buffer.alloc(1e6, 65)])), 'truncated', /header line/);
  await rejects(all(framesOfY4m('clip.y4m')), 'data', /source = 'clip.y4m'|source = "clip.y4m"/);
  await rejects(all(framesOfY4m(['YUV4MPEG2'])), 'data', /a piece of the stream/);
  await said('W2 H2 C420p10', [], 'codec', /C420p10 .*-pix_fmt yuv420p/);
  await said('W0 H2', [], 'frame-size', /width = 0/);
  await said('W2', [], 'frame-size', /height/);
  await said('W16384 H16384', [], 'too-large', /268435456 pixels in a frame .*the parameter maxPixels/);
  const cut = [Buffer.alloc(4), Buffer.alloc(3)];
  await said('W2 H2 Cmono', cut, 'truncated', /frame 1 of the stream has 3 bytes \(expected 4\)/);
  const broken = Buffer.from('YUV4MPEG2 W1 H1 Cmono\nFRAME\nxNEXT\n');
  await rejects(all(framesOfY4m([broken])), 'decode', /frame 1 .* FRAME/);
});

test('raw frames are read in every format', async () => {
  const one = async (format, bytes) => [
    ...rgb((await all(framesOfRaw([Uint8Array.from(bytes)], { width: 2, height: 1, format })))[0].frame),
  ];
  assert.deepEqual(await one('rgba', [1, 2, 3, 9, 4, 5, 6, 9]), [1, 2, 3, 4, 5, 6]);
  assert.deepEqual(await one('bgra', [3, 2, 1, 9, 6, 5, 4, 9]), [1, 2, 3, 4, 5, 6]);
  assert.deepEqual(await one('rgb24', [1, 2, 3, 4, 5, 6]), [1, 2, 3, 4, 5, 6]);
  assert.deepEqual(await one('bgr24', [3, 2, 1, 6, 5, 4]), [1, 2, 3, 4, 5, 6]);
  assert.deepEqual(await one('gray', [7, 8]), [7, 7, 7, 8, 8, 8]);
  for (const [format, bytes] of [
    ['yuv420p', [126, 16, 128, 128]],
    ['yuv422p', [126, 16, 128, 128]],
    ['yuv444p', [126, 16, 128, 128, 128, 128]],
  ])
    assert.deepEqual(await one(format, bytes), [128, 128, 128, 0, 0, 0], format);
  const options = { width: 2, height: 1, format: 'gray', frameRate: 4 };
  const frames = await all(framesOfRaw([Uint8Array.of(1, 2, 3), Uint8Array.of(4)], options));
  assert.deepEqual(
    frames.map(({ time }) => time),
    [0, 0.25],
  );
  await rejects(all(framesOfRaw([Uint8Array.of(1, 2, 3)], options)), 'truncated', /frame 1 of the stream has 1 bytes/);
  await rejects(all(framesOfRaw([], { ...options, format: 'nv12' })), 'param', /format .*yuv420p/);
  await rejects(all(framesOfRaw([], { ...options, width: 16384, height: 16384 })), 'too-large');
  await rejects(all(framesOfRaw([], { ...options, maxPixels: 1 })), 'too-large', /expected at most 1;/);
  await rejects(all(framesOfRaw([], { ...options, maxPixels: 0 })), 'param', /maxPixels = 0/);
  await rejects(all(framesOfRaw([], { ...options, frameRate: 0 })), 'param', /frameRate/);
});

test('what is not read of a stream is given up', async () => {
  let closed = false;
  async function* endless() {
    try {
      yield Buffer.from('YUV4MPEG2 W1 H1 Cmono\n');
      for (;;) yield Buffer.from('FRAME\nx');
    } finally {
      closed = true;
    }
  }
  for await (const { index } of framesOfY4m(endless())) if (index === 2) break;
  assert.ok(closed);
});

test('a session and segmentVideo take them', async () => {
  const frames = await framesOf();
  const { width, height } = frames[0];
  const bytes = frames.map(({ data }) => new Uint8Array(data));
  const raw = () => framesOfRaw(bytes, { width, height, format: 'rgba' });
  const expected = await segmentVideo(frames).collect();
  const found = await segmentVideo(raw()).collect();
  assert.equal(fnv1a(found.labels(3)), fnv1a(expected.labels(3)));
  const session = await createSession();
  for await (const { frame } of raw()) await session.push(frame);
  assert.equal(session.numFrames, frames.length);
  session.close();
});

test('without ffmpeg a video file is an error that says what to do', async () => {
  const missing = { ffmpeg: join(tmpdir(), 'no-ffmpeg-here') };
  const message = /could not be started: it was not found \(expected ffmpeg/;
  await rejects(all(framesOfVideo('clip.mp4', missing)), 'unsupported', message);
  await rejects(all(framesOfVideo(5)), 'data', /path = 5/);
  await rejects(all(framesOfVideo('a', { program: 'x' })), 'param', /program/);
});

test('ffmpeg decodes video files with their times', { skip: !hasFfmpeg && 'there is no ffmpeg' }, async (t) => {
  const folder = mkdtempSync(join(tmpdir(), 'tracecut-'));
  t.after(() => rmSync(folder, { recursive: true, force: true }));
  const clip = join(folder, '-clip: 1.mov');
  const frames = await framesOf();
  const { width, height } = frames[0];
  const raw = ['-f', 'rawvideo', '-pix_fmt', 'rgba', '-s', `${width}x${height}`, '-r', '8', '-i', '-'];
  const input = Buffer.concat(frames.map(({ data }) => Buffer.from(data)));
  // Every frame as it is, and the fifth shown late: the times are the file's, not those of a frame rate.
  const late = 'setpts=PTS+gte(N\\,5)*0.5/TB';
  const to = ['-vf', late, '-fps_mode', 'passthrough', '-c:v', 'png', `file:${clip}`];
  execFileSync('ffmpeg', ['-loglevel', 'error', ...raw, ...to], { input });
  const read = await all(framesOfVideo(clip));
  assert.deepEqual(
    read.map(({ time }) => Number(time.toFixed(2))),
    [0, 0.13, 0.25, 0.38, 0.5, 1.13, 1.25, 1.38],
  );
  read.forEach(({ frame, index }, k) => {
    assert.equal(index, k);
    assert.deepEqual(frame, { data: frames[k].data, width, height });
  });
  const stop = new AbortController();
  const reading = framesOfVideo(pathToFileURL(clip), { signal: stop.signal });
  assert.equal((await reading.next()).value.index, 0);
  stop.abort(new Error('enough'));
  await assert.rejects(all(reading), /enough/);
  for await (const { index } of framesOfVideo(clip)) if (index === 1) break;
  await rejects(all(framesOfVideo(join(folder, 'none.mp4'))), 'no-video', /none\.mp4: No such file/);
  writeFileSync(join(folder, 'words.mp4'), 'no video');
  await rejects(all(framesOfVideo(join(folder, 'words.mp4'))), 'no-video', /Invalid data/);
});
