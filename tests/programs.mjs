// The programs that tests run, and ports for their servers.

import { existsSync } from 'node:fs';
import { createServer } from 'node:net';
import { join } from 'node:path';
import { root } from '../scripts/tools.mjs';

/** The path of the command line: the one of the environment, or what Cargo built last here; null without one. */
export function commandLine() {
  const name = process.platform === 'win32' ? 'tracecut.exe' : 'tracecut';
  const path = process.env.TRACECUT_CLI ?? join(root, 'target', 'debug', name);
  return existsSync(path) ? path : null;
}

/** A port of this machine that is free. */
export async function freePort() {
  const server = createServer();
  await new Promise((done) => server.listen(0, '127.0.0.1', done));
  const { port } = server.address();
  await new Promise((done) => server.close(done));
  return port;
}
