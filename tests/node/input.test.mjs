// Frames as files and pixels, and input that is empty, tiny, still, broken, wrong or too large: a result or an error that says why.

import assert from 'node:assert/strict';
import { mkdirSync, mkdtempSync, rmSync, writeFileSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import { after, test } from 'node:test';
import { pathToFileURL } from 'node:url';
import { createSession, maskPng, parameters, readFrames, segmentVideo, synthClip, videoFrames } from 'tracecut';
import { boundaries } from 'tracecut/stages';
import { readFrames as pageFrames } from '../../dist/index.js';
import { withMemory, withTrap } from '../faulty-wasm.mjs';
import {
  collect,
  each,
  fingerprint,
  framesOf,
  JPEG,
  open,
  plain,
  png,
  printOf,
  PROGRESSIVE_JPEG,
  readWasm,
  ready,
  rejects,
  runModule,
  segment,
  SMALL,
  untilCollected,
  watchMemories,
} from './support.mjs';

/** The result of the first frames of the small clip. */
const threeFrames = framesOf().then((frames) => frames.slice(0, 3));
const threePrint = threeFrames.then(async (frames) => fingerprint(await segment(frames)));

test('a clip of PNG files gives the same result as its pixels, however the bytes are held', async () => {
  const frames = await threeFrames;
  const files = frames.map((frame) => png(frame));
  const pixels = await threePrint;
  assert.equal(fingerprint(await segment(files)), pixels);
  const sources = [files[0].buffer, new Blob([files[1]], { type: 'image/png' }), Buffer.from(files[2])];
  assert.equal(fingerprint(await segment(sources)), pixels);
});

test('frames are taken in the order of the calls, files and pixels mixed', async (t) => {
  const frames = await threeFrames;
  const session = await open(t);
  await Promise.all(frames.map((frame, k) => session.push(k % 2 === 0 ? new Blob([png(frame)]) : frame)));
  assert.equal(fingerprint(await session.run()), await threePrint);
});

test('the caller may reuse a buffer as soon as push has returned', async (t) => {
  const frames = await threeFrames;
  const session = await open(t);
  const reusedFrame = { ...frames[0], data: new Uint8ClampedArray(frames[0].data.length) };
  const pushed = frames.map((frame) => {
    reusedFrame.data.set(frame.data);
    return session.push(reusedFrame);
  });
  reusedFrame.data.fill(0);
  await Promise.all(pushed);
  assert.equal(fingerprint(await session.run()), await threePrint);
});

for (const [name, file] of Object.entries({ baseline: JPEG, progressive: PROGRESSIVE_JPEG })) {
  test(`a ${name} JPEG file is taken, a truncated one is not`, async (t) => {
    const session = await open(t);
    await session.push(file);
    assert.deepEqual([session.width, session.height], [24, 16]);
    for (const length of [3, 20, Math.floor(file.length / 2), file.length - 40]) {
      await rejects(session.push(file.slice(0, length)), 'decode', /JPEG|expected/);
    }
    await session.push(file);
    assert.equal(session.numFrames, 2);
  });
}

test('a file of another size than the first frame is refused', async (t) => {
  const session = await open(t);
  await session.push(png(plain(10, 10)));
  await rejects(session.push(JPEG), 'frame-size-changed', /24x16 \(expected 10x10/);
});

const folders = [];
after(() => folders.forEach((folder) => rmSync(folder, { recursive: true })));

/** A folder of files, by name; those without contents are a grey image each. */
async function folderOf(files) {
  const folder = mkdtempSync(join(tmpdir(), 'tracecut-'));
  folders.push(folder);
  const masks = { width: 16, height: 16, numFrames: 1, labels: () => new Uint8Array(256) };
  const grey = await maskPng(masks, 0);
  for (const [name, contents] of Object.entries(files)) writeFileSync(join(folder, name), contents ?? grey);
  return folder;
}

const namesOf = async (frames) => each(await collect(frames), 'name');

test('frames come in the order of their numbers, without hidden files and other files', async () => {
  const files = { 'frame10.png': null, 'frame2.png': null, 'Frame1.PNG': null, 'frame02b.jpg': null };
  const otherFiles = { '.DS_Store': 'x', '._frame2.png': 'x', 'Thumbs.db': 'x', 'notes.txt': 'x' };
  const folder = await folderOf({ ...files, ...otherFiles });
  mkdirSync(join(folder, 'more.png'));
  const expected = ['Frame1.PNG', 'frame2.png', 'frame02b.jpg', 'frame10.png'];
  assert.deepEqual(await namesOf(readFrames(folder)), expected);
  assert.deepEqual(await namesOf(readFrames(pathToFileURL(folder))), expected);
  const selection = [...Object.keys(files), '.DS_Store'].map((name) => new File(['x'], name));
  assert.deepEqual(await namesOf(pageFrames(selection)), expected);
});

test('the same number written otherwise, and numbers beyond any integer, have an order too', async () => {
  const names = ['a1.png', 'a01.png', 'a001.png', `a${'9'.repeat(30)}.png`, `a1${'0'.repeat(30)}.png`, 'a.png'];
  const files = (list) => list.map((name) => new File(['x'], name));
  const pageNames = await namesOf(pageFrames(files(names)));
  assert.deepEqual(await namesOf(pageFrames(files(names.reverse()))), pageNames);
  assert.deepEqual(pageNames.slice(-2), [`a${'9'.repeat(30)}.png`, `a1${'0'.repeat(30)}.png`]);
});

test('a folder without frames, of another format, or that is not there, is an error that says so', async () => {
  const empty = await folderOf({ 'notes.txt': 'x', '.hidden.png': 'x' });
  await rejects(namesOf(readFrames(empty)), 'no-frames', /no PNG or JPEG .*only notes\.txt/);
  const otherFolder = await folderOf({ 'a.png': null, 'b.webp': 'x' });
  await rejects(namesOf(readFrames(otherFolder)), 'data', /"b\.webp" .*PNG or JPEG/);
  await rejects(namesOf(readFrames(join(empty, 'none'))), 'no-frames', /none cannot be read/);
  await rejects(namesOf(readFrames(7)), 'data', /folder = 7/);
  await rejects(namesOf(pageFrames('frames')), 'unsupported', /webkitdirectory/);
});

test('a frame that cannot be decoded is named, wherever it is met', async () => {
  const folder = await folderOf({ 'f1.png': null, 'f2.png': null, 'f3.png': 'no image', 'f4.png': null });
  const message = /^frame 2 \(f3\.png\): /;
  await rejects(segmentVideo(readFrames(folder)).collect(), 'decode', message);
  await rejects(collect(videoFrames(readFrames(folder))), 'decode', message);
  const damages = [];
  const segmentation = segmentVideo(readFrames(folder), { onDamage: (damage) => damages.push(damage) });
  assert.equal((await segmentation.collect()).numFrames, 2);
  assert.match(damages[0].error.message, message);
});

test('a session names the faulty frame, and stays usable', async () => {
  const session = await createSession();
  const [good] = await collect(readFrames(await folderOf({ 'a.png': null })));
  await session.push(good.frame);
  await rejects(session.push(new Uint8Array(9)), 'decode', /^frame 1: /);
  await rejects(session.push(new File(['x'], 'b.png')), 'decode', /^frame 1 \(b\.png\): /);
  await session.push(good.frame);
  assert.equal(session.numFrames, 2);
  await session.clear();
  await rejects(session.push(new Uint8Array(9)), 'decode', /^frame 0: /);
  session.close();
});

test('a list says which of its frames has wrong pixels or times', async () => {
  const frame = { data: new Uint8Array(4), width: 1, height: 1 };
  const short = { data: new Uint8Array(3), width: 1, height: 1 };
  const read = async (list) => collect(videoFrames(list));
  await rejects(read([frame, { frame: short, name: 'b' }]), 'frame-bytes', /^frame 1 \(b\): /);
  await rejects(read([frame, { frame, time: NaN }]), 'data', /time = NaN of frame 1 /);
});

test('a run without frames says that motion needs two', async (t) => {
  const session = await open(t);
  await rejects(session.run(), 'too-few-frames', /0 frame\(s\) given \(expected at least 2/);
});

test('one frame is too few, and a second one may still follow, for trajectories of two points', async (t) => {
  const session = await open(t);
  const [first, second] = await framesOf();
  await session.push(first);
  await rejects(session.run(), 'too-few-frames', /1 frame/);
  await rejects(session.push(plain(64, 48)), 'frame-size-changed', /frame 1 is 64x48 \(expected 96x54/);
  await session.push(second);
  const { numFrames, trajectories } = await session.run();
  assert.equal(numFrames, 2);
  assert.ok(trajectories.count > 0);
  assert.equal(trajectories.x.length, 2 * trajectories.count);
});

for (const size of ['1x1', '17x3', '3x17', '1x40', '2x2']) {
  test(`a clip of ${size} pixels gives a result that fits together`, async () => {
    const [width, height] = size.split('x').map(Number);
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
  const frames = await threeFrames;
  const transparent = frames.map((frame) => ({ ...frame, data: frame.data.map((v, i) => (i % 4 === 3 ? 0 : v)) }));
  assert.equal(fingerprint(await segment(transparent)), await threePrint);
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
  const error = { name: 'TraceCutError', code: /^(decode|frame-size|too-large)$/ };
  for (const size of ['65535x65535', '16384x16384', '0x4'])
    await assert.rejects(session.push(png(plain(4, 4), size.split('x').map(Number))), error);
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
  assert.equal((await session.flow(6)).width, 96);
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
  for (const v of x) assert.ok(v >= -0.5 && v <= width, 'a point is outside of the frame');
  for (const v of y) assert.ok(v >= -0.5 && v <= height, 'a point is outside of the frame');
  assert.equal(clusters.label.length, count);
  assert.equal(thresholdClusters.label.length, count);
  assert.ok(thresholdClusters.label.every((label) => label < thresholdClusters.count));
  assert.ok(clusters.label.every((label) => label < clusters.count));
  assert.equal(embedding.vectors.length, count * embedding.dimensions);
  assert.equal(embedding.eigenvalues.length, embedding.dimensions);
  assert.ok(numFrames >= 2);
  assert.equal(clusters.object.length, clusters.count);
  const labels = new Set([0, ...each(objects, 'label')]);
  for (let t = 0; t < numFrames; t += 1) {
    const mask = result.labels(t);
    assert.equal(mask.length, width * height);
    const unknown = mask.find((label) => !labels.has(label));
    assert.equal(unknown, undefined, `a label in frame ${t} that is no object's`);
  }
}

/** The engine with memory for some hundred small frames. */
const smallWasm = readWasm().then((bytes) => WebAssembly.compile(withMemory(bytes, 16)));

for (const worker of [false, true]) {
  const where = worker ? 'on a thread of its own' : 'in this thread';

  test(`frames beyond the limits are refused, ${where}, and the session goes on`, async (t) => {
    const session = await open(t, { worker, clip: { maxPixels: 96 * 54, maxFrames: SMALL.frames } });
    const frames = await framesOf();
    const over = /^5238 pixels in .*\(expected at most 5184; the parameter clip\.maxPixels sets this limit\)$/;
    await rejects(session.push(plain(97, 54)), 'too-large', over);
    await rejects(session.push(png(plain(97, 54))), 'too-large', /^frame 0: 5238 pixels in an image file/);
    await rejects(session.push(new Blob([png(plain(8, 8), [16384, 16384])])), 'too-large', /268435456/);
    for (const frame of frames) await session.push(frame);
    await rejects(session.push(frames[0]), 'too-large', /^9 frames in a session \(expected at most 8/);
    assert.equal(session.numFrames, SMALL.frames);
    assert.equal(fingerprint(await session.run()), await printOf());
  });

  test(`memory that runs out is an error, ${where}: it comes back, and the next session works`, async (t) => {
    const memories = watchMemories(t);
    const session = await open(t, { worker, threads: 1, wasm: await smallWasm });
    const [frame] = await framesOf({ ...SMALL, width: 128, height: 72, frames: 1 });
    let pushed = 0;
    const pushing = async () => {
      for (; pushed < 2000; pushed += 1) await session.push(frame);
    };
    await rejects(pushing(), 'memory', /ran out of memory at 1\d MiB\. Create a new session/);
    assert.ok(pushed > 100 && pushed < 1000, `${pushed} frames`);
    await rejects(session.push(frame), 'memory');
    await rejects(session.run(), 'memory');
    if (!worker) {
      const isCollected = await untilCollected(() => !memories[0].deref());
      assert.ok(isCollected, 'the memory is given back while the session is still there');
    }
    const again = await segment(await framesOf(), { worker, wasm: await smallWasm });
    assert.equal(fingerprint(again), await printOf());
  });

  test(`a frame that no memory is there for ends in the same error, ${where}`, async (t) => {
    const session = await open(t, { worker, threads: 1, wasm: await smallWasm });
    await rejects(session.push(plain(2000, 2000)), 'memory', /ran out of memory/);
  });
}

test('a run that needs more than there is says so', async (t) => {
  const wasm = await smallWasm;
  const frames = await framesOf({ ...SMALL, width: 640, height: 360 });
  const session = await ready(t, { threads: 1, wasm, clip: { maxSide: 640 } }, frames);
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
  await rejects(segmentVideo(frames, { clip: { maxPixels: 5183 }, size: 64 }).collect(), 'too-large', /5184 pixels/);
});

test('limits have defaults and ranges, and refuse larger values', async () => {
  const limits = parameters().filter(({ name }) => name.startsWith('clip.max') && name !== 'clip.maxSide');
  assert.deepEqual(each(limits, 'name', 'default'), [
    ['clip.maxPixels', 2 ** 26],
    ['clip.maxFrames', 1e4],
    ['clip.maxTrajectories', 1e6],
    ['clip.maxPoints', 1e8],
  ]);
  await rejects(boundaries({ data: new Uint8Array(4), width: 16384, height: 4097 }), 'too-large', /67125248 pixels/);
  const frameStream = videoFrames([{ data: new Uint8Array(4), width: 16384, height: 16384 }]);
  await rejects(frameStream.next(), 'too-large', /268435456/);
});

test('a trap of the decoder is an error of the file, on a thread of its own', async (t) => {
  const decoder = withTrap(await readWasm('decoder'), 'decode');
  const frames = await framesOf();
  const session = await ready(t, { worker: true, decoder }, frames);
  const message = /^frame 8: image cannot be decoded: the decoder stopped on an internal error: .*unreachable/;
  for (let k = 0; k < 2; k += 1) await rejects(session.push(png(frames[0])), 'decode', message);
  assert.equal(fingerprint(await session.run()), await printOf());
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
  assert.equal(runModule(code), 'decode,decode,3,decode\n');
});
