// The repository's files agree: versions, links, the words for ffmpeg, and what SECURITY.md promises.

import assert from 'node:assert/strict';
import { execFileSync, spawnSync } from 'node:child_process';
import { existsSync, readFileSync } from 'node:fs';
import { dirname, join } from 'node:path';
import { test } from 'node:test';
import * as words from '../../dist/node/ffmpeg.js';
import { crateAnswer, packageAnswer } from '../../scripts/audit.mjs';
import { absentFrom } from '../../scripts/pack.mjs';
import { IS_PUBLISHED, notesOf, obstacles, versionOf } from '../../scripts/release.mjs';
import { PARTS } from '../../scripts/release/local.mjs';
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

test('the workflow runs this script at tags alone, and keeps no secret', () => {
  const workflow = read(join('.github', 'workflows', 'release.yml'));
  assert.match(workflow, /^on:\n {2}push:\n {4}tags: \['v\[0-9\]\*'\]\n\n/m);
  assert.match(workflow, /run: npm run release -- --publish$/m);
  assert.doesNotMatch(workflow, /secrets\./);
});

test('the workflow builds a wheel and the program for each system, and publishes only when all are built', () => {
  const workflow = read(join('.github', 'workflows', 'release.yml'));
  const targets = [...workflow.matchAll(/target: (\S+?)[ ,]/g)].map(([, target]) => target);
  assert.deepEqual(targets.filter((target) => !target.startsWith('$')).sort(), [
    'aarch64-apple-darwin',
    'aarch64-unknown-linux-gnu',
    'x86_64-apple-darwin',
    'x86_64-pc-windows-msvc',
    'x86_64-unknown-linux-gnu',
  ]);
  assert.match(workflow, /PyO3\/maturin-action@v\d\n[^]*manylinux: '2014'\n/);
  assert.match(workflow, /\n {2}publish:\n {4}needs: build\n/);
  const [, readmes] = /HERE \/ "tests" \/ "(\w+\.py)", PYTHONPATH=""/.exec(read('python/run_tests.py'));
  const checks = ['twine check --strict', 'abi3audit --strict', `python/tests/${readmes}`, 'npm run --silent docs'];
  for (const check of checks) assert.ok(workflow.includes(check), check);
  const [, oldest] = /"abi3-py(\d+)"/.exec(read('python/Cargo.toml'));
  assert.equal(/requires-python = ">=(.*)"/.exec(read('python/pyproject.toml'))[1].replace('.', ''), oldest);
});

const tracked = (...patterns) => output('git', ['ls-files', '--', ...patterns]).split('\n');

test('documents name packages where they are: in `out` until a version is published', () => {
  const readme = read('README.md');
  const install = readme.split(/^## /m).find((section) => section.startsWith('Install\n'));
  const says = ['README.md', 'python/README.md', 'cli/README.md', 'examples/README.md'].filter((file) =>
    /[Nn]o version is published yet/.test(read(file)),
  );
  // Names in a registry. (`pip install 'tracecut[video]'` in error messages finds the installed package.)
  const names = /\b(npm (install|i)|pip install|cargo (install|add)) (--locked )?["']?tracecut(-cli)?\b(?! --path)/;
  const naming = tracked('*.md', ':!CHANGELOG.md').filter((file) => names.test(read(file)));
  if (IS_PUBLISHED) {
    assert.deepEqual(says, []);
    for (const command of ['npm install tracecut', 'pip install tracecut', 'cargo install --locked tracecut-cli'])
      assert.ok(install.includes(command), command);
    return;
  }
  assert.deepEqual([says.length, naming], [4, []]);
  assert.ok(install.includes('npm run release -- --local'));
  const rows = [...install.matchAll(/^\| `(\w+)` \|/gm)].map(([, part]) => part);
  assert.deepEqual(rows, Object.keys(PARTS));
  const files = new RegExp(`tracecut-${manifest.version.replaceAll('.', '\\.')}[-.](tgz|cp39-abi3|crate)`, 'g');
  assert.ok([...install.matchAll(files)].length >= 3);
});

test('Cargo takes the versions of Cargo.lock, in documents and scripts', () => {
  const isUnlocked = (line) => !line.includes('--locked');
  const linesWith = (pattern, ...files) =>
    tracked(...files)
      .filter((file) => existsSync(join(root, file)))
      .flatMap((file) =>
        read(file)
          .split('\n')
          .map((line) => ({ file, line })),
      )
      .filter(({ line }) => pattern.test(line));
  const installs = linesWith(/cargo (install|package|publish) \S/, ':!CHANGELOG.md', ':!tests', ':!*.mjs');
  assert.ok(installs.length > 4, `${installs.length} lines`);
  assert.deepEqual(
    installs.filter(({ line }) => isUnlocked(line)),
    [],
  );
  const users = linesWith(/cargo (build|run) (?!.*tracecut-bench)/, 'README.md', 'docs', 'examples', '*/README.md');
  assert.deepEqual(
    users.filter(({ line }) => isUnlocked(line)),
    [],
  );
  const automatic = linesWith(/^[^#]*\bcargo (build|clippy|doc|run|test) /, '.ci', '.github');
  assert.ok(automatic.length > 3, `${automatic.length} lines`);
  assert.deepEqual(
    automatic.filter(({ line }) => isUnlocked(line)),
    [],
  );
  const called = linesWith(/'cargo'.*'(build|test|rustc|rustdoc|package|publish)'/, 'scripts', 'tests/*.mjs');
  assert.ok(called.length > 5, `${called.length} lines`);
  assert.deepEqual(
    called.filter(({ file, line }) => isUnlocked(line) && !line.includes("'fuzz'") && file),
    [],
  );
});

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
  const list = [...texts].map(([, text, other]) => text ?? constant(other));
  return source.startsWith('[') ? list : list[0];
}

test('the arguments for ffmpeg equal the command line’s', () => {
  for (const name of ['GENERAL', 'LIST', 'DECODE', 'FILTERS', 'WRITE'])
    assert.deepEqual(words[name], constant(name), name);
});

test('all files are formatted', () => {
  const { status, stderr } = spawnSync(process.execPath, ['scripts/format.mjs', '--check'], {
    cwd: root,
    encoding: 'utf8',
  });
  assert.equal(status, 0, stderr);
});
