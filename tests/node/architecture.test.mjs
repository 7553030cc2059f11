// What ARCHITECTURE.md says of rooms is so: each has its row, and imports lead up the table only.

import assert from 'node:assert/strict';
import { readFileSync, readdirSync } from 'node:fs';
import { basename, join, posix } from 'node:path';
import { test } from 'node:test';
import { root } from '../../scripts/tools.mjs';

const read = (file) => readFileSync(join(root, file), 'utf8').replaceAll('\r', '');
const architecture = read('ARCHITECTURE.md');

/** Names that the library has at its top, by the room that they come from. */
const AT_TOP = {
  Error: 'error',
  choices: 'params',
  Params: 'base',
  Session: 'run',
  Progress: 'base',
  Stage: 'base',
  Step: 'base',
};

const unquoted = (cell) => [...cell.matchAll(/`([^`]+)`/g)].map(([, name]) => name);

/** The rows of the table of rooms: the group (none: `''`) and the rooms in it. A row that names no group is of that above. */
const rows = architecture
  .split('\n| group | room |')[1]
  .split('\n\n')[0]
  .split('\n')
  .filter((line) => /^\| (`|none|\|)/.test(line))
  .reduce((found, row) => {
    const [, first, second] = row.split('|');
    const group = first.trim() ? (unquoted(first)[0] ?? '') : found.at(-1).group;
    return [...found, { group, names: unquoted(second) }];
  }, []);
const groups = new Set(rows.map(({ group }) => group).filter(Boolean));

/** All files of code in a folder and the folders in it. */
const codeIn = (folder) =>
  readdirSync(join(root, folder), { recursive: true })
    .map((name) => `${folder}/${name.replaceAll('\\', '/')}`)
    .filter((name) => /\.(rs|js|ts)$/.test(name) && !name.endsWith('.d.ts'));

/** The path of a file in `src`, from its room on. */
const inRoom = (file) => file.split('/').slice(groups.has(file.split('/')[1]) ? 2 : 1);

const roomOf = (file) => inRoom(file)[0].replace(/\.rs$/, '');

/** Files that only declare modules: that of the crate and those of groups. */
const declares = (file) => file === 'src/lib.rs' || [...groups].some((group) => file === `src/${group}/mod.rs`);

/** The rooms that a file of Rust imports from, without its tests. */
function importsOf(file) {
  if (/tests\.rs$/.test(file)) return [];
  const [code] = read(file).split('#[cfg(test)]\nmod tests {');
  const parts = code
    .replace(/\/\/.*$/gm, '')
    .split('crate::')
    .slice(1);
  const names = parts.flatMap((part) => (part.startsWith('{') ? part.slice(1).split('}')[0].split(',') : [part]));
  // The rooms of `session` have it in their paths; from outside only its public names are taken, of its last room.
  const room = ([, first, second]) => (first !== 'session' ? first : /^[a-z]/.test(second ?? 'A') ? second : 'read');
  const rooms = names.flatMap((name) => [/^\s*(\w+)(?:::(\w+))?/.exec(name) ?? []].filter((m) => m[1]).map(room));
  return rooms.map((name) => AT_TOP[name] ?? name).filter((name) => name !== roomOf(file));
}

