// The package as npm would publish it.

import assert from 'node:assert/strict';
import { spawnSync } from 'node:child_process';
import { mkdtempSync, readFileSync, readdirSync, rmSync } from 'node:fs';
import { createRequire } from 'node:module';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import { after, test } from 'node:test';
import { build as bundle } from 'esbuild';
import * as tracecut from 'tracecut';
import { LIBRARIES, LICENCES } from '../../scripts/licences.mjs';
import { packed } from '../../scripts/size.mjs';
import { root } from '../../scripts/tools.mjs';

const require = createRequire(import.meta.url);
const read = (name) => readFileSync(join(root, name), 'utf8');
const manifest = JSON.parse(read('package.json'));
const folder = mkdtempSync(join(tmpdir(), 'tracecut-package-'));
after(() => rmSync(folder, { recursive: true }));
const published = packed('--pack-destination', folder);
const tarball = join(folder, published.filename);

test('the versions of crate, package and built module are one', () => {
  assert.equal(/^version = "(.+)"$/m.exec(read('Cargo.toml'))[1], manifest.version);
  assert.equal(tracecut.version, manifest.version);
});

/** Projects that know other types: their settings, and which of the files in `types` they have. */
const PROJECTS = {
  browser: [
    '--target es2022 --module nodenext --lib es2023,esnext.disposable,dom --exactOptionalPropertyTypes',
    'types misuse',
  ],
  node: ['--target es2022 --module node16 --lib es2022 --types node --skipLibCheck', 'misuse use'],
  bare: ['--target es2020 --module esnext --moduleResolution bundler --lib es2020', 'misuse use'],
  webworker: ['--target es2022 --module esnext --moduleResolution bundler --lib es2022,webworker', 'misuse use'],
  dom: ['--target es2022 --module preserve --lib es2022,dom', 'misuse use use-dom'],
  exact: [
    '--target es2023 --module nodenext --lib es2023,esnext.disposable,dom,dom.iterable --types node --exactOptionalPropertyTypes ' +
      '--noUncheckedIndexedAccess --noPropertyAccessFromIndexSignature --verbatimModuleSyntax',
    'misuse use use-dom',
  ],
};

test('misuse fails to compile, and use compiles, whatever types a project knows', () => {
  const folder = join(root, 'tests', 'node', 'types');
  const misuse = readFileSync(join(folder, 'misuse.ts'), 'utf8').match(/@ts-expect-error/g);
  assert.ok(misuse.length >= 40, `${misuse.length} misuses`);
  for (const [project, [settings, names]] of Object.entries(PROJECTS)) {
    const files = names.split(' ').map((name) => join(folder, `${name}.ts`));
    const { status, stdout } = tool(
      'typescript/bin/tsc',
      '--strict',
      '--noEmit',
      '--skipDefaultLibCheck',
      ...settings.split(' '),
      ...files,
    );
    assert.equal(status, 0, `${project}: ${stdout}`);
  }
});

test('each entry exports the same in browsers and Node, by import and by require, and none a thenable', async () => {
  const allEntries = require('../../dist/node/all.cjs');
  for (const name of ['', 'draw', 'edit', 'export', 'stages']) {
    const [inNode, browser] = await Promise.all([
      import(`tracecut${name && `/${name}`}`),
      import(`../../dist/${name || 'index'}.js`),
    ]);
    const required = require(`../../dist/node/${name || 'index'}.cjs`);
    assert.deepEqual(Object.keys(inNode), Object.keys(browser));
    assert.deepEqual(Object.keys(required).sort(), Object.keys(browser));
    for (const [key, value] of Object.entries(required)) assert.equal(value, allEntries[key]);
    assert.ok(!('then' in inNode));
  }
});

test('no name is in two entries', async () => {
  const otherEntries = await Promise.all(
    ['draw', 'edit', 'export', 'stages'].map((name) => import(`tracecut/${name}`)),
  );
  const names = [tracecut, ...otherEntries].flatMap(Object.keys);
  assert.equal(new Set(names).size, names.length);
});

