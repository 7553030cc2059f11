// The packed tarball, installed in an empty folder without network: the code of README, guide, tasks and example as it stands, and
// bundles of esbuild for Node.

import assert from 'node:assert/strict';
import { execFileSync, spawn, spawnSync } from 'node:child_process';
import { copyFileSync, existsSync, mkdirSync, readdirSync, readFileSync, symlinkSync, writeFileSync } from 'node:fs';
import { join } from 'node:path';
import { test } from 'node:test';
import * as esbuild from 'esbuild';
import { fromTracksDat } from 'tracecut/stages';
import { root } from '../../scripts/tools.mjs';
import { outcome } from '../package/app/segment.js';
import { freePort, installed } from '../package/project.mjs';
import { codeOf, readmeCode, readmePage, TASKS } from '../readme.mjs';
import { framesOf, png } from './support.mjs';

/** Runs Node in a folder. */
const runNode = (folder, ...args) => spawnSync(process.execPath, args, { cwd: folder, encoding: 'utf8' });

const write = (folder, name, bytes) => writeFileSync(join(folder, name), bytes);

/** Runs programs one after the other in one process, and returns what each prints. @param {Map<string, string>} programs */
function runPrograms(folder, programs) {
  const names = [...programs.keys()];
  names.forEach((name, k) => write(folder, `program${k}.mjs`, programs.get(name)));
  const end = '--- end of a program ---\n';
  const lines = names.map(
    (_, k) => `await import('./program${k}.mjs');\nprocess.stdout.write(${JSON.stringify(end)});\n`,
  );
  write(folder, 'main.mjs', lines.join(''));
  const { status, stdout, stderr } = runNode(folder, 'main.mjs');
  const outputs = stdout.split(end);
  assert.equal(status, 0, `${names[outputs.length - 1]}: ${stderr}`);
  return new Map(names.map((name, k) => [name, outputs[k]]));
}

/** The application's results, by the installed package and by bundles of esbuild; a failure is its code and message. */
const COMPARE = `
import { createRequire } from 'node:module';
import { outcome } from './segment.js';
const require = createRequire(import.meta.url);
const runs = [
  outcome,
  async () => (await import('./external.mjs')).outcome(),
  async () => require('./inline.cjs').outcome(),
  async () => (await import('./broken.mjs')).outcome(),
  async () => require('./broken.cjs').outcome(),
];
const results = [];
for (const run of runs) results.push(await run().catch(({ code, message }) => ({ code, message })));
console.log(JSON.stringify(results));
`;

test('a project that installs the tarball segments a clip, as do its bundles; one without wasm files says how to name them', async (t) => {
  const folder = installed(t, 'tests/package/app');
  assert.deepEqual(
    readdirSync(join(folder, 'node_modules')).filter((name) => !name.startsWith('.')),
    ['tracecut'],
  );
  assert.ok(!existsSync(join(folder, 'node_modules', 'tracecut', 'npm')));
  for (const [outfile, settings] of Object.entries({
    'external.mjs': { external: ['tracecut'] },
    'inline.cjs': { alias: { tracecut: 'tracecut/inline' } },
    'broken.mjs': {},
    'broken.cjs': {},
  }))
    await esbuild.build({
      ...{ absWorkingDir: folder, entryPoints: ['segment.js'], bundle: true, platform: 'node', logLevel: 'error' },
      ...{ format: outfile.endsWith('.mjs') ? 'esm' : 'cjs', outfile, ...settings },
    });
  write(folder, 'compare.mjs', COMPARE);
  const { stdout, stderr } = runNode(folder, 'compare.mjs');
  assert.ok(stdout, stderr);
  const results = JSON.parse(stdout);
  assert.deepEqual(results.slice(0, 3), Array(3).fill(await outcome()));
  for (const { code, message } of results.slice(3)) {
    assert.equal(code, 'wasm-load', message);
    assert.match(message, /external: \['tracecut'\]/);
    assert.match(message, /configure\(\{ wasm: 'path\/of\/tracecut_bg\.wasm' \}\)/);
  }
});

