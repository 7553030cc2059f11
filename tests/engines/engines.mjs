// Chromium, Firefox and WebKit behind one small interface: a page that goes to an address and evaluates functions. Files
// are handed to a page as bytes, and what it saves comes back so; so nothing else is needed of a driver. WebKitGTK has its own
// driver, which speaks the classic WebDriver protocol: JSON over HTTP.

import { spawn } from 'node:child_process';
import { once } from 'node:events';
import { existsSync } from 'node:fs';
import { writeFile } from 'node:fs/promises';
import { join } from 'node:path';
import { findBrowser, launchBrowser } from '../../scripts/browser.mjs';
import { findProgram } from '../../scripts/tools.mjs';
import { freePort } from '../package/project.mjs';
import { poll } from './page.mjs';

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

/** Paths of WebKit's MiniBrowser on Debian and similar systems. */
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

/** Longest run of a function in a page, in milliseconds. */
const SCRIPT_MS = 300_000;

/**
 * @param {{driver: string, browser: string, display: string | null}} parts paths of programs
 */
export async function startWebKit({ driver, browser, display }) {
  const screen = display && (await startDisplay(display));
  const port = await freePort();
  const env = screen ? { ...process.env, DISPLAY: screen.name } : process.env;
  const server = spawn(driver, [`--port=${port}`], { stdio: 'ignore', env });
  const end = () => [server, screen?.process].forEach((program) => program?.kill());
  try {
    const session = await openSession(`http://127.0.0.1:${port}`, browser);
    const close = async () => {
      await session.send('DELETE', '').catch(() => {});
      end();
    };
    return { version: session.version, page: pageOf(session.send), close };
  } catch (error) {
    end();
    throw error;
  }
}

/** A display in memory; the server chooses its number. */
async function startDisplay(program) {
  const screen = ['-screen', '0', '1400x1000x24', '-nolisten', 'tcp', '-displayfd', '1'];
  const server = spawn(program, screen, { stdio: ['ignore', 'pipe', 'ignore'] });
  const [number] = await Promise.race([
    once(server.stdout, 'data'),
    once(server, 'exit').then(() => Promise.reject(new Error('Xvfb has no display to give'))),
  ]);
  return { process: server, name: `:${String(number).trim()}` };
}

async function openSession(url, binary) {
  await poll(async () => (await fetch(`${url}/status`)).ok);
  const options = { 'webkitgtk:browserOptions': { binary, args: ['--automation'] } };
  const { sessionId, capabilities } = await ask('POST', `${url}/session`, { capabilities: { alwaysMatch: options } });
  const send = (method, path, body) => ask(method, `${url}/session/${sessionId}${path}`, body);
  await send('POST', '/timeouts', { script: SCRIPT_MS, pageLoad: SCRIPT_MS });
  await send('POST', '/window/rect', { width: 1280, height: 900 });
  return { send, version: capabilities.browserVersion };
}

/** Sends a command; throws the driver's error. */
async function ask(method, url, body) {
  const headers = { 'content-type': 'application/json' };
  const response = await fetch(url, { method, headers, body: body && JSON.stringify(body) });
  const { value } = await response.json();
  if (!response.ok) throw new Error(`WebKit: ${value?.error}: ${value?.message}`);
  return value;
}

/** Calls a function and returns its value or error as text: the driver cannot read every value of a page. */
const CALL = `
  const resolve = arguments[arguments.length - 1];
  Promise.resolve().then(() => (FUNCTION)(...arguments[0]))
    .then((value) => ({ value }), (error) => ({ error: String(error) + ' at ' + error?.stack }))
    .then((outcome) => resolve(JSON.stringify(outcome)));`;

/** @returns {import('./engines.mjs').EnginePage} */
function pageOf(send) {
  return {
    goto: (url) => send('POST', '/url', { url }),
    async call(run, ...args) {
      const script = CALL.replace('FUNCTION', () => String(run));
      const { value, error } = JSON.parse(await send('POST', '/execute/async', { script, args: [args] }));
      if (error) throw new Error(error);
      return value;
    },
    screenshot: async (path) => writeFile(path, Buffer.from(await send('GET', '/screenshot'), 'base64')),
  };
}
