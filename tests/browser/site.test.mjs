// The page as it is put on a host, bundled and minified: that it works from a folder of a host, and what it weighs.

import assert from 'node:assert/strict';
import { existsSync, mkdtempSync, readFileSync, readdirSync, rmSync } from 'node:fs';
import { createServer } from 'node:http';
import { tmpdir } from 'node:os';
import { dirname, extname, join } from 'node:path';
import { after, before, test } from 'node:test';
import { gzipSync } from 'node:zlib';
import { launchBrowser } from '../../scripts/browser.mjs';
import { writeSite } from '../../scripts/site.mjs';
import { SMALL, bytesOf, ended, exportAs, onlyLong, text } from './support.mjs';

/** Most bytes of all that a visit loads until the sample is segmented, each file zipped as a host sends it. */
const MOST_ZIPPED = { '': 556 * 1000, 'lab/': 457 * 1000 };
const FOLDER = '/some/where/';
const TYPES = {
  '.html': 'text/html',
  '.js': 'text/javascript',
  '.css': 'text/css',
  '.wasm': 'application/wasm',
  '.svg': 'image/svg+xml',
  '.avif': 'image/avif',
  '.webmanifest': 'application/manifest+json',
};

const target = mkdtempSync(join(tmpdir(), 'tracecut-site-'));
const asked = new Map();
let files, server, browser, hasSmallSample;

before(async () => {
  files = await writeSite(target);
  server = createServer((request, response) => {
    const { pathname } = new URL(request.url, 'http://localhost');
    const name = pathname.slice(FOLDER.length).replace(/(^|\/)$/, '$1index.html');
    if (!pathname.startsWith(FOLDER) || !existsSync(join(target, name))) return response.writeHead(404).end();
    const bytes = readFileSync(join(target, name));
    asked.set(name, gzipSync(bytes, { level: 9 }).length);
    const type = TYPES[extname(name)] ?? 'image/png';
    return response.writeHead(200, { 'content-type': type }).end(withSmallSample(bytes, type));
  });
  await new Promise((done) => server.listen(0, '127.0.0.1', done));
  browser = await launchBrowser();
});
after(async () => {
  await browser?.close();
  server?.closeAllConnections();
  server?.close();
  rmSync(target, { recursive: true, force: true });
});

/** A script as the site has it, or with a smaller sample: the page's own takes five times as long. */
function withSmallSample(bytes, type) {
  if (type !== TYPES['.js'] || !hasSmallSample) return bytes;
  return String(bytes).replace('{width:480,height:270,frames:24,seed:0}', JSON.stringify(SMALL));
}

/** A page at the site, its sample segmented. @param {'' | 'lab/'} place of the page in the site */
async function visit(serviceWorkers, place = '') {
  asked.clear();
  // What a service worker keeps has to be what was built.
  hasSmallSample = serviceWorkers === 'block';
  const context = await browser.newContext({ serviceWorkers });
  await context.addInitScript(() => (globalThis.showSaveFilePicker = undefined));
  const page = await context.newPage();
  // On a busy machine the sample takes far longer than alone.
  page.setDefaultTimeout(180_000);
  const faults = [];
  page.on('pageerror', ({ message }) => faults.push(message));
  page.on('response', (response) => response.ok() || faults.push(`${response.status()} ${response.url()}`));
  await page.goto(`http://127.0.0.1:${server.address().port}${FOLDER}${place}`);
  assert.equal(await ended(page), 'done');
  assert.match(await text(page, place ? '#status' : '#headline'), /^[2-9] moving objects/);
  assert.equal(await page.evaluate(() => document.body.innerText.includes(' 16 frames')), hasSmallSample);
  return { page, faults };
}

for (const [place, most] of Object.entries(MOST_ZIPPED))
  test(`the site's ${place || 'page'} segments its sample, and weighs less than ${most / 1000} kB until then`, async () => {
    const { faults } = await visit('block', place);
    const weight = [...asked.values()].reduce((sum, size) => sum + size, 0);
    console.log(`a first visit: ${weight} bytes zipped in ${asked.size} files`);
    assert.ok(weight < most, `${weight} bytes`);
    assert.deepEqual(faults, []);
  });

test('the site is cached completely for offline use, including parts that are loaded on demand', onlyLong, async () => {
  const { page, faults } = await visit('allow');
  // A service worker that misses a file is not installed.
  await page.evaluate(() => navigator.serviceWorker.ready.then(() => true));
  const unasked = files.filter((name) => name !== './' && !asked.has(name.slice(2).replace(/\/$/, '/index.html')));
  assert.deepEqual(unasked, []);
  await page.keyboard.press('e');
  const coming = page.waitForEvent('download');
  await exportAs(page, 'zip');
  assert.ok((await bytesOf(await coming)).length > 0);
  assert.deepEqual(faults, []);
});

test('every script of the site has a source map with its sources, and none names a place of this machine', () => {
  const scripts = readdirSync(target, { recursive: true }).filter((name) => name.endsWith('.js'));
  assert.ok(scripts.length > 30, `${scripts.length} scripts`);
  for (const file of scripts.map((name) => join(target, name))) {
    const code = readFileSync(file, 'utf8');
    const { sources, sourcesContent } = JSON.parse(readFileSync(`${file}.map`, 'utf8'));
    assert.equal(sourcesContent.filter(Boolean).length, sources.length, file);
    assert.deepEqual(
      sources.filter((source) => source.startsWith('/') || source.includes(target.slice(1))),
      [],
    );
    const named = /\/\/# sourceMappingURL=(\S+)\s*$/.exec(code)?.[1];
    if (named ?? code.length >= 4096) assert.ok(named && existsSync(join(dirname(file), named)), file);
  }
  assert.deepEqual(
    files.filter((name) => name.endsWith('.map')),
    [],
  );
});
