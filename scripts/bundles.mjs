// Builds the package as single files, for tools that copy no other files: the worker, everything with the wasm inside, and
// CommonJS for Node.

import { readFileSync, writeFileSync } from 'node:fs';
import { join } from 'node:path';
import { deflateSync } from 'node:zlib';
import { root } from './tools.mjs';

const dist = join(root, 'dist');
const entries = join(root, 'scripts', 'bundle');

/** Their sources besides the built modules. */
export const BUNDLE_SOURCES = ['worker.js', 'inline.js'].map((name) => join(entries, name));

/** The entries of the package that `require` can load: their paths in `dist`, for Node and for types. */
const ENTRIES = {
  index: ['node/index.js', 'index.js'],
  draw: ['draw.js', 'draw.js'],
  edit: ['node/edit.js', 'edit.js'],
  export: ['node/export.js', 'export.js'],
  stages: ['node/stages.js', 'stages.js'],
};

/** Writes `worker.bundle.js`, `inline.js` and the entries for `require` into `dist`. */
export async function buildBundles() {
  const { build } = await import('esbuild');
  const common = { bundle: true, minify: true, target: 'es2022', legalComments: 'eof', logLevel: 'warning' };
  await build({
    ...common,
    entryPoints: [join(entries, 'worker.js')],
    outfile: join(dist, 'worker.bundle.js'),
    format: 'iife',
  });
  await build({
    ...common,
    entryPoints: [join(entries, 'inline.js')],
    outfile: join(dist, 'inline.js'),
    format: 'esm',
    // There are no files beside this one, and bundlers must not look for any.
    define: { 'import.meta.url': '"inline:"' },
    plugins: [packed],
  });
  const typeExports = Object.values(ENTRIES).map(([, types]) => `export * from './${types}';\n`);
  writeFileSync(join(dist, 'inline.d.ts'), typeExports.join(''));
  await buildCommonJs(build, common);
}

/**
 * Builds Node's entries as CommonJS: one file with all code, and one per entry with its names, so that all share one state.
 * The other files lie beside them, as beside the modules. Node reads neither video files nor cameras, so that code stays external.
 */
async function buildCommonJs(build, common) {
  const modules = Object.values(ENTRIES).map(([module]) => module);
  const node = { ...common, platform: 'node', plugins: [outside] };
  await build({
    ...node,
    stdin: { contents: modules.map((name) => `export * from './${name}';`).join('\n'), resolveDir: dist },
    outfile: join(dist, 'node', 'all.cjs'),
    format: 'cjs',
    define: { 'import.meta.url': 'moduleUrl' },
    banner: { js: "const moduleUrl = require('node:url').pathToFileURL(__filename).href;" },
  });
  const entryPoints = modules.map((name) => join(dist, name));
  const { metafile } = await build({ ...node, entryPoints, outdir: dist, format: 'esm', write: false, metafile: true });
  const outputs = Object.values(metafile.outputs);
  for (const [name, [module, types]] of Object.entries(ENTRIES)) {
    const { exports } = outputs.find(({ entryPoint }) => entryPoint?.endsWith(`dist/${module}`));
    const file = join(dist, 'node', name);
    writeFileSync(
      `${file}.cjs`,
      `const { ${exports.join(', ')} } = require('./all.cjs');\nmodule.exports = { ${exports.join(', ')} };\n`,
    );
    writeFileSync(`${file}.d.cts`, `export * from '../${types}';\n`);
  }
}

/** Embeds the files as text. */
const packed = {
  name: 'packed',
  setup(build) {
    const files = { ENGINE: 'tracecut_bg.wasm', DECODER: 'decoder_bg.wasm', WORKER: 'worker.bundle.js' };
    const line = ([name, file]) => {
      const text = deflateSync(readFileSync(join(dist, file)), { level: 9 }).toString('base64');
      return `export const ${name} = '${text}';`;
    };
    build.onResolve({ filter: /^packed$/ }, () => ({ path: 'packed', namespace: 'packed' }));
    build.onLoad({ filter: /.*/, namespace: 'packed' }, () => ({
      contents: Object.entries(files).map(line).join('\n'),
    }));
  },
};

const outside = {
  name: 'outside',
  setup(build) {
    build.onResolve({ filter: /vendor\/media\.js$/ }, () => ({ path: '../vendor/media.js', external: true }));
    build.onResolve({ filter: /^\.\/live\.js$/ }, () => ({ path: '../video/live.js', external: true }));
  },
};
