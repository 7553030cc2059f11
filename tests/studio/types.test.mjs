// Imports between folders of JavaScript, by the rules of .dependency-cruiser.cjs, and types of the studio and of the lab's
// comments, by the TypeScript compiler.

import assert from 'node:assert/strict';
import { spawnSync } from 'node:child_process';
import { join } from 'node:path';
import { test } from 'node:test';
import { root } from '../../scripts/tools.mjs';

test('package, studio, lab and scripts import only what the architecture allows', () => {
  const program = join(root, 'node_modules', 'dependency-cruiser', 'bin', 'dependency-cruise.mjs');
  const folders = ['dist', 'build', 'studio', 'www', 'scripts'];
  const { status, stdout } = spawnSync(process.execPath, [program, ...folders], { cwd: root, encoding: 'utf8' });
  assert.equal(status, 0, stdout);
  assert.match(stdout, /no dependency violations found \(\d{3} modules/);
});

for (const folder of ['studio', 'www'])
  test(`${folder} compiles`, () => {
    const compiler = join(root, 'node_modules', 'typescript', 'bin', 'tsc');
    const { status, stdout } = spawnSync(process.execPath, [compiler, '--project', `${folder}/tsconfig.json`], {
      cwd: root,
      encoding: 'utf8',
    });
    assert.equal(status, 0, stdout);
  });
