// What rustdoc has to say of a Rust library, as JSON. That form is not stable yet, so rustdoc is told to act as a
// nightly one, and is asked by itself: told so through cargo, it would build all dependencies once more.

import { spawnSync } from 'node:child_process';
import { readFileSync } from 'node:fs';
import { dirname, join } from 'node:path';
import { fail, root } from '../tools.mjs';

/** Describes the library whose first file is `file`, with the names and files of the libraries that it takes. */
export function describe(file, { name, edition, folder, libraries = [], env = {} }) {
  const externs = libraries.flatMap(([extern, library]) => ['--extern', `${extern}=${library}`]);
  const folders = new Set(libraries.map(([, library]) => `dependency=${dirname(library)}`));
  const crate = ['--crate-name', name, '--edition', edition, file];
  const form = ['-Z', 'unstable-options', '--output-format', 'json', '--out-dir', folder];
  command('rustdoc', [...crate, ...[...folders].flatMap((place) => ['-L', place]), ...externs, ...form], {
    ...env,
    RUSTC_BOOTSTRAP: '1',
  });
  return JSON.parse(readFileSync(join(folder, `${name}.json`), 'utf8'));
}

/** Describes the project's own library, without features, as docs.rs shows it. */
export function describeProject() {
  // Of this platform alone, or cargo would fetch what others need.
  const [, host] = /^host: (.+)$/m.exec(command('rustc', ['--version', '--verbose']));
  const form = ['--locked', '--format-version', '1', '--filter-platform', host];
  const { packages, resolve } = JSON.parse(command('cargo', ['metadata', ...form]));
  const { name, version, edition } = packages.find(({ id }) => id === resolve.root);
  const own = resolve.nodes.find(({ id }) => id === resolve.root).deps;
  return describe(join('src', 'lib.rs'), {
    name,
    edition,
    folder: join(root, 'target', 'api'),
    libraries: dependencies(own),
    env: { CARGO_PKG_VERSION: version, CARGO_MANIFEST_DIR: root },
  });
}

/** Name and file of each of these dependencies, from cargo, which checks what it has not checked before. */
function dependencies(own) {
  return command('cargo', ['check', '--locked', '--lib', '--message-format', 'json'])
    .trim()
    .split('\n')
    .map((line) => JSON.parse(line))
    .filter(({ reason, target }) => reason === 'compiler-artifact' && !target.kind.includes('custom-build'))
    .flatMap(({ package_id: id, filenames }) => {
      const name = own.find(({ pkg }) => pkg === id)?.name;
      const library = filenames.find((path) => /\.(rmeta|so|dylib|dll)$/.test(path));
      return name && library ? [[name, library]] : [];
    });
}

/** What a command prints; its complaints go to the console. */
function command(name, args, env = {}) {
  const { status, stdout, error } = spawnSync(name, args, {
    cwd: root,
    encoding: 'utf8',
    stdio: ['ignore', 'pipe', 'inherit'],
    env: { ...process.env, ...env },
    maxBuffer: 1 << 28,
  });
  if (status !== 0) fail(`${name} ${args[0]} failed. ${error?.message ?? ''}`);
  return stdout;
}
