// Image files are decoded in wasm: the same bytes everywhere.

import assert from 'node:assert/strict';
import { test } from 'node:test';
import { createSession } from 'tracecut';
import { JPEG, PROGRESSIVE_JPEG } from './pictures.mjs';
import { fingerprint, framesOf, plain, png, rejects, segment } from './support.mjs';

test('a clip of PNG files gives the same result as its pixels, however the bytes are held', async () => {
  const frames = (await framesOf()).slice(0, 3);
  const files = frames.map((frame) => png(frame));
  const pixels = fingerprint(await segment(frames));
  assert.equal(fingerprint(await segment(files)), pixels);
  const held = [files[0].buffer, new Blob([files[1]], { type: 'image/png' }), Buffer.from(files[2])];
  assert.equal(fingerprint(await segment(held)), pixels);
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
  const shared = { ...frames[0], data: new Uint8ClampedArray(frames[0].data.length) };
  const pushed = frames.map((frame) => {
    shared.data.set(frame.data);
    return session.push(shared);
  });
  shared.data.fill(0);
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
