// The packed tarball, installed in a folder of its own, in pages: through esbuild, webpack and Vite, without a bundler, and in
// service and shared workers. Each gives what Node gives.

import { cpSync, readFileSync, writeFileSync } from 'node:fs';
import { join } from 'node:path';
import * as esbuild from 'esbuild';
import { synthClip } from '../../dist/node.js';
import { outcome } from '../package/app/segment.js';
import { MAIN, execute, installed, project, recipe, served } from '../package/project.mjs';
import { codeOf } from '../readme.mjs';
import { downloadBytes, expect, test } from './fixtures.mjs';

const CLASSIC = `<!doctype html><meta charset="utf-8"><link rel="icon" href="data:,"><script src="./main.js"></script>`;
const CORS = { 'Access-Control-Allow-Origin': '*' };
/** The files that bundlers copy if they are listed. */
const COPIED = ['tracecut_bg.wasm', 'decoder_bg.wasm', 'worker.bundle.js'];

let expected;
test.beforeAll(async () => {
  expected = await outcome();
  expect(expected).toMatchObject({ objects: 3, decoded: [1, 1] });
  expect(expected.overlap).toBeGreaterThan(0.75);
});

/** Expects that the application gives in a page what it gives in Node, with workers started from `numFiles` files. */
async function expectSameResults(openPage, url, { numFiles }) {
  const workers = [];
  const page = await openPage(url, (target) => target.on('worker', (worker) => workers.push(worker.url())));
  await page.waitForFunction(() => globalThis.outcome);
  const [results, video] = await page.evaluate(() => globalThis.outcome);
  expect(results).toEqual(expected);
  expect(video).toMatchObject({ type: 'video/webm', times: [0, 100, 200, 300, 400, 500] });
  expect(video.overlap).toBeGreaterThan(0.5);
  expect(new Set(workers).size, String(workers)).toBe(numFiles);
}

/** Bundles a file of a project for pages, and returns the folder of the bundle. */
async function bundleClassic(folder, entry, settings) {
  const out = join(folder, 'bundle');
  await esbuild.build({
    ...{ absWorkingDir: folder, entryPoints: [entry], bundle: true, format: 'iife', logLevel: 'error' },
    ...{ outfile: join(out, 'main.js'), ...settings },
  });
  writeFileSync(join(out, 'index.html'), CLASSIC);
  return out;
}

for (const [format, tag] of [
  ['iife', []],
  ['esm', '@long'],
])
  test(`the recipe for esbuild, as ${format}`, { tag }, async ({ cleanup, openPage }) => {
    const folder = await project(cleanup, { recipe: 'esbuild', files: { 'main.js': MAIN } });
    // The project has no esbuild: the recipe imports the one of this project.
    const script = readFileSync(join(folder, 'build.js'), 'utf8');
    const esbuildPath = JSON.stringify(import.meta.resolve('esbuild'));
    writeFileSync(join(folder, 'build.mjs'), script.replace("'esbuild'", esbuildPath));
    await execute(folder, process.execPath, ['build.mjs', format]);
    const out = join(folder, 'out');
    if (format === 'esm') cpSync(join(folder, 'index.html'), join(out, 'index.html'));
    else writeFileSync(join(out, 'index.html'), CLASSIC);
    await expectSameResults(openPage, await served(cleanup, out), { numFiles: 1 });
  });

test('esbuild, with everything in one script that is not a module', { tag: '@long' }, async ({ cleanup, openPage }) => {
  const folder = await project(cleanup, { files: { 'plain.js': MAIN.replace(/^.*setup.*\n/, '') } });
  const out = await bundleClassic(folder, 'plain.js', { alias: { tracecut: 'tracecut/inline' } });
  await expectSameResults(openPage, await served(cleanup, out), { numFiles: 1 });
});

