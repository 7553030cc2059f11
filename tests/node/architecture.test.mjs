// What ARCHITECTURE.md says of rooms is so: each has its row, and imports lead up the table only; and every file of code
// says in its first lines what it is.

import assert from 'node:assert/strict';
import { existsSync, readFileSync, readdirSync } from 'node:fs';
import { basename, extname, join } from 'node:path';
import { test } from 'node:test';
import { root } from '../../scripts/tools.mjs';

const read = (file) => readFileSync(join(root, file), 'utf8').replaceAll('\r', '');
const architecture = read('ARCHITECTURE.md');

const CODE = ['.rs', '.js', '.mjs', '.ts', '.css', '.py', '.pyi'];
const FOLDERS = ['src', 'cli', 'decoder', 'www', 'python', 'examples', 'scripts', 'tests', 'bench', 'benches', 'fuzz'];
const NOT_OURS = ['node_modules', 'dist', 'target', 'pkg', 'out', '.venv', '.mypy_cache', '__pycache__'];

/** Names that the library has at its top, by the room that they come from. */
const AT_TOP = {
  Error: 'error',
  choices: 'params',
  Params: 'pipeline',
  Session: 'pipeline',
  Progress: 'pipeline',
  Stage: 'pipeline',
  Step: 'pipeline',
};

/** The rows of the table with this heading: the names in each one's first column. */
function rowsOf(heading) {
  const table = architecture.split(`\n| ${heading} |`)[1].split('\n\n')[0];
  const rows = table.split('\n').filter((line) => line.startsWith('| `'));
  return rows.map((row) => [...row.split('|')[1].matchAll(/`([^`]+)`/g)].map(([, name]) => name));
}

/** All files of code in a folder and the folders in it. */
function codeIn(folder) {
  return readdirSync(join(root, folder), { withFileTypes: true }).flatMap((entry) => {
    const path = `${folder}/${entry.name}`;
    if (entry.isDirectory()) return NOT_OURS.includes(entry.name) ? [] : codeIn(path);
    return CODE.includes(extname(path)) ? [path] : [];
  });
}

const roomOf = (file) => file.split('/')[1].replace(/\.rs$/, '');

/** The rooms that a file of Rust imports from, without its tests. */
function importsOf(file) {
  if (/tests\.rs$/.test(file)) return [];
  const [code] = read(file).split('#[cfg(test)]\nmod tests {');
  const parts = code
    .replace(/\/\/.*$/gm, '')
    .split('crate::')
    .slice(1);
  const names = parts.flatMap((part) => (part.startsWith('{') ? part.slice(1).split('}')[0].split(',') : [part]));
  const rooms = names.map((name) => /^\s*(\w+)/.exec(name)?.[1]).filter(Boolean);
  return rooms.map((name) => AT_TOP[name] ?? name).filter((name) => name !== roomOf(file));
}

test('every room of the library has one row, and nothing else has', () => {
  const rooms = new Set(readdirSync(join(root, 'src')).map((name) => basename(name, '.rs')));
  rooms.delete('lib');
  assert.deepEqual(rowsOf('room').flat().sort(), [...rooms].sort());
});

test('a room imports only from the rooms above it in the table', () => {
  const rows = rowsOf('room');
  const place = new Map(rows.flatMap((names, row) => names.map((name, k) => [name, row + k / 100])));
  const files = codeIn('src').filter((file) => file !== 'src/lib.rs');
  const imports = files.flatMap((file) => importsOf(file).map((room) => ({ file, room })));
  assert.ok(imports.length > 300, `${imports.length} imports`);
  assert.deepEqual(
    imports.filter(({ file, room }) => !(place.get(room) < place.get(roomOf(file)))),
    [],
  );
  assert.ok(place.get('cut') > place.get('flow'));
});

test('the package imports nothing of the page, and the page takes the package by its name', () => {
  const imported = (folder) =>
    codeIn(folder).flatMap((file) => {
      const names = [...read(file).matchAll(/(?:\bfrom|\bimport)\s*\(?\s*'([^'\n]+)'/g)].map(([, name]) => name);
      return names.map((name) => ({ file, name }));
    });
  const [ofPackage, ofPage] = [imported('www/lib'), imported('www/demo')];
  assert.ok(ofPackage.length > 200 && ofPage.length > 200);
  assert.deepEqual(
    ofPackage.filter(({ name }) => name.includes('demo/')),
    [],
  );
  assert.deepEqual(
    ofPage.filter(({ name }) => /\b(lib|dist)\//.test(name) || !/^(\.|tracecut(\/|$)|fflate$)/.test(name)),
    [],
  );
});

test('every folder that the page names is there', () => {
  const folders = rowsOf('folder').flat();
  assert.ok(FOLDERS.filter((name) => !['src', 'www'].includes(name)).every((name) => folders.includes(name)));
  assert.deepEqual(
    folders.filter((name) => !existsSync(join(root, name))),
    [],
  );
  const parts = ['lib', 'demo'].flatMap((part) =>
    readdirSync(join(root, 'www', part), { withFileTypes: true }).filter((entry) => entry.isDirectory()),
  );
  assert.deepEqual(
    parts.map(({ name }) => name).filter((name) => !architecture.includes(`\`${name}\``)),
    [],
  );
});

test('every file of code says in its first lines what it is', () => {
  const files = FOLDERS.flatMap(codeIn);
  assert.ok(files.length > 700, `${files.length} files`);
  const silent = files.filter((file) => !/^(#!.*\n)?\s*(\/\/|\/\*|#|r?""")/.test(read(file)));
  assert.deepEqual(silent, []);
});

test('it is short enough to be read', () => {
  assert.ok(Buffer.byteLength(architecture) <= 15 * 1024, `${Buffer.byteLength(architecture)} bytes`);
});
