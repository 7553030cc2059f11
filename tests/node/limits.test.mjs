// What is too large, and memory that runs out: errors with a code and a figure, and what goes on afterwards.

import assert from 'node:assert/strict';
import { execFileSync } from 'node:child_process';
import { readFile } from 'node:fs/promises';
import { test } from 'node:test';
import { setFlagsFromString } from 'node:v8';
import { runInNewContext } from 'node:vm';
import { parameters, segmentVideo, videoFrames } from 'tracecut';
import { boundaries } from 'tracecut/stages';
import { root } from '../../scripts/tools.mjs';
import { withMemory, withTrap } from '../trap.mjs';
import { SMALL, fingerprint, framesOf, open, plain, png, ready, rejects, segment, watchMemories } from './support.mjs';

setFlagsFromString('--expose-gc');
const collectGarbage = runInNewContext('gc');

const packaged = async (name) => new Uint8Array(await readFile(new URL(`../../dist/${name}_bg.wasm`, import.meta.url)));
/** Room for some hundred small frames. */
const small = async () => withMemory(await packaged('tracecut'), 16);

for (const worker of [false, true]) {
  const where = worker ? 'on a thread of its own' : 'in this thread';

  test(`frames beyond the limits are refused, ${where}, and the session goes on`, async (t) => {
    const session = await open(t, { worker, clip: { maxPixels: 128 * 72, maxFrames: SMALL.frames } });
    const frames = await framesOf();
    const over = /^9288 pixels in .*\(expected at most 9216; the parameter clip\.maxPixels sets this limit\)$/;
    await rejects(session.push(plain(129, 72)), 'too-large', over);
    await rejects(session.push(png(plain(129, 72))), 'too-large', /^frame 0: 9288 pixels in an image file/);
    await rejects(session.push(new Blob([png(plain(8, 8), [16384, 16384])])), 'too-large', /268435456/);
    for (const frame of frames) await session.push(frame);
    await rejects(session.push(frames[0]), 'too-large', /^9 frames in a session \(expected at most 8/);
    assert.equal(session.numFrames, SMALL.frames);
    assert.equal(fingerprint(await session.run()), fingerprint(await segment(frames)));
  });

  test(`memory that runs out is an error, ${where}: it comes back, and the next session works`, async (t) => {
    const memories = watchMemories(t);
    const session = await open(t, { worker, threads: 1, wasm: await small() });
    const frame = (await framesOf())[0];
    let pushed = 0;
    const pushing = async () => {
      for (; pushed < 2000; pushed += 1) await session.push(frame);
    };
    await rejects(pushing(), 'memory', /ran out of memory at 1\d MiB\. Create a new session/);
    assert.ok(pushed > 100 && pushed < 1000, `${pushed} frames`);
    await rejects(session.push(frame), 'memory');
    await rejects(session.run(), 'memory');
    if (!worker) {
      const first = memories.shift();
      for (let i = 0; i < 50 && first.deref(); i += 1) {
        await new Promise(setImmediate);
        collectGarbage();
      }
      assert.equal(first.deref(), undefined, 'the memory is given back while the session is still there');
    }
    const frames = await framesOf();
    assert.equal(
      fingerprint(await segment(frames, { worker, wasm: await small() })),
      fingerprint(await segment(frames)),
    );
  });

  test(`a frame that no memory is there for ends in the same error, ${where}`, async (t) => {
    const session = await open(t, { worker, threads: 1, wasm: await small() });
    await rejects(session.push(plain(2000, 2000)), 'memory', /ran out of memory/);
  });
}

test('a run that needs more than there is says so', async (t) => {
  const wasm = await small();
  const session = await ready(
    t,
    { threads: 1, wasm, clip: { maxSide: 640 } },
    await framesOf({ ...SMALL, width: 640, height: 360 }),
  );
  await rejects(session.run(), 'memory', /ran out of memory/);
});

test('trajectories and windows have limits too', async (t) => {
  const session = await open(t, { clip: { maxFrames: 20, maxTrajectories: 2, maxPoints: 9 } });
  const tracks = (count, points, numFrames = 20) => ({
    numFrames,
    width: 64,
    height: 48,
    startFrame: new Uint32Array(count),
    offset: Uint32Array.from({ length: count + 1 }, (_, k) => k * points),
    x: new Float32Array(count * points),
    y: new Float32Array(count * points),
  });
  await rejects(session.setTrajectories(tracks(1, 4, 21)), 'too-large', /clip\.maxFrames/);
  await rejects(session.setTrajectories(tracks(3, 2)), 'too-large', /^3 trajectories .*clip\.maxTrajectories/);
  await rejects(session.setTrajectories(tracks(2, 5)), 'too-large', /^10 points .*clip\.maxPoints/);
  await session.setTrajectories(tracks(2, 4));
  const frames = await framesOf();
  await rejects(segmentVideo(frames, { clip: { maxFrames: 4 } }).collect(), 'too-large', /clip\.maxFrames/);
  const result = await segmentVideo(frames, { clip: { maxFrames: 4 }, window: 4, overlap: 1 }).collect();
  assert.equal(result.numFrames, SMALL.frames);
  await rejects(segmentVideo(frames, { clip: { maxPixels: 9215 }, size: 64 }).collect(), 'too-large', /9216 pixels/);
});

test('limits have defaults and ranges, and refuse what is larger by default', async () => {
  const limits = parameters().filter(({ name }) => name.startsWith('clip.max') && name !== 'clip.maxSide');
  assert.deepEqual(
    limits.map(({ name, default: value }) => [name, value]),
    [
      ['clip.maxPixels', 2 ** 26],
      ['clip.maxFrames', 1e4],
      ['clip.maxTrajectories', 1e6],
      ['clip.maxPoints', 1e8],
    ],
  );
  await rejects(boundaries({ data: new Uint8Array(4), width: 16384, height: 4097 }), 'too-large', /67125248 pixels/);
  const one = videoFrames([{ data: new Uint8Array(4), width: 16384, height: 16384 }]);
  await rejects(one.next(), 'too-large', /268435456/);
});

test('a trap of the decoder is an error of the file, on a thread of its own', async (t) => {
  const decoder = withTrap(await packaged('decoder'), 'decode');
  const frames = await framesOf();
  const session = await open(t, { worker: true, decoder });
  for (const frame of frames) await session.push(frame);
  const words = /^frame 8: image cannot be decoded: the decoder stopped on an internal error: .*unreachable/;
  for (let k = 0; k < 2; k += 1) await rejects(session.push(png(frames[0])), 'decode', words);
  assert.equal(fingerprint(await session.run()), fingerprint(await segment(frames)));
});

test('and in this thread', () => {
  // In a process of its own: a thread keeps the decoder that it began with.
  const code = `
    import { readFileSync } from 'node:fs';
    import { createSession, segmentVideo } from 'tracecut';
    import { withTrap } from './tests/trap.mjs';
    const decoder = withTrap(new Uint8Array(readFileSync('dist/decoder_bg.wasm')), 'decode');
    const session = await createSession({ decoder });
    const frame = (t) => ({ data: new Uint8Array(4 * 64).map((_, b) => 7 * b + 9 * t), width: 8, height: 8 });
    const codes = [];
    for (let k = 0; k < 2; k += 1) await session.push(new Uint8Array(9)).catch(({ code }) => codes.push(code));
    for (let t = 0; t < 3; t += 1) await session.push(frame(t));
    codes.push((await session.run()).numFrames);
    await segmentVideo([new Uint8Array(9)], { decoder }).collect().catch(({ code }) => codes.push(code));
    console.log(codes.join());`;
  const said = execFileSync(process.execPath, ['--input-type=module', '-e', code], { cwd: root, encoding: 'utf8' });
  assert.equal(said.trim(), 'decode,decode,3,decode');
});
