// The programs that Cargo built, for tests that run them.

import { existsSync } from 'node:fs';
import { join } from 'node:path';
import { root } from '../scripts/tools.mjs';

/** The path of the command line: the one of the environment, or what Cargo built last here; null without one. */
export function commandLine() {
  const name = process.platform === 'win32' ? 'tracecut.exe' : 'tracecut';
  const path = process.env.TRACECUT_CLI ?? join(root, 'target', 'debug', name);
  return existsSync(path) ? path : null;
}
