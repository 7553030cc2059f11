// `npm run site -- [folder]`: the page as a folder for any static host (out/site if not given); works from any
// sub-path. Its code is bundled and minified, with source maps; what is served while one works on the page is as
// written.

import { cpSync, mkdirSync, readFileSync, readdirSync, rmSync, writeFileSync } from 'node:fs';
import { basename, dirname, join, relative, resolve, sep } from 'node:path';
import { pathToFileURL } from 'node:url';
import { build as bundle, transform } from 'esbuild';
import { build } from './build.mjs';
import { writeLicences } from './licences.mjs';
import { listed, precacheList, serviceWorker } from './serve.mjs';
import { root } from './tools.mjs';

/** Code that is found by its place: bundles of these names, each with what only it needs. */
const BUNDLES = [
  { folder: 'dist', entries: ['index.js', 'selftest.js', 'worker.js', 'lab.js'] },
  { folder: 'dist', entries: ['aside-worker.js'] },
  { folder: 'view', entries: ['main.js', 'page.js'] },
];

/**
 * Least bytes of a bundle that names its source map: the name alone weighs 35, and a visit loads many small parts.
 * Their maps lie beside them all the same.
 */
const LEAST_MAPPED = 4096;

/** Folders as they are built, and as they are served. */
const PLACES = { dist: join(root, 'dist'), view: join(root, 'studio', 'view') };

/** Where the page finds the package, which it imports by name: its document says so to browsers. */
const IMPORT_MAP = /\s*<script type="importmap">([^<]*)<\/script>/;
const PAGE = readFileSync(join(root, 'studio', 'index.html'), 'utf8');
const { imports: NAMES } = JSON.parse(/** @type {string} */ (IMPORT_MAP.exec(PAGE)?.[1]));

/** The page's list of the package's entries: served as the one file that they are together, which weighs less. */
const LIBRARY = join(root, 'studio', 'model', 'library.ts');

/** Browsers for which nested style rules are unfolded. */
const CSS_BROWSERS = ['chrome105', 'firefox121', 'safari16.4'];

/** The lab is bundled with the package, so that it loads only what it takes of it. */
const LAB = join(root, 'www');

/**
 * Writes the site of what is built.
 * @param {string} target a folder; what else is in it stays
 * @param {{splits?: boolean}} [options] whether what is needed later has files of its own
 * @returns {Promise<string[]>} the files that a page may ask for, relative to it
 */
export async function writeSite(target, { splits = true } = {}) {
  // Parts of an earlier site have other names.
  for (const { folder } of BUNDLES) rmSync(join(target, folder), { recursive: true, force: true });
  const isMade = (name) => /\.(js|css|html)$/.test(name) && !name.startsWith('./dist/vendor/');
  const names = precacheList().files.map(([file]) => file);
  for (const name of names.filter((file) => !file.endsWith('/') && !isMade(file))) {
    const to = join(target, name);
    mkdirSync(dirname(to), { recursive: true });
    cpSync(name.startsWith('./dist/') ? join(root, name) : join(root, 'studio', name), to);
  }
  await writeDocument(target);
  await writeLab(join(target, 'lab'));
  for (const name of ['media.js', 'zip.js']) copyWithMap(join('dist', 'vendor', name), target);
  for (const one of BUNDLES) await writeBundle(one, target, splits);
  const list = siteList(target);
  await writeServiceWorker(list, target);
  return list.files.map(([file]) => file);
}

/**
 * The files of a site that a page may ask for.
 * @param {string} target the folder of the site
 * @param {Record<string, string>} [instead] as of `listed`
 */
export function siteList(target, instead) {
  const wanted = (/** @type {string} */ name) =>
    /^(dist|view|icons|lab)\/|^(index\.html|page\.css|favicon\.svg|manifest\.webmanifest)$/.test(name) &&
    !name.endsWith('.map');
  return listed([{ folder: target, at: './', wanted }], instead);
}

/** @param {{version: string, files: string[]}} list @param {string} target */
async function writeServiceWorker(list, target) {
  const name = 'service-worker.js';
  const shape = { loader: /** @type {const} */ ('js'), minify: true, sourcemap: true, sourcefile: `../${name}` };
  const { code, map } = await transform(serviceWorker(list), shape);
  writeFileSync(join(target, `${name}.map`), map);
  writeFileSync(join(target, name), `${code}//# sourceMappingURL=${name}.map\n`);
}

/** A bundle of the package, which names its source map only where that lies beside it. */
function copyWithMap(name, target) {
  cpSync(join(root, `${name}.map`), join(target, `${name}.map`));
  const code = readFileSync(join(root, name), 'utf8');
  writeFileSync(join(target, name), `${code}//# sourceMappingURL=${basename(name)}.map\n`);
}

/**
 * The document, its style sheets as one in their order. Bundles name files by their places: there is no import map, so
 * that older browsers can open the site, and nothing inline is allowed.
 * @param {string} target
 */
