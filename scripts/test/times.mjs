// How long each file of tests takes: what was measured on an idle machine, in tests/times.json, and tables of it.

import { existsSync, readFileSync, writeFileSync } from 'node:fs';
import { join } from 'node:path';
import { root } from '../tools.mjs';

const file = join(root, 'tests', 'times.json');
/** What a file is taken to need that nobody has measured yet, in seconds. */
const UNKNOWN = 5;

/** @returns {Record<string, number>} seconds by the task's name, on two idle cores */
export function knownTimes() {
  return existsSync(file) ? JSON.parse(readFileSync(file, 'utf8')) : {};
}

export const secondsOf = (times) => (name) => times[name] ?? UNKNOWN;

/** Keeps what a run measured, for the next to plan with. @param {import('./pool.mjs').Outcome[]} outcomes */
export function keepTimes(outcomes) {
  const measured = outcomes.map(({ task, seconds }) => [task.name, Number(seconds.toFixed(1))]);
  const times = Object.entries({ ...knownTimes(), ...Object.fromEntries(measured) });
  const lines = times
    .sort(([a], [b]) => (a < b ? -1 : 1))
    .map(([name, seconds]) => `  ${JSON.stringify(name)}: ${seconds}`);
  writeFileSync(file, `{\n${lines.join(',\n')}\n}\n`);
}

/** The slowest of a run, as a table. */
export function slowest(outcomes, count) {
  const sorted = [...outcomes].sort((a, b) => b.seconds - a.seconds).slice(0, count);
  return sorted.map(({ task, seconds }) => `${seconds.toFixed(1).padStart(7)} s  ${task.name}`).join('\n');
}

/** The least time that tasks take on `cores` cores: the busiest of the cores' sum and the longest way through. */
export function estimate(tasks, cores) {
  const work = tasks.reduce((sum, { seconds, cores: wanted }) => sum + seconds * Math.min(wanted, cores), 0) / cores;
  const end = new Map();
  const endOf = (task) => {
    if (!end.has(task.name)) {
      const before = tasks.filter(({ name }) => task.after.includes(name));
      end.set(task.name, task.seconds + Math.max(0, ...before.map(endOf)));
    }
    return end.get(task.name);
  };
  return Math.max(work, ...tasks.map(endOf));
}
