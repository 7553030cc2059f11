#!/usr/bin/env node
// `npx tracecut`: the program of the npm package. Clips are segmented by the program of the crate `tracecut-cli`.

import { version } from '../node.js';
import { selftest } from './selftest.js';
import type { SelftestCheck } from '../selftest/run.js';

const USAGE = `tracecut ${version}, the program of the npm package

  tracecut selftest    check that this machine computes what every other does
  tracecut --version   print the version

Clips are segmented on the command line by the program of the crate tracecut-cli:
cargo install --locked tracecut-cli; in a clone of the repository, cargo install --locked --path cli`;

const REPORT = 'please report this machine and this list at https://github.com/tracecut/tracecut/issues';

/** Prints each hash and compares it with the expected one. */
async function runSelftest() {
  console.log(`tracecut ${version} in Node ${process.versions.node} on ${process.platform} ${process.arch}`);
  const onCheck = ({ name, what, hash, expected, same }: SelftestCheck) =>
    console.log(`${name.padEnd(16)} ${hash}  ${same ? 'same' : `DIFFERENT from ${expected}`}  (${what})`);
  const { same, checks } = await selftest({ onCheck });
  if (same) return console.log(`All ${checks.length} hashes are those of every other machine and engine.`);
  const count = checks.filter((check) => !check.same).length;
  console.error(`error: ${count} of ${checks.length} hashes differ: ${REPORT}`);
  process.exitCode = 1;
}

const [command, ...others] = process.argv.slice(2);
if (command === 'selftest' && others.length === 0) await runSelftest();
else if (command === '--version' || command === '-V') console.log(version);
else if (command === undefined || command === '--help' || command === '-h') console.log(USAGE);
else {
  console.error(`error: there is no command "${[command, ...others].join(' ')}"\n\n${USAGE}`);
  process.exitCode = 2;
}