async function writeDocument(target) {
  await writePage(target, PAGE, 'page.css', (href) => join(root, 'studio', href));
}

/** The lab's document and its style sheet. @param {string} target */
async function writeLab(target) {
  const html = readFileSync(join(LAB, 'index.html'), 'utf8').replace('./main.js', '../dist/lab.js');
  mkdirSync(target, { recursive: true });
  // The base sheet is the studio's.
  const pathOf = (/** @type {string} */ href) =>
    href.startsWith('../') ? join(root, 'studio', href.slice(3)) : join(LAB, href);
  await writePage(target, html, 'style.css', pathOf);
}

/**
 * @param {string} target a folder
 * @param {string} source the document
 * @param {string} name of its only style sheet there
 * @param {(href: string) => string} pathOf returns where a sheet of the source lies
 */
async function writePage(target, source, name, pathOf) {
  const link = /\s*<link rel="stylesheet" href="(.*?)">/g;
  const sheets = [...source.matchAll(link)].map(([, href]) => readFileSync(pathOf(href), 'utf8'));
  let count = 0;
  const one = `\n<link rel="stylesheet" href="./${name}">`;
  const html = withoutImportMap(source).replace(link, () => (count++ === 0 ? one : ''));
  // No element of the page keeps white space as it is.
  writeFileSync(join(target, 'index.html'), html.replace(/\n\s+/g, '\n'));
  const { code } = await transform(sheets.join('\n'), { loader: 'css', minify: true, target: CSS_BROWSERS });
  writeFileSync(join(target, name), code);
}

/** @param {string} html */
const withoutImportMap = (html) => html.replace(IMPORT_MAP, '').replace(/ 'sha256-[^']*'/, '');

/**
 * @param {{folder: string, entries: string[]}} one
 * @param {string} target
 * @param {boolean} splits
 */
async function writeBundle({ folder, entries }, target, splits) {
  // Source maps name sources by their way from here: wherever the site goes, they are the same.
  const made = join(root, 'out', 'site');
  const { outputFiles } = await bundle({
    entryPoints: entries.map((name) => ({ in: sourceOf(folder, name), out: basename(name, '.js') })),
    outdir: join(made, folder),
    write: false,
    bundle: true,
    splitting: splits,
    minify: true,
    sourcemap: true,
    format: 'esm',
    chunkNames: '[hash]',
    plugins: [apart(folder)],
    logLevel: 'warning',
  });
  for (const { path, text } of outputFiles) {
    const to = join(target, relative(made, path));
    mkdirSync(dirname(to), { recursive: true });
    writeFileSync(to, text.length < LEAST_MAPPED ? text.replace(/\/\/# sourceMappingURL=.*\n$/, '') : text);
  }
}

/** @param {string} folder @param {string} name of a bundle in it */
function sourceOf(folder, name) {
  if (name === 'lab.js') return join(LAB, 'main.js');
  if (folder === 'view') return join(PLACES.view, name.replace('.js', '.ts'));
  return name === 'index.js' ? LIBRARY : join(PLACES.dist, name);
}

/**
 * What other projects made, and the package beside the page, stay files of their own.
 * @param {string} folder of the bundle in the site; all its files lie in it
 * @returns {import('esbuild').Plugin}
 */
function apart(folder) {
  const setup = (/** @type {import('esbuild').PluginBuild} */ { onResolve }) =>
    onResolve({ filter: /./ }, ({ path, resolveDir, importer, kind }) => {
      if (kind === 'entry-point') return undefined;
      if (importer === LIBRARY) return { path: join(PLACES.dist, path.replace(/^.*\/dist\//, '')) };
      const [, entry] = (dirname(importer) === LAB && /^tracecut(?:\/(\w+))?$/.exec(path)) || [];
      if (path === 'tracecut' || entry) {
        return { path: join(PLACES.dist, `${entry ?? 'index'}.js`), sideEffects: false };
      }
      const place = resolve(resolveDir, path);
      const inDist = relative(PLACES.dist, place).replaceAll(sep, '/');
      const ofPage = place === LIBRARY.replace('.ts', '.js') ? 'dist/index.js' : NAMES[path];
      const file = folder === 'view' ? ofPage : /^(vendor\/|index\.js$)/.test(inDist) && `dist/${inDist}`;
      if (!file) return undefined;
      const to = relative(folder, file).replaceAll(sep, '/');
      return { path: to.startsWith('.') ? to : `./${to}`, external: true };
    });
  return { name: 'apart', setup };
}

if (import.meta.url === pathToFileURL(process.argv[1]).href) {
  const target = resolve(process.argv[2] ?? join(root, 'out', 'site'));
  await build();
  await writeSite(target);
  writeLicences(join(target, 'dist'));
  console.log(`The site is in ${target}: ${readdirSync(target, { recursive: true }).length} files and folders.`);
}
