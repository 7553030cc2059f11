// The recipe for esbuild, in every format, for pages and for Node; and what is said where nothing is set.

import assert from 'node:assert/strict';
import { cpSync, readFileSync, writeFileSync } from 'node:fs';
import { join } from 'node:path';
import { after, before, test } from 'node:test';
import * as esbuild from 'esbuild';
import { useServerAndBrowser } from '../site.mjs';
import { outcome } from './app/segment.js';
import { gives } from './browser-results.mjs';
import { served } from './installed.mjs';
import { MAIN, execute, project } from './project.mjs';

const site = useServerAndBrowser();
const cleaners = [];
const PLAIN = MAIN.replace(/^.*setup.*\n/, '');
const PRINT =
  "import { outcome } from './segment.js';\noutcome().then((found) => console.log(JSON.stringify(found)));\n";
const CLASSIC = `<!doctype html><meta charset="utf-8"><link rel="icon" href="data:,"><script src="./main.js"></script>`;
let expected;
let folder;

before(async () => {
  folder = await project(
    { after: (clean) => cleaners.push(clean) },
    { recipe: 'esbuild', files: { 'main.js': MAIN, 'plain.js': PLAIN, 'print.js': PRINT } },
  );
  expected = await outcome();
});
after(() => cleaners.forEach((clean) => clean()));

for (const format of ['esm', 'iife']) {
  test(`the recipe, as ${format}`, async (t) => {
    const script = join(folder, `build-${format}.mjs`);
    // The project has no esbuild of its own; this one's is named in full.
    const text = readFileSync(join(folder, 'build.js'), 'utf8');
    writeFileSync(script, text.replace("'esbuild'", JSON.stringify(import.meta.resolve('esbuild'))));
    await execute(folder, process.execPath, [script, format]);
    const out = join(folder, 'out');
    if (format === 'esm') cpSync(join(folder, 'index.html'), join(out, 'index.html'));
    else writeFileSync(join(out, 'index.html'), CLASSIC);
    await gives(t, site.browser, await served(t, out), expected, { files: 1 });
  });
}

test('everything inside one script that is no module', async (t) => {
  const out = await bundled('plain.js', {
    format: 'iife',
    outfile: 'inline/main.js',
    alias: { tracecut: 'tracecut/inline' },
  });
  writeFileSync(join(out, 'index.html'), CLASSIC);
  await gives(t, site.browser, await served(t, out), expected, { files: 1 });
});

for (const format of ['esm', 'cjs']) {
  for (const [how, settings] of [
    ['with the package outside', { external: ['tracecut'] }],
    ['with everything inside', { alias: { tracecut: 'tracecut/inline' } }],
  ]) {
    test(`for Node, as ${format}, ${how}`, async () => {
      const file = `node-${format}-${how.split(' ').at(-1)}/print.${format === 'esm' ? 'mjs' : 'cjs'}`;
      await bundled('print.js', { format, platform: 'node', outfile: file, ...settings });
      assert.deepEqual(JSON.parse(await execute(folder, process.execPath, [file])), expected);
    });
  }
  test(`for Node, as ${format}, where the wasm files were left behind, the error says how to name them`, async () => {
    const file = `lost-${format}/print.${format === 'esm' ? 'mjs' : 'cjs'}`;
    await bundled('print.js', { format, platform: 'node', outfile: file });
    await assert.rejects(execute(folder, process.execPath, [file]), (error) => {
      assert.match(error.message, /code: 'wasm-load'/);
      assert.match(error.message, /external: \['tracecut'\]/);
      assert.match(error.message, /configure\(\{ wasm: 'path\/of\/tracecut_bg\.wasm' \}\)/);
      return true;
    });
  });
}

test('a page whose script lost the files gets typed errors that say what to write', async (t) => {
  const lines = {
    'lost.js': `import * as tracecut from 'tracecut';
      globalThis.kit = tracecut;
      globalThis.said = (options) => tracecut.createSession(options).then(() => 'none', ({ code, message }) => [code, message]);`,
  };
  for (const [name, text] of Object.entries(lines)) writeFileSync(join(folder, name), text);
  const out = await bundled('lost.js', { format: 'iife', outfile: 'lost/main.js' });
  writeFileSync(join(out, 'index.html'), CLASSIC);
  for (const name of ['tracecut_bg.wasm', 'decoder_bg.wasm'])
    cpSync(join(folder, 'node_modules', 'tracecut', 'dist', name), join(out, name));
  const page = await site.browser.newPage();
  t.after(() => page.close());
  await page.goto(await served(t, out));
  const said = async (options) => page.evaluate((given) => globalThis.said(given), options);
  const [code, message] = await said();
  assert.equal(code, 'wasm-load');
  assert.match(message, /configure\(\{ wasm: '\/tracecut_bg\.wasm' \}\).*tracecut\/inline/);
  const [workerCode, words] = await said({ wasm: './tracecut_bg.wasm' });
  assert.equal(workerCode, 'wasm-load');
  assert.match(words, /configure\(\{ worker: '\/worker\.bundle\.js' \}\)/);
  const [missing, lost] = await said({ wasm: './tracecut_bg.wasm', worker: './nowhere.js' });
  assert.equal(missing, 'wasm-load');
  assert.match(lost, /the worker could not be started.*configure\(\{ worker: /);
  assert.equal(await said({ wasm: './tracecut_bg.wasm', worker: false }), 'none');
  const decoder = await page.evaluate(async () => {
    const session = await globalThis.kit.createSession({ wasm: './tracecut_bg.wasm', worker: false });
    return session.push(new Uint8Array([137, 80, 78, 71])).catch(({ code: which, message: text }) => [which, text]);
  });
  assert.equal(decoder[0], 'wasm-load');
  assert.match(decoder[1], /configure\(\{ decoder: '\/decoder_bg\.wasm' \}\)/);
});

/** Bundles a file of the project; gives the folder that it is in. */
async function bundled(entry, { outfile, ...settings }) {
  await esbuild.build({
    absWorkingDir: folder,
    entryPoints: [entry],
    bundle: true,
    outfile,
    logLevel: 'error',
    ...settings,
  });
  return join(folder, outfile, '..');
}
