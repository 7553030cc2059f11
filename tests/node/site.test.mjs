// The development server, which serves studio/, www/ (the lab) and dist/ and nothing else, and the built site.

import assert from 'node:assert/strict';
import {
  existsSync,
  mkdirSync,
  mkdtempSync,
  readFileSync,
  readdirSync,
  rmSync,
  symlinkSync,
  writeFileSync,
} from 'node:fs';
import { request } from 'node:http';
import { networkInterfaces, tmpdir } from 'node:os';
import { dirname, join } from 'node:path';
import { test } from 'node:test';
import { serve } from '../../scripts/serve.mjs';
import { writeSite } from '../../scripts/site.mjs';
import { root } from '../../scripts/tools.mjs';

/** Requests a path as it is written; `fetch` would normalize it. */
function rawRequest(base, path, { method = 'GET', headers = {}, hostname = new URL(base).hostname } = {}) {
  return new Promise((resolve, reject) => {
    const { port } = new URL(base);
    request({ hostname, port, path, method, headers }, (response) => {
      response.resume();
      resolve({ status: response.statusCode, type: response.headers['content-type'] });
    })
      .on('error', reject)
      .end();
  });
}

test('serves files with their types', async (t) => {
  const server = await serve();
  t.after(() => server.close());
  assert.deepEqual(await rawRequest(server.url, '/dist/index.js'), {
    status: 200,
    type: 'text/javascript; charset=utf-8',
  });
  assert.deepEqual(await rawRequest(server.url, '/dist/tracecut_bg.wasm'), { status: 200, type: 'application/wasm' });
  assert.deepEqual(await rawRequest(server.url, '/'), { status: 200, type: 'text/html; charset=utf-8' });
  assert.deepEqual(await rawRequest(server.url, '/lab/'), { status: 200, type: 'text/html; charset=utf-8' });
  assert.deepEqual(await rawRequest(server.url, '/styles/base.css', { method: 'HEAD' }), {
    status: 200,
    type: 'text/css; charset=utf-8',
  });
});

test('serves no path outside of its folders', async (t) => {
  const server = await serve();
  t.after(() => server.close());
  for (const path of [
    '/../package.json',
    '/%2e%2e/package.json',
    '/..%2fpackage.json',
    '/dist/../../package.json',
    '/dist/..%2f..%2fpackage.json',
    '/dist/..%5c..%5cpackage.json',
    '/dist/%2e%2e%2f%2e%2e%2fpackage.json',
    '/dist/%2E%2E/%2E%2E/package.json',
    '/dist/%252e%252e%252f%252e%252e%252fpackage.json',
    '/dist/..%255c..%255cpackage.json',
    '/dist/%c0%ae%c0%ae/%c0%ae%c0%ae/package.json',
    '/dist/....//....//package.json',
    '/dist/..;/package.json',
    '//package.json',
    '//etc/passwd',
    '/dist//etc/passwd',
    '/%2fetc%2fpasswd',
    '/dist/index.js%00',
    '/dist/index.js%00.html',
    '/%00',
    '/%',
    '/dist',
    '/dist/',
    '/nothing.js',
    '/package.json',
  ]) {
    assert.equal((await rawRequest(server.url, path)).status, 404, path);
  }
  assert.equal((await rawRequest(server.url, '/', { method: 'POST' })).status, 405);
});

test('follows no link out of a folder', async (t) => {
  const outside = mkdtempSync(join(tmpdir(), 'tracecut-'));
  t.after(() => rmSync(outside, { recursive: true, force: true }));
  const folder = join(outside, 'open');
  mkdirSync(folder);
  writeFileSync(join(outside, 'secret.js'), 'secret');
  writeFileSync(join(folder, 'file.js'), 'open');
  symlinkSync(outside, join(folder, 'up'));
  symlinkSync(join(outside, 'secret.js'), join(folder, 'secret.js'));
  symlinkSync('file.js', join(folder, 'same.js'));
  const server = await serve({ places: [{ prefix: '/', folder }] });
  t.after(() => server.close());
  for (const path of ['/up/secret.js', '/secret.js', '/up/open/file.js/../../secret.js'])
    assert.equal((await rawRequest(server.url, path)).status, 404, path);
  for (const path of ['/file.js', '/same.js', '/up/open/file.js'])
    assert.equal((await rawRequest(server.url, path)).status, 200, path);
});

test('answers only this machine, and only under its own names', async (t) => {
  const server = await serve();
  t.after(() => server.close());
  const externalAddresses = Object.values(networkInterfaces()).flatMap((addresses) =>
    addresses.filter(({ internal }) => !internal),
  );
  for (const { address, scopeid } of externalAddresses) {
    const hostname = scopeid ? `${address}%${scopeid}` : address;
    await assert.rejects(rawRequest(server.url, '/', { hostname }), undefined, address);
  }
  for (const host of ['rebound.example', '127.0.0.1.example', 'localhost.example:80'])
    assert.equal((await rawRequest(server.url, '/', { headers: { host } })).status, 403, host);
  const { port } = new URL(server.url);
  for (const host of [`localhost:${port}`, `127.0.0.1:${port}`, '[::1]', 'LOCALHOST'])
    assert.equal((await rawRequest(server.url, '/', { headers: { host } })).status, 200, host);
});

test('every script of the site has a source map with its sources, and names no path of this machine', async (t) => {
  const folder = mkdtempSync(join(tmpdir(), 'tracecut-site-'));
  t.after(() => rmSync(folder, { recursive: true, force: true }));
  const listed = await writeSite(folder);
  const scripts = readdirSync(folder, { recursive: true }).filter((name) => name.endsWith('.js'));
  assert.ok(scripts.length > 30, `${scripts.length} scripts`);
  for (const path of scripts.map((name) => join(folder, name))) {
    const code = readFileSync(path, 'utf8');
    const { sources, sourcesContent } = JSON.parse(readFileSync(`${path}.map`, 'utf8'));
    assert.equal(sourcesContent.filter(Boolean).length, sources.length, path);
    const isLocal = (source) => source.startsWith('/') || source.includes(folder.slice(1));
    assert.deepEqual(sources.filter(isLocal), []);
    // Small scripts do not name their map, to save bytes.
    const map = /\/\/# sourceMappingURL=(\S+)\s*$/.exec(code)?.[1];
    if (map || code.length >= 4096) assert.ok(map && existsSync(join(dirname(path), map)), path);
  }
  const isMap = (name) => name.endsWith('.map');
  assert.deepEqual(listed.filter(isMap), []);
});

test('the manifest makes the page installable, with icons of the sizes that it names', () => {
  const read = (name) => readFileSync(join(root, 'studio', name));
  assert.match(String(read('index.html')), /<link rel="manifest" href="\.\/manifest\.webmanifest">/);
  const { display, icons } = JSON.parse(read('manifest.webmanifest'));
  assert.equal(display, 'standalone');
  for (const { src, sizes, type } of icons) {
    const bytes = read(src);
    if (type === 'image/svg+xml') assert.ok(sizes === 'any' && bytes.includes('<svg'), src);
    else assert.equal(`${bytes.readUInt32BE(16)}x${bytes.readUInt32BE(20)}`, sizes, src);
  }
});
