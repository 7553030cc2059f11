// Before all tests in Chromium: writes the site of what is built, which each worker serves (see fixtures.mjs).

import { mkdtempSync, rmSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import { writeSite } from '../../scripts/site.mjs';

export default async function setUp() {
  const folder = mkdtempSync(join(tmpdir(), 'tracecut-site-'));
  await writeSite(folder, { splits: false });
  process.env.TRACECUT_TEST_SITE = folder;
  return () => rmSync(folder, { recursive: true, force: true });
}
