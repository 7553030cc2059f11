// The development server serves studio/, www/ (the lab) and dist/ and nothing else.

import assert from 'node:assert/strict';
import { mkdirSync, mkdtempSync, rmSync, symlinkSync, writeFileSync } from 'node:fs';
import { request } from 'node:http';
import { networkInterfaces, tmpdir } from 'node:os';
import { join } from 'node:path';
import { test } from 'node:test';
import { serve } from '../../scripts/serve.mjs';

/** A request whose path goes out as it is written; `fetch` would tidy it up. */
function raw(base, path, { method = 'GET', headers = {}, hostname = new URL(base).hostname } = {}) {
  return new Promise((done, failed) => {
    const { port } = new URL(base);
    request({ hostname, port, path, method, headers }, (response) => {
      response.resume();
      done({ status: response.statusCode, type: response.headers['content-type'] });
    })
      .on('error', failed)
      .end();
  });
}

test('files have their types', async (t) => {
  const server = await serve();
  t.after(() => server.close());
  assert.deepEqual(await raw(server.url, '/dist/index.js'), { status: 200, type: 'text/javascript; charset=utf-8' });
  assert.deepEqual(await raw(server.url, '/dist/tracecut_bg.wasm'), { status: 200, type: 'application/wasm' });
  assert.deepEqual(await raw(server.url, '/'), { status: 200, type: 'text/html; charset=utf-8' });
  assert.deepEqual(await raw(server.url, '/lab/'), { status: 200, type: 'text/html; charset=utf-8' });
  assert.deepEqual(await raw(server.url, '/styles/base.css', { method: 'HEAD' }), {
    status: 200,
    type: 'text/css; charset=utf-8',
  });
});

test('no path leads out of the two folders', async (t) => {
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
    assert.equal((await raw(server.url, path)).status, 404, path);
  }
  assert.equal((await raw(server.url, '/', { method: 'POST' })).status, 405);
});

test('a link does not lead out of a folder', async (t) => {
  const made = mkdtempSync(join(tmpdir(), 'tracecut-'));
  t.after(() => rmSync(made, { recursive: true, force: true }));
  const folder = join(made, 'open');
  mkdirSync(folder);
  writeFileSync(join(made, 'secret.js'), 'secret');
  writeFileSync(join(folder, 'file.js'), 'open');
  symlinkSync(made, join(folder, 'up'));
  symlinkSync(join(made, 'secret.js'), join(folder, 'secret.js'));
  symlinkSync('file.js', join(folder, 'same.js'));
  const server = await serve({ places: [{ prefix: '/', folder }] });
  t.after(() => server.close());
  for (const path of ['/up/secret.js', '/secret.js', '/up/open/file.js/../../secret.js'])
    assert.equal((await raw(server.url, path)).status, 404, path);
  for (const path of ['/file.js', '/same.js', '/up/open/file.js'])
    assert.equal((await raw(server.url, path)).status, 200, path);
});

test('it answers on this machine alone, and under no name but its own', async (t) => {
  const server = await serve();
  t.after(() => server.close());
  const others = Object.values(networkInterfaces()).flatMap((all) => all.filter(({ internal }) => !internal));
  for (const { address, scopeid } of others) {
    const hostname = scopeid ? `${address}%${scopeid}` : address;
    await assert.rejects(raw(server.url, '/', { hostname }), undefined, address);
  }
  for (const host of ['rebound.example', '127.0.0.1.example', 'localhost.example:80'])
    assert.equal((await raw(server.url, '/', { headers: { host } })).status, 403, host);
  const { port } = new URL(server.url);
  for (const host of [`localhost:${port}`, `127.0.0.1:${port}`, '[::1]', 'LOCALHOST'])
    assert.equal((await raw(server.url, '/', { headers: { host } })).status, 200, host);
});
