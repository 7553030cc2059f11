// `npm run api` writes docs/api.txt, the public interface of the Rust library as the crate public-api lists it;
// `npm run api -- --check` fails where the sources say otherwise, so that no change of it goes unseen.

import { existsSync, readFileSync, writeFileSync } from 'node:fs';
import { join } from 'node:path';
import { parseArgs } from 'node:util';
import { ensureOwnTool, ensureRust, fail, output, ownTool, root, run } from './tools.mjs';

/** Most public items: each is a promise. Lower it when there are fewer. */
const MOST_ITEMS = 266;

/** What counts: all that the documentation has a heading for. Methods that a trait asks for have none. */
const ITEM = /^(?:#\[\w+\] )*pub (?:const |async )*(mod|struct|enum|union|trait|fn|const|static|type|macro) ([\w:]+)/;

const file = join(root, 'docs', 'api.txt');
const { check } = options();
ensureRust();
await ensureOwnTool('api');
const json = ['--', '-Z', 'unstable-options', '--output-format', 'json'];
run('cargo', ['rustdoc', '--quiet', '--locked', '--lib', ...json], { env: { RUSTDOC: ownTool('api') } });
const { lines, count } = listed(output('api', [join('target', 'doc', 'tracecut.json')]));
console.log(`${count} public items (at most ${MOST_ITEMS}).`);
if (count > MOST_ITEMS) fail(`These are ${count - MOST_ITEMS} too many: make what no user needs pub(crate).`);
if (check) compare(existsSync(file) ? readFileSync(file, 'utf8').replaceAll('\r', '').split('\n') : []);
else writeFileSync(file, `${lines.join('\n')}\n`);

/** The lines of a listing without the methods of traits, each once, and the items: of two names of one type the first. */
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

/** Ends the script where the listing differs from the sources, with the lines that differ. */
function compare(before) {
  const gone = before.filter((line) => line && !lines.includes(line)).map((line) => `- ${line}`);
  const come = lines.filter((line) => !before.includes(line)).map((line) => `+ ${line}`);
  if (gone.length + come.length === 0) return;
  fail(`The public interface differs from docs/api.txt:\n${[...gone, ...come].join('\n')}
If this is meant: npm run api, and a line in CHANGELOG.md.`);
}

function options() {
  try {
    return parseArgs({ options: { check: { type: 'boolean', default: false } } }).values;
  } catch (error) {
    return fail(`${error.message}\nUsage: npm run api -- [--check]`);
  }
}
