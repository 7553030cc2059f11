// Types of the studio and of the lab's comments, by the TypeScript compiler.

import assert from 'node:assert/strict';
import { spawnSync } from 'node:child_process';
import { test } from 'node:test';
import { join } from 'node:path';
import { root } from '../../scripts/tools.mjs';

for (const folder of ['studio', 'www'])
  test(`${folder} compiles`, () => {
    const compiler = join(root, 'node_modules', 'typescript', 'bin', 'tsc');
    const { status, stdout } = spawnSync(process.execPath, [compiler, '--project', `${folder}/tsconfig.json`], {
      cwd: root,
      encoding: 'utf8',
    });
    assert.equal(status, 0, stdout);
  });
