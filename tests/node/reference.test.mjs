// The API reference: that it is what the package declares, that nothing public lacks a description, and the reader that
// it is made with.

import assert from 'node:assert/strict';
import { readFileSync, writeFileSync } from 'node:fs';
import { join } from 'node:path';
import { test } from 'node:test';
import * as tracecut from '../whole.mjs';
import { descriptions } from '../../scripts/declarations.mjs';
import { docOf, parse } from '../../scripts/reference/read.mjs';
import { reference } from '../../scripts/reference/write.mjs';
import { root } from '../../scripts/tools.mjs';

const file = join(root, 'docs', 'reference.md');
const { text, undocumented, names } = reference(join(root, 'dist'), tracecut.parameters());

test('docs/reference.md says what the declarations say', () => {
  if (process.env.REGENERATE) {
    writeFileSync(file, text);
    assert.fail('docs/reference.md was rewritten: look at the difference, then run again without REGENERATE');
  }
  assert.ok(
    readFileSync(file, 'utf8').replaceAll('\r', '') === text,
    'docs/reference.md is out of date: run node scripts/reference.mjs',
  );
});

test('every public name, member and parameter has a description', () => {
  assert.deepEqual(undocumented, []);
});

test('the reference has an entry for all that the package exports, and each of its links leads somewhere', () => {
  assert.deepEqual(
    Object.keys(tracecut).filter((name) => !names.includes(name)),
    [],
  );
  const anchors = new Set();
  for (const [, title] of text.matchAll(/^#+ (.+)$/gm)) {
    const anchor = title
      .toLowerCase()
      .replaceAll(' ', '-')
      .replace(/[^\w-]/g, '');
    let own = anchor;
    for (let k = 1; anchors.has(own); k += 1) own = `${anchor}-${k}`;
    anchors.add(own);
  }
  for (const [, anchor] of text.matchAll(/\]\(#([^)]+)\)/g)) assert.ok(anchors.has(anchor), `#${anchor}`);
  for (const name of names) assert.match(text, new RegExp(`^### ${name}$`, 'm'));
});

test('statements are read with the comment before them, whatever brackets and quotes they hold', () => {
  const read = parse(
    `import { A } from './a.js';
/** Says so; has a } in it. */
export declare function f<T extends {
    x: ';';
}>(a: T, b?: import('../b.js').B): Promise<void>;
/** A class. */
export declare class C extends A {
    #private;
    /** Its size. */
    get size(): number;
    /** Not listed. */
    constructor(a: A);
    /** Ends it. */
    [Symbol.dispose](): void;
}
export type { D } from './deep/d.js';
declare const hidden: number;
export * from '../all.js';
`,
    'sub/m.js',
  );
  assert.deepEqual(
    read.map(({ kind, name, from }) => [kind, name ?? from]),
    [
      ['function', 'f'],
      ['class', 'C'],
      ['names', 'sub/deep/d.js'],
      ['all', 'all.js'],
    ],
  );
  assert.equal(read[0].doc.words, 'Says so; has a } in it.');
  assert.ok(read[0].text.endsWith('Promise<void>;'));
  assert.deepEqual(
    read[1].members.map(({ name, doc }) => [name, doc.words]),
    [
      ['size', 'Its size.'],
      ['[Symbol.dispose]', 'Ends it.'],
    ],
  );
});

test('comments are read with their tags', () => {
  const doc = docOf(`/**
 * Two
 * lines.
 * @param {{a: number, b: {c: string}}} [options] what to do,
 *   and how
 * @param {number} t
 * @returns {Promise<number>} a number
 * @throws {TraceCutError} \`data\` if not
 */`);
  assert.equal(doc.words, 'Two\nlines.');
  assert.deepEqual([...doc.params], [['options', 'what to do, and how']]);
  assert.deepEqual([doc.returns, doc.throws], ['a number', ['`data` if not']]);
  const source = `/** In one line. @typedef {{a: number}} One */
/**
 * In more,
 * here two.
 * @typedef {object} Two
 * @property {{b: number}} b
 */
/** @typedef {string} Silent */
`;
  assert.deepEqual(
    [...descriptions(source)],
    [
      ['One', 'In one line.'],
      ['Two', 'In more,\nhere two.'],
    ],
  );
});
