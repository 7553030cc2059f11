// Chromium, Firefox and WebKit behind one small interface: a page that goes to an address and evaluates functions. Files
// are handed to a page as bytes, and what it saves comes back so; so nothing else is needed of a driver.

import { existsSync } from 'node:fs';
import { join } from 'node:path';
import { findBrowser, launchBrowser } from '../../scripts/browser.mjs';
import { findProgram } from '../../scripts/tools.mjs';
import { startWebKit } from './webkit.mjs';

/**
 * A page of an engine; what `call` is given and gives is plain data.
 * @typedef {object} EnginePage
 * @property {(url: string) => Promise<unknown>} goto
 * @property {(what: Function, ...args: unknown[]) => Promise<any>} call runs a function in the page
 * @property {(path: string) => Promise<unknown>} screenshot
 */

/**
 * @typedef {object} Engine
 * @property {string} name
 * @property {() => string | null} missing the packages to install, if any
 * @property {() => Promise<{version: string, page: EnginePage, close: () => Promise<unknown>}>} start
 */

/** Where Debian and similar systems have WebKit's MiniBrowser. */
const MINI_BROWSERS = ['webkit2gtk-4.1', 'webkit2gtk-4.0', 'webkitgtk-6.0'].flatMap((folder) =>
  ['/usr/lib/x86_64-linux-gnu', '/usr/lib/aarch64-linux-gnu', '/usr/libexec', '/usr/lib'].map((place) =>
    join(place, folder, 'MiniBrowser'),
  ),
);

const firefox = () => findProgram(process.env.FIREFOX, 'firefox-esr', 'firefox');

/** @type {Engine[]} */
export const ENGINES = [
  { name: 'Chromium', missing: () => (findBrowser() ? null : 'chromium'), start: startChromium },
  { name: 'Firefox', missing: () => (firefox() ? null : 'firefox-esr'), start: startFirefox },
  { name: 'WebKit', missing: missingOfWebKit, start: () => startWebKit(webKitParts()) },
];

const SIZE = { width: 1280, height: 800 };

async function startChromium() {
  const browser = await launchBrowser();
  return started(browser, await browser.newPage({ viewport: SIZE }));
}

async function startFirefox() {
  const { launch } = await import('puppeteer-core');
  const options = { browser: 'firefox', executablePath: firefox(), headless: true, defaultViewport: SIZE };
  const browser = await launch({ ...options, protocolTimeout: 300_000 });
  return started(browser, await browser.newPage());
}

async function started(browser, page) {
  const call = (run, ...args) => page.evaluate(`(${run})(...${JSON.stringify(args)})`);
  return {
    version: (await browser.version()).replace(/^\D+/, ''),
    page: { goto: (url) => page.goto(url), call, screenshot: (path) => page.screenshot({ path }) },
    close: () => browser.close(),
  };
}

function webKitParts() {
  return {
    driver: findProgram('WebKitWebDriver'),
    browser: MINI_BROWSERS.find((path) => existsSync(path)),
    display: process.env.DISPLAY ? null : findProgram('Xvfb'),
  };
}

function missingOfWebKit() {
  const { driver, browser, display } = webKitParts();
  if (!driver || !browser) return 'webkit2gtk-driver';
  return display || process.env.DISPLAY ? null : 'xvfb';
}