test('a CommonJS project imports it, and the wasm files have names that resolve', (t) => {
  const script = `
    import('tracecut').then(async ({ synthClip }) => {
      const wasm = require('node:fs').readFileSync(require.resolve('tracecut/tracecut.wasm'));
      const clip = await synthClip({ frames: 2, wasm });
      console.log(clip.numObjects, require.resolve('tracecut/decoder.wasm').endsWith('decoder_bg.wasm'));
    });`;
  const { stdout, stderr } = runNode(installed(t), '--input-type=commonjs', '--eval', script);
  assert.equal(stdout, '3 true\n', stderr);
});

test('the Node example writes a palette PNG for each frame of a folder', async (t) => {
  const folder = installed(t, 'examples/node');
  const frames = await framesOf({ width: 128, height: 72, frames: 12, seed: 1 });
  mkdirSync(join(folder, 'frames'));
  // Names as cameras give them: 2 comes before 10.
  frames.forEach((frame, k) => write(folder, join('frames', `frame${k}.png`), png(frame)));
  const usage = runNode(folder, 'masks.mjs');
  assert.deepEqual([usage.status, usage.stderr], [2, 'Usage: node masks.mjs FRAMES MASKS\n']);
  const { status, stdout, stderr } = runNode(folder, 'masks.mjs', 'frames', 'masks');
  assert.equal(status, 0, stderr);
  assert.match(stdout, /12 of 12 frames, [1-9] objects/);
  assert.deepEqual(readdirSync(join(folder, 'masks')).sort(), frames.map((_, k) => `frame${k}.png`).sort());
  const file = readFileSync(join(folder, 'masks', 'frame11.png'));
  assert.deepEqual(
    [file.readUInt32BE(16), file.readUInt32BE(20), file[25]],
    [128, 72, 3],
    'width, height, indexed colour',
  );
});

const code = readmeCode();
const taskCode = codeOf('docs/tasks.md');
const SCENE = { width: 256, height: 144, frames: 8, seed: 1 };
const hasFfmpeg = spawnSync('ffmpeg', ['-version']).status === 0;

/** Blocks that continue each other, as one program. */
const PROGRAM = ['Sessions', 'Corrections', 'Edits by hand'];

/** The blocks for Node as programs, with names that they use, and a line that prints their results. */
const GUIDE_PROGRAMS = {
  'In Node': code.get('In Node'),
  Sessions: PROGRAM.map((heading) => code.get(heading))
    .join('\n')
    .replace('session.close();', 'console.log(edit.paints[0].parts.size > 1, editor.undoable); session.close();'),
  'Single images': `
    import { synthClip } from 'tracecut';
    const image = (await synthClip({ width: 128, height: 72 })).frame(0);
    ${code.get('Single images')}
    console.log(pb.length, thin.length, label.length, count > 20, borders.a.length > 20, discontinuity.length, combined.length);`,
  Errors: `import { createSession } from 'tracecut';\n${code.get('Errors')}`,
};

