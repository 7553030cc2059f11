// Which files the page needs to work without a network, and the service worker with their list and version filled in.

import { createHash } from 'node:crypto';
import { existsSync, readFileSync, readdirSync } from 'node:fs';
import { join, sep } from 'node:path';
import { PAGE } from './compile.mjs';
import { root } from './tools.mjs';

const PLACEHOLDER = "const PRECACHE = { version: '', files: [] };";

/** Entries of Node, and builds in one file. */
const NOT_THE_PAGES = ['node.js', 'inline.js', 'worker.bundle.js'];

/**
 * Folders of the site: where they lie, where they are served, and which of their files a page in a browser may ask for.
 */
const folders = [
  { folder: PAGE, at: './', wanted: () => true },
  {
    folder: join(root, 'studio'),
    at: './',
    wanted: (name) => !/^service-worker\.js$|\.(json|ts|md)$/.test(name),
  },
  { folder: join(root, 'www'), at: './lab/', wanted: (name) => /\.(html|css|js)$/.test(name) },
  {
    folder: join(root, 'dist'),
    at: './dist/',
    wanted: (name) => /\.(js|wasm)$/.test(name) && !/^node\//.test(name) && !NOT_THE_PAGES.includes(name),
  },
];

/**
 * Files, relative to the page, each with what its bytes hash to, and a version that changes when any of them does. The
 * page itself is `./`.
 * @typedef {{version: string, files: [name: string, integrity: string][]}} Precache
 */

/**
 * @param {Record<string, string>} [instead] texts that a server gives in the place of files, by their paths
 * @returns {Precache}
 */
export function precacheList(instead) {
  return listed(folders, instead);
}

/**
 * The same of any folders.
 * @param {typeof folders} places
 * @param {Record<string, string>} [instead]
 * @returns {Precache}
 */
export function listed(places, instead = {}) {
  const hash = createHash('sha256');
  /** @type {Precache['files']} */
  const files = [];
  for (const { folder, at, wanted } of places.filter((one) => existsSync(one.folder))) {
    const names = readdirSync(folder, { recursive: true, withFileTypes: true })
      .filter((entry) => entry.isFile())
      .map((entry) =>
        join(entry.parentPath ?? entry.path, entry.name)
          .slice(folder.length + 1)
          .replaceAll(sep, '/'),
      );
    for (const name of names.filter(wanted).sort()) {
      const bytes = instead[(at + name).slice(1)] ?? readFileSync(join(folder, name));
      hash.update(at + name).update(bytes);
      const own = createHash('sha256').update(bytes).digest('base64');
      // Hosts may lead from one of the names of a page to the other.
      files.push([at + name.replace(/^index\.html$/, ''), `sha256-${own}`]);
    }
  }
  return { version: hash.digest('hex').slice(0, 16), files };
}

/** The text of the service worker, filled in with the files that it keeps. */
export function serviceWorker(list = precacheList()) {
  const source = readFileSync(join(root, 'studio', 'service-worker.js'), 'utf8');
  if (!source.includes(PLACEHOLDER)) throw new Error('studio/service-worker.js has no place for the list of files.');
  return source.replace(PLACEHOLDER, `const PRECACHE = ${JSON.stringify(list)};`);
}
