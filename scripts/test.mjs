// `npm test`: everything, in the order in which a fault is cheapest to find. Sets up what is missing first.
// `npm test -- rust|wasm|node|browser` runs only the parts named; `npm run test:long` what is too slow for every time.

import { existsSync, readFileSync, readdirSync } from 'node:fs';
import { availableParallelism } from 'node:os';
import { join } from 'node:path';
import { build } from './build.mjs';
import { ensureNodeModules, ensureRust, ensureRustTool, fail, output, root, run } from './tools.mjs';

const parts = {
  rust: () => {
    // Together: the library is compiled once, with all that the command line wants of it.
    run('cargo', ['test', '--package', 'tracecut', '--package', 'tracecut-cli', '--features', 'tracecut/pnm']);
  },
  wasm: () => {
    ensureRustTool('wasm-bindgen');
    ensureRustTool('wasm-pack');
    // wasm-pack takes the wasm-bindgen test runner from PATH and downloads nothing.
    run('wasm-pack', ['test', '--node', '--mode', 'no-install', 'tests/wasm']);
  },
  node: async () => {
    await build();
    // By itself Node leaves one processor free, which is half of two.
    run(process.execPath, [
      '--test',
      '--test-reporter=spec',
      `--test-concurrency=${availableParallelism()}`,
      ...testFiles('tests/node'),
    ]);
  },
  browser: () => inBrowser('tests/package', 'tests/browser', 'tests/engines'),
  long: async () => {
    run(process.execPath, ['scripts/audit.mjs', '--install']);
    for (const crate of ['tracecut', 'tracecut-cli'])
      run('cargo', ['test', '--tests', '--package', crate, '--', '--ignored', '--nocapture']);
    sanitized();
    run('python3', ['python/run_tests.py', '--wheel']);
    await inBrowser('tests/long');
    // Of the ordinary tests, files that have some which are passed over otherwise.
    const isSlow = (file) => readFileSync(join(root, file), 'utf8').includes('onlyLong');
    const files = testFiles('tests/browser').filter(isSlow);
    run(process.execPath, ['--test', '--test-reporter=spec', ...files], { env: { TRACECUT_LONG: '1' } });
  },
};
const ordinary = ['rust', 'wasm', 'node', 'browser'];

const chosen = process.argv.slice(2);
const unknown = chosen.find((name) => !(name in parts));
if (unknown) fail(`There is no part "${unknown}" (expected ${Object.keys(parts).join(', ')}).`);

ensureNodeModules();
ensureRust();
for (const [name, part] of Object.entries(parts)) {
  if (!(chosen.length > 0 ? chosen : ordinary).includes(name)) continue;
  console.log(`\n== ${name} tests`);
  await part();
}
console.log('\nAll tests passed.');

/** Native tests with every access of memory checked: our code has no `unsafe`, the crates that it calls have. */
function sanitized() {
  if (process.platform !== 'linux' || output('rustc', ['+nightly', '--version']) === null) {
    console.log(
      '!!! SKIPPED: tests with the address sanitizer need Linux and the nightly compiler (rustup toolchain install nightly)',
    );
    return;
  }
  const target = output('rustc', ['-vV']).match(/host: (.*)/)[1];
  const env = { RUSTFLAGS: '-Zsanitizer=address', CARGO_TARGET_DIR: join('target', 'sanitizer') };
  const tests = {
    tracecut: [
      '--features',
      'pnm',
      '--lib',
      '--test',
      'random',
      '--test',
      'pipeline',
      '--test',
      'spectral',
      '--test',
      'mirror',
    ],
    'tracecut-cli': ['--lib', '--test', 'readers'],
  };
  for (const [crate, which] of Object.entries(tests))
    run('cargo', ['+nightly', 'test', '--target', target, '--package', crate, ...which], { env });
}

async function inBrowser(...folders) {
  await build();
  const { ensureBrowser } = await import('./browser.mjs');
  ensureBrowser();
  run(process.execPath, ['--test', '--test-reporter=spec', ...folders.flatMap(testFiles)]);
}

function testFiles(folder) {
  const path = join(root, folder);
  if (!existsSync(path)) fail(`${folder} is missing.`);
  return readdirSync(path)
    .filter((name) => /\.test\.m?js$/.test(name))
    .sort()
    .map((name) => `${folder}/${name}`);
}
