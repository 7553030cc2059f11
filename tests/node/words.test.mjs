// Every English text of the page is in each table of another language, with the same places to fill, and nothing else.

import assert from 'node:assert/strict';
import { test } from 'node:test';
import german from '../../www/demo/words/de.js';
import { say } from '../../www/demo/language.js';
import { modules, textsOf, textsOfPage } from '../words.mjs';

/** What is the same in German. */
const SAME = [
  ...['320 px', '480 px', '640 px', 'COCO JSON', 'Clip', 'Clips', 'Esc', 'Original', 'PNG', 'Pb', 'Superpixels', 'Tab'],
  ...[
    'TraceCut',
    'ZIP',
    'Transparent',
    'Zoom',
    'beige',
    'magenta',
    'orange',
    'objects.csv',
    'px',
    'tracks.dat',
    '{0} MP4',
    '{0} WebM',
  ],
];

const table = new Map(Object.entries(german));
const texts = new Set(
  [...textsOfPage(), ...modules().flatMap(textsOf)].filter((text) => text.replace(/\{\d\}/g, '').match(/\p{L}{2}/u)),
);

test('every English text has its German one', () => {
  assert.ok(texts.size > 500, `${texts.size} texts`);
  assert.deepEqual(
    [...texts].filter((text) => !table.has(text) && !SAME.includes(text)),
    [],
  );
});

test('the table has nothing that the page never says, and nothing that is the same', () => {
  const used = new Set([...texts, ...textsWithoutWords()]);
  assert.deepEqual(
    [...table.keys()].filter((key) => !used.has(key)),
    [],
  );
  assert.deepEqual(
    SAME.filter((text) => table.has(text) || !texts.has(text)),
    [],
  );
});

/** Texts of places to fill and little else. */
function textsWithoutWords() {
  return modules()
    .flatMap(textsOf)
    .filter((text) => text.includes('{0}'));
}

test('both have the same places to fill', () => {
  const places = (text) => [...text.matchAll(/\{\d\}/g)].map(([place]) => place).sort();
  assert.deepEqual(
    [...table].filter(([key, words]) => String(places(key)) !== String(places(words))),
    [],
  );
});

test('German words that are looked up again stay as they are', () => {
  const changed = [...new Set(table.values())].filter((words) => table.has(words) && table.get(words) !== words);
  assert.deepEqual(changed, []);
});

test('say fills in what stands in a sentence', () => {
  assert.equal(say('Save'), 'Save');
  assert.equal(say`Saved ${'a{1}.zip'}, ${2}.`, 'Saved a{1}.zip, 2.');
  assert.equal(say`${1}\u00a0s`, '1\u00a0s');
});
