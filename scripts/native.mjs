// `node scripts/native.mjs build|test|clippy ...` builds, tests or lints the native crates with Cargo, always the same set of
// them: another set has other features, and all dependencies would be compiled again. The Python module is one of them where
// Python is installed.

import { pathToFileURL } from 'node:url';
import { output, run } from './tools.mjs';

/** Returns whether Python 3.9 or later with venv is installed. */
export function hasPython() {
  return output('python3', ['-c', 'import sys, venv, ensurepip; sys.exit(sys.version_info < (3, 9))']) !== null;
}

/** Returns the arguments of `cargo` for a command on the native crates. */
export function nativeArguments(command, ...args) {
  const crates = ['tracecut', 'tracecut-cli', 'tracecut-bench', ...(hasPython() ? ['tracecut-python'] : [])];
  const packages = crates.flatMap((name) => ['--package', name]);
  return [command, '--locked', ...packages, '--features', 'tracecut/pnm', ...args];
}

if (import.meta.url === pathToFileURL(process.argv[1] ?? '').href) {
  const [command, ...args] = process.argv.slice(2);
  const targets = command === 'build' ? ['--lib', '--bins', '--tests', '--examples'] : [];
  run('cargo', nativeArguments(command, ...targets, ...args));
}
