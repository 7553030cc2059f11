// Tests in Chromium: the page and the package, in `tests/browser`. Firefox and WebKit have drivers of their own (`tests/engines`).

import { join } from 'node:path';
import { defineConfig } from '@playwright/test';
import { BROWSER_FLAGS, ensureBrowser } from './scripts/browser.mjs';
import { root } from './scripts/tools.mjs';

const isLong = Boolean(process.env.TRACECUT_LONG);

export default defineConfig({
  testDir: join(root, 'tests'),
  testMatch: '**/*.spec.mjs',
  globalSetup: join(root, 'tests', 'browser', 'fixtures.mjs'),
  outputDir: join(root, 'out', 'playwright'),
  // Slow tests have this tag; `npm run test:long` runs them.
  ...(isLong ? { grep: /@long/ } : { grepInvert: /@long/ }),
  // A page often waits for its workers, so that three files keep two cores busy.
  workers: isLong ? 1 : 3,
  forbidOnly: Boolean(process.env.CI),
  // Only against tests that never end: each waits for states, and a busy machine may take its time.
  timeout: 600_000,
  expect: { timeout: 300_000 },
  reporter: [['list'], ['junit', { outputFile: join(root, 'out', 'tests', 'browser.xml') }]],
  use: {
    launchOptions: { executablePath: ensureBrowser(), args: BROWSER_FLAGS },
    viewport: { width: 1280, height: 800 },
  },
});
