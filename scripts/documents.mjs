// The documentation as pages of the site, below `docs/`, from the Markdown files as they are. Whole without a network and without a server: no page asks for anything that is not
// beside it. `node scripts/documents.mjs [folder]` writes them alone (out/site if not given).

import { cpSync, mkdirSync, readFileSync, rmSync, writeFileSync } from 'node:fs';
import { dirname, join, resolve } from 'node:path';
import { pathToFileURL } from 'node:url';
import { render } from './documents/markdown.mjs';
import { allPages } from './documents/pages.mjs';
import { pageOf } from './documents/template.mjs';
import { root } from './tools.mjs';

/**
 * Writes `docs/` anew.
 * @param {string} target the site's folder
 * @returns {Promise<string[]>} the pages, relative to `docs/`
 */
export async function writeDocuments(target) {
  const folder = join(target, 'docs');
  rmSync(folder, { recursive: true, force: true });
  const pages = allPages();
  const index = [];
  const pictures = new Set();
  for (const page of pages) {
    const made = render(page, pages);
    write(join(folder, page.path), pageOf(page, made, pages));
    index.push(...made.sections);
    for (const picture of made.pictures) pictures.add(picture);
  }
  for (const picture of pictures) copy(join(root, picture), join(folder, 'pictures', picture));
  write(join(folder, 'docs.css'), styles());
  // A script and no JSON, as a page that was opened from a folder may fetch none.
  write(join(folder, 'search-index.js'), `globalThis.tracecutDocs = ${JSON.stringify(index)};\n`);
  await writeSearch(folder);
  return pages.map(({ path }) => path);
}

function write(file, text) {
  mkdirSync(dirname(file), { recursive: true });
  writeFileSync(file, text);
}

function copy(from, to) {
  mkdirSync(dirname(to), { recursive: true });
  cpSync(from, to);
}

/** The colours of the demo page, light and dark, and what the documentation does with them. */
function styles() {
  const base = readFileSync(join(root, 'www', 'styles', 'base.css'), 'utf8').replaceAll('\r', '');
  const colours = base.slice(0, base.indexOf('\n*,'));
  return `${colours}\n${readFileSync(join(root, 'scripts', 'documents', 'docs.css'), 'utf8')}`;
}

async function writeSearch(folder) {
  const { build } = await import('esbuild');
  const { outputFiles } = await build({
    entryPoints: [join(root, 'scripts', 'documents', 'search.js')],
    outfile: join(root, 'out', 'site', 'docs', 'search.js'),
    bundle: true,
    write: false,
    minify: true,
    sourcemap: true,
    format: 'iife',
    logLevel: 'warning',
  });
  for (const { path, contents } of outputFiles)
    writeFileSync(join(folder, path.endsWith('.map') ? 'search.js.map' : 'search.js'), contents);
}

if (import.meta.url === pathToFileURL(process.argv[1] ?? '').href) {
  const target = resolve(process.argv[2] ?? join(root, 'out', 'site'));
  console.log(`${(await writeDocuments(target)).length} pages in ${join(target, 'docs')}`);
}
