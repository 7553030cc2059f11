// What the release script reads, says and refuses; what it builds is tested by its dry run.

import assert from 'node:assert/strict';
import { spawnSync } from 'node:child_process';
import { mkdtempSync, readFileSync, rmSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import { test } from 'node:test';
import {
  FILES,
  absent,
  byHand,
  listing,
  notesOf,
  obstacles,
  publishing,
  rehearsal,
  tagOf,
  versionOf,
} from '../../scripts/release.mjs';
import { packed } from '../../scripts/size.mjs';
import { output, root } from '../../scripts/tools.mjs';

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

test('what to type by hand ends with the tag, which makes the workflow publish', () => {
  assert.equal(tagOf('1.2.3'), 'v1.2.3');
  const lines = byHand('1.2.3');
  assert.equal(lines[0], 'npm run release -- --dry-run');
  assert.equal(lines.at(-1), 'git push origin v1.2.3');
});

test('npm publishes the very file that was checked, with provenance, and cargo the crate', () => {
  const [npm, cargo, program] = publishing('1.2.3').map((words) => words.join(' '));
  assert.equal(npm, 'npm publish target/package/tracecut-1.2.3.tgz --provenance --access public');
  assert.equal(cargo, 'cargo publish --locked --package tracecut');
  assert.equal(program, 'cargo publish --locked --package tracecut-cli');
});

test('npm would publish the tarball as it is', (t) => {
  const folder = mkdtempSync(join(tmpdir(), 'tracecut-'));
  t.after(() => rmSync(folder, { recursive: true }));
  const { files, filename } = packed('--pack-destination', folder);
  assert.deepEqual(absent(files.map(({ path }) => path)), []);
  const [command, ...words] = rehearsal('1.2.3').map((word) => (word.endsWith('.tgz') ? join(folder, filename) : word));
  assert.equal(output(command, [...words, '--offline']), `+ tracecut@${JSON.parse(read('package.json')).version}`);
});

test('a package without its licences or its bill of materials is refused', () => {
  const paths = ['LICENSE-MIT', 'LICENSE-APACHE', 'README.md', 'dist/index.js'];
  assert.deepEqual(absent(paths), ['dist/THIRD-PARTY-LICENSES.txt', 'dist/sbom.cdx.json']);
});

test('only the workflow publishes: at the tag of this version, of this repository, with a token to sign with', () => {
  const manifest = JSON.parse(read('package.json'));
  const env = {
    GITHUB_ACTIONS: 'true',
    ACTIONS_ID_TOKEN_REQUEST_URL: 'somewhere',
    GITHUB_REF: 'refs/tags/v1.2.3',
    GITHUB_REPOSITORY: 'tracecut/tracecut',
  };
  const faults = (change, of = manifest) => obstacles('1.2.3', { ...env, ...change }, of).join();
  assert.equal(faults({}), '');
  assert.match(faults({ GITHUB_ACTIONS: undefined }), /push the tag/);
  assert.match(faults({ ACTIONS_ID_TOKEN_REQUEST_URL: undefined }), /"id-token: write"/);
  assert.match(faults({ GITHUB_REF: 'refs/heads/main' }), /refs\/heads\/main \(expected refs\/tags\/v1\.2\.3\)/);
  assert.match(faults({ GITHUB_REPOSITORY: 'a/fork' }), /a\/fork, and package\.json names tracecut\/tracecut/);
  assert.match(faults({}, { ...manifest, publishConfig: {} }), /publishConfig\.provenance/);
});

test('without the workflow nothing is published', () => {
  const { GITHUB_ACTIONS, ...env } = process.env;
  const { status, stderr } = spawnSync(process.execPath, ['scripts/release.mjs', '--publish'], {
    cwd: root,
    env,
    encoding: 'utf8',
  });
  assert.equal(status, 1);
  assert.match(stderr, /Publishing is for the workflow release\.yml/);
});

test('the workflow runs this script at tags alone, and may sign', () => {
  const workflow = read(join('.github', 'workflows', 'release.yml'));
  assert.match(workflow, /^on:\n {2}push:\n {4}tags: \['v\[0-9\]\*'\]\n\n/m);
  assert.match(workflow, /^ {4}permissions:\n {6}contents: read\n {6}id-token: write\n/m);
  assert.match(workflow, /run: npm run release -- --publish$/m);
  assert.doesNotMatch(workflow, /secrets\./);
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
