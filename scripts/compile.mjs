// TypeScript as the JavaScript that browsers and Node run: the types go, the code stays as it is. Whether the types agree
// is for the compiler, in the build and in the tests.

import { readdirSync, rmSync } from 'node:fs';
import { join } from 'node:path';
import { root } from './tools.mjs';

/** The page, beside the files of `studio/` that are served as they are. */
export const PAGE = join(root, 'build');

/** Compiles the modules of `npm` into `dist`. */
export async function compilePackage() {
  const { build } = await import('esbuild');
  await build(options('npm', join(root, 'dist')));
}

/**
 * Compiles the page.
 * @param {{watch?: boolean}} [options] `watch` to compile again after each edit, until the process ends
 */
export async function compilePage({ watch = false } = {}) {
  const { build, context } = await import('esbuild');
  if (watch) return (await context(options('studio', PAGE))).watch();
  rmSync(PAGE, { recursive: true, force: true });
  await build(options('studio', PAGE));
}

/** @param {string} folder @param {string} outdir */
function options(folder, outdir) {
  const names = readdirSync(join(root, folder), { recursive: true }).filter((name) => /(?<!\.d)\.ts$/.test(name));
  const entryPoints = names.map((name) => join(root, folder, name));
  return {
    entryPoints,
    outdir,
    outbase: join(root, folder),
    format: 'esm',
    target: 'es2022',
    charset: 'utf8',
    logLevel: 'warning',
  };
}
