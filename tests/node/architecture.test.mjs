// The tables of ARCHITECTURE.md name every file of code once, alone or by its folder, and nothing that is not there.

import assert from 'node:assert/strict';
import { existsSync, readFileSync, readdirSync } from 'node:fs';
import { basename, dirname, extname, join, posix } from 'node:path';
import { test } from 'node:test';
import { root } from '../../scripts/tools.mjs';

/** Where the names of each table begin, by its heading. */
const TABLES = {
  'src: the library': 'src',
  'cli/src: the command line': 'cli/src',
  'www: the package and the page': 'www',
  'python: the Python package': 'python',
  'examples, scripts, tests, benches': '.',
};
const FOLDERS = ['src', 'cli', 'decoder', 'www', 'python', 'examples', 'scripts', 'tests', 'bench', 'benches', 'fuzz'];
const CODE = ['.rs', '.js', '.mjs', '.ts', '.css', '.html', '.py', '.pyi'];
const NOT_OURS = ['node_modules', 'dist', 'target', 'pkg', 'out', '.venv'];

/** The places that one row names; a name alone stands in the folder of the row's first. */
function placesOf(row, base) {
  const names = [...row.split('|')[1].matchAll(/`([^`]+)`/g)].map(([, name]) => name);
  return names.map((name, k) => posix.join(base, k > 0 && !name.includes('/') ? posix.dirname(names[0]) : '.', name));
}

function named() {
  const text = readFileSync(join(root, 'ARCHITECTURE.md'), 'utf8').replaceAll('\r', '');
  return Object.entries(TABLES).flatMap(([heading, base]) => {
    const section = text.split(`\n### ${heading}\n`)[1]?.split(/\n##/)[0];
    assert.ok(section, `there is no table "${heading}"`);
    const rows = section.split('\n').filter((line) => line.startsWith('| `'));
    return rows.flatMap((row) => placesOf(row, base));
  });
}

/** All files of code in a folder and the folders in it. */
function codeIn(folder) {
  return readdirSync(join(root, folder), { withFileTypes: true }).flatMap((entry) => {
    const path = `${folder}/${entry.name}`;
    if (entry.isDirectory()) return NOT_OURS.includes(entry.name) ? [] : codeIn(path);
    return CODE.includes(extname(path)) ? [path] : [];
  });
}

test('every file of code has its place in the tables of ARCHITECTURE.md', () => {
  const places = named();
  const isNamed = (file) => places.some((place) => place === file || (place.endsWith('/') && file.startsWith(place)));
  const files = FOLDERS.flatMap(codeIn);
  assert.ok(files.length > 300, `${files.length} files`);
  assert.deepEqual(
    files.filter((file) => !isNamed(file)),
    [],
  );
});

test('the tables name nothing twice and nothing that is not there', () => {
  const places = named();
  assert.deepEqual(
    places.filter((place) => !existsSync(join(root, place))),
    [],
  );
  assert.deepEqual(
    places.filter((place, k) => places.indexOf(place) !== k),
    [],
  );
});

test('a name alone stands beside the first of its row', () => {
  const row = '| `demo/run/job.js`, `jobs.js`, `styles/run.css` | words and `code` |';
  assert.deepEqual(placesOf(row, 'www'), ['www/demo/run/job.js', 'www/demo/run/jobs.js', 'www/styles/run.css']);
  assert.equal(basename(dirname(placesOf('| `../decoder/lib.rs` | |', 'src')[0])), 'decoder');
});
