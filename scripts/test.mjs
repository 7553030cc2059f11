// `npm test`: the tests for every change. Sets up what is missing first, then runs test files in parallel.
//
//   npm test [-- PART ...] [--slowest N]     parts: rust, wasm, node, browser, python
//   npm run test:fast [PATTERN]                             the tests an edit most likely breaks, or the files that match
//   npm run test:long [PART ...]                            the slow tests

import { availableParallelism } from 'node:os';
import { parseArgs } from 'node:util';
import { fastTasks } from './test/fast.mjs';
import { longTasks } from './test/long.mjs';
import { clock, runAll } from './test/pool.mjs';
import { PARTS, tasksOf } from './test/tasks.mjs';
import { ensureNodeModules, ensureRust, fail } from './tools.mjs';

const { mode, words, count } = options();
ensureNodeModules();
ensureRust();
const cores = availableParallelism();
const tasks = chosenTasks();
if (tasks.length === 0) fail(`No test file matches ${words.join(' ')}.`);
printPlan();
const closeBrowser = await useOneBrowser(tasks);
const start = Date.now();
const outcomes = await runAll(tasks, cores);
await closeBrowser();
report();

/**
 * Starts one browser and one server per sample if a task needs them; tests find them by the environment (tests/site.mjs).
 *
 * @param {import('./test/pool.mjs').Task[]} tasks
 * @returns {Promise<() => Promise<void>>} stops them
 */
async function useOneBrowser(tasks) {
  if (!tasks.some(({ part }) => part === 'browser')) return async () => {};
  const { ensureBrowser, shareBrowser } = await import('./browser.mjs');
  const { shareSites } = await import('../tests/site.mjs');
  ensureBrowser();
  const browser = await shareBrowser();
  process.env.TRACECUT_BROWSER = browser.wsEndpoint();
  let sites;
  // The site is written from the package, which is built before the first of these starts.
  for (const task of tasks.filter(({ part }) => part === 'browser')) {
    const { start } = task;
    task.start = async () => {
      await (sites ??= shareSites());
      return start();
    };
  }
  return async () => {
    await browser.close();
    await (
      await sites
    )?.();
  };
}

function options() {
  try {
    const { values, positionals } = parseArgs({
      options: { slowest: { type: 'string', default: '0' } },
      allowPositionals: true,
    });
    const [first, ...rest] = positionals;
    const isMode = ['fast', 'long'].includes(first);
    return {
      mode: isMode ? first : 'all',
      words: isMode ? rest : positionals,
      count: Number(values.slowest),
    };
  } catch (error) {
    return fail(`${error.message}\nUsage: npm test -- [PART ...] [--slowest N]`);
  }
}

function chosenTasks() {
  if (mode === 'fast') return fastTasks(words);
  if (mode === 'long') return longTasks(words);
  const unknown = words.find((name) => !(name in PARTS));
  if (unknown) fail(`There is no part "${unknown}" (expected ${Object.keys(PARTS).join(', ')}).`);
  return tasksOf(words.length > 0 ? words : Object.keys(PARTS));
}

/** Prints the plan. */
function printPlan() {
  const parts = new Map();
  for (const { part } of tasks) parts.set(part, (parts.get(part) ?? 0) + 1);
  const list = [...parts].map(([part, number]) => (part === 'build' ? `${number} builds` : `${number} of ${part}`));
  console.log(`${tasks.length} tasks (${list.join(', ')}) on ${cores} cores`);
}

function report() {
  if (count > 0) console.log(`\nThe slowest:\n${slowest(count)}`);
  const sum = (key) => outcomes.reduce((total, { counts }) => total + counts[key], 0);
  const failed = outcomes.filter((outcome) => outcome.failed);
  if (failed.length > 0) console.log(`\nFAILED:\n${failed.map(({ task }) => `  ${task.name}`).join('\n')}`);
  const missed = Math.max(sum('failed'), failed.length);
  console.log(
    `\nIn ${clock(Date.now() - start)} minutes:\n${sum('passed')} passed, ${missed} failed, ${sum('skipped')} skipped`,
  );
  if (failed.length > 0) process.exit(1);
}

/** Returns the slowest tasks as a table. */
function slowest(count) {
  const sorted = [...outcomes].sort((a, b) => b.seconds - a.seconds).slice(0, count);
  return sorted.map(({ task, seconds }) => `${seconds.toFixed(1).padStart(7)} s  ${task.name}`).join('\n');
}
