// Builds the npm package into dist/: Rust to wasm, its JavaScript glue, optimisation, the modules of `npm` and their
// types; and the page into build/. Steps whose inputs have not changed are skipped. `node scripts/build.mjs --force` takes them all, `--fast`
// leaves the wasm files unoptimised, for `npm start` and the tests.

import { createHash } from 'node:crypto';
import { copyFileSync, existsSync, mkdirSync, readFileSync, readdirSync, rmSync, writeFileSync } from 'node:fs';
import { homedir } from 'node:os';
import { basename, dirname, join } from 'node:path';
import { pathToFileURL } from 'node:url';
import { gzipSync } from 'node:zlib';
import { BUNDLE_SOURCES, buildBundles } from './bundles.mjs';
import { compilePackage, compilePage, finishDeclarations } from './compile.mjs';
import { parameterSources, writeParameters } from './parameters.mjs';
import { MOST_WASM } from './size.mjs';
import {
  during,
  ensureNodeModules,
  ensureOwnTool,
  ensureRust,
  fail,
  ownToolSource,
  root,
  run,
  runBeside,
} from './tools.mjs';

const WASM = 'wasm32-unknown-unknown';
const dist = join(root, 'dist');
const lib = join(root, 'npm');
const bin = (name) => join(root, 'node_modules', name);
// What rustc emits for wasm32 today, spelt out because wasm-opt accepts no more than it is told; never relaxed SIMD,
// which Safari and Node 20 refuse.
const wasmFeatures = [
  'bulk-memory',
  'nontrapping-float-to-int',
  'sign-ext',
  'mutable-globals',
  'reference-types',
  'multivalue',
  'simd',
].map((feature) => `--enable-${feature}`);

/** How the wasm files are made. */
const KINDS = {
  release: { profile: 'wasm', optimise: true },
  fast: { profile: 'wasm-fast', optimise: false },
};

/**
 * Builds everything that is out of date. An optimised wasm file over its budget ends the script. With `fast` the wasm files are
 * not optimised: larger, with the same results. With `onlyPage` only what the demo page loads: no declarations and no builds in one file.
 */
export async function build({ force = false, fast = false, onlyPage = false } = {}) {
  ensureRust();
  const installation = ensureNodeModules();
  mkdirSync(dist, { recursive: true });
  const stamps = readStamps(force);

  const scripts = ['build', 'compile', 'parameters'].map((name) => join(root, 'scripts', `${name}.mjs`));
  const making = [...scripts, ownToolSource('bindgen')];
  const vendored = ['media', 'zip'].map((name) => join(root, 'scripts', 'vendor', `${name}.js`));
  const lock = join(root, 'package-lock.json');
  const kind = fast ? 'fast' : 'release';
  const { profile } = KINDS[kind];
  const decoder = wasmFile('tracecut_decoder', profile);
  const engine = wasmFile('tracecut_engine', profile);
  fetchCrates();
  await Promise.all([
    installation,
    during('making the tool for the glue', 40, () => ensureOwnTool('bindgen')),
    during('compiling the library and what it needs', 60, () => compileCrates(kind)),
  ]);
  await Promise.all([
    step(stamps, 'wasm', [engine, lock, ...making], async () => {
      await buildWasm(engine, 'tracecut', kind);
      await buildGlue();
    }),
    step(stamps, 'decoder', [decoder, lock, ...making], async () => {
      await buildWasm(decoder, 'decoder', kind);
      editDecoder();
    }),
  ]);
  await step(stamps, 'parameters', [engine, ...parameterSources(), ...scripts], () => writeParameters(dist));
  await step(stamps, 'vendor', [...vendored, lock, ...scripts], () => Promise.all(vendored.map(buildVendored)));
  writeExpected();
  const sources = libraryFiles().map((name) => join(lib, name));
  removeStale();
  await compilePackage();
  await compilePage();
  if (!onlyPage) {
    // With the wasm files, whose declarations it goes on with.
    const declared = [engine, decoder, ...['parameters.js', 'selftest/expected.js'].map((name) => join(dist, name))];
    await step(stamps, 'types', [...sources, ...declared, lock, ...scripts], buildTypes);
    const bundled = [
      'tracecut_bg.wasm',
      'decoder_bg.wasm',
      'parameters.js',
      'glue.js',
      'decoder.js',
      'vendor/media.js',
      'vendor/zip.js',
    ];
    const parts = [...bundled.map((name) => join(dist, name)), ...BUNDLE_SOURCES, join(root, 'scripts', 'bundles.mjs')];
    await step(stamps, 'bundles', [...sources, ...parts, lock, ...scripts], buildBundles);
  }
  writeFileSync(join(dist, 'stamps.json'), JSON.stringify(stamps, null, 2));
  if (!fast) checkSize();
}

