// `npm start`: sets up what is missing, builds, serves the demo page and opens it.
// Options: --port N (default 5173), --no-open.

import { spawn } from 'node:child_process';
import { existsSync } from 'node:fs';
import { join } from 'node:path';
import { parseArgs } from 'node:util';
import { build } from './build.mjs';
import { compilePage } from './compile.mjs';
import { serve } from './serve.mjs';
import { fail, root } from './tools.mjs';

const { port, open } = options();
if (!existsSync(join(root, 'dist', 'stamps.json')))
  console.log(
    'The first start compiles the library to WebAssembly: about a minute and a half on two idle cores. The next one takes a second.',
  );
await build({ fast: true, onlyPage: true });
await compilePage({ watch: true });
const { url } = await serve({ port }).catch((error) =>
  fail(
    error.code === 'EADDRINUSE'
      ? `Port ${port} is in use; choose another: npm start -- --port ${port + 1}`
      : error.message,
  ),
);
console.log(`\nTraceCut is at ${url}, its lab at ${url}lab/ (Ctrl+C ends it)`);
if (open) openInBrowser(url);

function options() {
  try {
    const { values } = parseArgs({
      options: { port: { type: 'string', default: '5173' }, 'no-open': { type: 'boolean', default: false } },
    });
    const number = Number(values.port);
    if (!Number.isInteger(number) || number < 0 || number > 65535) fail(`--port ${values.port} (expected 0..=65535)`);
    return { port: number, open: !values['no-open'] };
  } catch (error) {
    return fail(`${error.message}\nUsage: npm start -- [--port N] [--no-open]`);
  }
}

/** Best effort: a machine without a browser still has its server. */
function openInBrowser(address) {
  const commands = { darwin: ['open'], win32: ['cmd', '/c', 'start', ''] };
  const [command, ...args] = commands[process.platform] ?? ['xdg-open'];
  spawn(command, [...args, address], { stdio: 'ignore', detached: true })
    .on('error', () => {})
    .unref();
}
