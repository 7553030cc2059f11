// The recipe of Node in several versions, each with what Node of this project finds.

import assert from 'node:assert/strict';
import { readFileSync, writeFileSync } from 'node:fs';
import { join } from 'node:path';
import { before, test } from 'node:test';
import { outcome } from '../package/app/segment.js';
import { execute, nodeOf, project, recipe } from '../package/project.mjs';

let expected;
before(async () => {
  expected = await outcome();
});

const PRINT = "import { outcome } from './segment.js';\nconsole.log(JSON.stringify(await outcome()));\n";
const asCommonJs = (text) =>
  text.replace(/import \{(.*?)\} from '(.*?)';/gs, "const {$1} = require('$2');").replaceAll('export ', '');

for (const version of ['18.20.8', '20.19.5', '22.21.1', '24.11.1']) {
  test(`Node ${version}, as modules and as CommonJS`, async (t) => {
    const node = await nodeOf(t, version);
    const folder = await project(t, { recipe: 'node', files: { 'print.mjs': PRINT } });
    assert.equal(await execute(folder, node, ['--version']), `v${version}\n`);
    for (const file of recipe('node').keys()) assert.equal(await execute(folder, node, [file]), '3\n', file);
    const text = asCommonJs(readFileSync(join(folder, 'segment.js'), 'utf8'));
    const print = 'outcome().then((found) => console.log(JSON.stringify(found)));';
    writeFileSync(join(folder, 'segment.cjs'), `${text}\n${print}`);
    for (const file of ['print.mjs', 'segment.cjs'])
      assert.deepEqual(JSON.parse(await execute(folder, node, [file])), expected, file);
  });
}
