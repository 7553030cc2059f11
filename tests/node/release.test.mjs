// Versions agree, and nothing is published but by the workflow, at the tag of the version.

import assert from 'node:assert/strict';
import { spawnSync } from 'node:child_process';
import { readFileSync } from 'node:fs';
import { join } from 'node:path';
import { test } from 'node:test';
import { absent, notesOf, obstacles, versionOf } from '../../scripts/release.mjs';
import { root } from '../../scripts/tools.mjs';

const read = (file) => readFileSync(join(root, file), 'utf8');
const manifest = JSON.parse(read('package.json'));

test('all files name one version and one day; a file that differs, or names none, is told by its name', () => {
  const { version, faults } = versionOf(read);
  assert.deepEqual([version, faults], [manifest.version, []]);
  assert.notEqual(notesOf(read('CHANGELOG.md'), version), '');
  const citation = (text) => versionOf((name) => (name === 'CITATION.cff' ? text : read(name))).faults.join();
  assert.match(citation(read('CITATION.cff').replace(version, '7.8.9')), /7\.8\.9 in CITATION\.cff/);
  assert.match(citation(read('CITATION.cff').replace(/(?<=date-released: ).*/, '1999-01-01')), /The dates differ/);
  assert.match(citation(''), /CITATION\.cff names no version/);
});

test('the notes of a version end where the next begins, or the links', () => {
  const changelog = '# C\n\n## [0.2.0] - 2027-01-01\n\n- New.\n\n## [0.1.0] - 2026-01-01\n\nOld.\n\n[0.2.0]: x\n';
  assert.deepEqual(
    ['0.2.0', '0.1.0', '0.3.0'].map((version) => notesOf(changelog, version)),
    ['- New.', 'Old.', ''],
  );
});

test('a package without its licences is refused', () => {
  const paths = ['LICENSE-MIT', 'LICENSE-APACHE', 'README.md', 'dist/index.js'];
  assert.deepEqual(absent(paths), ['dist/THIRD-PARTY-LICENSES.txt']);
});

test('only the workflow publishes: at the tag of this version, of this repository, with a token to sign with', () => {
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
  const { GITHUB_ACTIONS, ...here } = process.env;
  const { status, stderr } = spawnSync(process.execPath, ['scripts/release.mjs', '--publish'], {
    cwd: root,
    env: here,
    encoding: 'utf8',
  });
  assert.equal(status, 1);
  assert.match(stderr, /Publishing is for the workflow release\.yml/);
});

test('the workflow runs this script at tags alone, and keeps no secret', () => {
  const workflow = read(join('.github', 'workflows', 'release.yml'));
  assert.match(workflow, /^on:\n {2}push:\n {4}tags: \['v\[0-9\]\*'\]\n\n/m);
  assert.match(workflow, /run: npm run release -- --publish$/m);
  assert.doesNotMatch(workflow, /secrets\./);
});
