// The native tests with the address sanitizer, which needs Linux and the nightly compiler: our code has no `unsafe`, but crates
// that it calls do.

import { join } from 'node:path';
import { output, run } from './tools.mjs';

const target = output('rustc', ['-vV']).match(/host: (.*)/)[1];
const env = { RUSTFLAGS: '-Zsanitizer=address', CARGO_TARGET_DIR: join('target', 'sanitizer') };
const common = ['+nightly', 'test', '--locked', '--target', target, '--lib', '--test', 'integration'];
// No unit test has one of the names that are left out; those tests start other programs.
run(
  'cargo',
  [...common, '--package', 'tracecut', '--features', 'pnm', '--', '--skip', 'each_crate_has', '--skip', 'examples'],
  { env },
);
run('cargo', [...common, '--package', 'tracecut-cli', '--', '--skip', 'cli::', '--skip', 'long::'], { env });
run('cargo', [...common, '--package', 'tracecut-bench', '--', '--skip', 'bench::', '--skip', 'benchmark::'], { env });
