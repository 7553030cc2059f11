// The blocks of code of docs/tasks.md, run as they stand in a project that has installed the package.

import assert from 'node:assert/strict';
import { execFileSync, spawn, spawnSync } from 'node:child_process';
import { copyFileSync, mkdirSync, readFileSync, writeFileSync } from 'node:fs';
import { join } from 'node:path';
import { test } from 'node:test';
import { fromTracksDat } from 'tracecut/stages';
import { installed } from '../package/installed.mjs';
import { freePort } from '../port.mjs';
import { TASKS, codeOf } from '../readme.mjs';
import { framesOf, png } from './support.mjs';

const code = codeOf('docs/tasks.md');
const SCENE = { width: 256, height: 144, frames: 8, seed: 1 };
const hasFfmpeg = spawnSync('ffmpeg', ['-version']).status === 0;

const file = (folder, name, bytes) => writeFileSync(join(folder, name), bytes);

/** A project with the package, and with the files that the blocks take. */
async function project(t) {
  const folder = installed(t);
  const frames = await framesOf(SCENE);
  mkdirSync(join(folder, 'frames'));
  frames.forEach((frame, k) => file(folder, join('frames', `${k}.png`), png(frame)));
  const rgb = Buffer.concat(frames.map(({ data }) => Buffer.from(data.filter((_, k) => k % 4 < 3))));
  file(folder, 'clip.rgb', rgb);
  if (hasFfmpeg) {
    const size = `${SCENE.width}x${SCENE.height}`;
    const raw = `-f rawvideo -pix_fmt rgb24 -s ${size} -r 10 -i clip.rgb`.split(' ');
    execFileSync('ffmpeg', ['-loglevel', 'error', ...raw, '-c:v', 'mpeg4', '-q:v', '2', 'clip.mp4'], { cwd: folder });
  }
  return folder;
}

/** What a block prints. */
function run(folder, heading) {
  file(folder, 'main.mjs', code.get(heading));
  const { status, stdout, stderr } = spawnSync(process.execPath, ['main.mjs'], { cwd: folder, encoding: 'utf8' });
  return { status, stdout, stderr };
}

function prints(folder, heading, expected) {
  const { status, stdout, stderr } = run(folder, heading);
  assert.equal(status, 0, `${heading}: ${stderr}`);
  assert.match(stdout, expected, heading);
}

async function answerOf(t, folder) {
  const port = await freePort();
  file(
    folder,
    'server.mjs',
    code.get('A server that answers meanwhile').replace('8000', `${port}, () => console.log('up')`),
  );
  const child = spawn(process.execPath, ['server.mjs'], { cwd: folder, stdio: ['ignore', 'pipe', 'inherit'] });
  t.after(() => child.kill());
  await new Promise((done, fail) => {
    child.stdout.once('data', done);
    child.once('exit', () => fail(new Error('the server ended')));
  });
  return (await fetch(`http://127.0.0.1:${port}/`)).json();
}

test('every block of the tasks is run by some test', () => {
  assert.deepEqual([...code.keys()].sort(), Object.values(TASKS).flat().sort());
});

test('the tasks for Node do what they say', async (t) => {
  const folder = await project(t);
  prints(folder, 'The motion between two pictures', /^the pixel at 100, 60 goes by -?\d+\.\d+, -?\d+\.\d+\n$/);
  prints(folder, 'Points followed through a clip', /^\d{3,} points, the first at [\d.]+, [\d.]+ in frame 0\n$/);
  const tracks = await fromTracksDat(readFileSync(join(folder, 'tracks.dat'), 'utf8'), SCENE);
  assert.equal(tracks.numFrames, 8);
  prints(
    folder,
    "Masks from trajectories of one's own",
    new RegExp(`^[1-9] objects, by ${tracks.count} trajectories\n$`),
  );
  prints(
    folder,
    'Where each object is, how large, how fast',
    /^(\d \d+ [\d.]+ [\d.]+ (-?[\d.e-]+|null) (-?[\d.e-]+|null)\n){8,}$/,
  );
  assert.match(readFileSync(join(folder, 'objects.csv'), 'utf8'), /^frame,time,object,.*\n0,0,1,/);
  prints(
    folder,
    'Why a pixel has its label, and how sure that is',
    /^label \d holds by [\d.]+: its costs are [\d.,]+\n\d+ pixels are worth a look\n$/,
  );
  prints(folder, 'Many single pictures', /^(\d+\n){8}$/);
  prints(folder, 'Uncompressed video from a stream', /^[1-9] objects\n$/);
});

test(
  'video files are decoded by ffmpeg, and a server answers',
  { skip: !hasFfmpeg && 'there is no ffmpeg' },
  async (t) => {
    const folder = await project(t);
    prints(folder, 'Video files in Node', /^8 frames to 0\.7 s, [1-9] objects\n$/);
    copyFileSync(join(folder, 'clip.mp4'), join(folder, 'other.mp4'));
    prints(folder, 'Several clips in one stream', /^clip\.mp4 ([1-9]) objects\nother\.mp4 \1 objects\n$/);
    const objects = await answerOf(t, folder);
    assert.ok(objects.length > 0 && objects.every(({ label, meanArea }) => label > 0 && meanArea > 0));
  },
);
