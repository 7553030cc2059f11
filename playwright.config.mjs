// Tests in Chromium: the page and the package, in `tests/browser`. Firefox and WebKit have drivers of their own (`tests/engines`).

import { join } from 'node:path';
import { defineConfig } from '@playwright/test';
import { BROWSER_FLAGS, ensureBrowser } from './scripts/browser.mjs';
import { root } from './scripts/tools.mjs';

const OF_THE_PAGE = /[\\/](studio|offline|policy)[^\\/]*\.spec\.mjs$/;
const isLong = Boolean(process.env.TRACECUT_LONG);

const outputOf = (project) => join(root, 'out', 'playwright', project);

export default defineConfig({
  testDir: join(root, 'tests'),
  testMatch: '**/*.spec.mjs',
  globalSetup: join(root, 'tests', 'browser', 'fixtures.mjs'),
  // Slow tests have this tag; `npm run test:long` runs them.
  ...(isLong ? { grep: /@long/ } : { grepInvert: /@long/ }),
  // Apart, so that an edit of the page does not run the package's tests. Both often run beside each other, and a page often
  // waits for its workers, so that two files of each keep two cores busy.
  projects: [
    { name: 'page', outputDir: outputOf('page'), testMatch: OF_THE_PAGE },
    { name: 'package', outputDir: outputOf('package'), testIgnore: OF_THE_PAGE },
  ],
  workers: isLong ? 1 : 2,
  forbidOnly: Boolean(process.env.CI),
  // Only against tests that never end: each waits for states, and a busy machine may take its time.
  timeout: 600_000,
  expect: { timeout: 300_000 },
  reporter: 'list',
  use: {
    launchOptions: { executablePath: ensureBrowser(), args: BROWSER_FLAGS },
    viewport: { width: 1280, height: 800 },
  },
});