test('a bundle without the files of the package has errors that say which address to set, and works once all are set', async ({
  cleanup,
  openPage,
  faults,
}) => {
  const script = `import * as tracecut from 'tracecut';
    globalThis.tracecut = tracecut;
    globalThis.createError = (options) =>
      tracecut.createSession(options).then(() => 'none', ({ code, message }) => code + ': ' + message);`;
  const configured = codeOf('docs/guide.md').get('Bundlers 2');
  const folder = await project(cleanup, { files: { 'lost.js': script, 'configured.js': `${script}\n${configured}` } });
  const out = await bundleClassic(folder, 'lost.js');
  for (const name of COPIED)
    cpSync(join(folder, 'node_modules', 'tracecut', 'dist', name), join(out, name.replace('worker', 'moved')));
  const url = await served(cleanup, out);
  const page = await openPage(url);
  const createError = (options) => page.evaluate((argument) => globalThis.createError(argument), options);
  const wasm = './tracecut_bg.wasm';
  expect(await createError()).toMatch(/^wasm-load: .*configure\(\{ wasm: '\/tracecut_bg\.wasm' \}\).*tracecut\/inline/);
  expect(await createError({ wasm })).toMatch(/^wasm-load: .*configure\(\{ worker: '\/worker\.bundle\.js' \}\)/);
  expect(await createError({ wasm, worker: './nowhere.js' })).toMatch(
    /^wasm-load: the worker could not be started.*configure\(\{ worker: /,
  );
  expect(await createError({ wasm, worker: false })).toBe('none');
  const decoderError = await page.evaluate(async () => {
    const session = await tracecut.createSession({ wasm: './tracecut_bg.wasm', worker: false });
    return session.push(new Uint8Array([137, 80, 78, 71])).catch(({ code, message }) => `${code}: ${message}`);
  });
  expect(decoderError).toMatch(/^wasm-load: .*configure\(\{ decoder: '\/decoder_bg\.wasm' \}\)/);
  // The browser reports the missing files.
  faults.expected.push(/404/);

  await bundleClassic(folder, 'configured.js');
  cpSync(join(out, 'moved.bundle.js'), join(out, 'worker.bundle.js'));
  await page.reload();
  const codes = await page.evaluate(async () => {
    const session = await tracecut.createSession();
    const { code } = await session.push(new Uint8Array([137, 80, 78, 71])).catch((error) => error);
    session.close();
    return code;
  });
  expect(codes).toBe('decode');
});

test(
  'the Vite example makes an object background by a click, undoes that, and saves an archive',
  { tag: '@long' },
  async ({ cleanup, openPage }) => {
    const root = installed(cleanup, 'examples/vite');
    const configFile = join(root, 'vite.config.js');
    writeFileSync(configFile, codeOf('docs/guide.md').get('Bundlers'));
    const vite = await import('vite');
    await vite.build({ root, configFile, logLevel: 'warn', build: { outDir: 'out' } });
    const page = await openPage(await served(cleanup, join(root, 'out')));
    const status = page.getByRole('status');
    await expect(status).toHaveText(/^3 objects/);
    const clip = await synthClip({ width: 480, height: 270, frames: 10, seed: 1 });
    await page.locator('canvas').click({ position: middleOf(clip.mask(0), 1, clip.width) });
    await expect(status).toHaveText(/^2 objects/);
    await page.getByRole('button', { name: 'Undo' }).click();
    await expect(status).toHaveText(/^3 objects/);
    const [download] = await Promise.all([
      page.waitForEvent('download'),
      page.getByRole('button', { name: 'Save' }).click(),
    ]);
    expect(download.suggestedFilename()).toBe('masks.zip');
    const archive = await downloadBytes(download);
    expect(archive.toString('latin1', 0, 2)).toBe('PK');
    expect(archive.includes('00009.png')).toBe(true);
  },
);

/** Returns a point inside an object: the middle of its middle row. */
function middleOf(mask, object, width) {
  const pixels = [...mask.keys()].filter((p) => mask[p] === object);
  const y = Math.floor(pixels[pixels.length >> 1] / width);
  const row = pixels.filter((p) => Math.floor(p / width) === y).map((p) => p % width);
  return { x: row[row.length >> 1], y };
}

test('the recipe for webpack', { tag: '@long' }, async ({ cleanup, openPage }) => {
  const folder = await project(cleanup, { recipe: 'webpack' });
  const { default: config } = await import(join(folder, 'webpack.config.js'));
  const { default: webpack } = await import('webpack');
  const stats = await new Promise((resolve, reject) =>
    webpack({ ...config, context: folder }, (error, result) => (error ? reject(error) : resolve(result))),
  );
  expect(stats.hasErrors(), stats.toString()).toBe(false);
  cpSync(join(folder, 'index.html'), join(folder, 'out', 'index.html'));
  await expectSameResults(openPage, await served(cleanup, join(folder, 'out')), { numFiles: 2 });
});

test('an import map that names the package on another origin', { tag: '@long' }, async ({ cleanup, openPage }) => {
  const folder = await project(cleanup, { recipe: 'No bundler' });
  const origin = await served(cleanup, join(folder, 'node_modules'), { headers: CORS });
  const page = recipe('No bundler').get('index.html').replaceAll('./node_modules/', origin);
  expect(page).toContain(`${origin}tracecut/dist/index.js`);
  writeFileSync(join(folder, 'index.html'), page);
  await expectSameResults(openPage, await served(cleanup, folder), { numFiles: 2 });
});

/** Scripts of workers that send the results, or the error, to the page. */
const SERVICE_WORKER = `import { outcome } from './segment.js';
  self.addEventListener('message', (event) => {
    const send = (message) => event.source.postMessage(message);
    event.waitUntil(outcome().then(send, ({ code, message }) => send({ code, message })));
  });`;
const SHARED_WORKER = `import { outcome } from './segment.js';
  self.onconnect = ({ ports: [port] }) => {
    const send = (message) => port.postMessage(message);
    outcome().then(send, ({ code, message }) => send({ code, message }));
  };`;

/** Opens a page beside a worker that takes the package from a file of `dist`. */
async function openWorkerPage(cleanup, openPage, entry, script) {
  const folder = await project(cleanup, { files: { 'worker.js': script } });
  const segment = readFileSync(join(folder, 'segment.js'), 'utf8');
  const address = `./node_modules/tracecut/dist/${entry}`;
  writeFileSync(join(folder, 'segment.js'), segment.replace("'tracecut'", `'${address}'`));
  writeFileSync(join(folder, 'index.html'), '<!doctype html><link rel="icon" href="data:,">');
  return openPage(await served(cleanup, folder));
}

test(
  'a service worker needs the inline package, which the error says',
  { tag: '@long' },
  async ({ cleanup, openPage }) => {
    const results = [];
    for (const entry of ['index.js', 'inline.js']) {
      const page = await openWorkerPage(cleanup, openPage, entry, SERVICE_WORKER);
      results.push(
        await page.evaluate(async () => {
          await navigator.serviceWorker.register('./worker.js', { type: 'module' });
          const { active } = await navigator.serviceWorker.ready;
          const answer = new Promise((resolve) => {
            navigator.serviceWorker.onmessage = ({ data }) => resolve(data);
          });
          active.postMessage('go');
          return answer;
        }),
      );
    }
    expect(results[0].code).toBe('wasm-load');
    expect(results[0].message).toMatch(/import\(\) is disallowed.*tracecut\/inline/);
    expect(results[1]).toEqual(expected);
  },
);

for (const entry of ['index.js', 'inline.js'])
  test(`a shared worker with ${entry}`, { tag: '@long' }, async ({ cleanup, openPage }) => {
    const page = await openWorkerPage(cleanup, openPage, entry, SHARED_WORKER);
    const results = await page.evaluate(
      () =>
        new Promise((resolve, reject) => {
          const worker = new SharedWorker('./worker.js', { type: 'module' });
          worker.onerror = () => reject(new Error('no shared worker'));
          worker.port.onmessage = ({ data }) => resolve(data);
          worker.port.start();
        }),
    );
    expect(results).toEqual(expected);
  });
