// The program `tracecut`, for tests that run it.

import { existsSync, statSync } from 'node:fs';
import { join } from 'node:path';
import { root } from '../scripts/tools.mjs';

/** Cargo's profiles that tests and people build the program with. */
const PROFILES = ['quick', 'release', 'debug'];

/** Returns the path of the program: the one that `TRACECUT_CLI` names, else the newest build, else null. */
export function commandLine() {
  if (process.env.TRACECUT_CLI) return process.env.TRACECUT_CLI;
  const built = PROFILES.map((profile) => join(root, 'target', profile, 'tracecut')).filter((path) => existsSync(path));
  const age = (path) => statSync(path).mtimeMs;
  return built.sort((a, b) => age(b) - age(a))[0] ?? null;
}
