// `npm run site -- [folder]`: the page as a folder for any static host (out/site if not given); works from any
// sub-path. Its code is bundled and minified; what is served while one works on the page is as written.

import { cpSync, mkdirSync, readFileSync, readdirSync, rmSync, writeFileSync } from 'node:fs';
import { dirname, join, relative, resolve, sep } from 'node:path';
import { pathToFileURL } from 'node:url';
import { build as bundle, transform } from 'esbuild';
import { build } from './build.mjs';
import { listed, precacheList, serviceWorker } from './precache.mjs';
import { root } from './tools.mjs';

/** Code that is found by its place: bundles of these names, each with what only it needs. */
const BUNDLES = [
  { folder: 'dist', entries: ['index.js', 'worker.js'] },
  { folder: 'dist/aside', entries: ['worker.js'] },
  { folder: 'demo', entries: ['main.js', 'page.js'] },
];

/** Folders as they are built, and as they are served. */
const PLACES = { dist: join(root, 'dist'), demo: join(root, 'www', 'demo') };

/**
 * Writes the site of what is built.
 * @param {string} target a folder; what else is in it stays
 * @returns {Promise<string[]>} the files that a page may ask for, relative to it
 */
export async function writeSite(target) {
  // Parts of an earlier site have other names.
  for (const { folder } of BUNDLES) rmSync(join(target, folder), { recursive: true, force: true });
  const isMade = (name) => /\.(js|css|html)$/.test(name) && !name.startsWith('./dist/vendor/');
  for (const name of precacheList().files.filter((file) => file !== './' && !isMade(file))) {
    const to = join(target, name);
    mkdirSync(dirname(to), { recursive: true });
    cpSync(name.startsWith('./dist/') ? join(root, name) : join(root, 'www', name), to);
  }
  await writeDocument(target);
  // Fetched when somebody looks at it, and not kept before.
  cpSync(join(PLACES.demo, 'gallery'), join(target, 'demo', 'gallery'), { recursive: true });
  for (const one of BUNDLES) await writeBundle(one, target);
  const isOfSite = (/** @type {string} */ name) =>
    /^(dist|demo(?!\/gallery)|icons)\/|^(index\.html|page\.css|favicon\.svg|manifest\.webmanifest)$/.test(name);
  const list = listed([{ folder: target, at: './', wanted: isOfSite }]);
  writeFileSync(join(target, 'service-worker.js'), await small(serviceWorker(list), 'js'));
  cpSync(join(PLACES.dist, 'vendor', 'LICENSES.txt'), join(target, 'dist', 'vendor', 'LICENSES.txt'));
  return list.files;
}

/** The document, its style sheets as one in their order. @param {string} target */
async function writeDocument(target) {
  const source = readFileSync(join(root, 'www', 'index.html'), 'utf8');
  const link = /\s*<link rel="stylesheet" href="(.*?)">/g;
  const sheets = [...source.matchAll(link)].map(([, href]) => readFileSync(join(root, 'www', href), 'utf8'));
  let count = 0;
  const one = '\n    <link rel="stylesheet" href="./page.css">';
  writeFileSync(
    join(target, 'index.html'),
    source.replace(link, () => (count++ === 0 ? one : '')),
  );
  writeFileSync(join(target, 'page.css'), await small(sheets.join('\n'), 'css'));
}

/**
 * @param {{folder: string, entries: string[]}} one
 * @param {string} target
 */
async function writeBundle({ folder, entries }, target) {
  const [place, ...deeper] = folder.split('/');
  const from = join(PLACES[place], ...deeper);
  await bundle({
    entryPoints: entries.map((name) => join(from, name)),
    outdir: join(target, folder),
    bundle: true,
    splitting: true,
    minify: true,
    format: 'esm',
    chunkNames: 'part-[hash]',
    plugins: [apart(folder)],
    logLevel: 'warning',
  });
}

/**
 * What other projects made, and the package beside the page, stay files of their own.
 * @param {string} folder of the bundle in the site; all its files lie in it
 * @returns {import('esbuild').Plugin}
 */
function apart(folder) {
  const setup = (/** @type {import('esbuild').PluginBuild} */ { onResolve }) =>
    onResolve({ filter: /^\.{1,2}\// }, ({ path, resolveDir }) => {
      // The page names the package by where it is served.
      const served = relative(PLACES.demo, resolve(resolveDir, path));
      const file = served.startsWith(join('..', 'dist'))
        ? served.slice(3)
        : join('dist', relative(PLACES.dist, resolve(resolveDir, path)));
      const isApart =
        folder === 'demo' ? served.startsWith(join('..', 'dist')) : file.startsWith(join('dist', 'vendor'));
      if (!isApart) return undefined;
      const to = relative(folder, file).replaceAll(sep, '/');
      return { path: to.startsWith('.') ? to : `./${to}`, external: true };
    });
  return { name: 'apart', setup };
}

/** The same code or style sheet in fewer bytes. */
async function small(source, loader) {
  return (await transform(source, { loader, minify: true })).code;
}

if (import.meta.url === pathToFileURL(process.argv[1]).href) {
  const target = resolve(process.argv[2] ?? join(root, 'out', 'site'));
  await build();
  await writeSite(target);
  console.log(`The site is in ${target}: ${readdirSync(target, { recursive: true }).length} files and folders.`);
}
