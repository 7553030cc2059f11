// An empty page of the server, for tests of the package alone.

/**
 * @param {import('node:test').TestContext} t closes the page when it ends
 * @param {{url: string, browser: import('playwright-core').Browser}} site
 * @param {string} [policy] content security policy: the strictest that the package can do with, if not given
 */
export async function emptyPage(t, site, policy = "script-src 'self' 'wasm-unsafe-eval'; worker-src 'self'") {
  const context = await site.browser.newContext();
  t.after(() => context.close());
  const page = await context.newPage();
  const body = '<!doctype html><title>empty</title>';
  await page.route(`${site.url}empty`, (route) =>
    route.fulfill({ contentType: 'text/html', headers: { 'Content-Security-Policy': policy }, body }),
  );
  await page.goto(`${site.url}empty`);
  return page;
}
