// The package as npm would publish it.

import assert from 'node:assert/strict';
import { execFileSync } from 'node:child_process';
import { readFileSync, readdirSync } from 'node:fs';
import { join } from 'node:path';
import { test } from 'node:test';
import * as tracecut from 'tracecut';
import { root } from '../../scripts/tools.mjs';

const read = (name) => readFileSync(join(root, name), 'utf8');
const manifest = JSON.parse(read('package.json'));

test('the versions of crate, package and built module are one', () => {
  assert.equal(/^version = "(.+)"$/m.exec(read('Cargo.toml'))[1], manifest.version);
  assert.equal(tracecut.version, manifest.version);
});

test('declarations compile in a project that uses them', () => {
  const tsc = join(root, 'node_modules', 'typescript', 'bin', 'tsc');
  try {
    execFileSync(process.execPath, [tsc, '--project', join(root, 'tests', 'node', 'tsconfig.json')], { encoding: 'utf8' });
  } catch (error) {
    assert.fail(`${error.stdout}${error.stderr}`);
  }
});

test('browser and Node entries export the same names, and none is a thenable', async () => {
  const browser = await import('../../dist/index.js');
  assert.deepEqual(Object.keys(browser).sort(), Object.keys(tracecut).sort());
  assert.ok(!Object.keys(tracecut).includes('then'));
});

test('the tarball holds the built package and nothing else', () => {
  const { files } = packed();
  const names = files.map(({ path }) => path);
  for (const needed of ['dist/index.js', 'dist/index.d.ts', 'dist/node.js', 'dist/worker.js', 'dist/tracecut.js', 'dist/tracecut_bg.wasm']) {
    assert.ok(names.includes(needed), `${needed} is missing of ${names}`);
  }
  const stray = names.filter((name) => !/^(dist\/[\w-]+\.(js|d\.ts)|dist\/(tracecut|decoder)_bg\.wasm(\.d\.ts)?|package\.json|[A-Z][\w.-]*)$/.test(name));
  assert.deepEqual(stray, []);
  assert.deepEqual(names.filter((name) => name.endsWith('.wasm')).sort(), ['dist/decoder_bg.wasm', 'dist/tracecut_bg.wasm']);
});

test('every module of the source is in the build, unchanged', () => {
  for (const name of readdirSync(join(root, 'www', 'lib')).filter((file) => file.endsWith('.js'))) {
    assert.equal(read(join('dist', name)), read(join('www', 'lib', name)), name);
  }
});

test('the lock file names no registry', () => {
  assert.doesNotMatch(read('package-lock.json'), /"resolved"/);
});

function packed() {
  const windows = process.platform === 'win32';
  const text = execFileSync('npm', ['pack', '--dry-run', '--json', '--ignore-scripts'], { cwd: root, encoding: 'utf8', shell: windows });
  const parsed = JSON.parse(text);
  return Array.isArray(parsed) ? parsed[0] : Object.values(parsed)[0];
}
