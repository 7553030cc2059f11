// Keeps the whole site on the device, so that it opens without a network. Whoever serves the site fills in the list of
// files and its version (scripts/precache.mjs); unfilled, this worker keeps nothing and answers nothing.

const PRECACHE = { version: '', files: [] };

const NAME = `tracecut-${PRECACHE.version}`;

self.addEventListener('install', (event) => {
  event.waitUntil(keep());
});

self.addEventListener('activate', (event) => {
  event.waitUntil(dropOthers().then(() => self.clients.claim()));
});

// A new version waits until the page says that it may take over: files of two versions must not mix.
self.addEventListener('message', (event) => {
  if (event.data === 'take-over') self.skipWaiting();
});

self.addEventListener('fetch', (event) => {
  const { request } = event;
  if (request.method !== 'GET' || !request.url.startsWith(self.registration.scope) || PRECACHE.files.length === 0)
    return;
  event.respondWith(answer(request));
  if (request.mode === 'navigate') event.waitUntil(leaveIfGone());
});

async function keep() {
  const cache = await caches.open(NAME);
  await cache.addAll(PRECACHE.files.map((file) => new Request(file, { cache: 'no-cache' })));
}

async function dropOthers() {
  for (const name of await caches.keys()) {
    if (name.startsWith('tracecut-') && name !== NAME) await caches.delete(name);
  }
}

async function answer(request) {
  const cache = await caches.open(NAME);
  const { origin, pathname } = new URL(request.url);
  if (/\/(demo\/gallery|docs)\//.test(pathname)) return fetchedOrKept(request, origin + pathname, cache);
  return (await cache.match(origin + pathname)) ?? fetch(request);
}

/** Gallery and documentation are not listed: what was fetched is kept from then on, and shown without a network. */
async function fetchedOrKept(request, address, cache) {
  const response = await fetch(request).catch(() => null);
  if (response?.ok) await cache.put(address, response.clone());
  return response ?? (await cache.match(address)) ?? Response.error();
}

/** Where something else has moved in at this address, the worker steps aside. */
async function leaveIfGone() {
  const response = await fetch(self.location.href, { method: 'HEAD', cache: 'no-store' }).catch(() => null);
  if (response?.status !== 404) return;
  await caches.delete(NAME);
  await self.registration.unregister();
}
