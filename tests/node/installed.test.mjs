// The packed tarball, installed in an empty folder without network: the code of README, guide, tasks and example as it stands.

import assert from 'node:assert/strict';
import { execFileSync, spawn, spawnSync } from 'node:child_process';
import { copyFileSync, existsSync, mkdirSync, readdirSync, readFileSync, symlinkSync, writeFileSync } from 'node:fs';
import { join } from 'node:path';
import { test } from 'node:test';
import { fromTracksDat } from 'tracecut/stages';
import { outcome } from '../package/app/segment.js';
import { root } from '../../scripts/tools.mjs';
import { installed } from '../package/project.mjs';
import { freePort } from '../programs.mjs';
import { codeOf, readmeCode, readmePage, TASKS } from '../readme.mjs';
import { framesOf, png } from './support.mjs';

test('a project that installs the tarball segments a clip, and installs nothing else', async (t) => {
  const folder = installed(t, 'tests/package/app');
  assert.deepEqual(
    readdirSync(join(folder, 'node_modules')).filter((name) => !name.startsWith('.')),
    ['tracecut'],
  );
  assert.ok(!existsSync(join(folder, 'node_modules', 'tracecut', 'npm')));
  const script = "import { outcome } from './segment.js'; console.log(JSON.stringify(await outcome()));";
  const printed = execFileSync(process.execPath, ['--input-type=module', '--eval', script], {
    cwd: folder,
    encoding: 'utf8',
  });
  assert.deepEqual(JSON.parse(printed), await outcome());
});

test('a CommonJS project imports it, and the wasm files have names that resolve', (t) => {
  const folder = installed(t);
  const script = `
    import('tracecut').then(async ({ synthClip }) => {
      const wasm = require('node:fs').readFileSync(require.resolve('tracecut/tracecut.wasm'));
      const clip = await synthClip({ frames: 2, wasm });
      console.log(clip.numObjects, require.resolve('tracecut/decoder.wasm').endsWith('decoder_bg.wasm'));
    });`;
  const printed = execFileSync(process.execPath, ['--input-type=commonjs', '--eval', script], {
    cwd: folder,
    encoding: 'utf8',
  });
  assert.equal(printed, '3 true\n');
});

