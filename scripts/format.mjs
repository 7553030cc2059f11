// `npm run format`: Rust by rustfmt, TypeScript and JavaScript by Prettier. `-- --check` changes nothing and fails at a file that is
// not formatted.

import { parseArgs } from 'node:util';
import { ensureNodeModules, fail, run } from './tools.mjs';

const hint = 'npm run format puts it right.';
const check = options();
ensureNodeModules();
run('cargo', ['fmt', '--all', ...(check ? ['--check'] : [])], { hint });
run(
  process.execPath,
  ['node_modules/prettier/bin/prettier.cjs', '--log-level', 'warn', check ? '--check' : '--write', '.'],
  { hint },
);

/** Whether only to look. */
function options() {
  try {
    return parseArgs({ options: { check: { type: 'boolean', default: false } } }).values.check;
  } catch (error) {
    return fail(`${error.message}\nUsage: npm run format -- [--check]`);
  }
}
