// The packed tarball, installed in an empty folder, in a browser: through Vite and webpack, which the project has, without a
// bundler, and by the recipes of other bundlers; esbuild has tests of its own. Each must give what Node gives.

import assert from 'node:assert/strict';
import { cpSync, readFileSync, writeFileSync } from 'node:fs';
import { join } from 'node:path';
import { after, before, test } from 'node:test';
import * as vite from 'vite';
import webpack from 'webpack';
import { outcome } from '../package/app/segment.js';
import { gives } from '../package/found.mjs';
import { installed, served } from '../package/installed.mjs';
import { MAIN, execute, project, recipe, tool } from '../package/project.mjs';
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

test('what is compared is a segmentation', () => {
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

test('webpack, without a setting for the package', async (t) => {
  const path = join(folder, 'out-webpack');
  const stats = await new Promise((done, fail) => {
    webpack({ mode: 'production', context: folder, entry: './main.js', output: { path } }, (error, result) =>
      error ? fail(error) : done(result),
    );
  });
  assert.ok(!stats.hasErrors(), stats.toString());
  cpSync(join(folder, 'index.html'), join(path, 'index.html'));
  await right(t, path);
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

for (const format of ['es', 'iife']) {
  test(`Rollup, as ${format}`, async (t) => {
    const tools = { rollup: '4.68.7', '@rollup/plugin-node-resolve': '16.0.3' };
    const folder = await project(t, { tools, recipe: 'rollup', files: { 'main.js': MAIN } });
    const more = format === 'iife' ? ['--format', 'iife', '--inlineDynamicImports'] : [];
    await tool(folder, 'rollup', '--config', ...more);
    const page = readFileSync(join(folder, 'index.html'), 'utf8');
    const script = format === 'iife' ? page.replace('type="module"', 'defer') : page;
    writeFileSync(join(folder, 'out', 'index.html'), script);
    await right(t, join(folder, 'out'), { files: 1 });
  });
}

test('Parcel', async (t) => {
  const folder = await project(t, { tools: { parcel: '2.16.4' }, recipe: 'parcel', files: { 'main.js': MAIN } });
  await tool(folder, 'parcel', 'build', 'index.html', '--no-cache');
  await right(t, join(folder, 'dist'), { files: 1 });
});

test('Rspack', async (t) => {
  const folder = await project(t, { tools: { '@rspack/core': '2.3.2' } });
  writeFileSync(join(folder, 'rspack.config.js'), recipe('webpack').get('webpack.config.js'));
  // What its command line does, which is a package of its own.
  const script = `import { rspack } from '@rspack/core';
    import config from './rspack.config.js';
    rspack(config, (error, stats) => {
      if (error ?? stats.hasErrors()) throw error ?? new Error(stats.toString());
    });`;
  writeFileSync(join(folder, 'build.mjs'), script);
  await execute(folder, process.execPath, ['build.mjs']);
  cpSync(join(folder, 'index.html'), join(folder, 'out', 'index.html'));
  await right(t, join(folder, 'out'));
});

test('Vite 7, built and in development', async (t) => {
  const folder = await project(t, { tools: { vite: '7.3.8' }, recipe: 'vite' });
  await tool(folder, 'vite', 'build');
  await right(t, join(folder, 'dist'));
  const { createServer } = await import(join(folder, 'node_modules/vite/dist/node/index.js'));
  const server = await createServer({
    root: folder,
    logLevel: 'error',
    server: { port: 0, host: '127.0.0.1', hmr: false },
  });
  t.after(() => server.close());
  await server.listen();
  await gives(t, site.browser, server.resolvedUrls.local[0], expected);
});

test('an import map that names the package at another origin', async (t) => {
  const folder = await project(t, { recipe: 'none' });
  const headers = { 'Access-Control-Allow-Origin': '*' };
  const elsewhere = await served(t, join(folder, 'node_modules'), { headers });
  const page = recipe('none').get('index.html').replace('./node_modules/', elsewhere);
  writeFileSync(join(folder, 'index.html'), page);
  await right(t, folder);
  assert.ok(page.includes(`${elsewhere}tracecut/dist/index.js`));
});

test('Angular', async (t) => {
  const core = Object.fromEntries(
    ['common', 'compiler', 'compiler-cli', 'core', 'platform-browser'].map((name) => [`@angular/${name}`, '20.3.35']),
  );
  const tools = { ...core, '@angular/build': '20.3.41', '@angular/cli': '20.3.41', rxjs: '7.8.2', typescript: '5.9.3' };
  const [setup, assets] = [recipe('angular').get('setup.js'), JSON.parse(recipe('angular').get('assets.json'))];
  const options = {
    browser: 'src/main.ts',
    index: 'src/index.html',
    tsConfig: 'tsconfig.json',
    outputPath: 'out',
    assets,
  };
  const target = { builder: '@angular/build:application', options: { ...options, aot: true } };
  const app = { projectType: 'application', root: '', sourceRoot: 'src', architect: { build: target } };
  const compilerOptions = {
    target: 'ES2022',
    module: 'preserve',
    moduleResolution: 'bundler',
    strict: true,
    allowJs: true,
    skipLibCheck: true,
  };
  const folder = await project(t, {
    tools,
    files: {
      'angular.json': JSON.stringify({ version: 1, projects: { app }, cli: { analytics: false } }),
      'tsconfig.json': JSON.stringify({ compilerOptions, files: ['src/main.ts'] }),
      'src/index.html':
        '<!doctype html><meta charset="utf-8"><base href="/"><link rel="icon" href="data:,"><app-root></app-root>',
      'src/main.ts': `import { provideZonelessChangeDetection, Component } from '@angular/core';
import { bootstrapApplication } from '@angular/platform-browser';
${setup}
// @ts-ignore
import { outcome, throughVideo } from '../segment.js';
@Component({ selector: 'app-root', template: 'TraceCut' })
class App {
  constructor() { (globalThis as any).outcome = Promise.all([outcome(), throughVideo()]); }
}
bootstrapApplication(App, { providers: [provideZonelessChangeDetection()] });
`,
    },
  });
  await tool(folder, 'ng', 'build');
  await right(t, join(folder, 'out', 'browser'), { files: 1 });
});
