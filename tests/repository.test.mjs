// What the scripts of the repository do: release, packing, audit, the development server and the built site. And files that must agree:
// versions, links, arguments for ffmpeg.

import assert from 'node:assert/strict';
import { spawnSync } from 'node:child_process';
import {
  existsSync,
  mkdirSync,
  mkdtempSync,
  readdirSync,
  readFileSync,
  rmSync,
  symlinkSync,
  writeFileSync,
} from 'node:fs';
import { request } from 'node:http';
import { networkInterfaces, tmpdir } from 'node:os';
import { dirname, join } from 'node:path';
import { test } from 'node:test';
import * as ffmpegArguments from '../dist/node/ffmpeg.js';
import { crateAnswer, packageAnswer } from '../scripts/audit.mjs';
import { absentFrom } from '../scripts/pack.mjs';
import { notesOf, obstacles, versionOf } from '../scripts/release.mjs';
import { serve } from '../scripts/serve.mjs';
import { writeSite } from '../scripts/site.mjs';
import { output, root } from '../scripts/tools.mjs';

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

/** Requests a path as it is written; `fetch` would normalize it. */
function rawRequest(base, path, { method = 'GET', headers = {}, hostname = new URL(base).hostname } = {}) {
  return new Promise((resolve, reject) => {
    const { port } = new URL(base);
    request({ hostname, port, path, method, headers }, (response) => {
      response.resume();
      resolve({ status: response.statusCode, type: response.headers['content-type'] });
    })
      .on('error', reject)
      .end();
  });
}

test('serves files with their types', async (t) => {
  const server = await serve();
  t.after(() => server.close());
  assert.deepEqual(await rawRequest(server.url, '/dist/index.js'), {
    status: 200,
    type: 'text/javascript; charset=utf-8',
  });
  assert.deepEqual(await rawRequest(server.url, '/dist/tracecut_bg.wasm'), { status: 200, type: 'application/wasm' });
  assert.deepEqual(await rawRequest(server.url, '/'), { status: 200, type: 'text/html; charset=utf-8' });
  assert.deepEqual(await rawRequest(server.url, '/lab/'), { status: 200, type: 'text/html; charset=utf-8' });
  assert.deepEqual(await rawRequest(server.url, '/styles/base.css', { method: 'HEAD' }), {
    status: 200,
    type: 'text/css; charset=utf-8',
  });
});

test('serves no path outside of its folders', async (t) => {
  const server = await serve();
  t.after(() => server.close());
  for (const path of [
    '/../package.json',
    '/%2e%2e/package.json',
    '/..%2fpackage.json',
    '/dist/../../package.json',
    '/dist/..%2f..%2fpackage.json',
    '/dist/..%5c..%5cpackage.json',
    '/dist/%2e%2e%2f%2e%2e%2fpackage.json',
    '/dist/%2E%2E/%2E%2E/package.json',
    '/dist/%252e%252e%252f%252e%252e%252fpackage.json',
    '/dist/..%255c..%255cpackage.json',
    '/dist/%c0%ae%c0%ae/%c0%ae%c0%ae/package.json',
    '/dist/....//....//package.json',
    '/dist/..;/package.json',
    '//package.json',
    '//etc/passwd',
    '/dist//etc/passwd',
    '/%2fetc%2fpasswd',
    '/dist/index.js%00',
    '/dist/index.js%00.html',
    '/%00',
    '/%',
    '/dist',
    '/dist/',
    '/nothing.js',
    '/package.json',
  ]) {
    assert.equal((await rawRequest(server.url, path)).status, 404, path);
  }
  assert.equal((await rawRequest(server.url, '/', { method: 'POST' })).status, 405);
});

test('follows no link out of a folder', async (t) => {
  const outside = mkdtempSync(join(tmpdir(), 'tracecut-'));
  t.after(() => rmSync(outside, { recursive: true, force: true }));
  const folder = join(outside, 'open');
  mkdirSync(folder);
  writeFileSync(join(outside, 'secret.js'), 'secret');
  writeFileSync(join(folder, 'file.js'), 'open');
  symlinkSync(outside, join(folder, 'up'));
  symlinkSync(join(outside, 'secret.js'), join(folder, 'secret.js'));
  symlinkSync('file.js', join(folder, 'same.js'));
  const server = await serve({ places: [{ prefix: '/', folder }] });
  t.after(() => server.close());
  for (const path of ['/up/secret.js', '/secret.js', '/up/open/file.js/../../secret.js'])
    assert.equal((await rawRequest(server.url, path)).status, 404, path);
  for (const path of ['/file.js', '/same.js', '/up/open/file.js'])
    assert.equal((await rawRequest(server.url, path)).status, 200, path);
});

test('answers only this machine, and only under its own names', async (t) => {
  const server = await serve();
  t.after(() => server.close());
  const externalAddresses = Object.values(networkInterfaces()).flatMap((addresses) =>
    addresses.filter(({ internal }) => !internal),
  );
  for (const { address, scopeid } of externalAddresses) {
    const hostname = scopeid ? `${address}%${scopeid}` : address;
    await assert.rejects(rawRequest(server.url, '/', { hostname }), undefined, address);
  }
  for (const host of ['rebound.example', '127.0.0.1.example', 'localhost.example:80'])
    assert.equal((await rawRequest(server.url, '/', { headers: { host } })).status, 403, host);
  const { port } = new URL(server.url);
  for (const host of [`localhost:${port}`, `127.0.0.1:${port}`, '[::1]', 'LOCALHOST'])
    assert.equal((await rawRequest(server.url, '/', { headers: { host } })).status, 200, host);
});

test('every script of the site has a source map with its sources, and names no path of this machine', async (t) => {
  const folder = mkdtempSync(join(tmpdir(), 'tracecut-site-'));
  t.after(() => rmSync(folder, { recursive: true, force: true }));
  const listed = await writeSite(folder);
  const scripts = readdirSync(folder, { recursive: true }).filter((name) => name.endsWith('.js'));
  assert.ok(scripts.length > 30, `${scripts.length} scripts`);
  for (const path of scripts.map((name) => join(folder, name))) {
    const code = readFileSync(path, 'utf8');
    const { sources, sourcesContent } = JSON.parse(readFileSync(`${path}.map`, 'utf8'));
    assert.equal(sourcesContent.filter(Boolean).length, sources.length, path);
    const isLocal = (source) => source.startsWith('/') || source.includes(folder.slice(1));
    assert.deepEqual(sources.filter(isLocal), []);
    // Small scripts do not name their map, to save bytes.
    const map = /\/\/# sourceMappingURL=(\S+)\s*$/.exec(code)?.[1];
    if (map || code.length >= 4096) assert.ok(map && existsSync(join(dirname(path), map)), path);
  }
  const isMap = (name) => name.endsWith('.map');
  assert.deepEqual(listed.filter(isMap), []);
});

test('the manifest makes the page installable, with icons of the sizes that it names', () => {
  const read = (name) => readFileSync(join(root, 'studio', name));
  assert.match(String(read('index.html')), /<link rel="manifest" href="\.\/manifest\.webmanifest">/);
  const { display, icons } = JSON.parse(read('manifest.webmanifest'));
  assert.equal(display, 'standalone');
  for (const { src, sizes, type } of icons) {
    const bytes = read(src);
    if (type === 'image/svg+xml') assert.ok(sizes === 'any' && bytes.includes('<svg'), src);
    else assert.equal(`${bytes.readUInt32BE(16)}x${bytes.readUInt32BE(20)}`, sizes, src);
  }
});
