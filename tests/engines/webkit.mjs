// WebKitGTK by its own driver, which speaks the classic WebDriver protocol: JSON over HTTP. It shows its window on a
// display of its own in memory where the machine has none.

import { spawn } from 'node:child_process';
import { once } from 'node:events';
import { writeFile } from 'node:fs/promises';
import { freePort } from '../programs.mjs';
import { poll } from './page.mjs';

/** How long a function may run in a page, in milliseconds. */
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
  const done = arguments[arguments.length - 1];
  Promise.resolve().then(() => (FUNCTION)(...arguments[0]))
    .then((value) => ({ value }), (error) => ({ error: String(error) + ' at ' + error?.stack }))
    .then((outcome) => done(JSON.stringify(outcome)));`;

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