/** Runs `make` unless the contents of `inputs` are the same as last time. */
async function step(stamps, name, inputs, make) {
  const hash = createHash('sha256');
  for (const input of inputs) hash.update(readFileSync(input));
  const digest = hash.digest('hex');
  if (stamps[name] === digest) {
    console.log(`${name}: up to date`);
    return;
  }
  delete stamps[name];
  const begun = Date.now();
  await make();
  stamps[name] = digest;
  console.log(`${name}: made in ${((Date.now() - begun) / 1000).toFixed(1)} s`);
}

function readStamps(force) {
  const file = join(dist, 'stamps.json');
  if (force || !existsSync(file)) return {};
  const stamps = JSON.parse(readFileSync(file, 'utf8'));
  rmSync(file); // A build that fails halfway leaves none.
  return stamps;
}

/**
 * Compiles the engine and what reads files to wasm. In optimised builds, messages name a crate's files from its name on, so that the bytes are
 * the same anywhere; others share what `wasm-pack test` compiles.
 */
function compileCrates(kind) {
  const { profile, optimise } = KINDS[kind];
  const flags = crateFolders().flatMap((place) => ['--remap-path-prefix', `${place}=crates`]);
  const remapped = optimise ? ['--config', `target.${WASM}.rustflags=${JSON.stringify(flags)}`] : [];
  const crates = ['--package', 'tracecut-wasm', '--package', 'tracecut-decoder', '--lib'];
  return runBeside('cargo', [
    'build',
    '--quiet',
    '--locked',
    '--profile',
    profile,
    '--target',
    WASM,
    ...remapped,
    ...crates,
  ]);
}

/** Before their place is asked for: on a new machine they have none. */
function fetchCrates() {
  if (crateFolders().length === 0) run('cargo', ['fetch', '--locked', '--target', WASM]);
}

/** Where Cargo unpacks crates, a folder for each registry. */
function crateFolders() {
  const folder = join(process.env.CARGO_HOME ?? join(homedir(), '.cargo'), 'registry', 'src');
  return existsSync(folder) ? readdirSync(folder).map((name) => join(folder, name)) : [];
}

/** Where a crate's wasm file is, once compiled. */
function wasmFile(crate, profile) {
  return join(root, 'target', WASM, profile, `${crate}.wasm`);
}

/** JavaScript glue and the wasm file in `dist`; optimised ones are kept, for when another build has been between. */
async function buildWasm(cargoWasm, name, kind) {
  await runBeside('bindgen', [cargoWasm, dist, name]);
  if (!KINDS[kind].optimise) return;
  const wasm = join(dist, `${name}_bg.wasm`);
  const kept = join(
    root,
    'target',
    'optimised',
    name,
    `${createHash('sha256').update(readFileSync(wasm)).digest('hex')}.wasm`,
  );
  if (!existsSync(kept)) {
    rmSync(dirname(kept), { recursive: true, force: true });
    mkdirSync(dirname(kept), { recursive: true });
    const options = ['-O3', '--converge', ...wasmFeatures, '--strip-producers', '--strip-target-features'];
    // Enlarging a mask would become one function, which engines compile to code slower by a quarter.
    if (name === 'decoder') options.push('--one-caller-inline-max-function-size=0');
    await during(`optimising ${name}_bg.wasm`, name === 'decoder' ? 12 : 60, () =>
      runBeside(process.execPath, [bin('binaryen/bin/wasm-opt'), ...options, wasm, '-o', kept]),
    );
  }
  copyFileSync(kept, wasm);
}

/** Engines without `TextDecoder` have one of the package's. */
const TEXT = "import { Decoder as TextDecoder, Encoder as TextEncoder } from './text.js';\n";

/** It would find the wasm file by itself, and bundlers with it; here it is always given. */
function editDecoder() {
  const file = join(dist, 'decoder.js');
  const text = readFileSync(file, 'utf8');
  const edited = text.replace("new URL('decoder_bg.wasm', import.meta.url)", 'undefined');
  if (edited === text) fail('decoder.js does not say where its wasm file is.');
  writeFileSync(file, TEXT + edited);
}

