// The packed tarball, installed in an empty folder without network, in Node.

import assert from 'node:assert/strict';
import { execFileSync } from 'node:child_process';
import { existsSync, readdirSync } from 'node:fs';
import { join } from 'node:path';
import { test } from 'node:test';
import { outcome } from '../package/app/segment.js';
import { installed } from '../package/installed.mjs';

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
