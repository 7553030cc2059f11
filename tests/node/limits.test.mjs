// Input that is empty, tiny, still, broken, wrong or too large: an answer or an error in words, never a crash.

import assert from 'node:assert/strict';
import { execFileSync } from 'node:child_process';
import { readFile } from 'node:fs/promises';
import { test } from 'node:test';
import { setFlagsFromString } from 'node:v8';
import { runInNewContext } from 'node:vm';
import { createSession, parameters, segmentVideo, synthClip, videoFrames } from 'tracecut';
import { boundaries } from 'tracecut/stages';
import { root } from '../../scripts/tools.mjs';
import { withMemory, withTrap } from '../faulty-wasm.mjs';
import { fingerprint, framesOf, open, plain, png, ready, rejects, segment, SMALL, watchMemories } from './support.mjs';

test('a run without frames says that motion needs two', async (t) => {
  const session = await open(t);
  await rejects(session.run(), 'too-few-frames', /0 frame\(s\) given \(expected at least 2/);
});

test('one frame is too few, and a second one may still follow', async (t) => {
  const session = await open(t);
  const [first, second] = await framesOf();
  await session.push(first);
  await rejects(session.run(), 'too-few-frames', /1 frame/);
  await session.push(second);
  assert.equal((await session.run()).numFrames, 2);
});

test('two frames give trajectories of two points', async () => {
  const result = await segment((await framesOf()).slice(0, 2));
  assert.ok(result.trajectories.count > 0);
  assert.equal(result.trajectories.x.length, 2 * result.trajectories.count);
});

test('frames of changing size are refused and the session stays usable', async (t) => {
  const session = await open(t);
  const [first, second] = await framesOf();
  await session.push(first);
  await rejects(session.push(plain(64, 48)), 'frame-size-changed', /frame 1 is 64x48 \(expected 128x72/);
  await session.push(second);
  assert.equal(session.numFrames, 2);
  assert.equal((await session.run()).numFrames, 2);
});

for (const [width, height] of [
  [1, 1],
  [17, 3],
  [3, 17],
  [1, 40],
  [2, 2],
]) {
  test(`a clip of ${width}x${height} pixels gives a result that fits together`, async () => {
    const frames = [0, 1, 2].map((t) => plain(width, height, (x, y) => (40 * (x + t) + 70 * y) % 256));
    const result = await segment(frames);
    assert.deepEqual([result.width, result.height, result.numFrames], [width, height, 3]);
    fitsTogether(result);
  });
}

test('an all-black clip gives a result without objects', async () => {
  const result = await segment(Array.from({ length: 5 }, () => plain(64, 48)));
  fitsTogether(result);
  assert.ok(result.clusters.count <= 1, `${result.clusters.count} clusters`);
});

test('a still video is one cluster that does not move', async () => {
  const [first] = await framesOf();
  const result = await segment(Array.from({ length: 5 }, () => first));
  fitsTogether(result);
  assert.equal(result.clusters.count, 1);
  const { count, offset, x } = result.trajectories;
  for (let i = 0; i < count; i += 1) {
    assert.ok(Math.abs(x[offset[i + 1] - 1] - x[offset[i]]) < 0.05, `trajectory ${i} moved`);
  }
});

test('alpha is ignored', async () => {
  const frames = (await framesOf()).slice(0, 3);
  const transparent = frames.map((frame) => ({ ...frame, data: frame.data.map((v, i) => (i % 4 === 3 ? 0 : v)) }));
  assert.equal(fingerprint(await segment(transparent)), fingerprint(await segment(frames)));
});

test('outside trajectories are clustered, and NaN in them is refused by place and value', async (t) => {
  const session = await open(t);
  const tracks = twoGroups();
  const broken = { ...tracks, x: tracks.x.with(7, NaN) };
  await rejects(session.setTrajectories(broken), 'data', /x\[7\] = NaN/);
  await rejects(session.setTrajectories({ ...tracks, x: tracks.x.slice(1) }), 'data', /x/);
  await rejects(session.setTrajectories({ ...tracks, numFrames: 3 }), 'data', /frame/);
  await rejects(session.setTrajectories({ ...tracks, numFrames: 1 }), 'too-few-frames');
  await session.setTrajectories(tracks);
  const result = await session.run();
  assert.deepEqual([result.width, result.height, result.numFrames], [100, 100, 10]);
  assert.equal(result.trajectories.count, 100);
  assert.equal(result.clusters.count, 2);
  for (let i = 0; i < 100; i += 1) assert.equal(result.clusters.label[i] === result.clusters.label[0], i % 10 < 5);
  assert.deepEqual(result.trajectories.x, tracks.x);
});

test('wrong types of trajectories are named', async (t) => {
  const session = await open(t);
  const tracks = twoGroups();
  const refused = (wrong, code, message) => rejects(session.setTrajectories({ ...tracks, ...wrong }), code, message);
  await rejects(session.setTrajectories(null), 'data', /trajectories = null/);
  await refused({ offset: 'many' }, 'data', /offset = "many" \(expected a Uint32Array/);
  await refused({ startFrame: [0.5] }, 'data', /startFrame\[0\] = 0.5/);
  await refused({ width: 0 }, 'frame-size', /width = 0 \(expected a whole number, 1\.\.=16384\)/);
});

test('a trajectory that begins at the end of 32 bits is refused, not taken for one that has ended', async (t) => {
  const session = await open(t);
  const tracks = twoGroups();
  const startFrame = Uint32Array.from(tracks.startFrame).fill(4294967295, 0, 1);
  await rejects(session.setTrajectories({ ...tracks, startFrame }), 'data', /trajectory 0 ends in frame 4294967294/);
  await session.setTrajectories(tracks);
  assert.equal((await session.run()).clusters.count, 2);
});

test('misspelt options, wrong types and values out of range are named with the allowed ones', async () => {
  const refused = (options, message) => rejects(createSession(options), 'param', message);
  await refused({ clip: { maxSize: 320 } }, /clip\.maxSize = 320 .*clip\.maxSide/);
  await refused({ maxSide: 320 }, /maxSide = 320/);
  await refused({ clip: { maxSide: '320' } }, /clip\.maxSide = "320" \(expected a whole number, 16\.\.=4096\)/);
  await refused({ clip: { maxSide: 320.5 } }, /320\.5/);
  await refused({ clip: { maxSide: 8 } }, /clip\.maxSide = 8 \(expected a whole number, 16\.\.=4096\)/);
  await refused({ clip: { maxSide: NaN } }, /NaN/);
  await refused({ clip: { maxSide: null } }, /clip\.maxSide = null/);
  await refused({ clip: { maxSide: [320] } }, /clip\.maxSide = a list of 1/);
  await refused({ clip: { maxSide: () => 320 } }, /clip\.maxSide = a function/);
  await refused('fast', /options = "fast"/);
  await refused(null, /options = null/);
  await refused({ worker: 1 }, /worker = 1 \(expected true, false, an address or a function that starts one\)/);
  const circular = { clip: {} };
  circular.clip.clip = circular.clip;
  await refused(circular, /clip\.clip/);
  const session = await createSession({ clip: { maxSide: undefined }, flow: undefined });
  session.close();
});

test('frames of wrong types and lengths are named', async (t) => {
  const session = await open(t);
  for (const wrong of [undefined, null, 5, 'frame.png', {}, [], new Uint8ClampedArray(4), new Float32Array(4)]) {
    await rejects(session.push(wrong), 'data', /frame = .*\(expected ImageData/);
  }
  const refused = (data, message) => rejects(session.push({ data, width: 2, height: 2 }), 'frame-bytes', message);
  await refused(new Uint8Array(15), /15 bytes \(expected 16\)/);
  await refused([0, 0, 0, 0], /a list of 4/);
  await refused(new Float32Array(16), /Float32Array/);
  const size = /frame\.width = .*1\.\.=16384/;
  for (const width of [0, -1, 1.5, NaN, '2', 16385, 2 ** 32 + 1])
    await rejects(session.push({ data: new Uint8Array(4), width, height: 1 }), 'frame-size', size);
  assert.equal(session.numFrames, 0);
});

test('a detached buffer is an error of the frame, and the session stays usable', async (t) => {
  const session = await open(t);
  const frame = plain(8, 8);
  structuredClone(frame.data, { transfer: [frame.data.buffer] });
  await rejects(session.push(frame), 'frame-bytes', /0 bytes \(expected 256\)/);
  await session.push(plain(8, 8));
});

test('truncated and broken image files are refused and the session stays usable', async (t) => {
  const session = await open(t);
  const file = png(plain(40, 30, (x, y) => (x * 31 + y * 17) % 256));
  for (const length of [0, 1, 7, 8, 20, 33, Math.floor(file.length / 2), file.length - 20]) {
    await rejects(session.push(file.slice(0, length)), 'decode', /expected a whole PNG or JPEG file/);
  }
  const damaged = file.slice();
  damaged[Math.floor(file.length / 2)] ^= 0xff;
  await rejects(session.push(damaged), 'decode');
  await rejects(session.push(new TextEncoder().encode('<!doctype html>')), 'decode');
  await session.push(file);
  assert.equal(session.numFrames, 1);
});

test('a picture that claims to be gigantic is refused before memory is taken', async (t) => {
  const session = await open(t);
  for (const claim of [
    [65535, 65535],
    [16384, 16384],
    [0, 4],
  ]) {
    await assert.rejects(session.push(png(plain(4, 4), claim)), {
      name: 'TraceCutError',
      code: /^(decode|frame-size|too-large)$/,
    });
  }
  await session.push(png(plain(4, 4)));
});

test('wrong frame numbers are refused with the legal range', async (t) => {
  const session = await ready(t);
  const result = await session.run();
  const range = /expected a whole number, 0\.\.=7/;
  for (const wrong of [-1, 8, 0.5, NaN, '0', undefined]) {
    assert.throws(() => result.edges(wrong), { code: 'param', message: range });
    assert.throws(() => result.labels(wrong), { code: 'param', message: range });
    for (const call of ['superpixels', 'boundaries']) {
      await rejects(result[call](wrong), 'param', range);
      await rejects(session[call](wrong), 'param', range);
    }
    await rejects(session.flow(wrong), 'param', /expected a whole number, 0\.\.=6/);
  }
  assert.equal((await session.flow(6)).width, 128);
});

test('wrong options of a synthetic clip are named', async () => {
  await rejects(synthClip({ width: 0 }), 'param', /width = 0/);
  await rejects(synthClip({ widht: 10 }), 'param', /widht = 10/);
  await rejects(synthClip(3), 'param', /options = 3/);
  const clip = await synthClip({ width: 16, height: 9, frames: 2 });
  assert.throws(() => clip.frame(2), { code: 'param' });
});

/** Ten by ten points over ten frames; the left half stands still, the right half moves down. */
function twoGroups() {
  const [numFrames, count] = [10, 100];
  const startFrame = new Uint32Array(count);
  const offset = Uint32Array.from({ length: count + 1 }, (_, i) => i * numFrames);
  const x = Float32Array.from({ length: count * numFrames }, (_, p) => 10 * (Math.floor(p / numFrames) % 10) + 5);
  const y = Float32Array.from({ length: count * numFrames }, (_, p) => {
    const i = Math.floor(p / numFrames);
    return 8 * Math.floor(i / 10) + 4 + (i % 10 < 5 ? 0 : 2 * (p % numFrames));
  });
  return { numFrames, width: 100, height: 100, startFrame, offset, x, y };
}

/** Checks that the arrays of a result have the lengths and ranges that their descriptions promise. */
function fitsTogether(result) {
  const { width, height, numFrames, trajectories, clusters, thresholdClusters, embedding, objects } = result;
  const { count, startFrame, offset, x, y } = trajectories;
  assert.equal(startFrame.length, count);
  assert.equal(offset.length, count + 1);
  assert.equal(x.length, offset[count]);
  assert.equal(y.length, offset[count]);
  assert.ok(
    x.every((v) => v >= -0.5 && v <= width) && y.every((v) => v >= -0.5 && v <= height),
    'a point is outside of the frame',
  );
  assert.equal(clusters.label.length, count);
  assert.equal(thresholdClusters.label.length, count);
  assert.ok(thresholdClusters.label.every((label) => label < thresholdClusters.count));
  assert.ok(clusters.label.every((label) => label < clusters.count));
  assert.equal(embedding.vectors.length, count * embedding.dimensions);
  assert.equal(embedding.eigenvalues.length, embedding.dimensions);
  assert.ok(numFrames >= 2);
  assert.equal(clusters.object.length, clusters.count);
  const labels = new Set([0, ...objects.map(({ label }) => label)]);
  for (let t = 0; t < numFrames; t += 1) {
    const mask = result.labels(t);
    assert.equal(mask.length, width * height);
    assert.ok(
      mask.every((label) => labels.has(label)),
      `a label in frame ${t} that is no object's`,
    );
  }
}

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

test('limits have defaults and ranges, and refuse larger values', async () => {
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
  const frameStream = videoFrames([{ data: new Uint8Array(4), width: 16384, height: 16384 }]);
  await rejects(frameStream.next(), 'too-large', /268435456/);
});

test('a trap of the decoder is an error of the file, on a thread of its own', async (t) => {
  const decoder = withTrap(await packaged('decoder'), 'decode');
  const frames = await framesOf();
  const session = await open(t, { worker: true, decoder });
  for (const frame of frames) await session.push(frame);
  const message = /^frame 8: image cannot be decoded: the decoder stopped on an internal error: .*unreachable/;
  for (let k = 0; k < 2; k += 1) await rejects(session.push(png(frames[0])), 'decode', message);
  assert.equal(fingerprint(await session.run()), fingerprint(await segment(frames)));
});

test('and in this thread', () => {
  // In a process of its own: a thread keeps the decoder that it began with.
  const code = `
    import { readFileSync } from 'node:fs';
    import { createSession, segmentVideo } from 'tracecut';
    import { withTrap } from './tests/faulty-wasm.mjs';
    const decoder = withTrap(new Uint8Array(readFileSync('dist/decoder_bg.wasm')), 'decode');
    const session = await createSession({ decoder });
    const frame = (t) => ({ data: new Uint8Array(4 * 64).map((_, b) => 7 * b + 9 * t), width: 8, height: 8 });
    const codes = [];
    for (let k = 0; k < 2; k += 1) await session.push(new Uint8Array(9)).catch(({ code }) => codes.push(code));
    for (let t = 0; t < 3; t += 1) await session.push(frame(t));
    codes.push((await session.run()).numFrames);
    await segmentVideo([new Uint8Array(9)], { decoder }).collect().catch(({ code }) => codes.push(code));
    console.log(codes.join());`;
  const printed = execFileSync(process.execPath, ['--input-type=module', '-e', code], { cwd: root, encoding: 'utf8' });
  assert.equal(printed.trim(), 'decode,decode,3,decode');
});
