// A static file server for development and tests: the page (`build/` and `studio/`) at `/`, the lab (`www/`) at `/lab/`, the
// built package at `/dist/`. Nothing else is reachable, and from no other machine. It also lists the
// files that the page needs without a network, and fills the list and its version into the service worker.

import { createHash } from 'node:crypto';
import { existsSync, readFileSync, readdirSync } from 'node:fs';
import { open, realpath, stat } from 'node:fs/promises';
import { createServer } from 'node:http';
import { extname, join, resolve, sep } from 'node:path';
import { pipeline } from 'node:stream/promises';
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

export const mounts = [
  { prefix: '/dist/', folder: join(root, 'dist') },
  { prefix: '/lab/', folder: join(root, 'www') },
  { prefix: '/', folder: PAGE },
  { prefix: '/', folder: join(root, 'studio') },
];

const types = {
  '.css': 'text/css; charset=utf-8',
  '.html': 'text/html; charset=utf-8',
  '.ico': 'image/x-icon',
  '.js': 'text/javascript; charset=utf-8',
  '.json': 'application/json; charset=utf-8',
  '.map': 'application/json; charset=utf-8',
  '.mjs': 'text/javascript; charset=utf-8',
  '.png': 'image/png',
  '.svg': 'image/svg+xml',
  '.ts': 'text/plain; charset=utf-8',
  '.wasm': 'application/wasm',
  '.avif': 'image/avif',
  '.webmanifest': 'application/manifest+json',
};

/**
 * Starts the server on this machine's own address; port 0 takes a free one. `places` are folders by what their
 * addresses begin with, the first that has a file is taken; `instead` are texts that are served in the place of files, by
 * their paths; `list` gives the files that the service worker keeps.
 * @returns {Promise<{url: string, close: () => Promise<void>}>}
 */
export function serve({ port = 0, places = mounts, instead = {}, list = () => precacheList(instead) } = {}) {
  const server = createServer((request, response) => {
    answer(request, response, { places, instead, list }).catch(() => end(response, 500, 'internal error'));
  });
  return new Promise((done, failed) => {
    server.once('error', failed);
    server.listen(port, '127.0.0.1', () => {
      const close = () =>
        new Promise((closed) => {
          server.close(closed);
          server.closeAllConnections();
        });
      done({ url: `http://127.0.0.1:${server.address().port}/`, close });
    });
  });
}

/** A name that leads here may be anybody's; a page at such a name is not to read what is served. */
const OWN_HOSTS = /^(127\.0\.0\.1|localhost|\[::1\])(:\d+)?$/i;

async function answer(request, response, { places, instead, list }) {
  if (!OWN_HOSTS.test(request.headers.host ?? '')) return end(response, 403, 'only for this machine');
  if (request.method !== 'GET' && request.method !== 'HEAD') return end(response, 405, 'only GET and HEAD');
  if (request.url in instead) return end(response, 200, instead[request.url], types['.js']);
  if (/^\/service-worker\.js(\?|$)/.test(request.url)) {
    return end(response, 200, serviceWorker(list()), types['.js']);
  }
  const file = await find(request.url, places);
  if (!file) return end(response, 404, 'not found');
  // Its size and its bytes are of one file, also where another takes its place meanwhile.
  const handle = await open(file);
  const { size } = await handle.stat();
  response.writeHead(200, {
    'Content-Type': types[extname(file)] ?? 'application/octet-stream',
    'Content-Length': size,
    'Cache-Control': 'no-cache',
  });
  if (request.method === 'HEAD') {
    response.end();
    return handle.close();
  }
  // A page that is closed ends what it reads.
  return pipeline(handle.createReadStream(), response).catch(() => {});
}

/** The file that a request's path names, or null: also for paths and links that leave their folder. */
async function find(url, places) {
  let path;
  try {
    path = decodeURIComponent(url.split(/[?#]/)[0]);
  } catch {
    return null;
  }
  if (path.includes('\0')) return null;
  for (const { prefix, folder } of places.filter((mount) => path.startsWith(mount.prefix))) {
    const file = resolve(folder, `.${sep}${path.slice(prefix.length)}${path.endsWith('/') ? 'index.html' : ''}`);
    if (!file.startsWith(folder + sep)) continue;
    const found = await stat(file).catch(() => null);
    if (found?.isFile() && (await realpath(file)).startsWith((await realpath(folder)) + sep)) return file;
  }
  return null;
}

function end(response, status, text, type = 'text/plain; charset=utf-8') {
  if (!response.headersSent) response.writeHead(status, { 'Content-Type': type, 'Cache-Control': 'no-cache' });
  response.end(text);
}
