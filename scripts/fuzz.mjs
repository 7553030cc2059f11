// `npm run fuzz -- TARGET|all [RUNS]`: fuzzes with libFuzzer, and lists the targets with findings. File readers run with
// the address sanitizer; whole runs go without it, at twice the speed, unless TRACECUT_SANITIZER=address. Needs the nightly
// compiler (`rustup toolchain install nightly`); cargo-fuzz is built into .tools if it is missing. Findings are written to
// fuzz/artifacts, inputs with new coverage to fuzz/corpus.

import { spawnSync } from 'node:child_process';
import { existsSync, mkdirSync, readFileSync } from 'node:fs';
import { join } from 'node:path';
import { ensureRustTool, environment, fail, output, root, run } from './tools.mjs';

const folder = join(root, 'fuzz');
const source = readFileSync(join(folder, 'fuzz.rs'), 'utf8');
const targets = [...source.matchAll(/^ +"(\w+)" => /gm)].map(([, name]) => name);

/** Number of runs and maximum length of inputs, where they are not 1,000,000 and 4 KiB. */
const runsOf = {
  session: 20000,
  corrections: 20000,
  halves: 20000,
  windows: 20000,
  image: 50000,
  outside_tracks: 20000,
};
/** The code of these is ours and has no `unsafe`; `npm run test:long` runs the native tests with the sanitizer. */
const sanitizerOf = (name) => process.env.TRACECUT_SANITIZER ?? (name in runsOf ? 'none' : 'address');
const built = (sanitizer) => join(folder, 'target', sanitizer);
const lengthOf = { image_file: 16384, animation: 8192, y4m: 2048, flo: 1024, setting: 128, bmf: 512 };

const [target, runs] = process.argv.slice(2);
const chosen = target === 'all' ? targets : [target];
if (!chosen.every((name) => targets.includes(name)) || (runs !== undefined && !(Number(runs) > 0)))
  fail(`Usage: npm run fuzz -- all|${targets.join('|')} [RUNS]`);
if (process.platform !== 'linux' || process.arch !== 'x64') fail('Fuzzing is set up for Linux on x86-64 only.');
if (output('rustc', ['+nightly', '--version']) === null)
  fail('The nightly compiler was not found: rustup toolchain install nightly --profile minimal');
ensureRustTool('cargo-fuzz');
const writer = ['--features', 'pnm', '--test', 'integration', 'seed_files_are_written', '--', '--ignored'];
run('cargo', ['test', '--quiet', '--locked', ...writer]);
for (const sanitizer of new Set(chosen.map(sanitizerOf)))
  run('cargo', ['+nightly', 'fuzz', 'build', 'fuzz', '--sanitizer', sanitizer, '--target-dir', built(sanitizer)]);

const found = chosen.filter((name) => fuzz(name, Number(runs ?? runsOf[name] ?? 1e6)) !== 0);
if (found.length > 0) fail(`Findings in ${found.join(', ')}: see fuzz/artifacts.`);
console.log(`\nNo findings in ${chosen.join(', ')}.`);

/** Fuzzes one target and returns the exit code of its program. */
function fuzz(name, count) {
  for (const part of ['corpus', 'artifacts']) mkdirSync(join(folder, part, name), { recursive: true });
  const binary = join(built(sanitizerOf(name)), 'x86_64-unknown-linux-gnu', 'release', 'fuzz');
  const args = argumentsOf(name, count);
  console.log(`\n$ ${name} ${args.join(' ')}`);
  return spawnSync(binary, args, { stdio: 'inherit', env: environment({ RUST_BACKTRACE: '1', TRACECUT_TARGET: name }) })
    .status;
}

function argumentsOf(name, count) {
  const dictionary = join(folder, 'dictionaries', `${name}.dict`);
  return [
    join(folder, 'corpus', name),
    join(folder, 'seeds', name),
    `-artifact_prefix=${join(folder, 'artifacts', name)}/`,
    `-runs=${count}`,
    `-max_len=${lengthOf[name] ?? 4096}`,
    '-rss_limit_mb=2048',
    `-timeout=${name in runsOf ? 60 : 20}`,
    '-print_final_stats=1',
    ...(existsSync(dictionary) ? [`-dict=${dictionary}`] : []),
  ];
}
