// The types of the page, and those in the comments of the lab, by the TypeScript compiler.

import assert from 'node:assert/strict';
import { spawnSync } from 'node:child_process';
import { test } from 'node:test';
import { join } from 'node:path';
import { root } from '../../scripts/tools.mjs';

for (const folder of ['studio', 'www'])
  test(`the types of ${folder} agree`, () => {
    const compiler = join(root, 'node_modules', 'typescript', 'bin', 'tsc');
    const { status, stdout } = spawnSync(process.execPath, [compiler, '--project', `${folder}/tsconfig.json`], {
      cwd: root,
      encoding: 'utf8',
    });
    assert.equal(status, 0, stdout);
  });
