// Page actions of the studio in any engine: open files, wait for results, catch what is saved.

import { createHash } from 'node:crypto';
import { setTimeout as delay } from 'node:timers/promises';

const POLL_MS = 200;
/** Four minutes: a busy machine is slow. */
const MAX_POLLS = 1200;

/**
 * Asks until the answer is truthy, and returns it; errors count as no answer. WebDriver tells no events of a page, and its
 * server does not tell when it is ready, so the tests of engines poll.
 */
export async function poll(ask) {
  for (let count = 0; count < MAX_POLLS; count += 1) {
    const answer = await ask().catch(() => null);
    if (answer) return answer;
    await delay(POLL_MS);
  }
  throw new Error(`not true after ${MAX_POLLS * POLL_MS} ms: ${ask}`);
}

/** Waits until a function of the page returns something truthy, and returns that. */
export const until = (page, condition, ...args) => poll(() => page.call(condition, ...args));

/** Waits until a run has ended and returns the state it ended in. */
export const ended = (page) =>
  until(page, () => {
    const { state } = document.body.dataset;
    return ['done', 'error'].includes(state) && state;
  });

export const inPhase = (page, phase) => until(page, (expected) => document.body.dataset.phase === expected, phase);

/** Opens the site and collects all errors of the page. */
export async function visit(page, url) {
  await page.goto(url);
  await page.call(() => {
    globalThis.faults = [];
    addEventListener('error', ({ message }) => faults.push(message));
    addEventListener('unhandledrejection', ({ reason }) => faults.push(`unhandled: ${reason}`));
    const { error } = console;
    console.error = (...parts) => (faults.push(parts.join(' ')), error.apply(console, parts));
    // Nobody answers a dialog of the browser's here: files come as downloads.
    globalThis.showSaveFilePicker = undefined;
  });
}

export const faults = (page) => page.call(() => globalThis.faults);

/** Presses a button. */
export const press = (page, selector) => page.call((query) => void document.querySelector(query).click(), selector);

/** Returns the text of an element. */
export const textOf = (page, selector) =>
  page.call((query) => document.querySelector(query).innerText.trim(), selector);

/**
 * Opens files as if they had been chosen, and waits for the end of the run.
 * @param {import('./engines.mjs').EnginePage} page
 * @param {{name: string, mimeType: string, buffer: Uint8Array}[]} files
 */
export async function open(page, files) {
  const list = files.map(({ name, mimeType, buffer }) => [name, mimeType, Buffer.from(buffer).toString('base64')]);
  await page.call((encoded) => {
    const transfer = new DataTransfer();
    for (const [name, type, text] of encoded) {
      const bytes = Uint8Array.from(atob(text), (letter) => letter.charCodeAt(0));
      transfer.items.add(new File([bytes], name, { type }));
    }
    document.body.dataset.state = 'opening';
    const input = document.querySelector('#file');
    input.files = transfer.files;
    input.dispatchEvent(new Event('change', { bubbles: true }));
  }, list);
  return ended(page);
}

/** Returns a hash of the masks on screen. */
export async function maskHash(page) {
  const text = await page.call(() => {
    const { result } = globalThis.tracecutStudio;
    let text = '';
    for (let t = 0; t < result.numFrames; t += 1) text += result.labels(t).join('');
    return text;
  });
  return createHash('sha256').update(text).digest('hex').slice(0, 16);
}

/** Saves one export by the dialog; returns its file name and bytes. */
export async function save(page, id) {
  await page.call(catchDownload);
  await page.call(() => document.querySelector('#export').open || document.querySelector('#export-open').click());
  await until(
    page,
    (query) => document.querySelector('#export').open && document.querySelector(query) !== null,
    item(id),
  );
  await page.call(() => void (document.querySelector('#export-more').open = true));
  // A card is only chosen by a press; a button saves at once, and is disabled meanwhile.
  const isCard = await page.call((query) => document.querySelector(query).type === 'radio', item(id));
  await press(page, item(id));
  if (isCard) await press(page, '#export-run');
  const { name, text } = await until(page, () => globalThis.caught);
  await press(page, '#export-close');
  return { name, bytes: Buffer.from(text, 'base64') };
}

const item = (id) => `[data-export="${id}"]:enabled`;

/** Runs in the page: keeps the next saved file as `caught`. The page may not fetch object URLs, so this keeps the blobs. */
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
