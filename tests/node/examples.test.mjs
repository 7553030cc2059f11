// The example for Node, in a folder of its own with the packed tarball.

import assert from 'node:assert/strict';
import { spawnSync } from 'node:child_process';
import { mkdirSync, readFileSync, readdirSync, writeFileSync } from 'node:fs';
import { join } from 'node:path';
import { test } from 'node:test';
import { installed } from '../package/installed.mjs';
import { framesOf, png } from './support.mjs';

test('the Node example writes a palette PNG for each frame of a folder', async (t) => {
  const folder = installed(t, 'examples/node');
  const frames = await framesOf({ width: 256, height: 144, frames: 12, seed: 1 });
  mkdirSync(join(folder, 'frames'));
  // Names as cameras give them: 2 comes before 10.
  frames.forEach((frame, k) => writeFileSync(join(folder, 'frames', `frame${k}.png`), png(frame)));
  const { status, stdout, stderr } = spawnSync(process.execPath, ['masks.mjs', 'frames', 'masks'], {
    cwd: folder,
    encoding: 'utf8',
  });
  assert.equal(status, 0, stderr);
  assert.match(stdout, /12 of 12 frames, [1-9] objects/);
  assert.deepEqual(readdirSync(join(folder, 'masks')).sort(), frames.map((_, k) => `frame${k}.png`).sort());
  const file = readFileSync(join(folder, 'masks', 'frame11.png'));
  assert.deepEqual(
    [file.readUInt32BE(16), file.readUInt32BE(20), file[25]],
    [256, 144, 3],
    'width, height, indexed colour',
  );
});

test('the Node example says how it is used', (t) => {
  const folder = installed(t, 'examples/node');
  const { status, stderr } = spawnSync(process.execPath, ['masks.mjs'], { cwd: folder, encoding: 'utf8' });
  assert.deepEqual([status, stderr], [2, 'Usage: node masks.mjs FRAMES MASKS\n']);
});
