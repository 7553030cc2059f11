// What SECURITY.md promises of the code: no `unsafe`, and what is made of the answers of cargo-deny and npm.

import assert from 'node:assert/strict';
import { execFileSync } from 'node:child_process';
import { existsSync, readFileSync } from 'node:fs';
import { join } from 'node:path';
import { test } from 'node:test';
import { crateAnswer, packageAnswer } from '../../scripts/audit.mjs';
import { root } from '../../scripts/tools.mjs';

const textOf = (name) => readFileSync(join(root, name), 'utf8').replaceAll('\r', '');

/** The code of a Rust file without its comments and texts. */
const codeOf = (name) => textOf(name).replace(/\/\/.*|"(\\.|[^"\\])*"/g, '');

test(
  'every package of the workspace forbids unsafe code, and no file has any',
  { skip: !existsSync(join(root, '.git')) },
  () => {
    const forbids = (manifest) => /\n\[lints(?:\.rust)?\]\n(workspace = true|unsafe_code = "forbid")\n/.test(manifest);
    const main = textOf('Cargo.toml');
    assert.match(main, /\n\[workspace\.lints\.rust\]\nunsafe_code = "forbid"\n/);
    const [, members] = /\nmembers = \[(.*?)\]/s.exec(`\n${main}`);
    const folders = ['.', ...[...members.matchAll(/"(.*?)"/g)].map(([, folder]) => folder)];
    assert.ok(folders.length >= 5, `${folders}`);
    assert.deepEqual(
      folders.filter((folder) => !forbids(textOf(join(folder, 'Cargo.toml')))),
      [],
    );
    const files = execFileSync('git', ['ls-files', '*.rs'], { cwd: root, encoding: 'utf8' }).trim().split('\n');
    assert.ok(files.length > 200, `${files.length} files`);
    assert.deepEqual(
      files.filter((name) => existsSync(join(root, name)) && /\bunsafe\b/.test(codeOf(name))),
      [],
    );
  },
);

test('what cargo-deny says is clean, found, or could not be looked at', () => {
  assert.equal(crateAnswer(0, 'advisories ok').state, 'clean');
  assert.equal(crateAnswer(1, 'error[vulnerability]: buffer overflow\nadvisories FAILED').state, 'found');
  assert.equal(crateAnswer(2, 'error[rejected]: failed to satisfy license requirements').state, 'found');
  const without = '[ERROR] failed to fetch advisory database x: failed to clone\nfatal: Could not resolve host';
  assert.deepEqual(crateAnswer(1, without), { state: 'open', words: 'fatal: Could not resolve host' });
  assert.deepEqual(crateAnswer(null, ''), { state: 'open', words: 'no answer in time' });
});

test('what npm says is of all packages, or of those that ours carries', () => {
  const report = JSON.stringify({
    vulnerabilities: {
      fflate: { name: 'fflate', severity: 'high', range: '<0.9' },
      webpack: { name: 'webpack', severity: 'low', range: '*' },
    },
  });
  assert.deepEqual(
    packageAnswer(report, (name) => name === 'fflate'),
    { state: 'found', words: 'fflate <0.9: high' },
  );
  assert.match(packageAnswer(report, () => true).words, /webpack \*: low/);
  assert.equal(packageAnswer(report, () => false).state, 'clean');
  assert.equal(packageAnswer('{"vulnerabilities": {}}', () => true).state, 'clean');
  assert.deepEqual(
    packageAnswer('{"message": "405 Method Not Allowed"}', () => true),
    { state: 'open', words: '405 Method Not Allowed' },
  );
  assert.equal(packageAnswer('', () => true).state, 'open');
});
