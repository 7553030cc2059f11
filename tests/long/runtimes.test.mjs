// The recipes of runtimes and of test runners, each with what Node of this project finds.

import assert from 'node:assert/strict';
import { cpSync, readFileSync, writeFileSync } from 'node:fs';
import { join } from 'node:path';
import { before, test } from 'node:test';
import { outcome } from '../package/app/segment.js';
import { execute, nodeOf, project, recipe, tool } from '../package/project.mjs';

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

test('Bun, as it is, bundled with the package outside, and with everything inside', async (t) => {
  const folder = await project(t, { tools: { bun: '1.4.5' }, files: { 'print.js': PRINT } });
  const bun = join(folder, 'node_modules', 'bun', 'bin', 'bun.exe');
  const prints = async (program, file) =>
    assert.deepEqual(JSON.parse(await execute(folder, program, [file])), expected);
  await prints(bun, 'print.js');
  await execute(folder, bun, ['build', 'print.js', '--target=node', '--external', 'tracecut', '--outdir', 'out']);
  await prints(process.execPath, 'out/print.js');
  writeFileSync(
    join(folder, 'segment.js'),
    readFileSync(join(folder, 'segment.js'), 'utf8').replace("'tracecut'", "'tracecut/inline'"),
  );
  await prints(bun, 'print.js');
  await execute(folder, bun, ['build', 'print.js', '--target=node', '--outdir', 'inside']);
  await prints(process.execPath, 'inside/print.js');
});

test('Deno, with the rights that the recipe names', async (t) => {
  const folder = await project(t, { tools: { deno: '2.9.6' }, files: { 'print.js': PRINT } });
  // What the package's own script would link when it is installed.
  const [name] = Object.keys(
    JSON.parse(readFileSync(join(folder, 'node_modules/deno/package.json'), 'utf8')).optionalDependencies,
  )
    .filter((each) => each.includes(`${process.platform}-${process.arch}`))
    .filter((each) => !each.includes('musl'));
  const deno = join(folder, 'node_modules', name, process.platform === 'win32' ? 'deno.exe' : 'deno');
  const rights = ['--allow-read', '--allow-env', '--allow-sys'];
  assert.deepEqual(JSON.parse(await execute(folder, deno, ['run', ...rights, 'print.js'])), expected);
});

const TESTED = `
test('the package', async () => {
  expect(await outcome()).toEqual(EXPECTED);
});
`;

test('Jest, in the environments node and jsdom', async (t) => {
  const folder = await project(t, {
    tools: { jest: '30.5.2', 'jest-environment-jsdom': '30.5.2' },
    recipe: 'jest',
    manifest: { type: 'commonjs' },
  });
  const text = asCommonJs(readFileSync(join(folder, 'segment.js'), 'utf8'));
  writeFileSync(join(folder, 'all.test.js'), text + TESTED.replace('EXPECTED', JSON.stringify(expected)));
  for (const environment of ['node', 'jsdom']) await tool(folder, 'jest', '--env', environment, '--ci');
});

test('Vitest, in the environments node and jsdom', async (t) => {
  const folder = await project(t, { tools: { vitest: '4.1.12', jsdom: '27.3.0' }, recipe: 'vitest' });
  const head = "import { expect, test } from 'vitest';\nimport { outcome } from './segment.js';\n";
  writeFileSync(join(folder, 'all.test.js'), head + TESTED.replace('EXPECTED', JSON.stringify(expected)));
  for (const environment of ['node', 'jsdom']) await tool(folder, 'vitest', 'run', '--environment', environment);
});

test('workerd, from its first modules on', async (t) => {
  const folder = await project(t, {
    tools: { miniflare: '4.20260730.0' },
    recipe: 'workerd',
    files: {
      'worker.js': `import './setup.js';
        import { outcome } from './segment.js';
        export default { fetch: async () => Response.json(await outcome()) };`,
      'run.mjs': `import { Miniflare } from 'miniflare';
        const rules = [{ type: 'ESModule', include: ['**/*.js'] }, { type: 'CompiledWasm', include: ['**/*.wasm'] }];
        for (const compatibilityDate of ['2022-10-31', '2024-09-01', '2026-04-01']) {
          const flare = new Miniflare({ modules: true, modulesRules: rules, scriptPath: 'out/worker.js', compatibilityDate });
          const answer = await flare.dispatchFetch('http://localhost/');
          console.log(JSON.stringify({ compatibilityDate, found: await answer.json() }));
          await flare.dispose();
        }`,
    },
  });
  // What wrangler does: bundled by esbuild, the wasm files as modules beside the script.
  const { build } = await import('esbuild');
  const files = new Set();
  await build({
    absWorkingDir: folder,
    entryPoints: ['worker.js'],
    outfile: 'out/worker.js',
    bundle: true,
    format: 'esm',
    conditions: ['workerd', 'worker', 'browser'],
    plugins: [wasmModules(files)],
    logLevel: 'error',
  });
  for (const file of files) cpSync(join(folder, 'node_modules/tracecut/dist', file), join(folder, 'out', file));
  assert.equal(files.size, 2);
  const lines = (await execute(folder, process.execPath, ['run.mjs']))
    .trim()
    .split('\n')
    .map((line) => JSON.parse(line));
  assert.equal(lines.length, 3);
  for (const { compatibilityDate, found } of lines) assert.deepEqual(found, expected, compatibilityDate);
});

/** The package's wasm files as modules that stay outside; their names go into `wanted`. */
function wasmModules(wanted) {
  return {
    name: 'wasm-modules',
    setup(build) {
      build.onResolve({ filter: /\.wasm$/ }, ({ path }) => {
        const file = path === 'tracecut/tracecut.wasm' ? 'tracecut_bg.wasm' : 'decoder_bg.wasm';
        wanted.add(file);
        return { path: `./${file}`, external: true };
      });
    },
  };
}
