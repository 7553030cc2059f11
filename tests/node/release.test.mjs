// What the release script reads and says; what it builds is tested by running it.

import assert from 'node:assert/strict';
import { readFileSync } from 'node:fs';
import { join } from 'node:path';
import { test } from 'node:test';
import { FILES, byHand, listing, notesOf, tagOf, versionOf } from '../../scripts/release.mjs';
import { root } from '../../scripts/tools.mjs';

const read = (file) => readFileSync(join(root, file), 'utf8');

test('all files name one version and one day', () => {
  const { version, faults } = versionOf(read);
  assert.deepEqual(faults, []);
  assert.equal(version, JSON.parse(read('package.json')).version);
  assert.equal(JSON.parse(read('package-lock.json')).packages[''].version, version);
  assert.notEqual(notesOf(read('CHANGELOG.md'), version), '');
});

test('a file that names another version, or none, is told by its name', () => {
  const { version } = versionOf(read);
  for (const file of FILES) {
    const other = (name) => (name === file ? read(name).replaceAll(version, '7.8.9') : read(name));
    const [fault, ...more] = versionOf(other).faults;
    assert.ok(fault.includes(`7.8.9 in ${file}`), fault);
    assert.deepEqual(more, []);
    const without = (name) => (name === file ? '' : read(name));
    assert.equal(versionOf(without).faults[0], `${file} names no version.`);
  }
});

test('the days of changelog and citation are compared', () => {
  const late = (file) =>
    file === 'CITATION.cff' ? read(file).replace(/^date-released: .*$/m, 'date-released: 1999-01-01') : read(file);
  assert.match(versionOf(late).faults.join(), /^The dates differ: .*1999-01-01 in CITATION.cff/);
});

test('windows line ends make no difference', () => {
  assert.deepEqual(
    versionOf((file) => read(file).replaceAll('\n', '\r\n')),
    versionOf(read),
  );
});

test('the notes of a version end where the next begins, or the links', () => {
  const changelog =
    '# Changelog\n\n## [Unreleased]\n\n## [0.2.0] - 2027-01-01\n\n### Added\n\n- New.\n\n## [0.1.0] - 2026-01-01\n\nOld.\n\n[0.2.0]: x\n';
  assert.equal(notesOf(changelog, '0.2.0'), '### Added\n\n- New.');
  assert.equal(notesOf(changelog, '0.1.0'), 'Old.');
  assert.equal(notesOf(changelog, '0.3.0'), '');
  assert.equal(notesOf(changelog, 'Unreleased'), '');
});

test('what to type by hand names the tag and ends with both publishers', () => {
  assert.equal(tagOf('1.2.3'), 'v1.2.3');
  const lines = byHand('1.2.3');
  assert.ok(lines.includes('git push origin v1.2.3'));
  assert.deepEqual(lines.slice(-2), ['cargo publish --locked', 'npm publish target/package/tracecut-1.2.3.tgz']);
});

test('contents are listed with the largest first and their sum', () => {
  const text = listing([
    { path: 'b', size: 5 },
    { path: 'c', size: 1234 },
    { path: 'a', size: 5 },
  ]);
  assert.deepEqual(
    text.split('\n').map((line) => line.trim().split(/\s+/)),
    [
      ['1,234', 'c'],
      ['5', 'a'],
      ['5', 'b'],
      ['1,244', 'in', '3', 'files'],
    ],
  );
});