test('the Node example writes a palette PNG for each frame of a folder', async (t) => {
  const folder = installed(t, 'examples/node');
  const frames = await framesOf({ width: 256, height: 144, frames: 12, seed: 1 });
  mkdirSync(join(folder, 'frames'));
  // Names as cameras give them: 2 comes before 10.
  frames.forEach((frame, k) => writeFileSync(join(folder, 'frames', `frame${k}.png`), png(frame)));
  const usage = spawnSync(process.execPath, ['masks.mjs'], { cwd: folder, encoding: 'utf8' });
  assert.deepEqual([usage.status, usage.stderr], [2, 'Usage: node masks.mjs FRAMES MASKS\n']);
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

const code = readmeCode();
const SCENE = { width: 256, height: 144, frames: 8, seed: 1 };

/** Code before and after a block: names that it uses, and a line that prints its results. */
const AROUND = {
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

test('the blocks for Node work as described', async (t) => {
  const folder = installed(t);
  mkdirSync(join(folder, 'frames'));
  (await framesOf(SCENE)).forEach((frame, k) => writeFileSync(join(folder, 'frames', `${k}.png`), png(frame)));
  run(folder, 'In Node');
  assert.deepEqual(
    readdirSync(join(folder, 'masks')).sort(),
    [...'01234567'].map((name) => `${name}.png`),
  );
  // One program, as a reader who goes on writes it.
  const program = ['Sessions', 'Corrections', 'Edits by hand'].map((heading) => code.get(heading)).join('\n');
  writeFileSync(
    join(folder, 'main.mjs'),
    program.replace(
      'session.close();',
      'console.log(edit.paints[0].parts.size > 1, editor.undoable); session.close();',
    ),
  );
  const printed = execFileSync(process.execPath, ['main.mjs'], { cwd: folder, encoding: 'utf8' });
  assert.match(printed, /masks 1\n\d{3,} trajectories, [1-9] objects\ntrue 2\n$/);
  assert.equal(run(folder, 'Single images'), '9216 9216 9216 true true 9216 9216\n');
  assert.match(run(folder, 'Errors'), /^param clip\.maxSide = -1 \(expected /);
});

const taskCode = codeOf('docs/tasks.md');
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

/** Runs a block and checks what it prints. */
function prints(folder, heading, expected) {
  file(folder, 'main.mjs', taskCode.get(heading));
  const { status, stdout, stderr } = spawnSync(process.execPath, ['main.mjs'], { cwd: folder, encoding: 'utf8' });
  assert.equal(status, 0, `${heading}: ${stderr}`);
  assert.match(stdout, expected, heading);
}

async function answerOf(t, folder) {
  const port = await freePort();
  file(
    folder,
    'server.mjs',
    taskCode.get('A server that stays responsive').replace('8000', `${port}, () => console.log('up')`),
  );
  const child = spawn(process.execPath, ['server.mjs'], { cwd: folder, stdio: ['ignore', 'pipe', 'inherit'] });
  t.after(() => child.kill());
  await new Promise((done, fail) => {
    child.stdout.once('data', done);
    child.once('exit', () => fail(new Error('the server ended')));
  });
  return (await fetch(`http://127.0.0.1:${port}/`)).json();
}

test('the tasks for Node work as described', async (t) => {
  const folder = await project(t);
  prints(folder, 'The motion between two pictures', /^the pixel at 100, 60 moves by -?\d+\.\d+, -?\d+\.\d+\n$/);
  prints(folder, 'Points followed through a clip', /^\d{3,} points, the first at [\d.]+, [\d.]+ in frame 0\n$/);
  const tracks = await fromTracksDat(readFileSync(join(folder, 'tracks.dat'), 'utf8'), SCENE);
  assert.equal(tracks.numFrames, 8);
  prints(folder, 'Masks from your own tracker', new RegExp(`^[1-9] objects, from ${tracks.count} trajectories\n$`));
  prints(
    folder,
    'Where each object is, how large, how fast',
    /^(\d \d+ [\d.]+ [\d.]+ (-?[\d.e-]+|null) (-?[\d.e-]+|null)\n){8,}$/,
  );
  assert.match(readFileSync(join(folder, 'objects.csv'), 'utf8'), /^frame,time,object,.*\n0,0,1,/);
  prints(
    folder,
    'Why a pixel has its label',
    /^label \d wins by [\d.]+; the costs are [\d.,]+\n\d+ ranges of frames to check\n$/,
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

/** Names that blocks use without declaring them: the reader's file or image, and what the text has introduced. */
const FILE = 'declare const file: File;\n';
const NAMES = `${FILE}
import { encodeVideo, maskPng, masksZip, segmentVideo, videoFrames } from 'tracecut';
import { cocoRle, labelsNpy } from 'tracecut/export';
`;
const GRANTED = {
  Video: NAMES,
  'What comes out': NAMES,
  'Single images': 'declare const image: ImageData;\n',
  Errors: "import { createSession } from 'tracecut';\n",
  [TASKS.browser[0]]: FILE,
};

/** Blocks that continue each other, as one program. */
const PROGRAM = ['Sessions', 'Corrections', 'Edits by hand'];
/** The elements of the first page, which browsers give a script by their ids: a file was chosen, and the canvas has a context. */
const ELEMENTS = `
declare const input: HTMLInputElement & { files: FileList };
declare const canvas: { getContext(kind: '2d'): CanvasRenderingContext2D } & HTMLCanvasElement;
`;

/** The script of the first page, which imports the package from an address. */
function pageScript() {
  const [, script] = /<script type="module">\n([^]*?)<\/script>/.exec(readmePage());
  return `${ELEMENTS}${script.replace(/'https:[^']*inline.js'/, "'tracecut/inline'")}`;
}

/** Returns the code of all other documents; a block may name its file. */
function otherCode() {
  const documents = ['docs', 'examples', '.'].flatMap((folder) =>
    readdirSync(join(root, folder))
      .filter((name) => name.endsWith('.md'))
      .map((name) => join(folder, name)),
  );
  const named = ['README.md', 'docs/guide.md', 'docs/tasks.md'];
  return documents
    .filter((name) => !named.includes(name))
    .flatMap((name) => {
      const blocks = readFileSync(join(root, name), 'utf8').matchAll(
        /^( *)```(?:js|ts|mjs|cjs)\b *(\S*)\n([^]*?)^ *```$/gm,
      );
      return [...blocks].map(([, , file, source]) => ({ source, extension: file.endsWith('.cjs') ? 'cts' : 'ts' }));
    });
}

test('the blocks of all documents compile in strict mode', (t) => {
  const folder = installed(t);
  for (const tool of ['esbuild', '@types'])
    symlinkSync(join(root, 'node_modules', tool), join(folder, 'node_modules', tool));
  const blocks = [...code, ...taskCode].filter(([heading]) => !PROGRAM.includes(heading));
  const sources = blocks.map(([heading, source]) => ({
    source: `${GRANTED[heading] ?? ''}${source}`,
    extension: 'ts',
  }));
  sources.push({ source: PROGRAM.map((heading) => code.get(heading)).join('\n'), extension: 'ts' });
  sources.push({ source: pageScript(), extension: 'ts' });
  const others = otherCode();
  assert.ok(others.length > 5, others);
  const files = [...sources, ...others].map(({ source, extension }, k) => {
    file(folder, `block${k}.${extension}`, extension === 'ts' ? `${source}\nexport {};\n` : source);
    return `block${k}.${extension}`;
  });
  const settings =
    '--strict --noEmit --target es2022 --module nodenext --lib es2023,esnext.disposable,dom,dom.iterable --types node';
  const types = ['--typeRoots', join(root, 'node_modules', '@types')];
  const tsc = join(root, 'node_modules', 'typescript', 'bin', 'tsc');
  const { status, stdout, stderr } = spawnSync(process.execPath, [tsc, ...settings.split(' '), ...types, ...files], {
    cwd: folder,
    encoding: 'utf8',
  });
  assert.equal(status, 0, stdout || stderr);
});
