// One browser and one server of each sample, for all tests that need no more.

/**
 * Starts both where a task wants them; the tests find them by the environment (tests/site.mjs).
 *
 * @param {import('./pool.mjs').Task[]} tasks
 * @returns {Promise<() => Promise<void>>} ends them
 */
export async function useOneBrowser(tasks) {
  if (!tasks.some(({ part }) => part === 'browser')) return async () => {};
  const { ensureBrowser, shareBrowser } = await import('../browser.mjs');
  const { shareSites } = await import('../../tests/site.mjs');
  ensureBrowser();
  const [closeSites, browser] = [await shareSites(), await shareBrowser()];
  process.env.TRACECUT_BROWSER = browser.wsEndpoint();
  return async () => {
    await browser.close();
    await closeSites();
  };
}
