// `npm run api` writes docs/api.txt, the public interface of the Rust library, a line for each item;
// `npm run api -- --check` fails where the sources say otherwise, so that no change of it goes unseen.

import { existsSync, readFileSync, writeFileSync } from 'node:fs';
import { join } from 'node:path';
import { parseArgs } from 'node:util';
import { listApi } from './api/list.mjs';
import { describeProject } from './api/rustdoc.mjs';
import { ensureRust, fail, root } from './tools.mjs';

/** Most public items: each is a promise. Lower it when there are fewer. */
const MOST_ITEMS = 250;

const file = join(root, 'docs', 'api.txt');
const { check } = options();
ensureRust();
const { lines, count } = listApi(describeProject());
const text = `${lines.join('\n')}\n`;
console.log(`${count} public items (at most ${MOST_ITEMS}).`);
if (count > MOST_ITEMS) fail(`These are ${count - MOST_ITEMS} too many: make what no user needs pub(crate).`);
if (check) compare(existsSync(file) ? readFileSync(file, 'utf8').replaceAll('\r', '').split('\n') : []);
else writeFileSync(file, text);

/** Ends the script where the listing differs from the sources, with the lines that differ. */
function compare(listed) {
  const gone = listed.filter((line) => line && !lines.includes(line)).map((line) => `- ${line}`);
  const come = lines.filter((line) => !listed.includes(line)).map((line) => `+ ${line}`);
  if (gone.length + come.length === 0) return;
  fail(`The public interface is not that of docs/api.txt:\n${[...gone, ...come].join('\n')}
If this is meant: npm run api, and a line in CHANGELOG.md.`);
}

function options() {
  try {
    return parseArgs({ options: { check: { type: 'boolean', default: false } } }).values;
  } catch (error) {
    return fail(`${error.message}\nUsage: npm run api -- [--check]`);
  }
}
