// Finds a Chromium to test in, or downloads one, and starts it.

import { join } from 'node:path';
import { chromium } from '@playwright/test';
import { fail, findProgram, root, run } from './tools.mjs';

// Headless first: a third less work for the machine.
const names = [
  'chromium-headless-shell',
  'chromium',
  'chromium-browser',
  'google-chrome',
  'google-chrome-stable',
  'chrome',
];
const places = [
  '/Applications/Google Chrome.app/Contents/MacOS/Google Chrome',
  '/Applications/Chromium.app/Contents/MacOS/Chromium',
  'C:\\Program Files\\Google\\Chrome\\Application\\chrome.exe',
];
/** Options of every Chromium that tests and benchmarks start. */
export const BROWSER_FLAGS = [
  '--no-sandbox',
  '--disable-gpu',
  '--disable-quic',
  '--no-first-run',
  '--disable-background-networking',
  '--disable-component-update',
  '--disable-sync',
];

/**
 * Returns the path of a Chromium: from the CHROME environment variable, on PATH, in a usual place, or downloaded earlier.
 */
export function findBrowser() {
  return findProgram(process.env.CHROME, ...names, ...places, chromium.executablePath());
}

/** Like `findBrowser`, but downloads a Chromium if there is none; ends the script if that fails. */
export function ensureBrowser() {
  const found = findBrowser();
  if (found) return found;
  console.log('No Chromium or Chrome was found; downloading one for the tests.');
  run(process.execPath, [join(root, 'node_modules', 'playwright', 'cli.js'), 'install', '--no-shell', 'chromium'], {
    hint: 'Install Chromium or Chrome, or name one in the environment variable CHROME, then run this again.',
  });
  return findBrowser() ?? fail('The downloaded Chromium cannot be found; name one in the environment variable CHROME.');
}

/** Starts a headless Chromium with a fresh profile. @param {{args?: string[]}} [options] more options of the browser */
export function launchBrowser({ args = [] } = {}) {
  return chromium.launch({ executablePath: ensureBrowser(), headless: true, args: [...BROWSER_FLAGS, ...args] });
}
