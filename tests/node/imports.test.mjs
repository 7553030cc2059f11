// The import rules of ARCHITECTURE.md, checked by dependency-cruiser.

import assert from 'node:assert/strict';
import { execFile } from 'node:child_process';
import { test } from 'node:test';
import { promisify } from 'node:util';
import { root } from '../../scripts/tools.mjs';

test('package, studio, lab and scripts import only what the architecture allows', async () => {
  const cruiser = 'node_modules/dependency-cruiser/bin/dependency-cruise.mjs';
  const folders = ['dist', 'build', 'studio', 'www', 'scripts'];
  const { stdout } = await promisify(execFile)(process.execPath, [cruiser, ...folders], { cwd: root });
  assert.match(stdout, /no dependency violations found \(\d{3} modules/);
});
