// The tasks of `npm run test:fast`: within a minute after an edit in `src`, within ten seconds after one in JavaScript.

import { readdirSync } from 'node:fs';
import { join } from 'node:path';
import { output, root } from '../tools.mjs';
import { PARTS, tasksOf } from './tasks.mjs';

/** Without a pattern: fast tests that fail for most mistakes. */
const OF_SRC = ['src, unit tests', 'tests/node/golden.test.mjs'];
/** The slowest module of unit tests; other tests mostly fail together with it. */
const SLOWEST = 'session::drive::windows_tests';
const OF_SCRIPTS = ['session', 'video-driver', 'export', 'edit', 'repository'].map(
  (name) => `tests/node/${name}.test.mjs`,
);

/**
 * @param {string[]} words the pattern: part of the name of a file, Rust module or test; without one, the changes since the
 *   last commit decide
 * @returns {import('./pool.mjs').Task[]}
 */
export function fastTasks([pattern]) {
  const all = tasksOf(Object.keys(PARTS), { fast: true });
  const chosen = pattern ? all.filter(matching(pattern)) : all.filter(({ name }) => usual().includes(name));
  const needed = new Set(chosen.flatMap(({ after }) => after));
  for (const { name, after } of all) if (needed.has(name)) after.forEach((before) => needed.add(before));
  const which = pattern ? [pattern.replaceAll('/', '::')] : ['--skip', SLOWEST];
  const narrowed = chosen.map((task) => unitTests(task, which));
  return [...all.filter(({ name }) => needed.has(name)), ...narrowed];
}

const matching =
  (pattern) =>
  ({ name, part }) =>
    part !== 'build' && (name.includes(pattern) || (name === 'src, unit tests' && namesModule(pattern)));

/** Returns whether the name of a Rust module or unit test contains the pattern. */
function namesModule(pattern) {
  const modules = readdirSync(join(root, 'src'), { recursive: true }).map((name) => name.replace(/\.rs$/, ''));
  const path = pattern.replaceAll('::', '/');
  return modules.some((name) => name.includes(path)) || output('git', ['grep', '-l', `fn ${pattern}`, 'src']) !== null;
}

/** Restricts the library's unit tests to the ones that the arguments choose. */
function unitTests(task, which) {
  if (task.name !== 'src, unit tests') return task;
  const start = async () => {
    const command = await task.start();
    return { ...command, args: [...command.args, ...which] };
  };
  return { ...task, start };
}

function usual() {
  const changed = changedFiles(output('git', ['status', '--porcelain', '--no-renames']) ?? '');
  const inRust = changed.some((file) => /^(src|tests\/.*\.rs|Cargo)/.test(file));
  const inScripts = changed.some((file) => /^(npm|studio|www)\//.test(file));
  return [...(inRust || !inScripts ? OF_SRC : []), ...(inScripts || !inRust ? OF_SCRIPTS : [])];
}

/** Returns the files that `git status --porcelain` names, even if the space before its first row is cut off. */
export function changedFiles(status) {
  return status
    .split('\n')
    .map((row) => row.trim().replace(/^\S+ +/, ''))
    .filter(Boolean);
}
