// The README's and the guide's blocks of code for Node, run as they stand in a project that has installed the package.

import assert from 'node:assert/strict';
import { execFileSync } from 'node:child_process';
import { mkdirSync, readdirSync, writeFileSync } from 'node:fs';
import { join } from 'node:path';
import { test } from 'node:test';
import { installed } from '../package/installed.mjs';
import { RUN, readmeCode } from '../readme.mjs';
import { framesOf, png } from './support.mjs';

const code = readmeCode();
const SCENE = { width: 256, height: 144, frames: 8, seed: 1 };

/** What a block takes for granted, and what is looked at when it is over. */
const AROUND = {
  Corrections: [
    `import { createSession, synthClip } from 'tracecut';
     const clip = await synthClip(${JSON.stringify(SCENE)});
     const session = await createSession();
     for (let t = 0; t < clip.numFrames; t += 1) await session.push(clip.frame(t));`,
    'console.log(session.corrections, result.objects.length > 1, result.labels(0)[y * result.width + x] === result.labels(0)[y * result.width + x + 45]);',
  ],
  'Edits by hand': [
    `import { createSession, synthClip } from 'tracecut';
     const clip = await synthClip(${JSON.stringify(SCENE)});
     const session = await createSession();
     for (let t = 0; t < clip.numFrames; t += 1) await session.push(clip.frame(t));
     const result = await session.run();`,
    `console.log(edit.paints[0].parts.size > 1, editor.undoable, editor.labels(4)[80 * 256 + 100]); session.close();`,
  ],
  'Single images': [
    `import { synthClip } from 'tracecut';
     const image = (await synthClip({ width: 128, height: 72 })).frame(0);`,
    'console.log(pb.length, thin.length, label.length, count > 20, borders.a.length > 20, discontinuity.length, combined.length);',
  ],
  Errors: ["import { createSession } from 'tracecut';", ''],
};

function run(folder, heading) {
  const [before, after] = AROUND[heading] ?? ['', ''];
  writeFileSync(join(folder, 'main.mjs'), `${before}\n${code.get(heading)}\n${after}\n`);
  return execFileSync(process.execPath, ['main.mjs'], { cwd: folder, encoding: 'utf8' });
}

test('every block of JavaScript in README and guide is run by some test', () => {
  assert.deepEqual([...code.keys()].sort(), Object.values(RUN).flat().sort());
});

test('the blocks for Node do what they say', async (t) => {
  const folder = installed(t);
  mkdirSync(join(folder, 'frames'));
  (await framesOf(SCENE)).forEach((frame, k) => writeFileSync(join(folder, 'frames', `${k}.png`), png(frame)));
  run(folder, 'In Node');
  assert.deepEqual(
    readdirSync(join(folder, 'masks')).sort(),
    [...'01234567'].map((name) => `${name}.png`),
  );
  assert.match(run(folder, 'Sessions'), /masks \d+ \d+\n\d{3,} trajectories, [1-9] objects\n$/);
  assert.equal(run(folder, 'Corrections'), '3 true true\n');
  assert.equal(run(folder, 'Edits by hand'), 'true 2 0\n');
  assert.equal(run(folder, 'Single images'), '9216 9216 9216 true true 9216 9216\n');
  assert.match(run(folder, 'Errors'), /^param clip\.maxSide = -1 \(expected /);
});
