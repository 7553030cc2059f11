// What an editor shows of the installed package: the descriptions of the API reference, from the compiler's language server.

import assert from 'node:assert/strict';
import { spawn } from 'node:child_process';
import { writeFileSync } from 'node:fs';
import { join } from 'node:path';
import { test } from 'node:test';
import { pathToFileURL } from 'node:url';
import { root } from '../../scripts/tools.mjs';
import { installed } from '../package/installed.mjs';

const ENTRIES = ['tracecut', 'tracecut/draw', 'tracecut/edit', 'tracecut/export', 'tracecut/stages', 'tracecut/node'];

/** Starts the language server in a folder; `ask` sends a request, `tell` a notification. */
function languageServer(t, folder) {
  const compiler = join(root, 'node_modules', 'typescript', 'bin', 'tsc');
  const server = spawn(process.execPath, [compiler, '--lsp', '--stdio'], { cwd: folder, stdio: 'pipe' });
  t.after(() => server.kill());
  const answers = new Map();
  let received = Buffer.alloc(0);
  const send = (message) => {
    const body = Buffer.from(JSON.stringify({ jsonrpc: '2.0', ...message }));
    server.stdin.write(Buffer.concat([Buffer.from(`Content-Length: ${body.length}\r\n\r\n`), body]));
  };
  server.stdout.on('data', (data) => {
    received = Buffer.concat([received, data]);
    for (;;) {
      const end = received.indexOf('\r\n\r\n');
      if (end < 0) return;
      const length = Number(/Content-Length: (\d+)/.exec(received.subarray(0, end).toString())[1]);
      if (received.length < end + 4 + length) return;
      const message = JSON.parse(received.subarray(end + 4, end + 4 + length).toString());
      received = received.subarray(end + 4 + length);
      // The server's own questions need an answer too.
      if (message.method) message.id !== undefined && send({ id: message.id, result: null });
      else answers.get(message.id)(message);
    }
  });
  let count = 0;
  const ask = (method, params) =>
    new Promise((resolve) => {
      count += 1;
      answers.set(count, resolve);
      send({ id: count, method, params });
    });
  return { ask, tell: (method, params) => send({ method, params }) };
}

/** Returns what an editor shows beside each of these names, by name. */
async function shown(t, folder, file, imports) {
  const names = imports.flatMap(([, list]) => list);
  const lines = imports.map(([entry, list]) => `import { ${list.join(', ')} } from '${entry}';`);
  const text = [...lines, ...names, ''].join('\n');
  writeFileSync(join(folder, file), text);
  const uri = pathToFileURL(join(folder, file)).href;
  const { ask, tell } = languageServer(t, folder);
  await ask('initialize', { processId: process.pid, rootUri: pathToFileURL(folder).href, capabilities: {} });
  tell('initialized', {});
  tell('textDocument/didOpen', { textDocument: { uri, languageId: 'typescript', version: 1, text } });
  const hovers = new Map();
  for (const [index, name] of names.entries()) {
    const position = { line: lines.length + index, character: 0 };
    const { result } = await ask('textDocument/hover', { textDocument: { uri }, position });
    hovers.set(name, typeof result?.contents === 'string' ? result.contents : (result?.contents?.value ?? ''));
  }
  return hovers;
}

for (const file of ['main.mts', 'main.cts'])
  test(`an editor shows the description of everything that ${file} imports`, async (t) => {
    const folder = installed(t);
    const entries = file.endsWith('.cts') ? ENTRIES.filter((entry) => entry !== 'tracecut/node') : ENTRIES;
    const imports = await Promise.all(
      entries.map(async (entry) => [entry, Object.keys(await import(entry)).filter((name) => name !== 'default')]),
    );
    const hovers = await shown(t, folder, file, imports);
    assert.ok(hovers.size > 60, `${hovers.size} names`);
    // The declaration is a block of code; the description follows it.
    const bare = [...hovers].filter(([, text]) => !/\w/.test(text.replace(/```[^]*?```/g, '')));
    assert.deepEqual(bare, []);
    assert.match(hovers.get('createSession'), /Opens a session\./);
  });
