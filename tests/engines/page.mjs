// What tests do on the page of the site, in any engine: files handed over, results waited for, what is saved caught.

import { createHash } from 'node:crypto';

/** How often a page is asked, and how many times at most: a busy machine may take minutes. */
const PAUSE_MS = 200;
const MOST_ASKED = 1200;

/** Waits until a function of the page gives something true, and gives that. */
export async function until(page, what, ...args) {
  for (let asked = 0; asked < MOST_ASKED; asked += 1) {
    // Between two pages there is none to ask.
    const found = await page.call(what, ...args).catch(() => null);
    if (found) return found;
    await new Promise((done) => setTimeout(done, PAUSE_MS));
  }
  throw new Error(`it never came true: ${what} (${await page.call(() => JSON.stringify(document.body.dataset))})`);
}

/** Waits until a run has ended and gives the state it ended in. */
export const ended = (page) =>
  until(page, () => {
    const { state } = document.body.dataset;
    return ['done', 'error'].includes(state) && state;
  });

export const inPhase = (page, phase) => until(page, (wanted) => document.body.dataset.phase === wanted, phase);

/** Goes to the site and collects from the first moment on what goes wrong on the page. */
export async function visit(page, url) {
  await page.goto(url);
  await page.call(() => {
    globalThis.faults = [];
    addEventListener('error', ({ message }) => faults.push(message));
    addEventListener('unhandledrejection', ({ reason }) => faults.push(`unhandled: ${reason}`));
    const { error } = console;
    console.error = (...words) => (faults.push(words.join(' ')), error.apply(console, words));
    // Nobody answers a dialog of the browser's here: files come as downloads.
    globalThis.showSaveFilePicker = undefined;
  });
}

export const faults = (page) => page.call(() => globalThis.faults);

/** Presses a button. */
export const press = (page, selector) => page.call((one) => void document.querySelector(one).click(), selector);

export const words = (page, selector) => page.call((one) => document.querySelector(one).innerText.trim(), selector);

/**
 * Hands files to the page as if they had been chosen, and waits for what becomes of them.
 * @param {import('./engines.mjs').EnginePage} page
 * @param {{name: string, mimeType: string, buffer: Uint8Array}[]} files
 */
export async function open(page, files) {
  const list = files.map(({ name, mimeType, buffer }) => [name, mimeType, Buffer.from(buffer).toString('base64')]);
  await page.call((given) => {
    const transfer = new DataTransfer();
    for (const [name, type, text] of given) {
      const bytes = Uint8Array.from(atob(text), (letter) => letter.charCodeAt(0));
      transfer.items.add(new File([bytes], name, { type }));
    }
    document.body.dataset.state = 'given';
    const input = document.querySelector('#file');
    input.files = transfer.files;
    input.dispatchEvent(new Event('change', { bubbles: true }));
  }, list);
  return ended(page);
}

/** The masks of the result on screen, as one hash. */
export async function maskHash(page) {
  const text = await page.call(() => {
    const { result } = globalThis.tracecutStudio;
    let all = '';
    for (let t = 0; t < result.numFrames; t += 1) all += result.labels(t).join('');
    return all;
  });
  return createHash('sha256').update(text).digest('hex').slice(0, 16);
}

/** Saves one thing by the page's dialog; its name and bytes. */
export async function save(page, id) {
  await page.call(catchDownload);
  await page.call(() => document.querySelector('#export').open || document.querySelector('#export-open').click());
  await until(page, (one) => document.querySelector('#export').open && document.querySelector(one) !== null, item(id));
  await page.call(() => void (document.querySelector('#export-more').open = true));
  // A card is only chosen by a press; a button saves at once, and is disabled meanwhile.
  const isCard = await page.call((one) => document.querySelector(one).type === 'radio', item(id));
  await press(page, item(id));
  if (isCard) await press(page, '#export-run');
  const { name, text } = await until(page, () => globalThis.caught);
  await press(page, '#export-close');
  return { name, bytes: Buffer.from(text, 'base64') };
}

const item = (id) => `[data-export="${id}"]:enabled`;

/** Runs in the page: the next file that is saved is kept. The page may not fetch what it saves, so its blob is. */
function catchDownload() {
  globalThis.caught = null;
  const { createObjectURL } = URL;
  const { click } = HTMLAnchorElement.prototype;
  const blobs = new Map();
  URL.createObjectURL = (blob) => {
    const url = createObjectURL.call(URL, blob);
    blobs.set(url, blob);
    return url;
  };
  HTMLAnchorElement.prototype.click = function () {
    if (!this.download) return click.call(this);
    URL.createObjectURL = createObjectURL;
    HTMLAnchorElement.prototype.click = click;
    return void blobs
      .get(this.href)
      .arrayBuffer()
      .then((bytes) => {
        const text = Array.from(new Uint8Array(bytes), (byte) => String.fromCharCode(byte)).join('');
        globalThis.caught = { name: this.download, text: btoa(text) };
      });
  };
}
