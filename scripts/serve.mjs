// A static file server for development and tests: the page (`build/` and `studio/`) at `/`, the lab (`www/`) at `/lab/`, the
// built package at `/dist/`. Nothing else is reachable, and from no other machine.

import { createReadStream } from 'node:fs';
import { realpath, stat } from 'node:fs/promises';
import { createServer } from 'node:http';
import { extname, join, resolve, sep } from 'node:path';
import { PAGE } from './compile.mjs';
import { precacheList, serviceWorker } from './precache.mjs';
import { root } from './tools.mjs';

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
  const { size } = await stat(file);
  response.writeHead(200, {
    'Content-Type': types[extname(file)] ?? 'application/octet-stream',
    'Content-Length': size,
    'Cache-Control': 'no-cache',
  });
  if (request.method === 'HEAD') return response.end();
  createReadStream(file).pipe(response);
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
