// What the package says of other people's work in it: the licences and the bill of materials, in the tarball itself.

import assert from 'node:assert/strict';
import { mkdtempSync, readFileSync, readdirSync, rmSync, writeFileSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import { test } from 'node:test';
import { BILL, LICENCES, VENDORED, writeLicences } from '../../scripts/licences.mjs';
import { checksumsOf, treeLines } from '../../scripts/licences/crates.mjs';
import { alternatives, mitHolders, noticesIn, plainMit } from '../../scripts/licences/notices.mjs';
import { hashOf } from '../../scripts/licences/packages.mjs';
import { root } from '../../scripts/tools.mjs';
import { installed } from '../package/installed.mjs';

const read = (name) => readFileSync(join(root, name), 'utf8');
const manifest = JSON.parse(read('package.json'));

test('the tarball carries the licences and the bill, and they are those of what it was built from', (t) => {
  const dist = join(installed(t), 'node_modules', 'tracecut', 'dist');
  const fresh = temporary(t);
  writeLicences(fresh);
  for (const name of [LICENCES, BILL])
    assert.equal(readFileSync(join(dist, name), 'utf8'), readFileSync(join(fresh, name), 'utf8'), name);
});

test('every crate that a wasm file names in its messages is listed for that file', () => {
  const list = read(join('dist', LICENCES)).split('\n');
  for (const file of ['tracecut_bg.wasm', 'decoder_bg.wasm']) {
    const text = readFileSync(join(root, 'dist', file), 'latin1');
    const paths = [...text.matchAll(/([\w/.-]*)\/([a-z][\w-]*?)-(\d+\.\d+\.\d+)\/src\//g)];
    const crates = paths
      .filter(([, before]) => !before.startsWith('/rust'))
      .map(([, , name, version]) => `${name} ${version}`);
    assert.ok(crates.length > 3, `${file}: ${crates}`);
    for (const crate of new Set(crates))
      assert.ok(
        list.some((line) => line.startsWith(`- ${crate}, `) && line.includes(file)),
        `${file}: ${crate}`,
      );
  }
});

test('each part has its licence in words, and the Mozilla part says where its source is', () => {
  const text = read(join('dist', LICENCES));
  const [contents] = text.split(/\n-{80}\n/);
  const parts = [...contents.matchAll(/^- (\S+ \S+), ([^,]+), in /gm)];
  assert.ok(parts.length > 40, `${parts.length} parts`);
  const titles = text
    .slice(contents.length)
    .split('\n')
    .flatMap((line) => line.split(', '));
  for (const [, part] of parts) assert.ok(titles.includes(part), part);
  const { version } = JSON.parse(read('node_modules/mediabunny/package.json'));
  assert.match(
    text,
    new RegExp(`^- mediabunny ${version.replaceAll('.', '\\.')}, MPL-2\\.0, in vendor/media\\.js`, 'm'),
  );
  assert.match(text, /folder src of the\nnpm package mediabunny@\d+\.\d+\.\d+, and at https:/);
  assert.match(text, /Mozilla Public License Version 2\.0\n=+\n/);
  assert.match(manifest.license, /AND MPL-2\.0$/);
});

test('the bill of materials has the shape of CycloneDX 1.6', () => {
  const bill = JSON.parse(read(join('dist', BILL)));
  assert.equal(bill.bomFormat, 'CycloneDX');
  assert.equal(bill.specVersion, '1.6');
  assert.equal(bill.version, 1);
  const allowed = ['$schema', 'bomFormat', 'specVersion', 'version', 'metadata', 'components', 'dependencies'];
  assert.deepEqual(Object.keys(bill), allowed);
  assert.equal(bill.metadata.component.purl, `pkg:npm/${manifest.name}@${manifest.version}`);
  for (const component of bill.components) assertComponent(component);
  assertGraph(bill);
});

test('the bill has the checksums of both lock files, and the licences that the parts name', () => {
  const { components } = JSON.parse(read(join('dist', BILL)));
  const spade = components.find(({ name }) => name === 'spade');
  const [, version, checksum] = /name = "spade"\nversion = "(.+)"\n.*\nchecksum = "(.+)"/.exec(read('Cargo.lock'));
  assert.deepEqual([spade.version, spade.hashes], [version, [{ alg: 'SHA-256', content: checksum }]]);
  assert.deepEqual(spade.licenses, [{ expression: 'MIT OR Apache-2.0' }]);
  const media = components.find(({ name }) => name === 'mediabunny');
  assert.deepEqual(media.licenses, [{ license: { id: 'MPL-2.0' } }]);
  assert.match(media.hashes[0].content, /^[0-9a-f]{128}$/);
  assert.deepEqual(
    media.properties.map(({ value }) => value),
    ['dist/vendor/media.js', 'dist/inline.js'],
  );
});

test('every library is listed with the files that hold it', () => {
  for (const [name, files] of Object.entries(VENDORED))
    assert.match(read(join('scripts', files[0])), new RegExp(`from '${name}'`));
  const scripts = readdirSync(join(root, 'dist'), { recursive: true })
    .map((name) => name.replaceAll('\\', '/'))
    .filter((name) => /\.c?js$/.test(name));
  // Words of their own that bundling leaves: a notice, a message.
  const signs = { mediabunny: /Copyright \(c\) \d{4}-present, Vanilagy/, fflate: /unexpected EOF/ };
  for (const [name, sign] of Object.entries(signs)) {
    const holders = scripts.filter((file) => sign.test(read(join('dist', file))));
    assert.deepEqual(holders.sort(), [...VENDORED[name]].sort(), name);
  }
});

test('of several licences one is taken whose text is there, and none at all is an error', (t) => {
  assert.deepEqual(alternatives('(MIT OR Apache-2.0) AND Unicode-3.0'), [
    ['MIT', 'Unicode-3.0'],
    ['Apache-2.0', 'Unicode-3.0'],
  ]);
  assert.deepEqual(alternatives('Zlib'), [['Zlib']]);
  const folder = temporary(t);
  assert.deepEqual(noticesIn(folder, 'MIT', 'Copyright (c) me'), [plainMit('Copyright (c) me')]);
  assert.throws(() => noticesIn(folder, 'Zlib', ''), /no text for the licence Zlib/);
  assert.throws(() => noticesIn(folder, 'GPL-3.0-only', ''), /no text for the licence GPL-3.0-only/);
  writeFileSync(join(folder, 'LICENSE-APACHE'), 'Apache License\n   Version 2.0, January 2004');
  assert.equal(noticesIn(folder, 'MIT OR Apache-2.0', '')[0].licence, 'Apache-2.0');
});

test('only the MIT licence in its own words is shortened to its copyright lines', () => {
  const { text } = plainMit('Copyright (c) 2020 A\nCopyright (c) 2021 B');
  assert.deepEqual(mitHolders(`MIT License\n\n${text}`), ['Copyright (c) 2020 A', 'Copyright (c) 2021 B']);
  assert.equal(mitHolders(`${text}\n\nAnd one thing more.`), null);
});

test('what Cargo and npm write is read as they mean it', () => {
  const lines = treeLines('0|tracecut v0.1.0 (/a/b)|MIT|here\n1|paste v1.0.15 (proc-macro)|MIT/Apache-2.0|x.git (*)');
  assert.deepEqual(lines[1], { depth: 1, name: 'paste', version: '1.0.15', licence: 'MIT OR Apache-2.0', source: 'x' });
  assert.throws(() => treeLines('warning: what'), /"warning: what", which is no package/);
  assert.equal(checksumsOf('name = "a"\nversion = "1"\ndependencies = []\n').size, 0);
  assert.throws(() => hashOf('md5-abc'), /integrity = "md5-abc"/);
});

function temporary(t) {
  const folder = mkdtempSync(join(tmpdir(), 'tracecut-'));
  t.after(() => rmSync(folder, { recursive: true }));
  return folder;
}

const LENGTHS = { 'SHA-256': 64, 'SHA-384': 96, 'SHA-512': 128 };

/** What the schema asks of a component, and what we ask: a licence, an identifier, a checksum. */
function assertComponent(component) {
  const { type, name, version, purl, licenses, hashes = [], externalReferences = [] } = component;
  assert.equal(type, 'library');
  assert.ok(name && version && licenses.length === 1, JSON.stringify(component));
  assert.match(purl, /^pkg:(cargo|npm|generic)\/[\w-]+@[\w.+-]+$/);
  assert.equal(component['bom-ref'], purl);
  assert.ok(licenses[0].expression ?? licenses[0].license.id, purl);
  assert.equal(hashes.length, purl.startsWith('pkg:generic/') ? 0 : 1, purl);
  for (const { alg, content } of hashes) assert.equal(content.length, LENGTHS[alg], purl);
  for (const { type: kind, url } of externalReferences) assert.ok(kind === 'vcs' && URL.canParse(url), url);
}

/** Everything is reached from the package, and nothing is named that is not listed. */
function assertGraph({ metadata, components, dependencies }) {
  const refs = new Set(components.map((component) => component['bom-ref']));
  assert.equal(refs.size, components.length);
  const uses = new Map(dependencies.map(({ ref, dependsOn }) => [ref, dependsOn]));
  const reached = new Set([metadata.component['bom-ref']]);
  for (const ref of reached) for (const used of uses.get(ref)) reached.add(used);
  reached.delete(metadata.component['bom-ref']);
  assert.deepEqual([...reached].sort(), [...refs].sort());
}
