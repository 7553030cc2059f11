// `npm run fuzz -- TARGET|all [RUNS]`: fuzzes with libFuzzer, and prints what came of it. What reads files goes with the
// address sanitizer; whole runs go without it, at twice the speed, unless TRACECUT_SANITIZER=address.
// Needs the nightly compiler (`rustup toolchain install nightly`); cargo-fuzz is built into .tools when it is missing.
// What is found lies in fuzz/artifacts, what covers more in fuzz/corpus, the output of each run in fuzz/logs.

import { spawn } from 'node:child_process';
import { createWriteStream, existsSync, mkdirSync, readdirSync } from 'node:fs';
import { join } from 'node:path';
import { ensureRustTool, environment, fail, output, root, run } from './tools.mjs';

const folder = join(root, 'fuzz');
const targets = readdirSync(join(folder, 'targets')).map((name) => name.replace('.rs', ''));

/** How often each is run, and how long its input may be, where that is not 1,000,000 times and 4 KiB. */
const runsOf = {
  session: 20000,
  corrections: 20000,
  halves: 20000,
  windows: 20000,
  image: 50000,
  outside_tracks: 20000,
};
/** Of these the code is ours, which has no `unsafe`; `npm run test:long` runs the native tests with the sanitizer. */
const sanitizerOf = (name) => process.env.TRACECUT_SANITIZER ?? (name in runsOf ? 'none' : 'address');
const built = (name) => join(folder, 'target', sanitizerOf(name));
const lengthOf = { image_file: 16384, gif: 8192, y4m: 2048, flo: 1024, setting: 128, bmf: 512 };

const [target, runs] = process.argv.slice(2);
const chosen = target === 'all' ? targets : [target];
if (!chosen.every((name) => targets.includes(name)) || (runs !== undefined && !(Number(runs) > 0)))
  fail(`Usage: npm run fuzz -- all|${targets.join('|')} [RUNS]`);
if (process.platform !== 'linux' || process.arch !== 'x64') fail('Fuzzing is set up for Linux on x86-64 only.');
if (output('rustc', ['+nightly', '--version']) === null)
  fail('The nightly compiler was not found: rustup toolchain install nightly --profile minimal');
ensureRustTool('cargo-fuzz');
for (const name of chosen) {
  const options = ['--sanitizer', sanitizerOf(name), '--target-dir', built(name)];
  run('cargo', ['+nightly', 'fuzz', 'build', name, ...options]);
}

const rows = [];
for (const name of chosen) rows.push(await fuzz(name, Number(runs ?? runsOf[name] ?? 1e6)));
console.log(`\n| target | executions | edges | seconds | found |\n|---|---:|---:|---:|---|\n${rows.join('\n')}`);

/** Fuzzes one target; gives its row of the table. */
async function fuzz(name, count) {
  for (const part of ['corpus', 'artifacts', 'logs'].map((part) => join(folder, part)))
    mkdirSync(part.endsWith('logs') ? part : join(part, name), { recursive: true });
  const log = createWriteStream(join(folder, 'logs', `${name}.log`));
  const begin = Date.now();
  let last = '';
  const status = await spawned(name, argumentsOf(name, count), (text) => {
    log.write(text);
    last = (last + text).slice(-20000);
  });
  log.end();
  const number = (pattern) => Number([...last.matchAll(pattern)].at(-1)?.[1] ?? 0).toLocaleString('en');
  const executions = number(/^(?:#|stat::number_of_executed_units: *)(\d+)/gm);
  const seconds = Math.round((Date.now() - begin) / 1000).toLocaleString('en');
  const found = status === 0 ? 'nothing' : (/^SUMMARY: .*$/m.exec(last)?.[0] ?? `exit code ${status}`);
  if (status !== 0) process.exitCode = 1;
  return `| \`${name}\` | ${executions} | ${number(/ cov: (\d+)/g)} | ${seconds} | ${found} |`;
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

/** Runs a target's binary, tells `hear` of its output, and shows what is not a line of its pulse. */
function spawned(name, args, hear) {
  console.log(`\n$ ${name} ${args.join(' ')}`);
  return new Promise((resolve) => {
    const binary = join(built(name), 'x86_64-unknown-linux-gnu', 'release', name);
    const child = spawn(binary, args, { env: environment({ RUST_BACKTRACE: '1' }) });
    child.stderr.setEncoding('utf8').on('data', (text) => {
      hear(text);
      const told = text.split('\n').filter((line) => line !== '' && !/^#\d+\s+(?:NEW|REDUCE|RELOAD)/.test(line));
      if (told.length > 0) console.log(told.join('\n'));
    });
    child.stdout.resume();
    child.on('close', resolve);
  });
}
