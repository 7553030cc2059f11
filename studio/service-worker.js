// Caches the whole site, so that it works offline. scripts/serve.mjs fills in the list of files and its version;
// without them, this worker does nothing.

const PRECACHE = { version: '', files: [] };

const { scope } = self.registration;

/** Prefix of this site's caches: other sites of the host may have their own. */
const OWN = `tracecut ${new URL(scope).pathname} `;
const NAME = OWN + PRECACHE.version;

self.addEventListener('install', (event) => {
  event.waitUntil(keep());
});

self.addEventListener('activate', (event) => {
  event.waitUntil(dropOthers().then(() => self.clients.claim()));
});

// A new version waits until the only open page asks it to take over: other pages would mix files of two versions.
self.addEventListener('message', (event) => {
  if (event.data === 'take-over') event.waitUntil(takeOver(event.source));
});

self.addEventListener('fetch', (event) => {
  const { request } = event;
  if (request.method !== 'GET' || !request.url.startsWith(scope) || PRECACHE.files.length === 0) return;
  event.respondWith(answer(request));
  if (request.mode === 'navigate') event.waitUntil(leaveIfGone());
});

async function takeOver(asking) {
  const pages = await self.clients.matchAll({ type: 'window', includeUncontrolled: true });
  if (pages.filter(({ url }) => url.startsWith(scope)).length > 1) asking.postMessage('other-pages');
  else await self.skipWaiting();
}

/** Caches all files or none. Integrity hashes reject login pages of networks and files of the next version. */
async function keep() {
  const cache = await caches.open(NAME);
  const asIs = { cache: 'no-cache', redirect: 'error' };
  await cache.addAll(PRECACHE.files.map(([file, integrity]) => new Request(file, { ...asIs, integrity })));
}

async function dropOthers() {
  for (const name of await caches.keys()) {
    if (name.startsWith(OWN) && name !== NAME) await caches.delete(name);
  }
}

async function answer(request) {
  const cache = await caches.open(NAME);
  const { origin, pathname } = new URL(request.url);
  const address = origin + pathname.replace(/\/index\.html$/, '/');
  return (await cache.match(address)) ?? fetch(request);
}

/** Unregisters this worker if the address no longer serves it. */
async function leaveIfGone() {
  const response = await fetch(self.location.href, { method: 'HEAD', cache: 'no-store' }).catch(() => null);
  if (response?.status !== 404) return;
  await caches.delete(NAME);
  await self.registration.unregister();
}
