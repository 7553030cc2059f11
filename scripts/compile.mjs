// TypeScript as the JavaScript that browsers and Node run: the types go, the code stays as it is. Whether the types agree
// is for the compiler, in the build and in the tests. The declarations that the compiler writes get what they lack: names of
// the platform, and descriptions of what is loaded later.

import { readFileSync, readdirSync, rmSync, writeFileSync } from 'node:fs';
import { dirname, join, posix, relative } from 'node:path';
import { pathToFileURL } from 'node:url';
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

/** The declarations that know the platform's names, below `dist`. */
const DOM = 'dom.d.ts';

/** A part that is loaded later, as the compiler declares it: without its description. */
const LOADED_LATER = /^export declare const (\w+): typeof import\(['"]([^'"]+)['"]\)\.\1;$/gm;

/**
 * Puts an import before each declaration file of `dist` that mentions names of the platform, so that it compiles in
 * projects that do not have them. What is loaded later is declared where it is written.
 */
export function finishDeclarations(dist) {
  const names = exported(readFileSync(join(dist, DOM), 'utf8'));
  const files = readdirSync(dist, { recursive: true }).map((file) => file.replaceAll('\\', '/'));
  for (const name of files.filter((file) => file.endsWith('.d.ts') && file !== DOM && !file.startsWith('vendor/'))) {
    const file = join(dist, name);
    const text = readFileSync(file, 'utf8')
      .replace(/^import type \{.*\} from '[./]*dom\.js';\n/, '')
      .replace(LOADED_LATER, "export { $1 } from '$2';");
    const used = names.filter((one) => mentions(text, one));
    const from = posix.join(relative(dirname(name), '.').replaceAll('\\', '/') || '.', 'dom.js');
    const line = `import type { ${used.join(', ')} } from '${from.startsWith('.') ? from : `./${from}`}';\n`;
    writeFileSync(file, used.length > 0 ? line + text : text);
  }
}

function exported(declarations) {
  return [...declarations.matchAll(/^export (?:declare )?(?:type|interface|namespace) (\w+)/gm)].map(
    ([, name]) => name,
  );
}

/** Whether a name stands outside of comments and strings, alone: not as a property, nor as one of another module. */
function mentions(declarations, name) {
  const code = declarations.replace(/\/\*[^]*?\*\/|\/\/.*$|'[^'\n]*'|"[^"\n]*"/gm, '');
  return new RegExp(`(?<![.\\w])${name}\\b(?!\\??\\s*:)`).test(code);
}

if (import.meta.url === pathToFileURL(process.argv[1] ?? '').href) await compilePage();
