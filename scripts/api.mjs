// `npm run api` writes docs/api.txt, the public interface of the Rust library as the crate public-api lists it;
// `npm run api -- --check` fails if the sources differ, so that no change goes unnoticed.

import { existsSync, readFileSync, writeFileSync } from 'node:fs';
import { join } from 'node:path';
import { parseArgs } from 'node:util';
import { ensureOwnTool, ensureRust, fail, output, ownTool, root, run } from './tools.mjs';

/** Maximum number of public items, as each is a promise. Lower it when there are fewer. */
const MAX_ITEMS = 200;

/** The counted items: those with a heading in the documentation. Trait methods have none. */
const ITEM = /^(?:#\[\w+\] )*pub (?:const |async )*(mod|struct|enum|union|trait|fn|const|static|type|macro) ([\w:]+)/;

const file = join(root, 'docs', 'api.txt');
const { check } = options();
ensureRust();
await ensureOwnTool('api');
const json = ['--', '-Z', 'unstable-options', '--output-format', 'json'];
run('cargo', ['rustdoc', '--quiet', '--locked', '--lib', ...json], { env: { RUSTDOC: ownTool('api') } });
const { lines, count } = listed(output('api', [join('target', 'doc', 'tracecut.json')]));
console.log(`${count} public items (at most ${MAX_ITEMS}).`);
if (count > MAX_ITEMS) fail(`These are ${count - MAX_ITEMS} too many: make what no user needs pub(crate).`);
if (check) compare(existsSync(file) ? readFileSync(file, 'utf8').replaceAll('\r', '').split('\n') : []);
else writeFileSync(file, `${lines.join('\n')}\n`);

/** Returns the distinct lines of a listing without trait methods, and the items; a type with two names counts once. */
function listed(listing) {
  const [lines, items] = [new Set(), new Set()];
  let implementing = '';
  for (const line of listing.split('\n')) {
    const [, kind, name] = ITEM.exec(line.replace(/<[^>]*>(?=::)/g, '')) ?? [];
    if (/^(unsafe )?impl\b/.test(line)) implementing = / for ([\w:]+)/.exec(line)?.[1] ?? '';
    if (implementing && name?.startsWith(`${implementing}::`)) continue;
    lines.add(line);
    if (kind) items.add(['struct', 'enum'].includes(kind) ? name.split('::').at(-1) : line);
  }
  return { lines: [...lines], count: items.size };
}

/** Ends the script if the listing differs from the sources, and prints the differences. */
function compare(previous) {
  const removed = previous.filter((line) => line && !lines.includes(line)).map((line) => `- ${line}`);
  const added = lines.filter((line) => !previous.includes(line)).map((line) => `+ ${line}`);
  if (removed.length + added.length === 0) return;
  fail(`The public interface differs from docs/api.txt:\n${[...removed, ...added].join('\n')}
If this is intended: npm run api, and a line in CHANGELOG.md.`);
}

function options() {
  try {
    return parseArgs({ options: { check: { type: 'boolean', default: false } } }).values;
  } catch (error) {
    return fail(`${error.message}\nUsage: npm run api -- [--check]`);
  }
}
