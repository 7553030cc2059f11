// The table of faults in docs/reliability.md: each row has tests, and they are there.

import assert from 'node:assert/strict';
import { existsSync, readFileSync } from 'node:fs';
import { join } from 'node:path';
import { test } from 'node:test';
import { root } from '../../scripts/tools.mjs';

const read = (name) => readFileSync(join(root, name), 'utf8').replaceAll('\r', '');

/** The rows of the table of faults, as lists of cells. */
function rows() {
  const section = read('docs/reliability.md').split('\n## Faults\n')[1].split('\n## ')[0];
  const lines = section.split('\n').filter((line) => line.startsWith('| ') && !line.startsWith('| fault |'));
  return lines.map((line) => line.slice(2, -2).split(' | '));
}

/** The tests that a cell names: `file`: name; name · `file`: name. */
const named = (cell) =>
  cell.split(' · ').flatMap((part) => {
    const [, file, names] = /^`([^`]+)`: (.*)$/.exec(part) ?? assert.fail(`no test: ${part}`);
    return names.split('; ').map((name) => [file, name]);
  });

/** The names of a file's tests, those with values in them too. */
function testsOf(file) {
  const pattern = file.endsWith('.rs') ? /\bfn (\w+)\(\)/g : /\btest\(\s*(["'`])(.*?)\1/gs;
  return [...read(file).matchAll(pattern)].map((found) => found.at(-1).replaceAll('\\', ''));
}

test('each fault says what is kept, and has tests that exist', () => {
  const all = rows();
  assert.ok(all.length >= 15, `${all.length} rows`);
  for (const row of all) {
    const [fault, where, kept, tests] = row;
    assert.equal(row.length, 4, fault);
    assert.ok(where && kept.length > 20, fault);
    for (const [file, name] of named(tests)) {
      assert.ok(existsSync(join(root, file)), `${fault}: there is no ${file}`);
      assert.ok(
        testsOf(file).some((title) => title.includes(name)),
        `${fault}: ${file} has no test "${name}"`,
      );
    }
  }
});

test('memory over time was measured, and is flat', () => {
  const [, table] = /<!-- soak: .*? -->\n([\s\S]*?)<!-- \/soak -->/.exec(read('docs/reliability.md'));
  const lines = table.split('\n').filter((line) => /^\| (sessions|crowd|windows|page) /.test(line));
  assert.equal(lines.length, 4);
  for (const line of lines) {
    const [heap] = line.split('|').at(-2).split(',').map(Number);
    assert.ok(heap < 1024, line);
  }
  assert.ok(existsSync(join(root, 'docs', 'soak.svg')));
});