/** What each program prints. */
const OUTPUTS = {
  'In Node': /^$/,
  Sessions: /masks 1\n\d{3,} trajectories, [1-9] objects\ntrue 2\n$/,
  'Single images': /^9216 9216 9216 true true 9216 9216\n$/,
  Errors: /^param clip\.maxSide = -1 \(expected /,
  'The motion between two pictures': /^the pixel at 100, 60 moves by -?\d+\.\d+, -?\d+\.\d+\n$/,
  'Points followed through a clip': /^\d{3,} points, the first at [\d.]+, [\d.]+ in frame 0\n$/,
  'Masks from your own tracker': /^[1-9] objects, from \d{3,} trajectories\n$/,
  'Where each object is, how large, how fast': /^(\d \d+ [\d.]+ [\d.]+ (-?[\d.e-]+|null) (-?[\d.e-]+|null)\n){8,}$/,
  'Why a pixel has its label': /^label \d wins by [\d.]+; the costs are [\d.,]+\n\d+ ranges of frames to check\n$/,
  'Many single pictures': /^(\d+\n){8}$/,
  'Uncompressed video from a stream': /^[1-9] objects\n$/,
};
const VIDEO_OUTPUTS = {
  'Video files in Node': /^8 frames to 0\.7 s, [1-9] objects\n$/,
  'Several clips in one stream': /^clip\.mp4 ([1-9]) objects\nother\.mp4 \1 objects\n$/,
};

/** A project with the package, and with the files that the blocks read. */
async function createProject(t) {
  const folder = installed(t);
  const frames = await framesOf(SCENE);
  mkdirSync(join(folder, 'frames'));
  frames.forEach((frame, k) => write(folder, join('frames', `${k}.png`), png(frame)));
  const rgb = Buffer.concat(frames.map(({ data }) => Buffer.from(data.filter((_, k) => k % 4 < 3))));
  write(folder, 'clip.rgb', rgb);
  if (hasFfmpeg) {
    const size = `${SCENE.width}x${SCENE.height}`;
    const raw = `-f rawvideo -pix_fmt rgb24 -s ${size} -r 10 -i clip.rgb`.split(' ');
    execFileSync('ffmpeg', ['-loglevel', 'error', ...raw, '-c:v', 'mpeg4', '-q:v', '2', 'clip.mp4'], { cwd: folder });
    copyFileSync(join(folder, 'clip.mp4'), join(folder, 'other.mp4'));
  }
  return folder;
}

test('the blocks of the guide and the tasks for Node work as described', async (t) => {
  const folder = await createProject(t);
  const expected = { ...OUTPUTS, ...(hasFfmpeg ? VIDEO_OUTPUTS : {}) };
  const programs = Object.keys(expected).map((heading) => [heading, GUIDE_PROGRAMS[heading] ?? taskCode.get(heading)]);
  const outputs = runPrograms(folder, new Map(programs));
  for (const [heading, pattern] of Object.entries(expected)) assert.match(outputs.get(heading), pattern, heading);
  assert.deepEqual(
    readdirSync(join(folder, 'masks')).sort(),
    [...'01234567'].map((name) => `${name}.png`),
  );
  const tracks = await fromTracksDat(readFileSync(join(folder, 'tracks.dat'), 'utf8'), SCENE);
  assert.equal(tracks.numFrames, 8);
  assert.match(outputs.get('Masks from your own tracker'), new RegExp(` ${tracks.count} trajectories`));
  assert.match(readFileSync(join(folder, 'objects.csv'), 'utf8'), /^frame,time,object,.*\n0,0,1,/);
});

test('the server of the tasks answers', { skip: !hasFfmpeg && 'there is no ffmpeg' }, async (t) => {
  const folder = await createProject(t);
  const port = await freePort();
  const source = taskCode.get('A server that stays responsive').replace('8000', `${port}, () => console.log('up')`);
  write(folder, 'server.mjs', source);
  const child = spawn(process.execPath, ['server.mjs'], { cwd: folder, stdio: ['ignore', 'pipe', 'inherit'] });
  t.after(() => child.kill());
  await new Promise((resolve, reject) => {
    child.stdout.once('data', resolve);
    child.once('exit', () => reject(new Error('the server ended')));
  });
  const objects = await (await fetch(`http://127.0.0.1:${port}/`)).json();
  assert.ok(objects.length > 0 && objects.every(({ label, meanArea }) => label > 0 && meanArea > 0));
});

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
  const otherBlocks = otherCode();
  assert.ok(otherBlocks.length > 5, otherBlocks);
  const files = [...sources, ...otherBlocks].map(({ source, extension }, k) => {
    write(folder, `block${k}.${extension}`, extension === 'ts' ? `${source}\nexport {};\n` : source);
    return `block${k}.${extension}`;
  });
  const settings =
    '--strict --noEmit --skipDefaultLibCheck --target es2022 --module nodenext --lib es2023,esnext.disposable,dom,dom.iterable --types node';
  const types = ['--typeRoots', join(root, 'node_modules', '@types')];
  const tsc = join(root, 'node_modules', 'typescript', 'bin', 'tsc');
  const { status, stdout, stderr } = runNode(folder, tsc, ...settings.split(' '), ...types, ...files);
  assert.equal(status, 0, stdout || stderr);
});
