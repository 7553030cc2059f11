// Finding and compiling the wasm file, and what is said when that fails.

import assert from 'node:assert/strict';
import { readFile } from 'node:fs/promises';
import { test } from 'node:test';
import { createSession } from 'tracecut';
import { boundaries } from 'tracecut/stages';
import { serve } from '../../scripts/serve.mjs';
import { plain, png, rejects } from './support.mjs';

const wasmFile = new URL('../../dist/tracecut_bg.wasm', import.meta.url);

test('the module needs no relaxed SIMD, which Safari and Node 20 refuse', async () => {
  const bytes = await readFile(wasmFile);
  const relaxed = [
    0, 97, 115, 109, 1, 0, 0, 0, 1, 5, 1, 96, 0, 1, 123, 3, 2, 1, 0, 10, 15, 1, 13, 0, 65, 1, 253, 15, 65, 2, 253, 15,
    253, 128, 2, 11,
  ];
  assert.ok(WebAssembly.validate(bytes), 'this Node refuses the module');
  // Where the engine itself knows relaxed SIMD the check above proves nothing; CI runs a Node that does not.
  if (process.version.startsWith('v20.'))
    assert.ok(!WebAssembly.validate(new Uint8Array(relaxed)), 'the probe is no probe');
});

test('wasm can be given as bytes, as a module, as a file URL, as a web URL and as a response', async (t) => {
  const bytes = await readFile(wasmFile);
  const server = await serve();
  t.after(() => server.close());
  const url = `${server.url}dist/tracecut_bg.wasm`;
  for (const wasm of [
    bytes,
    bytes.buffer,
    await WebAssembly.compile(bytes),
    wasmFile,
    url,
    new URL(url),
    await fetch(url),
  ]) {
    (await createSession({ wasm })).close();
  }
});

test('the decoder is only loaded for files, from wherever it is said to be', async (t) => {
  const [broken, image] = [new Uint8Array([0, 97, 115, 109, 9]), plain(8, 8)];
  const session = await createSession({ decoder: broken });
  t.after(() => session.close());
  await session.push(image);
  await rejects(session.push(png(image)), 'wasm-load', /could not be compiled/);
  assert.equal(session.numFrames, 1);
  const other = await createSession({ decoder: new URL('../../dist/decoder_bg.wasm', import.meta.url) });
  t.after(() => other.close());
  await other.push(png(image));
  assert.equal(other.numFrames, 1);
  await rejects(boundaries(png(image), { decoder: 7 }), 'param', /wasm = 7/);
});

test('a page of HTML in place of wasm is called what it is', async () => {
  const html = new TextEncoder().encode('<!doctype html><title>404</title>');
  await rejects(createSession({ wasm: html }), 'wasm-load', /HTML/);
  const response = new Response(html, { headers: { 'Content-Type': 'text/html' } });
  await rejects(createSession({ wasm: response }), 'wasm-load', /HTML/);
  const disguised = new Response(html, { headers: { 'Content-Type': 'application/wasm' } });
  await rejects(createSession({ wasm: disguised }), 'wasm-load', /HTML/);
});

test('a missing, broken or wrong wasm file is a wasm-load error in words', async (t) => {
  const server = await serve();
  t.after(() => server.close());
  await rejects(createSession({ wasm: `${server.url}dist/none.wasm` }), 'wasm-load', /the server answered 404/);
  await rejects(createSession({ wasm: new URL('none.wasm', wasmFile) }), 'wasm-load', /could not be read/);
  await rejects(createSession({ wasm: new Uint8Array([0, 97, 115, 109, 9]) }), 'wasm-load', /could not be compiled/);
  await rejects(createSession({ wasm: 7 }), 'param', /wasm = 7/);
});