/** The files of a folder that a file of JavaScript or TypeScript imports, at once or later; types do not count. */
function localImports(file) {
  const code = read(file).replace(/\/\*[^]*?\*\/|^\s*\/\/.*$|^(im|ex)port type [^;]*;/gm, '');
  const names = [...code.matchAll(/(?:\bfrom|\bimport)\s*\(?\s*'(\.[^'\n]+)'/g)].map(([, name]) => name);
  const ending = posix.extname(file);
  return names.map((name) => posix.join(posix.dirname(file), name).replace(/\.js$/, ending));
}

/** Groups of files of which each leads to each other by imports. @param {Map<string, string[]>} imports */
function circlesIn(imports) {
  const reached = new Map([...imports.keys()].map((file) => [file, reachedFrom(file, imports)]));
  const circles = [...imports.keys()].map((file) =>
    [...reached.get(file)].filter((other) => reached.get(other)?.has(file)).sort(),
  );
  return circles.filter((circle, k) => circle.length > 0 && circle[0] === [...imports.keys()][k]);
}

function reachedFrom(file, imports, found = new Set()) {
  for (const next of imports.get(file) ?? []) if (!found.has(next)) reachedFrom(next, imports, found.add(next));
  return found;
}

test('every room of the library has one row, and nothing else has', () => {
  const entries = (folder) => readdirSync(join(root, 'src', folder)).map((name) => basename(name, '.rs'));
  const rooms = [...groups].flatMap((group) => entries(group).map((name) => `${group}/${name}`));
  const others = entries('').filter((name) => name !== 'lib' && !groups.has(name));
  assert.deepEqual(
    rows.flatMap(({ group, names }) => names.map((name) => (group ? `${group}/${name}` : name))).sort(),
    [...rooms.filter((name) => !name.endsWith('/mod')), ...others].sort(),
  );
});

test('a room imports only from the rooms above it in the table', () => {
  const place = new Map(rows.flatMap(({ names }, row) => names.map((name, k) => [name, row + k / 100])));
  const files = codeIn('src').filter((file) => !declares(file));
  const imports = files.flatMap((file) => importsOf(file).map((room) => ({ file, room })));
  assert.ok(imports.length > 300, `${imports.length} imports`);
  assert.deepEqual(
    imports.filter(({ file, room }) => !(place.get(room) < place.get(roomOf(file)))),
    [],
  );
  assert.ok(place.get('cut') > place.get('flow'));
});

test('what reads files is compiled without the library, of the files of the rooms that the table names', () => {
  assert.doesNotMatch(read('decoder/Cargo.toml'), /^tracecut\b/m);
  const taken = codeIn('decoder').flatMap((file) =>
    [...read(file).matchAll(/#\[path = "\.\.\/(src\/[^"]+)"\]/g)].map(([, name]) => name),
  );
  const may = unquoted(/^\| `decoder` \|.*\|(.*)\|$/m.exec(architecture)[1]);
  assert.ok(taken.length > 10, taken.join());
  assert.deepEqual(
    taken.filter((file) => !may.includes(roomOf(file)) && !may.includes(file.split('/')[1])),
    [],
  );
});

test('the package imports nothing of the studio, and the studio takes the package from library.js', () => {
  const imported = (folder) =>
    codeIn(folder).flatMap((file) => {
      const names = [...read(file).matchAll(/(?:\bfrom|\bimport)\s*\(?\s*'([^'\n]+)'/g)].map(([, name]) => name);
      return names.map((name) => ({ file, name }));
    });
  const [ofPackage, ofPage] = [
    imported('npm'),
    imported('studio').filter(({ file }) => !/(library\.ts|service-worker\.js)$/.test(file)),
  ];
  assert.ok(ofPackage.length > 200 && ofPage.length > 200);
  assert.deepEqual(
    ofPackage.filter(({ name }) => name.includes('studio/')),
    [],
  );
  assert.deepEqual(
    ofPage.filter(({ name }) => /\b(npm|dist)\//.test(name) || !/^(\.|tracecut\/selftest$|fflate$)/.test(name)),
    [],
  );
});

/** What only a browser's pages have. */
const DOM =
  /\b(document|navigator|localStorage|indexedDB|matchMedia|requestAnimationFrame|OffscreenCanvas|createImageBitmap|location|byId|HTML\w*Element)\b|\bnew (ImageData|Image|Worker)\b|\bwindow\.(?!shot\b|frames\b|firstFrame\b|settled\b)/;

test('the model of the studio has no word of the DOM, and imports nothing of the view', () => {
  const model = codeIn('studio/model');
  const code = (file) => read(file).replace(/\/\*[^]*?\*\/|\/\/.*$/gm, '');
  assert.ok(model.length > 25, `${model.length} files`);
  assert.deepEqual(
    model.flatMap(
      (file) =>
        DOM.exec(code(file))
          ?.slice(0, 1)
          .map((word) => ({ file, word })) ?? [],
    ),
    [],
  );
  assert.deepEqual(
    model.filter((file) => /\.\.\/view\//.test(read(file))),
    [],
  );
  assert.match(code('studio/view/viewer.ts'), DOM);
});

test('the lab imports the public entries of the package and nothing else', () => {
  const files = codeIn('www');
  const names = files.flatMap((file) =>
    [...read(file).matchAll(/\b(?:from|import) '([^']+)'/g)].map(([, name]) => name),
  );
  assert.ok(names.length > 15);
  assert.deepEqual(
    names.filter((name) => !/^(\.\/[\w-]+\.js|tracecut(\/\w+)?)$/.test(name)),
    [],
  );
  const lines = files.reduce((sum, file) => sum + read(file).split('\n').length - 1, 0);
  assert.ok(lines <= 1500, `${lines} lines`);
});

test('no files of the package, the page or the lab import each other in a circle', () => {
  for (const [folder, known] of Object.entries({ npm: [], studio: [], www: [] })) {
    const imports = new Map(codeIn(folder).map((file) => [file, localImports(file)]));
    assert.deepEqual(circlesIn(imports), known, folder);
  }
  const circle = new Map([
    ['a', ['b', 'd']],
    ['b', ['c']],
    ['c', ['a', 'd']],
    ['d', []],
  ]);
  assert.deepEqual(circlesIn(circle), [['a', 'b', 'c']]);
});
