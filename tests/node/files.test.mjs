// Frames as image files, decoded in wasm to the same bytes everywhere, and folders of them.

import assert from 'node:assert/strict';
import { mkdirSync, mkdtempSync, rmSync, writeFileSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import { after, test } from 'node:test';
import { pathToFileURL } from 'node:url';
import { createSession, maskPng, readFrames, segmentVideo, videoFrames } from 'tracecut';
import { readFrames as pageFrames } from '../../dist/index.js';
import { JPEG, PROGRESSIVE_JPEG, fingerprint, framesOf, plain, png, rejects, segment } from './support.mjs';

test('a clip of PNG files gives the same result as its pixels, however the bytes are held', async () => {
  const frames = (await framesOf()).slice(0, 3);
  const files = frames.map((frame) => png(frame));
  const pixels = fingerprint(await segment(frames));
  assert.equal(fingerprint(await segment(files)), pixels);
  const sources = [files[0].buffer, new Blob([files[1]], { type: 'image/png' }), Buffer.from(files[2])];
  assert.equal(fingerprint(await segment(sources)), pixels);
});

test('frames are taken in the order of the calls, files and pixels mixed', async (t) => {
  const frames = (await framesOf()).slice(0, 4);
  const session = await createSession();
  t.after(() => session.close());
  await Promise.all(frames.map((frame, k) => session.push(k % 2 === 0 ? new Blob([png(frame)]) : frame)));
  assert.equal(fingerprint(await session.run()), fingerprint(await segment(frames)));
});

test('the caller may reuse a buffer as soon as push has returned', async (t) => {
  const frames = (await framesOf()).slice(0, 3);
  const session = await createSession();
  t.after(() => session.close());
  const reusedFrame = { ...frames[0], data: new Uint8ClampedArray(frames[0].data.length) };
  const pushed = frames.map((frame) => {
    reusedFrame.data.set(frame.data);
    return session.push(reusedFrame);
  });
  reusedFrame.data.fill(0);
  await Promise.all(pushed);
  assert.equal(fingerprint(await session.run()), fingerprint(await segment(frames)));
});

for (const [name, file] of Object.entries({ baseline: JPEG, progressive: PROGRESSIVE_JPEG })) {
  test(`a ${name} JPEG file is taken, a truncated one is not`, async (t) => {
    const session = await createSession();
    t.after(() => session.close());
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
  const session = await createSession();
  t.after(() => session.close());
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

async function listOf(frames) {
  const list = [];
  for await (const frame of frames) list.push(frame);
  return list;
}

async function namesOf(frames) {
  const names = [];
  for await (const { name } of frames) names.push(name);
  return names;
}

const refuses = (code, message) => (error) => {
  assert.equal(error.code, code);
  assert.match(error.message, message);
  return true;
};

test('frames come in the order of their numbers, without hidden files and other files', async () => {
  const files = { 'frame10.png': null, 'frame2.png': null, 'Frame1.PNG': null, 'frame02b.jpg': null };
  const folder = await folderOf({
    ...files,
    '.DS_Store': 'x',
    '._frame2.png': 'x',
    'Thumbs.db': 'x',
    'notes.txt': 'x',
  });
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
  await assert.rejects(namesOf(readFrames(empty)), refuses('no-frames', /no PNG or JPEG .*only notes\.txt/));
  const otherFolder = await folderOf({ 'a.png': null, 'b.webp': 'x' });
  await assert.rejects(namesOf(readFrames(otherFolder)), refuses('data', /"b\.webp" .*PNG or JPEG/));
  await assert.rejects(namesOf(readFrames(join(empty, 'none'))), refuses('no-frames', /none cannot be read/));
  await assert.rejects(namesOf(readFrames(7)), refuses('data', /folder = 7/));
  await assert.rejects(namesOf(pageFrames('frames')), refuses('unsupported', /webkitdirectory/));
});

test('a frame that cannot be decoded is named, wherever it is met', async () => {
  const folder = await folderOf({ 'f1.png': null, 'f2.png': null, 'f3.png': 'no image', 'f4.png': null });
  const checkError = refuses('decode', /^frame 2 \(f3\.png\): /);
  await assert.rejects(segmentVideo(readFrames(folder)).collect(), checkError);
  await assert.rejects(async () => {
    for await (const { frame } of videoFrames(readFrames(folder))) assert.equal(frame.width, 16);
  }, checkError);
  const damages = [];
  const segmentation = segmentVideo(readFrames(folder), { onDamage: (damage) => damages.push(damage) });
  assert.equal((await segmentation.collect()).numFrames, 2);
  assert.match(damages[0].error.message, /^frame 2 \(f3\.png\): /);
});

test('a session names the faulty frame, and stays usable', async () => {
  const session = await createSession();
  const [good] = await listOf(readFrames(await folderOf({ 'a.png': null })));
  await session.push(good.frame);
  await assert.rejects(session.push(new Uint8Array(9)), refuses('decode', /^frame 1: /));
  await assert.rejects(session.push(new File(['x'], 'b.png')), refuses('decode', /^frame 1 \(b\.png\): /));
  await session.push(good.frame);
  assert.equal(session.numFrames, 2);
  await session.clear();
  await assert.rejects(session.push(new Uint8Array(9)), refuses('decode', /^frame 0: /));
  session.close();
});

test('a list says which of its frames has wrong pixels or times', async () => {
  const frame = { data: new Uint8Array(4), width: 1, height: 1 };
  const short = { data: new Uint8Array(3), width: 1, height: 1 };
  const read = async (list) => listOf(videoFrames(list));
  await assert.rejects(read([frame, { frame: short, name: 'b' }]), refuses('frame-bytes', /^frame 1 \(b\): /));
  await assert.rejects(read([frame, { frame, time: NaN }]), refuses('data', /time = NaN of frame 1 /));
});
