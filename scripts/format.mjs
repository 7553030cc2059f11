// `npm run format`: formats Rust with rustfmt, TypeScript and JavaScript with Prettier. `-- --check` changes nothing and
// fails if a file is not formatted.

import { parseArgs } from 'node:util';
import { ensureNodeModules, fail, run } from './tools.mjs';

const hint = 'Run npm run format.';
const check = options();
await ensureNodeModules();
run('cargo', ['fmt', '--all', ...(check ? ['--check'] : [])], { hint });
run(
  process.execPath,
  ['node_modules/prettier/bin/prettier.cjs', '--log-level', 'warn', check ? '--check' : '--write', '.'],
  { hint },
);

/** Returns whether to check only. */
function options() {
  try {
    return parseArgs({ options: { check: { type: 'boolean', default: false } } }).values.check;
  } catch (error) {
    return fail(`${error.message}\nUsage: npm run format -- [--check]`);
  }
}