test('the tarball holds the built package and nothing else', () => {
  const sources = modules().flatMap((name) => [`dist/${name}`, `dist/${name.replace(/\.js$/, '.d.ts')}`]);
  const typed = ['glue', 'decoder', 'parameters', 'selftest/expected', 'inline'];
  const built = [
    ...typed.flatMap((name) => [`${name}.js`, `${name}.d.ts`]),
    ...['tracecut', 'decoder'].flatMap((name) => [`${name}_bg.wasm`, `${name}_bg.wasm.d.ts`]),
    ...['tracecut.d.ts', 'dom.d.ts', 'vendor/media.js', 'vendor/zip.js', 'worker.bundle.js', 'node/all.cjs'],
    ...['index', 'draw', 'edit', 'export', 'stages'].flatMap((name) => [`node/${name}.cjs`, `node/${name}.d.cts`]),
  ].map((name) => `dist/${name}`);
  const documents = ['CHANGELOG.md', 'LICENSE-APACHE', 'LICENSE-MIT', 'README.md', 'package.json'];
  // Only a release writes the licences.
  const shipped = published.files.map(({ path }) => path).filter((path) => path !== `dist/${LICENCES}`);
  assert.deepEqual(shipped.sort(), [...sources, ...built, ...documents].sort());
});

test('the licences list the libraries that the package holds', () => {
  const entries = ['media', 'zip'].flatMap((name) => [
    ...read(`scripts/vendor/${name}.js`).matchAll(/from '(?:.*\/node_modules\/)?(\w+)/g),
  ]);
  assert.deepEqual([...new Set(entries.map(([, name]) => name))].sort(), LIBRARIES);
});

test('importing the package touches nothing', () => {
  const script = `
    for (const name of ['fetch', 'Worker', 'document', 'navigator', 'addEventListener', 'WebAssembly']) {
      Object.defineProperty(globalThis, name, { get() { throw new Error(name + ' was read'); } });
    }
    const before = Reflect.ownKeys(globalThis).length;
    await import('./dist/index.js');
    if (Reflect.ownKeys(globalThis).length !== before) throw new Error('a global was added');
    console.log('quiet');`;
  const { stdout, stderr } = spawnSync(process.execPath, ['--input-type=module', '--eval', script], {
    cwd: root,
    encoding: 'utf8',
  });
  assert.equal(stdout, 'quiet\n', stderr);
});

test('bundlers may drop what is not used, but for the worker', async () => {
  assert.equal((await bundled("import { createSession } from 'tracecut';")).trim(), '');
  assert.match(await bundled("import 'tracecut/worker';"), /addEventListener/);
});

test('publint finds no fault', () => {
  const { status, stdout } = tool('publint/src/cli.js', 'run', tarball, '--strict');
  assert.equal(status, 0, stdout);
  assert.match(stdout, /All good!/);
});

// .attw.json has the flags. `esm-only`: there is no CommonJS build, and none is missing, since Node from 20.19 on can
// require() this one; the wasm files are no modules, so they have no types that every bundler would agree with.
test('attw finds no fault', () => {
  const { status, stdout } = tool('@arethetypeswrong/cli/dist/index.js', tarball, '--format', 'json');
  assert.equal(status, 0, stdout);
  const { analysis } = JSON.parse(stdout);
  assert.deepEqual(Object.keys(analysis.entrypoints), [
    '.',
    './draw',
    './edit',
    './export',
    './stages',
    './inline',
    './node',
    './worker',
    './aside-worker',
    './selftest',
    './package.json',
  ]);
});

/** The modules below npm, as they are below dist. */
function modules() {
  return readdirSync(join(root, 'npm'), { recursive: true })
    .filter((name) => /(?<!\.d)\.ts$/.test(name))
    .map((name) => name.replaceAll('\\', '/').replace(/\.ts$/, '.js'));
}

/** Bundles a module with these contents in a project that has installed the package. */
async function bundled(contents) {
  const { outputFiles } = await bundle({
    stdin: { contents, resolveDir: root },
    bundle: true,
    write: false,
    format: 'esm',
    logLevel: 'warning',
  });
  return outputFiles[0].text;
}

/** Runs a command line tool of node_modules by its script. */
function tool(script, ...args) {
  return spawnSync(process.execPath, [join(root, 'node_modules', script), ...args], { cwd: root, encoding: 'utf8' });
}
