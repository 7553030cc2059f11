// The packed tarball, installed in an empty folder, in a browser: through Vite and webpack, which the project has, and without
// a bundler; esbuild has tests of its own. Each must give what Node gives.

import assert from 'node:assert/strict';
import { cpSync, writeFileSync } from 'node:fs';
import { join } from 'node:path';
import { after, before, test } from 'node:test';
import * as vite from 'vite';
import webpack from 'webpack';
import { outcome } from '../package/app/segment.js';
import { gives } from '../package/browser-results.mjs';
import { installed, served } from '../package/installed.mjs';
import { project, recipe } from '../package/project.mjs';
import { codeOf } from '../readme.mjs';
import { useServerAndBrowser } from '../site.mjs';

const site = useServerAndBrowser();
const cleaners = [];
let expected;
let folder;
before(async () => {
  folder = installed({ after: (clean) => cleaners.push(clean) }, 'tests/package/app');
  expected = await outcome();
});
after(() => cleaners.forEach((clean) => clean()));

/** Checks the page in a folder that a tool has made. */
async function right(t, made, options) {
  await gives(t, site.browser, await served(t, made), expected, options);
}

test('only segmentations are compared', () => {
  assert.equal(expected.objects, 3);
  assert.ok(expected.overlap > 0.85, `${expected.overlap}`);
  assert.deepEqual(expected.decoded, [1, 1]);
});

test('a production build of Vite', async (t) => {
  const outDir = join(folder, 'out-vite');
  await vite.build({ root: folder, configFile: false, logLevel: 'error', build: { outDir } });
  await right(t, outDir);
});

for (const [how, settings] of [
  ['as it comes', 'export default {};'],
  ['as the guide has it for older ones', codeOf('docs/guide.md').get('Bundlers')],
]) {
  test(`the development server of Vite, ${how}`, async (t) => {
    const configFile = join(folder, 'vite.config.js');
    writeFileSync(configFile, settings);
    const cacheDir = join(folder, `.vite-${settings.length}`);
    const server = await vite.createServer({
      root: folder,
      cacheDir,
      configFile,
      logLevel: 'error',
      server: { port: 0, host: '127.0.0.1', hmr: false },
    });
    assert.deepEqual(server.config.optimizeDeps.exclude ?? [], settings.includes('exclude') ? ['tracecut'] : []);
    t.after(() => server.close());
    await server.listen();
    await gives(t, site.browser, server.resolvedUrls.local[0], expected);
  });
}

test('webpack', async (t) => {
  const folder = await project(t, { recipe: 'webpack' });
  const { default: config } = await import(join(folder, 'webpack.config.js'));
  const stats = await new Promise((done, fail) => {
    webpack({ ...config, context: folder }, (error, result) => (error ? fail(error) : done(result)));
  });
  assert.ok(!stats.hasErrors(), stats.toString());
  cpSync(join(folder, 'index.html'), join(folder, 'out', 'index.html'));
  await right(t, join(folder, 'out'));
});

test('Vite, with the files and the worker where the guide says that others have them', async (t) => {
  const outDir = join(folder, 'out-configured');
  writeFileSync(join(folder, 'configured.js'), `${codeOf('docs/guide.md').get('Bundlers 2')}\n`);
  const edit = {
    name: 'configured',
    transform: (code, id) => (id.endsWith('/main.js') ? `import './configured.js';\n${code}` : undefined),
  };
  await vite.build({ root: folder, configFile: false, logLevel: 'error', build: { outDir }, plugins: [edit] });
  for (const name of ['tracecut_bg.wasm', 'decoder_bg.wasm', 'worker.bundle.js'])
    cpSync(join(folder, 'node_modules', 'tracecut', 'dist', name), join(outDir, name));
  await right(t, outDir, { files: 1 });
});

test('a page without a bundler, under a strict content security policy', async (t) => {
  const headers = {
    'Content-Security-Policy':
      "default-src 'none'; connect-src 'self'; img-src data:; script-src 'self' 'wasm-unsafe-eval'; worker-src 'self'",
  };
  const edit = naming('/node_modules/tracecut/dist/index.js');
  await gives(t, site.browser, await served(t, folder, { headers, edit }), expected);
});

test('a page that takes the package from another origin, as from a CDN', async (t) => {
  const elsewhere = await served(t, join(folder, 'node_modules'), { headers: { 'Access-Control-Allow-Origin': '*' } });
  const edit = naming(`${elsewhere}tracecut/dist/index.js`);
  await gives(t, site.browser, await served(t, folder, { edit }), expected);
});

/** An edit that resolves the package's name as an import map would, which the policy does not allow inline. */
function naming(place) {
  return (text) => text.replace("from 'tracecut'", `from '${place}'`);
}

test('an import map that names the package at another origin', async (t) => {
  const folder = await project(t, { recipe: 'none' });
  const headers = { 'Access-Control-Allow-Origin': '*' };
  const elsewhere = await served(t, join(folder, 'node_modules'), { headers });
  const page = recipe('none').get('index.html').replace('./node_modules/', elsewhere);
  writeFileSync(join(folder, 'index.html'), page);
  await right(t, folder);
  assert.ok(page.includes(`${elsewhere}tracecut/dist/index.js`));
});
