// Release, packing and audit: what their scripts refuse. And files that must agree: versions, links, arguments for ffmpeg.

import assert from 'node:assert/strict';
import { spawnSync } from 'node:child_process';
import { existsSync, readFileSync } from 'node:fs';
import { dirname, join } from 'node:path';
import { test } from 'node:test';
import * as ffmpegArguments from '../../dist/node/ffmpeg.js';
import { crateAnswer, packageAnswer } from '../../scripts/audit.mjs';
import { absentFrom } from '../../scripts/pack.mjs';
import { notesOf, obstacles, versionOf } from '../../scripts/release.mjs';
import { output, root } from '../../scripts/tools.mjs';

const read = (file) => readFileSync(join(root, file), 'utf8');
const manifest = JSON.parse(read('package.json'));

test('all files have the same version and date; a file that differs, or has none, is named', () => {
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

test('npm packs the whole package, and refuses one with only what the page of `npm start` loads', () => {
  assert.match(manifest.scripts.prepack, /^node scripts\/pack\.mjs\b/);
  const isOfPage = (path) => !/\.d\.c?ts$|\.cjs$|inline\.js$|worker\.bundle\.js$/.test(path);
  const missing = absentFrom(manifest, isOfPage);
  for (const name of ['index.d.ts', 'node/index.d.cts', 'node/index.cjs', 'inline.js', 'worker.bundle.js'])
    assert.ok(missing.includes(`dist/${name}`), name);
  assert.ok(missing.length >= 22, `${missing.length} missing`);
  assert.deepEqual(
    absentFrom(manifest, (path) => path !== 'LICENSE-MIT'),
    ['LICENSE-MIT'],
  );
  assert.deepEqual(
    absentFrom(manifest, () => true),
    [],
  );
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

test('cargo-deny’s output is clean, found, or could not be checked', () => {
  assert.equal(crateAnswer(0, 'advisories ok').state, 'clean');
  assert.equal(crateAnswer(1, 'error[vulnerability]: buffer overflow\nadvisories FAILED').state, 'found');
  assert.equal(crateAnswer(2, 'error[rejected]: failed to satisfy license requirements').state, 'found');
  const without = '[ERROR] failed to fetch advisory database x: failed to clone\nfatal: Could not resolve host';
  assert.deepEqual(crateAnswer(1, without), { state: 'open', words: 'fatal: Could not resolve host' });
  assert.deepEqual(crateAnswer(null, ''), { state: 'open', words: 'no answer in time' });
});

test('npm’s report covers all packages, or the ones bundled in ours', () => {
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

const HERE = /^https:\/\/(raw\.githubusercontent|github)\.com\/tracecut\/tracecut\/((blob|tree)\/)?HEAD\//;

test('every link to a file of the repository leads to one', () => {
  const links = output('git', ['ls-files', '*.md'])
    .split('\n')
    .flatMap((file) =>
      [...readFileSync(join(root, file), 'utf8').matchAll(/\]\(([^)#\s]+)/g)].map(([, target]) => ({ file, target })),
    )
    .filter(({ target }) => HERE.test(target) || !/^[a-z]+:/.test(target));
  assert.ok(links.length > 50, `${links.length} links`);
  // Registries show the README on pages of their own.
  assert.ok(links.every(({ file, target }) => file !== 'README.md' || HERE.test(target)));
  const place = ({ file, target }) => join(root, HERE.test(target) ? '.' : dirname(file), target.replace(HERE, ''));
  assert.deepEqual(
    links.filter((link) => !existsSync(place(link))),
    [],
  );
});

const rust = readFileSync(join(root, 'cli', 'src', 'ffmpeg.rs'), 'utf8').replaceAll('\r', '');

/** The value of a constant of Rust: a text, or a list of texts and of names of other constants. */
function constant(name) {
  const [, source] = new RegExp(`^const ${name}: [^=]*= &?([^;]*);$`, 'm').exec(rust) ?? [];
  assert.ok(source, `cli/src/ffmpeg.rs has no constant ${name}`);
  const texts = source.replace(/\\\n\s*/g, '').matchAll(/"([^"]*)"|\b([A-Z_]+)\b/g);
  const list = [...texts].map(([, text, name]) => text ?? constant(name));
  return source.startsWith('[') ? list : list[0];
}

test('the arguments for ffmpeg equal the command line’s', () => {
  for (const name of ['GENERAL', 'LIST', 'DECODE', 'FILTERS', 'WRITE'])
    assert.deepEqual(ffmpegArguments[name], constant(name), name);
});
