// The development server serves www/ and dist/ and nothing else.

import assert from 'node:assert/strict';
import { request } from 'node:http';
import { test } from 'node:test';
import { serve } from '../../scripts/serve.mjs';

/** A request whose path goes out as it is written; `fetch` would tidy it up. */
function raw(base, path, method = 'GET') {
  return new Promise((done, failed) => {
    const { hostname, port } = new URL(base);
    request({ hostname, port, path, method }, (response) => {
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
  assert.deepEqual(await raw(server.url, '/styles/base.css', 'HEAD'), { status: 200, type: 'text/css; charset=utf-8' });
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
    '//package.json',
    '/%00',
    '/%',
    '/dist',
    '/dist/',
    '/nothing.js',
    '/package.json',
  ]) {
    assert.equal((await raw(server.url, path)).status, 404, path);
  }
  assert.equal((await raw(server.url, '/', 'POST')).status, 405);
});
