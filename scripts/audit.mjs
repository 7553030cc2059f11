// `npm run audit`: checks the crates and npm packages that the project uses. Licences, bans and sources of crates are
// checked offline (deny.toml); advisories need a network, and the report says if there is none. `--install` first builds
// cargo-deny if it is missing (a few minutes), `--strict` fails if anything could not be checked.

import { spawnSync } from 'node:child_process';
import { pathToFileURL } from 'node:url';
import { LIBRARIES } from './licences.mjs';
import { ensureRustTool, environment, fail, hasRustTool, root } from './tools.mjs';

/**
 * The outcome of one check; `open` means it could not be made, and `words` say why.
 * @typedef {{question: string, state: 'clean' | 'found' | 'open', words: string}} Answer
 */

/** Timeout for an advisory database or a registry. */
const TIMEOUT_MS = 30_000;
const NO_RETRIES = ['--fetch-retries=0', '--fetch-timeout=15000'];
const NO_DATABASE = /failed to (fetch|open|load) advisory database|unable to access|failed to clone/i;

/** @returns {Answer[]} */
function cratesAnswers() {
  if (!hasRustTool('cargo-deny'))
    return [{ question: 'crates', state: 'open', words: 'cargo-deny is not installed (npm run audit -- --install)' }];
  return ['licenses', 'bans', 'sources', 'advisories'].map((check) => {
    const { status, stderr, error } = ask('cargo', ['deny', '--locked', '--workspace', 'check', check]);
    return { question: `crates: ${check}`, ...crateAnswer(status, `${error?.message ?? ''}${stderr}`) };
  });
}

/**
 * @param {number | null} status of `cargo deny check`
 * @param {string} said
 * @returns {Pick<Answer, 'state' | 'words'>}
 */
export function crateAnswer(status, said) {
  if (status === 0) return { state: 'clean', words: '' };
  if (status === null || NO_DATABASE.test(said)) return { state: 'open', words: lastLine(said) };
  return { state: 'found', words: said.trim() };
}

/** @returns {Answer[]} */
function packagesAnswers() {
  const { stdout } = ask('npm', ['audit', '--json', ...NO_RETRIES]);
  const within = packageAnswer(stdout, (name) => LIBRARIES.includes(name));
  return [
    { question: `npm packages within ours (${LIBRARIES})`, ...within },
    // Development tools only read our own files: reported, but not a fault.
    { question: 'npm packages of the development', ...asReport(packageAnswer(stdout, () => true)) },
  ];
}

/**
 * @param {string} json what `npm audit --json` says
 * @param {(name: string) => boolean} counts
 * @returns {Pick<Answer, 'state' | 'words'>}
 */
export function packageAnswer(json, counts) {
  const report = parsed(json);
  if (!report?.vulnerabilities) return { state: 'open', words: report?.message ?? 'npm gives no answer' };
  const found = Object.values(report.vulnerabilities).filter(({ name }) => counts(name));
  if (found.length === 0) return { state: 'clean', words: '' };
  return {
    state: 'found',
    words: found.map(({ name, severity, range }) => `${name} ${range}: ${severity}`).join('\n'),
  };
}

/** @param {Pick<Answer, 'state' | 'words'>} answer */
function asReport({ state, words }) {
  return state === 'found' ? { state: 'clean', words: `(reported, not a fault)\n${words}` } : { state, words };
}

/** @param {string} json */
function parsed(json) {
  try {
    return JSON.parse(json);
  } catch {
    return null;
  }
}

/** @param {string} command @param {string[]} args */
function ask(command, args) {
  const shell = process.platform === 'win32';
  const options = { cwd: root, env: environment(), encoding: 'utf8', timeout: TIMEOUT_MS, shell };
  return spawnSync(command, args, /** @type {const} */ (options));
}

/** @param {string} said */
function lastLine(said) {
  return said.trim().split('\n').pop() || 'no answer in time';
}

if (import.meta.url === pathToFileURL(process.argv[1] ?? '').href) {
  if (process.argv.includes('--install')) ensureRustTool('cargo-deny');
  const marks = { clean: 'clean', found: '!!! FOUND', open: '!!! NOT CHECKED' };
  const answers = [...cratesAnswers(), ...packagesAnswers()];
  for (const { question, state, words } of answers) console.log(`${question}: ${marks[state]} ${words}`.trim());
  const bad = process.argv.includes('--strict') ? ['found', 'open'] : ['found'];
  const faults = answers.filter(({ state }) => bad.includes(state));
  if (faults.length > 0) fail(`Not clean: ${faults.map(({ question }) => question).join('; ')}.`);
}
