// Large frames and many of them: what fits works, and what does not ends in an error after which the next session works.

import assert from 'node:assert/strict';
import { readFile } from 'node:fs/promises';
import { test } from 'node:test';
import { createSession } from 'tracecut';
import { withMemory } from '../faulty-wasm.mjs';

const SIZE = { width: 4000, height: 3000 };

/** A frame of squares that move to the right, in memory that all frames share. */
function* frames(count) {
  const data = new Uint8Array(4 * SIZE.width * SIZE.height);
  const pixels = new Uint32Array(data.buffer);
  for (let t = 0; t < count; t += 1) {
    for (let p = 0; p < pixels.length; p += 1) {
      const [x, y] = [p % SIZE.width, Math.floor(p / SIZE.width)];
      pixels[p] = ((((x - 40 * t) >> 7) * 73 + (y >> 7) * 151) & 255) * 0x10101;
    }
    yield { data, ...SIZE };
  }
}

for (const worker of [false, true]) {
  const where = worker ? 'on a thread of its own' : 'in this thread';

  test(`60 frames of 4000 × 3000 have their masks, ${where}`, async (t) => {
    const session = await createSession({ worker, clip: { maxSide: 160 } });
    t.after(() => session.close());
    for (const frame of frames(60)) await session.push(frame);
    const result = await session.run();
    assert.equal(result.labels(59).length, SIZE.width * SIZE.height);
  });

  test(`kept at their size they need more than a GiB, ${where}, and the next session has it again`, async () => {
    const wasm = withMemory(
      new Uint8Array(await readFile(new URL('../../dist/tracecut_bg.wasm', import.meta.url))),
      1024,
    );
    for (let again = 0; again < 2; again += 1) {
      const session = await createSession({ worker, wasm, threads: 1, clip: { maxSide: 4096 } });
      const pushing = async () => {
        for (const frame of frames(60)) await session.push(frame);
      };
      await assert.rejects(pushing(), { code: 'memory' });
      // A worker also has the memory of the jobs that it does while it waits for frames.
      assert.ok(session.numFrames > (worker ? 5 : 10), `${session.numFrames} frames`);
    }
  });
}
