// What the package says of other people's work in it: the licences and the bill of materials, in the tarball itself.

import assert from 'node:assert/strict';
import { mkdtempSync, readFileSync, readdirSync, rmSync, writeFileSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import { test } from 'node:test';
import { BILL, LICENCES, VENDORED, writeLicences } from '../../scripts/licences.mjs';
import { noticesIn, plainMit } from '../../scripts/notices.mjs';
import { root } from '../../scripts/tools.mjs';
import { installed } from '../package/installed.mjs';

const read = (...names) => readFileSync(join(root, ...names), 'utf8');

test('the tarball carries the licences and the bill, and they are those of what it was built from', (t) => {
  const dist = join(installed(t), 'node_modules', 'tracecut', 'dist');
  const fresh = temporary(t);
  writeLicences(fresh);
  for (const name of [LICENCES, BILL])
    assert.equal(readFileSync(join(dist, name), 'utf8'), readFileSync(join(fresh, name), 'utf8'), name);
});

test('every crate that a wasm file names in its messages is listed for that file', () => {
  const list = read('dist', LICENCES).split('\n');
  for (const file of ['tracecut_bg.wasm', 'decoder_bg.wasm']) {
    const text = readFileSync(join(root, 'dist', file), 'latin1');
    const paths = [...text.matchAll(/([\w/.-]*)\/([a-z][\w-]*?)-(\d+\.\d+\.\d+)\/src\//g)];
    const named = paths.filter(([, before]) => !before.startsWith('/rust'));
    assert.ok(named.length > 3, file);
    for (const [, , name, version] of named)
      assert.ok(
        list.some((line) => line.startsWith(`- ${name} ${version}, `) && line.includes(file)),
        `${file}: ${name} ${version}`,
      );
  }
});

test('each part has its licence in words, and the Mozilla part says where its source is', () => {
  const text = read('dist', LICENCES);
  const [contents] = text.split(/\n-{80}\n/);
  const parts = [...contents.matchAll(/^- (\S+ \S+), [^,]+, in /gm)].map(([, part]) => part);
  assert.ok(parts.length > 40, `${parts.length} parts`);
  const titles = text.slice(contents.length).split(/\n|, /);
  for (const part of parts) assert.ok(titles.includes(part), part);
  assert.match(text, /^- mediabunny [\d.]+, MPL-2\.0, in vendor\/media\.js/m);
  assert.match(text, /folder src of the\nnpm package mediabunny@\d+\.\d+\.\d+, and at https:/);
  assert.match(text, /Mozilla Public License Version 2\.0\n=+\n/);
});

test('the bill of materials has the shape of CycloneDX 1.6, with checksums and licences of all parts', () => {
  const { name, version } = JSON.parse(read('package.json'));
  const { bomFormat, specVersion, metadata, components, dependencies } = JSON.parse(read('dist', BILL));
  const own = `pkg:npm/${name}@${version}`;
  assert.deepEqual([bomFormat, specVersion, metadata.component.purl], ['CycloneDX', '1.6', own]);
  for (const { type, purl, hashes = [], licenses, 'bom-ref': ref } of components) {
    assert.deepEqual([type, ref], ['library', purl]);
    assert.match(purl, /^pkg:(cargo|npm|generic)\/[\w-]+@[\w.+-]+$/);
    assert.ok(licenses[0].expression ?? licenses[0].license.id, purl);
    const length = { cargo: 64, npm: 128 }[/\w+(?=\/)/.exec(purl)[0]];
    assert.deepEqual(
      hashes.map(({ content }) => content.length),
      length ? [length] : [],
      purl,
    );
  }
  const spade = components.find((component) => component.name === 'spade');
  assert.ok(read('Cargo.lock').includes(`version = "${spade.version}"`));
  assert.ok(read('Cargo.lock').includes(`checksum = "${spade.hashes[0].content}"`));
  // Everything is reached from the package, and nothing is named that is not listed.
  const uses = new Map(dependencies.map(({ ref, dependsOn }) => [ref, dependsOn]));
  const reached = new Set([own]);
  for (const ref of reached) for (const used of uses.get(ref)) reached.add(used);
  assert.deepEqual([...reached].sort(), [own, ...components.map(({ purl }) => purl)].sort());
});

test('every library is listed with the files that hold it', () => {
  const scripts = readdirSync(join(root, 'dist'), { recursive: true })
    .map((name) => name.replaceAll('\\', '/'))
    .filter((name) => /\.c?js$/.test(name));
  // What bundling leaves of each: a notice, a message.
  const signs = { mediabunny: /Copyright \(c\) \d{4}-present, Vanilagy/, fflate: /unexpected EOF/ };
  for (const [name, files] of Object.entries(VENDORED)) {
    const holders = scripts.filter((file) => signs[name].test(read('dist', file)));
    assert.deepEqual(holders.sort(), [...files].sort(), name);
  }
});

test('of several licences one is taken whose text is there, and none at all is an error', (t) => {
  const folder = temporary(t);
  assert.deepEqual(noticesIn(folder, 'MIT', 'Copyright (c) me'), [plainMit('Copyright (c) me')]);
  assert.throws(() => noticesIn(folder, 'Zlib', ''), /no text for the licence Zlib/);
  assert.throws(() => noticesIn(folder, 'GPL-3.0-only', ''), /no text for the licence GPL-3.0-only/);
  writeFileSync(join(folder, 'LICENSE-APACHE'), 'Apache License\n   Version 2.0, January 2004');
  writeFileSync(join(folder, 'LICENSE-UNICODE'), 'UNICODE LICENSE V3');
  assert.deepEqual(
    noticesIn(folder, '(MIT OR Apache-2.0) AND Unicode-3.0', '').map(({ licence }) => licence),
    ['Apache-2.0', 'Unicode-3.0'],
  );
});

function temporary(t) {
  const folder = mkdtempSync(join(tmpdir(), 'tracecut-'));
  t.after(() => rmSync(folder, { recursive: true }));
  return folder;
}
