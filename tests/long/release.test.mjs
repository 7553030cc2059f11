// `npm run release -- --local` makes each part in `out`, and the printed commands install it; `npm pack` completes a package
// of which `npm start` has built only the page. Both work in a copy of the repository, as other tests use what is built here.

import assert from 'node:assert/strict';
import { execFileSync } from 'node:child_process';
import { cpSync, existsSync, mkdirSync, mkdtempSync, rmSync, symlinkSync, writeFileSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import { after, before, test } from 'node:test';
import { absentFrom, readManifest } from '../../scripts/pack.mjs';
import { PARTS } from '../../scripts/release.mjs';
import { findProgram, output, root } from '../../scripts/tools.mjs';

const copy = mkdtempSync(join(tmpdir(), 'tracecut-copy-'));
after(() => rmSync(copy, { recursive: true }));

/** Runs a command, and returns its output. */
const outputOf = (command, args, folder = copy) =>
  execFileSync(command, args, { cwd: folder, encoding: 'utf8', stdio: ['ignore', 'pipe', 'inherit'] });

const manifest = readManifest();
let printed;
before(() => {
  // Files keep their times: a lock file that is newer than node_modules would be installed.
  for (const name of [...output('git', ['ls-files']).split('\n'), 'dist'])
    cpSync(join(root, name), join(copy, name), { recursive: true, preserveTimestamps: true });
  for (const name of ['node_modules', 'target', '.tools']) symlinkSync(join(root, name), join(copy, name), 'dir');
  printed = outputOf(process.execPath, ['scripts/release.mjs', '--local', ...Object.keys(PARTS)]);
});

/** Returns the printed command that begins like this, as words. */
function commandOf(beginning) {
  const line = printed.split('\n').find((text) => text.trim().startsWith(beginning));
  assert.ok(line, `${beginning}: ${printed}`);
  return line.trim().split(' ');
}

function emptyFolder(t) {
  const folder = mkdtempSync(join(tmpdir(), 'tracecut-release-'));
  t.after(() => rmSync(folder, { recursive: true }));
  return folder;
}

test('the npm package', (t) => {
  const folder = emptyFolder(t);
  writeFileSync(join(folder, 'package.json'), '{"type": "module"}');
  const [npm, ...args] = commandOf('npm install');
  outputOf(npm, [...args, '--offline'], folder);
  const script = "import { version } from 'tracecut'; console.log(version);";
  assert.equal(outputOf(process.execPath, ['--input-type=module', '--eval', script], folder).trim(), manifest.version);
});

test('the wheel', (t) => {
  const folder = emptyFolder(t);
  outputOf(findProgram('python3', 'python'), ['-m', 'venv', folder]);
  const python = join(folder, process.platform === 'win32' ? 'Scripts/python.exe' : 'bin/python');
  const [, ...args] = commandOf('pip install');
  outputOf(python, ['-m', 'pip', '--quiet', ...args]);
  const script = 'import tracecut; print(tracecut.__version__)';
  assert.equal(outputOf(python, ['-c', script], folder).trim(), manifest.version);
});

test('the program', () => {
  assert.equal(outputOf(join(copy, 'out', 'tracecut'), ['--version']).trim(), `tracecut ${manifest.version}`);
});

test('the crate, in a new program', (t) => {
  const folder = emptyFolder(t);
  mkdirSync(join(folder, 'src'));
  writeFileSync(join(folder, 'src', 'main.rs'), 'fn main() {}\n');
  writeFileSync(join(folder, 'Cargo.toml'), '[package]\nname = "new-program"\nversion = "0.0.0"\nedition = "2024"\n');
  const [cargo, ...args] = commandOf('cargo add');
  outputOf(cargo, args, folder);
  assert.match(outputOf(cargo, ['tree', '--depth', '1', '--prefix', 'none'], folder), /^tracecut v/m);
});

test('the API reference', () => {
  assert.ok(existsSync(join(copy, 'out', 'docs', 'functions', 'index.segmentVideo.html')));
});

test('npm pack builds what a package lacks', () => {
  const isThere = (path) => existsSync(join(copy, path));
  // As after `npm start` in a new clone.
  for (const name of ['inline.js', 'worker.bundle.js', 'index.d.ts', 'stamps.json']) rmSync(join(copy, 'dist', name));
  assert.equal(absentFrom(manifest, isThere).length, 3);
  const [{ files }] = JSON.parse(outputOf('npm', ['pack', '--dry-run', '--json']));
  const paths = new Set(files.map(({ path }) => path));
  assert.deepEqual(
    absentFrom(manifest, (path) => paths.has(path)),
    [],
  );
});
