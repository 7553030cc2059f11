// Runs tasks in parallel, as many as there are cores for, and reports progress.

import { spawn } from 'node:child_process';
import { mkdirSync, writeFileSync } from 'node:fs';
import { join } from 'node:path';
import { environment, root } from '../tools.mjs';

/**
 * @typedef {object} Task
 * @property {string} name
 * @property {string} part the part of the tests it belongs to
 * @property {number} cores number of cores it keeps busy
 * @property {string} [lock] tasks with the same lock run one at a time
 * @property {string[]} after names of tasks that must be done before
 * @property {() => Command | Promise<unknown>} start its command, or its work
 * @typedef {{command: string, args: string[], cwd?: string, env?: Record<string, string>}} Command
 * @typedef {{task: Task, seconds: number, failed: boolean, output: string, counts: Counts}} Outcome
 * @typedef {{passed: number, failed: number, skipped: number}} Counts
 */

/** After this long without output, a line lists the running tasks. */
const SILENCE_MS = 15_000;
const LONGEST_LINE = 300;
const LOGS = join(root, 'out', 'tests');

/**
 * Runs all tasks. A failed task shows its output at once; tasks that depend on it are skipped.
 *
 * @param {Task[]} tasks
 * @param {number} cores
 * @returns {Promise<Outcome[]>} in the order in which they ended
 */
export async function runAll(tasks, cores) {
  mkdirSync(LOGS, { recursive: true });
  const names = new Set(tasks.map(({ name }) => name));
  const waiting = [...tasks].sort((a, b) => chainAfter(b, tasks) - chainAfter(a, tasks));
  const running = new Map();
  const outcomes = [];
  const done = new Set();
  const lost = new Set();
  const started = Date.now();
  let spoken = started;
  const say = (line) => {
    spoken = Date.now();
    console.log(`[${clock(spoken - started)}] ${line}`);
  };
  const timer = setInterval(() => {
    if (Date.now() - spoken < SILENCE_MS) return;
    const now = [...running.values()].map(({ task, since }) => `${task.name} (${clock(Date.now() - since)})`);
    say(`running: ${now.join(', ')}`);
  }, 1000);

  const free = () => cores - [...running.values()].reduce((sum, { task }) => sum + Math.min(task.cores, cores), 0);
  const isReady = (task) => task.after.every((name) => done.has(name) || !names.has(name));
  while (waiting.length > 0 || running.size > 0) {
    for (const task of waiting.filter(({ after }) => after.some((name) => lost.has(name)))) {
      waiting.splice(waiting.indexOf(task), 1);
      lost.add(task.name);
      outcomes.push(left(task));
      say(`LEFT OUT ${task.name}: it needs ${task.after.find((name) => lost.has(name))}`);
    }
    for (const task of waiting.filter(isReady)) {
      if (task.lock && [...running.values()].some((other) => other.task.lock === task.lock)) continue;
      if (running.size > 0 && free() + 1e-9 < Math.min(task.cores, cores)) continue;
      waiting.splice(waiting.indexOf(task), 1);
      running.set(task.name, { task, since: Date.now(), end: perform(task) });
    }
    if (running.size === 0) continue;
    const outcome = await Promise.race([...running.values()].map(({ end }) => end));
    running.delete(outcome.task.name);
    outcomes.push(outcome);
    (outcome.failed ? lost : done).add(outcome.task.name);
    say(line(outcome, `${outcomes.length}/${tasks.length}`));
    if (outcome.failed) console.log(`\n${shortened(outcome.output)}\n`);
    for (const note of outcome.output.matchAll(/^.*(!!! .*)$/gm)) console.log(`    ${note[1]}`);
  }
  clearInterval(timer);
  return outcomes;
}

/** Returns the length of the longest chain of tasks that depend on this one; long chains start first. */
function chainAfter({ name }, tasks) {
  const followers = tasks.filter(({ after }) => after.includes(name));
  return Math.max(0, ...followers.map((follower) => 1 + chainAfter(follower, tasks)));
}

async function perform(task) {
  const since = Date.now();
  const { output, failed } = await attempt(task);
  writeFileSync(join(LOGS, `${task.name.replaceAll(/[^\w.-]+/g, '-')}.log`), output);
  return { task, seconds: (Date.now() - since) / 1000, output, failed, counts: countsIn(output) };
}

async function attempt(task) {
  try {
    const command = await task.start();
    return typeof command === 'object' ? await execute(command) : { output: '', failed: false };
  } catch (error) {
    return { output: String(error.stack ?? error), failed: true };
  }
}

/** Runs a command and returns its output. @param {Command} command */
export function execute({ command, args, cwd = root, env = {} }) {
  return new Promise((resolve) => {
    const child = spawn(command, args, { cwd, env: environment(env), stdio: ['ignore', 'pipe', 'pipe'] });
    const pieces = [`$ ${command} ${args.join(' ')}\n`];
    for (const stream of [child.stdout, child.stderr]) stream.on('data', (piece) => pieces.push(String(piece)));
    child.on('error', (error) => resolve({ output: `${pieces.join('')}${error.message}\n`, failed: true }));
    child.on('close', (code) => resolve({ output: pieces.join(''), failed: code !== 0 }));
  });
}

/** Counts the tests in the output of Node's runner, Cargo or pytest. @returns {Counts} */
export function countsIn(output) {
  const sum = (...patterns) =>
    patterns.flatMap((pattern) => [...output.matchAll(pattern)]).reduce((total, [, count]) => total + Number(count), 0);
  return {
    passed: sum(
      /^\W* pass (\d+)$/gm,
      /^test result: .*? (\d+) passed/gm,
      /^(?!test result).*?\b(\d+) passed\b.* in [\d.:]+/gm,
    ),
    failed: sum(
      /^\W* fail (\d+)$/gm,
      /^test result: .*? (\d+) failed/gm,
      /^(?!test result).*?\b(\d+) failed\b.* in [\d.:]+/gm,
    ),
    skipped: sum(
      /^\W* skipped (\d+)$/gm,
      /^test result: .*? (\d+) ignored/gm,
      /^(?!test result).*?\b(\d+) skipped\b.* in [\d.:]+/gm,
    ),
  };
}

function left(task) {
  return { task, seconds: 0, failed: true, output: '', counts: { passed: 0, failed: 0, skipped: 0 } };
}

function line({ task, seconds, failed, counts }, place) {
  const { passed, skipped } = counts;
  const said = [passed > 0 ? `${passed} passed` : '', skipped > 0 ? `${skipped} skipped` : ''].filter(Boolean);
  return `${place} ${failed ? 'FAILED' : 'ok'} ${task.name}, ${seconds.toFixed(1)} s${said.length > 0 ? ` (${said.join(', ')})` : ''}`;
}

/** Shortens long lines; `out/tests/` has the full output. */
function shortened(output) {
  const lines = output.trimEnd().split('\n');
  return lines.map((one) => (one.length > LONGEST_LINE ? `${one.slice(0, LONGEST_LINE)} …` : one)).join('\n');
}

/** Formats minutes and seconds. */
export function clock(ms) {
  const seconds = Math.round(ms / 1000);
  return `${Math.floor(seconds / 60)}:${String(seconds % 60).padStart(2, '0')}`;
}