/**
 * Writes `glue.js`: wasm-bindgen's module, which is bound to one instance, as a function that makes as many as are
 * wanted.
 */
async function buildGlue() {
  const { build: bundle } = await import('esbuild');
  await bundle({
    entryPoints: [join(dist, 'tracecut.js')],
    outfile: join(dist, 'glue.js'),
    bundle: true,
    format: 'iife',
    globalName: 'glue',
    target: 'es2022',
    banner: {
      js: `// Written by the build from the module that wasm-bindgen made.\n${TEXT}export function makeGlue() {`,
    },
    footer: { js: '  return glue;\n}' },
    // It would find and fetch the wasm file by itself; here a module is always given.
    define: { 'import.meta.url': 'undefined', Response: 'undefined', Request: 'undefined', URL: 'undefined' },
    minifySyntax: true,
    logLevel: 'warning',
  });
  writeFileSync(join(dist, 'glue.d.ts'), "export declare function makeGlue(): typeof import('./tracecut.js');\n");
}

/**
 * Bundles what the package takes of a library into one module of its own, so that a page without a bundler can use it
 * as it is. The library's own notice stays at the end of the file. Its types stay out: nothing public mentions them. So
 * does its source map, which is larger than the whole package: the built site has it.
 */
async function buildVendored(entry) {
  const { build: bundle } = await import('esbuild');
  const outfile = join(dist, 'vendor', basename(entry));
  await bundle({
    entryPoints: [entry],
    outfile,
    bundle: true,
    format: 'esm',
    target: 'es2022',
    minify: true,
    sourcemap: 'external',
    legalComments: 'eof',
    logLevel: 'warning',
  });
  copyFileSync(entry, outfile.replace('.js', '.d.ts'));
}

/** The modules of the package, by their places below `npm`, and how they are compiled. */
function libraryFiles() {
  return readdirSync(lib, { recursive: true })
    .filter((name) => /\.(ts|json)$/.test(name))
    .sort();
}

/** Removes what modules that are no more have left in `dist`, or it would go into the package. */
function removeStale() {
  for (const name of readdirSync(dist, { recursive: true }).map((file) => file.replaceAll('\\', '/'))) {
    const isModule =
      /\.(js|d\.ts)$/.test(name) &&
      !/^(tracecut|decoder|glue|parameters|inline|worker\.bundle|selftest\/expected)\b|^\w+_bg\.wasm|^vendor\//.test(
        name,
      );
    const sources = [name, name.replace(/(\.d\.ts|\.js)$/, '.ts')].map((source) => join(lib, source));
    if (isModule && !sources.some(existsSync)) rmSync(join(dist, name));
  }
}

/** What the self test expects, from the file that the command line holds. */
function writeExpected() {
  const text = readFileSync(join(root, 'cli', 'src', 'selftest', 'expected.json'), 'utf8').trimEnd();
  const file = join(dist, 'selftest', 'expected');
  mkdirSync(dirname(file), { recursive: true });
  writeFileSync(
    `${file}.js`,
    `// Written by the build from cli/src/selftest/expected.json.\nexport const EXPECTED = ${text};\n`,
  );
  const type = '{ readonly version: string; readonly hashes: Readonly<Record<string, string>> }';
  writeFileSync(`${file}.d.ts`, `export declare const EXPECTED: ${type};\n`);
}

function buildTypes() {
  copyFileSync(join(lib, 'dom.d.ts'), join(dist, 'dom.d.ts'));
  run(process.execPath, [bin('typescript/bin/tsc'), '--project', join(lib, 'tsconfig.json')], {
    hint: 'The types of npm do not agree.',
  });
  finishDeclarations(dist);
}

function checkSize() {
  for (const [name, most] of Object.entries(MOST_WASM)) {
    const bytes = readFileSync(join(dist, name));
    const zipped = gzipSync(bytes, { level: 9 }).length;
    console.log(`${name}: ${kilobytes(bytes.length)} raw, ${kilobytes(zipped)} gzipped (at most ${kilobytes(most)})`);
    if (zipped > most) fail(`${name} is over its budget.`);
  }
}

function kilobytes(bytes) {
  return `${(bytes / 1024).toFixed(0)} KB`;
}

if (import.meta.url === pathToFileURL(process.argv[1] ?? '').href) {
  await build({ force: process.argv.includes('--force'), fast: process.argv.includes('--fast') });
}
