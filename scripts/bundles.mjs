// Builds of the package in single files, for tools that carry no other files along: the worker, everything with the wasm
// inside, and CommonJS for Node.

import { readFileSync, writeFileSync } from 'node:fs';
import { join } from 'node:path';
import { deflateSync } from 'node:zlib';
import { root } from './tools.mjs';

const dist = join(root, 'dist');
const entries = join(root, 'scripts', 'bundle');

/** What they are made from besides the built modules. */
export const BUNDLE_SOURCES = ['worker.js', 'inline.js'].map((name) => join(entries, name));

/** Writes `worker.bundle.js`, `inline.js` and `node.cjs` into `dist`. */
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
    // Nothing lies beside this file, and no bundler shall look for it.
    define: { 'import.meta.url': '"inline:"' },
    plugins: [packed],
  });
  writeFileSync(join(dist, 'inline.d.ts'), "export * from './index.js';\n");
  await buildCommonJs(build, common);
  writeFileSync(join(dist, 'node.d.cts'), "export * from './index.js';\n");
}

/**
 * Node's entry as CommonJS: the other files lie beside it, as they do beside the module. Video files are none of Node's,
 * so what reads them stays outside.
 */
function buildCommonJs(build, common) {
  return build({
    ...common,
    entryPoints: [join(dist, 'node.js')],
    outfile: join(dist, 'node.cjs'),
    platform: 'node',
    format: 'cjs',
    define: { 'import.meta.url': 'moduleUrl' },
    banner: { js: "const moduleUrl = require('node:url').pathToFileURL(__filename).href;" },
    plugins: [outside],
  });
}

/** The files that go inside, as text. */
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
    build.onResolve({ filter: /vendor\/media\.js$/ }, () => ({ path: './vendor/media.js', external: true }));
  },
};
