// An empty page of the server, for tests of the package without the studio.

import { before } from 'node:test';
import { fileURLToPath } from 'node:url';

const STRICT = "script-src 'self' 'wasm-unsafe-eval'; worker-src 'self'";

/**
 * @param {import('node:test').TestContext} t closes the page when it ends
 * @param {{url: string, browser: import('playwright-core').Browser}} site
 * @param {{policy?: string, modules?: string[]}} [options] a content security policy, if not the strictest that the package can do
 *   with; files of `tests/` that the page may import
 */
export async function emptyPage(t, site, { policy = STRICT, modules = [] } = {}) {
  const context = await site.browser.newContext();
  t.after(() => context.close());
  const page = await context.newPage();
  const body = '<!doctype html><title>empty</title>';
  await page.route(`${site.url}empty`, (route) =>
    route.fulfill({ contentType: 'text/html', headers: { 'Content-Security-Policy': policy }, body }),
  );
  for (const name of modules) {
    const path = fileURLToPath(new URL(`../${name}`, import.meta.url));
    await page.route(site.url + name, (route) => route.fulfill({ path, contentType: 'text/javascript' }));
  }
  await page.goto(`${site.url}empty`);
  return page;
}

/**
 * One such page for all tests of a file, prepared; read `page` in the tests.
 *
 * @param {ReturnType<import('../site.mjs').useServerAndBrowser>} site
 * @param {(page: import('playwright-core').Page) => Promise<unknown>} prepare
 * @param {object} [options] those of `emptyPage`
 * @returns {{page: import('playwright-core').Page}}
 */
export function useEmptyPage(site, prepare, options) {
  const shared = { page: null };
  before(async () => {
    await site.ready();
    // The browser closes it.
    shared.page = await emptyPage({ after() {} }, site, options);
    await prepare(shared.page);
  });
  return shared;
}
