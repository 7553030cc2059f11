// The README's and the guide's blocks of code for Node, run as they stand in a project that has installed the package.

import assert from 'node:assert/strict';
import { execFileSync } from 'node:child_process';
import { mkdirSync, readFileSync, readdirSync, writeFileSync } from 'node:fs';
import { join } from 'node:path';
import { test } from 'node:test';
import { gzipSync } from 'node:zlib';
import { root } from '../../scripts/tools.mjs';
import { installed } from '../package/installed.mjs';
import { RUN, readmeCode } from '../readme.mjs';
import { framesOf, png } from './support.mjs';

const code = readmeCode();
const read = (file) => readFileSync(join(root, file), 'utf8');
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
    `console.log(edit.parts.size > 1, editor.undoable, editor.labels(4)[80 * 256 + 100]); session.close();`,
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

test('the lines for a newcomer are few', () => {
  const lines = (heading) =>
    code
      .get(heading)
      .trim()
      .split('\n')
      .filter((line) => line && !line.startsWith('import')).length;
  assert.ok(lines('In Node') <= 10 && lines('In the browser') <= 10);
});

test('the blocks for Node do what they say', async (t) => {
  const folder = installed(t);
  mkdirSync(join(folder, 'frames'));
  (await framesOf(SCENE)).forEach((frame, k) => writeFileSync(join(folder, 'frames', `${k}.png`), png(frame)));
  run(folder, 'In Node');
  assert.deepEqual(readdirSync(join(folder, 'masks')).sort(), [
    '0.png',
    '1.png',
    '2.png',
    '3.png',
    '4.png',
    '5.png',
    '6.png',
    '7.png',
  ]);
  assert.match(run(folder, 'Sessions'), /masks \d+ \d+\n\d{3,} trajectories, [1-9] objects\n$/);
  assert.equal(run(folder, 'Corrections'), '3 true true\n');
  assert.equal(run(folder, 'Edits by hand'), 'true 1 0\n');
  assert.equal(run(folder, 'Single images'), '9216 9216 9216 true true 9216 9216\n');
  assert.match(run(folder, 'Errors'), /^param cut\.spatialWeight = -1 \(expected /);
});

test('the README is short, and shows both commands and the picture on its first screen', () => {
  const readme = read('README.md');
  assert.ok(Buffer.byteLength(readme) <= 10 * 1024, `${Buffer.byteLength(readme)} bytes`);
  const first = readme.split('\n').slice(0, 20).join('\n');
  for (const what of ['npm start', 'npm test', 'docs/tracecut.webp']) assert.ok(first.includes(what), what);
});

test('the sizes that README and guide name are the sizes of the build', () => {
  const texts = `${read('README.md')}\n${read('docs/guide.md')}`;
  const named = [
    ['tracecut_bg.wasm', /the wasm file is (\d+) kB\s+gzipped/],
    ['vendor/media.js', /reads and writes video files \((\d+) kB\s+gzipped\)/],
    ['decoder_bg.wasm', /decodes PNG and JPEG \((\d+) kB\)/],
  ];
  for (const [name, words] of named) {
    const kilobytes = gzipSync(readFileSync(join(root, 'dist', name)), { level: 9 }).length / 1000;
    const said = Number(words.exec(texts)?.[1]);
    assert.ok(Math.abs(said - kilobytes) < 0.04 * kilobytes, `${name}: ${kilobytes} kB, the text says ${said}`);
  }
});
