// Bundles of esbuild for Node: with the package outside, with everything inside, and without its wasm files.

import assert from 'node:assert/strict';
import { after, before, test } from 'node:test';
import * as esbuild from 'esbuild';
import { outcome } from '../package/app/segment.js';
import { execute, project } from '../package/project.mjs';

const PRINT =
  "import { outcome } from './segment.js';\noutcome().then((results) => console.log(JSON.stringify(results)));\n";
const cleanups = [];
let folder, expected;
before(async () => {
  expected = await outcome();
  folder = await project({ after: (clean) => cleanups.push(clean) }, { files: { 'print.js': PRINT } });
});
after(() => cleanups.forEach((clean) => clean()));

/** Bundles the application and returns what it prints. */
async function runBundle(format, settings) {
  const outfile = `bundle.${format === 'esm' ? 'mjs' : 'cjs'}`;
  await esbuild.build({
    ...{ absWorkingDir: folder, entryPoints: ['print.js'], bundle: true, platform: 'node', logLevel: 'error' },
    ...{ format, outfile, ...settings },
  });
  return execute(folder, process.execPath, [outfile]);
}

for (const [name, format, settings] of [
  ['the package outside', 'esm', { external: ['tracecut'] }],
  ['everything inside', 'cjs', { alias: { tracecut: 'tracecut/inline' } }],
])
  test(`a bundle with ${name}, as ${format}, gives the same results`, async () => {
    assert.deepEqual(JSON.parse(await runBundle(format, settings)), expected);
  });

for (const format of ['esm', 'cjs'])
  test(`a bundle without the wasm files, as ${format}, has an error that says how to name them`, async () => {
    await assert.rejects(runBundle(format, {}), ({ message }) => {
      assert.match(message, /code: 'wasm-load'/);
      assert.match(message, /external: \['tracecut'\]/);
      assert.match(message, /configure\(\{ wasm: 'path\/of\/tracecut_bg\.wasm' \}\)/);
      return true;
    });
  });
